//! Checks where results go before the work: a missing folder is reported at once, not after minutes of
//! computing.

use std::path::{Path, PathBuf, is_separator};

use chladni_caricature::Template;
use chladni_mesh::{
    Format, Material, ShapeSource, Texture, TriMesh, check_glb, name_within, pictures_beside,
};
use chladni_task::{folder_of, read_file};
use chladni_view::film::frame_path;
use chladni_view::{FilmFormat, ViewError, ffmpeg_is_there};

use super::formats::ends_in;
use super::left_out::{is_gltf, other_picture};
use super::{Error, Warning};

/// Pixels that a picture has at most: a drawing in ink takes some twenty bytes of memory for each.
const MOST_PIXELS: u64 = 64 << 20;

/// Checks that a picture of this size is not too large for memory.
///
/// # Errors
/// [`Error::Input`] with its size.
pub fn check_size(width: u32, height: u32) -> Result<(), Error> {
    if u64::from(width) * u64::from(height) <= MOST_PIXELS {
        return Ok(());
    }
    Err(Error::Input(format!("{width} × {height} pixels are more than 64 megapixels: take a smaller size")))
}

/// Checks that a file can be written at `path`.
///
/// # Errors
/// [`Error::Input`] or [`Error::Unwritten`], with the path.
pub fn check_file(path: &Path) -> Result<(), Error> {
    let refused = |why: &str| Err(Error::Input(format!("{}: {why}", path.display())));
    if path.is_dir() {
        return refused("is a folder; the name of a file is needed");
    }
    if path.exists() && !path.is_file() {
        return refused("is a device or a pipe; the name of a file is needed");
    }
    if path.as_os_str().as_encoded_bytes().last().is_some_and(|last| is_separator(char::from(*last))) {
        return refused("is the name of a folder; that of a file is needed");
    }
    let folder = folder_of(path);
    if !folder.is_dir() {
        return refused("its folder does not exist");
    }
    check_writable(folder, path)
}

/// Checks that files can be written into the folder, as `path` needs.
fn check_writable(folder: &Path, path: &Path) -> Result<(), Error> {
    tempfile::tempfile_in(folder).map(drop).map_err(|error| Error::unwritten(path, error.kind().to_string()))
}

/// Checks that files can be written into the folder `path`, which is created if it does not exist.
///
/// # Errors
/// As [`check_file`] does, and [`Error::Input`] for a file.
pub fn check_folder(path: &Path) -> Result<(), Error> {
    // With a slash at its end, a file would be no file.
    let bare: PathBuf = path.components().collect();
    let path = bare.as_path();
    if path.is_dir() {
        check_writable(path, path)
    } else if path.exists() {
        Err(Error::Input(format!("{}: is a file; the name of a folder is needed", path.display())))
    } else {
        check_file(path)
    }
}

/// Checks that a folder can be made at `path`, with those around it, and be written into.
///
/// # Errors
/// As [`check_folder`] does for the innermost folder that is there.
pub fn check_folders(path: &Path) -> Result<(), Error> {
    check_folder(path.ancestors().find(|folder| folder.exists()).unwrap_or(Path::new(".")))
}

/// Checks that a film can be written at `path`: a file, or frames into a folder.
///
/// # Errors
/// As [`check_file`] does, and [`Error::Other`] for an MP4 where there is no ffmpeg, with `others` that need none.
pub fn check_film(path: &Path, others: &str) -> Result<(), Error> {
    match FilmFormat::of(path).map_err(Error::input)? {
        FilmFormat::Frames => check_folder(path),
        FilmFormat::Mp4 => {
            check_file(path)?;
            let advised = |why: ViewError| Error::other(format!("{why}; {others} need none"));
            check_ffmpeg().map_err(|why| advised(why).of(path.display()))
        }
        FilmFormat::Gif | FilmFormat::Apng => check_file(path),
    }
}

/// Checks that ffmpeg can be started.
///
/// # Errors
/// [`ViewError::NoFfmpeg`].
pub fn check_ffmpeg() -> Result<(), ViewError> {
    if ffmpeg_is_there() { Ok(()) } else { Err(ViewError::NoFfmpeg) }
}

/// A warning where a folder has frames of a longer film, which stay behind those of one of `frames` frames.
pub fn earlier_frames(folder: &Path, frames: u64) -> Option<Warning> {
    let next = frame_path(folder, frames);
    let name = next.file_name()?.to_string_lossy();
    next.is_file()
        .then(|| Warning::of(folder.display(), format!("{name} and those after it are of an earlier film")))
}

/// A warning where the film at `path` is an MP4 and leaves out the last column or row of pictures of this size.
pub fn odd_sides(path: &Path, size: [u32; 2]) -> Option<Warning> {
    let is_mp4 = FilmFormat::of(path).is_ok_and(|format| format == FilmFormat::Mp4);
    let even = size.map(|side| side & !1);
    let [width, height] = even;
    (is_mp4 && even != size)
        .then(|| Warning::of(path.display(), format!("an MP4 has even sides: {width}×{height}")))
}

/// Checks that a picture can be written at `path`, whose name must end in `.png`.
///
/// # Errors
/// As [`check_file`] does.
pub fn check_picture(path: &Path) -> Result<(), Error> {
    check_endings(path, &["png"])
}

/// Checks that a picture can be written at `path`, whose name must end in one of `endings`.
///
/// # Errors
/// As [`check_file`] does.
pub fn check_endings(path: &Path, endings: &[&str]) -> Result<(), Error> {
    check_named(path, "a picture ends", endings)
}

/// Checks that arrays can be written at `path`, whose name must end in `.npz`.
///
/// # Errors
/// As [`check_file`] does.
pub fn check_arrays(path: &Path) -> Result<(), Error> {
    check_named(path, "arrays are written into a file that ends", &["npz"])
}

/// Checks that a mesh can be written at `path`, and that none of `inputs` lies there.
///
/// # Errors
/// As [`check_file`] does.
pub fn check_mesh(path: &Path, inputs: &[&Path]) -> Result<(), Error> {
    mesh_format(path)?;
    check_file(path)?;
    check_apart(path, inputs)
}

/// The format in which a mesh is written at `path`.
///
/// # Errors
/// [`Error::Input`], with the path, where meshes are not written so.
pub fn mesh_format(path: &Path) -> Result<Format, Error> {
    match Format::of_path(path) {
        Some(format @ (Format::Obj | Format::Ply | Format::Stl | Format::Glb)) => Ok(format),
        _ => Err(Error::Input(format!("{}: results are written as obj, ply, stl or glb", path.display()))),
    }
}

/// Checks that a file written to `path` replaces none of `inputs`.
///
/// # Errors
/// [`Error::Input`], with the path.
pub fn check_apart(path: &Path, inputs: &[&Path]) -> Result<(), Error> {
    if inputs.iter().any(|input| is_same_file(path, input)) {
        let why = format!("{}: is read, too, and would be replaced; choose another name", path.display());
        return Err(Error::Input(why));
    }
    Ok(())
}

/// Checks that a picture written to `path` replaces none that `mesh`, which was read from the file `shape`, names: its
/// textures lie beside it. Files that it names elsewhere are not touched, not even to ask whether they are there.
///
/// # Errors
/// [`Error::Input`], with the path.
pub fn check_no_texture(path: &Path, shape: &Path, mesh: &TriMesh) -> Result<(), Error> {
    let folder = folder_of(shape);
    // One that a GLB holds itself may have the name of any file.
    let is_file = |name: &str, bytes: &[u8]| {
        let there = || read_file(&folder.join(name), bytes.len() as u64);
        bytes.is_empty() || there().is_ok_and(|there| there == bytes)
    };
    let own_name =
        |texture: &Texture| name_within(&texture.name).filter(|name| is_file(name, &texture.bytes));
    let names = |material: &Material| {
        let color = material.base_color_texture.iter().filter_map(own_name);
        let others = material.other_statements.iter().filter_map(|statement| other_picture(statement));
        color.chain(others.flatten()).collect::<Vec<_>>()
    };
    // The mesh knows only the pictures of colors of a glTF file; a GLB replaces none of them.
    let of_gltf = if is_gltf(shape) && path.is_file() && !is_gltf(path) {
        read_file(shape, u64::MAX).map(|bytes| pictures_beside(&bytes)).unwrap_or_default()
    } else {
        Vec::new()
    };
    let of_gltf = of_gltf.iter().filter_map(|name| name_within(name));
    for name in mesh.appearance.materials.iter().flat_map(names).chain(of_gltf) {
        check_apart(path, &[&folder.join(name)])?;
    }
    Ok(())
}

/// Checks that none of the pictures or films at `paths` replaces a texture of a shape or of the meshes among `templates`.
///
/// # Errors
/// [`Error::Input`], with the path.
pub fn check_textures<'a>(
    paths: &[&Path],
    (shape, mesh): (&ShapeSource, &TriMesh),
    templates: impl Iterator<Item = &'a Template>,
) -> Result<(), Error> {
    let there: Vec<&Path> = paths.iter().copied().filter(|path| path.is_file()).collect();
    if there.is_empty() {
        return Ok(());
    }
    let check =
        |file: &Path, mesh: &TriMesh| there.iter().try_for_each(|path| check_no_texture(path, file, mesh));
    shape.file().map_or(Ok(()), |file| check(file, mesh))?;
    for file in templates.filter_map(Template::file) {
        // One that cannot be read is reported by its layer.
        if let Ok(loaded) = ShapeSource::named(file).load(None) {
            check(file, &loaded.mesh)?;
        }
    }
    Ok(())
}

/// Checks, before the work, that all of `mesh`, with this number of morph `targets`, fits in the GLB at `output`. Where the
/// shape comes from a glTF file nothing is checked: that file is kept and only gains targets.
///
/// # Errors
/// [`Error::Unwritten`], with the path.
pub fn check_fits(
    output: &Path,
    (shape, mesh): (&ShapeSource, &TriMesh),
    targets: usize,
) -> Result<(), Error> {
    if Format::of_path(output) != Some(Format::Glb) || shape.file().is_some_and(is_gltf) {
        return Ok(());
    }
    check_glb(mesh, targets).map_err(|error| Error::unwritten(output, error))
}

/// Checks that no two of `outputs` are one file, where the later would replace the other.
///
/// # Errors
/// [`Error::Input`], with the path.
pub fn check_distinct(outputs: &[&Path]) -> Result<(), Error> {
    let mut rest = outputs;
    while let [path, others @ ..] = rest {
        if others.iter().any(|other| is_one_place(path, other)) {
            let why = "two results would be written there; choose another name for one of them";
            return Err(Error::Input(format!("{}: {why}", path.display())));
        }
        rest = others;
    }
    Ok(())
}

/// Whether both paths lead to one file that is there.
pub fn is_same_file(a: &Path, b: &Path) -> bool {
    let real = |path: &Path| path.canonicalize().ok();
    real(a).is_some_and(|place| real(b) == Some(place))
}

/// Whether files that are written to both paths would be one file, which need not be there.
pub fn is_one_place(a: &Path, b: &Path) -> bool {
    let real = |path: &Path| Some(folder_of(path).canonicalize().ok()?.join(path.file_name()?));
    a == b || is_same_file(a, b) || real(a).is_some_and(|place| real(b) == Some(place))
}

fn check_named(path: &Path, what: &str, endings: &[&str]) -> Result<(), Error> {
    if !ends_in(path, endings) {
        let listed = endings.join(" or .");
        return Err(Error::Input(format!("{}: {what} in .{listed}", path.display())));
    }
    check_file(path)
}

#[cfg(test)]
mod tests {
    use super::super::left_out::{left_pictures, pictures_apart};
    use super::*;

    #[test]
    fn a_picture_has_64_megapixels_at_most() {
        for [width, height] in [[16_384, 4096], [4096, 16_384], [8192, 8192], [16, 16]] {
            assert!(check_size(width, height).is_ok(), "{width} × {height}");
        }
        let why = check_size(16_384, 4097).unwrap_err().to_string();
        assert!(why.contains("16384 × 4097") && why.contains("64 megapixels"), "{why}");
    }

    #[test]
    fn an_mp4_of_odd_sides_says_how_large_it_is() {
        let said = |name: &str, size| odd_sides(Path::new(name), size).map(|warning| warning.to_string());
        for size in [[321, 181], [320, 181], [321, 180]] {
            assert_eq!(said("odd.mp4", size).as_deref(), Some("odd.mp4: an MP4 has even sides: 320×180"));
            assert_eq!((said("odd.gif", size), said("frames", size)), (None, None));
        }
        assert_eq!(said("even.mp4", [320, 180]), None);
    }

    #[test]
    fn what_no_glb_holds_is_refused_before_the_work() {
        let ball = chladni_mesh::samples::icosphere(0);
        let refused = |output: &str, shape: &str, targets| {
            check_fits(Path::new(output), (&ShapeSource::named(Path::new(shape)), &ball), targets).is_err()
        };
        let many = 20_000_000;
        assert!(refused("out.glb", "scan.ply", many) && !refused("out.glb", "scan.ply", 2));
        assert!(!refused("out.ply", "scan.ply", many) && !refused("out.glb", "scan.glb", many));
    }

    #[test]
    fn pictures_that_a_shape_names_are_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let place = |name: &str| folder.path().join(name);
        for name in ["my bump.png", "rough.png", "other.png"] {
            std::fs::write(place(name), "").unwrap();
        }
        let replaces =
            |name: &str, shape, mesh: &TriMesh| check_no_texture(&place(name), &place(shape), mesh).is_err();
        let mut mesh = chladni_mesh::samples::icosphere(0);
        let mut material = Material::named("skin");
        let statements = ["map_Bump -bm 0.5 my bump.png", "refl\t-type sphere rough.png", "Ns other.png"];
        material.other_statements = statements.map(str::to_owned).to_vec();
        mesh.appearance.materials = vec![material];
        for (name, is_named) in [("my bump.png", true), ("rough.png", true), ("other.png", false)] {
            assert_eq!(replaces(name, "blank.obj", &mesh), is_named, "{name}");
        }
        let left = left_pictures(&place("blank.obj"), &mesh, &place("out/blank.obj")).unwrap().to_string();
        assert!(left.contains("name my bump.png and 1 more"), "{left}");

        mesh.appearance.materials.clear();
        let gltf = r#"{"images":[{"uri":"my%20bump.png"},{"uri":"./rough.png"}]}"#;
        std::fs::write(place("m.gltf"), gltf).unwrap();
        for (name, is_named) in [("my bump.png", true), ("rough.png", true), ("other.png", false)] {
            assert_eq!(replaces(name, "m.gltf", &mesh), is_named, "{name}");
        }
        let apart = pictures_apart(Path::new("m.gltf"), gltf.as_bytes()).unwrap().to_string();
        assert_eq!(apart, "m.gltf: names my bump.png and 1 more, which the GLB does not hold");
    }

    #[test]
    fn pictures_outside_the_folder_of_a_shape_are_not_looked_for() {
        let home = tempfile::tempdir().unwrap();
        let (outside, shape) = (home.path().join("x.png"), home.path().join("mesh/m.obj"));
        std::fs::create_dir(home.path().join("mesh")).unwrap();
        std::fs::write(&outside, "").unwrap();
        let mut mesh = chladni_mesh::samples::icosphere(0);
        for name in ["../x.png".to_owned(), "..\\x.png".to_owned(), outside.display().to_string()] {
            let texture = Texture { name: name.clone(), bytes: b"".as_slice().into() };
            let other_statements = vec![format!("map_Bump {name}")];
            let material =
                Material { base_color_texture: Some(texture), other_statements, ..Material::named("skin") };
            mesh.appearance.materials = vec![material];
            assert_eq!(left_pictures(&shape, &mesh, &home.path().join("out/m.obj")), None, "{name}");
            assert!(check_no_texture(&outside, &shape, &mesh).is_ok(), "{name}");
        }
    }

    #[test]
    fn a_slash_at_the_end_names_a_folder() {
        let folder = tempfile::tempdir().unwrap();
        let place = |name: &str| format!("{}/{name}", folder.path().display());
        std::fs::write(place("file"), "").unwrap();
        std::fs::create_dir(place("folder")).unwrap();
        for name in ["folder", "folder/", "new", "new/"] {
            assert!(check_folder(Path::new(&place(name))).is_ok(), "{name}");
        }
        for name in ["file", "file/"] {
            let why = check_folder(Path::new(&place(name))).unwrap_err().to_string();
            assert!(why.contains("is a file"), "{name}: {why}");
        }
        for name in ["file/", "folder/", "new.obj/"] {
            let why = check_file(Path::new(&place(name))).unwrap_err().to_string();
            assert!(why.contains("folder"), "{name}: {why}");
        }
        assert!(check_file(Path::new(&place("new.obj"))).is_ok());
    }
}
