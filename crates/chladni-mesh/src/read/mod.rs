//! From bytes to a mesh.

pub(crate) mod beside;
pub(crate) mod draft;
pub(crate) mod gltf;
pub(crate) mod gltf_buffers;
pub(crate) mod gltf_chunks;
pub(crate) mod gltf_json;
pub(crate) mod gltf_matrix;
mod medit;
mod mtl;
mod obj;
mod off;
pub(crate) mod ply;
mod ply_header;
mod stl;
mod text;

use std::fmt;
use std::path::Path;

pub use beside::name_within;
pub use gltf::pictures_beside;
pub use mtl::picture_name;

use chladni_task::{counted, read_file};

use beside::{Beside, read_within};

use crate::error::Fault;
use crate::surface::MOST_CORNERS;
use crate::{Format, HealthReport, MeshError, TriMesh};

/// A mesh, and the repairs that its file needed.
#[derive(Clone, Debug, PartialEq)]
pub struct Loaded {
    /// The mesh.
    pub mesh: TriMesh,
    /// Faults of the file, and how each was mended.
    pub mended: Vec<Mended>,
    /// glTF only, where nodes move their meshes: the positions before that.
    pub stored_positions: Option<Vec<[f64; 3]>>,
}

impl Loaded {
    /// The health report of the file. Where a glTF file places meshes by nodes, its count of
    /// duplicate vertices is that of the stored positions; all else is of the mesh as placed.
    pub fn health(&self) -> HealthReport {
        HealthReport::of_placed(&self.mesh, self.stored_positions.as_deref())
    }
}

/// Something in a file that was repaired or left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Mended {
    /// The content is of another format than the name says.
    Misnamed(Format),
    /// This many vertex colors were not numbers, or missing, and are white now.
    Colors(usize),
    /// This many faces have fewer than three corners and were left out.
    ShortFaces(usize),
    /// This many faces cross themselves, or are not convex and have very many corners: their triangles overlap.
    FoldedFans(usize),
    /// This many texture coordinates were not numbers, or out of range, and were left out.
    Uvs(usize),
    /// Bytes after the end that the header promises were ignored.
    TrailingBytes(usize),
    /// A part of the file that was left out, and why.
    LeftOut(String),
    /// A material library or texture that could not be read: name and reason.
    MissingFile(String, String),
}

impl fmt::Display for Mended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Misnamed(format) => {
                write!(f, "read as {format}, which its content is, not as its name says")
            }
            Self::Colors(count) => {
                let were = counted(*count, "vertex color was", "vertex colors were");
                write!(f, "{were} missing or not numbers: set to white")
            }
            Self::ShortFaces(count) => {
                let have = counted(*count, "face has", "faces have");
                write!(f, "{have} fewer than three corners: left out")
            }
            Self::FoldedFans(count) => write!(
                f,
                "faces that cross themselves, or are not convex and have more than {MOST_CORNERS} corners, whose \
                 triangles overlap: {count}"
            ),
            Self::Uvs(count) => {
                let were = counted(*count, "texture coordinate was", "texture coordinates were");
                write!(f, "{were} unusable: left out")
            }
            Self::TrailingBytes(count) => {
                write!(f, "{} after the end of the data: ignored", counted(*count, "byte", "bytes"))
            }
            Self::LeftOut(what) => write!(f, "left out: {what}"),
            Self::MissingFile(name, reason) => write!(f, "{name} could not be read ({reason}): done without"),
        }
    }
}

/// Reads a mesh from `bytes`.
///
/// Files that it refers to are not opened: a glTF file with external buffers is an error, and materials of an
/// OBJ have only their names. [`load_mesh`] reads them.
///
/// At most 64 bytes of memory are in use for each byte of the file, or 256 for glTF, whose primitives in all their instances may
/// have 2^24 vertices in all besides.
///
/// # Errors
/// [`MeshError::Malformed`] with line, byte or part; [`MeshError::NoFace`] for a well-formed
/// file without a face.
pub fn read_mesh(bytes: &[u8], format: Format) -> Result<Loaded, MeshError> {
    read_mesh_beside(bytes, format, &nothing_beside)
}

/// For a mesh without a folder: none of the files that it names can be read.
///
/// # Errors
/// Always.
pub fn nothing_beside(_name: &str) -> Result<Vec<u8>, String> {
    Err("only the mesh itself was given".into())
}

/// The largest file that is read: text of a mesh of fifty million vertices.
pub(crate) const MOST_BYTES: u64 = 8 << 30;

/// Reads the mesh file at `path`; its format is determined by extension and content. Files that it names are read from
/// its own folder or below, not from elsewhere.
///
/// # Errors
/// Those of [`read_mesh`], of the file system, and [`MeshError::UnknownFormat`], each inside a
/// [`MeshError::InFile`].
pub fn load_mesh(path: &Path) -> Result<Loaded, MeshError> {
    load(path).map_err(|error| MeshError::InFile { path: path.to_owned(), error: Box::new(error) })
}

fn load(path: &Path) -> Result<Loaded, MeshError> {
    let bytes = read_file(path, MOST_BYTES).map_err(MeshError::Io)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    read_named_mesh(path, &bytes, &|name| read_within(folder, name, MOST_BYTES))
}

/// Reads a mesh from the `bytes` of a file called `name`, whose format is determined by extension and content; `beside`
/// is that of [`read_mesh_beside`].
///
/// # Errors
/// Those of [`read_mesh`], and [`MeshError::UnknownFormat`].
pub fn read_named_mesh(name: &Path, bytes: &[u8], beside: &Beside<'_>) -> Result<Loaded, MeshError> {
    let extension = name.extension().and_then(|extension| extension.to_str());
    let format = format_of(extension, bytes)?;
    let mut loaded = read_mesh_beside(bytes, format, beside)?;
    if Format::of_path(name).is_some_and(|promised| promised != format) {
        loaded.mended.insert(0, Mended::Misnamed(format));
    }
    Ok(loaded)
}

/// The format of a file by its extension and content. If the two disagree, the content decides.
fn format_of(extension: Option<&str>, bytes: &[u8]) -> Result<Format, MeshError> {
    if bytes.starts_with(b"# vtk DataFile") {
        return Err(MeshError::UnknownFormat("legacy VTK is not read; save it as PLY or OBJ".into()));
    }
    match (Format::from_content(bytes), extension.and_then(Format::from_extension)) {
        (Some(format), _) | (None, Some(format)) => Ok(format),
        (None, None) => Err(MeshError::UnknownFormat(match extension {
            Some(extension) => format!("no mesh format is called .{extension} ({KNOWN})"),
            None => format!("neither name nor content tells the mesh format ({KNOWN})"),
        })),
    }
}

const KNOWN: &str = "known are obj, ply, off, stl, gltf, glb, mesh";

/// Like [`read_mesh`]; `beside` gives the bytes of a file that the mesh names, or says why there are none.
///
/// # Errors
/// As [`read_mesh`].
pub fn read_mesh_beside(bytes: &[u8], format: Format, beside: &Beside<'_>) -> Result<Loaded, MeshError> {
    let read = match format {
        Format::Obj => obj::read(bytes, beside),
        Format::Ply => ply::read(bytes, beside),
        Format::Off => off::read(bytes),
        Format::Stl => stl::read(bytes),
        Format::Medit => medit::read(bytes),
        Format::Gltf | Format::Glb => return gltf::read(bytes, format, beside),
    };
    let draft = read.map_err(|Fault { at, reason }| MeshError::Malformed { format, at, reason })?;
    draft.finish(format)
}
