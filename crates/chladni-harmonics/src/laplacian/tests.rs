//! The properties of the operator on meshes where a plain cotangent Laplacian lacks them.

use super::cover::Cover;
use super::{MOLLIFY, Refusal, cotangent_laplacian, delaunay_cover, delaunay_laplacian, intrinsic};
use crate::{BasisSettings, CoverReport, Laplacian};

fn promises(positions: &[[f64; 3]], triangles: &[[u32; 3]], area: f64) {
    let (s, mass) = delaunay_laplacian(positions, triangles, MOLLIFY).unwrap();
    assert!(mass.iter().all(|a| *a > 0.0));
    let total: f64 = mass.iter().sum();
    assert!((total - area).abs() <= 1e-4 * area, "{total} for {area}");
    for j in 0..s.size() {
        let scale: f64 = s.column(j).map(|(_, v)| v.abs()).sum();
        assert!(s.column(j).map(|(_, v)| v).sum::<f64>().abs() <= 1e-12 * scale);
        assert!(s.column(j).all(|(i, v)| i == j || v <= 0.0));
        for (i, v) in s.column(j) {
            let mirrored = s.column(i).find(|(r, _)| *r == j).map(|(_, v)| v);
            assert_eq!(mirrored, Some(v));
        }
    }
}

#[test]
fn a_fan_of_three_triangles_on_one_edge() {
    let positions = [[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.5], [-0.5, 0.8, 0.5], [-0.5, -0.8, 0.5]];
    let leaf = 0.5 * (0.5_f64.powi(2) + 0.8_f64.powi(2)).sqrt();
    promises(&positions, &[[0, 1, 2], [0, 1, 3], [0, 1, 4]], 0.5 + 2.0 * leaf);
    // Orientation does not matter.
    promises(&positions, &[[1, 0, 2], [0, 1, 3], [1, 0, 4]], 0.5 + 2.0 * leaf);
}

#[test]
fn one_triangle_however_flat() {
    promises(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]], 0.5);
    // Obtuse: a plain cotangent Laplacian has a negative weight on the long side.
    promises(&[[0.0; 3], [4.0, 0.0, 0.0], [2.0, 0.5, 0.0]], &[[0, 1, 2]], 1.0);
}

#[test]
fn a_bad_diagonal_is_flipped_to_the_weights_of_the_good_one() {
    let positions = [[0.0; 3], [3.0, -1.0, 0.0], [6.0, 0.0, 0.0], [3.0, 1.0, 0.0]];
    let (bad, _) = delaunay_laplacian(&positions, &[[0, 1, 2], [0, 2, 3]], MOLLIFY).unwrap();
    let (good, _) = delaunay_laplacian(&positions, &[[0, 1, 3], [1, 2, 3]], MOLLIFY).unwrap();
    for j in 0..4 {
        for i in 0..4 {
            let at = |s: &crate::SymmetricSparse| s.column(j).find(|(r, _)| *r == i).map_or(0.0, |(_, v)| v);
            assert!((at(&bad) - at(&good)).abs() < 1e-14);
        }
    }
}

#[test]
fn two_fans_take_as_many_flips_as_the_square_of_their_triangles() {
    // Two parallel rows of points. Each fan has its tip at one end of the other row.
    let m = 60_u32;
    let row = |y: f64| (0..=m).map(move |i| [f64::from(i), y, 0.0]);
    let positions: Vec<[f64; 3]> = row(0.0).chain(row(12.0)).collect();
    let top = |i: u32| m + 1 + i;
    let triangles: Vec<[u32; 3]> =
        (0..m).flat_map(|i| [[top(0), i, i + 1], [m, top(i + 1), top(i)]]).collect();
    let cover = delaunay_cover(&positions, &triangles, MOLLIFY).unwrap();
    assert_eq!((cover.sheets, cover.flips as u32), (2, m * (m - 1)));
    let large = 3000;
    let sides = cover.tail.len() as u64 / u64::from(m) * large;
    assert!(super::flips::most_flips(sides) > large * (large - 1));
    assert!(super::flips::most_flips(1 << 20) < 1 << 30, "they cannot be canceled");
}

#[test]
fn a_closed_delaunay_mesh_keeps_its_plain_cotangents_in_one_sheet() {
    let positions = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    let triangles = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
    assert_eq!(Cover::of(&positions, &triangles).sheets, 1);
    let (s, _) = delaunay_laplacian(&positions, &triangles, MOLLIFY).unwrap();
    for (i, v) in s.column(0) {
        // cot 60° = 1/√3.
        let exact = if i == 0 { 3.0 } else { -1.0 } / 3.0_f64.sqrt();
        assert!((v - exact).abs() < 1e-14);
    }
    // The tufted cover of the same surface, forced by turning one triangle over, agrees.
    let turned = [[0, 2, 1], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
    assert_eq!(Cover::of(&positions, &turned).sheets, 2);
    let (t, _) = delaunay_laplacian(&positions, &turned, MOLLIFY).unwrap();
    assert!(s.values.iter().zip(&t.values).all(|(a, b)| (a - b).abs() < 1e-14));
}

#[test]
fn covers_are_glued_in_pairs_that_run_opposite_ways_before_and_after_flips() {
    let positions =
        [[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.1], [-0.5, 0.8, 0.9], [-0.5, -0.8, 0.5], [2.0, 0.0, 0.0]];
    let triangles = [[0, 1, 2], [0, 1, 3], [1, 0, 4], [2, 5, 0]];
    let check = |cover: &Cover| {
        for h in 0..cover.tail.len() as u32 {
            let t = cover.twin[h as usize];
            assert_eq!(cover.twin[t as usize], h);
            assert_eq!(cover.tail[t as usize], cover.tail[super::cover::next(h) as usize]);
            assert!((cover.length[t as usize] - cover.length[h as usize]).abs() < 1e-15);
        }
    };
    check(&Cover::of(&positions, &triangles));
    let flipped = delaunay_cover(&positions, &triangles, MOLLIFY).unwrap();
    check(&flipped);
    let areas = barycentric_areas(&flipped, 6, 0.5);
    let voronoi = intrinsic::mixed_voronoi_areas(&flipped, 6, 0.5);
    assert!((areas.iter().sum::<f64>() - voronoi.iter().sum::<f64>()).abs() < 1e-12);
}

#[test]
fn mixed_voronoi_areas_are_those_of_the_cells() {
    for (square, area, cotangent, exact) in [
        // (0, 0), (4, 0) and (1, 3), with the circumcenter (2, 1).
        ([16.0, 18.0, 10.0], 6.0, [0.5, 1.0 / 3.0, 1.0], [2.25, 1.75, 2.0]),
        // (0, 0), (4, 0) and (1, 1): obtuse at the last.
        ([16.0, 10.0, 2.0], 2.0, [-0.5, 1.0, 3.0], [0.5, 0.5, 1.0]),
    ] {
        let (found_area, found_cotangent) = intrinsic::cotangents(square.map(f64::sqrt));
        assert!((found_area - area).abs() < 1e-13);
        let parts = intrinsic::mixed_voronoi_parts(square, area, cotangent);
        for i in 0..3 {
            assert!((found_cotangent[i] - cotangent[i]).abs() < 1e-13);
            assert!((parts[i] - exact[i]).abs() < 1e-14, "{parts:?}");
        }
    }
}

/// For each vertex a third of the area of its triangles, times `share`.
fn barycentric_areas(cover: &Cover, vertices: usize, share: f64) -> Vec<f64> {
    let mut mass = vec![0.0; vertices];
    for (f, length) in cover.length.as_chunks::<3>().0.iter().enumerate() {
        let area = intrinsic::cotangents(*length).0;
        for i in 0..3 {
            mass[cover.tail[3 * f + i] as usize] += area / 3.0 * share;
        }
    }
    mass
}

/// The rows for one method in reference_eigenvalues.csv: file and λ_0 … λ_10.
fn reference(method: &str) -> Vec<(String, Vec<f64>)> {
    let Some(path) = chladni_testdata::shared("meshes/reference_eigenvalues.csv") else { return Vec::new() };
    let text = std::fs::read_to_string(path).unwrap();
    text.lines()
        .filter(|line| line.contains(method))
        .map(|line| {
            let file = line.split(',').next().unwrap().to_owned();
            let mut values: Vec<f64> = line.rsplit(',').take(11).map(|v| v.parse().unwrap()).collect();
            values.reverse();
            (file, values)
        })
        .collect()
}

fn first_eigenvalues(file: &str, laplacian: Laplacian, barycentric: bool) -> Option<Vec<f64>> {
    let path = chladni_testdata::shared(&format!("meshes/{file}"))?;
    let mesh = chladni_mesh::load_mesh(&path).unwrap().mesh;
    let mut operator = crate::Operator::with(&mesh, laplacian).unwrap();
    if barycentric {
        let cover = match laplacian {
            Laplacian::Delaunay => delaunay_cover(&operator.positions, &operator.triangles, MOLLIFY).unwrap(),
            Laplacian::Cotangent => Cover::of(&operator.positions, &operator.triangles),
        };
        operator.mass = barycentric_areas(&cover, operator.vertices(), 1.0 / cover.sheets as f64);
    }
    let solved = crate::eigen::solve(&operator, &BasisSettings::new(11), &chladni_task::Task::new()).unwrap();
    Some(solved.basis.eigenvalues.iter().map(|l| l * operator.frame.scale.powi(2)).collect())
}

/// robust_laplacian builds the same operator with a third of each triangle's area per corner. With that
/// mass, all digits in the table must agree.
#[test]
fn eigenvalues_agree_with_robust_laplacian() {
    for (file, exact) in reference("robust_laplacian") {
        // The largest meshes are left to the benchmark.
        if file.contains("igea") || file.contains("koala") {
            continue;
        }
        let Some(values) = first_eigenvalues(&file, Laplacian::Delaunay, true) else { return };
        for (value, exact) in values.iter().zip(&exact).skip(1) {
            assert!((value - exact).abs() < 1e-6 * exact, "{file}: {value} for {exact}");
        }
    }
}

/// The plain cotangent operator with barycentric mass is another discretization of the same
/// surface: on sound meshes the first eigenvalues agree to a few percent.
#[test]
fn eigenvalues_are_near_those_of_the_plain_cotangent_operator() {
    for (file, exact) in reference("cotan, lumped") {
        if file.contains("igea") || file.contains("koala") || file.contains("octopus") {
            continue;
        }
        let Some(values) = first_eigenvalues(&file, Laplacian::Delaunay, false) else { return };
        for (value, exact) in values.iter().zip(&exact).skip(1) {
            assert!((value - exact).abs() < 0.03 * exact, "{file}: {value} for {exact}");
        }
    }
}

/// Negative weights are clamped to 0, which must remove no more than rounding errors. If an edge were left
/// that is not Delaunay, the operator would be a different one, and heat could oscillate.
#[test]
fn every_edge_of_the_cover_is_delaunay_to_rounding() {
    let mut meshes: Vec<(String, chladni_mesh::TriMesh)> = ["head", "octopus", "template"]
        .iter()
        .filter_map(|name| Some(((*name).to_owned(), chladni_mesh::samples::sample(name)?)))
        .collect();
    for file in [
        "heads/face.obj",
        "heads/decimated-max.obj",
        "nasty/truck.obj",
        "nasty/bunny.ply",
        "formats/beetle.off",
    ] {
        let Some(path) = chladni_testdata::shared(&format!("meshes/{file}")) else { continue };
        meshes.push((file.to_owned(), chladni_mesh::load_mesh(&path).unwrap().mesh));
    }
    for (name, mesh) in &meshes {
        let Ok(operator) = crate::Operator::of(mesh) else { continue };
        let cover = delaunay_cover(&operator.positions, &operator.triangles, MOLLIFY).unwrap();
        let cotangent: Vec<f64> =
            cover.length.as_chunks::<3>().0.iter().flat_map(|l| intrinsic::cotangents(*l).1).collect();
        let least = (0..cotangent.len()).map(|h| cotangent[h] + cotangent[cover.twin[h] as usize]);
        let least = least.fold(f64::MAX, f64::min);
        assert!(least > -1e-9, "{name}: {least}");
        let s = &operator.stiffness;
        assert!((0..s.size()).all(|j| s.column(j).all(|(i, v)| i == j || v <= 0.0)), "{name}");
    }
}

/// The table's "cotan, lumped" rows are the plain cotangents with a third of each triangle's area per
/// corner: given that mass, the plain operator is the same matrix.
#[test]
fn plain_cotangents_are_those_of_the_table() {
    let mut compared = 0;
    for (file, exact) in reference("cotan, lumped") {
        let small = ["octopus", "goathead", "spot", "fertility", "torus", "square", "suzanne", "hemisphere"];
        if !small.iter().any(|name| file.contains(name)) {
            continue;
        }
        let Some(values) = first_eigenvalues(&file, Laplacian::Cotangent, true) else { return };
        for (value, exact) in values.iter().zip(&exact).skip(1) {
            assert!((value - exact).abs() < 1e-7 * exact, "{file}: {value} for {exact}");
        }
        compared += 1;
    }
    if chladni_testdata::shared("meshes/reference_eigenvalues.csv").is_some() {
        assert!(compared > 3);
    }
}

#[test]
fn mollification_is_by_the_mean_of_the_edges_each_counted_once() {
    // A triangle without height on the long side of another: the edge between them has two triangles.
    let positions = [[0.0; 3], [2.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]];
    let mut cover = Cover::of(&positions, &[[0, 1, 3], [1, 0, 2]]);
    cover.mollify(0.1);
    let mean = (2.0 + 1.0 + 1.0 + 2.0 * 2.0_f64.sqrt()) / 5.0;
    let shortest = cover.length.iter().copied().fold(f64::INFINITY, f64::min);
    assert!((shortest - (1.0 + 0.1 * mean)).abs() < 1e-14, "{shortest}");
    let report = cover.report();
    assert!((report.mollified_by - 0.1).abs() < 1e-14, "{report:?}");
    assert_eq!(report.to_string(), "tufted cover, mollified by 1.0e-1 mean edge lengths, 0 edge flips");
}

#[test]
fn what_was_done_to_a_surface_is_reported() {
    let report = |positions: &[[f64; 3]], triangles: &[[u32; 3]]| {
        delaunay_cover(positions, triangles, MOLLIFY).unwrap().report()
    };
    let tetrahedron = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    let sound = report(&tetrahedron, &[[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]);
    assert_eq!(sound, CoverReport { sheets: 1, mollified_by: 0.0, flips: 0 });
    assert_eq!(sound.to_string(), "the mesh as it is, 0 edge flips");
    // The long diagonal of a rhombus is flipped on both sheets.
    let rhombus = [[0.0; 3], [3.0, -1.0, 0.0], [6.0, 0.0, 0.0], [3.0, 1.0, 0.0]];
    let open = report(&rhombus, &[[0, 1, 2], [0, 2, 3]]);
    assert_eq!(open, CoverReport { sheets: 2, mollified_by: 0.0, flips: 2 });
    // A triangle whose corners lie in one line.
    let line = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let flat = report(&line, &[[0, 1, 3], [0, 1, 2]]);
    assert!(flat.mollified_by > 0.9 * MOLLIFY && flat.mollified_by < 1.1 * MOLLIFY, "{flat:?}");
}

#[test]
fn plain_cotangents_keep_the_negative_weight_of_an_obtuse_pair() {
    let positions = [[0.0; 3], [3.0, -1.0, 0.0], [6.0, 0.0, 0.0], [3.0, 1.0, 0.0]];
    let (s, mass) = cotangent_laplacian(&positions, &[[0, 1, 2], [0, 2, 3]]).unwrap();
    let at = |i: usize, j: usize| s.column(j).find(|(r, _)| *r == i).map_or(0.0, |(_, v)| v);
    // The angle at vertex 1 has cosine (-3, 1)·(3, 1) / 10 = -0.8: its cotangent is -4/3, twice.
    assert!((at(0, 2) - 4.0 / 3.0).abs() < 1e-14, "{}", at(0, 2));
    // The boundary edge of 0 and 1 has one angle opposite, at 2, of cotangent 3.
    assert!((at(0, 1) + 1.5).abs() < 1e-14, "{}", at(0, 1));
    (0..4).for_each(|j| assert!(s.column(j).map(|(_, v)| v).sum::<f64>().abs() < 1e-14));
    // Both triangles are obtuse at 1 and 3: half of their area there, a quarter elsewhere.
    mass.iter().zip([1.5, 1.5, 1.5, 1.5]).for_each(|(a, exact)| assert!((a - exact).abs() < 1e-14));
}

#[test]
fn what_has_no_plain_cotangents_is_refused_with_its_place() {
    let fan = [[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.5], [-0.5, 0.8, 0.5], [-0.5, -0.8, 0.5]];
    let crowded = cotangent_laplacian(&fan, &[[0, 1, 2], [0, 1, 3], [0, 1, 4]]).unwrap_err();
    assert_eq!(crowded, Refusal::CrowdedEdge { ends: [0, 1], triangles: 3 });
    let line = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let flat = cotangent_laplacian(&line, &[[0, 1, 3], [0, 1, 2]]).unwrap_err();
    assert_eq!(flat, Refusal::FlatTriangle { corners: [0, 1, 2] });
    // Errors name the vertices of the file: vertex 0 of the operator is vertex 1 here.
    let mesh = chladni_mesh::TriMesh {
        positions: std::iter::once([9.0; 3]).chain(fan).collect(),
        triangles: vec![[1, 2, 3], [1, 2, 4], [1, 2, 5]],
        ..Default::default()
    };
    let error = crate::Operator::with(&mesh, Laplacian::Cotangent).unwrap_err();
    assert_eq!(error, crate::HarmonicsError::CrowdedEdge { ends: [1, 2], triangles: 3 });
    assert!(crate::Operator::of(&mesh).is_ok());
}
