//! The layer stack evaluated on one body: each layer's result is the shape of the next.

use std::collections::HashMap;
use std::sync::Arc;

use chladni_harmonics::Body;
use chladni_match::MatchSettings;
use chladni_synth::Term;
use rayon::prelude::*;

use crate::difference::check_count;
use crate::keeping::{KeepRequest, Kept, SharedKeeper};
use crate::layer_memo::{Answer, LayerMemo, Scene};
use crate::matching::own_target;
use crate::memo::Same;
use crate::softening::Softening;
use crate::{
    Base, CaricatureError, Difference, EvaluatedLayer, Evaluation, Layer, LayerId, LayerState, MatchRequest,
    Matched, Model, Project, Signals, Surface, Template,
};
use chladni_mesh::surface::vec3::{Vec3, add};

/// Evaluates projects on one body, and remembers its results.
///
/// Basis and correspondences never change; a layer whose inputs have not changed costs nothing, so a change
/// to layer i is paid for only from i up.
///
/// A clone shares all that is remembered, and costs next to nothing: it evaluates on another thread, and what it then
/// remembers is taken over by [`remember`](Self::remember).
#[derive(Clone, Debug)]
pub struct Stack {
    body: Arc<Body>,
    surface: Arc<Surface>,
    file_positions: Arc<[Vec3]>,
    original: Arc<Base>,
    matches: Vec<(MatchRequest, Answer<Matched>)>,
    /// How far each layer was limited last.
    kept: HashMap<LayerId, (KeepRequest, Answer<Kept>)>,
    layers: HashMap<LayerId, LayerMemo>,
    softening: Softening,
    keeper: Arc<SharedKeeper>,
    all_models_of: Option<LayerId>,
}

/// Beyond this many matches the oldest that no layer uses is dropped: moving landmarks makes many, of a
/// megabyte or two each.
const MAX_MATCHES: usize = 32;

impl Stack {
    /// A stack on `body`, with nothing matched.
    ///
    /// # Errors
    /// A basis that does not fit the positions.
    pub fn new(body: Arc<Body>) -> Result<Self, CaricatureError> {
        let surface = Arc::new(Surface::new(&body));
        let original = Base::new(body.basis.clone(), surface.clone(), body.positions.clone())?;
        let file_positions = surface.file_positions().into();
        let (matches, kept, layers) = (Vec::new(), HashMap::new(), HashMap::new());
        let softening = Softening::of(surface.clone());
        let keeper = Arc::new(SharedKeeper::of(surface.clone(), softening.flow()));
        let (original, all_models_of) = (Arc::new(original), None);
        Ok(Self {
            body,
            surface,
            file_positions,
            original,
            matches,
            kept,
            layers,
            softening,
            keeper,
            all_models_of,
        })
    }

    /// A stack on the same shape with another number of harmonics. Matches do not depend on harmonics and are
    /// kept.
    ///
    /// # Errors
    /// A body of another shape.
    pub fn with_harmonics_of(&self, body: Arc<Body>) -> Result<Self, CaricatureError> {
        check_count("the shape", self.body.positions.len(), &body.basis)?;
        let (softening, keeper) = (self.softening.clone(), self.keeper.clone());
        Ok(Self { matches: self.matches.clone(), softening, keeper, ..Self::new(body)? })
    }

    /// The body that is deformed.
    pub fn body(&self) -> &Arc<Body> {
        &self.body
    }

    /// The body's surface, to paint on.
    pub fn surface(&self) -> &Arc<Surface> {
        &self.surface
    }

    /// The shape under all layers.
    pub fn original(&self) -> &Arc<Base> {
        &self.original
    }

    /// The preparation before regions can be softened, half a second for 50,000 vertices: a window runs it on
    /// another thread as soon as the brush is chosen. [`evaluate`](Self::evaluate) waits for it, or does it
    /// if needed.
    pub fn brush_preparation(&self) -> impl FnOnce() + Send + 'static {
        self.softening.preparation()
    }

    /// The matches that acting layers wait for, each once. Run them away from the window and
    /// [`install`](Self::install) what they find.
    pub fn missing(&self, project: &Project) -> Vec<MatchRequest> {
        let mut missing: Vec<MatchRequest> = Vec::new();
        for layer in project.acting() {
            let unknown = |r: &MatchRequest| !self.matches.iter().any(|(known, _)| known == r);
            if let Some(request) = MatchRequest::of(layer).filter(|r| unknown(r) && !missing.contains(r)) {
                missing.push(request);
            }
        }
        missing
    }

    /// Keeps a match for all layers that ask for it, now and later, so that undoing a change of
    /// template does not match again. A failed one puts its layers in [`LayerState::Failed`].
    pub fn install(&mut self, request: MatchRequest, matched: Result<Matched, CaricatureError>) {
        self.forget(&request);
        self.matches.push((request, matched.map(Arc::new).map_err(Arc::new)));
    }

    /// Takes over what another stack of the same shape has matched, in place of matches that failed here. Its own failures
    /// stay there.
    pub fn learn(&mut self, other: &Self) {
        for (request, found) in other.matches.iter().filter(|(_, found)| found.is_ok()) {
            if self.matched(request).is_none() {
                self.forget(request);
                self.matches.push((request.clone(), found.clone()));
            }
        }
    }

    /// Forgets a match, so that it is [`missing`](Self::missing) again: its file has changed.
    pub fn forget(&mut self, request: &MatchRequest) {
        self.matches.retain(|(known, _)| known != request);
    }

    /// Forgets all matches with a template whose file has changed.
    pub fn forget_template(&mut self, template: &Template) {
        self.matches.retain(|(known, _)| known.template != *template);
    }

    /// Whether a match with this template has succeeded, whatever its settings.
    pub fn is_matched_with(&self, template: &Template) -> bool {
        self.matches.iter().any(|(known, found)| known.template == *template && found.is_ok())
    }

    /// The match that answers `request`, where there is one.
    pub fn matched(&self, request: &MatchRequest) -> Option<&Arc<Matched>> {
        let (_, found) = self.matches.iter().find(|(known, _)| known == request)?;
        found.as_ref().ok()
    }

    /// The difference between the shape, below all layers, and a template, filled in completely where the match is
    /// not trusted.
    ///
    /// # Errors
    /// A template that is not matched, that is the result of a layer, or that keeps more harmonics than there are.
    pub fn difference(
        &self,
        template: &Template,
        matching: &MatchSettings,
    ) -> Result<Arc<Difference>, CaricatureError> {
        let refused =
            |why: &str| CaricatureError::Template { template: template.to_string(), why: why.into() };
        if matches!(template, Template::Layer(_)) {
            return Err(refused("there are no layers to be compared with"));
        }
        let layer = Layer { matching: matching.clone(), ..Layer::new("", template.clone()) };
        let target = match MatchRequest::of(&layer) {
            Some(request) => match self.matched(&request) {
                Some(matched) => Some(matched.target(self.original.basis(), layer.infill)?),
                None => None,
            },
            None => own_target(template, &self.original)?,
        };
        let target = Arc::new(target.ok_or_else(|| refused("is not matched"))?);
        Difference::new(self.original.clone(), target).map(Arc::new)
    }

    /// The lowest layer that is still to be limited, where `project` keeps triangles. Run it away from the window and
    /// [`settle`](Self::settle) what it finds; the layers above it change with it. Until then a layer is shown as far
    /// as it went when it was limited last.
    pub fn unsettled(&mut self, project: &Project) -> Option<KeepRequest> {
        if !project.keep_triangles {
            return None;
        }
        let evaluation = self.evaluate(project);
        self.unsettled_in(&evaluation)
    }

    /// The same of an `evaluation` that this stack, or a clone of it, has made of a project that keeps triangles.
    pub fn unsettled_in(&self, evaluation: &Evaluation) -> Option<KeepRequest> {
        let l = evaluation.layers.iter().find(|l| l.unlimited.is_some() && l.kept.is_none())?;
        let (base, mask, keeper) = (l.base.clone(), l.mask.clone(), self.keeper.clone());
        Some(KeepRequest { layer: l.id, base, unlimited: l.unlimited.clone()?, mask, keeper })
    }

    /// Keeps the answer to a request; a failed one puts its layer in [`LayerState::Failed`].
    pub fn settle(&mut self, request: KeepRequest, kept: Result<Kept, CaricatureError>) {
        self.kept.insert(request.layer, (request, kept.map(Arc::new).map_err(Arc::new)));
    }

    /// Forgets how far a layer was limited, or why it could not be, so that it is asked for again.
    pub fn forget_limit(&mut self, layer: LayerId) {
        self.kept.remove(&layer);
    }

    /// Takes over what a clone of this stack remembers. Matches and limits stay: of those this one may have newer ones.
    pub fn remember(&mut self, clone: Self) {
        if Arc::ptr_eq(&self.body, &clone.body) {
            (self.layers, self.softening) = (clone.layers, clone.softening);
        }
    }

    /// Drops limits of layers that `project` does not have, and a match that no layer of it uses where there are too
    /// many. [`evaluate`](Self::evaluate) does so itself; a stack whose clones evaluate does not.
    pub fn forget_unused(&mut self, project: &Project) {
        self.kept.retain(|id, _| project.layer(*id).is_some());
        if self.matches.len() > MAX_MATCHES {
            let wanted: Vec<_> = project.layers().iter().filter_map(|(_, l)| MatchRequest::of(l)).collect();
            if let Some(oldest) = self.matches.iter().position(|(known, _)| !wanted.contains(known)) {
                drop(self.matches.remove(oldest));
            }
        }
    }

    /// Evaluates every layer of `project`, lowest first. Layers that cannot act leave the shape
    /// as it is and say why in their state.
    pub fn evaluate(&mut self, project: &Project) -> Evaluation {
        self.forget_unused(project);
        let mut memos = std::mem::take(&mut self.layers);
        let mut base = self.original.clone();
        let mut layers = Vec::with_capacity(project.layers().len());
        for (id, layer) in project.layers() {
            let memo = self.layers.entry(*id).or_insert_with(|| memos.remove(id).unwrap_or_default());
            let all_models = self.all_models_of == Some(*id);
            let (matches, places) = (&self.matches, &self.file_positions);
            let (keeper, kept) = (project.keep_triangles.then_some(&self.keeper), self.kept.get(id));
            let template = match layer.template {
                Template::Original => Some(&self.original),
                Template::Layer(below) => result_of(below, &layers, &base),
                _ => Some(&base),
            };
            let scene = Scene { matches, template, places, all_models, keeper, kept, id: *id };
            let mut evaluated = EvaluatedLayer {
                id: *id,
                name: layer.name.clone(),
                state: LayerState::Off,
                base: base.clone(),
                mask: None,
                difference: None,
                displacement: None,
                unlimited: None,
                kept: None,
            };
            if project.acts(layer) {
                match memo.evaluate(&scene, &mut self.softening, layer, &base) {
                    Ok(Some(acting)) => {
                        base = acting.result;
                        evaluated.state =
                            if acting.outdated { LayerState::Outdated } else { LayerState::Acts };
                        evaluated.mask = acting.mask;
                        evaluated.difference = Some(acting.difference);
                        evaluated.displacement = Some(acting.displacement);
                        evaluated.unlimited = Some(acting.unlimited);
                        evaluated.kept = acting.kept;
                    }
                    Ok(None) => evaluated.state = LayerState::Waiting,
                    Err(why) => evaluated.state = LayerState::Failed(why.to_string()),
                }
            }
            layers.push(evaluated);
        }
        Evaluation { layers, result: base }
    }

    /// Announces that the layer will be shown in all three models: they are then evaluated together, in the
    /// same passes over H as the active one.
    pub fn prepare_models_of(&mut self, layer: Option<LayerId>) {
        self.all_models_of = layer;
    }

    /// The layer's result under each of the three models, in the order of [`Model::ALL`], N
    /// positions each; `None` where the layer does not act.
    pub fn three_models(&mut self, project: &Project, id: LayerId) -> Option<[Vec<Vec3>; 3]> {
        let evaluated = self.evaluate(project).layers.into_iter().find(|l| l.id == id)?;
        let (difference, layer) = (evaluated.difference?, project.layer(id)?);
        let memo = self.layers.get_mut(&id)?;
        let base = &difference.base;
        let fields = memo.all_fields(&difference, &layer.curve);
        Some(fields.map(|field| {
            let moved = field.displacement(base.normals(), layer.effective_mu(), evaluated.mask.as_deref());
            base.positions.par_iter().zip(moved).map(|(x, d)| add(*x, d)).collect()
        }))
    }

    /// The layer under each of the three models as terms for a synthesizer that rests on the
    /// layer's base (`EvaluatedLayer::base`), in the order of [`Model::ALL`]; `None` where the
    /// layer does not act.
    pub fn terms(&mut self, project: &Project, id: LayerId) -> Option<[Term; 3]> {
        let evaluated = self.evaluate(project).layers.into_iter().find(|l| l.id == id)?;
        let (difference, layer) = (evaluated.difference?, project.layer(id)?);
        let memo = self.layers.get_mut(&id)?;
        difference.prepare();
        let of = || Ok::<_, std::convert::Infallible>(Signals::of(&difference));
        let Ok(signals) = memo.signals.get(Same::from(&difference), of);
        let mu = layer.effective_mu();
        Some(Model::ALL.map(|m| difference.term(&signals, m, &layer.curve, mu, evaluated.mask.clone())))
    }
}

/// The shape after layer `id`, one of `layers`, above which is `top`.
fn result_of<'a>(id: LayerId, layers: &'a [EvaluatedLayer], top: &'a Arc<Base>) -> Option<&'a Arc<Base>> {
    let place = layers.iter().position(|layer| layer.id == id)?;
    Some(layers.get(place + 1).map_or(top, |above| &above.base))
}
