//! Projects, meshes and pictures, as the files that the desktop reads and writes, too.

use std::path::Path;

use chladni_caricature::{Action, LayerState, PaintEdit, Painted, Project, ShapeSource, Template};
use chladni_mesh::Format;
use chladni_program::work::{Sculpture, mask};
use serde::Serialize;
use wasm_bindgen::prelude::*;

use super::Sitting;
use crate::PROJECT;

/// The reason why nothing is exported while layers wait.
const STILL_WORKING: &str =
    "Layers are still being matched, or harmonics solved for: export again once that is done.";

/// The files of a project that the page has to find by itself.
#[derive(Serialize)]
struct Needs {
    shape: String,
    /// The shape is a file.
    file: bool,
    harmonics: usize,
    laplacian: chladni_harmonics::Laplacian,
    /// Meshes that layers are compared with, beside samples.
    templates: Vec<String>,
}

impl Needs {
    fn of(project: &Project) -> Self {
        let templates = project.layers().iter().filter_map(|(_, layer)| match &layer.template {
            Template::File(path) => Some(path.to_string_lossy().into_owned()),
            _ => None,
        });
        Self {
            shape: project.shape.to_string(),
            file: matches!(project.shape, ShapeSource::File(_)),
            harmonics: project.harmonics,
            laplacian: project.laplacian,
            templates: templates.collect(),
        }
    }
}

/// The shape and the templates that the text of a project file names, as JSON.
///
/// # Errors
/// Text that is not a project.
#[wasm_bindgen]
pub fn needs_of_project(name: &str, text: &str) -> Result<String, JsError> {
    let (project, _) = Project::from_text(text, Path::new(name))?;
    Ok(serde_json::to_string(&Needs::of(&project))?)
}

#[wasm_bindgen]
impl Sitting {
    /// The files that its project names, as JSON, like [`needs_of_project`].
    ///
    /// # Errors
    /// Bugs only.
    pub fn needs(&self) -> Result<String, JsError> {
        Ok(serde_json::to_string(&Needs::of(self.history.project()))?)
    }

    /// The project as the text of a project file, which then counts as saved.
    ///
    /// # Errors
    /// Names that are not Unicode.
    pub fn save_project(&mut self) -> Result<String, JsError> {
        let text = self.history.project().to_text(Path::new(PROJECT), None)?;
        self.history.mark_saved();
        Ok(text)
    }

    /// Nothing has been done so far that a person would miss.
    pub fn mark_saved(&mut self) {
        self.history.mark_saved();
    }

    /// The project as the text of a project file, to be read elsewhere in the page.
    ///
    /// # Errors
    /// Names that are not Unicode.
    pub fn project_text(&self) -> Result<String, JsError> {
        Ok(self.history.project().to_text(Path::new(PROJECT), None)?)
    }

    /// The region of the selected layer as a mask: an array (`npy`), an archive (`npz`), or a mesh (`ply`, `obj`, `glb`).
    ///
    /// # Errors
    /// Another ending.
    pub fn save_mask(&self, ending: &str) -> Result<Vec<u8>, JsError> {
        let layer = self.selected.and_then(|id| self.history.project().layer(id));
        let painted = layer.map_or(Painted::Everywhere, |layer| layer.region.painted.clone());
        Ok(mask::to_bytes(ending, &painted, &self.mesh.clone().into())?.0)
    }

    /// Gives the selected layer the region in a file called `name`.
    ///
    /// # Errors
    /// A file that holds no mask of this shape; no layer.
    pub fn open_mask(&mut self, name: &str, bytes: &[u8]) -> Result<(), JsError> {
        let layer = self.selected.ok_or_else(|| JsError::new("A mask needs a layer: add one first."))?;
        let painted = mask::read_in(Path::new(name), bytes, &self.mesh.clone().into())?;
        Ok(self.act_once(&Action::Paint { layer, edit: PaintEdit::Set(painted) })?)
    }

    /// The result as a mesh: `glb`, with a slider for each layer, `obj`, `ply` or `stl`. Layers that cannot act are left
    /// out, with a note that says why.
    ///
    /// # Errors
    /// Another format, a shape that the format cannot hold, or layers that are still worked on.
    pub fn export(&mut self, extension: &str) -> Result<Vec<u8>, JsError> {
        let format = Format::from_extension(extension).ok_or_else(|| JsError::new("no such format"))?;
        let waits = |state: &LayerState| matches!(state, LayerState::Waiting | LayerState::Outdated);
        // Until others are solved for, those of before stay.
        let is_solved = self.solved && self.solved_for == self.history.project().harmonics;
        if !is_solved || self.evaluation.layers.iter().any(|layer| waits(&layer.state)) {
            return Err(JsError::new(STILL_WORKING));
        }
        self.settle()?;
        for layer in &self.evaluation.layers {
            if let LayerState::Failed(why) = &layer.state {
                self.notes.push(format!("Written without the layer {}: {why}.", layer.name));
            }
        }
        let sculpture = Sculpture {
            source: self.history.project().shape.clone(),
            subject: self.mesh.clone().into(),
            body: self.stack.body().clone(),
            evaluation: self.evaluation.clone(),
        };
        let (bytes, warning) = sculpture.to_bytes(format, self.file.as_deref())?;
        self.notes.extend(warning.map(|warning| warning.to_string()));
        Ok(bytes)
    }

    /// A picture as PNG, from where the viewer stands.
    ///
    /// # Errors
    /// A picture without pixels or too large.
    pub fn export_picture(&mut self, width: u32, height: u32) -> Result<Vec<u8>, JsError> {
        self.settle()?;
        Ok(self.stage.png(width, height)?)
    }

    /// Draws it in `width` × `height` pixels, `scale` for each of the page, if anything has changed; whether it was drawn.
    ///
    /// # Errors
    /// A picture without pixels or too large, and bugs.
    pub fn frame(&mut self, width: u32, height: u32, scale: f32) -> Result<bool, JsError> {
        if !self.stage.awaits(width, height)? {
            return Ok(false);
        }
        let (area, own) = (self.stage.area(), self.matching().landmarks);
        match (&mut self.landmarks, &mut self.hanging) {
            (Some(landmarks), _) => self.stage.draw_others(&landmarks.placed(area, &own, scale))?,
            (_, Some(hanging)) => self.stage.draw_others(&hanging.placed(area))?,
            _ => self.stage.draw()?,
        }
        Ok(true)
    }

    /// The processor draws from now on: the page has lost its graphics card.
    ///
    /// # Errors
    /// Bugs only.
    pub fn draw_by_processor(&mut self) -> Result<(), JsError> {
        // Their pictures lie on the card.
        (self.landmarks, self.hanging) = (None, None);
        self.stage.draw_by_processor()?;
        Ok(self.refresh()?)
    }

    /// Where the pixels of the last picture begin in the module's memory: RGBA, rows from the top.
    pub fn pixels(&self) -> *const u8 {
        self.stage.picture().rgba.as_ptr()
    }
}
