//! Compares bases by SLEPc on the ranks of MPI with those of our own solver. If MPI or slepc4py is missing,
//! a line is printed and the test is skipped.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod shapes;

use chladni_harmonics::{
    Basis, BasisSettings, Body, HarmonicsError, InnerSolver, Operator, Ranks, RanksReport,
};
use chladni_mesh::TriMesh;
use chladni_task::{Cancelled, Task};

/// A bumpy sphere, all of whose eigenvalues are different.
fn bumpy(levels: u32) -> TriMesh {
    let mut mesh = shapes::icosphere(levels);
    for p in &mut mesh.positions {
        let size = 1.0 + 0.2 * (3.0 * p[0] + 1.0).sin() * (2.0 * p[1]).cos() + 0.1 * p[2];
        *p = p.map(|x| x * size);
    }
    mesh
}

/// Solves on ranks and checks the certificate. An error is the reason why ranks cannot be used here.
fn solved(
    mesh: &TriMesh,
    settings: &BasisSettings,
    ranks: &Ranks,
) -> Result<(Body, RanksReport, bool), String> {
    let operator = Operator::of(mesh).unwrap();
    match Body::solve_on_ranks(mesh, &operator, settings, ranks, &Task::new()) {
        Ok((body, report, of_ranks)) => {
            // Our own factorizations must agree with those of MUMPS.
            let again = operator.certify(&body.basis).unwrap();
            let own = body.basis.certificate;
            assert!(again.is_precise(), "{again:?}");
            assert!(own.max_relative_residual < 1e-9 && own.max_orthogonality_error < 1e-8, "{own:?}");
            let counted = (ranks.inner != InnerSolver::Iterated).then_some(true);
            assert_eq!((own.inertia_counts_match, own.is_precise()), (counted, counted.is_some()));
            if settings.harmonics > operator.components() {
                assert_eq!((of_ranks.ranks, of_ranks.peak_bytes.len()), (ranks.count, ranks.count));
            }
            Ok((body, of_ranks, report.cuts_cluster))
        }
        Err(HarmonicsError::NoRanks { reason }) => Err(reason),
        Err(HarmonicsError::RanksFailed { reason }) if reason.contains("OMPI_ALLOW_RUN_AS_ROOT") => {
            Err(reason)
        }
        Err(error) => panic!("{error}"),
    }
}

/// Compares eigenvalues to 10⁻⁸, and vectors by the share of each that lies in the space of our vectors
/// with the same or an equal eigenvalue.
fn agree(theirs: &Basis, ours: &Basis) {
    assert_eq!(theirs.harmonics(), ours.harmonics());
    for (k, (a, b)) in theirs.eigenvalues.iter().zip(&ours.eigenvalues).enumerate() {
        assert!((a - b).abs() <= 1e-8 * b, "{k}: {a} for {b}");
    }
    let last = ours.harmonics() - 1;
    for k in 0..=last {
        let near = |j: &usize| {
            (ours.eigenvalues[*j] - theirs.eigenvalues[k]).abs() <= 1e-4 * theirs.eigenvalues[k].max(1e-9)
        };
        let share: f64 = (0..=last)
            .filter(near)
            .map(|j| {
                let product = |v: usize| theirs.harmonic(k)[v] * ours.harmonic(j)[v] * ours.mass[v];
                (0..ours.vertices()).map(product).sum::<f64>().powi(2)
            })
            .sum();
        // The last group of equal eigenvalues may continue beyond K.
        assert!(
            (share - 1.0).abs() < 1e-8
                || ours.eigenvalues[last] - ours.eigenvalues[k] < 1e-4 * ours.eigenvalues[k],
            "{k}: {share}"
        );
    }
}

#[test]
fn one_two_and_four_ranks_find_what_our_solver_finds() {
    let (mesh, settings) = (bumpy(3), BasisSettings::new(40));
    let ours = Body::build(&mesh, &settings, &Task::new()).unwrap();
    let factors = |groups| InnerSolver::Factors { groups };
    for (count, inner) in [
        (1, factors(1)),
        (2, factors(1)),
        (4, factors(2)),
        (1, InnerSolver::Iterated),
        (2, InnerSolver::Iterated),
    ] {
        let ranks = Ranks { inner, ..Ranks::here(count) };
        let (body, report, cuts) = match solved(&mesh, &settings, &ranks) {
            Ok(solved) => solved,
            Err(reason) => return println!("skipped: {reason}"),
        };
        agree(&body.basis, &ours.basis);
        assert!(!cuts);
        let is_counted = report.counted_by.is_some() && report.counts.len() >= 3;
        assert!(if inner == InnerSolver::Iterated { report.searches >= 2 } else { is_counted }, "{report:?}");
        for k in 0..40 {
            // The signs must be chosen equally.
            let product =
                |v: usize| body.basis.harmonic(k)[v] * ours.basis.harmonic(k)[v] * ours.basis.mass[v];
            assert!((0..ours.basis.vertices()).map(product).sum::<f64>() > 0.99, "{k}");
        }
    }
}

#[test]
fn clusters_and_several_components_come_whole() {
    // Two spheres: every eigenvalue l (l + 1) occurs 2 (2 l + 1) times; K = 20 is in the middle of a group
    // of ten.
    let sphere = shapes::icosphere(3);
    let mesh = shapes::beside(&[sphere.clone(), sphere], [3.0, 0.0, 0.0]);
    let (factors, iterated) = (InnerSolver::Factors { groups: 1 }, InnerSolver::Iterated);
    for (whole_clusters, expected, inner) in
        [(false, 15, factors), (true, 18, factors), (false, 15, iterated), (true, 18, iterated)]
    {
        let settings = BasisSettings { whole_clusters, ..BasisSettings::new(15) };
        let ours = Body::build(&mesh, &settings, &Task::new()).unwrap();
        let (body, _, cuts) = match solved(&mesh, &settings, &Ranks { inner, ..Ranks::here(1) }) {
            Ok(solved) => solved,
            Err(reason) => return println!("skipped: {reason}"),
        };
        assert_eq!((body.basis.harmonics(), cuts), (expected, !whole_clusters));
        agree(&body.basis, &ours.basis);
    }
    // No more harmonics than there are constants.
    let (body, ..) = match solved(&mesh, &BasisSettings::new(2), &Ranks::here(1)) {
        Ok(solved) => solved,
        Err(reason) => return println!("skipped: {reason}"),
    };
    assert_eq!(body.basis.eigenvalues, [0.0, 0.0]);
}

#[test]
fn a_cancelled_solve_ends_its_ranks_and_leaves_nothing() {
    let scratch = tempfile::tempdir().unwrap();
    let mesh = bumpy(5);
    let operator = Operator::of(&mesh).unwrap();
    let ranks = Ranks { scratch: Some(scratch.path().to_owned()), ..Ranks::here(2) };
    let task = Task::new();
    let outcome = std::thread::scope(|scope| {
        let solving = scope.spawn(|| {
            Body::solve_on_ranks(&mesh, &operator, &BasisSettings::new(300), &ranks, &task).map(|_| ())
        });
        // Wait until the ranks are at work.
        let at_work = ["counting", "harmonics", "polishing"];
        while !solving.is_finished() && !at_work.contains(&task.progress().stage.as_str()) {
            std::thread::yield_now();
        }
        task.cancel();
        solving.join().unwrap()
    });
    match outcome {
        Err(HarmonicsError::Cancelled(Cancelled)) => {}
        Err(HarmonicsError::NoRanks { reason } | HarmonicsError::RanksFailed { reason }) => {
            println!("skipped: {reason}")
        }
        other => panic!("{other:?}"),
    }
    assert_eq!(std::fs::read_dir(scratch.path()).unwrap().count(), 0);
}

#[test]
fn harmonics_that_are_kept_on_disk_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = bumpy(3);
    let operator = Operator::of(&mesh).unwrap();
    // In memory 40 harmonics take about 1,600 bytes a vertex, on disk 1,300.
    let settings = BasisSettings {
        memory_bytes: Some(1400 * operator.vertices() as u64),
        scratch: Some(folder.path().to_owned()),
        ..BasisSettings::new(40)
    };
    match Body::solve_on_ranks(&mesh, &operator, &settings, &Ranks::here(1), &Task::new()) {
        Ok((_, report, _)) => assert!(report.short_of_memory.is_some_and(|short| short.scratch.is_some())),
        Err(HarmonicsError::NoRanks { reason } | HarmonicsError::RanksFailed { reason }) => {
            println!("skipped: {reason}")
        }
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn too_many_harmonics_are_refused() {
    let mesh = shapes::icosphere(1);
    let operator = Operator::of(&mesh).unwrap();
    let error =
        Body::solve_on_ranks(&mesh, &operator, &BasisSettings::new(30), &Ranks::here(1), &Task::new());
    assert!(error.unwrap_err().to_string().contains("at most half"));
}
