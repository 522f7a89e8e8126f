//! The dancing body: a shape, or a caricature whose layers are voices.

use std::path::Path;
use std::sync::Arc;

use chladni_caricature::Project;
use chladni_harmonics::{Body, Laplacian};
use chladni_mesh::{Orientation, ShapeSource};
use chladni_synth::Term;

use super::outputs::check_textures;
use super::{Error, Stance, Subject, Watcher, body, check_templates, formats, make, source};

/// A mesh, and the project that it comes from where it is a caricature.
pub struct Cast {
    shape: ShapeSource,
    subject: Subject,
    project: Option<Project>,
}

impl Cast {
    /// Reads a mesh, or a project and its shape.
    ///
    /// # Errors
    /// Whatever is wrong with either file.
    pub fn open(path: &Path, watcher: &impl Watcher) -> Result<Self, Error> {
        if formats::is_project(path) {
            let mut project = source::project(path, watcher)?;
            let subject = Subject::of(&mut project, watcher)?;
            return Ok(Self { shape: project.shape.clone(), subject, project: Some(project) });
        }
        let shape = ShapeSource::named(path);
        let subject = Subject::open(&shape, watcher)?;
        Ok(Self { shape, subject, project: None })
    }

    /// The shape as it is worked on.
    pub fn subject(&self) -> &Subject {
        &self.subject
    }

    /// The file of its shape; `None` for a sample.
    pub fn shape_file(&self) -> Option<&Path> {
        self.shape.file()
    }

    /// The files that its project names.
    pub fn files(&self) -> Vec<&Path> {
        self.project.as_ref().map_or_else(Vec::new, Project::files)
    }

    /// Checks that no file written to `paths` replaces a texture of its shape or of its project's templates.
    ///
    /// # Errors
    /// As [`check_textures`].
    pub fn check_textures(&self, paths: &[&Path]) -> Result<(), Error> {
        let layers = self.project.iter().flat_map(|project| project.layers());
        let templates = layers.map(|(_, layer)| &layer.template);
        check_textures(paths, (&self.shape, self.subject.whole()), templates)
    }

    /// Checks, before any work, that the templates of its project are there to be read.
    ///
    /// # Errors
    /// As [`check_templates`].
    pub fn check_templates(&self, watcher: &impl Watcher) -> Result<(), Error> {
        self.project.as_ref().map_or(Ok(()), |project| check_templates(project, watcher))
    }

    /// How its project says that it stands.
    fn kept_stance(&self) -> Option<Orientation> {
        self.project.as_ref()?.stands
    }

    /// How many harmonics dance unless a number is given: `most`, or those of its project where it has fewer.
    pub fn harmonics(&self, most: usize) -> usize {
        self.project.as_ref().map_or(most, |project| project.harmonics.min(most))
    }

    /// How it stands: as given, else as a show of it has `kept`, else as its project has.
    ///
    /// # Errors
    /// As [`Stance::of`].
    pub fn stands(
        &self,
        stance: Stance,
        kept: Option<Orientation>,
        watcher: &impl Watcher,
    ) -> Result<Orientation, Error> {
        let kept = kept.or_else(|| self.kept_stance());
        stance.of(&self.shape.to_string(), &self.subject.mesh, kept, None, watcher)
    }

    /// The body with this many harmonics, and the voices by name, each at full strength. A layer that cannot
    /// act is an error, or `forgiven` with a warning.
    ///
    /// # Errors
    /// As [`body::build`] and [`make`] do.
    pub fn prepare(
        self,
        harmonics: usize,
        laplacian: Laplacian,
        forgiven: bool,
        watcher: &impl Watcher,
    ) -> Result<(Body, Vec<(String, Term)>), Error> {
        let name = self.shape.to_string();
        let build =
            |harmonics, laplacian| body::build(&name, &self.subject.mesh, harmonics, laplacian, watcher);
        let (body, _) = build(harmonics, laplacian)?;
        let Some(project) = &self.project else { return Ok((body, Vec::new())) };
        // The layers are displacements: they do not depend on how many harmonics dance.
        let layered = match (project.harmonics, project.laplacian) == (harmonics, laplacian) {
            true => body.clone(),
            false => build(project.harmonics, project.laplacian)?.0,
        };
        let made = make(self.subject, Arc::new(layered), project, forgiven, watcher)?;
        Ok((body, made.sculpture.evaluation.voices()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_caricature_dances_with_no_more_harmonics_than_its_project_has() {
        let shape = ShapeSource::Sample("octopus".into());
        let of = |project: Option<Project>| {
            let subject = Subject::from(chladni_mesh::samples::icosphere(1));
            let cast = Cast { shape: shape.clone(), subject, project };
            [10, 512].map(|most| cast.harmonics(most))
        };
        assert_eq!(of(None), [10, 512]);
        assert_eq!(of(Some(Project::new(shape.clone(), 24))), [10, 24]);
    }
}
