//! Faults that are planted into solved slices must be found by their counts and repaired.

use super::super::found::{largest_residual, quiet_place};
use super::super::polish::polish;
use super::super::window::Pairs;
use super::*;
use crate::Operator;
use crate::ldlt::Factor;
use chladni_mesh::TriMesh;

#[path = "../../tests/shapes/mod.rs"]
mod shapes;

/// A bumpy torus without symmetry, with one component.
fn torus(around: u32, across: u32) -> TriMesh {
    use std::f64::consts::TAU;
    let positions = (0..around * across)
        .map(|v| {
            let (a, b) = (
                TAU * f64::from(v % around) / f64::from(around),
                TAU * f64::from(v / around) / f64::from(across),
            );
            let r = 0.4 + 0.08 * (3.0 * a + b).sin() + 0.05 * (2.0 * b - a).cos();
            [(1.0 + r * b.cos()) * a.cos(), (1.0 + r * b.cos()) * a.sin() * 1.2, r * b.sin()]
        })
        .collect();
    let at = |i: u32, j: u32| (j % across) * around + i % around;
    let triangles = (0..around * across)
        .flat_map(|v| {
            let (i, j) = (v % around, v / around);
            [[at(i, j), at(i + 1, j), at(i, j + 1)], [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]]
        })
        .collect();
    TriMesh { positions, triangles, ..TriMesh::default() }
}

fn solved(operator: &Operator, harmonics: usize) -> (Problem, Vec<Found>) {
    let (task, mut profile) = (Task::new(), Profile::default());
    let problem = Problem::of(operator.pencil());
    let slices = plan(&problem, harmonics, false, &mut profile, &task).unwrap();
    let found = slices
        .into_iter()
        .map(|(s, factor)| {
            let (found, tried) = Found::begin(&problem, s, factor, harmonics, &mut profile, &task).unwrap();
            found.finish(&problem, tried, harmonics, &mut profile, &task).unwrap()
        })
        .collect();
    (problem, found)
}

fn values(known: &Known) -> Vec<f64> {
    known.entries.iter().map(|e| e.value).collect()
}

#[test]
fn a_pair_that_is_missing_or_doubled_in_a_slice_is_noticed_and_mended() {
    let operator = Operator::of(&torus(48, 24)).unwrap();
    let harmonics = 150;
    let exact = operator.dense_eigenvalues().unwrap();
    let check = |plant: &dyn Fn(&mut Vec<Found>), mends: bool| {
        let (problem, mut found) = solved(&operator, harmonics);
        let (task, mut profile) = (Task::new(), Profile::default());
        plant(&mut found);
        assert_eq!(mends, matches!(Join::of(&found, 1, harmonics, None), Join::Missing(..)));
        let known = mend(&problem, &mut found, harmonics, usize::MAX, &mut profile, &task).unwrap();
        for (value, exact) in values(&known).iter().zip(&exact[1..]) {
            assert!((value - exact).abs() < 1e-9 * exact, "{value} for {exact}");
        }
        assert!(known.cluster_end >= harmonics);
    };
    check(&|_| {}, false);
    // Removes one pair from the middle of a slice (the zeroed column represents no vector).
    let forget = |found: &mut Vec<Found>| {
        let shift = found[1].slice.shift;
        let pairs = &mut found[1].runs[0];
        let middle = pairs.values.iter().position(|l| *l > shift).unwrap() - 2;
        forget_column(pairs, middle);
    };
    check(&forget, true);
}

/// Removes a pair: its value is dropped, and later columns move up.
fn forget_column(pairs: &mut Pairs, column: usize) {
    use super::super::tall::BLOCK;
    let count = pairs.values.len();
    let mut blocks: Vec<_> = pairs.blocks.iter_mut().collect();
    for k in column..count {
        for row in 0..blocks[0].len() {
            let next = if k + 1 < count { blocks[(k + 1) / BLOCK][row][(k + 1) % BLOCK] } else { 0.0 };
            blocks[k / BLOCK][row][k % BLOCK] = next;
        }
    }
    pairs.values.remove(column);
}

#[test]
fn a_doubled_pair_is_never_certified() {
    let operator = Operator::of(&torus(40, 20)).unwrap();
    let (problem, mut found) = solved(&operator, 100);
    let pairs = &mut found[0].runs[0];
    let twice = pairs.values[3];
    pairs.values.insert(3, twice);
    assert!(matches!(Join::of(&found, 1, 100, None), Join::Missing(..)));
    let mended = mend(&problem, &mut found, 100, usize::MAX, &mut Profile::default(), &Task::new());
    assert!(mended.is_err());
}

#[test]
fn polishing_takes_rough_errors_out_of_the_lowest_pairs() {
    let operator = Operator::of(&torus(60, 24)).unwrap();
    let (problem, mut found) = solved(&operator, 12);
    let mut pairs = found.remove(0).runs.remove(0);
    let exact = pairs.values.clone();
    let relative = |pairs: &Pairs| largest_residual(&problem, pairs);
    for (block, rows) in pairs.blocks.iter_mut().enumerate() {
        for (i, row) in rows.iter_mut().enumerate() {
            for (j, x) in row.iter_mut().enumerate() {
                *x += 1e-8 * (((i * 37 + j * 11 + block * 5) % 17) as f64 - 8.0) / 8.0;
            }
        }
    }
    let rough = relative(&pairs);
    let polished = polish(&problem, pairs, Factor::default(), &mut Profile::default());
    assert!(relative(&polished) < rough / 50.0, "{rough} to {}", relative(&polished));
    for (polished, exact) in polished.values.iter().zip(&exact) {
        assert!((polished / exact - 1.0).abs() < 1e-12, "{polished} {exact}");
    }
}

#[test]
fn where_eigenvalues_come_in_clumps_slices_know_how_many_are_theirs() {
    let ends = |mesh: &TriMesh| {
        let operator = Operator::of(mesh).unwrap();
        let problem = Problem::of(operator.pencil());
        let exact = operator.dense_eigenvalues().unwrap();
        let slices = plan(&problem, 200, false, &mut Profile::default(), &Task::new()).unwrap();
        for (slice, _) in &slices {
            let below = |lambda: f64| exact[1..].partition_point(|l| *l < lambda) + 1;
            if let Some((low, high)) = slice.ends {
                assert_eq!(low, below(slice.low));
                assert!(slice.top || high == below(slice.high));
            }
        }
        slices.iter().all(|(slice, _)| slice.ends.is_some())
    };
    // A sphere has clumps of 2 l + 1 eigenvalues; the other shape has none.
    assert!(ends(&shapes::icosphere(3)));
    assert!(!ends(&torus(40, 20)));
}

#[test]
fn a_shift_that_has_to_move_moves_to_a_wide_gap() {
    let values = [1.0, 2.0, 2.125, 2.25, 3.0, 3.125, 5.125];
    assert_eq!(quiet_place(&values, 2.12, 1.0, 1), Some(1.75));
    assert_eq!(quiet_place(&values, 2.12, 1.0, 2), Some(2.4375));
    // The shift is already in the middle of the widest gap, or there is no gap this near.
    assert_eq!(quiet_place(&values, 4.0, 0.5, 1), None);
    assert_eq!(quiet_place(&values, 4.0, 1.5, 1), Some(2.8125));
    assert_eq!(quiet_place(&[], 4.0, 1.5, 1), None);
}
