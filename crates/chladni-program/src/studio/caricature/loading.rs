//! A project to be opened, and the result of loading it.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::Sender;

use chladni_caricature::{Painted, Project, Recovered, Stack};
use chladni_mesh::{Estimate, Orientation, TriMesh};
use chladni_task::Task;

use super::evaluating::{Evaluated, Sight, in_turn};
use super::health::Unexamined;
use crate::work::{Aside, Error, OwnLook, Subject, Warning, Watcher, body, source};

/// A project that will replace the open one.
pub struct Candidate {
    /// The document.
    pub project: Project,
    /// Where it lies, if anywhere.
    pub path: Option<PathBuf>,
    /// The hash of the file there.
    pub on_disk: Option<String>,
    /// The recovery copy that it comes from.
    pub recovered: Option<Recovered>,
    /// The shape that its layers were made on, where `project` names another: regions and landmarks
    /// are carried over.
    pub made_on: Option<Arc<TriMesh>>,
    /// Meshes that become layers of it as soon as it is open.
    pub templates: Vec<PathBuf>,
    /// Meshes of it were found elsewhere than its file says.
    pub found_moved: bool,
}

impl Candidate {
    /// A project that is not in a file yet.
    pub fn new(project: Project) -> Self {
        let (path, on_disk, recovered, made_on) = (None, None, None, None);
        Self { project, path, on_disk, recovered, made_on, templates: Vec::new(), found_moved: false }
    }
}

/// The result of loading.
pub struct Loaded {
    pub project: Project,
    pub path: Option<PathBuf>,
    /// The hash of the file there, as the project was read.
    pub on_disk: Option<String>,
    /// Whether the project differs from any file.
    pub new: bool,
    /// Whether its layers were made on another shape.
    pub is_carried: bool,
    /// The recovery copy that the project comes from.
    pub recovered: Option<Recovered>,
    pub subject: Subject,
    /// The same for its health report.
    pub unexamined: Unexamined,
    pub stands: Estimate,
    /// What of it is seen first.
    pub sight: Sight,
    /// Its evaluation on the shape with its harmonics.
    pub evaluated: Evaluated,
    /// The colors that the file has.
    pub look: Option<OwnLook>,
    /// Repairs made to the file, and faults of the harmonics.
    pub warnings: Vec<Warning>,
}

/// Loads the shape of a project and its harmonics. The mesh is sent to `read` as soon as it is loaded:
/// solving may take much longer.
pub fn load(
    candidate: Candidate,
    read: &Sender<(Arc<TriMesh>, Orientation)>,
    task: &Task,
) -> Result<Loaded, Error> {
    let Candidate { mut project, path, on_disk, recovered, made_on, found_moved, .. } = candidate;
    let aside = Aside::new(task);
    let name = project.shape.to_string();
    let chladni_mesh::Loaded { mesh, mended, stored_positions } = source::loaded(&project.shape, &aside)?;
    let subject = match made_on {
        Some(_) => Subject::before_carrying(mesh, &mut project, &aside)?,
        None => Subject::of_mesh(mesh, &mut project, &aside)?,
    };
    let mesh = &subject.mesh;
    if let Some(message) = project.taken_over() {
        aside.warn(Warning::Plain(format!("This is {message}.")));
    }
    let known = project.shape.known();
    let stands = Estimate::of(mesh, known, task)?;
    // There may be no receiver any more.
    let _ = read.send((Arc::clone(mesh), project.stands.unwrap_or(stands.orientation)));
    let is_carried = made_on.is_some();
    let new = recovered.is_some() || is_carried || found_moved;
    if let Some(from) = made_on {
        let carried = project.carried(&from, mesh, task)?;
        for message in carried.report.into_iter().flat_map(|report| report.warnings) {
            aside.warn(Warning::of(&name, message));
        }
        project = carried.project;
    }
    let (body, report) = body::build(&name, mesh, project.harmonics, project.laplacian, &aside)?;
    // That of a proxy says nothing of the whole shape.
    let cover = report.cover.filter(|_| subject.proxy.is_none());
    let unexamined = Unexamined { whole: Arc::clone(subject.whole()), stored_positions, mended, cover };
    let look = OwnLook::of_subject(&name, &subject, &body, &aside);
    let stack = Stack::new(Arc::new(body))?;
    if project.layers().iter().any(|(_, layer)| layer.region.painted != Painted::Everywhere) {
        stack.brush_preparation()();
    }
    let selected = project.layers().last().map(|(id, _)| *id);
    let sight = Sight { selected, ..Sight::default() };
    let evaluated = in_turn(|| Evaluated::of(stack, &project, sight, None))?;
    let warnings = aside.warnings();
    Ok(Loaded {
        project,
        path,
        on_disk,
        new,
        is_carried,
        recovered,
        subject,
        unexamined,
        stands,
        sight,
        evaluated,
        look,
        warnings,
    })
}
