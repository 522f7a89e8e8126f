//! Surfaces with held borders, and points without triangles.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::f64::consts::PI;

use chladni_harmonics::{
    BasisSettings, BasisWarning, Body, HarmonicsError, Pencil, mesh_laplacian, point_cloud_laplacian,
};
use chladni_mesh::{TriMesh, samples};
use chladni_task::Task;

/// The rectangle [0, 2] × [0, 1], shifted, in (2n + 1) × (n + 1) vertices.
fn rectangle(n: u32) -> TriMesh {
    let (columns, rows) = (2 * n + 1, n + 1);
    let at = |x: u32, y: u32| y * columns + x;
    let step = 1.0 / f64::from(n);
    let positions = (0..columns * rows)
        .map(|v| [5.0 + step * f64::from(v % columns), step * f64::from(v / columns), 3.0])
        .collect();
    let squares = (0..n).flat_map(|y| (0..2 * n).map(move |x| (x, y)));
    let triangles = squares
        .flat_map(|(x, y)| {
            [[at(x, y), at(x + 1, y), at(x + 1, y + 1)], [at(x, y), at(x + 1, y + 1), at(x, y + 1)]]
        })
        .collect();
    TriMesh { positions, triangles, ..TriMesh::default() }
}

#[test]
fn a_held_rectangle_has_the_tones_of_a_membrane() {
    let mesh = rectangle(40);
    let (body, report) = Body::with_held_border(&mesh, &BasisSettings::new(12), &Task::new()).unwrap();
    assert!(report.warnings(&body.basis.certificate).is_empty());
    let mut tones: Vec<f64> = (1..9)
        .flat_map(|i| (1..9).map(move |j| PI * PI * (f64::from(i * i) / 4.0 + f64::from(j * j))))
        .collect();
    tones.sort_by(f64::total_cmp);
    for (k, (lambda, tone)) in body.basis.eigenvalues.iter().zip(&tones).enumerate() {
        let found = body.eigenvalue_in_file(*lambda);
        assert!((found / tone - 1.0).abs() < 0.01, "{k}: {found} of {tone}");
    }
    let on_border = |p: &[f64; 3]| p[0] == 5.0 || p[0] == 7.0 || p[1] == 0.0 || p[1] == 1.0;
    let (basis, n) = (&body.basis, mesh.positions.len());
    for k in 0..12 {
        let h = basis.harmonic(k);
        for (p, v) in mesh.positions.iter().zip(&body.operator_vertex) {
            assert!(!on_border(p) || h[v.unwrap() as usize] == 0.0, "harmonic {k} at {p:?}");
        }
        for l in 0..=k {
            let product: f64 = (0..n).map(|v| basis.mass[v] * h[v] * basis.harmonic(l)[v]).sum();
            assert!((product - f64::from(u8::from(k == l))).abs() < 1e-9);
        }
    }
}

/// The second and third eigenvalue of a held square are equal.
#[test]
fn a_group_that_k_cuts_has_the_harmonics_of_the_whole_group() {
    let mesh = samples::grid_square(24);
    let of = |harmonics| {
        let settings = BasisSettings::new(harmonics);
        Body::with_held_border(&mesh, &settings, &Task::new()).unwrap()
    };
    let ((cut, cut_report), (whole, report)) = (of(2), of(3));
    assert_eq!((cut.basis.harmonics(), whole.basis.harmonics()), (2, 3));
    assert!(cut_report.cuts_cluster && !report.cuts_cluster);
    for k in 0..2 {
        assert!((cut.basis.eigenvalues[k] / whole.basis.eigenvalues[k] - 1.0).abs() < 1e-9);
        for (a, b) in cut.basis.harmonic(k).iter().zip(whole.basis.harmonic(k)) {
            assert!((a - b).abs() < 1e-6, "harmonic {k}: {a} and {b}");
        }
    }
}

#[test]
fn a_closed_surface_has_no_border_to_hold_and_one_triangle_nothing_else() {
    let (sphere, settings) = (samples::icosphere(3), BasisSettings::new(9));
    let held = Body::with_held_border(&sphere, &settings, &Task::new()).unwrap().0;
    let free = Body::build(&sphere, &settings, &Task::new()).unwrap();
    for (a, b) in held.basis.eigenvalues.iter().zip(&free.basis.eigenvalues) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }
    let triangle = TriMesh {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        ..TriMesh::default()
    };
    // More harmonics than vertices off the border.
    let grid = samples::grid_square(5);
    let (body, report) = Body::with_held_border(&grid, &BasisSettings::new(100), &Task::new()).unwrap();
    let free = body.basis.harmonics();
    assert_eq!((report.vertices, report.vertices - report.held), (grid.positions.len(), free));
    let warning = BasisWarning::HeldBorder { asked: 100, vertices: report.vertices, free };
    assert!(report.warnings(&body.basis.certificate).contains(&warning), "{report:?}");
    let refused = Body::with_held_border(&triangle, &settings, &Task::new()).unwrap_err();
    assert!(refused.to_string().contains("border"), "{refused}");
}

/// The harmonics of all vertices stand beside those of the free ones for a moment.
#[test]
fn a_held_surface_keeps_its_harmonics_where_there_is_room() {
    let (mesh, task, folder) = (rectangle(31), Task::new(), tempfile::tempdir().unwrap());
    let n = mesh.positions.len() as u64;
    let usual = BasisSettings { threads: Some(1), ..BasisSettings::new(600) };
    let in_memory = Body::with_held_border(&mesh, &usual, &task).unwrap().0;
    // One copy fits beside the solver's own memory, two do not.
    let short = BasisSettings { memory_bytes: Some(10_000 * n), ..usual };
    let refused = Body::with_held_border(&mesh, &short, &task).unwrap_err();
    assert!(matches!(refused, HarmonicsError::TooMany { .. }), "{refused}");
    let scratch = BasisSettings { scratch: Some(folder.path().to_owned()), ..short };
    let (on_disk, report) = Body::with_held_border(&mesh, &scratch, &task).unwrap();
    assert!(!on_disk.basis.vectors.is_in_memory() && report.short_of_memory.is_some());
    assert!(on_disk.basis.vectors == in_memory.basis.vectors);
}

/// The corners of one triangle lie in one place, where a corner of another is.
#[test]
fn a_triangle_without_extent_leaves_numbers_where_nothing_is_mollified() {
    let mut mesh = rectangle(4);
    let n = mesh.positions.len() as u32;
    mesh.positions.extend([mesh.positions[0]; 2]);
    mesh.triangles.push([0, n, n + 1]);
    let (stiffness, mass) = mesh_laplacian(&mesh, 0.0).unwrap();
    assert!(mass.iter().all(|a| *a > 0.0) && stiffness.values.iter().all(|x| x.is_finite()));
    assert!((mass.iter().sum::<f64>() - 2.0).abs() < 1e-3);
    Pencil::new(&stiffness, &mass).unwrap().solve(&BasisSettings::new(5), &Task::new()).unwrap();
}

/// λ = l (l + 1), 2 l + 1 times, on the unit sphere.
#[test]
fn points_on_a_sphere_have_its_spectrum_in_any_units() {
    for (scale, shift) in [(1.0, 0.0), (250.0, 1000.0)] {
        let points: Vec<[f64; 3]> =
            samples::icosphere(4).positions.iter().map(|p| p.map(|x| scale * x + shift)).collect();
        let (stiffness, mass) = point_cloud_laplacian(&points, 30, 1e-5).unwrap();
        let area = mass.iter().sum::<f64>() / (scale * scale);
        assert!((area / (4.0 * PI) - 1.0).abs() < 0.02, "{area}");
        let pencil = Pencil::new(&stiffness, &mass).unwrap();
        let (basis, _) = pencil.solve(&BasisSettings::new(16), &Task::new()).unwrap();
        let expected = (0..4).flat_map(|l| std::iter::repeat_n(f64::from(l * (l + 1)), 2 * l as usize + 1));
        for (lambda, expected) in basis.eigenvalues.iter().zip(expected) {
            let found = lambda * scale * scale;
            assert!((found - expected).abs() <= 0.02 * expected + 1e-6, "{found} of {expected}");
        }
    }
}

/// Points of a flat grid are their own Delaunay triangulation: the Laplacian of the mesh, also where rounding has moved the
/// points of one circle off it.
#[test]
fn points_of_a_flat_grid_have_the_laplacian_of_its_mesh_however_it_is_turned() {
    let turn = |[x, y]: [f64; 2], angle_rad: f64| {
        let (sin, cos) = angle_rad.sin_cos();
        [cos * x - sin * y, sin * x + cos * y]
    };
    for step in 0..7 {
        let mut mesh = rectangle(8);
        let (of_mesh, _) = mesh_laplacian(&mesh, 1e-5).unwrap();
        for p in mesh.positions.iter_mut().filter(|_| step > 0) {
            let [x, y] = turn([p[0], p[1]], 0.9 * f64::from(step) - 0.2);
            let [y, z] = turn([y, p[2]], 0.4 * f64::from(step) + 0.2);
            *p = [x, y, z];
        }
        let (of_points, areas) = point_cloud_laplacian(&mesh.positions, 30, 1e-5).unwrap();
        assert!((areas.iter().sum::<f64>() - 2.0).abs() < 1e-9, "turn {step}");
        for j in 0..mesh.positions.len() {
            let row = |s: &chladni_harmonics::SymmetricSparse| -> Vec<(usize, f64)> {
                s.column(j).filter(|(_, value)| value.abs() > 1e-9).collect()
            };
            let (a, b) = (row(&of_points), row(&of_mesh));
            assert_eq!(a.len(), b.len(), "turn {step}, row {j}");
            for ((i, x), (k, y)) in a.into_iter().zip(b) {
                assert!(i == k && (x - y).abs() < 1e-9, "turn {step}, ({i}, {j}): {x} and {y}");
            }
        }
    }
}

#[test]
fn a_point_in_the_place_of_another_is_in_nobody_s_way() {
    let mut points = samples::icosphere(3).positions;
    let solve = |points: &[[f64; 3]]| {
        let (stiffness, mass) = point_cloud_laplacian(points, 30, 1e-5).unwrap();
        let pencil = Pencil::new(&stiffness, &mass).unwrap();
        pencil.solve(&BasisSettings::new(9), &Task::new()).unwrap().0.eigenvalues
    };
    let alone = solve(&points);
    points.push(points[7]);
    for (a, b) in alone.iter().zip(solve(&points)) {
        assert!((a - b).abs() <= 1e-2 * b, "{a} {b}");
    }
}

#[test]
fn points_without_a_surface_are_refused() {
    let line: Vec<[f64; 3]> = (0..50).map(|i| [f64::from(i), 0.0, 0.0]).collect();
    for (points, neighbors, word) in [
        (&line[..], 30, "line"),
        (&[][..], 30, "line"),
        (&line, 1, "neighbors"),
        (&[[f64::NAN; 3], [0.0; 3], [1.0; 3]], 30, "finite"),
    ] {
        let refused = point_cloud_laplacian(points, neighbors, 1e-5).unwrap_err().to_string();
        assert!(refused.contains(word), "{refused}");
    }
}

#[test]
fn a_part_without_area_is_named_where_borders_are_held_too() {
    let mut mesh = rectangle(10);
    let n = mesh.positions.len() as u32;
    mesh.positions.extend([[30.0; 3], [40.0; 3], [60.0; 3]]);
    mesh.triangles.push([n, n + 1, n + 2]);
    let (body, report) = Body::with_held_border(&mesh, &BasisSettings::new(5), &Task::new()).unwrap();
    let warnings = report.warnings(&body.basis.certificate);
    assert!(warnings.contains(&BasisWarning::WithoutArea { parts: 1 }), "{warnings:?}");
}
