//! Who dances: a shape, or a caricature whose layers are voices.

use std::path::Path;

use chladni_caricature::Project;
use chladni_harmonics::{Body, Laplacian};
use chladni_mesh::{Orientation, TriMesh};
use chladni_synth::Term;

use crate::cli::inputs::{build_body, open_mesh};
use crate::cli::project::opened;
use crate::cli::sculpture::Sculpture;
use crate::cli::stance::Stance;
use crate::cli::{Failure, Terminal};
use crate::source;

/// A mesh, and the project that it comes from where it is a caricature.
pub struct Cast {
    name: String,
    mesh: TriMesh,
    project: Option<Project>,
}

impl Cast {
    /// Reads a mesh, or a project and its shape.
    pub fn open(name: &str, terminal: &Terminal) -> Result<Self, Failure> {
        let path = Path::new(name);
        if path.extension().is_none_or(|extension| extension != "chladni") {
            return Ok(Self { name: name.into(), mesh: open_mesh(name, terminal)?, project: None });
        }
        let project = opened(path, terminal)?;
        let (mesh, warnings) = source::shape(&project.shape, path.parent()).map_err(Failure::BadInput)?;
        for warning in warnings {
            terminal.warn(warning);
        }
        Ok(Self { name: project.shape.to_string(), mesh, project: Some(project) })
    }

    /// How it stands.
    pub fn stands(&self, stance: Stance, terminal: &Terminal) -> Result<Orientation, Failure> {
        let kept = self.project.as_ref().and_then(|project| project.stands);
        stance.of(&self.name, &self.mesh, kept, None, terminal)
    }

    /// The body with so many harmonics, and the voices.
    pub fn prepare(
        self,
        harmonics: usize,
        laplacian: Laplacian,
        terminal: &Terminal,
    ) -> Result<(Body, Vec<Term>), Failure> {
        let (body, _) = build_body(&self.name, &self.mesh, harmonics, laplacian, terminal)?;
        let Some(project) = &self.project else { return Ok((body, Vec::new())) };
        let sculpture = Sculpture::make(&self.name, self.mesh, project, terminal)?;
        Ok((body, sculpture.voices().into_iter().map(|(_, term)| term).collect()))
    }
}
