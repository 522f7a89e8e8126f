//! Counts eigenvalues by Sylvester's law of inertia in numbers of twice the digits, so that even beside a largest
//! eigenvalue that is 10¹⁶ times as large, the count is exact.

use chladni_harmonics::SymmetricSparse;
use chladni_testdata::DoubleDouble;

/// A single pivot is taken unless a value beside the diagonal is larger by this much (Bunch & Parlett 1971).
const SINGLE: f64 = 0.640_388_203_202_208;

/// The number of eigenvalues of S h = λ M h below σ: that of the negative pivots in an LDLᵀ of S − σM, whose rows and
/// columns are chosen anew for each pivot.
pub fn count_below(stiffness: &SymmetricSparse, mass: &SymmetricSparse, sigma: f64) -> usize {
    let n = stiffness.size();
    let mut a = shifted(stiffness, mass, sigma);
    let (mut open, mut negative): (Vec<usize>, usize) = ((0..n).collect(), 0);
    while !open.is_empty() {
        // The largest values on the diagonal and beside it.
        let (mut own, mut beside) = ((0.0, open[0]), (0.0, open[0], open[0]));
        for (at, &i) in open.iter().enumerate() {
            let value = a[i * n + i].rounded().abs();
            own = if value > own.0 { (value, i) } else { own };
            for &j in &open[..at] {
                let value = a[i * n + j].rounded().abs();
                beside = if value > beside.0 { (value, i, j) } else { beside };
            }
        }
        let (_, p, q) = beside;
        if own.0 >= SINGLE * beside.0 {
            let p = own.1;
            let pivot = a[p * n + p];
            negative += usize::from(pivot.rounded() < 0.0);
            open.retain(|i| *i != p);
            // Only zeros are left: σ is an eigenvalue.
            if own.0 == 0.0 {
                break;
            }
            eliminate(&mut a, n, &open, |a, i| [(p, a[i * n + p] / pivot), (p, DoubleDouble::default())]);
        } else {
            // A pair of rows, of which one is positive and one negative.
            negative += 1;
            open.retain(|i| *i != p && *i != q);
            let (pp, qq, pq) = (a[p * n + p], a[q * n + q], a[p * n + q]);
            let determinant = pp * qq - pq * pq;
            eliminate(&mut a, n, &open, |a, i| {
                let (x, y) = (a[i * n + p], a[i * n + q]);
                [(p, (qq * x - pq * y) / determinant), (q, (pp * y - pq * x) / determinant)]
            });
        }
    }
    negative
}

/// Subtracts from each row of `open` the rows that `multiples` names.
fn eliminate(
    a: &mut [DoubleDouble],
    n: usize,
    open: &[usize],
    multiples: impl Fn(&[DoubleDouble], usize) -> [(usize, DoubleDouble); 2],
) {
    for (at, &i) in open.iter().enumerate() {
        for (p, factor) in multiples(a, i) {
            if factor == DoubleDouble::default() {
                continue;
            }
            for &j in &open[..=at] {
                let value = a[i * n + j] - factor * a[p * n + j];
                (a[i * n + j], a[j * n + i]) = (value, value);
            }
        }
    }
}

/// S − σM, n×n. Rows and columns are scaled by powers of 2, which are exact, so that masses are about 1.
fn shifted(stiffness: &SymmetricSparse, mass: &SymmetricSparse, sigma: f64) -> Vec<DoubleDouble> {
    let n = stiffness.size();
    let scale: Vec<f64> = mass.diagonal().iter().map(|m| (-0.5 * m.log2()).round().exp2()).collect();
    let mut a = vec![DoubleDouble::default(); n * n];
    for (matrix, factor) in [(stiffness, 1.0), (mass, -sigma)] {
        for j in 0..n {
            for (i, value) in matrix.column(j) {
                let at = j * n + i;
                a[at] = a[at] + DoubleDouble::from(factor) * (value * scale[i] * scale[j]).into();
            }
        }
    }
    a
}

#[test]
fn counts_are_exact_where_doubles_have_no_digit_left() {
    // Five beads in a row, the last of which hangs on a weak spring.
    let springs = [1e18, 1e12, 1e6, 1e-2];
    let entries =
        springs.iter().enumerate().flat_map(|(i, s)| [(i, i, *s), (i + 1, i + 1, *s), (i, i + 1, -s)]);
    let stiffness = SymmetricSparse::from_entries(5, entries).unwrap();
    let mass = SymmetricSparse::from_entries(5, (0..5).map(|i| (i, i, 1.0))).unwrap();
    // It swings against the other four, which move as one up to a share of 10⁻⁸.
    let weak = 1e-2 * 1.25;
    for (sigma, count) in
        [(-1e-3, 0), (1e-6, 1), (weak * (1.0 - 1e-7), 1), (weak * (1.0 + 1e-7), 2), (1e20, 5)]
    {
        assert_eq!(count_below(&stiffness, &mass, sigma), count, "{sigma}");
    }
}

#[test]
fn pairs_of_rows_are_pivots_where_the_diagonal_is_zero() {
    // Eigenvalues ±1, ±2 and 0.
    let entries = [(0, 1, 1.0), (2, 3, 2.0), (4, 4, 0.0)];
    let stiffness = SymmetricSparse::from_entries(5, entries).unwrap();
    let mass = SymmetricSparse::from_entries(5, (0..5).map(|i| (i, i, 1.0))).unwrap();
    for (sigma, count) in [(-3.0, 0), (-1.5, 1), (-0.5, 2), (0.0, 2), (0.5, 3), (1.5, 4), (3.0, 5)] {
        assert_eq!(count_below(&stiffness, &mass, sigma), count, "{sigma}");
    }
}
