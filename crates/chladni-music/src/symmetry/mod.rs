//! Which harmonics are symmetric and which antisymmetric (docs/symmetry.md).

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

/// What the mirror does to a harmonic.
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
    /// By applying this mirror plane, found from the pairs and refined.
    Mirror(MirrorPlane),
    /// By the paper's vote alone: the shape has no mirror plane, the classes are rough.
    Vote,
}

/// Settings of the symmetry test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SymmetrySettings {
    /// n_k: how many non-constant harmonics the extrema and signatures are taken of.
    pub signature_harmonics: usize,
    /// c: for how many of them a vertex must be an extremum; lowered until 8 vertices remain.
    pub least_extrema: usize,
    /// Neighboring eigenvalues whose relative gap is below this count as repeated.
    pub cluster_gap: f64,
    /// |⟨H, H∘T⟩| below this is undecided, (0, 1).
    pub decided: f64,
    /// A mirror plane may miss the shape by at most this share of its bounding box's diagonal
    /// (root mean square over the best nine tenths of the vertices).
    pub plane_tolerance: f64,
    /// Uses the paper's vote alone, even where there is a mirror plane: symmetric where a majority of pairs
    /// says so, antisymmetric otherwise.
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
    /// The class of a harmonic of this score.
    fn class(&self, score: f64) -> Class {
        match score {
            s if s >= self.decided => Class::Symmetric,
            s if s <= -self.decided => Class::Antisymmetric,
            _ => Class::Undecided,
        }
    }
}

/// The symmetry of a body's harmonics.
#[derive(Clone, Debug, PartialEq)]
pub struct Symmetry {
    /// The class of each of the K harmonics, after [`rotations`](Self::rotations).
    pub classes: Vec<Class>,
    /// ⟨H_k, H_k∘T⟩ in [−1, 1], or for the vote (votes for − votes against) / pairs.
    pub scores: Vec<f64>,
    /// For how many of the first n_k harmonics each vertex is an extremum (N values).
    pub extrema_counts: Vec<u8>,
    /// The vertices that are an extremum often enough.
    pub extrema: Vec<u32>,
    /// Extrema that the symmetry is likely to exchange.
    pub pairs: Vec<[u32; 2]>,
    /// How repeated eigenvalues' harmonics are to be mixed so that they have a class.
    pub rotations: Vec<Rotation>,
    /// How the classes were found.
    pub method: SymmetryMethod,
}

impl Symmetry {
    /// Classifies the harmonics of `body` with the usual settings.
    ///
    /// # Errors
    /// As [`with`](Self::with).
    pub fn of(body: &Body, task: &Task) -> Result<Self, MusicError> {
        Self::with(body, &SymmetrySettings::default(), task)
    }

    /// Classifies the harmonics of `body`: the paper's test for extrema and pairs, from them
    /// a mirror plane, and from that the class of each harmonic and cluster.
    ///
    /// # Errors
    /// A body without harmonics or vertices, or the task was cancelled.
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
            let (scores, rotations) = cluster::mirrored(body, &image, settings, task)?;
            return Ok(Self::new(extrema, scores, rotations, SymmetryMethod::Mirror(plane), settings));
        }
        let scores = extrema.vote(basis, settings);
        let by_majority = SymmetrySettings { decided: f64::MIN_POSITIVE, ..*settings };
        let rotations = cluster::unmirrored(body, settings, task)?;
        let mut found = Self::new(extrema, scores, rotations, SymmetryMethod::Vote, &by_majority);
        if settings.by_vote {
            let undecided = found.classes.iter_mut().filter(|c| **c == Class::Undecided);
            undecided.for_each(|c| *c = Class::Antisymmetric);
        }
        Ok(found)
    }

    fn new(
        extrema: paper::Extrema,
        scores: Vec<f64>,
        rotations: Vec<Rotation>,
        method: SymmetryMethod,
        settings: &SymmetrySettings,
    ) -> Self {
        let classes = scores.iter().map(|&score| settings.class(score)).collect();
        let paper::Extrema { counts, vertices, pairs, .. } = extrema;
        Self { classes, scores, extrema_counts: counts, extrema: vertices, pairs, rotations, method }
    }

    /// `body` with the harmonics of repeated eigenvalues mixed as the classes assume. The
    /// basis is copied only where something is to be mixed.
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

/// The best mirror plane, and the mirror as a map of the surface; `None` where no plane fits
/// within the tolerance.
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
pub(crate) fn first_waving(basis: &Basis) -> usize {
    let largest = basis.eigenvalues.last().copied().unwrap_or(0.0);
    basis.eigenvalues.partition_point(|&l| l <= 1e-9 * largest)
}
