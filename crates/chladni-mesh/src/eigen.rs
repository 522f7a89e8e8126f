//! Eigenpairs of small symmetric matrices, by cyclic Jacobi rotations.

/// Eigenvalues in descending order and the unit eigenvectors that belong to them.
///
/// Golub & Van Loan, *Matrix Computations*, 8.5. Accurate to rounding relative to ‖A‖.
pub fn symmetric_eigen<const N: usize>(mut a: [[f64; N]; N]) -> ([f64; N], [[f64; N]; N]) {
    let mut v = [[0.0; N]; N];
    diagonalize(&mut a, &mut v);
    let mut order: [usize; N] = std::array::from_fn(|i| i);
    order.sort_by(|&i, &j| a[j][j].total_cmp(&a[i][i]));
    (order.map(|i| a[i][i]), order.map(|i| std::array::from_fn(|r| v[r][i])))
}

/// As [`symmetric_eigen`], of a square matrix of any size.
pub fn symmetric_eigen_of(mut a: Vec<Vec<f64>>) -> (Vec<f64>, Vec<Vec<f64>>) {
    let n = a.len();
    let mut v = vec![vec![0.0; n]; n];
    diagonalize(&mut a, &mut v);
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| a[j][j].total_cmp(&a[i][i]));
    let vector = |i: &usize| v.iter().map(|row| row[*i]).collect();
    (order.iter().map(|&i| a[i][i]).collect(), order.iter().map(vector).collect())
}

/// Makes `a` diagonal, and turns `v`, which must be 0, into the matrix whose columns are its eigenvectors.
fn diagonalize<R: AsRef<[f64]> + AsMut<[f64]>>(a: &mut [R], v: &mut [R]) {
    let n = a.len();
    for i in 0..n {
        v[i].as_mut()[i] = 1.0;
    }
    let largest_of = |row: &R| row.as_ref().iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let largest = a.iter().map(largest_of).fold(0.0, f64::max);
    if largest == 0.0 || largest.is_infinite() {
        return;
    }
    // Squares of very large or small entries would leave the range of f64. A power of two changes no other bit.
    let unit = f64::from_bits(largest.to_bits() & f64::INFINITY.to_bits()).max(f64::MIN_POSITIVE);
    scale(a, 1.0 / unit);
    rotate_all(a, v);
    scale(a, unit);
}

fn scale<R: AsMut<[f64]>>(a: &mut [R], factor: f64) {
    a.iter_mut().for_each(|row| row.as_mut().iter_mut().for_each(|x| *x *= factor));
}

/// Sweeps of rotations until `a` is diagonal.
fn rotate_all<R: AsRef<[f64]> + AsMut<[f64]>>(a: &mut [R], v: &mut [R]) {
    let n = a.len();
    for _ in 0..50 {
        let mut off = 0.0;
        let mut total = 0.0;
        for (i, row) in a.iter().enumerate() {
            for (j, x) in row.as_ref().iter().enumerate() {
                total += x * x;
                if i != j {
                    off += x * x;
                }
            }
        }
        if off <= total * 1e-32 {
            break;
        }
        for p in 0..n {
            for q in p + 1..n {
                if a[p].as_ref()[q] != 0.0 {
                    rotate(a, v, p, q);
                }
            }
        }
    }
}

/// One Jacobi rotation that zeroes a[p][q].
fn rotate<R: AsRef<[f64]> + AsMut<[f64]>>(a: &mut [R], v: &mut [R], p: usize, q: usize) {
    let (app, aqq, apq) = (a[p].as_ref()[p], a[q].as_ref()[q], a[p].as_ref()[q]);
    let theta = (aqq - app) / (2.0 * apq);
    let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
    let c = 1.0 / t.hypot(1.0);
    let s = t * c;
    let turned = |x: f64, y: f64| (c * x - s * y, s * x + c * y);
    for row in a.iter_mut().chain(v.iter_mut()) {
        let row = row.as_mut();
        (row[p], row[q]) = turned(row[p], row[q]);
    }
    for k in 0..a.len() {
        let (x, y) = turned(a[p].as_ref()[k], a[q].as_ref()[k]);
        (a[p].as_mut()[k], a[q].as_mut()[k]) = (x, y);
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

    #[test]
    fn the_size_of_the_entries_does_not_matter() {
        let a = [[4.0, 1.0, -2.0], [1.0, 2.0, 0.5], [-2.0, 0.5, 3.0]];
        let (values, vectors) = symmetric_eigen(a);
        for size in [2_f64.powi(600), 2_f64.powi(-600)] {
            let sized = symmetric_eigen(a.map(|row| row.map(|x| size * x)));
            assert_eq!(sized, (values.map(|value| size * value), vectors));
        }
        assert_eq!(symmetric_eigen([[0.0; 2]; 2]), ([0.0; 2], [[1.0, 0.0], [0.0, 1.0]]));
    }

    #[test]
    fn a_matrix_of_any_size_comes_apart() {
        // Hilbert's, whose eigenvalues lie far apart.
        let a: Vec<Vec<f64>> = (0..6).map(|i| (0..6).map(|j| 1.0 / f64::from(i + j + 1)).collect()).collect();
        let (values, vectors) = symmetric_eigen_of(a.clone());
        assert!(values.is_sorted_by(|x, y| x >= y));
        for (value, x) in values.iter().zip(&vectors) {
            for r in 0..6 {
                let ax: f64 = (0..6).map(|c| a[r][c] * x[c]).sum();
                assert!((ax - value * x[r]).abs() < 1e-14);
            }
        }
        assert_eq!(symmetric_eigen_of(Vec::new()), (Vec::new(), Vec::new()));
    }
}
