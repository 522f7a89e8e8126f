//! glTF files whose parts name each other in any way: cycles, repeats, what is not there, and all that the reader looks at.

use arbitrary::Arbitrary;
use chladni_mesh::{Format, MorphTarget, add_morph_targets_in, pictures_beside, read_mesh};

use crate::base64::base64;
use crate::extreme::Number;
use crate::gltf_parts::{Accessor, Image, Material, Node, Primitive, Skin, Texture, View, index};
use crate::json::{Members, list, quoted};
use crate::{MIB, mesh_within};

/// A file. Lists are cut to a few entries.
#[derive(Arbitrary, Debug)]
pub struct GltfGraph {
    is_glb: bool,
    data: [u8; 48],
    scene: Option<u8>,
    scenes: Vec<Vec<u8>>,
    nodes: Vec<Node>,
    skins: Vec<Skin>,
    meshes: Vec<Vec<Primitive>>,
    accessors: Vec<Accessor>,
    views: Vec<View>,
    materials: Vec<Material>,
    textures: Vec<Texture>,
    images: Vec<Image>,
    required: Option<u8>,
}

/// How many of each part there are, for indices that mostly name one.
pub(crate) struct Counts {
    pub nodes: usize,
    pub skins: usize,
    pub meshes: usize,
    pub accessors: usize,
    pub views: usize,
    pub buffers: usize,
    pub materials: usize,
    pub textures: usize,
    pub images: usize,
}

const EXTENSIONS: [&str; 4] = [
    "KHR_texture_transform",
    "KHR_mesh_quantization",
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
];

/// Bytes of the half of a buffer.
const HALF: usize = 512;

impl GltfGraph {
    fn shorten(&mut self) {
        self.scenes.truncate(3);
        self.scenes.iter_mut().for_each(|roots| roots.truncate(8));
        self.nodes.truncate(16);
        self.skins.truncate(4);
        self.meshes.truncate(4);
        self.meshes.iter_mut().for_each(|primitives| primitives.truncate(4));
        self.accessors.truncate(16);
        self.views.truncate(16);
        self.materials.truncate(4);
        self.textures.truncate(4);
        self.images.truncate(4);
    }

    fn counts(&self) -> Counts {
        Counts {
            nodes: self.nodes.len(),
            skins: self.skins.len(),
            meshes: self.meshes.len(),
            accessors: self.accessors.len(),
            views: self.views.len(),
            // Two buffers of one uri share their bytes.
            buffers: if self.is_glb { 1 } else { 2 },
            materials: self.materials.len(),
            textures: self.textures.len(),
            images: self.images.len(),
        }
    }

    /// Numbers of any bits, then small whole ones of 32 bits, so that some indices name a vertex.
    fn buffer(&self) -> Vec<u8> {
        let bytes = || self.data.iter().copied().cycle();
        let small = bytes().take(HALF).enumerate().map(|(i, b)| if i % 4 == 0 { b % 4 } else { 0 });
        bytes().take(HALF).chain(small).collect()
    }

    fn bytes(&self) -> Vec<u8> {
        let (counts, data) = (self.counts(), self.buffer());
        let indices =
            |named: &[u8], count: usize| list(named.iter().take(8).map(|named| index(*named, count)));
        let scene = |roots: &Vec<u8>| Members::default().with("nodes", indices(roots, counts.nodes)).object();
        let mesh = |primitives: &Vec<Primitive>| {
            let primitives = list(primitives.iter().map(|primitive| primitive.json(&counts)));
            Members::default().with("primitives", primitives).object()
        };
        let uri = quoted(&format!("data:application/octet-stream;base64,{}", base64(&data)));
        let buffer = || {
            let buffer = Members::default().with("byteLength", data.len());
            buffer.with_some("uri", (!self.is_glb).then_some(&uri)).object()
        };
        let extension = |named: u8| list([quoted(EXTENSIONS[usize::from(named) % EXTENSIONS.len()])]);
        let json = Members::default()
            .with("asset", r#"{"version":"2.0"}"#)
            .with_some("scene", self.scene.map(|scene| index(scene, self.scenes.len())))
            .with("scenes", list(self.scenes.iter().map(scene)))
            .with("nodes", list(self.nodes.iter().map(|node| node.json(&counts))))
            .with("skins", list(self.skins.iter().map(|skin| skin.json(&counts))))
            .with("meshes", list(self.meshes.iter().map(mesh)))
            .with("accessors", list(self.accessors.iter().map(|accessor| accessor.json(&counts))))
            .with("bufferViews", list(self.views.iter().map(|view| view.json(&counts))))
            .with("materials", list(self.materials.iter().map(|material| material.json(&counts))))
            .with("textures", list(self.textures.iter().map(|texture| texture.json(&counts))))
            .with("images", list(self.images.iter().map(|image| image.json(&counts))))
            .with("buffers", list((0..counts.buffers).map(|_| buffer())))
            .with_some("extensionsRequired", self.required.map(extension))
            .object();
        if self.is_glb { binary(json, &data) } else { json.into_bytes() }
    }
}

/// The two chunks of a GLB.
fn binary(json: String, data: &[u8]) -> Vec<u8> {
    let mut json = json.into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let word = |number: usize| (number as u32).to_le_bytes();
    let all = 28 + json.len() + data.len();
    let header = [&b"glTF"[..], &word(2), &word(all), &word(json.len()), b"JSON"].concat();
    [&header[..], &json, &word(data.len()), b"BIN\0", data].concat()
}

/// Reads the file, and where that works puts a morph target into it, which leaves its mesh as it was.
pub fn gltf_graph(mut graph: GltfGraph) {
    graph.shorten();
    let bytes = graph.bytes();
    let format = if graph.is_glb { Format::Glb } else { Format::Gltf };
    // As `read_mesh` promises. 16 nodes place 4 primitives each, of up to 64 vertices: those cost the file nothing, and take
    // less than 1 KiB each.
    mesh_within(&bytes, format, 256, 4 * MIB);
    assert!(pictures_beside(&bytes).len() <= graph.images.len());
    let Ok(loaded) = read_mesh(&bytes, format) else { return };
    let displacements = vec![[0.0, 0.125, 0.0]; loaded.mesh.positions.len()];
    let target = MorphTarget { name: "up".into(), displacements };
    if let Ok(patched) = add_morph_targets_in(&bytes, &loaded.mesh, &[target]) {
        let back = read_mesh(&patched, Format::Glb).expect("what was written can be read").mesh;
        assert_eq!(back.positions, loaded.mesh.positions);
        assert_eq!(back.triangles, loaded.mesh.triangles);
    }
}

/// Finite numbers as JSON, which knows no others; products of the greatest are not finite.
pub(crate) fn numbers(numbers: &[Number]) -> String {
    let finite = |x: f64| if x.is_finite() { x } else { f64::MAX };
    list(numbers.iter().map(|number| format!("{:e}", finite(number.value()))))
}
