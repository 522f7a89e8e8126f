//! Mass matrices that are not diagonal, compared with closed forms, a dense solver and the definition.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::f64::consts::PI;

use chladni_harmonics::{
    BasisSettings, Body, ConsistentPencil, Eigenpairs, HarmonicsError, Laplacian, Operator, Pencil,
    SymmetricSparse, mesh_laplacian,
};
use chladni_mesh::samples;
use chladni_task::Task;
use faer::{Mat, Side};

fn solved(stiffness: &SymmetricSparse, mass: &SymmetricSparse, harmonics: usize) -> Eigenpairs {
    let pencil = ConsistentPencil::new(stiffness, mass).unwrap();
    let (pairs, report) = pencil.solve(&BasisSettings::new(harmonics), &Task::new()).unwrap();
    assert!(report.warnings(&pairs.certificate).is_empty(), "{:?}", pairs.certificate);
    check(stiffness, mass, &pairs);
    pairs
}

/// Compares the pairs with their definition, independently of their certificate.
fn check(stiffness: &SymmetricSparse, mass: &SymmetricSparse, pairs: &Eigenpairs) {
    let n = stiffness.size();
    let harmonics: Vec<&[f64]> = pairs.vectors.chunks_exact(n).collect();
    let top = pairs.eigenvalues.last().unwrap().max(1e-300);
    let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
    for (k, (h, lambda)) in harmonics.iter().zip(&pairs.eigenvalues).enumerate() {
        let (image, weighted) = (stiffness.times(h), mass.times(h));
        let rest: Vec<f64> = image.iter().zip(&weighted).map(|(s, m)| s - lambda * m).collect();
        assert!(norm(&rest) < 1e-8 * top * norm(&weighted), "pair {k}");
        for (other, h) in harmonics.iter().enumerate() {
            let product: f64 = h.iter().zip(&weighted).map(|(h, m)| h * m).sum();
            assert!((product - f64::from(u8::from(other == k))).abs() < 1e-8, "pairs {k} and {other}");
        }
    }
}

/// The consistent mass of linear elements on a mesh: each pair of corners of a triangle gets a twelfth of
/// its area.
fn linear_elements(operator: &Operator) -> SymmetricSparse {
    let area = |t: &[u32; 3]| chladni_mesh::surface::total_area(&operator.positions, std::slice::from_ref(t));
    let entries = operator.triangles.iter().flat_map(|t| {
        let a = area(t);
        let [i, j, k] = t.map(|v| v as usize);
        [
            (i, i, a / 6.0),
            (j, j, a / 6.0),
            (k, k, a / 6.0),
            (i, j, a / 12.0),
            (j, k, a / 12.0),
            (k, i, a / 12.0),
        ]
    });
    SymmetricSparse::from_entries(operator.vertices(), entries).unwrap()
}

/// All eigenvalues of M⁻¹ S by a dense generalized solver.
fn dense(stiffness: &SymmetricSparse, mass: &SymmetricSparse) -> Vec<f64> {
    let full = |matrix: &SymmetricSparse| {
        let mut full = Mat::<f64>::zeros(matrix.size(), matrix.size());
        for j in 0..matrix.size() {
            matrix.column(j).for_each(|(i, value)| full[(i, j)] = value);
        }
        full
    };
    let (s, m) = (full(stiffness), full(mass));
    // M^-½ by the eigenvectors of M, which is not the method of the solver.
    let decomposed = m.self_adjoint_eigen(Side::Lower).unwrap();
    let u = decomposed.U();
    let root = Mat::from_fn(s.nrows(), s.nrows(), |i, j| u[(i, j)] / decomposed.S()[j].sqrt());
    let symmetric = root.transpose() * s * &root;
    symmetric.self_adjoint_eigenvalues(Side::Lower).unwrap()
}

#[test]
fn strings_of_linear_elements_have_their_closed_form() {
    // Three free strings that are not joined: every eigenvalue occurs three times.
    let (strings, elements) = (3, 400);
    let h = 1.0 / elements as f64;
    let assemble = |own: f64, other: f64| {
        let entries = (0..strings).flat_map(|s| {
            (0..elements).flat_map(move |e| {
                let v = s * (elements + 1) + e;
                [(v, v, own), (v + 1, v + 1, own), (v, v + 1, other)]
            })
        });
        SymmetricSparse::from_entries(strings * (elements + 1), entries).unwrap()
    };
    let pairs = solved(&assemble(1.0 / h, -1.0 / h), &assemble(h / 3.0, h / 6.0), 60);
    for (i, lambda) in pairs.eigenvalues.iter().enumerate() {
        let c = (PI * (i / strings) as f64 * h).cos();
        let exact = 6.0 / (h * h) * (1.0 - c) / (2.0 + c);
        assert!((lambda - exact).abs() <= 1e-9 * exact.max(PI * PI), "{i}: {lambda} {exact}");
    }
    assert!(pairs.eigenvalues[..3].iter().all(|lambda| *lambda == 0.0));
}

#[test]
fn surfaces_agree_with_a_dense_solver() {
    // One mesh is solved by slices, one by slices with double eigenvalues, and one as a dense matrix.
    for (mesh, harmonics) in [("grid", 120), ("sphere", 90), ("small", 40)] {
        let shape = match mesh {
            "grid" => samples::grid_square(24),
            "sphere" => samples::icosphere(3),
            _ => samples::icosphere(1),
        };
        let operator = Operator::with(&shape, Laplacian::Cotangent).unwrap();
        let mass = linear_elements(&operator);
        let pairs = solved(&operator.stiffness, &mass, harmonics);
        let exact = dense(&operator.stiffness, &mass);
        for (k, (lambda, exact)) in pairs.eigenvalues.iter().zip(&exact).enumerate() {
            assert!((lambda - exact).abs() < 1e-9 * exact.abs().max(1.0), "{mesh} {k}: {lambda} {exact}");
        }
    }
}

#[test]
fn a_diagonal_mass_gives_what_a_pencil_gives() {
    let operator = Operator::of(&samples::torus(0.4, 40, 20)).unwrap();
    let entries = operator.mass.iter().enumerate().map(|(i, a)| (i, i, *a));
    let mass = SymmetricSparse::from_entries(operator.vertices(), entries).unwrap();
    let pairs = solved(&operator.stiffness, &mass, 50);
    let pencil = Pencil::new(&operator.stiffness, &operator.mass).unwrap();
    let (basis, _) = pencil.solve(&BasisSettings::new(50), &Task::new()).unwrap();
    for (a, b) in pairs.eigenvalues.iter().zip(&basis.eigenvalues) {
        assert!((a - b).abs() < 1e-9 * b.max(1.0));
    }
}

#[test]
fn a_mass_with_places_of_its_own_is_solved() {
    // S joins neighbors on a line; M joins vertices two apart.
    let n = 500;
    let springs = (0..n).flat_map(|i| [(i, i, 2.0), (i, (i + 1) % n, -1.0)]);
    let stiffness = SymmetricSparse::from_entries(n, springs).unwrap();
    let beads = (0..n).flat_map(|i| [(i, i, 1.0), (i, (i + 2) % n, 0.25)]);
    let mass = SymmetricSparse::from_entries(n, beads).unwrap();
    let pairs = solved(&stiffness, &mass, 31);
    let turn = |k: usize| 2.0 * PI * k as f64 / n as f64;
    let mut exact: Vec<f64> =
        (0..n).map(|k| (2.0 - 2.0 * turn(k).cos()) / (1.0 + 0.5 * (2.0 * turn(k)).cos())).collect();
    exact.sort_by(f64::total_cmp);
    for (lambda, exact) in pairs.eigenvalues.iter().zip(&exact) {
        assert!((lambda - exact).abs() < 1e-10, "{lambda} {exact}");
    }
}

#[test]
fn what_is_no_metric_is_refused() {
    let path = |own: f64, other: f64| {
        let entries = (0..400).flat_map(move |i| [(i, i, own), (i, (i + 1) % 400, other)]);
        SymmetricSparse::from_entries(400, entries).unwrap()
    };
    let stiffness = path(2.0, -1.0);
    let reason = |mass: &SymmetricSparse| {
        let solved = ConsistentPencil::new(&stiffness, mass)
            .and_then(|pencil| pencil.solve(&BasisSettings::new(5), &Task::new()));
        match solved {
            Err(HarmonicsError::BadPencil { reason }) => reason,
            other => panic!("{other:?}"),
        }
    };
    assert!(reason(&path(1.0, 0.6)).contains("M is not positive definite"));
    // 1 + cos(2πk / 400) is 0 at k = 200.
    let singular = reason(&path(1.0, 0.5));
    assert!(singular.contains("not positive definite") || singular.contains("nearly singular"), "{singular}");
    assert!(reason(&path(-1.0, 0.0)).contains("not positive"));
    let small = SymmetricSparse::from_entries(3, [(0, 0, 1.0), (1, 1, 1.0), (2, 2, 1.0)]).unwrap();
    assert!(reason(&small).contains("400 rows"));
    let mut slanted = path(1.0, 0.1);
    slanted.values[1] = 0.2;
    assert!(reason(&slanted).contains("M is not symmetric"));
}

#[test]
fn matrices_come_in_compressed_columns_of_any_order() {
    // [[2, -1, 0], [-1, 2, 0], [0, 0, 0]]: rows in any order, one place given twice, mirrored up to
    // rounding.
    let columns = (&[0, 3, 5, 5][..], &[1, 0, 0, 1, 0][..]);
    let values = [-1.0, 1.5, 0.5, 2.0, -1.0 - 1e-15];
    let matrix = SymmetricSparse::from_columns("S", columns.0, columns.1, &values).unwrap();
    assert_eq!(matrix.diagonal(), [2.0, 2.0, 0.0]);
    assert_eq!(matrix.column(0).collect::<Vec<_>>()[1], (1, matrix.column(1).next().unwrap().1));
    let refused = |starts: &[usize], rows: &[usize], values: &[f64]| {
        SymmetricSparse::from_columns("S", starts, rows, values).unwrap_err().to_string()
    };
    assert!(
        refused(&[0, 1, 1], &[1], &[1.0]).contains("S is not symmetric: 1 at (1, 0), 0 at (0, 1)"),
        "one triangle only"
    );
    assert!(refused(&[0, 2], &[0], &[1.0]).contains("starts"));
    assert!(refused(&[0, 1], &[1], &[1.0]).contains("row 1"));
    assert!(refused(&[0, 1], &[0], &[f64::NAN]).contains("NaN"));
    assert!(refused(&[], &[], &[1.0]).contains("starts"));
}

#[test]
fn the_laplacian_of_a_mesh_as_it_is_has_its_rows_and_units() {
    let mut mesh = samples::icosphere(2);
    mesh.positions.iter_mut().flatten().for_each(|x| *x = 3.0 * *x + 7.0);
    let (stiffness, mass) = mesh_laplacian(&mesh, 1e-5).unwrap();
    let total = chladni_mesh::surface::total_area(&mesh.positions, &mesh.triangles);
    assert!((mass.iter().sum::<f64>() / total - 1.0).abs() < 1e-12);
    // With other indices and an additional unused vertex: the same values.
    let n = mesh.positions.len() as u32;
    let mut moved = mesh.clone();
    moved.positions.insert(0, [0.5; 3]);
    moved.triangles.iter_mut().flatten().for_each(|v| *v += 1);
    let (shifted, shifted_mass) = mesh_laplacian(&moved, 1e-5).unwrap();
    let least = mass.iter().copied().fold(f64::INFINITY, f64::min);
    assert!((shifted_mass[0] / (1e-3 * least) - 1.0).abs() < 1e-9);
    assert_eq!(shifted.column(0).collect::<Vec<_>>(), [(0, 1.0)]);
    for j in 0..n as usize {
        assert!((shifted_mass[j + 1] - mass[j]).abs() < 1e-12 * total);
        for ((i, a), (k, b)) in stiffness.column(j).zip(shifted.column(j + 1)) {
            assert!(i + 1 == k && (a - b).abs() < 1e-10);
        }
    }
    // Vertices at the same place are not welded: both sides of a seam keep a mass above 0.
    let mut seam = mesh.clone();
    seam.positions.push(seam.positions[seam.triangles[0][0] as usize]);
    seam.triangles[0][0] = n;
    assert!(mesh_laplacian(&seam, 1e-5).unwrap().1.iter().all(|a| *a > 0.0));
    assert!(mesh_laplacian(&mesh, f64::NAN).is_err());
    // The unused vertex is in nobody's way.
    let solve = |stiffness: &SymmetricSparse, mass: &[f64]| {
        let pencil = Pencil::new(stiffness, mass).unwrap();
        pencil.solve(&BasisSettings::new(9), &Task::new()).unwrap().0.eigenvalues
    };
    for (a, b) in solve(&stiffness, &mass).iter().zip(solve(&shifted, &shifted_mass)) {
        assert!((a - b).abs() <= 1e-9 * b, "{a} {b}");
    }
}

#[test]
fn a_shape_so_large_or_small_that_its_numbers_overflow_is_refused() {
    for scale in [1e-160, 1e-110, 1e110] {
        let mut mesh = samples::icosphere(2);
        mesh.positions.iter_mut().flatten().for_each(|x| *x *= scale);
        let refused = mesh_laplacian(&mesh, 1e-5).unwrap_err().to_string();
        assert!(refused.contains("scale it"), "{refused}");
        assert!(Body::build(&mesh, &BasisSettings::new(2), &Task::new()).is_err());
    }
    for scale in [1e-95, 1e95] {
        let mut mesh = samples::icosphere(2);
        mesh.positions.iter_mut().flatten().for_each(|x| *x *= scale);
        let (_, mass) = mesh_laplacian(&mesh, 1e-5).unwrap();
        assert!(mass.iter().all(|a| a.is_normal()));
        let file = Body::build(&mesh, &BasisSettings::new(9), &Task::new()).unwrap().basis_in_file();
        assert!(file.eigenvalues[1..].iter().chain(&*file.vectors).all(|x| x.is_normal()));
    }
}
