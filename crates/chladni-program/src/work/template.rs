//! Templates: their meshes, and the match of a shape with one.

use std::path::Path;

use chladni_caricature::{CaricatureError, MatchRequest, Matched, Project, Template};
use chladni_harmonics::Body;
use chladni_match::NEAR_TIE;
use chladni_mesh::TriMesh;
use chladni_task::read_file;

use super::{Error, Warning, Watcher, source};

/// The mesh of a template; `None` where it is none.
///
/// # Errors
/// As [`source::shape`] does.
pub fn template_mesh(template: &Template, watcher: &impl Watcher) -> Result<Option<TriMesh>, Error> {
    let mesh = template.mesh().map(|source| source::shape(&source, watcher)).transpose();
    mesh.map_err(|error| advised(template, error))
}

/// Checks, before any work, that a template is there to be read.
///
/// # Errors
/// As [`template_mesh`] does.
pub fn check_template(template: &Template, watcher: &impl Watcher) -> Result<(), Error> {
    let found = template.mesh().map_or(Ok(()), |source| source::check_there(&source, watcher));
    found.map_err(|error| advised(template, error))
}

/// The error of a template that cannot be read; where a single word names no file, with the templates that are none.
fn advised(template: &Template, error: Error) -> Error {
    let is_word = |file: &Path| file.extension().is_none() && file.components().count() == 1;
    if !error.is_cancelled() && template.file().is_some_and(|file| is_word(file) && !file.exists()) {
        let known = "ellipsoid, sphere, sample:NAME, self:scale=0.9 and self:lowpass=20";
        return Error::Input(format!("{error}; templates that are no files are {known}"));
    }
    error
}

/// The same for the templates of all layers of `project` that act.
///
/// # Errors
/// As [`template_mesh`] does.
pub fn check_templates(project: &Project, watcher: &impl Watcher) -> Result<(), Error> {
    project.acting().try_for_each(|layer| check_template(&layer.template, watcher))
}

/// Whether `next` is another mesh of the same file name than `template`, rather than the same file moved: the one before is
/// still there, and differs.
pub fn is_namesake(template: &Template, next: &Template) -> bool {
    let (Some(one), Some(two)) = (template.file(), next.file()) else { return false };
    let differ = || {
        let [size, other] = [one.metadata().ok()?.len(), two.metadata().ok()?.len()];
        Some(size != other || read_file(one, size).ok()? != read_file(two, size).ok()?)
    };
    one.file_name() == two.file_name() && differ().unwrap_or(false)
}

/// Matches the shape `mesh`, which `body` was built from, as `request` says, and warns of faults
/// of the match.
///
/// # Errors
/// Whatever keeps the layer from acting, in the words that the layer is shown with.
pub fn matched(
    request: &MatchRequest,
    mesh: &TriMesh,
    body: &Body,
    watcher: &impl Watcher,
) -> Result<Matched, CaricatureError> {
    let template = template_mesh(&request.template, watcher)
        .map_err(|error| CaricatureError::Elsewhere(error.to_string()))?;
    matched_with(request, mesh, body, template.as_ref(), watcher)
}

/// The same where the mesh of the template was read already; `None` where it is none.
///
/// # Errors
/// As [`matched`].
pub fn matched_with(
    request: &MatchRequest,
    mesh: &TriMesh,
    body: &Body,
    template: Option<&TriMesh>,
    watcher: &impl Watcher,
) -> Result<Matched, CaricatureError> {
    let found = watcher.watch("matching", |task| request.run(mesh, body, template, task))?;
    for message in found.report.iter().flat_map(|report| &report.warnings) {
        watcher.warn(if message == NEAR_TIE {
            Warning::NearTie { template: request.template.to_string() }
        } else {
            Warning::of(&request.template, message)
        });
    }
    Ok(found)
}
