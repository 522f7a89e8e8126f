//! Templates: their meshes, and the match of a shape with one.

use chladni_caricature::{CaricatureError, MatchRequest, Matched, Project, Template};
use chladni_harmonics::Body;
use chladni_mesh::TriMesh;
use chladni_task::read_file;

use super::{Error, Warning, Watcher, source};

/// The mesh of a template; `None` where it is none.
///
/// # Errors
/// As [`source::shape`] does.
pub fn template_mesh(template: &Template, watcher: &impl Watcher) -> Result<Option<TriMesh>, Error> {
    template.mesh().map(|source| source::shape(&source, watcher)).transpose()
}

/// Checks, before any work, that a template is there to be read.
///
/// # Errors
/// As [`template_mesh`] does.
pub fn check_template(template: &Template, watcher: &impl Watcher) -> Result<(), Error> {
    template.mesh().map_or(Ok(()), |source| source::check_there(&source, watcher))
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
        watcher.warn(Warning::of(&request.template, message));
    }
    Ok(found)
}
