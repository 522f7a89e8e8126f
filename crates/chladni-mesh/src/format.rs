//! Which format a file is in, by its name and by its content.

use std::ffi::OsStr;
use std::fmt;
use std::path::Path;

/// A mesh file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// Wavefront OBJ.
    Obj,
    /// Stanford PLY, ascii or binary.
    Ply,
    /// Geomview OFF, ascii or binary.
    Off,
    /// Stereolithography, ascii or binary.
    Stl,
    /// glTF 2.0 as JSON.
    Gltf,
    /// glTF 2.0 in one binary file.
    Glb,
    /// INRIA Medit `.mesh`, ascii.
    Medit,
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Obj => "OBJ",
            Self::Ply => "PLY",
            Self::Off => "OFF",
            Self::Stl => "STL",
            Self::Gltf => "glTF",
            Self::Glb => "GLB",
            Self::Medit => "Medit mesh",
        })
    }
}

impl Format {
    /// The format of a file extension (without its dot).
    pub fn from_extension(extension: &str) -> Option<Self> {
        Some(match extension.to_ascii_lowercase().as_str() {
            "obj" => Self::Obj,
            "ply" => Self::Ply,
            "off" | "coff" | "noff" => Self::Off,
            "stl" => Self::Stl,
            "gltf" => Self::Gltf,
            "glb" => Self::Glb,
            "mesh" => Self::Medit,
            _ => return None,
        })
    }

    /// The format that the ending of `path` promises.
    pub fn of_path(path: &Path) -> Option<Self> {
        path.extension().and_then(OsStr::to_str).and_then(Self::from_extension)
    }

    /// The format recognized by the first bytes. OBJ and text in general cannot be.
    pub fn from_content(bytes: &[u8]) -> Option<Self> {
        if bytes.starts_with(b"glTF") {
            return Some(Self::Glb);
        }
        if is_binary_stl(bytes) {
            return Some(Self::Stl);
        }
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
        let first = text.split(|b| b.is_ascii_whitespace()).next().unwrap_or_default();
        match first {
            b"ply" => Some(Self::Ply),
            _ if first.eq_ignore_ascii_case(b"solid") => Some(Self::Stl),
            b"MeshVersionFormatted" => Some(Self::Medit),
            _ if off_keyword(first).is_some() => Some(Self::Off),
            _ if text.starts_with(b"{") => Some(Self::Gltf),
            _ => None,
        }
    }
}

/// Whether the triangle count at byte 80 fits the length: the only sign of a binary STL, whose header may
/// contain anything, even `solid`.
pub(crate) fn is_binary_stl(bytes: &[u8]) -> bool {
    let count = bytes.get(80..84).and_then(|c| <[u8; 4]>::try_from(c).ok()).map(u32::from_le_bytes);
    count.is_some_and(|count| bytes.len() as u64 == 84 + 50 * u64::from(count))
}

/// The vertex layout that an OFF header keyword such as `STCNOFF` announces, and the keyword's length. Counts may
/// follow it without a blank.
pub(crate) fn off_keyword(word: &[u8]) -> Option<(OffVertex, usize)> {
    let mut vertex = OffVertex::default();
    let mut rest = word;
    for (prefix, flag) in [
        (&b"ST"[..], &mut vertex.texture),
        (b"C", &mut vertex.color),
        (b"N", &mut vertex.normal),
        (b"4", &mut vertex.homogeneous),
        (b"n", &mut vertex.any_dimension),
    ] {
        if let Some(after) = rest.strip_prefix(prefix) {
            *flag = true;
            rest = after;
        }
    }
    let after = rest.strip_prefix(b"OFF")?;
    after.iter().all(u8::is_ascii_digit).then_some((vertex, word.len() - after.len()))
}

/// The fields of each vertex of an OFF file besides x, y, z.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct OffVertex {
    pub texture: bool,
    pub color: bool,
    pub normal: bool,
    pub homogeneous: bool,
    pub any_dimension: bool,
}
