//! What was read from a file, handed on to all that follows.

use chladni_match::{MatchSettings, Method};
use chladni_mesh::{Format, Orientation, TriMesh, read_mesh, weld};
use chladni_music::SymmetrySettings;

use crate::dance::{Score, perform};
use crate::export::exported;
use crate::pipeline::{body_of, contrast};
use crate::promised;
use crate::random::Random;

/// The first byte of an input, modulo their number, says which of these the rest is.
pub const FORMATS: [Format; 7] =
    [Format::Obj, Format::Ply, Format::Off, Format::Stl, Format::Gltf, Format::Glb, Format::Medit];

const HARMONICS: u8 = 12;

/// The mesh that `bytes` hold, where it is small, and what the first byte says beside the format.
fn small(bytes: &[u8]) -> Option<(u8, TriMesh)> {
    let (first, rest) = bytes.split_first()?;
    let kinds = FORMATS.len() as u8;
    let loaded = read_mesh(rest, FORMATS[usize::from(first % kinds)]).ok()?;
    let stored = (loaded.mesh.positions.len(), loaded.mesh.triangles.len());
    if stored.0 > 1000 || stored.1 > 2000 {
        return None;
    }
    promised(&loaded);
    let welded = weld(&loaded.mesh);
    let is_small = welded.positions.len() <= 300 && welded.triangles.len() <= 600;
    is_small.then_some((first / kinds, loaded.mesh))
}

/// Reads a mesh, writes it in each format, matches it with itself distorted, and exaggerates the difference; `thoroughly` also
/// where the match looks for the pose, which takes tens of seconds under AddressSanitizer.
pub fn whole(bytes: &[u8], thoroughly: bool) {
    let Some((_, mesh)) = small(bytes) else { return };
    exported(&mesh);
    let distorted = mesh.positions.iter().map(|[x, y, z]| [1.1 * x, *y, 0.9 * z + 0.05 * x]);
    let distorted = TriMesh { positions: distorted.collect(), ..mesh.clone() };
    let same = MatchSettings { method: Method::Same, ..MatchSettings::default() };
    contrast(&mesh, &distorted, same, HARMONICS, 1.0);
    if thoroughly {
        let closest = MatchSettings { method: Method::Icp, ..MatchSettings::default() };
        contrast(&mesh, &distorted, closest, HARMONICS, 1.0);
    }
}

/// Reads a mesh and lets it dance a few frames. How it stands is given and its mirror plane not looked for: both searches
/// take seconds under AddressSanitizer.
pub fn whole_dance(bytes: &[u8]) {
    let Some((choice, mesh)) = small(bytes) else { return };
    let Some(body) = body_of(&mesh, HARMONICS) else { return };
    let score = Score::random(&mut Random::new(choice.into()));
    perform(&score, &body, &Orientation::Y_UP, &SymmetrySettings { by_vote: true, ..Default::default() });
}
