//! Pencils that are nothing like surfaces: dense matrices, cliques, stars, and eigenvalues of huge multiplicity.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use chladni_harmonics::{
    BasisSettings, Body, BuildReport, Certificate, HarmonicsError, Pencil, SymmetricSparse,
};
use chladni_mesh::TriMesh;
use chladni_task::Task;

/// The first `k` eigenvalues, which were certified to be precise.
fn first(matrix: &SymmetricSparse, k: usize) -> (Vec<f64>, BuildReport) {
    let mass = vec![1.0; matrix.size()];
    let (basis, report) =
        Pencil::new(matrix, &mass).unwrap().solve(&BasisSettings::new(k), &Task::new()).unwrap();
    // Eigenvalues of a billionth of the largest one are at the edge of rounding: 3e-7 for a clique in a path.
    let certificate = basis.certificate;
    assert!(certificate.is_precise() || certificate.max_relative_residual < 1e-6, "{certificate:?}");
    assert_eq!((basis.harmonics(), basis.vectors.len()), (k, k * matrix.size()));
    (basis.eigenvalues, report)
}

fn check(matrix: &SymmetricSparse, exact: &[f64]) -> BuildReport {
    let (values, report) = first(matrix, exact.len());
    for (value, exact) in values.iter().zip(exact) {
        assert!((value - exact).abs() < 1e-8 * exact.max(1.0), "{value} for {exact}");
    }
    report
}

/// The Laplacian of a graph.
fn laplacian(n: usize, edges: impl IntoIterator<Item = (usize, usize)>) -> SymmetricSparse {
    let (mut degree, mut entries) = (vec![0.0; n], Vec::new());
    for (i, j) in edges {
        degree[i] += 1.0;
        degree[j] += 1.0;
        entries.push((i, j, -1.0));
    }
    entries.extend(degree.iter().enumerate().map(|(i, d)| (i, i, *d)));
    SymmetricSparse::from_entries(n, entries).unwrap()
}

fn clique(first: usize, n: usize) -> impl Iterator<Item = (usize, usize)> {
    (first..first + n).flat_map(move |i| (first..i).map(move |j| (i, j)))
}

#[test]
fn dense_matrices_and_cliques_are_solved() {
    // 1 + i on the diagonal and a constant everywhere: eigenvalues lie between those of the diagonal.
    for n in [402, 1000] {
        let entries = (0..n)
            .flat_map(|i| (0..=i).map(move |j| (i, j, 0.01 + if i == j { 1.0 + i as f64 } else { 0.0 })));
        let matrix = SymmetricSparse::from_entries(n, entries).unwrap();
        let (values, _) = first(&matrix, 5);
        for (i, value) in values.iter().enumerate() {
            // The secular equation, whose root lies between two neighbors.
            let sum = (0..n).map(|j| 0.01 / (1.0 + j as f64 - value)).sum::<f64>();
            assert!(
                (1.0 + sum).abs() < 1e-5 && *value > 1.0 + i as f64 && *value < 2.0 + i as f64,
                "{value}"
            );
        }
    }
    let mut exact = vec![600.0; 9];
    exact[0] = 0.0;
    check(&laplacian(600, clique(0, 600)), &exact);
    // A clique in the middle of a path hardly moves.
    let path = (1..3000).map(|i| (i, i - 1)).filter(|(i, _)| !(1501..2000).contains(i));
    let (values, _) = first(&laplacian(3000, clique(1500, 500).chain(path)), 6);
    assert!(values[0] == 0.0 && values[1] > 1e-7 && values[5] < 1e-3, "{values:?}");
    let three = [0, 450, 900].into_iter().flat_map(|first| clique(first, 450));
    check(&laplacian(1350, three), &[0.0, 0.0, 0.0, 450.0, 450.0]);
}

#[test]
fn a_complete_bipartite_graph_is_solved() {
    let edges = (0..300).flat_map(|i| (300..600).map(move |j| (j, i)));
    check(&laplacian(600, edges), &[0.0, 300.0, 300.0, 300.0, 300.0]);
}

#[test]
fn of_an_eigenvalue_of_huge_multiplicity_only_as_many_vectors_are_made_as_are_wanted() {
    let diagonal = |values: &mut dyn Iterator<Item = f64>| {
        let entries: Vec<_> = values.enumerate().map(|(i, x)| (i, i, x)).collect();
        SymmetricSparse::from_entries(entries.len(), entries).unwrap()
    };
    // Whole, each would be a matrix of tens of gigabytes.
    assert!(check(&diagonal(&mut std::iter::repeat_n(1.0, 100_000)), &[1.0; 7]).cuts_cluster);
    let zeros = std::iter::repeat_n(0.0, 30_000);
    assert!(check(&diagonal(&mut zeros.chain((0..20_000).map(f64::from))), &[0.0; 7]).cuts_cluster);
    let report = check(&laplacian(40_000, (0..20_000).map(|i| (2 * i, 2 * i + 1))), &[0.0; 6]);
    assert!(report.cuts_cluster);
}

#[test]
fn a_star_has_one_eigenvalue_almost_everywhere() {
    for n in [3000, 20_000] {
        let star = laplacian(n, (1..n).map(|i| (i, 0)));
        assert!(check(&star, &[0.0, 1.0, 1.0, 1.0, 1.0, 1.0]).cuts_cluster);
        let two = laplacian(2 * n, (1..n).flat_map(|i| [(i, 0), (n + i, n)]));
        assert!(check(&two, &[0.0, 0.0, 1.0, 1.0, 1.0, 1.0]).cuts_cluster);
    }
}

#[test]
fn eigenvalues_at_the_edge_of_rounding_can_be_counted() {
    let values = [1e-10, 2e-10].into_iter().chain((1..1999).map(f64::from));
    let matrix = SymmetricSparse::from_entries(2000, values.enumerate().map(|(i, x)| (i, i, x))).unwrap();
    check(&matrix, &[1e-10, 2e-10, 1.0]);
}

#[test]
fn a_dense_solve_that_is_cancelled_is_not_waited_for() {
    let path = laplacian(1500, (1..1500).map(|i| (i, i - 1)));
    let (mass, task) = (vec![1.0; 1500], Task::new());
    let pencil = Pencil::new(&path, &mass).unwrap();
    let error = std::thread::scope(|scope| {
        let solve = scope.spawn(|| pencil.solve(&BasisSettings::new(1400), &task).unwrap_err());
        while task.progress().stage.is_empty() {
            std::thread::yield_now();
        }
        task.cancel();
        solve.join().unwrap()
    });
    assert_eq!(error, HarmonicsError::Cancelled(chladni_task::Cancelled));
}

/// Triangles that share nothing.
fn triangles(count: u32) -> TriMesh {
    let corners = |i: u32| {
        let x = 2.0 * f64::from(i);
        [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.5]]
    };
    TriMesh {
        positions: (0..count).flat_map(corners).collect(),
        triangles: (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ..TriMesh::default()
    }
}

#[test]
fn a_mesh_of_many_pieces_gets_its_first_constants_and_a_whole_group_only_where_it_fits() {
    let mesh = triangles(25_000);
    let mut settings = BasisSettings::new(10);
    settings.memory_bytes = Some(2_000_000_000);
    let (body, report) = Body::load_or_build(&mesh, &settings, None, &Task::new()).unwrap();
    assert_eq!(body.basis.eigenvalues, [0.0; 10]);
    assert!(
        report.cuts_cluster && body.basis.certificate.max_orthogonality_error < Certificate::ORTHOGONALITY
    );
    settings.whole_clusters = true;
    let refused = Body::load_or_build(&mesh, &settings, None, &Task::new()).unwrap_err().to_string();
    assert!(refused.contains("25000 harmonics") && refused.contains("15.0 GB"), "{refused}");
}
