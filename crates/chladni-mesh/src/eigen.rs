//! Eigenpairs of tiny symmetric matrices, by cyclic Jacobi rotations.

/// Eigenvalues in descending order and the unit eigenvectors that belong to them.
///
/// Golub & Van Loan, *Matrix Computations*, 8.5. Accurate to rounding relative to ‖A‖.
pub fn symmetric_eigen<const N: usize>(mut a: [[f64; N]; N]) -> ([f64; N], [[f64; N]; N]) {
    let mut v = [[0.0; N]; N];
    for i in 0..N {
        v[i][i] = 1.0;
    }
    for _ in 0..50 {
        let mut off = 0.0;
        let mut total = 0.0;
        for i in 0..N {
            for j in 0..N {
                total += a[i][j] * a[i][j];
                if i != j {
                    off += a[i][j] * a[i][j];
                }
            }
        }
        if off <= total * 1e-32 {
            break;
        }
        for p in 0..N {
            for q in p + 1..N {
                if a[p][q] != 0.0 {
                    rotate(&mut a, &mut v, p, q);
                }
            }
        }
    }
    let mut order: [usize; N] = std::array::from_fn(|i| i);
    order.sort_by(|&i, &j| a[j][j].total_cmp(&a[i][i]));
    (order.map(|i| a[i][i]), order.map(|i| std::array::from_fn(|r| v[r][i])))
}

/// One Jacobi rotation that zeroes a[p][q].
fn rotate<const N: usize>(a: &mut [[f64; N]; N], v: &mut [[f64; N]; N], p: usize, q: usize) {
    let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
    let c = 1.0 / t.hypot(1.0);
    let s = t * c;
    for k in 0..N {
        (a[k][p], a[k][q]) = (c * a[k][p] - s * a[k][q], s * a[k][p] + c * a[k][q]);
    }
    for k in 0..N {
        (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
    }
    for row in v.iter_mut() {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenpairs_satisfy_their_equation() {
        let a = [[4.0, 1.0, -2.0], [1.0, 2.0, 0.5], [-2.0, 0.5, 3.0]];
        let (values, vectors) = symmetric_eigen(a);
        assert!(values[0] >= values[1] && values[1] >= values[2]);
        for (value, x) in values.iter().zip(vectors) {
            for r in 0..3 {
                let ax: f64 = (0..3).map(|c| a[r][c] * x[c]).sum();
                assert!((ax - value * x[r]).abs() < 1e-14);
            }
        }
    }
}
