//! Heat steps on the shape at rest, which soften the edges of regions.

use std::sync::{Arc, OnceLock};

use chladni_harmonics::{HarmonicsError, HeatFlow, HeatStep};

use crate::Surface;

/// The heat steps that the layers of a stack ask for, on any number of harmonics: heat does not depend on them. Layers
/// of equal softness share a factorization.
#[derive(Clone, Debug)]
pub(crate) struct Softening {
    flow: Arc<SharedFlow>,
    /// By their length, the last used at the end.
    steps: Vec<(f64, Arc<HeatStep>)>,
}

/// A Laplacian that is built on first use. It outlives the harmonics of its shape, and holds none of them.
#[derive(Debug)]
pub(crate) struct SharedFlow {
    surface: Arc<Surface>,
    flow: OnceLock<Result<Arc<HeatFlow>, HarmonicsError>>,
}

impl SharedFlow {
    pub(crate) fn get(&self) -> Result<&Arc<HeatFlow>, HarmonicsError> {
        let of = |surface: &Surface| HeatFlow::on_surface(&surface.positions, &surface.triangles);
        self.flow.get_or_init(|| of(&self.surface).map(Arc::new)).as_ref().map_err(Clone::clone)
    }
}

/// A factorization of 50,000 vertices takes about 25 MB; dragging the softness makes many.
const MAX_STEPS: usize = 4;

impl Softening {
    pub(crate) fn of(surface: Arc<Surface>) -> Self {
        Self { flow: Arc::new(SharedFlow { surface, flow: OnceLock::new() }), steps: Vec::new() }
    }

    /// The Laplacian that all steps share.
    pub(crate) fn flow(&self) -> Arc<SharedFlow> {
        self.flow.clone()
    }

    /// The slow preparation before the first region can be softened, to be run on another thread. A step that
    /// is asked for meanwhile waits for it.
    pub(crate) fn preparation(&self) -> impl FnOnce() + Send + 'static {
        let flow = self.flow.clone();
        move || {
            // An error is reported by the first step that is asked for.
            let _ = flow.get();
        }
    }

    /// The step of length `time`.
    pub(crate) fn step(&mut self, time: f64) -> Result<Arc<HeatStep>, HarmonicsError> {
        let step = match self.steps.iter().position(|(known, _)| *known == time) {
            Some(at) => self.steps.remove(at).1,
            None => Arc::new(self.flow.get()?.step(time)?),
        };
        self.steps.push((time, step.clone()));
        if self.steps.len() > MAX_STEPS {
            self.steps.remove(0);
        }
        Ok(step)
    }
}
