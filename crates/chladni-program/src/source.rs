//! Meshes by the names that users give them: a path, or `sample:NAME`.

use std::path::Path;

use chladni_mesh::{Loaded, ShapeSource, TriMesh};

/// The shape of a project that lives in `folder`, and what was mended while reading it.
pub fn shape(source: &ShapeSource, folder: Option<&Path>) -> Result<(TriMesh, Vec<String>), String> {
    let loaded = source.load(folder).map_err(|error| error.to_string())?;
    let path = match (source, folder) {
        (ShapeSource::File(path), Some(folder)) => folder.join(path).display().to_string(),
        _ => source.to_string(),
    };
    let warnings = loaded.mended.iter().map(|mended| format!("{path}: {mended}")).collect();
    Ok((loaded.mesh, warnings))
}

/// What the command line names: a file, or `sample:NAME`.
pub fn named(name: &Path) -> Result<Loaded, String> {
    ShapeSource::named(name).load(None).map_err(|error| error.to_string())
}

/// A mesh file; a relative path starts from `folder`.
pub fn mesh_file(path: &Path, folder: Option<&Path>) -> Result<(TriMesh, Vec<String>), String> {
    shape(&ShapeSource::File(path.to_owned()), folder)
}

/// A sample shape by its name without the prefix.
pub fn sample(name: &str) -> Result<TriMesh, String> {
    shape(&ShapeSource::Sample(name.to_owned()), None).map(|(mesh, _)| mesh)
}
