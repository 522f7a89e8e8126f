//! Names of an open project and of the files made from it.

use std::path::PathBuf;

use chladni_caricature::ShapeSource;

use super::Session;

impl Session {
    /// The name of the project's file, beside the shape where it was never saved.
    pub fn beside(&self, extension: &str) -> PathBuf {
        self.own_path().with_extension(extension)
    }

    /// A name for a file made from this project, such as `igea-caricature.glb`.
    pub fn beside_named(&self, addition: &str, extension: &str) -> PathBuf {
        let path = self.own_path();
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        path.with_file_name(format!("{stem}-{addition}.{extension}"))
    }

    fn own_path(&self) -> PathBuf {
        match (&self.path, &self.project().shape) {
            (Some(path), _) | (None, ShapeSource::File(path)) => path.clone(),
            (None, ShapeSource::Sample(name)) => PathBuf::from(name.split('?').next().unwrap_or(name)),
        }
    }

    /// Its name in the window's title and on the start screen.
    pub fn name(&self) -> String {
        match (&self.path, &self.project().shape) {
            (Some(path), _) | (None, ShapeSource::File(path)) => path
                .file_stem()
                .map_or_else(|| path.display().to_string(), |stem| stem.to_string_lossy().into_owned()),
            (None, ShapeSource::Sample(name)) => format!("sample {name}"),
        }
    }
}
