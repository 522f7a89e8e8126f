//! Wavefront OBJ and its material library.

use std::collections::HashMap;
use std::ffi::OsStr;
use std::fmt::Write;
use std::io::{BufRead, BufReader, ErrorKind, Read};
use std::path::{Path, PathBuf};

use chladni_task::{open_file, read_file, write_atomic, write_new};

use crate::appearance::srgb_from_linear;
use crate::{CornerUvs, Material, MeshError, TriMesh};

/// The text of `mesh` alone, which names a library `materials.mtl` where there are materials.
pub(crate) fn write(mesh: &TriMesh) -> Vec<u8> {
    // Without a library, readers take a number sign for a comment, and materials that differ after it for one.
    text_with(mesh, "materials.mtl", &names(&mesh.appearance.materials, &['\n', '\r', '#']))
}

fn text_with(mesh: &TriMesh, library: &str, names: &Names) -> Vec<u8> {
    let look = &mesh.appearance;
    let mut text = String::new();
    if !look.materials.is_empty() {
        line(&mut text, format_args!("mtllib {library}"));
    }
    for (v, p) in mesh.positions.iter().enumerate() {
        text.push('v');
        p.iter().for_each(|&x| push_number(&mut text, x));
        if let Some(color) = look.colors.as_ref().and_then(|colors| colors.get(v)) {
            for &c in &color[..3] {
                // f32 holds linear light to about seven digits, which gives six in sRGB.
                let _ = write!(text, " {}", (srgb_from_linear(f64::from(c)) * 1e6).round() / 1e6);
            }
        }
        text.push('\n');
    }
    for point in look.uvs.iter().flat_map(|uvs| &uvs.points) {
        text.push_str("vt");
        point.iter().for_each(|&x| push_number(&mut text, x));
        text.push('\n');
    }
    let mut current = None;
    for f in 0..mesh.face_count() {
        let material = look.face_materials.get(f).copied().flatten();
        if material != current {
            let name = material.map_or(names.none.as_str(), |material| &names.materials[material as usize]);
            line(&mut text, format_args!("usemtl {name}"));
        }
        current = material;
        text.push('f');
        let first = mesh.first_corner(f);
        for (i, v) in mesh.face(f).iter().enumerate() {
            let uv = look.uvs.as_ref().map(|uvs| uvs.corners[first + i]).filter(|&uv| uv != CornerUvs::NONE);
            let _ = match uv {
                Some(uv) => write!(text, " {}/{}", v + 1, uv + 1),
                None => write!(text, " {}", v + 1),
            };
        }
        text.push('\n');
    }
    text.into_bytes()
}

/// Names of materials in the file.
struct Names {
    materials: Vec<String>,
    /// For faces without a material after faces with one: OBJ cannot take a material back.
    none: String,
}

/// The names of `materials`, all different and readable, with blanks for the `unreadable`: OBJ distinguishes materials only
/// by their names.
fn names(materials: &[Material], unreadable: &[char]) -> Names {
    // How often each name was asked for; one that never was is free.
    let mut wanted: HashMap<String, usize> = HashMap::new();
    let mut free = |name: &str| {
        let plain = name.replace(unreadable, " ");
        let plain = plain.trim_end_matches(|c: char| c == '\\' || c.is_whitespace()).trim_start();
        let plain = if plain.is_empty() { "material" } else { plain };
        let mut candidate = plain.to_owned();
        while wanted.contains_key(&candidate) {
            let times = wanted.entry(plain.to_owned()).or_default();
            *times += 1;
            candidate = format!("{plain} {times}");
        }
        wanted.insert(candidate.clone(), 1);
        candidate
    };
    let materials = materials.iter().map(|material| free(&material.name)).collect();
    Names { materials, none: free("none") }
}

/// A blank and the shortest text that reads back as exactly `x`.
fn push_number(text: &mut String, x: f64) {
    let plain = x == 0.0 || (1e-5..1e16).contains(&x.abs());
    let _ = if plain { write!(text, " {x}") } else { write!(text, " {x:e}") };
}

/// A line of its own; names from files may hold line ends.
fn line(text: &mut String, content: std::fmt::Arguments<'_>) {
    text.push_str(&content.to_string().replace(['\n', '\r'], " "));
    text.push('\n');
}

/// Writes the OBJ file, its library and the pictures beside it, the OBJ last. The library is `STEM.mtl`, or has a number where
/// that is of another mesh.
pub(crate) fn save_with_materials(mesh: &TriMesh, path: &Path) -> Result<(), MeshError> {
    let stem = readable(&path.file_stem().unwrap_or_default().to_string_lossy(), "mesh");
    let mut text = String::new();
    // With the library, names are found again whatever number signs they hold.
    let names = names(&mesh.appearance.materials, &['\n', '\r']);
    for (material, name) in mesh.appearance.materials.iter().zip(&names.materials) {
        let picture = match &material.base_color_texture {
            Some(texture) if texture.bytes.is_empty() => Some(texture.name.clone()),
            Some(texture) => Some(save_picture(path, &stem, &texture.name, &texture.bytes)?),
            None => None,
        };
        push_material(&mut text, name, material, picture.as_deref());
    }
    if mesh.appearance.face_materials.contains(&None) {
        push_material(&mut text, &names.none, &Material::named(""), None);
    }
    let numbered = (1..MOST_NUMBERS).map(|i| format!("{stem}-{i}.mtl"));
    let own = library_of(path);
    let libraries = std::iter::once(format!("{stem}.mtl")).chain(numbered);
    let library = save_beside(path, libraries, text.as_bytes(), own.as_deref())?;
    write_atomic(path, &text_with(mesh, &library, &names)).map_err(MeshError::Io)
}

fn push_material(text: &mut String, name: &str, material: &Material, picture: Option<&str>) {
    line(text, format_args!("newmtl {name}"));
    let [r, g, b, opacity] = material.base_color.map(f64::from);
    let [r, g, b] = [r, g, b].map(|c| (srgb_from_linear(c) * 1e6).round() / 1e6);
    // One that was not understood stands among the others.
    let kept = |keyword| material.other_statements.iter().any(|s| s.split(' ').next() == Some(keyword));
    if !kept("Kd") {
        line(text, format_args!("Kd {r} {g} {b}"));
    }
    if opacity < 1.0 && !kept("d") {
        line(text, format_args!("d {opacity}"));
    }
    if let Some(picture) = picture {
        let options = &material.texture_options;
        line(text, format_args!("map_Kd {options}{}{picture}", if options.is_empty() { "" } else { " " }));
    }
    for statement in &material.other_statements {
        line(text, format_args!("{statement}"));
    }
    text.push('\n');
}

/// Puts a picture beside `path` unless an identical one is there already; returns its name.
fn save_picture(path: &Path, stem: &str, name: &str, bytes: &[u8]) -> Result<String, MeshError> {
    let name = name.replace('\\', "/");
    let own = Path::new(&name).file_name().unwrap_or_default();
    let mut own = readable(&own.to_string_lossy(), "texture");
    let known =
        |ending: &OsStr| ["png", "jpg", "jpeg"].iter().any(|known| ending.eq_ignore_ascii_case(known));
    if !Path::new(&own).extension().is_some_and(known) {
        own.push_str(if bytes.starts_with(b"\x89PNG") { ".png" } else { ".jpg" });
    }
    let numbered = (1..MOST_NUMBERS).map(|i| format!("{stem}-{i}-{own}"));
    save_beside(path, std::iter::once(own.clone()).chain(numbered), bytes, None)
}

/// `name` as a file's name that a statement can end in and that leaves room for numbers; `other` where nothing is left of
/// it. Readers drop blanks around a name, take a dash for an option, a backslash for a folder and # for a comment.
fn readable(name: &str, other: &str) -> String {
    let plain = name.replace(|c: char| c.is_control() || ['#', '\\'].contains(&c), "_");
    let plain = plain.trim();
    let plain = if plain.is_empty() { other } else { plain };
    let dash = if plain.starts_with('-') { "_" } else { "" };
    format!("{dash}{}", &plain[..plain.floor_char_boundary(MOST_BYTES)])
}

/// A name of a mesh and one of a picture fit into one name of a file, of at most 255 bytes.
const MOST_BYTES: usize = 115;

/// From this number on, names for files of one name are not tried.
const MOST_NUMBERS: usize = 1000;

/// Puts `bytes` beside `path` under the first of `names` that is free or has them already, or that is `own`, which may be
/// replaced; returns that name. A link is never followed: it may have come with the mesh.
fn save_beside(
    path: &Path,
    names: impl Iterator<Item = String>,
    bytes: &[u8],
    own: Option<&str>,
) -> Result<String, MeshError> {
    let mut wanted = None;
    for name in names {
        let file: PathBuf = path.with_file_name(&name);
        // A file that cannot be read, such as a pipe or a longer one, is another file.
        let there = || read_file(&file, bytes.len() as u64);
        let is_own = || own == Some(&name) && file.symlink_metadata().is_ok_and(|known| known.is_file());
        let written = match there() {
            Ok(there) if there == bytes => return Ok(name),
            _ if is_own() => write_atomic(&file, bytes),
            Err(error) if error.kind() == ErrorKind::NotFound => write_new(&file, bytes),
            // No other number would help.
            Err(error) if matches!(error.kind(), ErrorKind::InvalidFilename | ErrorKind::NotADirectory) => {
                Err(error)
            }
            _ => Err(ErrorKind::AlreadyExists.into()),
        };
        match written {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                // Another program may just have put the same one there.
                if there().is_ok_and(|there| there == bytes) {
                    return Ok(name);
                }
                wanted.get_or_insert(name);
            }
            written => return written.map(|()| name).map_err(MeshError::Io),
        }
    }
    let wanted = wanted.unwrap_or_default();
    Err(MeshError::Io(std::io::Error::other(format!("no free name for a file like {wanted}"))))
}

/// The library that the OBJ file at `path` names, if there is one near its beginning.
fn library_of(path: &Path) -> Option<String> {
    const BEGINNING: u64 = 1 << 20;
    let file = open_file(path).ok()?;
    let mut lines = BufReader::new(file.take(BEGINNING)).split(b'\n').map_while(Result::ok);
    let name = lines.find_map(|line| {
        let rest = line.trim_ascii().strip_prefix(b"mtllib")?;
        rest.first()?.is_ascii_whitespace().then(|| rest.trim_ascii().to_vec())
    })?;
    String::from_utf8(name).ok()
}
