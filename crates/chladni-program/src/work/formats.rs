//! The files that the program opens, by their endings: the one list of them.

use std::path::{Path, PathBuf};

use chladni_mesh::ShapeSource;

pub use chladni_sound::SONG_EXTENSIONS as SONGS;

/// The name of the sample tune.
pub const TUNE: &str = "sample:tune";

/// Meshes that can be read.
pub const MESHES: [&str; 7] = ["obj", "ply", "off", "stl", "gltf", "glb", "mesh"];
/// Caricature projects.
pub const PROJECT: &str = "chladni";
/// Presets and shows.
pub const TEXT: &str = "toml";

/// Lists of songs.
pub const LISTS: [&str; 2] = ["m3u", "m3u8"];

/// Files that a mesh names and that are read with it, and pictures.
const COMPANIONS: [&str; 2] = ["mtl", "bin"];
const PICTURES: [&str; 11] =
    ["png", "jpg", "jpeg", "webp", "ktx2", "bmp", "gif", "tga", "tif", "tiff", "hdr"];
/// Masks that are no meshes, and landmarks.
const ARRAYS: [&str; 2] = ["npy", "npz"];
const LANDMARKS: &str = "txt";

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

/// Whether the name of `path` has one of `endings`.
pub fn ends_in(path: &Path, endings: &[&str]) -> bool {
    path.extension().is_some_and(|own| endings.iter().any(|ending| own.eq_ignore_ascii_case(ending)))
}

/// The ending of `path` in lower case; empty where it has none.
fn ending(path: &Path) -> String {
    path.extension().map_or_else(String::new, |ending| ending.to_string_lossy().to_lowercase())
}

/// The kind of `path`, or of a sample by its name.
pub fn kind(path: &Path) -> Kind {
    match ending(path).as_str() {
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

/// The files among `paths` that are opened, and a message about each other one that is read with none of them. A file of an
/// unknown ending is opened only if there is no other one: its content may say its format.
pub fn opened_together(paths: &[PathBuf]) -> (Vec<PathBuf>, Vec<String>) {
    let has_known = paths.iter().any(|path| is_known(path));
    let (mut opened, mut left_out) = (Vec::new(), Vec::new());
    for path in without_companions(paths) {
        match opened_elsewhere(&path) {
            Some(why) => left_out.push(why),
            None if has_known && !is_known(&path) => {
                left_out.push(format!("{}: is no file that is opened here", path.display()));
            }
            None => opened.push(path),
        }
    }
    (opened, left_out)
}

/// Whether the name of `path` says its kind; a folder is a list of songs.
fn is_known(path: &Path) -> bool {
    kind(path) != Kind::Mesh
        || ends_in(path, &MESHES)
        || ShapeSource::sample_name(path).is_some()
        || path.is_dir()
}

/// The files among `paths` that are opened by themselves: where there is a mesh or a project, what lies beside it with its
/// materials and textures is read by it.
pub fn without_companions(paths: &[PathBuf]) -> Vec<PathBuf> {
    let is_shape = |path: &PathBuf| is_project(path) || ends_in(path, &MESHES);
    let has_shape = paths.iter().any(is_shape);
    let is_companion = |path: &PathBuf| ends_in(path, &COMPANIONS) || ends_in(path, &PICTURES);
    paths.iter().filter(|path| !has_shape || !is_companion(path)).cloned().collect()
}

/// Why a file whose ending is no shape's is not opened here, and where it can be opened, as a message with its path; `None`
/// where it may be a mesh.
fn opened_elsewhere(path: &Path) -> Option<String> {
    let why = match ending(path).as_str() {
        named if COMPANIONS.contains(&named) => "is read with the mesh that names it: open that one",
        picture if PICTURES.contains(&picture) => {
            "is a picture and no shape: a texture is read with the mesh that names it"
        }
        array if ARRAYS.contains(&array) => "is no shape: masks are opened under Region, Mask",
        LANDMARKS => "is no shape: landmarks are opened under Template, Landmarks",
        _ => return None,
    };
    Some(format!("{}: {why}", path.display()))
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

    #[test]
    fn what_lies_beside_a_mesh_is_not_opened_by_itself() {
        let opened = |names: &[&str]| {
            let paths: Vec<PathBuf> = names.iter().map(PathBuf::from).collect();
            let opened = without_companions(&paths).into_iter();
            opened.map(|path| path.to_string_lossy().into_owned()).collect::<Vec<_>>()
        };
        assert_eq!(opened(&["a.mtl", "a.OBJ", "a.png", "b.xyz"]), ["a.OBJ", "b.xyz"]);
        assert_eq!(opened(&["a.bin", "a.chladni", "a.KTX2"]), ["a.chladni"]);
        assert_eq!(opened(&["a.png", "a.mtl"]), ["a.png", "a.mtl"]);
        let (known, left_out) = opened_together(&["LICENSE", "a.obj", "b.npy"].map(PathBuf::from));
        assert_eq!(known, [PathBuf::from("a.obj")]);
        assert!(
            left_out.len() == 2
                && left_out[0].contains("LICENSE: is no file")
                && left_out[1].contains("b.npy")
        );
        let album = ["a.cue", "b.mp3", "sample:octopus"].map(PathBuf::from);
        assert_eq!(
            opened_together(&album),
            (album[1..].to_vec(), vec!["a.cue: is no file that is opened here".into()])
        );
        assert_eq!(opened_together(&["scan".into()]), (vec!["scan".into()], Vec::new()));
        let is_shape = |name: &str| opened_elsewhere(Path::new(name)).is_none();
        assert!(MESHES.iter().chain([&PROJECT]).all(|ending| is_shape(&format!("a.{ending}"))));
        assert!(["a", "a.xyz", "sample:octopus"].into_iter().all(is_shape));
        assert!(!["a.png", "a.npy", "a.TXT", "a.mtl"].into_iter().any(is_shape));
    }
}
