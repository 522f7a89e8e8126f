//! The result of a stack of layers.

use std::sync::Arc;

use chladni_harmonics::Body;
use chladni_mesh::surface::vec3::{Vec3, add};
use chladni_synth::{Coefficients, Residual, Term};
use rayon::prelude::*;

use crate::exaggeration::single;
use crate::fold::flipped_triangles;
use crate::keeping::Kept;
use crate::{Base, Difference, LayerId, Surface};

/// The result of evaluating a project.
#[derive(Clone, Debug)]
pub struct Evaluation {
    /// The layers, lowest first.
    pub layers: Vec<EvaluatedLayer>,
    /// The shape on top of all layers.
    pub result: Arc<Base>,
}

/// The effect of one layer.
#[derive(Clone, Debug)]
pub struct EvaluatedLayer {
    /// The layer.
    pub id: LayerId,
    /// Its name.
    pub name: String,
    /// Whether it acts, and why not.
    pub state: LayerState,
    /// The shape it starts from.
    pub base: Arc<Base>,
    /// χ; `None` is 1 everywhere.
    pub mask: Option<Arc<[f32]>>,
    /// Its difference, where it acts.
    pub difference: Option<Arc<Difference>>,
    /// The displacement it adds, N, working frame; `None` where it does not act.
    pub displacement: Option<Arc<Vec<Vec3>>>,
    /// The same before it is limited; the same values where it is not.
    pub unlimited: Option<Arc<Vec<Vec3>>>,
    /// How far it was limited; `None` where the project does not keep triangles, or until
    /// [`unsettled`](crate::Stack::unsettled) requests are answered.
    pub kept: Option<Arc<Kept>>,
}

/// Whether a layer acts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LayerState {
    /// It does.
    Acts,
    /// It acts with the previous match of its template: the match that it asks for now is still
    /// [`missing`](crate::Stack::missing), as while landmarks are moved.
    Outdated,
    /// It is switched off, or others are soloed.
    Off,
    /// Its template is not matched yet; see [`missing`](crate::Stack::missing).
    Waiting,
    /// It cannot: the reason.
    Failed(String),
}

impl EvaluatedLayer {
    /// How many triangles of `surface` the layer turns over; 0 where it does not act.
    pub fn folds(&self, surface: &Surface) -> usize {
        self.folded_triangles(surface).len()
    }

    /// The triangles of `surface` that the layer turns over, ascending.
    pub fn folded_triangles(&self, surface: &Surface) -> Vec<u32> {
        let Some(displacement) = &self.displacement else { return Vec::new() };
        let base = &self.base.positions;
        let pairs = base.par_iter().zip(displacement.par_iter());
        let moved: Vec<Vec3> = pairs.map(|(x, d)| add(*x, *d)).collect();
        flipped_triangles(surface, base, &moved)
    }
}

impl Evaluation {
    /// The displacement of all layers together, N, working frame; exactly zero where no layer
    /// moves anything.
    pub fn displacement(&self) -> Vec<Vec3> {
        let mut sum = vec![[0.0; 3]; self.result.positions.len()];
        for layer in self.layers.iter().filter_map(|l| l.displacement.as_ref()) {
            sum.par_iter_mut().zip(layer.par_iter()).for_each(|(s, d)| *s = add(*s, *d));
        }
        sum
    }

    /// The n vertices of the result in the coordinates of the file, whose own vertices are
    /// `file_positions`.
    pub fn file_positions(&self, body: &Body, file_positions: &[Vec3]) -> Vec<Vec3> {
        body.displaced_file_positions(file_positions, &self.displacement())
    }

    /// For each acting layer its name and its displacement as a term for a synthesizer that rests
    /// on the original shape. Together they give the result; their gains can be driven apart, so
    /// that layers become the voices of an instrument.
    pub fn voices(&self) -> Vec<(String, Term)> {
        let voice = |displacement: &[Vec3]| Term {
            coefficients: Coefficients::Vector(Vec::new()),
            residual: Some(Residual::Vector(single(displacement))),
            residual_gain: 1.0,
            mask: None,
        };
        let acting = self.layers.iter().filter_map(|l| Some((l.name.clone(), l.displacement.as_ref()?)));
        acting.map(|(name, displacement)| (name, voice(displacement))).collect()
    }

    /// For each acting layer its name and the displacement of the n file vertices, in file
    /// units: morph targets that add up to the result.
    pub fn morph_targets(&self, body: &Body) -> Vec<(String, Vec<Vec3>)> {
        let acting = self.layers.iter().filter_map(|l| Some((l.name.clone(), l.displacement.as_ref()?)));
        acting.map(|(name, d)| (name, body.displacements_in_file(d))).collect()
    }
}
