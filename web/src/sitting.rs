//! One shape that is exaggerated: the caricature room without a window. The page sends its actions and says how large
//! its picture is, and gets the pixels.

mod doings;
mod files;
mod hanging;
mod landmarks;
mod matches;
mod pointing;
mod scale;
mod seeing;
mod stage;
mod state;

use std::path::Path;
use std::sync::Arc;

use chladni_caricature::{Evaluation, History, LayerId, Project, ShapeSource, Stack};
use chladni_harmonics::Body;
use chladni_mesh::{Estimate, MirrorPlane, MirrorSearch, Orientation, TriMesh};
use chladni_program::work::{Aside, Error, OwnLook, Parts, Subject, settled, source};
use chladni_task::Task;
use wasm_bindgen::prelude::*;

use self::hanging::Hanging;
use self::landmarks::Landmarks;
pub use self::matches::head_sliders;
use self::pointing::Tool;
use self::seeing::Heat;
pub use self::seeing::{color_maps, quantities};
use self::stage::Stage;
use crate::reporter::shape;
use crate::{PROJECT, solve};

/// A project on its shape, and the picture of it.
#[wasm_bindgen]
pub struct Sitting {
    /// The file that the shape was read from; none for a sample.
    file: Option<Vec<u8>>,
    mesh: Arc<TriMesh>,
    history: History,
    stack: Stack,
    /// Its harmonics are there. Until then the shape is shown as it is.
    solved: bool,
    /// The project's number of harmonics for which these were solved.
    solved_for: usize,
    evaluation: Evaluation,
    selected: Option<LayerId>,
    /// How the shape stands where the project does not say.
    stands: Estimate,
    /// The shape is shown under its layers.
    bare: bool,
    /// The chosen layer is shown in its three models.
    in_models: bool,
    parts: Parts,
    /// The plane in which the shape is its own mirror image, once it was looked for.
    mirror: Option<Option<MirrorPlane>>,
    tool: Tool,
    stage: Stage,
    heat: Heat,
    /// Both shapes, while landmarks are picked.
    landmarks: Option<Landmarks>,
    /// Caricatures in the place of the figure.
    hanging: Option<Hanging>,
    /// Messages for the page.
    notes: Vec<String>,
}

#[wasm_bindgen]
impl Sitting {
    /// The shape called `name`, which is `sample:NAME` or a file whose content is `file`, with the `project` in the text
    /// of a project file, or a new one of that many `harmonics`.
    ///
    /// # Errors
    /// Files that cannot be read.
    #[wasm_bindgen(constructor)]
    pub fn new(
        name: &str,
        file: Option<Vec<u8>>,
        project: Option<String>,
        harmonics: usize,
    ) -> Result<Self, JsError> {
        let task = Task::new();
        let aside = Aside::new(&task);
        let mut project = match project {
            Some(text) => source::project_in(Path::new(PROJECT), &text, &aside)?,
            None => Project::new(ShapeSource::named(name), harmonics),
        };
        let mesh = Subject::of_mesh(shape(name, file.as_deref(), &aside)?, &mut project, &aside)?.mesh;
        let known = project.shape.known();
        let stands = Estimate::of(&mesh, known, &task)?;
        let body = Body::unsolved(&mesh).map_err(|error| Error::from(error).of(name))?;
        let look = OwnLook::of(name, &mesh, &body, &aside);
        let stage = Stage::new(&body, look, project.stands.unwrap_or(stands.orientation))?;
        let mut stack = Stack::new(Arc::new(body))?;
        let evaluation = stack.evaluate(&nothing(&project));
        let selected = project.layers().last().map(|(id, _)| *id);
        let notes = aside.warnings().iter().map(ToString::to_string).collect();
        let parts = Parts::known(name, &mesh, stack.body());
        let history = History::new(project);
        let (solved, bare, in_models, mirror, tool) = (false, false, false, None, Tool::default());
        let (heat, landmarks, hanging) = (Heat::of(stage.has_own_look()), None, None);
        Ok(Self {
            file,
            mesh,
            history,
            stack,
            solved,
            solved_for: 0,
            evaluation,
            selected,
            stands,
            bare,
            in_models,
            parts,
            mirror,
            tool,
            stage,
            heat,
            landmarks,
            hanging,
            notes,
        })
    }

    /// The harmonics that [`solve`](crate::solve::solve) found when the project asked for `harmonics`.
    ///
    /// # Errors
    /// Those of another shape.
    pub fn take_harmonics(&mut self, bytes: &[u8], harmonics: usize) -> Result<(), JsError> {
        let body = Arc::new(Body::of_basis(&self.mesh, solve::from_bytes(bytes)?)?);
        self.stack = self.stack.with_harmonics_of(body)?;
        (self.solved, self.solved_for) = (true, harmonics);
        Ok(self.refresh()?)
    }
}

/// The project without its layers.
fn nothing(project: &Project) -> Project {
    Project::new(project.shape.clone(), project.harmonics)
}

impl Sitting {
    /// Evaluates the project again and shows it.
    fn refresh(&mut self) -> Result<(), Error> {
        let project = self.history.project();
        if self.selected.is_none_or(|id| project.layer(id).is_none()) {
            self.selected = project.layers().last().map(|(id, _)| *id);
        }
        let stands = self.stands_now();
        self.evaluation =
            if self.solved { self.stack.evaluate(project) } else { self.stack.evaluate(&nothing(project)) };
        self.stage.stand(stands);
        if let Some(hanging) = &mut self.hanging {
            hanging.stand(stands);
        }
        if let Some(landmarks) = &mut self.landmarks {
            landmarks.stand(stands);
        }
        self.stage.take(if self.bare { self.stack.original() } else { &self.evaluation.result })?;
        self.line_up_models()?;
        self.forget_other_landmarks();
        self.recoat()
    }

    /// Has the three models of the chosen layer stand beside each other, where that is wanted.
    fn line_up_models(&mut self) -> Result<(), Error> {
        if !self.in_models {
            self.stage.stand_alone();
            return Ok(());
        }
        let selected = self.selected.filter(|_| self.solved);
        let models = selected.and_then(|layer| self.stack.three_models(self.history.project(), layer));
        let (result, original) = (&self.evaluation.result.positions, &self.stack.original().positions);
        // A layer that does not act looks the same in all of them.
        let [a, b, c] = match &models {
            Some(models) => models.each_ref(),
            None => [result; 3],
        };
        self.stage.line_up([a, b, c, original], self.stack.surface())
    }

    /// How the shape stands.
    fn stands_now(&self) -> Orientation {
        self.history.project().stands.unwrap_or(self.stands.orientation)
    }

    /// The same with all layers limited where the project keeps triangles.
    fn settle(&mut self) -> Result<(), Error> {
        // An unsolved shape has nothing to limit yet.
        if self.solved {
            let task = Task::new();
            settled(&mut self.stack, self.history.project(), &Aside::new(&task))?;
        }
        self.refresh()
    }

    fn mirror(&mut self) -> Result<Option<MirrorPlane>, Error> {
        if let Some(known) = self.mirror {
            return Ok(known);
        }
        let surface = self.stack.surface();
        let search = MirrorSearch::of(&surface.positions, &surface.triangles);
        let found = search.map(|search| search.best(&[], &Task::new())).transpose()?.flatten();
        self.mirror = Some(found);
        Ok(found)
    }
}
