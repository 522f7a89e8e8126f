//! ψ beside the same formula in numbers of twice the digits.

use chladni_testdata::DoubleDouble;

use super::*;
use crate::fixture::{bumpy_sphere, sphere_with_bumps, with_target};
use chladni_mesh::surface::vec3::length;

/// Bits that may be lost in the sums over all vertices, beyond what cancels in them.
const LOST: f64 = 16.0 * f64::EPSILON;

/// f̃_k, and the sum of the lengths that are added up in it.
fn transform(basis: &Basis, k: usize, signal: &[Vec3]) -> ([DoubleDouble; 3], f64) {
    let mut sum = [DoubleDouble::default(); 3];
    let mut size = 0.0;
    for ((a, h), f) in basis.mass.iter().zip(basis.harmonic(k)).zip(signal) {
        let weight = DoubleDouble::from(*a) * (*h).into();
        (0..3).for_each(|i| sum[i] = sum[i] + weight * f[i].into());
        size += a * h.abs() * length(*f);
    }
    (sum, size)
}

fn product(f: &[DoubleDouble; 3], g: &[DoubleDouble; 3]) -> DoubleDouble {
    (0..3).map(|i| f[i] * g[i]).sum()
}

/// Compares ψ of a shape, and returns for how many harmonics it is 0 because the shape has nothing of them.
fn compare(shape: (Arc<chladni_harmonics::Body>, Surface)) -> usize {
    let (_, _, base, target) = with_target(shape);
    let d = Difference::new(base, target).unwrap();
    let (basis, found) = (d.base.basis(), d.psi());
    let [of_shape, of_target] = [&d.base.positions, &d.target.points]
        .map(|f| (0..basis.harmonics()).map(|k| transform(basis, k, f)).collect::<Vec<_>>());
    let long = |f: &[DoubleDouble; 3]| product(f, f).sqrt().rounded();
    let waves = of_shape.iter().zip(&basis.eigenvalues).filter(|(_, lambda)| **lambda > 0.0);
    let largest = waves.map(|((x, _), _)| long(x)).fold(0.0, f64::max);
    let [mut below_xx, mut below_xd] = [DoubleDouble::default(); 2];
    let (mut worst, mut without): (f64, usize) = (0.0, 0);
    for (k, ((x, size_x), (r, size_r))) in of_shape.iter().zip(&of_target).enumerate() {
        let delta: [DoubleDouble; 3] = std::array::from_fn(|i| r[i] - x[i]);
        let (xx, xd) = (product(x, x), product(x, &delta));
        (below_xx, below_xd) = (below_xx + xx, below_xd + xd);
        let [long_x, long_d] = [x, &delta].map(long);
        let (is_constant, is_negligible) =
            (basis.eigenvalues[k] == 0.0, long_x <= NEGLIGIBLE_AMPLITUDE * largest);
        if is_constant || is_negligible {
            assert_eq!(found.psi[k], 0.0, "harmonic {k}");
            without += usize::from(!is_constant);
            continue;
        }
        let psi = xd / xx;
        let of_x = (long_d + 2.0 * psi.rounded().abs() * long_x) * size_x;
        let bound = LOST * (long_x * (size_x + size_r) + of_x) / xx.rounded();
        worst = worst.max(psi.error_of(found.psi[k]) / bound);
    }
    let sum = |g: &[Vec3]| {
        let terms = basis.mass.iter().zip(&d.base.positions).zip(g);
        let exact = |((a, x), g): ((&f64, &Vec3), &Vec3)| {
            DoubleDouble::from(*a) * product(&x.map(DoubleDouble::from), &g.map(DoubleDouble::from))
        };
        let size = terms.clone().map(|((a, x), g)| a * length(*x) * length(*g)).sum::<f64>();
        (terms.map(exact).sum::<DoubleDouble>(), size)
    };
    let ((xx, size_xx), (xd, size_xd)) = (sum(&d.base.positions), sum(&d.delta));
    let residual = (xd - below_xd) / (xx - below_xx);
    let bound = LOST * (size_xd + residual.rounded().abs() * size_xx) / (xx - below_xx).rounded();
    worst = worst.max(residual.error_of(found.residual) / bound);
    assert!(worst > 0.0 && worst <= 1.0, "{worst} times the bound");
    without
}

#[test]
fn psi_is_right_to_the_last_digits() {
    compare(bumpy_sphere());
    // A shape with three mirror planes has nothing of most harmonics.
    let mirrored = |p: &Vec3| 0.6 + 0.2 * (4.0 * p[1]).cos() + 0.15 * p[2] * p[2];
    let without = compare(sphere_with_bumps(mirrored));
    assert!((5..45).contains(&without), "{without} of 49");
}
