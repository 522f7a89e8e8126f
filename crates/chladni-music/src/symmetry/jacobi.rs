//! Eigenvectors of small symmetric matrices by cyclic Jacobi rotations.

/// Eigenvalues, descending, and eigenvectors (column j of `vectors[i][j]`) of the symmetric
/// matrix `a`.
pub(super) fn symmetric_eigen(mut a: Vec<Vec<f64>>) -> (Vec<f64>, Vec<Vec<f64>>) {
    let n = a.len();
    let mut v: Vec<Vec<f64>> =
        (0..n).map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect()).collect();
    for _ in 0..60 {
        let off: f64 = (0..n).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| a[i][j].powi(2)).sum();
        let diagonal: f64 = (0..n).map(|i| a[i][i].powi(2)).sum();
        if off <= 1e-30 * diagonal.max(f64::MIN_POSITIVE) {
            break;
        }
        for p in 0..n {
            for q in p + 1..n {
                rotate(&mut a, &mut v, p, q);
            }
        }
    }
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| a[j][j].total_cmp(&a[i][i]));
    let values = order.iter().map(|&i| a[i][i]).collect();
    let vectors = v.iter().map(|row| order.iter().map(|&j| row[j]).collect()).collect();
    (values, vectors)
}

/// The rotation that makes a[p][q] zero (Golub and Van Loan, algorithm 8.4.1).
fn rotate(a: &mut [Vec<f64>], v: &mut [Vec<f64>], p: usize, q: usize) {
    if a[p][q] == 0.0 {
        return;
    }
    let tau = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let t = if tau >= 0.0 { 1.0 } else { -1.0 } / (tau.abs() + (1.0 + tau * tau).sqrt());
    let c = 1.0 / (1.0 + t * t).sqrt();
    let s = t * c;
    for row in a.iter_mut() {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
    for j in 0..a.len() {
        (a[p][j], a[q][j]) = (c * a[p][j] - s * a[q][j], s * a[p][j] + c * a[q][j]);
    }
    for row in v.iter_mut() {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_diagonalise() {
        let a: Vec<Vec<f64>> =
            (0..6).map(|i: i32| (0..6).map(|j: i32| 1.0 / f64::from(i + j + 1)).collect()).collect();
        let (values, vectors) = symmetric_eigen(a.clone());
        assert!(values.is_sorted_by(|x, y| x >= y));
        for j in 0..6 {
            for i in 0..6 {
                let image: f64 = (0..6).map(|k| a[i][k] * vectors[k][j]).sum();
                assert!((image - values[j] * vectors[i][j]).abs() < 1e-12);
            }
        }
    }
}
