//! Orthonormalizes blocks of eight columns.

use super::tall::{BLOCK, Small, multiply_right, overlap};
use crate::ldlt::Row;

/// Why a block could not be orthonormalized.
pub(super) enum Dependence {
    /// The columns are dependent; X is unchanged.
    Found,
    /// The columns are so nearly dependent that rounding has spoiled X.
    Spoiled,
}

/// Replaces X by Q of X = Q R, by Cholesky on XᵀX, twice (Yamamoto et al. 2015). Columns count as dependent
/// if the diagonal of R is not above `limits`. Returns R.
pub(super) fn orthonormalize(x: &mut [Row], limits: &Row) -> Result<Small, Dependence> {
    let (first, inverse) = cholesky(&overlap(x, x)).ok_or(Dependence::Found)?;
    if (0..BLOCK).any(|j| first[j][j] <= limits[j]) {
        return Err(Dependence::Found);
    }
    multiply_right(x, &inverse);
    let (second, inverse) = cholesky(&overlap(x, x)).ok_or(Dependence::Spoiled)?;
    multiply_right(x, &inverse);
    Ok(product(&second, &first))
}

/// The upper triangular R with RᵀR = G, and its inverse.
fn cholesky(gram: &Small) -> Option<(Small, Small)> {
    let mut r = [[0.0; 8]; BLOCK];
    for i in 0..BLOCK {
        let sum: f64 = (0..i).map(|k| r[k][i] * r[k][i]).sum();
        let pivot = gram[i][i] - sum;
        if pivot.is_nan() || pivot <= 1e-24 * gram[i][i] || gram[i][i] < f64::MIN_POSITIVE {
            return None;
        }
        let root = pivot.sqrt();
        r[i][i] = root;
        for j in i + 1..BLOCK {
            let sum: f64 = (0..i).map(|k| r[k][i] * r[k][j]).sum();
            r[i][j] = (gram[i][j] - sum) / root;
        }
    }
    let mut inverse = [[0.0; 8]; BLOCK];
    for j in 0..BLOCK {
        inverse[j][j] = 1.0 / r[j][j];
        for i in (0..j).rev() {
            let sum: f64 = (i + 1..=j).map(|k| r[i][k] * inverse[k][j]).sum();
            inverse[i][j] = -sum / r[i][i];
        }
    }
    Some((r, inverse))
}

fn product(a: &Small, b: &Small) -> Small {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..BLOCK).map(|k| a[i][k] * b[k][j]).sum()))
}
