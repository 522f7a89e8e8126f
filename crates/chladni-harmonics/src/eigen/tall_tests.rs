//! The kernels of tall blocks, beside sums written out, on every kind of processor.

use super::*;
use crate::simd::{alike, run_for};

fn block(n: usize, seed: usize) -> Vec<Row> {
    (0..n)
        .map(|i| std::array::from_fn(|j| ((i * 31 + j * 17 + seed * 7) % 101) as f64 / 50.0 - 1.0))
        .collect()
}

#[test]
fn overlaps_and_products_are_right_for_all_sizes_on_every_kind_of_processor() {
    for (n, wide, deep) in [(1, 1, 1), (7, 2, 3), (64, 3, 1), (71, 4, 2), (200, 5, 4), (131, 7, 3)] {
        let basis: Vec<Vec<Row>> = (0..deep).map(|s| block(n, s)).collect();
        let xs: Vec<Vec<Row>> = (0..wide).map(|s| block(n, 50 + s)).collect();
        let v: Vec<&[Row]> = basis.iter().map(Vec::as_slice).collect();
        let x: Vec<&[Row]> = xs.iter().map(Vec::as_slice).collect();
        let c: Vec<Small> = (0..wide * deep).map(|s| *block(8, 90 + s).first_chunk().unwrap()).collect();
        let sums = alike(|processor| {
            let mut sums = vec![[[0.0; 8]; BLOCK]; wide * deep];
            run_for(processor, Overlaps { basis: &v, xs: &x, upper: false, sums: &mut sums })?;
            Some(sums)
        });
        let left = alike(|processor| {
            let mut left = xs.clone();
            let mut views: Vec<&mut [Row]> = left.iter_mut().map(Vec::as_mut_slice).collect();
            run_for(processor, SubtractProducts { xs: &mut views, basis: &v, coefficients: &c })?;
            Some(left)
        });
        for (b, a) in (0..deep).flat_map(|b| (0..wide).map(move |a| (b, a))) {
            for (i, j) in (0..8).flat_map(|i| (0..8).map(move |j| (i, j))) {
                let exact: f64 = (0..n).map(|k| basis[b][k][i] * xs[a][k][j]).sum();
                assert!((sums[b * wide + a][i][j] - exact).abs() < 1e-12 * n as f64);
            }
        }
        for (a, k, j) in (0..wide).flat_map(|a| (0..n).flat_map(move |k| (0..8).map(move |j| (a, k, j)))) {
            let product = |b: usize| (0..8).map(|i| basis[b][k][i] * c[b * wide + a][i][j]).sum::<f64>();
            let exact = xs[a][k][j] - (0..deep).map(product).sum::<f64>();
            assert!((left[a][k][j] - exact).abs() < 1e-12, "{n} {wide} {deep}");
        }
    }
}

#[test]
fn blocks_are_multiplied_from_the_right_on_every_kind_of_processor() {
    for n in [1, 8, 29] {
        let (x, right) = (block(n, 3), *block(8, 4).first_chunk().unwrap());
        let product = alike(|processor| {
            let mut product = x.clone();
            run_for(processor, MultiplyRight { x: &mut product, right: &right })?;
            Some(product)
        });
        for (k, j) in (0..n).flat_map(|k| (0..8).map(move |j| (k, j))) {
            let exact: f64 = (0..8).map(|i| x[k][i] * right[i][j]).sum();
            assert!((product[k][j] - exact).abs() < 1e-13, "{n}");
        }
    }
}

#[test]
fn residuals_are_right_on_every_kind_of_processor() {
    let n = 61;
    let edges: Vec<(u32, u32, f64)> =
        (0..60).flat_map(|v| [(v, v + 1, 1.0 + f64::from(v % 5)), (v / 2, v + 1, 0.3)]).collect();
    let matrix = SymmetricSparse::laplacian(n, &edges);
    let (x, values) = (block(n, 5), block(1, 6)[0]);
    let weight: Vec<f64> = (0..n).map(|i| 0.5 + (i % 3) as f64).collect();
    let sums = alike(|processor| {
        run_for(processor, Residuals { matrix: &matrix, x: &x, values: &values, weight: &weight })
    });
    for j in 0..8 {
        let column: Vec<f64> = x.iter().map(|row| row[j]).collect();
        let image = matrix.times(&column);
        let rest = |i: usize| image[i] - values[j] * column[i];
        let exact = [
            (0..n).map(|i| rest(i).powi(2)).sum::<f64>(),
            (0..n).map(|i| weight[i] * rest(i).powi(2)).sum(),
            (0..n).map(|i| weight[i] * image[i].powi(2)).sum(),
        ];
        for (sum, exact) in sums.iter().zip(exact) {
            assert!((sum[j] - exact).abs() < 1e-12 * exact, "{} {exact}", sum[j]);
        }
    }
}
