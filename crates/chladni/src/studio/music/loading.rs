//! Shapes and caricatures, made ready to dance.

use std::path::Path;
use std::sync::Arc;

use chladni_caricature::{Error, MatchRequest, Project, ShapeSource, Stack, Template};
use chladni_harmonics::Body;
use chladni_mesh::TriMesh;
use chladni_music::{Dancer, Symmetry};
use chladni_synth::Term;
use chladni_task::Task;

use super::coarse;
use crate::source;
use crate::studio::bodies::solve;

/// Vertices of a gallery's item where the processor draws.
const COARSE_VERTICES: usize = 3000;

/// How a shape is made ready.
#[derive(Clone, Copy, Debug)]
pub struct Means {
    /// So many harmonics dance at most.
    pub harmonics: usize,
    /// The processor draws: a gallery of large shapes shows fewer triangles.
    pub coarsely: bool,
}

/// What loading brings back.
pub struct Ready {
    /// The body; harmonics of repeated eigenvalues are mixed so that they have a class.
    pub body: Body,
    /// What the players need of it.
    pub dancer: Arc<Dancer>,
    /// Its harmonics' classes.
    pub symmetry: Symmetry,
    /// The layers of a caricature, by name.
    pub voices: Vec<(String, Term)>,
    /// Triangles for cells of the gallery, where all would be too many.
    pub coarse: Option<Vec<[u32; 3]>>,
    /// What was mended in the file, what the harmonics are worth less than usual, and what could not act.
    pub warnings: Vec<String>,
}

/// Loads a shape, its harmonics and their symmetry classes.
pub fn shape(source: &ShapeSource, means: Means, task: &Task) -> Result<Ready, String> {
    let (mesh, mut warnings) = source::shape(source, None)?;
    let body = body(&mesh, means.harmonics, &mut warnings, task)?;
    Ready::new(body, means, Vec::new(), warnings, task)
}

/// Loads a caricature's project: its shape is the body, each acting layer a voice.
pub fn caricature(path: &Path, means: Means, task: &Task) -> Result<Ready, String> {
    let project = Project::load(path).map_err(|error| error.to_string())?;
    let folder = path.parent();
    let (mesh, mut warnings) = source::shape(&project.shape, folder)?;
    let layered = Arc::new(body(&mesh, project.harmonics, &mut warnings, task)?);
    let voices = voices(&project, &mesh, &layered, folder, &mut warnings, task)?;
    // The layers are displacements: they do not depend on how many harmonics dance.
    let body = if project.harmonics <= means.harmonics {
        (*layered).clone()
    } else {
        body(&mesh, means.harmonics, &mut warnings, task)?
    };
    Ready::new(body, means, voices, warnings, task)
}

/// The acting layers of a project on its body, each at its full strength.
pub fn voices(
    project: &Project,
    mesh: &TriMesh,
    body: &Arc<Body>,
    folder: Option<&Path>,
    warnings: &mut Vec<String>,
    task: &Task,
) -> Result<Vec<(String, Term)>, String> {
    let mut stack = Stack::new(Arc::clone(body)).map_err(|error| error.to_string())?;
    for request in stack.missing(project) {
        let matched =
            template(&request, folder).and_then(|template| request.run(mesh, body, template.as_ref(), task));
        if let Err(why) = &matched {
            warnings.push(why.to_string());
        }
        task.check().map_err(|error| error.to_string())?;
        stack.install(request, matched);
    }
    Ok(stack.evaluate(project).voices())
}

fn template(request: &MatchRequest, folder: Option<&Path>) -> Result<Option<TriMesh>, Error> {
    match &request.template {
        Template::File(path) => {
            source::mesh_file(path, folder).map(|(mesh, _)| Some(mesh)).map_err(Error::Unmatched)
        }
        Template::Sample(name) => source::sample(name).map(Some).map_err(Error::Unmatched),
        _ => Ok(None),
    }
}

fn body(mesh: &TriMesh, harmonics: usize, warnings: &mut Vec<String>, task: &Task) -> Result<Body, String> {
    let (body, doubts) = solve(mesh, harmonics, task)?;
    warnings.extend(doubts);
    Ok(body)
}

impl Ready {
    fn new(
        body: Body,
        means: Means,
        voices: Vec<(String, Term)>,
        warnings: Vec<String>,
        task: &Task,
    ) -> Result<Self, String> {
        let symmetry = Symmetry::of(&body, task).map_err(|error| error.to_string())?;
        let body = symmetry.rotated(&body);
        let dancer = Dancer::new(&body, &symmetry.classes).map_err(|error| error.to_string())?;
        let coarse = (means.coarsely && body.positions.len() > 2 * COARSE_VERTICES).then(|| {
            let rest: Vec<[f32; 3]> = body.positions.iter().map(|p| p.map(|c| c as f32)).collect();
            coarse::triangles(&rest, &body.triangles, COARSE_VERTICES)
        });
        Ok(Self { body, dancer: Arc::new(dancer), symmetry, voices, coarse, warnings })
    }
}
