//! Meshes by the names that users give them: a path, or `sample:NAME`.

use std::path::{Path, PathBuf};

use chladni_caricature::ShapeSource;
use chladni_mesh::TriMesh;

/// The names of the sample shapes.
pub const SAMPLES: [&str; 3] = ["head", "template", "octopus"];

/// The shape of a project that lives in `folder`, and what was mended while reading it.
pub fn shape(source: &ShapeSource, folder: Option<&Path>) -> Result<(TriMesh, Vec<String>), String> {
    match source {
        ShapeSource::File(path) => mesh_file(path, folder),
        ShapeSource::Sample(name) => Ok((sample(name)?, Vec::new())),
    }
}

/// A mesh file; a relative path starts from `folder`.
pub fn mesh_file(path: &Path, folder: Option<&Path>) -> Result<(TriMesh, Vec<String>), String> {
    let path: PathBuf = folder.map_or_else(|| path.to_owned(), |folder| folder.join(path));
    let loaded = chladni_mesh::load_mesh(&path).map_err(|error| error.to_string())?;
    let warnings = loaded.mended.iter().map(|mended| format!("{}: {mended}", path.display())).collect();
    Ok((loaded.mesh, warnings))
}

/// A sample shape by its name without the prefix.
pub fn sample(name: &str) -> Result<TriMesh, String> {
    chladni_mesh::samples::sample(name)
        .ok_or_else(|| format!("sample:{name}: there is no such sample; there are {}", SAMPLES.join(", ")))
}
