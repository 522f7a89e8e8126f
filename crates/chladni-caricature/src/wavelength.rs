//! One unit for every scale of detail: the wavelength, as a share of the shape's size.

use std::f64::consts::{PI, TAU};

use chladni_harmonics::Basis;

/// The size that wavelengths are a share of: √(A/π), the diameter of the ball with as much surface, in the
/// working frame. It depends neither on the number of harmonics nor on the shape's rotation.
pub fn size(basis: &Basis) -> f64 {
    (basis.mass.iter().sum::<f64>() / PI).sqrt()
}

/// The wavelength 2π/√λ_k of every harmonic as a share of the [`size`], K values, falling; infinite where
/// λ_k = 0. A bump of the surface is half a wave.
pub fn wavelengths(basis: &Basis) -> Vec<f64> {
    let size = size(basis);
    basis.eigenvalues.iter().map(|l| if *l > 0.0 { TAU / (l.sqrt() * size) } else { f64::INFINITY }).collect()
}

/// The eigenvalue whose harmonics have this wavelength.
pub fn eigenvalue_of(basis: &Basis, wavelength: f64) -> f64 {
    (TAU / (wavelength * size(basis))).powi(2)
}

/// π/√k, close to the wavelength of harmonic k > 0 on every closed shape: by Weyl's law λ_k ≈ 4πk/A. About k harmonics
/// have longer waves: on a sphere, where many share one, 36 for k = 32, 100 for 96 and 196 for 192; more where the surface
/// has borders.
pub fn usual_wavelength(k: f64) -> f64 {
    PI / k.sqrt()
}

/// A wavelength as it is typed: percent of the size, `30%`.
pub fn parse_wavelength(text: &str) -> Option<f64> {
    let percent: f64 = text.trim().strip_suffix('%')?.trim().parse().ok()?;
    (percent.is_finite() && percent > 0.0).then_some(percent / 100.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_harmonics::{BasisSettings, Body};
    use chladni_mesh::samples::icosphere;
    use chladni_task::Task;

    #[test]
    fn the_waves_of_a_ball_are_known_and_follow_no_k_and_no_scale() {
        let ball = icosphere(3);
        let mut larger = ball.clone();
        larger.positions.iter_mut().flatten().for_each(|c| *c = 25.4 * *c + 3.0);
        let of = |mesh, harmonics| {
            let body = Body::build(mesh, &BasisSettings::new(harmonics), &Task::new()).unwrap();
            wavelengths(&body.basis)
        };
        let (few, many) = (of(&ball, 36), of(&larger, 100));
        assert_eq!(few[0], f64::INFINITY);
        for (k, (a, b)) in few.iter().zip(&many).enumerate().skip(1) {
            // λ = l(l + 1) on the unit sphere, whose diameter is 2.
            let l = (k as f64).sqrt().floor();
            let exact = PI / (l * (l + 1.0)).sqrt();
            assert!((a - b).abs() < 1e-6 * a && (a - exact).abs() < 0.03 * exact, "{k}: {a}, {b}, {exact}");
        }
        assert!((usual_wavelength(64.0) / many[64] - 1.0).abs() < 0.1);
        // About 32: all of l < 6.
        assert_eq!(many.iter().filter(|wave| **wave > usual_wavelength(32.0)).count(), 36);
    }

    #[test]
    fn wavelengths_are_typed_in_percent() {
        assert_eq!(parse_wavelength(" 32 %"), Some(0.32));
        for bad in ["0.32", "32", "%", "0%", "-3%", "nan%", "inf%"] {
            assert_eq!(parse_wavelength(bad), None, "{bad}");
        }
    }
}
