//! Preparing shapes and caricatures to dance.

use std::path::Path;

use chladni_harmonics::{Body, Laplacian};
use chladni_mesh::Orientation;
use chladni_mesh::surface::vec3::single;
use chladni_mesh::surface::{Detail, details as simplified};
use chladni_music::Viewpoint;
use chladni_synth::Term;
use chladni_task::Task;

use crate::work::dancer::{Dancing, classes};
use crate::work::{Aside, Cast, Error, OwnLook, Stance, Warning, opening_view};

/// Vertices of the smallest level of detail where the processor draws, and how many times as many the next
/// larger one has.
const FEWEST_VERTICES: usize = 600;
const LEVEL_RATIO: f64 = 1.5;

/// How a shape is made ready.
#[derive(Clone, Copy, Debug)]
pub struct Means {
    /// The largest number of harmonics.
    pub harmonics: usize,
    /// The processor draws: small pictures of large shapes show fewer triangles.
    pub coarsely: bool,
}

/// The result of loading.
pub struct Ready {
    /// The body and what players need of it.
    pub dancing: Dancing,
    /// How it stands, as its project or sample says, or by an estimate.
    pub stands: Orientation,
    /// Whether that is in doubt.
    pub in_doubt: bool,
    /// From where it is seen first.
    pub opening_view: Viewpoint,
    /// The layers of a caricature, by name, each at its full strength.
    pub voices: Vec<(String, Term)>,
    /// The shape with fewer vertices for small pictures, from fine to coarse, where all would be too many.
    pub details: Vec<Detail>,
    /// The shape's own colors, where its file has some.
    pub own: Option<OwnLook>,
    /// Warnings: repairs of the file, how the harmonics are less exact than usual, and which layers
    /// cannot act.
    pub warnings: Vec<Warning>,
}

/// Loads a shape, or a caricature's project, whose shape is the body and whose acting layers are voices: with
/// its harmonics and their symmetry classes. `knows` is [what the user knows](Aside::knowing).
///
/// # Errors
/// Whatever is wrong with the file or the shape.
pub fn load(
    path: &Path,
    knows: impl Fn(&Path, &Path) -> bool,
    means: Means,
    task: &Task,
) -> Result<Ready, Error> {
    let aside = Aside::new(task).knowing(knows);
    let cast = Cast::open(path, &aside)?;
    let subject = cast.subject().clone();
    let stands = cast.stands(Stance::default(), None, &aside)?;
    let harmonics = cast.harmonics(means.harmonics);
    let (body, voices) = cast.prepare(harmonics, Laplacian::Delaunay, true, &aside)?;
    let (symmetry, details) = rayon::join(
        || classes(&body, false, task),
        || if means.coarsely { details(&body) } else { Vec::new() },
    );
    let dancing = Dancing::new(&body, symmetry?, &stands)?;
    let name = path.to_string_lossy();
    let own = OwnLook::of_subject(&name, &subject, &body, &aside);
    let opening_view = opening_view(&name);
    let warnings = aside.warnings();
    let in_doubt = warnings.iter().any(|warning| matches!(warning, Warning::InDoubt { .. }));
    Ok(Ready { dancing, stands, in_doubt, opening_view, voices, details, own, warnings })
}

fn details(body: &Body) -> Vec<Detail> {
    let sizes = std::iter::successors(Some(FEWEST_VERTICES as f64), |size| Some(LEVEL_RATIO * size));
    // Skip levels that save little.
    let most = body.positions.len() as f64 / LEVEL_RATIO;
    let mut wanted: Vec<usize> = sizes.take_while(|size| *size <= most).map(|size| size as usize).collect();
    wanted.reverse();
    simplified(&single(&body.positions), &body.triangles, &wanted)
}
