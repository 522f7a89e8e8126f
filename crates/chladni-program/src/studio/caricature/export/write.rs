//! Writing, away from the window.

use std::path::Path;
use std::sync::Arc;

use chladni_caricature::Evaluation;
use chladni_harmonics::Body;
use chladni_mesh::{Format, MorphTarget, TriMesh, save_mesh, write_glb};
use chladni_task::{Task, write_atomic};
use chladni_view::{FilmSettings, ViewError};

use super::super::session::Session;
use super::super::shot::Shot;

/// The result as it is now.
pub struct Sculpture {
    mesh: Arc<TriMesh>,
    body: Arc<Body>,
    evaluation: Evaluation,
}

impl Sculpture {
    /// The result of `session`; later edits do not change it.
    pub fn of(session: &Session) -> Self {
        let (mesh, body) = (Arc::clone(&session.mesh), Arc::clone(session.stack.body()));
        Self { mesh, body, evaluation: session.evaluation.clone() }
    }

    /// Writes it, in the format of the extension: GLB holds the original with one morph target
    /// per layer, other formats the result itself.
    pub fn save(&self, path: &Path) -> Result<(), String> {
        let failed = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
        if Format::from_extension(extension) == Some(Format::Glb) {
            let targets: Vec<MorphTarget> = self
                .evaluation
                .morph_targets(&self.body)
                .into_iter()
                .map(|(name, displacements)| MorphTarget { name, displacements })
                .collect();
            let bytes = write_glb(&self.mesh, &targets).map_err(|error| failed(&error))?;
            return write_atomic(path, &bytes).map_err(|error| failed(&error));
        }
        let positions = self.evaluation.file_positions(&self.body, &self.mesh.positions);
        let result = TriMesh { positions, ..TriMesh::clone(&self.mesh) };
        save_mesh(&result, path).map_err(|error| error.to_string())
    }
}

/// Writes a PNG.
pub fn picture(shot: &Shot, width: u32, height: u32, path: &Path) -> Result<(), String> {
    let failed = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let png = shot.picture(width, height).and_then(|picture| picture.to_png()).map_err(|e| failed(&e))?;
    write_atomic(path, &png).map_err(|error| failed(&error))
}

/// Writes a film of one turn.
pub fn film(shot: &Shot, settings: FilmSettings, path: &Path, task: &Task) -> Result<(), String> {
    shot.turntable(path, settings, task).map_err(|error| match error {
        ViewError::Cancelled(_) => format!("{}: cancelled, nothing was written", path.display()),
        error => format!("{}: {error}", path.display()),
    })
}
