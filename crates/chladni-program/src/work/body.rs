//! Shapes with their harmonics.

use chladni_harmonics::{BasisCache, BasisSettings, BasisWarning, Body, BuildReport, Laplacian};
use chladni_mesh::TriMesh;

use super::{Error, Warning, Watcher};

/// Where solved bases are cached: the folder named by `CHLADNI_CACHE`, else the user's cache folder; `None`,
/// without caching, if there is neither.
pub fn basis_cache() -> Option<BasisCache> {
    match std::env::var_os("CHLADNI_CACHE") {
        Some(folder) if !folder.is_empty() => Some(BasisCache::new(folder)),
        _ => BasisCache::of_user(),
    }
}

/// The operator of paper mode, or the usual one.
pub fn laplacian(paper: bool) -> Laplacian {
    if paper { Laplacian::Cotangent } else { Laplacian::Delaunay }
}

/// As many harmonics of the mesh called `name` as asked for, or all there are where it has fewer vertices;
/// from the user's cache where they are there.
///
/// # Errors
/// [`Error::Harmonics`] with that name.
pub fn build(
    name: &str,
    mesh: &TriMesh,
    harmonics: usize,
    laplacian: Laplacian,
    watcher: &impl Watcher,
) -> Result<(Body, BuildReport), Error> {
    let cache = basis_cache();
    let settings = BasisSettings { laplacian, ..BasisSettings::new(harmonics) };
    let (body, report) = watcher
        .watch("solving for harmonics", |task| Body::load_or_build(mesh, &settings, cache.as_ref(), task))
        .map_err(|error| Error::from(error).of(name))?;
    for warning in report.warnings(&body.basis.certificate) {
        watcher.warn(match warning {
            BasisWarning::FewerHarmonics { asked, vertices } => {
                Warning::FewerHarmonics { name: name.to_owned(), vertices, asked }
            }
            warning => Warning::of(name, warning),
        });
    }
    Ok((body, report))
}
