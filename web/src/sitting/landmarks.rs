//! Landmarks, picked on the shape and on the template of the selected layer, side by side.

use chladni_caricature::{Action, LayerId, Property, Template};
use chladni_match::{Landmark, MatchSettings, read_landmarks, write_landmarks};
use chladni_mesh::{Estimate, Known, Orientation};
use chladni_program::work::landmarks::{Gesture, Picks, Side, Which};
use chladni_program::work::{Aside, Error, template_mesh};
use chladni_task::Task;
use chladni_view::{Camera, Material, Rect};
use wasm_bindgen::prelude::*;

use super::Sitting;
use super::stage::Placed;
use crate::reporter::shape;

/// How near a landmark a press must be to hold it, in pixels of the page.
const GRIP: f32 = 14.0;
const BOTH: [Which; 2] = [Which::Shape, Which::Template];

/// Both shapes while landmarks of a layer are picked.
pub struct Landmarks {
    layer: LayerId,
    template: Template,
    sides: [Side; 2],
    /// How the template stands is in doubt: it stands as the shape does.
    follows: bool,
    picks: Picks,
    /// The shape that the pointer was on last.
    on: Which,
}

/// The halves of a picture: beside each other where it is wide.
fn halves(area: Rect) -> [Rect; 2] {
    let (w, h) = (area.width, area.height);
    let first = if w > h { Rect { width: w / 2, ..area } } else { Rect { height: h / 2, ..area } };
    let second = if w > h {
        Rect { x: first.width, width: w - first.width, ..area }
    } else {
        Rect { y: first.height, height: h - first.height, ..area }
    };
    [first, second]
}

impl Landmarks {
    fn side(&self, which: Which) -> &Side {
        &self.sides[which as usize]
    }

    /// Whether half a pair waits for its other half.
    pub fn has_pending(&self) -> bool {
        self.picks.pending().is_some()
    }

    /// Forgets half a pair; false where there was none.
    pub fn drop_pending(&mut self) -> bool {
        self.picks.drop_pending()
    }

    pub fn camera(&mut self) -> &mut Camera {
        &mut self.sides[self.on as usize].camera
    }

    pub fn fit(&mut self) {
        self.sides[self.on as usize].refit();
    }

    /// Turns the viewer where the shape stands otherwise.
    pub fn stand(&mut self, stands: Orientation) {
        let both = if self.follows { 2 } else { 1 };
        for side in self.sides.iter_mut().take(both).filter(|side| side.camera.stands != stands) {
            side.camera.stands = stands;
            side.refit();
        }
    }

    /// Both shapes with their landmarks, in a picture with `scale` pixels for each of the page.
    pub fn placed(&mut self, area: Rect, landmarks: &[Landmark], scale: f32) -> Vec<Placed<'_>> {
        let cells = halves(area);
        self.sides.iter_mut().zip(cells).for_each(|(side, cell)| side.fit(cell.aspect()));
        let placed = |(which, viewport)| {
            let side = self.side(which);
            let dots = side.dots(&self.picks.ends(which, landmarks));
            Placed {
                viewport,
                camera: side.camera,
                figures: vec![side.figure(Material::CLAY)],
                markers: dots.into_iter().map(|dot| dot.scaled(scale)).collect(),
            }
        };
        BOTH.into_iter().zip(cells).map(placed).collect()
    }

    /// The shape under a pixel, and its vertex there.
    fn under(&self, x: f32, y: f32, area: Rect) -> Option<(Which, Rect, Option<u32>)> {
        let mut both = BOTH.into_iter().zip(halves(area));
        let (which, cell) = both.find(|(_, cell)| cell.contains(x, y))?;
        Some((which, cell, self.side(which).vertex_at(x, y, cell)))
    }
}

#[wasm_bindgen]
impl Sitting {
    /// Shows the shape beside the template of the selected layer, to pick landmarks on them. A template that is a file
    /// has the content `template`.
    ///
    /// # Errors
    /// No layer, or one that is not compared with a mesh; a file that cannot be read.
    pub fn begin_landmarks(&mut self, template: Option<Vec<u8>>) -> Result<(), JsError> {
        let project = self.history.project();
        let found = self.selected.and_then(|id| Some((id, project.layer(id)?)));
        let (layer, wanted) = found
            .filter(|(_, layer)| layer.template.is_mesh())
            .map(|(id, layer)| (id, layer.template.clone()))
            .ok_or_else(|| JsError::new("Landmarks need a layer that is compared with a mesh."))?;
        let task = Task::new();
        let aside = Aside::new(&task);
        let mesh = match template {
            Some(bytes) => Some(shape(&wanted.to_string(), Some(&bytes), &aside)?),
            None => template_mesh(&wanted, &aside)?,
        };
        let mesh = mesh.ok_or_else(|| JsError::new("the template is no mesh"))?;
        let known = wanted.mesh().map_or_else(Known::default, |source| source.known());
        let found = Estimate::of(&mesh, known, &task)?;
        let beside = self.stands_now();
        let stands = if found.in_doubt { beside } else { found.orientation };
        let device = self.stage.device();
        let sides = [Side::new(device, &self.mesh, beside)?, Side::new(device, &mesh, stands)?];
        let picks = Picks::default();
        let (follows, on) = (found.in_doubt, Which::Shape);
        let landmarks = Landmarks { layer, template: wanted, sides, follows, picks, on };
        (self.landmarks, self.hanging) = (Some(landmarks), None);
        self.stage.stir();
        Ok(())
    }

    /// Back to the figure.
    pub fn leave_landmarks(&mut self) {
        self.landmarks = None;
        self.stage.stir();
    }

    /// Holds the landmark near a pixel; false where none is. `scale` is the number of pixels for each of the page.
    ///
    /// # Errors
    /// Bugs only.
    pub fn hold_landmark(&mut self, x: f32, y: f32, scale: f32) -> Result<bool, JsError> {
        let Some((which, index, vertex)) = self.landmark_near(x, y, scale) else { return Ok(false) };
        self.gesture(which, Gesture::Hold(index, vertex))?;
        Ok(true)
    }

    /// Takes the landmark near a pixel away, if there is one.
    ///
    /// # Errors
    /// Bugs only.
    pub fn remove_landmark_near(&mut self, x: f32, y: f32, scale: f32) -> Result<(), JsError> {
        match self.landmark_near(x, y, scale) {
            Some((which, index, _)) => Ok(self.gesture(which, Gesture::Remove(index))?),
            None => Ok(()),
        }
    }

    /// Moves the landmark that is held to a pixel of the same shape.
    ///
    /// # Errors
    /// Bugs only.
    pub fn move_landmark(&mut self, x: f32, y: f32) -> Result<(), JsError> {
        let area = self.stage.area();
        let Some(landmarks) = &self.landmarks else { return Ok(()) };
        if let Some((which, _, Some(vertex))) = landmarks.under(x, y, area)
            && let Some((index, _)) = landmarks.picks.held(which)
        {
            self.gesture(which, Gesture::Hold(index, vertex))?;
        }
        Ok(())
    }

    /// Lets go of the landmark that is held.
    ///
    /// # Errors
    /// A vertex of the shape that has one already.
    pub fn drop_landmark(&mut self) -> Result<(), JsError> {
        let held =
            |landmarks: &Landmarks| BOTH.into_iter().find(|which| landmarks.picks.held(*which).is_some());
        match self.landmarks.as_ref().and_then(held) {
            Some(which) => Ok(self.gesture(which, Gesture::Drop)?),
            None => Ok(()),
        }
    }

    /// Picks the vertex under a pixel: half a pair, or the other half.
    ///
    /// # Errors
    /// A vertex of the shape that has a landmark already.
    pub fn pick_landmark(&mut self, x: f32, y: f32) -> Result<(), JsError> {
        let area = self.stage.area();
        let found = self.landmarks.as_ref().and_then(|landmarks| landmarks.under(x, y, area));
        match found {
            Some((which, _, Some(vertex))) => Ok(self.gesture(which, Gesture::Pick(vertex))?),
            _ => Ok(()),
        }
    }

    /// Takes a landmark of the selected layer away, by its number from 0.
    ///
    /// # Errors
    /// Bugs only.
    pub fn remove_landmark(&mut self, index: usize) -> Result<(), JsError> {
        let mut settings = self.matching();
        if index < settings.landmarks.len() {
            settings.landmarks.remove(index);
            self.match_by(settings)?;
        }
        Ok(())
    }

    /// The landmarks of the selected layer as the text of a landmark file.
    pub fn save_landmarks(&self) -> String {
        write_landmarks(&self.matching().landmarks)
    }

    /// Gives the selected layer the landmarks in the text of a landmark file.
    ///
    /// # Errors
    /// Text that is none.
    pub fn open_landmarks(&mut self, text: &str) -> Result<(), JsError> {
        let landmarks = read_landmarks(text)?;
        let settings = MatchSettings { landmarks, ..self.matching() };
        Ok(self.match_by(settings)?)
    }

    /// The number, x and y of each landmark that is seen in the last picture.
    pub fn landmark_labels(&self) -> Vec<f32> {
        let Some(landmarks) = &self.landmarks else { return Vec::new() };
        let own = self.matching().landmarks;
        let label = |(which, cell): (Which, Rect)| {
            let ends = landmarks.picks.ends(which, &own);
            let seen = move |(index, vertex): (usize, u32)| match landmarks.side(which).pixel(vertex, cell) {
                Some(([x, y], true)) => Some([index as f32 + 1.0, x, y]),
                _ => None,
            };
            ends.into_iter().filter_map(seen)
        };
        BOTH.into_iter().zip(halves(self.stage.area())).flat_map(label).flatten().collect()
    }
}

impl Sitting {
    /// How the selected layer is matched.
    pub(super) fn matching(&self) -> MatchSettings {
        let layer = self.selected.and_then(|id| self.history.project().layer(id));
        layer.map(|layer| layer.matching.clone()).unwrap_or_default()
    }

    /// The landmark near a pixel: on which shape, its number, its vertex. That shape is the one that turns.
    fn landmark_near(&mut self, x: f32, y: f32, scale: f32) -> Option<(Which, usize, u32)> {
        let (area, own) = (self.stage.area(), self.matching().landmarks);
        let landmarks = self.landmarks.as_mut()?;
        let (which, cell, _) = landmarks.under(x, y, area)?;
        landmarks.on = which;
        let near = landmarks.side(which).near(which, &own, [x, y], GRIP * scale, cell)?;
        Some((which, near.0, near.1))
    }

    /// The hint at the next step, while landmarks are picked.
    pub(super) fn landmark_hint(&self) -> Option<String> {
        Some(self.landmarks.as_ref()?.picks.hint(self.matching().landmarks.len()))
    }

    /// Closes landmarks that are not those of the selected layer.
    pub(super) fn forget_other_landmarks(&mut self) {
        let project = self.history.project();
        let selected = self.selected.and_then(|id| Some((id, project.layer(id)?)));
        self.landmarks.take_if(|landmarks| {
            !selected.is_some_and(|(id, layer)| id == landmarks.layer && layer.template == landmarks.template)
        });
    }

    fn gesture(&mut self, which: Which, gesture: Gesture) -> Result<(), Error> {
        let settings = self.matching();
        let Some(landmarks) = &mut self.landmarks else { return Ok(()) };
        landmarks.on = which;
        let changed = landmarks.picks.act(which, gesture, &settings.landmarks);
        self.stage.stir();
        match changed? {
            Some(landmarks) => self.match_by(MatchSettings { landmarks, ..settings }),
            None => Ok(()),
        }
    }

    fn match_by(&mut self, settings: MatchSettings) -> Result<(), Error> {
        let Some(layer) = self.selected else { return Ok(()) };
        self.act_once(&Action::Set { layer, to: Property::Matching(settings) })
    }
}
