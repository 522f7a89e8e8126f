//! glTF 2.0: the triangles of a scene as one mesh.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use super::beside::{Beside, plain_uri};
use super::draft::{Draft, coordinate, is_texture_point, vertex_index};
use super::gltf_buffers::Buffers;
use super::gltf_chunks::{gltf_format, json_and_binary};
use super::gltf_json::{Accessor, Primitive, Root, TextureInfo};
use super::gltf_matrix::{IDENTITY, Matrix, local_matrix, mirrors, moved, product};
use crate::error::Fault;
use crate::read::{Loaded, Mended};
use crate::{CornerUvs, Format, MeshError};

mod materials;
mod place;
mod skins;
mod uv_transform;

use place::Place;
use skins::Skins;
use uv_transform::Affine;

/// Instances of a mesh, and primitives that share an accessor, cost nothing in the file; this limits the vertices and the
/// texture coordinates that all of them may add up to. `_VERTEX` stores vertex indices as `f32`, which is exact up to here.
pub(crate) const MOST_VERTICES: usize = 1 << 24;

/// How the names of extensions begin that are read, or say nothing about where triangles lie: a file that requires another
/// one is refused.
const EXTENSIONS: [&str; 14] = [
    "ADOBE_materials_",
    "EXT_lights_",
    "EXT_texture_",
    "KHR_animation_pointer",
    "KHR_audio",
    "KHR_lights_",
    "KHR_materials_",
    "KHR_mesh_quantization",
    "KHR_techniques_webgl",
    "KHR_texture_",
    "KHR_xmp",
    "MSFT_lod",
    "MSFT_texture_",
    "VRM",
];

/// Reads triangles, strips and fans, with or without indices, of all meshes that the scene's
/// nodes place, in the order of a walk from the roots. Every primitive brings its own vertices,
/// except where our own writer's `_VERTEX` attribute says which are the same. A skinned mesh lies where
/// the first joint of its skin places it. Morph targets, points and lines are left out.
pub(crate) fn read(bytes: &[u8], format: Format, beside: &Beside<'_>) -> Result<Loaded, MeshError> {
    read_placed(bytes, format, beside).map(|(loaded, _)| loaded)
}

/// A primitive that became a part of the mesh.
pub(crate) struct Placed {
    /// The number of its mesh among all that the scene places, which may be one mesh several times.
    pub place: usize,
    /// The node that places it; `None` of a file without nodes.
    pub node: Option<usize>,
    /// Its mesh, and which of that mesh's primitives it is.
    pub mesh: usize,
    pub primitive: usize,
    /// From its coordinates to the scene's.
    pub matrix: Matrix,
    /// For each of its vertices the one of the mesh that was read.
    pub vertices: Arc<[u32]>,
}

/// As [`read`], with where the parts of the mesh come from.
pub(crate) fn read_placed(
    bytes: &[u8],
    format: Format,
    beside: &Beside<'_>,
) -> Result<(Loaded, Vec<Placed>), MeshError> {
    let read = || {
        let (json, binary) = json_and_binary(bytes, format)?;
        let root: Root =
            serde_json::from_slice(json).map_err(|error| Fault::part("JSON", error.to_string()))?;
        let is_known = |name: &String| EXTENSIONS.iter().any(|known| name.starts_with(*known));
        if let Some(extension) = root.extensions_required.iter().find(|name| !is_known(name)) {
            return Err(Fault::part("extensionsRequired", format!("{extension} is not read")));
        }
        let buffers = Buffers::open(&root, binary, beside)?;
        let mut scene = Scene {
            root: &root,
            buffers,
            draft: Draft::default(),
            stored: Vec::new(),
            moved: false,
            left_out: LeftOut::default(),
            placed: Vec::new(),
            places: 0,
        };
        scene.materials(beside);
        scene.walk()?;
        Ok((scene.draft, scene.moved.then_some(scene.stored), scene.left_out, scene.placed))
    };
    let (mut draft, stored, left_out, placed) =
        read().map_err(|Fault { at, reason }| MeshError::Malformed { format, at, reason })?;
    for (count, what) in [
        (left_out.primitives, "primitives of points or lines"),
        (left_out.targets, "the morph targets of primitives, as if all sliders were at 0"),
        (left_out.poses, "the pose of skinned meshes"),
    ] {
        if count > 0 {
            draft.mended.push(Mended::LeftOut(format!("{what} ({count})")));
        }
    }
    let mut loaded = draft.finish(format)?;
    loaded.stored_positions = stored;
    Ok((loaded, placed))
}

/// The picture files beside it that a glTF file names, also for maps that are not read; none where `bytes` are no glTF
/// file.
pub fn pictures_beside(bytes: &[u8]) -> Vec<String> {
    let Ok((json, _)) = json_and_binary(bytes, gltf_format(bytes)) else { return Vec::new() };
    let Ok(root) = serde_json::from_slice::<Root>(json) else { return Vec::new() };
    let uris = root.images.iter().filter_map(|image| image.uri.as_deref());
    uris.filter(|uri| !uri.starts_with("data:")).map(|uri| plain_uri(uri).into_owned()).collect()
}

/// How much of a file is left out.
#[derive(Default)]
struct LeftOut {
    /// Primitives of points or lines.
    primitives: usize,
    /// Other primitives that have morph targets.
    targets: usize,
    /// Meshes whose joints are not at rest, or not in the scene.
    poses: usize,
}

struct Scene<'a> {
    root: &'a Root,
    buffers: Buffers<'a>,
    draft: Draft,
    /// Positions before the nodes moved them.
    stored: Vec<[f64; 3]>,
    moved: bool,
    left_out: LeftOut,
    placed: Vec<Placed>,
    places: usize,
}

impl Scene<'_> {
    /// Reads the meshes in the order of the nodes that place them, or all where there is no node.
    fn walk(&mut self) -> Result<(), Fault> {
        let root = self.root;
        if root.nodes.is_empty() {
            for mesh in 0..root.meshes.len() {
                self.mesh(None, mesh, &IDENTITY)?;
            }
        }
        let nodes = self.nodes()?;
        let mut skins = Skins::of(root, &nodes);
        for (index, own) in nodes {
            let node = &root.nodes[index];
            let Some(mesh) = node.mesh else { continue };
            // The place of a skinned mesh is that of its joints.
            let bound = node.skin.map(|skin| self.bound(skin, &mut skins)).transpose()?.flatten();
            self.mesh(Some(index), mesh, &bound.unwrap_or(own))?;
        }
        Ok(())
    }

    /// The scene's nodes, each with the map to the scene, parents first. The stack is explicit, because a file may nest
    /// them to any depth.
    fn nodes(&self) -> Result<Vec<(usize, Matrix)>, Fault> {
        let nodes = &self.root.nodes;
        let scene = self.root.scenes.get(self.root.scene.unwrap_or(0));
        let roots = match scene {
            Some(scene) => scene.nodes.clone(),
            None => {
                let mut is_child = vec![false; nodes.len()];
                for &child in nodes.iter().flat_map(|node| &node.children) {
                    if let Some(known) = is_child.get_mut(child) {
                        *known = true;
                    }
                }
                (0..nodes.len()).filter(|&node| !is_child[node]).collect()
            }
        };
        let mut found = Vec::new();
        let mut visited = vec![false; nodes.len()];
        let mut stack: Vec<(usize, Matrix)> = roots.into_iter().rev().map(|node| (node, IDENTITY)).collect();
        while let Some((index, parent)) = stack.pop() {
            let Some(node) = nodes.get(index) else {
                return Err(Fault::part(format!("nodes[{index}]"), "there is no such node"));
            };
            if std::mem::replace(&mut visited[index], true) {
                return Err(Fault::part(
                    format!("nodes[{index}]"),
                    "is reached twice: nodes must form a tree",
                ));
            }
            let matrix = product(&parent, &local_matrix(node));
            found.push((index, matrix));
            stack.extend(node.children.iter().rev().map(|&child| (child, matrix)));
        }
        Ok(found)
    }

    fn mesh(&mut self, node: Option<usize>, index: usize, matrix: &Matrix) -> Result<(), Fault> {
        let Some(mesh) = self.root.meshes.get(index) else {
            return Err(Fault::part(format!("meshes[{index}]"), "there is no such mesh"));
        };
        let mut place = Place::starting_at(self.stored.len());
        let first_corner = self.draft.corners.len();
        let mut brought: Vec<(usize, Range<u32>)> = Vec::new();
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let at = format!("meshes[{index}].primitives[{p}]");
            if matches!(primitive.mode, 4..=6) {
                brought.push((p, self.primitive(primitive, matrix, &at, &mut place)?));
                self.left_out.targets += usize::from(!primitive.targets.is_empty());
            } else {
                self.left_out.primitives += 1;
            }
        }
        let joined = self.rejoin(&place, first_corner);
        // Primitives with the same vertices have one list of them.
        let mut lists: HashMap<Range<u32>, Arc<[u32]>> = HashMap::new();
        for (primitive, range) in brought {
            let list = || range.clone().map(|v| if joined { place.joined(v) } else { v }).collect();
            let vertices: Arc<[u32]> = lists.entry(range.clone()).or_insert_with(list).clone();
            let (place, matrix) = (self.places, *matrix);
            self.placed.push(Placed { place, node, mesh: index, primitive, matrix, vertices });
        }
        self.places += 1;
        Ok(())
    }

    /// Reads a primitive; returns where its vertices lie among all.
    fn primitive(
        &mut self,
        primitive: &Primitive,
        matrix: &Matrix,
        at: &str,
        place: &mut Place,
    ) -> Result<Range<u32>, Fault> {
        let vertices = self.vertices(primitive, matrix, at, place)?;
        let count = vertices.len();
        let indices: Vec<u32> = match primitive.indices {
            Some(accessor) => {
                let check = |index: f64| vertex_index(index as i64, count, |reason| Fault::part(at, reason));
                self.buffers.scalars(accessor, at)?.into_iter().map(check).collect::<Result<_, _>>()?
            }
            None => (0..count as u32).collect(),
        };
        let first_corner = self.draft.corners.len();
        let first_face = self.draft.face_count();
        self.faces(primitive.mode, &indices, vertices.start, mirrors(matrix))?;
        let material = primitive.material.filter(|&m| m < self.draft.materials.len()).map(|m| m as u32);
        if material.is_some() && self.draft.face_materials.is_empty() {
            self.draft.face_materials = vec![None; first_face];
        }
        if material.is_some() || !self.draft.face_materials.is_empty() {
            self.draft.face_materials.resize(self.draft.face_count(), material);
        }
        self.uvs(primitive, &vertices, first_corner, at, place)?;
        Ok(vertices)
    }

    /// Reads the vertices of a primitive, or finds those of an earlier one that says that they are the same.
    fn vertices(
        &mut self,
        primitive: &Primitive,
        matrix: &Matrix,
        at: &str,
        place: &mut Place,
    ) -> Result<Range<u32>, Fault> {
        let attribute = |name: &str| primitive.attributes.get(name).copied();
        let Some(position) = attribute("POSITION") else {
            return Err(Fault::part(at, "has no POSITION"));
        };
        let is_bare = |accessor: &Accessor| accessor.buffer_view.is_none() && accessor.sparse.is_none();
        if primitive.has_draco() && self.root.accessors.get(position).is_some_and(is_bare) {
            return Err(Fault::part(at, "KHR_draco_mesh_compression is not read"));
        }
        let too_many = || Err(Fault::part(at, format!("more than {MOST_VERTICES} vertices in all")));
        if self.draft.corners.len() > 6 * MOST_VERTICES {
            return too_many();
        }
        let (color, id) = (attribute("COLOR_0"), attribute("_VERTEX"));
        if let Some(known) = place.known(position, color, id) {
            return Ok(known);
        }
        let base = self.stored.len();
        let points = self.buffers.vectors::<3>(position, at)?;
        let count = points.len();
        if base + count > MOST_VERTICES {
            return too_many();
        }
        let check = |x| coordinate(x, |reason| Fault::part(format!("{at}, accessors[{position}]"), reason));
        for point in points {
            let placed = moved(matrix, point);
            for x in point.into_iter().chain(placed) {
                check(x)?;
            }
            self.stored.push(point);
            self.draft.positions.push(placed);
        }
        self.moved |= *matrix != IDENTITY;
        self.colors(color, base, count, at)?;
        let ids = id.map(|accessor| self.buffers.scalars(accessor, at)).transpose()?;
        let vertices = base as u32..(base + count) as u32;
        place.brings(vertices.clone(), position, color, id.zip(ids));
        Ok(vertices)
    }

    fn faces(&mut self, mode: u32, indices: &[u32], base: u32, mirrored: bool) -> Result<(), Fault> {
        let first = self.draft.corners.len();
        match mode {
            4 => {
                for &[a, b, c] in indices.as_chunks().0 {
                    self.draft.corners.extend([base + a, base + b, base + c]);
                    self.draft.end_face();
                }
            }
            5 => self.draft.push_strip(indices.iter().map(|&v| Ok(Some(base + v))))?,
            _ => {
                for pair in indices.get(1..).unwrap_or_default().windows(2) {
                    self.draft.corners.extend([base + indices[0], base + pair[0], base + pair[1]]);
                    self.draft.end_face();
                }
            }
        }
        if mirrored {
            // A mirroring node turns its triangles inside out.
            for [_, b, c] in self.draft.corners[first..].as_chunks_mut().0 {
                std::mem::swap(b, c);
            }
        }
        Ok(())
    }

    fn colors(&mut self, accessor: Option<usize>, base: usize, count: usize, at: &str) -> Result<(), Fault> {
        let draft = &mut self.draft;
        if let Some(accessor) = accessor {
            draft.colors.resize(base, [1.0; 4]);
            draft.colors_tint = true;
            let mut mended = 0;
            for color in self.buffers.colors(accessor, at)?.into_iter().take(count) {
                let finite = color.iter().all(|c| c.is_finite());
                mended += usize::from(!finite);
                draft.colors.push(if finite { color.map(|c| c.clamp(0.0, 1.0) as f32) } else { [1.0; 4] });
            }
            if mended > 0 {
                draft.mended.push(Mended::Colors(mended));
            }
        }
        if !draft.colors.is_empty() {
            draft.colors.resize(base + count, [1.0; 4]);
        }
        Ok(())
    }

    fn uvs(
        &mut self,
        primitive: &Primitive,
        vertices: &Range<u32>,
        first_corner: usize,
        at: &str,
        place: &mut Place,
    ) -> Result<(), Fault> {
        let material = primitive.material.and_then(|m| self.root.materials.get(m));
        let texture = material.and_then(|m| m.pbr_metallic_roughness.as_ref()?.base_color_texture.as_ref());
        let set = texture.map_or(0, TextureInfo::set);
        let transform = texture.and_then(Affine::of);
        let draft = &mut self.draft;
        let points = match primitive.attributes.get(&format!("TEXCOORD_{set}")).copied() {
            None => 0..0,
            Some(accessor) => match place.known_uvs(vertices, accessor, transform) {
                Some(known) => known,
                None => {
                    let first = draft.uvs.len();
                    let points = self.buffers.vectors::<2>(accessor, at)?;
                    // glTF's v runs downward.
                    draft.uvs.extend(points.into_iter().take(vertices.len()).map(|point| {
                        let [u, v] = transform.map_or(point, |transform| transform.of_point(point));
                        [u, 1.0 - v]
                    }));
                    if draft.uvs.len() > MOST_VERTICES {
                        let reason = format!("more than {MOST_VERTICES} texture coordinates in all");
                        return Err(Fault::part(at, reason));
                    }
                    place.brings_uvs(vertices, accessor, transform, first..draft.uvs.len())
                }
            },
        };
        let mut bad = 0;
        for corner in first_corner..draft.corners.len() {
            let point = points.start + (draft.corners[corner] - vertices.start) as usize;
            let uv = match draft.uvs.get(point).filter(|_| point < points.end) {
                Some(p) if is_texture_point(*p) => point as u32,
                Some(_) => {
                    bad += 1;
                    CornerUvs::NONE
                }
                None => CornerUvs::NONE,
            };
            draft.corner_uvs.push(uv);
        }
        if bad > 0 {
            draft.mended.push(Mended::Uvs(bad));
        }
        Ok(())
    }
}
