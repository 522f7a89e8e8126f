//! Meshes that commands take: files, or samples by name.

use chladni_harmonics::{BasisSettings, Body, BuildReport, HarmonicsError};
use chladni_mesh::{TriMesh, load_mesh, samples};

use super::{Failure, Terminal, basis_cache};

/// Reads a mesh file, or makes `sample:NAME`; tells what had to be mended.
pub fn open_mesh(name: &str, terminal: &Terminal) -> Result<TriMesh, Failure> {
    if let Some(sample) = name.strip_prefix("sample:") {
        return samples::sample(sample).ok_or_else(|| {
            let known = samples::SAMPLES.join(", ");
            Failure::BadInput(format!("there is no sample shape {sample}; there are {known}"))
        });
    }
    let path = std::path::Path::new(name);
    let loaded = terminal.watch("reading the mesh", |_| load_mesh(path)).map_err(Failure::input)?;
    for line in &loaded.mended {
        terminal.warn(format_args!("{name}: {line}"));
    }
    Ok(loaded.mesh)
}

/// The harmonics of a mesh, from the user's cache where they are there.
pub fn build_body(
    name: &str,
    mesh: &TriMesh,
    harmonics: usize,
    terminal: &Terminal,
) -> Result<(Body, BuildReport), Failure> {
    let cache = basis_cache();
    let (body, report) = terminal
        .watch("solving for harmonics", |task| {
            Body::load_or_build(mesh, &BasisSettings::new(harmonics), cache.as_ref(), task)
        })
        .map_err(|error| match error {
            HarmonicsError::Cancelled(_) => Failure::Cancelled,
            error => Failure::BadInput(format!("{name}: {error}")),
        })?;
    if let Some(warning) = &report.cache_warning {
        terminal.warn(warning);
    }
    Ok((body, report))
}
