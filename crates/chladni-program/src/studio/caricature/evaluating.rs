//! Evaluates the document away from the window's thread, the newest first: a frame never waits for a slow one.

use std::sync::{Arc, LazyLock, Mutex, PoisonError};
use std::time::Duration;

use chladni_caricature::{EvaluatedLayer, Evaluation, LayerId, Project, Stack, Surface};
use chladni_mesh::surface::vec3::single;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use super::look::{Portrayal, Show};
use super::shot::Pose;
use crate::work::Error;
use crate::work::scale_plot::Spectrum;

/// How long a frame waits by default for the shape that its edits make, before the last one is shown again. Small shapes are
/// there by then, so that their pictures are never a frame late.
pub const PATIENCE: Duration = Duration::from_millis(4);

/// Threads of its own: the few parallel loops of a frame would queue behind an evaluation in the common pool.
static POOL: LazyLock<Result<ThreadPool, ThreadPoolBuildError>> = LazyLock::new(|| {
    // As many as in the common pool, which the system may limit.
    let pool = ThreadPoolBuilder::new().num_threads(rayon::current_num_threads());
    pool.thread_name(|index| format!("evaluate {index}")).build()
});

/// Held while an evaluation runs.
static TURN: Mutex<()> = Mutex::new(());

/// Runs `work`, which evaluates nothing, on the threads of evaluations.
pub fn on_own_threads<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T, Error> {
    Ok(POOL.as_ref().map_err(Error::other)?.install(work))
}

/// Evaluates on these threads, one evaluation after another. Those of one project share what they compute: a thread that
/// waits for a part of it would take up another evaluation, which would wait for that thread.
pub fn in_turn<T: Send>(evaluate: impl FnOnce() -> T + Send) -> Result<T, Error> {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    on_own_threads(evaluate)
}

/// The part of a project that is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sight {
    /// The layer that the panels edit.
    pub selected: Option<LayerId>,
    /// It is seen in all three models.
    pub models: bool,
    /// So is its template.
    pub template: bool,
}

impl Sight {
    /// What `look` shows of a project with this layer `selected`.
    pub fn of(selected: Option<LayerId>, look: Portrayal) -> Self {
        let (models, template) = (look.show == Show::Models, look.ghost || look.show == Show::Template);
        Self { selected, models, template }
    }
}

/// A project's evaluation, and what the panels show of it. It may be a step behind the document: layers are looked up by
/// their ids.
pub struct Shown {
    /// The layers and the result.
    pub evaluation: Evaluation,
    /// Triangles that each layer folds, in the order of the evaluation.
    pub folds: Vec<Arc<[u32]>>,
    /// The spectrum that the model of the selected layer exaggerates, over wavelength; empty where it does not act.
    pub spectrum: Spectrum,
}

/// The figures of an evaluation, ready to be copied to the device.
pub struct Figures {
    /// The result of all layers.
    pub result: Pose,
    /// The selected layer in each model, in the order of [`Model::ALL`](chladni_caricature::Model::ALL), where they are
    /// seen; the result where it does not act.
    pub models: Option<[Pose; 3]>,
    /// Where the shape's vertices lie on the template of the selected layer, where that is seen and matched.
    pub template: Option<Pose>,
}

/// The outcome of an evaluation.
pub struct Evaluated {
    /// The stack that evaluated, with what it remembers.
    pub stack: Stack,
    /// For the panels.
    pub shown: Shown,
    /// For the stage.
    pub figures: Figures,
}

impl Evaluated {
    /// Evaluates `project` on `stack`. What was counted `before` is not counted again where it has not changed.
    pub fn of(mut stack: Stack, project: &Project, sight: Sight, before: Option<&Shown>) -> Self {
        stack.prepare_models_of(sight.selected.filter(|_| sight.models));
        let evaluation = stack.evaluate(project);
        let folds =
            evaluation.layers.iter().map(|layer| known_folds(before, layer, stack.surface())).collect();
        let result = (single(&evaluation.result.positions), single(evaluation.result.normals()));
        let models = sight.models.then(|| {
            let own = sight.selected.and_then(|layer| stack.three_models(project, layer));
            let pose = |positions: Vec<_>| (single(&positions), single(&stack.surface().normals(&positions)));
            own.map_or_else(|| std::array::from_fn(|_| result.clone()), |own| own.map(pose))
        });
        let selected = evaluation.layers.iter().find(|layer| Some(layer.id) == sight.selected);
        let difference = selected.and_then(|layer| layer.difference.as_ref());
        let template = difference.filter(|_| sight.template).map(|difference| {
            let positions = single(&difference.target.points);
            let normals = chladni_view::smooth_normals(&positions, &stack.body().triangles);
            (positions, normals)
        });
        let layer = sight.selected.and_then(|id| project.layer(id));
        let spectrum = match (difference, layer) {
            (Some(difference), Some(layer)) => Spectrum::of(difference, layer.model, &stack.body().basis),
            _ => Spectrum::default(),
        };
        let figures = Figures { result, models, template };
        Self { shown: Shown { evaluation, folds, spectrum }, figures, stack }
    }
}

/// The triangles that a layer folds, counted where they were not before.
fn known_folds(before: Option<&Shown>, layer: &EvaluatedLayer, surface: &Surface) -> Arc<[u32]> {
    let known = before.and_then(|before| {
        let mut pairs = before.evaluation.layers.iter().zip(&before.folds);
        pairs.find(|(same, _)| moves_alike(same, layer)).map(|(_, folds)| Arc::clone(folds))
    });
    known.unwrap_or_else(|| layer.folded_triangles(surface).into())
}

/// Whether the two are the same layer that moves the same shape in the same way.
fn moves_alike(a: &EvaluatedLayer, b: &EvaluatedLayer) -> bool {
    let displaced = match (&a.displacement, &b.displacement) {
        (Some(a), Some(b)) => Arc::ptr_eq(a, b),
        (a, b) => a.is_none() && b.is_none(),
    };
    a.id == b.id && displaced && Arc::ptr_eq(&a.base, &b.base)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    #[test]
    fn one_evaluation_runs_at_a_time() {
        let (running, most) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let evaluate = || {
            most.fetch_max(running.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
            (0..20).for_each(|_| std::thread::yield_now());
            running.fetch_sub(1, Ordering::SeqCst);
        };
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| (0..50).for_each(|_| in_turn(evaluate).unwrap()));
            }
        });
        assert_eq!(most.into_inner(), 1);
    }
}
