//! The look of a mesh, as its file describes it.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::Rows;

/// The look of a mesh, as its file describes it, kept for drawing and for the export.
///
/// A file's normals are not kept: they would be wrong as soon as the shape moves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Appearance {
    /// The faces as the file stores them: row f holds the corners of face f. `None` where all
    /// are triangles; then face f is triangle f.
    pub polygons: Option<Rows>,
    /// How those polygons are divided that are not a fan of triangles from their first corner, by face: the corners of
    /// each triangle, counted within the face from 0.
    pub divided: BTreeMap<u32, Vec<[u32; 3]>>,
    /// One linear-light RGBA color per vertex, each channel in [0, 1].
    pub colors: Option<Vec<[f32; 4]>>,
    /// Whether these are multiplied with materials, as in glTF. Other formats do not say; there, textures are seen alone.
    pub colors_tint: bool,
    /// Texture coordinates per corner of a face.
    pub uvs: Option<CornerUvs>,
    /// The materials that faces may name.
    pub materials: Vec<Material>,
    /// For each face its index in `materials`; empty where no face has one.
    pub face_materials: Vec<Option<u32>>,
    /// Numbers of the vertices by name: the scalar properties of a PLY file that mean nothing else here.
    pub attributes: Vec<Attribute>,
}

/// A number for each vertex, such as a weight or the quality of a scan.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribute {
    /// Its name: one word.
    pub name: String,
    /// One for each vertex; not always finite.
    pub values: Vec<f64>,
}

/// Texture coordinates, which may differ between the faces that meet at a vertex (a seam).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CornerUvs {
    /// The points (u to the right, v upward, as in OBJ), in the order of the file.
    pub points: Vec<[f64; 2]>,
    /// For each corner of each face, face after face, its index in `points`, or
    /// [`NONE`](Self::NONE).
    pub corners: Vec<u32>,
}

impl CornerUvs {
    /// A corner without texture coordinates.
    pub const NONE: u32 = u32::MAX;
}

/// How the faces that name it are colored.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Its name; may be empty.
    pub name: String,
    /// Linear-light RGBA, multiplied with the texture.
    pub base_color: [f32; 4],
    /// A picture in texture coordinates.
    pub base_color_texture: Option<Texture>,
    /// What its alpha does.
    pub alpha_mode: AlphaMode,
    /// The options before the picture's name in an OBJ's material library, such as `-s 2 2 1`, for its export.
    pub texture_options: String,
    /// An OBJ material's other statements, line by line, for its export.
    pub other_statements: Vec<String>,
}

impl Material {
    /// A white material called `name`.
    pub fn named(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            base_color: [1.0; 4],
            base_color_texture: None,
            alpha_mode: AlphaMode::Usual,
            texture_options: String::new(),
            other_statements: Vec::new(),
        }
    }

    /// Its texture, if the picture's file was read.
    pub fn read_texture(&self) -> Option<&Texture> {
        self.base_color_texture.as_ref().filter(|texture| !texture.bytes.is_empty())
    }
}

/// What the alpha of a material's color and picture does.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// It is opacity where the base color has an alpha below 1; otherwise the material is opaque.
    #[default]
    Usual,
    /// Nothing is seen where it is below `cutoff`; elsewhere the material is opaque.
    Mask {
        /// Usually in [0, 1].
        cutoff: f32,
    },
    /// It is opacity.
    Blend,
}

/// A picture as its file holds it, not decoded.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// The name that the mesh's file has for it, a relative path in most formats.
    pub name: String,
    /// PNG or JPEG bytes; empty if the picture's file was not read.
    pub bytes: Arc<[u8]>,
}

/// Linear light of an sRGB-encoded channel, both in [0, 1] (IEC 61966-2-1).
pub fn linear_from_srgb(s: f64) -> f64 {
    if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
}

/// The inverse of [`linear_from_srgb`].
pub fn srgb_from_linear(l: f64) -> f64 {
    if l <= 0.0031308 { l * 12.92 } else { 1.055 * l.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eight_bit_colors_survive_linear_light() {
        for byte in 0..=255_u8 {
            let linear = linear_from_srgb(f64::from(byte) / 255.0) as f32;
            assert_eq!((srgb_from_linear(f64::from(linear)) * 255.0).round() as u8, byte);
        }
        assert!((linear_from_srgb(0.5) - 0.214_041_1).abs() < 1e-6);
    }
}
