//! Shapes with their harmonics.

use chladni_caricature::ProxyKey;
use chladni_harmonics::{
    Basis, BasisCache, BasisSettings, BasisWarning, Body, BuildReport, HarmonicsError, Laplacian,
};
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
/// [`Error::Harmonics`] with that name; [`Error::Input`] with a way out where there are too many.
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
        .map_err(|error| advised(error).of(name))?;
    for warning in report.warnings(&body.basis.certificate) {
        watcher.warn(match warning {
            BasisWarning::FewerHarmonics { asked, vertices } => {
                Warning::FewerHarmonics { name: name.to_owned(), vertices, asked }
            }
            warning => Warning::of(name, warning),
        });
    }
    watcher.warn_each(many_pieces(name, &body.basis));
    Ok((body, report))
}

/// A warning where more than a quarter of the harmonics of the shape called `name` are constants of its pieces, which
/// give it no form.
fn many_pieces(name: &str, basis: &Basis) -> Option<Warning> {
    let (constants, harmonics) = (basis.constants(), basis.harmonics());
    let are_many = constants > 1 && 4 * constants > harmonics;
    are_many.then(|| Warning::ManyPieces { name: name.to_owned(), constants, harmonics })
}

/// The error of a solve, with a way out where there are too many harmonics and enough vertices for a proxy.
fn advised(error: HarmonicsError) -> Error {
    match error {
        HarmonicsError::TooMany { vertices, .. } if vertices >= 2 * ProxyKey::FEWEST => {
            Error::input(format_args!(
                "{error}; ask for fewer harmonics, or work on fewer of its vertices: chladni project new \
                 --proxy N"
            ))
        }
        error => error.into(),
    }
}

#[cfg(test)]
mod tests {
    use chladni_mesh::samples::icosphere;
    use chladni_task::Task;

    use super::*;

    #[test]
    fn pieces_that_take_many_harmonics_are_warned_of() {
        let ball = icosphere(0);
        let mut mesh = TriMesh::default();
        for i in 0..5_u32 {
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(ball.positions.iter().map(|[x, y, z]| [x + 4.0 * f64::from(i), *y, *z]));
            mesh.triangles.extend(ball.triangles.iter().map(|t| t.map(|v| v + first)));
        }
        let warned = |harmonics| {
            let body = Body::build(&mesh, &BasisSettings::new(harmonics), &Task::new()).unwrap();
            many_pieces("balls", &body.basis).map(|warning| warning.to_string())
        };
        assert!(warned(8).is_some_and(|warning| warning.starts_with("balls: 5 of 8 harmonics")));
        assert!(warned(19).is_some());
        assert_eq!((warned(20), warned(1)), (None, None));
    }

    #[test]
    fn what_is_too_large_has_a_way_out_where_there_is_one() {
        let of = |vertices| {
            let reason = "they are too many".to_owned();
            advised(HarmonicsError::TooMany { harmonics: 9, vertices, reason }).to_string()
        };
        assert!(of(200).contains("too many; ask for fewer harmonics") && of(200).contains("--proxy N"));
        assert!(of(199).ends_with("they are too many"));
    }
}
