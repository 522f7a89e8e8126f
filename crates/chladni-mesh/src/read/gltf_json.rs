//! The parts of a glTF file's JSON that a mesh needs. Indices are checked where they are used.

use std::collections::HashMap;

use serde::de::{DeserializeOwned, IgnoredAny};
use serde::{Deserialize, Deserializer};

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Root {
    #[serde(default)]
    pub accessors: Vec<Accessor>,
    #[serde(default)]
    pub buffers: Vec<Buffer>,
    #[serde(default)]
    pub buffer_views: Vec<BufferView>,
    #[serde(default)]
    pub extensions_required: Vec<String>,
    #[serde(default)]
    pub images: Vec<Image>,
    #[serde(default)]
    pub materials: Vec<Material>,
    #[serde(default)]
    pub meshes: Vec<Mesh>,
    #[serde(default)]
    pub nodes: Vec<Node>,
    pub scene: Option<usize>,
    #[serde(default)]
    pub scenes: Vec<SceneNodes>,
    #[serde(default)]
    pub skins: Vec<Skin>,
    #[serde(default)]
    pub textures: Vec<TextureSource>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Accessor {
    pub buffer_view: Option<usize>,
    #[serde(default)]
    pub byte_offset: usize,
    pub component_type: u32,
    pub count: usize,
    #[serde(default)]
    pub normalized: bool,
    #[serde(rename = "type")]
    pub kind: String,
    pub sparse: Option<Sparse>,
}

#[derive(Deserialize)]
pub(crate) struct Sparse {
    pub count: usize,
    pub indices: SparseIndices,
    pub values: SparseValues,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct SparseIndices {
    pub buffer_view: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub component_type: u32,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct SparseValues {
    pub buffer_view: usize,
    #[serde(default)]
    pub byte_offset: usize,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Buffer {
    pub byte_length: usize,
    pub uri: Option<String>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct BufferView {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub byte_length: usize,
    pub byte_stride: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Image {
    pub buffer_view: Option<usize>,
    pub mime_type: Option<String>,
    pub name: Option<String>,
    pub uri: Option<String>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Material {
    #[serde(default)]
    pub name: String,
    pub pbr_metallic_roughness: Option<Pbr>,
    #[serde(default, deserialize_with = "if_understood")]
    pub alpha_mode: Option<AlphaMode>,
    #[serde(default, deserialize_with = "if_understood")]
    pub alpha_cutoff: Option<f32>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(crate) enum AlphaMode {
    Opaque,
    Mask,
    Blend,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Pbr {
    pub base_color_factor: Option<[f64; 4]>,
    pub base_color_texture: Option<TextureInfo>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct TextureInfo {
    pub index: usize,
    #[serde(default)]
    pub tex_coord: usize,
    #[serde(default, deserialize_with = "if_understood")]
    pub extensions: Option<TextureInfoExtensions>,
}

#[derive(Deserialize)]
pub(crate) struct TextureInfoExtensions {
    #[serde(rename = "KHR_texture_transform")]
    pub transform: Option<UvTransform>,
}

/// The extension `KHR_texture_transform`.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct UvTransform {
    #[serde(default)]
    pub offset: [f64; 2],
    #[serde(default)]
    pub rotation: f64,
    #[serde(default = "ones")]
    pub scale: [f64; 2],
    pub tex_coord: Option<usize>,
}

/// An extension or a mode with mistakes is passed over, as one that is not known.
fn if_understood<'de, D: Deserializer<'de>, T: DeserializeOwned>(value: D) -> Result<Option<T>, D::Error> {
    serde_json::Value::deserialize(value).map(|value| serde_json::from_value(value).ok())
}

fn ones() -> [f64; 2] {
    [1.0; 2]
}

#[derive(Deserialize)]
pub(crate) struct TextureSource {
    source: Option<usize>,
    #[serde(default, deserialize_with = "if_understood")]
    extensions: Option<TextureExtensions>,
}

/// Images in formats that not every program reads.
#[derive(Deserialize)]
struct TextureExtensions {
    #[serde(rename = "EXT_texture_webp")]
    webp: Option<ImageSource>,
    #[serde(rename = "EXT_texture_avif")]
    avif: Option<ImageSource>,
    #[serde(rename = "KHR_texture_basisu")]
    basis: Option<ImageSource>,
}

#[derive(Deserialize)]
struct ImageSource {
    source: Option<usize>,
}

impl TextureSource {
    /// Its image: in a format that glTF itself knows where there is one.
    pub fn image(&self) -> Option<usize> {
        let other = || {
            let TextureExtensions { webp, avif, basis } = self.extensions.as_ref()?;
            [webp, avif, basis].into_iter().flatten().find_map(|image| image.source)
        };
        self.source.or_else(other)
    }
}

#[derive(Deserialize)]
pub(crate) struct Mesh {
    pub primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
pub(crate) struct Primitive {
    pub attributes: HashMap<String, usize>,
    pub indices: Option<usize>,
    pub material: Option<usize>,
    #[serde(default = "triangles")]
    pub mode: u32,
    #[serde(default)]
    pub targets: Vec<HashMap<String, usize>>,
    #[serde(default, deserialize_with = "if_understood")]
    extensions: Option<PrimitiveExtensions>,
}

#[derive(Deserialize)]
struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    draco: Option<IgnoredAny>,
}

impl Primitive {
    /// Whether its data are there in Draco's compression, perhaps beside a plain copy.
    pub fn has_draco(&self) -> bool {
        self.extensions.as_ref().is_some_and(|extensions| extensions.draco.is_some())
    }
}

fn triangles() -> u32 {
    4
}

#[derive(Deserialize)]
pub(crate) struct Node {
    #[serde(default)]
    pub children: Vec<usize>,
    pub matrix: Option<[f64; 16]>,
    pub mesh: Option<usize>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    pub skin: Option<usize>,
    pub translation: Option<[f64; 3]>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Skin {
    pub inverse_bind_matrices: Option<usize>,
    #[serde(default)]
    pub joints: Vec<usize>,
}

#[derive(Deserialize)]
pub(crate) struct SceneNodes {
    #[serde(default)]
    pub nodes: Vec<usize>,
}
