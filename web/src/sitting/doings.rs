//! Actions of a person in a sitting.

use std::path::PathBuf;

use chladni_caricature::{Action, Layer, LayerId, Property, ScaleCurve};
use chladni_mesh::Axis;
use chladni_program::work::landmarks::HALF_A_LANDMARK;
use chladni_program::work::{
    Aside, Error, MAY_FOLD, Parts, STARTING_POINTS, Stance, furthest_mu, layer_against, layer_since,
    template_from,
};
use chladni_task::Task;
use chladni_view::{Camera, View};
use wasm_bindgen::prelude::*;

use super::Sitting;
use super::landmarks::Landmarks;

#[wasm_bindgen]
impl Sitting {
    /// Does an action of the project, as JSON: `{"set": {"layer": 1, "to": {"mu": -0.8}}}`.
    ///
    /// # Errors
    /// Text that is not an action, and an action that cannot be done.
    pub fn act(&mut self, action: &str) -> Result<(), JsError> {
        Ok(self.act_once(&serde_json::from_str(action)?)?)
    }

    /// Does it as part of a drag: all of one kind are one step until [`finish`](Self::finish).
    ///
    /// # Errors
    /// As [`act`](Self::act).
    pub fn drag(&mut self, action: &str) -> Result<(), JsError> {
        let surface = self.stack.surface().clone();
        self.history.apply_live(&serde_json::from_str(action)?, Some(&surface))?;
        Ok(self.refresh()?)
    }

    /// A drag or a stroke has ended.
    ///
    /// # Errors
    /// Bugs only.
    pub fn finish(&mut self) -> Result<(), JsError> {
        self.history.finish();
        self.lift_brush();
        Ok(self.refresh()?)
    }

    /// Undoes a step; returns its label, if there was one.
    ///
    /// # Errors
    /// Bugs only.
    pub fn undo(&mut self) -> Result<Option<String>, JsError> {
        // Half a landmark is not in the history yet: it is taken back first.
        if self.landmarks.as_mut().is_some_and(Landmarks::drop_pending) {
            self.refresh()?;
            return Ok(Some(HALF_A_LANDMARK.into()));
        }
        let label = self.history.undo();
        self.refresh()?;
        Ok(label.map(Into::into))
    }

    /// Repeats an undone step.
    ///
    /// # Errors
    /// Bugs only.
    pub fn redo(&mut self) -> Result<Option<String>, JsError> {
        let label = self.history.redo();
        self.refresh()?;
        Ok(label.map(Into::into))
    }

    /// Takes back harmonics that were not solved for: those that are there are `harmonics`.
    ///
    /// # Errors
    /// Bugs only.
    pub fn restore_harmonics(&mut self, harmonics: usize) -> Result<(), JsError> {
        if self.history.project().harmonics == harmonics {
            return Ok(());
        }
        // By the way that led here, so that no step back leads here again: forth where it was a step back.
        if self.history.step_to(|project| project.harmonics == harmonics) {
            return Ok(self.refresh()?);
        }
        // Something else was done meanwhile.
        Ok(self.act_once(&Action::SetHarmonics(harmonics))?)
    }

    /// Chooses the layer that controls and tools change.
    ///
    /// # Errors
    /// Bugs only.
    pub fn select(&mut self, layer: u32) -> Result<(), JsError> {
        self.selected = Some(LayerId(layer.into()));
        Ok(self.refresh()?)
    }

    /// Puts a layer on top, against a template that needs no file, by its number among
    /// [`starting_points`](crate::starting_points).
    ///
    /// # Errors
    /// A number that none has.
    pub fn begin(&mut self, point: usize) -> Result<(), JsError> {
        let found = STARTING_POINTS.get(point).ok_or_else(|| JsError::new("there is no such template"))?;
        let project = self.history.project();
        let most = if self.solved { self.stack.body().basis.harmonics() } else { project.harmonics };
        let layer = found.layer(project, most);
        Ok(self.add(layer)?)
    }

    /// Puts a layer on top, against the mesh in the file called `name`.
    ///
    /// # Errors
    /// Bugs only.
    pub fn compare(&mut self, name: &str) -> Result<(), JsError> {
        let layer = layer_against(self.history.project(), PathBuf::from(name));
        Ok(self.add(layer)?)
    }

    /// Puts a layer on top, against the shape as it is after one of its layers.
    ///
    /// # Errors
    /// A layer that is not there.
    pub fn compare_with_layer(&mut self, below: u32) -> Result<(), JsError> {
        let (project, below) = (self.history.project(), LayerId(below.into()));
        let found = project.layer(below).ok_or_else(|| JsError::new("there is no such layer"))?;
        let layer = layer_since(project, below, &found.name);
        Ok(self.add(layer)?)
    }

    /// Gives a layer a scale curve by its name: `flat`, `smooth`, `broad`, `mid` or `fine`.
    ///
    /// # Errors
    /// A name that none has.
    pub fn set_curve(&mut self, layer: u32, name: &str) -> Result<(), JsError> {
        let to = Property::Curve(name.parse::<ScaleCurve>()?);
        Ok(self.act_once(&Action::Set { layer: LayerId(layer.into()), to })?)
    }

    /// Compares a layer with another template that needs neither a mesh nor another layer, by its text: `self:scale=0.9`.
    ///
    /// # Errors
    /// Text of another kind of template, or of none; a layer that is not there.
    pub fn set_template(&mut self, layer: u32, text: &str) -> Result<(), JsError> {
        let to = Property::Template(template_from(text)?);
        Ok(self.act_once(&Action::Set { layer: LayerId(layer.into()), to })?)
    }

    /// The μ with the strongest exaggeration before the selected layer folds more than a sliver; `None` where nothing moves
    /// or it never folds.
    pub fn furthest_mu(&self) -> Option<f64> {
        let id = self.selected?;
        let layer = self.history.project().layer(id)?;
        let evaluated = self.evaluation.layers.iter().find(|evaluated| evaluated.id == id)?;
        furthest_mu(evaluated, layer, self.stack.surface(), MAY_FOLD)
    }

    /// Says which axis of the shape's file points up, such as `z` or `-y`; `""` leaves it to the estimate.
    ///
    /// # Errors
    /// A name that no axis has.
    pub fn stand(&mut self, up: &str) -> Result<(), JsError> {
        let stands = if up.is_empty() {
            None
        } else {
            let (stance, task) = (Stance { up: Some(up.parse::<Axis>()?), front: None }, Task::new());
            let name = self.history.project().shape.to_string();
            Some(stance.of(&name, &self.mesh, None, None, &Aside::new(&task))?)
        };
        Ok(self.act_once(&Action::Stand(stands))?)
    }

    /// Looks for parts of the shape, from whole limbs (0) to small features (1).
    ///
    /// # Errors
    /// Bugs only.
    pub fn find_parts(&mut self, level: f64) -> Result<(), JsError> {
        let mirror = self.mirror()?;
        self.tool.pointed.clear();
        self.parts = Parts::at_level(self.stack.body(), level, mirror);
        Ok(self.recoat()?)
    }

    /// The parts of a head that [`parts_of_head`](crate::solve::parts_of_head) found.
    ///
    /// # Errors
    /// Bugs only.
    pub fn take_parts_of_head(&mut self, parts: &[u8]) -> Result<(), JsError> {
        self.tool.pointed.clear();
        self.parts = Parts::of_head(parts, self.stack.body());
        Ok(self.recoat()?)
    }

    /// Shows the shape under its layers, to compare, or the result again.
    ///
    /// # Errors
    /// Bugs only.
    pub fn show_original(&mut self, on: bool) -> Result<(), JsError> {
        self.bare = on;
        Ok(self.refresh()?)
    }

    /// Shows the chosen layer in its three models beside the original, or the result again.
    ///
    /// # Errors
    /// Bugs only.
    pub fn show_models(&mut self, on: bool) -> Result<(), JsError> {
        self.in_models = on;
        Ok(self.refresh()?)
    }

    /// Limits all layers where the project keeps triangles; takes seconds.
    ///
    /// # Errors
    /// Bugs only.
    pub fn keep_triangles(&mut self) -> Result<(), JsError> {
        Ok(self.settle()?)
    }

    /// Turns the viewer by a drag in pixels.
    pub fn turn(&mut self, dx: f32, dy: f32) {
        self.camera().orbit(dx, dy);
        self.stage.moved(false);
    }

    /// Brings the viewer nearer by steps of a wheel.
    pub fn zoom(&mut self, steps: f32) {
        self.camera().zoom(steps);
        self.stage.moved(true);
    }

    /// Shifts the picture, in heights of it.
    pub fn shift(&mut self, right: f32, down: f32) {
        self.camera().pan(right, down, 1.0);
        self.stage.moved(true);
    }

    /// Shows all there is.
    pub fn fit(&mut self) {
        match (&mut self.landmarks, &mut self.hanging) {
            (Some(landmarks), _) => landmarks.fit(),
            (_, Some(hanging)) => hanging.fit(),
            _ => self.stage.fit(),
        }
        self.stage.stir();
    }

    /// Looks at the shape's `front`, from the `right`, its `back`, or as portraits do (`portrait`).
    ///
    /// # Errors
    /// A name that no view has.
    pub fn look(&mut self, from: &str) -> Result<(), JsError> {
        self.camera().look(match from {
            "front" => View::Front,
            "right" => View::Right,
            "back" => View::Back,
            "portrait" => View::ThreeQuarter,
            _ => return Err(JsError::new("there is no such view")),
        });
        self.fit();
        Ok(())
    }
}

impl Sitting {
    /// The camera of the current view.
    fn camera(&mut self) -> &mut Camera {
        match (&mut self.landmarks, &mut self.hanging) {
            (Some(landmarks), _) => landmarks.camera(),
            (_, Some(hanging)) => &mut hanging.camera,
            _ => &mut self.stage.camera,
        }
    }

    /// Does an action as a step of its own.
    pub(super) fn act_once(&mut self, action: &Action) -> Result<(), Error> {
        let (next, surface) = (self.history.project().next_id(), self.stack.surface().clone());
        self.history.apply(action, Some(&surface))?;
        if matches!(action, Action::Add { .. } | Action::Duplicate(_)) {
            self.selected = Some(next);
        }
        self.refresh()
    }

    fn add(&mut self, layer: Layer) -> Result<(), Error> {
        let index = self.history.project().layers().len();
        self.act_once(&Action::Add { index, layer: Box::new(layer) })
    }
}
