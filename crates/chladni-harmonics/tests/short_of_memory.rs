//! Solves that do not fit in memory: fewer slices at once, and harmonics in a scratch folder.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use chladni_harmonics::{
    BasisSettings, Body, HarmonicsError, Laplacian, Operator, Pencil, SymmetricSparse, available_memory,
};
use chladni_mesh::TriMesh;
use chladni_mesh::samples::icosphere;
use chladni_task::{Progress, Task};

/// One solved as usual, and one with `bytes` of memory per vertex and a scratch folder.
fn both(mesh: &TriMesh, harmonics: usize, bytes: u64) {
    let task = Task::new();
    let folder = tempfile::tempdir().unwrap();
    let usual = BasisSettings { threads: Some(2), ..BasisSettings::new(harmonics) };
    let (body, report) = Body::load_or_build(mesh, &usual, None, &task).unwrap();
    assert!(body.basis.vectors.is_in_memory() && report.short_of_memory.is_none());
    let vertices = body.basis.vertices() as u64;
    let short = BasisSettings {
        memory_bytes: Some(bytes * vertices),
        scratch: Some(folder.path().to_owned()),
        ..usual.clone()
    };
    let (spilled, report) = Body::load_or_build(mesh, &short, None, &task).unwrap();
    assert!(!spilled.basis.vectors.is_in_memory());
    let warning = report.warnings(&spilled.basis.certificate)[0].to_string();
    assert!(warning.contains("are kept in") && warning.contains("1 of 2 threads solve"), "{warning}");
    let bits = |body: &Body| body.basis.vectors.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert!(bits(&body) == bits(&spilled), "the same to the last bit");
    assert_eq!(body.basis.certificate, spilled.basis.certificate);
    // On Unix the file has no name.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), usize::from(!cfg!(unix)));
    refused_before_the_work(mesh, &BasisSettings { scratch: None, ..short });
}

/// Refused with what it takes and what there is, before anything begins.
fn refused_before_the_work(mesh: &TriMesh, settings: &BasisSettings) {
    let task = Task::new();
    let refused = Body::load_or_build(mesh, settings, None, &task).unwrap_err();
    assert!(matches!(refused, HarmonicsError::TooMany { .. }), "{refused}");
    assert_eq!(task.progress(), Progress::default());
    let message = refused.to_string();
    let words: Vec<&str> = message.split_whitespace().collect();
    let sizes = words.windows(2).filter(|pair| pair[1] == "MB").map(|pair| pair[0].parse::<f64>().unwrap());
    let sizes: Vec<f64> = sizes.collect();
    let free = settings.memory_bytes.unwrap() as f64 / 1e6;
    assert!(sizes.len() == 2 && sizes[0] > sizes[1] && (sizes[1] - free).abs() < 0.06, "{message}");
}

#[test]
fn a_mesh_whose_operator_does_not_fit_is_refused_before_that_is_built() {
    let tiny = BasisSettings { memory_bytes: Some(100_000), ..BasisSettings::new(9) };
    // Solved by slices, and as a dense matrix.
    for finer in [4, 2] {
        refused_before_the_work(&icosphere(finer), &tiny);
    }
}

/// The fin at one edge is what this operator refuses, as it is built.
#[test]
fn a_held_surface_that_does_not_fit_is_refused_before_its_operator_is_built() {
    let mut mesh = icosphere(4);
    mesh.triangles.pop();
    let [a, b, _] = mesh.triangles[0];
    mesh.positions.push([0.0, 0.0, 3.0]);
    mesh.triangles.push([a, b, mesh.positions.len() as u32 - 1]);
    let roomy = BasisSettings { laplacian: Laplacian::Cotangent, ..BasisSettings::new(9) };
    let tiny = BasisSettings { memory_bytes: Some(100_000), ..roomy.clone() };
    let refused =
        |settings: &BasisSettings| Body::with_held_border(&mesh, settings, &Task::new()).unwrap_err();
    assert!(!matches!(refused(&roomy), HarmonicsError::TooMany { .. }));
    assert!(matches!(refused(&tiny), HarmonicsError::TooMany { .. }));
}

#[test]
fn harmonics_on_disk_are_those_in_memory() {
    both(&icosphere(5), 300, 5000);
}

#[test]
fn harmonics_of_two_components_on_disk_are_those_in_memory() {
    let mut mesh = icosphere(4);
    let n = mesh.positions.len() as u32;
    let beside: Vec<_> = mesh.positions.iter().map(|[x, y, z]| [x + 3.0, 1.1 * y, 0.9 * z]).collect();
    mesh.positions.extend(beside);
    mesh.triangles.extend(mesh.triangles.clone().iter().map(|t| t.map(|v| v + n)));
    both(&mesh, 400, 5000);
}

#[test]
fn a_pencil_uses_the_same_room() {
    let operator = Operator::of(&icosphere(5)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let usual = BasisSettings { threads: Some(2), ..BasisSettings::new(200) };
    let short = BasisSettings {
        memory_bytes: Some(5000 * operator.vertices() as u64),
        scratch: Some(folder.path().to_owned()),
        ..usual.clone()
    };
    let pencil = operator.pencil();
    let (basis, report) = pencil.solve(&usual, &Task::new()).unwrap();
    let (spilled, of_short) = pencil.solve(&short, &Task::new()).unwrap();
    assert!(report.short_of_memory.is_none() && of_short.short_of_memory.is_some());
    assert!(!spilled.vectors.is_in_memory());
    assert!(basis == spilled);
}

#[test]
fn a_graph_whose_factor_fills_is_refused_before_it_is_factored() {
    // Of a complete graph, a factor takes 0.6 MB and its front 1.3 MB; of a surface, both take 0.4 MB.
    let n = 400;
    let edges = (0..n).flat_map(|j| (j + 1..n).map(move |i| (i, j, -1.0)));
    let diagonal = (0..n).map(|v| (v, v, (n - 1) as f64));
    let stiffness = SymmetricSparse::from_entries(n, edges.chain(diagonal)).unwrap();
    let mass = vec![1.0; n];
    let pencil = Pencil::new(&stiffness, &mass).unwrap();
    let settings = BasisSettings { memory_bytes: Some(2_500_000), ..BasisSettings::new(10) };
    let refused = pencil.solve(&settings, &Task::new()).unwrap_err();
    assert!(matches!(refused, HarmonicsError::TooMany { .. }), "{refused}");
    assert!(refused.to_string().contains("2.5 MB may be used"), "{refused}");
}

#[test]
fn beside_factors_that_fill_fewer_slices_are_reported_and_the_disk_is_used() {
    // With its front, a factor takes 1.9 MB, where one of a surface would take 0.4 MB.
    let n = 400;
    let weight = |i: usize, j: usize| 1.5 + ((7 * i * i + 13 * j * j + i * j) as f64).sin();
    let between = |i: usize, j: usize| if i == j { 0.0 } else { weight(i.max(j), i.min(j)) };
    let edges = (0..n).flat_map(|j| (j + 1..n).map(move |i| (i, j, -between(i, j))));
    let diagonal = (0..n).map(|v| (v, v, (0..n).map(|u| between(u, v)).sum::<f64>()));
    let stiffness = SymmetricSparse::from_entries(n, edges.chain(diagonal)).unwrap();
    let mass = vec![1.0; n];
    let pencil = Pencil::new(&stiffness, &mass).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let solve = |bytes: Option<u64>| {
        let usual = BasisSettings { threads: Some(2), memory_bytes: bytes, ..BasisSettings::new(130) };
        let settings = BasisSettings { scratch: Some(folder.path().to_owned()), ..usual };
        pencil.solve(&settings, &Task::new()).unwrap()
    };
    let (basis, report) = solve(None);
    assert!(report.short_of_memory.is_none());
    // One slice takes 3.9 MB, of which 0.4 MB may be on disk; two would take 7.0 MB.
    for (bytes, is_on_disk) in [(5_000_000, false), (3_550_000, true)] {
        let (fewer, report) = solve(Some(bytes));
        let short = report.short_of_memory.unwrap();
        assert_eq!((short.slices, short.of_slices, short.scratch.is_some()), (1, 2, is_on_disk), "{bytes}");
        assert!(fewer == basis);
    }
}

#[test]
fn dense_eigenvalues_that_do_not_fit_are_refused() {
    if available_memory().is_none() {
        return;
    }
    let n = 1_000_000;
    let mut operator = Operator::of(&icosphere(0)).unwrap();
    operator.stiffness = SymmetricSparse::from_entries(n, []).unwrap();
    operator.mass = vec![1.0; n];
    let refused = operator.dense_eigenvalues().unwrap_err();
    assert!(matches!(refused, HarmonicsError::TooMany { .. }), "{refused}");
}
