//! Shapes with their harmonics, for all rooms.

use chladni_harmonics::{BasisSettings, BasisWarning, Body, Laplacian};
use chladni_mesh::TriMesh;
use chladni_task::Task;

/// A shape with its harmonics, and what a person should know of them; or why there are none.
pub type Solved = Result<(Body, Vec<String>), String>;

/// The first `harmonics` harmonics of `mesh`, or all it has where those are fewer.
pub fn solve(mesh: &TriMesh, harmonics: usize, laplacian: Laplacian, task: &Task) -> Solved {
    let cache = crate::cli::basis_cache();
    let settings = BasisSettings { laplacian, ..BasisSettings::new(harmonics.max(1)) };
    let built = Body::load_or_build(mesh, &settings, cache.as_ref(), task);
    let (body, report) = built.map_err(|error| error.to_string())?;
    let warnings = report.warnings(&body.basis.certificate);
    // K stands where it is chosen.
    let told = warnings.iter().filter(|warning| !matches!(warning, BasisWarning::FewerHarmonics { .. }));
    Ok((body, told.map(BasisWarning::to_string).collect()))
}
