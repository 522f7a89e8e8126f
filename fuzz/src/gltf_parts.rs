//! The parts of a glTF file, each with what it names.

use arbitrary::Arbitrary;

use crate::base64::base64;
use crate::extreme::Number;
use crate::gltf_graph::{Counts, numbers};
use crate::json::{Members, list, quoted};

/// Which of `count` entries is meant: one that is there, unless `named` is great.
pub(crate) fn index(named: u8, count: usize) -> usize {
    let named = usize::from(named);
    if named < 250 { named % count.max(1) } else { named }
}

#[derive(Arbitrary, Debug)]
pub(crate) struct Node {
    children: Vec<u8>,
    matrix: Option<[Number; 16]>,
    mesh: Option<u8>,
    rotation: Option<[Number; 4]>,
    scale: Option<[Number; 3]>,
    skin: Option<u8>,
    translation: Option<[Number; 3]>,
}

impl Node {
    pub fn json(&self, counts: &Counts) -> String {
        Members::default()
            .with("children", list(self.children.iter().take(4).map(|child| index(*child, counts.nodes))))
            .with_some("matrix", self.matrix.as_ref().map(|matrix| numbers(matrix)))
            .with_some("mesh", self.mesh.map(|mesh| index(mesh, counts.meshes)))
            .with_some("rotation", self.rotation.as_ref().map(|rotation| numbers(rotation)))
            .with_some("scale", self.scale.as_ref().map(|scale| numbers(scale)))
            .with_some("skin", self.skin.map(|skin| index(skin, counts.skins)))
            .with_some("translation", self.translation.as_ref().map(|translation| numbers(translation)))
            .object()
    }
}

#[derive(Arbitrary, Debug)]
pub(crate) struct Skin {
    inverse: Option<u8>,
    joints: Vec<u8>,
}

impl Skin {
    pub fn json(&self, counts: &Counts) -> String {
        Members::default()
            .with_some("inverseBindMatrices", self.inverse.map(|inverse| index(inverse, counts.accessors)))
            .with("joints", list(self.joints.iter().take(8).map(|joint| index(*joint, counts.nodes))))
            .object()
    }
}

#[derive(Arbitrary, Debug)]
pub(crate) struct Primitive {
    position: Option<u8>,
    normal: Option<u8>,
    color: Option<u8>,
    uvs: [Option<u8>; 2],
    vertex: Option<u8>,
    indices: Option<u8>,
    material: Option<u8>,
    mode: Option<u8>,
    targets: Vec<Option<u8>>,
    has_draco: bool,
}

impl Primitive {
    pub fn json(&self, counts: &Counts) -> String {
        let accessor = |named: Option<u8>| named.map(|named| index(named, counts.accessors));
        let attributes = Members::default()
            .with_some("POSITION", accessor(self.position))
            .with_some("NORMAL", accessor(self.normal))
            .with_some("COLOR_0", accessor(self.color))
            .with_some("TEXCOORD_0", accessor(self.uvs[0]))
            .with_some("TEXCOORD_1", accessor(self.uvs[1]))
            .with_some("_VERTEX", accessor(self.vertex));
        let target =
            |position: &Option<u8>| Members::default().with_some("POSITION", accessor(*position)).object();
        let draco = r#"{"KHR_draco_mesh_compression":{"bufferView":0}}"#;
        Members::default()
            .with("attributes", attributes.object())
            .with_some("indices", accessor(self.indices))
            .with_some("material", self.material.map(|material| index(material, counts.materials)))
            .with_some("mode", self.mode.map(|mode| mode % 8))
            .with("targets", list(self.targets.iter().take(3).map(target)))
            .with_some("extensions", self.has_draco.then_some(draco))
            .object()
    }
}

/// The types that have a use, those of positions more often, and one that has none.
const TYPES: [&str; 8] = ["VEC3", "SCALAR", "VEC2", "VEC3", "VEC4", "MAT4", "VEC3", "MAT3"];
/// Component types, 32 bits more often, and one that there is not.
const COMPONENTS: [u32; 8] = [5126, 5125, 5121, 5123, 5126, 5120, 5122, 5130];
/// More elements than are read without data.
const GREAT_COUNTS: [u64; 3] = [(1 << 24) + 1, u32::MAX as u64, u64::MAX];

fn component(named: u8) -> u32 {
    COMPONENTS[usize::from(named) % COMPONENTS.len()]
}

fn count(named: u8) -> u64 {
    let great = usize::from(named).checked_sub(256 - GREAT_COUNTS.len());
    great.map_or(u64::from(named % 65), |great| GREAT_COUNTS[great])
}

#[derive(Arbitrary, Debug)]
pub(crate) struct Accessor {
    view: Option<u8>,
    offset: u8,
    component: u8,
    count: u8,
    is_normalized: bool,
    kind: u8,
    sparse: Option<Sparse>,
}

#[derive(Arbitrary, Debug)]
struct Sparse {
    count: u8,
    /// A view and an offset.
    indices: (u8, u8),
    component: u8,
    values: (u8, u8),
}

impl Accessor {
    pub fn json(&self, counts: &Counts) -> String {
        let at = |(view, offset): (u8, u8)| {
            Members::default().with("bufferView", index(view, counts.views)).with("byteOffset", offset)
        };
        let sparse = |sparse: &Sparse| {
            Members::default()
                .with("count", count(sparse.count))
                .with(
                    "indices",
                    at(sparse.indices).with("componentType", component(sparse.component)).object(),
                )
                .with("values", at(sparse.values).object())
                .object()
        };
        Members::default()
            .with_some("bufferView", self.view.map(|view| index(view, counts.views)))
            .with("byteOffset", self.offset)
            .with("componentType", component(self.component))
            .with("count", count(self.count))
            .with("normalized", self.is_normalized)
            .with("type", quoted(TYPES[usize::from(self.kind) % TYPES.len()]))
            .with_some("sparse", self.sparse.as_ref().map(sparse))
            .object()
    }
}

#[derive(Arbitrary, Debug)]
pub(crate) struct View {
    buffer: u8,
    /// In words of 32 bits.
    offset: u8,
    /// In words of 32 bits; all that follows where it is not given.
    length: Option<u16>,
    stride: Option<u8>,
}

impl View {
    pub fn json(&self, counts: &Counts) -> String {
        let offset = 4 * usize::from(self.offset);
        let length = self.length.map_or(1024 - offset, |length| 4 * usize::from(length));
        Members::default()
            .with("buffer", index(self.buffer, counts.buffers))
            .with("byteOffset", offset)
            .with("byteLength", length)
            .with_some("byteStride", self.stride)
            .object()
    }
}

#[derive(Arbitrary, Debug)]
pub(crate) struct Material {
    name: Option<u8>,
    color: Option<[Number; 4]>,
    texture: Option<u8>,
    set: Option<u8>,
    transform: Option<Transform>,
    alpha_mode: Option<u8>,
    alpha_cutoff: Option<Number>,
}

#[derive(Arbitrary, Debug)]
struct Transform {
    offset: [Number; 2],
    rotation: Number,
    /// Three numbers are a mistake.
    scale: Result<[Number; 2], [Number; 3]>,
    set: Option<u8>,
}

impl Transform {
    fn json(&self) -> String {
        let scale = match &self.scale {
            Ok(scale) => numbers(scale),
            Err(scale) => numbers(scale),
        };
        let rotation = numbers(&[self.rotation]);
        let transform = Members::default()
            .with("offset", numbers(&self.offset))
            .with("rotation", rotation.trim_matches(['[', ']']))
            .with("scale", scale)
            .with_some("texCoord", self.set.map(|set| set % 3));
        Members::default().with("KHR_texture_transform", transform.object()).object()
    }
}

impl Material {
    pub fn json(&self, counts: &Counts) -> String {
        let modes = ["OPAQUE", "MASK", "BLEND", "DITHER"];
        let texture = self.texture.map(|texture| {
            Members::default()
                .with("index", index(texture, counts.textures))
                .with_some("texCoord", self.set.map(|set| set % 3))
                .with_some("extensions", self.transform.as_ref().map(Transform::json))
                .object()
        });
        let metallic_roughness = Members::default()
            .with_some("baseColorFactor", self.color.as_ref().map(|color| numbers(color)))
            .with_some("baseColorTexture", texture);
        let cutoff = self.alpha_cutoff.map(|cutoff| numbers(&[cutoff]));
        Members::default()
            .with_some("name", self.name.map(|name| quoted(&format!("m{}", name % 4))))
            .with("pbrMetallicRoughness", metallic_roughness.object())
            .with_some("alphaMode", self.alpha_mode.map(|mode| quoted(modes[usize::from(mode) % 4])))
            .with_some("alphaCutoff", cutoff.as_ref().map(|cutoff| cutoff.trim_matches(['[', ']'])))
            .object()
    }
}

#[derive(Arbitrary, Debug)]
pub(crate) struct Texture {
    source: Option<u8>,
    webp: Option<u8>,
    basis: Option<u8>,
}

impl Texture {
    pub fn json(&self, counts: &Counts) -> String {
        let source = |named: u8| Members::default().with("source", index(named, counts.images)).object();
        let extensions = Members::default()
            .with_some("EXT_texture_webp", self.webp.map(source))
            .with_some("KHR_texture_basisu", self.basis.map(source));
        Members::default()
            .with_some("source", self.source.map(|named| index(named, counts.images)))
            .with("extensions", extensions.object())
            .object()
    }
}

#[derive(Arbitrary, Debug)]
pub(crate) enum Image {
    View(u8),
    Beside(u8),
    Inside([u8; 8]),
}

impl Image {
    pub fn json(&self, counts: &Counts) -> String {
        let members = Members::default();
        match self {
            Self::View(view) => {
                members.with("bufferView", index(*view, counts.views)).with("mimeType", quoted("image/png"))
            }
            Self::Beside(name) => members.with("uri", quoted(&format!("a%20{}.png", name % 4))),
            Self::Inside(bytes) => {
                let picture = base64(&[&b"\x89PNG\r\n\x1a\n"[..], bytes].concat());
                members.with("uri", quoted(&format!("data:image/png;base64,{picture}")))
            }
        }
        .object()
    }
}
