//! Classifies harmonics as symmetric or antisymmetric (docs/symmetry.md).

mod cluster;
mod paper;

use std::sync::Arc;

use chladni_harmonics::{Basis, Body};
use chladni_mesh::{MirrorPlane, MirrorSearch, OnSurface};
use chladni_task::Task;
use serde::{Deserialize, Serialize};

use crate::MusicError;
pub use cluster::Rotation;
pub(crate) use cluster::repeated;

/// How the mirror acts on a harmonic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Class {
    /// H(T v) = H(v).
    Symmetric,
    /// H(T v) = −H(v).
    Antisymmetric,
    /// Neither.
    Undecided,
}

impl Class {
    /// 1, −1 or 0.
    pub fn sign(self) -> i8 {
        match self {
            Self::Symmetric => 1,
            Self::Antisymmetric => -1,
            Self::Undecided => 0,
        }
    }
}

/// How the classes were found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SymmetryMethod {
    /// By applying this mirror plane, which was found from the pairs and refined.
    Mirror(MirrorPlane),
    /// Only by the paper's vote: the shape has no mirror plane, or none was to be looked for
    /// ([`by_vote`](SymmetrySettings::by_vote)). The classes are rough.
    Vote,
}

/// Settings of the symmetry test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SymmetrySettings {
    /// n_k: the number of non-constant harmonics used for extrema and signatures.
    pub signature_harmonics: usize,
    /// c: of how many of them a vertex must be an extremum; lowered until 8 vertices remain.
    pub least_extrema: usize,
    /// Neighboring eigenvalues with a relative difference below this count as repeated.
    pub cluster_gap: f64,
    /// A harmonic with |⟨H, H∘T⟩| below this is undecided, in (0, 1). It is at least 0.9 for the last harmonics, which K
    /// may part from others of their eigenvalue.
    pub decided: f64,
    /// The largest misfit of a mirror plane, as a share of the diagonal of the shape's bounding box (root
    /// mean square over the best nine tenths of the vertices).
    pub plane_tolerance: f64,
    /// Whether to use only the paper's vote, even if there is a mirror plane: a harmonic is symmetric if a
    /// majority of pairs says so, and otherwise antisymmetric.
    pub by_vote: bool,
}

impl Default for SymmetrySettings {
    fn default() -> Self {
        Self {
            signature_harmonics: 15,
            least_extrema: 10,
            cluster_gap: 1e-3,
            decided: 0.05,
            plane_tolerance: 0.015,
            by_vote: false,
        }
    }
}

impl SymmetrySettings {
    /// The settings for the harmonics that come last, which K may part from others of their eigenvalue.
    fn of_last(&self) -> Self {
        Self { decided: self.decided.max(WITHIN), ..*self }
    }

    /// The class of a harmonic with this score.
    fn class(&self, score: f64) -> Class {
        match score {
            s if s >= self.decided => Class::Symmetric,
            s if s <= -self.decided => Class::Antisymmetric,
            _ => Class::Undecided,
        }
    }
}

/// Of harmonics that K may part from others of their eigenvalue, those with |⟨H, H∘T⟩| below this are undecided: the
/// mirror may take them to others beyond K.
const WITHIN: f64 = 0.9;

/// The symmetry of a body's harmonics.
#[derive(Clone, Debug, PartialEq)]
pub struct Symmetry {
    /// The class of each of the K harmonics, after [`rotations`](Self::rotations).
    pub classes: Vec<Class>,
    /// ⟨H_k, H_k∘T⟩ in [−1, 1]; for the vote, (votes for − votes against) / pairs.
    pub scores: Vec<f64>,
    /// For each of the N vertices, of how many of the first n_k harmonics it is an extremum.
    pub extrema_counts: Vec<u8>,
    /// The vertices that are extrema often enough.
    pub extrema: Vec<u32>,
    /// Pairs of extrema that the symmetry is likely to exchange.
    pub pairs: Vec<[u32; 2]>,
    /// The rotations of repeated eigenvalues' harmonics after which each has a class.
    pub rotations: Vec<Rotation>,
    /// How the classes were found.
    pub method: SymmetryMethod,
}

impl Symmetry {
    /// Classifies the harmonics of `body` with the default settings.
    ///
    /// # Errors
    /// Those of [`with`](Self::with).
    pub fn of(body: &Body, task: &Task) -> Result<Self, MusicError> {
        Self::with(body, &SymmetrySettings::default(), task)
    }

    /// Classifies the harmonics of `body`: the paper's test gives extrema and pairs, these give a mirror
    /// plane, and the plane gives the class of each harmonic and group of repeated ones.
    ///
    /// # Errors
    /// A body without harmonics or vertices, or a cancelled task.
    pub fn with(body: &Body, settings: &SymmetrySettings, task: &Task) -> Result<Self, MusicError> {
        let basis = &*body.basis;
        if basis.harmonics() == 0 || basis.vertices() == 0 || body.positions.len() != basis.vertices() {
            let found = basis.vertices().min(body.positions.len());
            return Err(MusicError::Size {
                what: "vertices with harmonics",
                found,
                expected: basis.vertices().max(1),
            });
        }
        let _stage = task.stage("symmetry", 0);
        let extrema = paper::Extrema::of(body, settings);
        task.check()?;
        let mirrored = if settings.by_vote { None } else { mirror(body, &extrema.pairs, settings, task)? };
        if let Some((plane, image)) = mirrored {
            let (classified, rotations) = cluster::mirrored(body, &image, settings, task)?;
            let (classes, scores) = classified.into_iter().unzip();
            return Ok(Self::new(extrema, classes, scores, rotations, SymmetryMethod::Mirror(plane)));
        }
        let scores = extrema.vote(basis, settings);
        let by_majority = SymmetrySettings { decided: f64::MIN_POSITIVE, ..*settings };
        let classes = scores.iter().map(|&score| by_majority.class(score)).collect();
        let rotations = cluster::unmirrored(body, settings, task)?;
        let mut found = Self::new(extrema, classes, scores, rotations, SymmetryMethod::Vote);
        if settings.by_vote {
            let undecided = found.classes.iter_mut().filter(|c| **c == Class::Undecided);
            undecided.for_each(|c| *c = Class::Antisymmetric);
        }
        Ok(found)
    }

    fn new(
        extrema: paper::Extrema,
        classes: Vec<Class>,
        scores: Vec<f64>,
        rotations: Vec<Rotation>,
        method: SymmetryMethod,
    ) -> Self {
        let paper::Extrema { counts, vertices, pairs, .. } = extrema;
        Self { classes, scores, extrema_counts: counts, extrema: vertices, pairs, rotations, method }
    }

    /// `body` with the harmonics of repeated eigenvalues rotated as the classes assume. The basis is copied
    /// only if something must be rotated.
    pub fn rotated(&self, body: &Body) -> Body {
        if self.rotations.is_empty() {
            return body.clone();
        }
        let mut basis: Basis = (*body.basis).clone();
        for rotation in &self.rotations {
            rotation.apply(&mut basis);
        }
        Body { basis: Arc::new(basis), ..body.clone() }
    }
}

/// The best mirror plane, and the mirror as a map of the surface; `None` if no plane fits within the
/// tolerance.
fn mirror(
    body: &Body,
    pairs: &[[u32; 2]],
    settings: &SymmetrySettings,
    task: &Task,
) -> Result<Option<(MirrorPlane, Vec<OnSurface>)>, MusicError> {
    let Some(search) = MirrorSearch::of(&body.positions, &body.triangles) else { return Ok(None) };
    let across = |pair: &[u32; 2]| -> [f64; 3] {
        let [a, b] = pair.map(|v| body.positions[v as usize]);
        std::array::from_fn(|i| a[i] - b[i])
    };
    let hints: Vec<[f64; 3]> = pairs.iter().map(across).collect();
    let plane = search.best(&hints, task)?.filter(|plane| plane.misfit <= settings.plane_tolerance);
    Ok(plane.map(|plane| (plane, search.image(&plane))))
}

/// Index of the first harmonic that is not constant on a component.
pub(crate) fn first_waving(eigenvalues: &[f64]) -> usize {
    let largest = eigenvalues.last().copied().unwrap_or(0.0);
    eigenvalues.partition_point(|&l| l <= 1e-9 * largest)
}

/// The smallest eigenvalue of a harmonic that is not constant; 1 where there is none.
pub(crate) fn slowest(eigenvalues: &[f64]) -> f64 {
    eigenvalues.get(first_waving(eigenvalues)).copied().unwrap_or(1.0)
}

/// How many constant harmonics there are beside the first: one for each further piece of the shape.
pub(crate) fn spare_constants(eigenvalues: &[f64]) -> usize {
    first_waving(eigenvalues).saturating_sub(1)
}
