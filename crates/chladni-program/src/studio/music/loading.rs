//! Shapes and caricatures, made ready to dance.

use std::path::Path;
use std::sync::Arc;

use chladni_caricature::{Error, MatchRequest, Project, ShapeSource, Stack, Template};
use chladni_harmonics::{Body, Laplacian};
use chladni_mesh::{Estimate, Known, Orientation, TriMesh};
use chladni_music::{Dancer, Symmetry};
use chladni_synth::Term;
use chladni_task::Task;

use super::coarse::{self, Level};
use crate::source;
use crate::studio::bodies::solve;

/// Vertices of the smallest level of detail where the processor draws, and how many times as many the next
/// larger one has.
const FEWEST_VERTICES: usize = 600;
const LEVEL_RATIO: f64 = 1.5;

/// How a shape is made ready.
#[derive(Clone, Copy, Debug)]
pub struct Means {
    /// So many harmonics dance at most.
    pub harmonics: usize,
    /// The processor draws: small pictures of large shapes show fewer triangles.
    pub coarsely: bool,
}

/// What loading brings back.
pub struct Ready {
    /// The body; harmonics of repeated eigenvalues are mixed so that they have a class.
    pub body: Body,
    /// How it stands.
    pub stands: Orientation,
    /// What the players need of it.
    pub dancer: Arc<Dancer>,
    /// Its harmonics' classes.
    pub symmetry: Symmetry,
    /// The layers of a caricature, by name.
    pub voices: Vec<(String, Term)>,
    /// The shape with fewer vertices for small pictures, from fine to coarse, where all would be too many.
    pub levels: Vec<Level>,
    /// What was mended in the file, what the harmonics are worth less than usual, and what could not act.
    pub warnings: Vec<String>,
}

/// Loads a shape, its harmonics and their symmetry classes.
pub fn shape(source: &ShapeSource, means: Means, task: &Task) -> Result<Ready, String> {
    let (mesh, mut warnings) = source::shape(source, None)?;
    let body = body(&mesh, means.harmonics, &mut warnings, task)?;
    Ready::new(body, None, means, Vec::new(), warnings, task)
}

/// Loads a caricature's project: its shape is the body, each acting layer a voice.
pub fn caricature(path: &Path, means: Means, task: &Task) -> Result<Ready, String> {
    let project = Project::load(path).map_err(|error| error.to_string())?;
    let folder = path.parent();
    let (mesh, mut warnings) = source::shape(&project.shape, folder)?;
    warnings.extend(project.taken_over().map(|told| format!("This is {told}.")));
    let layered = Arc::new(body(&mesh, project.harmonics, &mut warnings, task)?);
    let voices = voices(&project, &mesh, &layered, folder, &mut warnings, task)?;
    // The layers are displacements: they do not depend on how many harmonics dance.
    let body = if project.harmonics <= means.harmonics {
        (*layered).clone()
    } else {
        body(&mesh, means.harmonics, &mut warnings, task)?
    };
    Ready::new(body, project.stands, means, voices, warnings, task)
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
    let (body, doubts) = solve(mesh, harmonics, Laplacian::Delaunay, task)?;
    warnings.extend(doubts);
    Ok(body)
}

impl Ready {
    fn new(
        body: Body,
        stands: Option<Orientation>,
        means: Means,
        voices: Vec<(String, Term)>,
        warnings: Vec<String>,
        task: &Task,
    ) -> Result<Self, String> {
        let (symmetry, levels) = rayon::join(
            || Symmetry::of(&body, task),
            || if means.coarsely { levels(&body) } else { Vec::new() },
        );
        let estimate = || Estimate::of_surface(&body.positions, &body.triangles, Known::default(), task);
        let stands = match stands {
            Some(told) => told,
            None => estimate().map_err(|error| error.to_string())?.orientation,
        };
        let symmetry = symmetry.map_err(|error| error.to_string())?;
        let body = symmetry.rotated(&body);
        let dancer = Dancer::new(&body, &symmetry.classes).map_err(|error| error.to_string())?;
        Ok(Self { body, stands, dancer: Arc::new(dancer), symmetry, voices, levels, warnings })
    }
}

fn levels(body: &Body) -> Vec<Level> {
    let sizes = std::iter::successors(Some(FEWEST_VERTICES as f64), |size| Some(LEVEL_RATIO * size));
    // A level that saves little is none.
    let most = body.positions.len() as f64 / LEVEL_RATIO;
    let mut wanted: Vec<usize> = sizes.take_while(|size| *size <= most).map(|size| size as usize).collect();
    wanted.reverse();
    let rest: Vec<[f32; 3]> = body.positions.iter().map(|p| p.map(|c| c as f32)).collect();
    coarse::levels(&rest, &body.triangles, &wanted)
}
