//! Compares the factorization with the matrix that was factored.

use super::solve::{Part, Solve};
use super::solve_one::SolveOne;
use super::{Factor, Symbolic, Workspace, nested_dissection};
use crate::SymmetricSparse;
use crate::simd::{alike, run_for};

/// The graph Laplacian of a grid with diagonals and a few long edges.
fn grid(side: u32) -> SymmetricSparse {
    let mut edges = Vec::new();
    for y in 0..side {
        for x in 0..side {
            let v = y * side + x;
            let w = 1.0 + 0.1 * f64::from(v % 7);
            if x + 1 < side {
                edges.push((v, v + 1, w));
            }
            if y + 1 < side {
                edges.push((v, v + side, w * 1.3));
            }
            if x + 1 < side && y + 1 < side {
                edges.push((v, v + side + 1, 0.5));
            }
        }
    }
    edges.push((0, side * side - 1, 0.7));
    SymmetricSparse::laplacian((side * side) as usize, &edges)
}

/// Factors and solves on every kind of processor; the number of eigenvalues below `shift`.
fn solves(side: u32, shift: f64) -> usize {
    let matrix = grid(side);
    let n = matrix.size();
    let symbolic = Symbolic::of(&matrix, nested_dissection(&matrix));
    let matrix = matrix.permuted_and_scaled(&symbolic.old, &vec![1.0; n]);
    let value = |i: usize, j: usize| ((i * 31 + j * 17) % 101) as f64 / 50.0 - 1.0;
    let b: Vec<[f64; 8]> = (0..n).map(|i| std::array::from_fn(|j| value(i, j))).collect();
    let (below, whole, halves, one) = alike(|processor| {
        let (mut factor, mut workspace) = (Factor::default(), Workspace::default());
        let work = factor.factorization(&symbolic, &matrix, shift, &mut workspace);
        run_for(processor, work)?.unwrap();
        let solved = |parts: &[Part]| {
            let mut x = b.clone();
            for &part in parts {
                run_for(processor, Solve { factor: &factor, symbolic: &symbolic, x: &mut x, part }).unwrap();
            }
            x
        };
        let halves = (factor.below_shift == 0).then(|| solved(&[Part::Forward, Part::Backward]));
        let mut one: Vec<f64> = b.iter().map(|row| row[3]).collect();
        run_for(processor, SolveOne { factor: &factor, symbolic: &symbolic, x: &mut one }).unwrap();
        Some((factor.below_shift, solved(&[Part::Whole]), halves, one))
    });
    check_solution(&matrix, shift, &whole, &b);
    if let Some(halves) = halves {
        // Solving the two halves one after the other equals solving the whole.
        check_solution(&matrix, shift, &halves, &b);
    }
    let eightfold = |column: Vec<f64>| -> Vec<[f64; 8]> { column.into_iter().map(|x| [x; 8]).collect() };
    let fourth = b.iter().map(|row| row[3]).collect();
    check_solution(&matrix, shift, &eightfold(one), &eightfold(fourth));
    below
}

fn check_solution(matrix: &SymmetricSparse, shift: f64, x: &[[f64; 8]], b: &[[f64; 8]]) {
    let n = b.len();
    for j in 0..8 {
        let column: Vec<f64> = x.iter().map(|row| row[j]).collect();
        let image = matrix.times(&column);
        let size = column.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        for i in 0..n {
            let residual = image[i] - shift * column[i] - b[i][j];
            assert!(residual.abs() < 1e-12 * (1.0 + 10.0 * size), "{residual} at {i}, {j}");
        }
    }
}

#[test]
fn solutions_satisfy_their_equations_and_inertia_counts_eigenvalues() {
    assert_eq!(solves(3, -0.5), 0);
    assert_eq!(solves(40, -0.01), 0);
    let side = 23;
    for shift in [0.013, 0.37, 2.9] {
        let below = solves(side, shift);
        let matrix = grid(side);
        let n = matrix.size();
        let mut dense = faer::Mat::<f64>::zeros(n, n);
        for j in 0..n {
            for (i, v) in matrix.column(j) {
                dense[(i, j)] = v;
            }
        }
        let exact = dense.self_adjoint_eigenvalues(faer::Side::Lower).unwrap();
        assert_eq!(below, exact.iter().filter(|l| **l < shift).count(), "at {shift}");
    }
}

#[test]
fn orders_are_permutations_also_of_scattered_graphs() {
    for edges in [vec![], vec![(0, 1, 1.0), (5, 6, 1.0)], (1..150).map(|i| (0, i, 1.0)).collect()] {
        let matrix = SymmetricSparse::laplacian(200, &edges);
        let mut order = nested_dissection(&matrix);
        order.sort_unstable();
        assert!(order.iter().enumerate().all(|(i, o)| i == *o as usize));
    }
}

#[test]
#[ignore = "a measurement, not a test: cargo test --release -- --ignored --nocapture ldlt_speed"]
#[allow(clippy::print_stderr, reason = "prints what it measured")]
fn ldlt_speed() {
    use std::time::Instant;
    for side in [187, 366] {
        let matrix = grid(side);
        let n = matrix.size();
        let t = Instant::now();
        let order = nested_dissection(&matrix);
        let t1 = t.elapsed();
        let t = Instant::now();
        let symbolic = Symbolic::of(&matrix, order);
        let t2 = t.elapsed();
        let flops: f64 = symbolic
            .supernodes
            .iter()
            .map(|s| (0..s.width).map(|k| ((s.width - k + s.below) as f64).powi(2)).sum::<f64>())
            .sum();
        eprintln!(
            "n {n}: order {t1:?}, analysis {t2:?}, {} supernodes, {} values, {:.3} Gflop",
            symbolic.supernodes.len(),
            symbolic.values,
            flops / 1e9
        );
        let matrix = matrix.permuted_and_scaled(&symbolic.old, &vec![1.0; n]);
        let (mut factor, mut workspace) = (Factor::default(), Workspace::default());
        for _ in 0..8 {
            let t = Instant::now();
            factor.compute(&symbolic, &matrix, 0.0137, &mut workspace).unwrap();
            eprintln!("  factor {:?}", t.elapsed());
        }
        let mut x = vec![[1.0; 8]; n];
        for _ in 0..8 {
            let t = Instant::now();
            factor.solve(&symbolic, &mut x);
            eprintln!("  per right-hand side {:?}", t.elapsed() / 8);
        }
        let mut x = vec![1.0; n];
        for _ in 0..8 {
            let t = Instant::now();
            factor.solve_one(&symbolic, &mut x);
            eprintln!("  a single right-hand side {:?}", t.elapsed());
        }
    }
}
