//! The difference between a shape and its template, as signals and in harmonics.

use std::sync::{Arc, OnceLock};

use chladni_harmonics::Basis;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::{CaricatureError, Surface};
use chladni_mesh::surface::vec3::{Vec3, add, dot, scaled, sub};

#[cfg(test)]
mod precision;

/// The three harmonic representations of a difference (section 4 of the paper).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Model {
    /// X = x^δ: a strict morph, equation (4).
    Coordinate,
    /// X = ξ n: along the normal of the shape, equation (5).
    Normal,
    /// X = ψ x: the one scalar filter of the shape that comes closest, equation (6).
    Distance,
}

impl Model {
    /// All three, in the order of the paper.
    pub const ALL: [Self; 3] = [Self::Coordinate, Self::Normal, Self::Distance];

    /// The strongest exaggeration that the paper uses with it; the distance model's would tear the shape in
    /// the others.
    pub fn strongest_usual_mu(self) -> f64 {
        if self == Self::Distance { -8.0 } else { -2.4 }
    }

    /// The μ of the paper's results: −8 for the distance model, for the others the weak end of −0.8 … −2.4.
    pub fn paper_mu(self) -> f64 {
        if self == Self::Distance { -8.0 } else { -0.8 }
    }
}

impl std::fmt::Display for Model {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Coordinate => "coordinate",
            Self::Normal => "normal",
            Self::Distance => "distance",
        })
    }
}

impl std::str::FromStr for Model {
    type Err = CaricatureError;

    fn from_str(text: &str) -> Result<Self, CaricatureError> {
        let model = Self::ALL.into_iter().find(|m| m.to_string() == text);
        model.ok_or_else(|| CaricatureError::syntax("model", text, "must be coordinate, normal or distance"))
    }
}

/// A shape that a layer starts from: positions of the N operator vertices and, once asked for,
/// their normals and transform.
#[derive(Debug)]
pub struct Base {
    basis: Arc<Basis>,
    surface: Arc<Surface>,
    /// x(v), N, working frame.
    pub positions: Vec<Vec3>,
    normals: OnceLock<Vec<Vec3>>,
    spectrum: OnceLock<Vec<Vec3>>,
}

impl Base {
    /// The shape whose vertices lie at `positions`, on the connectivity of `surface` and the
    /// harmonics of `basis`.
    ///
    /// # Errors
    /// Another number of positions than vertices.
    pub fn new(
        basis: Arc<Basis>,
        surface: Arc<Surface>,
        positions: Vec<Vec3>,
    ) -> Result<Self, CaricatureError> {
        check_count("the shape's positions", positions.len(), &basis)?;
        check_count("the surface", surface.vertices(), &basis)?;
        Ok(Self { basis, surface, positions, normals: OnceLock::new(), spectrum: OnceLock::new() })
    }

    /// This shape with its vertices moved by `displacement` (N).
    pub(crate) fn moved(&self, displacement: &[Vec3]) -> Self {
        let positions = self.positions.par_iter().zip(displacement).map(|(x, d)| add(*x, *d)).collect();
        let (basis, surface) = (self.basis.clone(), self.surface.clone());
        Self { basis, surface, positions, normals: OnceLock::new(), spectrum: OnceLock::new() }
    }

    /// n(v), N area-weighted unit normals; zero where undefined.
    pub fn normals(&self) -> &[Vec3] {
        self.normals.get_or_init(|| self.surface.normals(&self.positions))
    }

    /// x̃_k, K×3.
    pub fn spectrum(&self) -> &[Vec3] {
        self.spectrum.get_or_init(|| self.basis.analyze(self.basis.harmonics(), |v| self.positions[v]))
    }

    /// The harmonics all this is expressed in.
    pub fn basis(&self) -> &Arc<Basis> {
        &self.basis
    }
}

/// x^r: for each operator vertex its point on the template, working frame.
#[derive(Debug)]
pub struct Target {
    /// x^r(v), N.
    pub points: Vec<Vec3>,
    spectrum: OnceLock<Vec<Vec3>>,
    source: Source,
}

/// Where the transform of a target comes from.
#[derive(Debug)]
enum Source {
    Points(Arc<Basis>),
    Scaled(Arc<Base>, f64),
    LowPass(Arc<Base>, usize),
}

impl Target {
    /// Matched points, one per operator vertex; finite.
    ///
    /// # Errors
    /// Another number of points than vertices, or one that is not finite.
    pub fn new(basis: Arc<Basis>, points: Vec<Vec3>) -> Result<Self, CaricatureError> {
        check_count("the template's points", points.len(), &basis)?;
        if let Some(bad) = points.iter().flatten().find(|c| !c.is_finite()) {
            return Err(CaricatureError::Range {
                what: "a point of the template",
                value: *bad,
                range: "finite",
            });
        }
        Ok(Self { points, spectrum: OnceLock::new(), source: Source::Points(basis) })
    }

    /// The base itself, scaled by `factor` about the origin of the working frame.
    pub fn scaled(base: Arc<Base>, factor: f64) -> Self {
        let points = base.positions.iter().map(|p| scaled(*p, factor)).collect();
        Self { points, spectrum: OnceLock::new(), source: Source::Scaled(base, factor) }
    }

    /// The base itself without its harmonics from `cutoff` on and without its residual; the
    /// constants of all its pieces count as one harmonic.
    ///
    /// # Errors
    /// A `cutoff` that is 0 or above K; several pieces and no harmonics but their constants.
    pub fn low_passed(base: Arc<Base>, cutoff: usize) -> Result<Self, CaricatureError> {
        check_low_pass(cutoff, &base.basis)?;
        let cutoff = base.basis.harmonics_below(cutoff);
        let mut points = vec![[0.0; 3]; base.positions.len()];
        let spectrum = base.spectrum();
        base.basis.synthesize_each(&spectrum[..cutoff], &mut points, |_, low, p| *p = low);
        Ok(Self { points, spectrum: OnceLock::new(), source: Source::LowPass(base, cutoff) })
    }

    /// x̃^r_k, K×3.
    pub fn spectrum(&self) -> &[Vec3] {
        self.spectrum.get_or_init(|| match &self.source {
            Source::Points(basis) => basis.analyze(basis.harmonics(), |v| self.points[v]),
            Source::Scaled(base, factor) => base.spectrum().iter().map(|c| scaled(*c, *factor)).collect(),
            Source::LowPass(base, cutoff) => {
                let low = base.spectrum().iter().enumerate();
                low.map(|(k, c)| if k < *cutoff { *c } else { [0.0; 3] }).collect()
            }
        })
    }
}

/// x^δ = x^r − x of one base and one template, with everything the three models need.
///
/// Transforms are computed when first asked for and kept; [`prepare`](Self::prepare) computes
/// those of several models in a single pass over H.
#[derive(Debug)]
pub struct Difference {
    /// The shape x that the difference starts from.
    pub base: Arc<Base>,
    /// The template's points x^r.
    pub target: Arc<Target>,
    /// x^δ(v), N.
    pub delta: Vec<Vec3>,
    xi: OnceLock<Vec<f64>>,
    delta_spectrum: OnceLock<Vec<Vec3>>,
    xi_spectrum: OnceLock<Vec<f64>>,
    psi: OnceLock<Psi>,
}

/// The scales of a difference, as one model sees it; the sum of their squares is the energy Σ_v a(v) ‖X(v)‖².
#[derive(Clone, Debug, PartialEq)]
pub struct Amplitudes {
    /// ‖X̃_k‖, K.
    pub harmonics: Vec<f64>,
    /// The length of the residual dX, area-weighted.
    pub residual: f64,
}

/// The distance-minimizing filter.
#[derive(Clone, Debug, PartialEq)]
pub struct Psi {
    /// ψ_k, K; 0 where λ_k = 0 and where the shape has no amplitude of its own.
    pub psi: Vec<f64>,
    /// ψ_d, the filter above K.
    pub residual: f64,
}

/// Amplitudes ‖x̃_k‖ below this share of the largest are rounding or the error of the
/// eigensolver, and a ratio by them means nothing.
const NEGLIGIBLE_AMPLITUDE: f64 = 1e-8;

impl Difference {
    /// The difference between `base` and `target`, both on the same vertices.
    ///
    /// # Errors
    /// Shapes of different numbers of vertices.
    pub fn new(base: Arc<Base>, target: Arc<Target>) -> Result<Self, CaricatureError> {
        check_count("the template's points", target.points.len(), &base.basis)?;
        let pairs = target.points.par_iter().zip(&base.positions);
        let delta: Vec<Vec3> = pairs.map(|(r, x)| sub(*r, *x)).collect();
        let (delta_spectrum, xi, xi_spectrum) = (OnceLock::new(), OnceLock::new(), OnceLock::new());
        Ok(Self { base, target, delta, xi, delta_spectrum, xi_spectrum, psi: OnceLock::new() })
    }

    /// ξ(v) = ⟨x^δ(v), n(v)⟩, N.
    pub fn xi(&self) -> &[f64] {
        self.xi.get_or_init(|| {
            let pairs = self.delta.par_iter().zip(self.base.normals());
            pairs.map(|(d, n)| dot(*d, *n)).collect()
        })
    }

    /// Computes all missing transforms that the three models need, in one pass.
    pub fn prepare(&self) {
        self.xi_spectrum();
        self.psi();
    }

    /// x̃^δ_k = x̃^r_k − x̃_k, K×3. Correspondences are kept from layer to layer, so that a new
    /// base costs one transform, of x.
    pub fn delta_spectrum(&self) -> &[Vec3] {
        self.delta_spectrum.get_or_init(|| {
            let (r, x) = (self.target.spectrum(), self.base.spectrum());
            r.iter().zip(x).map(|(r, x)| sub(*r, *x)).collect()
        })
    }

    /// ξ̃_k, K. If the base's transform is missing, it is computed in the same pass.
    pub fn xi_spectrum(&self) -> &[f64] {
        let basis = &self.base.basis;
        let (k, xi) = (basis.harmonics(), self.xi());
        self.xi_spectrum.get_or_init(|| {
            if self.base.spectrum.get().is_some() {
                return basis.analyze(k, |v| [xi[v]]).iter().map(|c| c[0]).collect();
            }
            let x = &self.base.positions;
            let both = basis.analyze(k, |v| [x[v][0], x[v][1], x[v][2], xi[v]]);
            // Another thread may have been first; its values are the same.
            let _ = self.base.spectrum.set(both.iter().map(|c| [c[0], c[1], c[2]]).collect());
            both.iter().map(|c| c[3]).collect()
        })
    }

    /// ψ_k and ψ_d: the minimum of ½ Σ_v a(v) ‖φx(v) − x^δ(v)‖² (appendix A, area-weighted).
    pub fn psi(&self) -> &Psi {
        self.psi.get_or_init(|| self.minimize_distance())
    }

    fn minimize_distance(&self) -> Psi {
        let (x, d) = (self.base.spectrum(), self.delta_spectrum());
        // Where λ = 0 a harmonic is constant on each piece of the shape. Its amplitude says where the piece
        // lies, not what it looks like: for a single piece it is the distance between two kinds of centroid,
        // and filtering it would translate the piece in that arbitrary direction. So every piece keeps its
        // place.
        let waves = self.base.basis.eigenvalues.iter().map(|lambda| *lambda > 0.0);
        let squares: Vec<f64> =
            x.iter().zip(waves).map(|(x, waves)| if waves { dot(*x, *x) } else { 0.0 }).collect();
        let largest = squares.iter().copied().fold(0.0, f64::max);
        let negligible = largest * NEGLIGIBLE_AMPLITUDE * NEGLIGIBLE_AMPLITUDE;
        let ratio = |((x, d), square): ((&Vec3, &Vec3), &f64)| {
            if *square > negligible { dot(*x, *d) / square } else { 0.0 }
        };
        let psi = x.iter().zip(d).zip(&squares).map(ratio).collect();
        // Σ a⟨dx, dx^δ⟩ = Σ a⟨x, x^δ⟩ − Σ_k⟨x̃_k, x̃^δ_k⟩ (Parseval), so that neither residual
        // has to be formed.
        let mass = &self.base.basis.mass;
        // Sequentially: parallel sums would differ in their last bits from run to run.
        let (mut xx, mut xd) = (0.0, 0.0);
        for ((x, d), a) in self.base.positions.iter().zip(&self.delta).zip(mass) {
            xx += a * dot(*x, *x);
            xd += a * dot(*x, *d);
        }
        let below = |f: &[Vec3]| x.iter().zip(f).map(|(x, f)| dot(*x, *f)).sum::<f64>();
        let (residual_xx, residual_xd) = (xx - below(x), xd - below(d));
        // Where all harmonics are constants, those of further pieces may be missing: the residual would say where they lie.
        let basis = &self.base.basis;
        let is_torn = basis.harmonics() > 1 && basis.constants() == basis.harmonics();
        let noise = xx * self.base.basis.certificate.max_orthogonality_error.max(1e-13) * 10.0;
        let has_residual = residual_xx > noise && !is_torn;
        Psi { psi, residual: if has_residual { residual_xd / residual_xx } else { 0.0 } }
    }

    /// dx^δ(v), N: the part of x^δ above K.
    pub fn delta_residual(&self) -> Vec<Vec3> {
        residual(&self.base.basis, &self.delta, self.delta_spectrum())
    }

    /// dx(v), N: the part of the shape above K.
    pub fn shape_residual(&self) -> Vec<Vec3> {
        residual(&self.base.basis, &self.base.positions, self.base.spectrum())
    }

    /// dξ(v), N: the part of ξ above K.
    pub fn xi_residual(&self) -> Vec<f64> {
        let mut out = self.xi().to_vec();
        let coefficients: Vec<[f64; 1]> = self.xi_spectrum().iter().map(|c| [*c]).collect();
        self.base.basis.synthesize_each(&coefficients, &mut out, |_, [low], xi| *xi -= low);
        out
    }

    /// How much of every scale `model` exaggerates, before curve, region and μ: what is drawn behind the
    /// scale curve.
    pub fn amplitudes(&self, model: Model) -> Amplitudes {
        let length = |c: &Vec3| dot(*c, *c).sqrt();
        let mass = &self.base.basis.mass;
        let energy = |f: &[Vec3]| f.iter().zip(mass).map(|(f, a)| a * dot(*f, *f)).sum::<f64>();
        match model {
            Model::Coordinate => {
                let harmonics: Vec<f64> = self.delta_spectrum().iter().map(length).collect();
                let residual = self.above(energy(&self.delta), &harmonics);
                Amplitudes { harmonics, residual }
            }
            Model::Normal => {
                let harmonics: Vec<f64> = self.xi_spectrum().iter().map(|c| c.abs()).collect();
                let whole = self.xi().iter().zip(mass).map(|(xi, a)| a * xi * xi).sum();
                let residual = self.above(whole, &harmonics);
                Amplitudes { harmonics, residual }
            }
            Model::Distance => {
                let (shape, filter) = (self.base.spectrum(), self.psi());
                let of_shape: Vec<f64> = shape.iter().map(length).collect();
                let residual = filter.residual.abs() * self.above(energy(&self.base.positions), &of_shape);
                let harmonics = of_shape.iter().zip(&filter.psi).map(|(x, psi)| x * psi.abs()).collect();
                Amplitudes { harmonics, residual }
            }
        }
    }

    /// The amplitude above K of a signal of energy `whole` (Parseval); 0 where it cannot be distinguished from
    /// rounding.
    fn above(&self, whole: f64, harmonics: &[f64]) -> f64 {
        let above = whole - harmonics.iter().map(|c| c * c).sum::<f64>();
        let noise = whole * self.base.basis.certificate.max_orthogonality_error.max(1e-13) * 10.0;
        if above > noise { above.sqrt() } else { 0.0 }
    }
}

fn residual(basis: &Basis, signal: &[Vec3], spectrum: &[Vec3]) -> Vec<Vec3> {
    let mut out = signal.to_vec();
    basis.synthesize_each(spectrum, &mut out, |_, low, f| *f = sub(*f, low));
    out
}

/// A low-pass keeps between 1 and all of the harmonics, which include the constants of all pieces.
pub(crate) fn check_low_pass(k0: usize, basis: &Basis) -> Result<(), CaricatureError> {
    // Where all are constants, those of further pieces may be missing, and these would collapse.
    if basis.harmonics() > 1 && basis.constants() == basis.harmonics() {
        let what = "the number of harmonics beside the constants of its pieces";
        let range = "above 0: remove loose pieces, or ask for more harmonics";
        return Err(CaricatureError::Range { what, value: 0.0, range });
    }
    check_kept(k0, basis.harmonics())
}

/// A low-pass keeps between 1 and all of a shape's `harmonics`.
pub(crate) fn check_kept(k0: usize, harmonics: usize) -> Result<(), CaricatureError> {
    if (1..=harmonics).contains(&k0) {
        return Ok(());
    }
    let (what, range) = ("the number of harmonics that a low-pass keeps", "between 1 and those of the shape");
    Err(CaricatureError::Range { what, value: k0 as f64, range })
}

pub(crate) fn check_count(what: &'static str, found: usize, basis: &Basis) -> Result<(), CaricatureError> {
    let expected = basis.vertices();
    if found == expected { Ok(()) } else { Err(CaricatureError::VertexCount { what, found, expected }) }
}
