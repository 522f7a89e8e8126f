//! Where a layer acts: the painted signal χ01 and its low-pass χ.

use std::sync::Arc;

use chladni_harmonics::{Basis, Body};
use serde::{Deserialize, Serialize};

use crate::painted_spectrum::PaintedSpectrum;
use crate::softening::Softening;
use crate::wavelength::{eigenvalue_of, wavelengths};
use crate::{CaricatureError, Surface};
use chladni_mesh::surface::vec3::{Vec3, distance};

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

impl Painted {
    /// From a value in [0, 1] for each vertex of the file, and each one's operator vertex
    /// (`chladni_mesh::weld`). Vertices in one place take the largest of theirs.
    pub fn of_file(values: impl IntoIterator<Item = f32>, operator_vertex: &[Option<u32>]) -> Self {
        let vertices = operator_vertex.iter().flatten().max().map_or(0, |last| *last as usize + 1);
        let mut painted = vec![0.0_f32; vertices];
        for (value, vertex) in values.into_iter().zip(operator_vertex) {
            if let Some(own) = vertex.and_then(|v| painted.get_mut(v as usize)) {
                *own = own.max(value);
            }
        }
        Self::Vertices(Arc::from(painted))
    }

    /// How many values a file holds of it.
    pub(crate) fn stored_values(&self) -> usize {
        match self {
            Self::Everywhere | Self::Spheres(_) => 0,
            Self::Vertices(values) => values.len(),
        }
    }
}

/// A ball in the coordinates of the shape's file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sphere {
    /// Center, in file units.
    pub center: Vec3,
    /// Radius, in file units; positive.
    pub radius: f64,
}

/// The low-pass that turns χ01 into χ.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Smoothing {
    /// The wavelength, as a share of the shape's [`size`](crate::size), above which harmonics are kept
    /// (sharp), or whose harmonics are halved (heat): longer is softer. The paper's nχ harmonics are a
    /// wavelength of about π/√nχ ([`usual_wavelength`](crate::usual_wavelength)); it uses 32, 96 and 192 of
    /// 512. Each piece of a shape keeps its constant harmonic.
    pub wavelength: f64,
    /// The shape of the low-pass.
    pub roll_off: RollOff,
    /// Clamps χ to [0, 1] after a sharp cutoff, which rings below 0 and above 1. Heat never leaves that
    /// range.
    pub clamp: bool,
}

impl Default for Smoothing {
    /// 32 %, about the paper's nχ = 96, by heat.
    fn default() -> Self {
        Self { wavelength: 0.32, roll_off: RollOff::Heat, clamp: true }
    }
}

/// The shape of a low-pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RollOff {
    /// χ = Σ_{k<nχ} H_k χ̃01_k, as in the paper, where nχ harmonics have longer waves than the wavelength. It rings.
    Sharp,
    /// One implicit step of the heat equation, χ = (M + tS)⁻¹ M χ01 with t = 1/λ, λ that of the
    /// wavelength: all of the spectrum takes part, and harmonic k is multiplied by 1 / (1 + λ_k/λ).
    /// χ is an average of χ01, so that it never rings.
    Heat,
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
        softening: &mut Softening,
    ) -> Result<Option<Arc<[f32]>>, CaricatureError> {
        if self.painted == Painted::Everywhere {
            return Ok(None);
        }
        let painted = self.painted.values(file_positions);
        check_painted(painted.len(), basis.vertices())?;
        self.smoothing.apply_with(basis, &painted, spectrum, softening).map(Some)
    }
}

/// Checks that there are as many painted values as the shape has vertices.
pub(crate) fn check_painted(found: usize, expected: usize) -> Result<(), CaricatureError> {
    if found == expected { Ok(()) } else { Err(CaricatureError::PaintedElsewhere { found, expected }) }
}

impl PartialEq for Painted {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Everywhere, Self::Everywhere) => true,
            (Self::Spheres(a), Self::Spheres(b)) => a == b,
            // The window compares projects every frame; equal values are nearly always the same allocation.
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
    /// χ of a painted signal with one value per operator vertex of `body`. This computes everything each
    /// time; a [`Stack`](crate::Stack) caches it.
    ///
    /// # Errors
    /// A signal of another number of values; a surface on which no heat flows.
    pub fn apply(&self, body: &Arc<Body>, painted: &[f32]) -> Result<Arc<[f32]>, CaricatureError> {
        check_painted(painted.len(), body.basis.vertices())?;
        let mut softening = Softening::of(Arc::new(Surface::new(body)));
        self.apply_with(&body.basis, painted, &mut PaintedSpectrum::default(), &mut softening)
    }

    fn apply_with(
        &self,
        basis: &Basis,
        painted: &[f32],
        spectrum: &mut PaintedSpectrum,
        softening: &mut Softening,
    ) -> Result<Arc<[f32]>, CaricatureError> {
        match self.roll_off {
            RollOff::Heat => {
                let smooth = softening.step(self.heat_time(basis))?.apply(painted);
                // Rounding alone can leave the range.
                Ok(smooth.into_iter().map(|x| x.clamp(0.0, 1.0) as f32).collect())
            }
            RollOff::Sharp => {
                let waves = wavelengths(basis);
                let passing = waves.iter().take_while(|w| **w > self.wavelength).count().max(1);
                let low = spectrum.follow(basis, painted, passing).iter().take(passing);
                let low: Vec<[f64; 1]> = low.map(|c| [*c]).collect();
                let mut smooth = vec![0.0_f32; basis.vertices()];
                basis.synthesize_each(&low, &mut smooth, |_, [sum], out| {
                    *out = if self.clamp { sum.clamp(0.0, 1.0) as f32 } else { sum as f32 };
                });
                Ok(smooth.into())
            }
        }
    }

    /// t = 1/λ, the length of the heat step that halves harmonics of the wavelength.
    fn heat_time(&self, basis: &Basis) -> f64 {
        1.0 / eigenvalue_of(basis, self.wavelength).max(LOWEST_WAVE)
    }
}

/// Far below the λ of any wave on a shape of the working frame's size: heat then levels whole pieces.
const LOWEST_WAVE: f64 = 1e-4;

/// `x,y,z,radius` in file units.
impl std::str::FromStr for Sphere {
    type Err = CaricatureError;

    fn from_str(text: &str) -> Result<Self, CaricatureError> {
        let bad = |why: &str| CaricatureError::syntax("region", text, why);
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

    fn half(body: &Body) -> Vec<f32> {
        body.positions.iter().map(|p| if p[0] > 0.1 { 1.0 } else { 0.0 }).collect()
    }

    #[test]
    fn a_sharp_cut_is_the_projection_on_the_first_harmonics_and_rings() {
        let (body, _) = bumpy_sphere();
        let painted = half(&body);
        let wavelength = wavelengths(&body.basis)[16];
        let sharp = Smoothing { wavelength, roll_off: RollOff::Sharp, clamp: false };
        let chi = sharp.apply(&body, &painted).unwrap();
        let signal: Vec<f64> = painted.iter().map(|x| f64::from(*x)).collect();
        let expected = body.basis.synthesize(&body.basis.transform(&signal)[..16]);
        chi.iter().zip(expected).for_each(|(a, b)| assert!((f64::from(*a) - b).abs() < 1e-6));
        assert!(chi.iter().any(|c| *c < 0.0) && chi.iter().any(|c| *c > 1.0), "a sharp cut rings");
        let clamped = Smoothing { clamp: true, ..sharp }.apply(&body, &painted).unwrap();
        assert!(clamped.iter().all(|c| (0.0..=1.0).contains(c)));
    }

    /// A rock with harmonics of its own.
    fn rock() -> Arc<Body> {
        let mut mesh = chladni_mesh::samples::icosphere(3);
        for p in &mut mesh.positions {
            let bump = 1.0 + 0.3 * (3.0 * p[0]).sin() * p[1] + 0.1 * (7.0 * p[2]).cos();
            *p = chladni_mesh::surface::vec3::scaled(*p, bump);
        }
        let settings = chladni_harmonics::BasisSettings::new(64);
        Arc::new(Body::build(&mesh, &settings, &chladni_task::Task::new()).unwrap())
    }

    #[test]
    fn heat_never_rings_and_halves_its_cutoff() {
        let body = rock();
        let painted = half(&body);
        let plain: Vec<f64> = painted.iter().map(|x| f64::from(*x)).collect();
        let before = body.basis.transform(&plain);
        let waves = wavelengths(&body.basis);
        let chosen = [1, 4, 16, 63].map(|k| (waves[k], Some(k)));
        for (wavelength, halved) in chosen.into_iter().chain([(1e-3, None), (40.0, None), (1e30, None)]) {
            let heat = Smoothing { wavelength, roll_off: RollOff::Heat, clamp: false };
            // The step itself, before anything could be clamped.
            let mut softening = Softening::of(Arc::new(Surface::new(&body)));
            let chi = softening.step(heat.heat_time(&body.basis)).unwrap().apply(&painted);
            assert!(chi.iter().all(|c| *c >= 0.0 && *c <= 1.0 + 1e-12), "{wavelength}");
            let after = body.basis.transform(&chi);
            if let Some(k) = halved {
                assert!((after[k] - 0.5 * before[k]).abs() < 1e-9, "{wavelength}");
            }
            let by_heat = heat.apply(&body, &painted).unwrap();
            assert!(by_heat.iter().zip(&chi).all(|(a, b)| (f64::from(*a) - b).abs() < 1e-6));
        }
    }

    #[test]
    fn a_region_of_other_vertices_says_why_it_may_be_and_what_to_do() {
        let (body, _) = bumpy_sphere();
        let refused = Smoothing::default().apply(&body, &[1.0; 3]).unwrap_err().to_string();
        assert!(refused.contains("has 3 values") && refused.ends_with("paint the region again"), "{refused}");
    }

    #[test]
    fn a_longer_wavelength_is_softer() {
        let body = rock();
        let painted = half(&body);
        let steepest = |wavelength| {
            let chi = Smoothing { wavelength, ..Smoothing::default() }.apply(&body, &painted).unwrap();
            let sides = body.triangles.iter().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
            sides.map(|[a, b]| (chi[*a as usize] - chi[*b as usize]).abs()).fold(0.0, f32::max)
        };
        let steep = [0.1, 0.3, 0.9, 3.0].map(steepest);
        assert!(steep.windows(2).all(|pair| pair[0] > 1.3 * pair[1]), "{steep:?}");
    }

    #[test]
    fn everything_painted_stays_one() {
        let body = rock();
        let all = vec![1.0; body.positions.len()];
        for roll_off in [RollOff::Sharp, RollOff::Heat] {
            let smoothing = Smoothing { roll_off, clamp: false, ..Smoothing::default() };
            let chi = smoothing.apply(&body, &all).unwrap();
            assert!(chi.iter().all(|c| (c - 1.0).abs() < 1e-6));
        }
    }

    #[test]
    fn a_signal_of_another_shape_is_an_error() {
        let (body, _) = bumpy_sphere();
        assert!(Smoothing::default().apply(&body, &[1.0; 3]).is_err());
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
