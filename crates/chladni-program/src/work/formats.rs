//! The files that the program opens, by their endings: the one list of them.

use std::path::Path;

use super::source::TUNE;

pub use chladni_sound::SONG_EXTENSIONS as SONGS;

/// Meshes that can be read.
pub const MESHES: [&str; 7] = ["obj", "ply", "off", "stl", "gltf", "glb", "mesh"];
/// Caricature projects.
pub const PROJECT: &str = "chladni";
/// Presets and shows.
pub const TEXT: &str = "toml";

/// Lists of songs.
pub const LISTS: [&str; 2] = ["m3u", "m3u8"];

/// The kind of a file, by its ending.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A caricature project.
    Project,
    /// A preset or a show.
    Text,
    /// A song.
    Song,
    /// A list of songs.
    List,
    /// A mesh, or an unknown format, which reading will report.
    Mesh,
}

/// The kind of `path`, or of a sample by its name.
pub fn kind(path: &Path) -> Kind {
    let ending = path.extension().map_or_else(String::new, |ending| ending.to_string_lossy().to_lowercase());
    match ending.as_str() {
        PROJECT => Kind::Project,
        TEXT => Kind::Text,
        list if LISTS.contains(&list) => Kind::List,
        song if SONGS.contains(&song) => Kind::Song,
        _ if path == Path::new(TUNE) => Kind::Song,
        _ => Kind::Mesh,
    }
}

/// Whether `path` is named like a project.
pub fn is_project(path: &Path) -> bool {
    kind(path) == Kind::Project
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_mesh::Format;

    #[test]
    fn what_is_offered_can_be_read() {
        assert!(MESHES.iter().all(|ending| Format::from_extension(ending).is_some()));
        let kinds = ["a.CHLADNI", "a.toml", "a.Mp3", "a.obj", "a"].map(|name| kind(Path::new(name)));
        assert_eq!(kinds, [Kind::Project, Kind::Text, Kind::Song, Kind::Mesh, Kind::Mesh]);
        assert_eq!([TUNE, "sample:octopus"].map(|name| kind(Path::new(name))), [Kind::Song, Kind::Mesh]);
    }
}
