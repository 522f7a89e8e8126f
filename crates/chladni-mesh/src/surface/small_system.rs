//! Small linear systems, as fits to a surface make them.

/// Solves A x = b for a small symmetric positive (semi-)definite A, by elimination; `None` where it is singular.
pub fn solve_small<const N: usize>(mut a: [[f64; N]; N], mut b: [f64; N]) -> Option<[f64; N]> {
    let scale: f64 = (0..N).map(|i| a[i][i]).fold(0.0, f64::max);
    for p in 0..N {
        let pivot = a[p][p];
        if pivot.is_nan() || pivot <= scale * 1e-14 {
            return None;
        }
        for r in p + 1..N {
            let f = a[r][p] / pivot;
            for c in p..N {
                a[r][c] -= f * a[p][c];
            }
            b[r] -= f * b[p];
        }
    }
    for p in (0..N).rev() {
        let tail: f64 = (p + 1..N).map(|c| a[p][c] * b[c]).sum();
        b[p] = (b[p] - tail) / a[p][p];
    }
    b.iter().all(|x| x.is_finite()).then_some(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_singular_system_is_refused() {
        assert_eq!(solve_small([[1.0, 1.0], [1.0, 1.0]], [1.0, 2.0]), None);
        let x = solve_small([[2.0, 1.0], [1.0, 3.0]], [3.0, 4.0]).unwrap();
        assert!((x[0] - 1.0).abs() < 1e-15 && (x[1] - 1.0).abs() < 1e-15);
    }
}
