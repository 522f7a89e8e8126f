//! Where a layer acts: the painted signal χ01 and its low-pass χ.

use std::sync::Arc;

use chladni_harmonics::Basis;
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::difference::check_count;
use crate::painted_spectrum::PaintedSpectrum;
use crate::transform::synthesise;
use crate::vector::{Vec3, distance};
use crate::wavelength::{eigenvalue_of, wavelengths};

/// The part of the shape that a layer deforms.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// χ01, before smoothing.
    pub painted: Painted,
    /// How χ01 is smoothed to χ.
    pub smoothing: Smoothing,
}

/// χ01: the painted signal.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Painted {
    /// 1 everywhere; χ is 1 too, exactly.
    Everywhere,
    /// 1 inside any of the spheres, 0 outside.
    Spheres(Vec<Sphere>),
    /// A value in [0, 1] for each of the N operator vertices.
    Vertices(#[serde(with = "crate::runs")] Arc<[f32]>),
}

/// A ball in the coordinates of the shape's file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sphere {
    /// Centre, in file units.
    pub center: Vec3,
    /// Radius, in file units; positive.
    pub radius: f64,
}

/// The low-pass that turns χ01 into χ.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Smoothing {
    /// The wavelength, as a share of the shape's [`size`](crate::size), above which harmonics are kept
    /// (sharp), or whose harmonics are halved (Gaussian): longer is softer. The paper's nχ harmonics
    /// are a wavelength of about π/√nχ ([`usual_wavelength`](crate::usual_wavelength)); it uses 32, 96 and
    /// 192 of 512. Of a shape in several pieces each keeps its constant harmonic.
    pub wavelength: f64,
    /// The shape of the low-pass.
    pub roll_off: RollOff,
    /// Cuts χ to [0, 1]: a sharp cut rings below 0 and above 1.
    pub clamp: bool,
}

impl Default for Smoothing {
    /// 32 %, the paper's nχ = 96, with the Gaussian roll-off, clamped.
    fn default() -> Self {
        Self { wavelength: 0.32, roll_off: RollOff::Gaussian, clamp: true }
    }
}

/// How a low-pass ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RollOff {
    /// χ = Σ_{k<nχ} H_k χ̃01_k, as in the paper.
    Sharp,
    /// Heat flow: χ̃_k = χ̃01_k 2^(−λ_k/λ), λ that of the wavelength, which is halved; it does not ring.
    Gaussian,
}

impl Default for Region {
    fn default() -> Self {
        Self { painted: Painted::Everywhere, smoothing: Smoothing::default() }
    }
}

impl Region {
    /// χ, N values; `None` where it is 1 everywhere. `file_positions` of the operator vertices
    /// place the spheres; `spectrum` follows the painted signal.
    pub(crate) fn smoothed(
        &self,
        basis: &Basis,
        file_positions: &[Vec3],
        spectrum: &mut PaintedSpectrum,
    ) -> Result<Option<Arc<[f32]>>, Error> {
        if self.painted == Painted::Everywhere {
            return Ok(None);
        }
        let painted = self.painted.values(file_positions);
        check_count("the painted region", painted.len(), basis)?;
        let harmonics = self.smoothing.harmonics(basis);
        Ok(Some(self.smoothing.apply_to(basis, spectrum.follow(basis, &painted, harmonics))))
    }
}

impl PartialEq for Painted {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Everywhere, Self::Everywhere) => true,
            (Self::Spheres(a), Self::Spheres(b)) => a == b,
            // Windows compare projects every frame; equal values are nearly always shared.
            (Self::Vertices(a), Self::Vertices(b)) => Arc::ptr_eq(a, b) || a == b,
            _ => false,
        }
    }
}

impl Painted {
    /// χ01 on the operator vertices, whose positions in the file are `file_positions` (N).
    pub fn values(&self, file_positions: &[Vec3]) -> Arc<[f32]> {
        match self {
            Self::Everywhere => vec![1.0; file_positions.len()].into(),
            Self::Spheres(spheres) => spheres_to_vertices(spheres, file_positions),
            Self::Vertices(values) => values.clone(),
        }
    }
}

fn spheres_to_vertices(spheres: &[Sphere], file_positions: &[Vec3]) -> Arc<[f32]> {
    let inside = |p: &Vec3| spheres.iter().any(|s| distance(*p, s.center) <= s.radius);
    file_positions.iter().map(|p| if inside(p) { 1.0 } else { 0.0 }).collect()
}

impl Smoothing {
    /// χ of a painted signal with one value per operator vertex.
    pub fn apply(&self, basis: &Basis, painted: &[f32]) -> Arc<[f32]> {
        self.apply_to(basis, PaintedSpectrum::default().follow(basis, painted, self.harmonics(basis)))
    }

    /// χ of the signal whose transform is `spectrum`, at least as long as the low-pass.
    pub(crate) fn apply_to(&self, basis: &Basis, spectrum: &[f64]) -> Arc<[f32]> {
        let weights = self.weights(basis);
        let low: Vec<[f64; 1]> = spectrum.iter().zip(&weights).map(|(c, w)| [c * w]).collect();
        let mut smooth = vec![0.0_f32; basis.vertices()];
        synthesise(basis, &low, &mut smooth, |_, [sum], out| {
            *out = if self.clamp { sum.clamp(0.0, 1.0) as f32 } else { sum as f32 };
        });
        smooth.into()
    }

    /// How many harmonics pass.
    pub(crate) fn harmonics(&self, basis: &Basis) -> usize {
        self.weights(basis).len()
    }

    /// The gain of each harmonic that passes.
    fn weights(&self, basis: &Basis) -> Vec<f64> {
        match self.roll_off {
            RollOff::Sharp => {
                let waves = wavelengths(basis);
                waves.into_iter().take_while(|w| *w > self.wavelength).map(|_| 1.0).collect()
            }
            RollOff::Gaussian => {
                let cut = eigenvalue_of(basis, self.wavelength);
                let gain = basis.eigenvalues.iter().map(|l| (-l.max(0.0) / cut).exp2());
                // What is below a 500th no brush stroke shows.
                gain.take_while(|w| *w > 2e-3).collect()
            }
        }
    }
}

/// `x,y,z,radius` in file units.
impl std::str::FromStr for Sphere {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let bad = |why: &str| Error::syntax("region", text, why);
        let numbers: Vec<f64> = text
            .split(',')
            .map(|t| t.trim().parse().map_err(|_| bad("write it as x,y,z,radius")))
            .collect::<Result<_, _>>()?;
        let [x, y, z, radius] = numbers[..] else { return Err(bad("write it as x,y,z,radius")) };
        if !numbers.iter().all(|c| c.is_finite()) || radius <= 0.0 {
            return Err(bad("the numbers must be finite and the radius positive"));
        }
        Ok(Self { center: [x, y, z], radius })
    }
}

impl std::fmt::Display for Sphere {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y, z] = self.center;
        write!(f, "{x},{y},{z},{}", self.radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::bumpy_sphere;

    fn half(body: &chladni_harmonics::Body) -> Vec<f32> {
        body.positions.iter().map(|p| if p[0] > 0.1 { 1.0 } else { 0.0 }).collect()
    }

    #[test]
    fn a_sharp_cut_is_the_projection_on_the_first_harmonics() {
        let (body, _) = bumpy_sphere();
        let painted = half(&body);
        let wavelength = wavelengths(&body.basis)[16];
        let sharp = Smoothing { wavelength, roll_off: RollOff::Sharp, clamp: false };
        let chi = sharp.apply(&body.basis, &painted);
        let signal: Vec<f64> = painted.iter().map(|x| f64::from(*x)).collect();
        let expected = body.basis.synthesize(&body.basis.transform(&signal)[..16]);
        chi.iter().zip(expected).for_each(|(a, b)| assert!((f64::from(*a) - b).abs() < 1e-6));
        assert!(chi.iter().any(|c| *c < 0.0) && chi.iter().any(|c| *c > 1.0), "a sharp cut rings");
        let clamped = Smoothing { clamp: true, ..sharp }.apply(&body.basis, &painted);
        assert!(clamped.iter().all(|c| (0.0..=1.0).contains(c)));
    }

    #[test]
    fn the_gaussian_halves_its_cutoff_and_rings_less() {
        let (body, _) = bumpy_sphere();
        let painted = half(&body);
        let wavelength = wavelengths(&body.basis)[16];
        let low_pass = |roll_off| Smoothing { wavelength, roll_off, clamp: false };
        let weights = low_pass(RollOff::Gaussian).weights(&body.basis);
        assert!((weights[16] - 0.5).abs() < 1e-12 && weights[0] == 1.0);
        let ringing = |chi: Arc<[f32]>| chi.iter().map(|c| (-c).max(c - 1.0)).fold(0.0_f32, f32::max);
        let sharp = ringing(low_pass(RollOff::Sharp).apply(&body.basis, &painted));
        let gaussian = ringing(low_pass(RollOff::Gaussian).apply(&body.basis, &painted));
        assert!(gaussian < 0.5 * sharp, "{gaussian} against {sharp}");
    }

    #[test]
    fn everything_painted_stays_one() {
        let (body, _) = bumpy_sphere();
        let all = vec![1.0; body.positions.len()];
        for roll_off in [RollOff::Sharp, RollOff::Gaussian] {
            let smoothing = Smoothing { roll_off, clamp: false, ..Smoothing::default() };
            let chi = smoothing.apply(&body.basis, &all);
            assert!(chi.iter().all(|c| (c - 1.0).abs() < 1e-6));
        }
    }

    #[test]
    fn a_sphere_is_parsed_as_printed() {
        let sphere: Sphere = "1, -2.5,3e1,0.25".parse().unwrap();
        assert_eq!(sphere.to_string().parse::<Sphere>().unwrap(), sphere);
        for bad in ["", "1,2,3", "1,2,3,0", "1,2,3,-1", "a,2,3,1", "1,2,3,inf", "1,2,3,4,5"] {
            assert!(bad.parse::<Sphere>().is_err(), "{bad}");
        }
    }
}
