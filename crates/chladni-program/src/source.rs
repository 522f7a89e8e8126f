//! Meshes by the names that users give them: a path, or `sample:NAME`.

use std::path::{Path, PathBuf};

use chladni_caricature::ShapeSource;
use chladni_mesh::{Loaded, TriMesh, load_mesh, samples};

/// The shape of a project that lives in `folder`, and what was mended while reading it.
pub fn shape(source: &ShapeSource, folder: Option<&Path>) -> Result<(TriMesh, Vec<String>), String> {
    match source {
        ShapeSource::File(path) => mesh_file(path, folder),
        ShapeSource::Sample(name) => Ok((sample(name)?, Vec::new())),
    }
}

/// What the command line names: a file, or `sample:NAME`.
pub fn named(name: &Path) -> Result<Loaded, String> {
    match name.to_str().and_then(|name| name.strip_prefix("sample:")) {
        Some(name) => Ok(Loaded { mesh: sample(name)?, mended: Vec::new(), stored_positions: None }),
        None => load_mesh(name).map_err(|error| error.to_string()),
    }
}

/// A mesh file; a relative path starts from `folder`.
pub fn mesh_file(path: &Path, folder: Option<&Path>) -> Result<(TriMesh, Vec<String>), String> {
    let path: PathBuf = folder.map_or_else(|| path.to_owned(), |folder| folder.join(path));
    let loaded = load_mesh(&path).map_err(|error| error.to_string())?;
    let warnings = loaded.mended.iter().map(|mended| format!("{}: {mended}", path.display())).collect();
    Ok((loaded.mesh, warnings))
}

/// A sample shape by its name without the prefix.
pub fn sample(name: &str) -> Result<TriMesh, String> {
    samples::sample(name).ok_or_else(|| {
        format!("sample:{name}: there is no such sample; there are {}", samples::SAMPLES.join(", "))
    })
}
