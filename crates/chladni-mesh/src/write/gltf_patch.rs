//! Morph targets put into a glTF file that is there already: everything else in it stays.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use chladni_task::read_file;
use serde_json::{Value, json};

use self::turning::{Local, Shape, turned_along};
use super::glb::{Glb, container, distinct_names};
use super::{MorphTarget, narrowed};
use crate::read::gltf::{Placed, read_placed};
use crate::read::gltf_buffers::Buffers;
use crate::read::gltf_chunks::{gltf_format, json_and_binary};
use crate::read::gltf_json::Root;
use crate::read::{MOST_BYTES, beside};
use crate::surface::vec3::{Vec3, sub};
use crate::{Format, MeshError, TriMesh, nothing_beside};

mod turning;

const FORMAT: Format = Format::Glb;

fn unwritable(reason: impl Into<String>) -> MeshError {
    MeshError::Unwritable { format: FORMAT, reason: reason.into() }
}

/// The glTF file at `source`, which `mesh` was read from, as GLB with one more morph target, at weight 0, for each of
/// `targets`. Morph targets, skins, custom normals, materials, cameras, lights, animations and whatever else the file has
/// stay as they are; buffers and pictures beside it come into the GLB, which goes on naming a picture that is not there or
/// of an unknown kind ([`pictures_beside`](crate::pictures_beside) lists those). Normals of the new targets turn the file's
/// own as the surface turns; where it has none, the targets have none.
///
/// # Errors
/// [`MeshError::Unwritable`] where the file is no longer what `mesh` was read from, holds compressed meshes, places a mesh
/// flat, or would pass 4 GiB; what [`load_mesh`](crate::load_mesh) says of a damaged file.
pub fn add_morph_targets(
    source: &Path,
    mesh: &TriMesh,
    targets: &[MorphTarget],
) -> Result<Vec<u8>, MeshError> {
    let bytes = read_file(source, MOST_BYTES).map_err(MeshError::Io)?;
    let folder = source.parent().unwrap_or(Path::new(""));
    patched(&bytes, &|name| beside::read_within(folder, name, MOST_BYTES), mesh, targets)
}

/// The same for a file that is in memory, beside which there is nothing.
///
/// # Errors
/// As [`add_morph_targets`].
pub fn add_morph_targets_in(
    bytes: &[u8],
    mesh: &TriMesh,
    targets: &[MorphTarget],
) -> Result<Vec<u8>, MeshError> {
    patched(bytes, &nothing_beside, mesh, targets)
}

fn patched(
    bytes: &[u8],
    beside: &beside::Beside<'_>,
    mesh: &TriMesh,
    targets: &[MorphTarget],
) -> Result<Vec<u8>, MeshError> {
    let format = gltf_format(bytes);
    let malformed =
        |fault: crate::error::Fault| MeshError::Malformed { format, at: fault.at, reason: fault.reason };
    let (loaded, placed) = read_placed(bytes, format, beside)?;
    if loaded.mesh.positions != mesh.positions || loaded.mesh.triangles != mesh.triangles {
        return Err(unwritable("the file is not what the shape was read from"));
    }
    if let Some(target) = targets.iter().find(|target| target.displacements.len() != mesh.positions.len()) {
        return Err(unwritable(format!("target '{}' has not one displacement per vertex", target.name)));
    }
    let (json, binary) = json_and_binary(bytes, format).map_err(malformed)?;
    let parse = |error: serde_json::Error| malformed(crate::error::Fault::part("JSON", error.to_string()));
    let root: Root = serde_json::from_slice(json).map_err(parse)?;
    let document: Value = serde_json::from_slice(json).map_err(parse)?;
    if !has_objects(&document) {
        return Err(unwritable("it has a list where an object belongs"));
    }
    let compressed = |name: &&str| {
        name.contains("draco") || name.contains("meshopt") || name.contains("animation_pointer")
    };
    let used = document["extensionsUsed"].as_array().into_iter().flatten().filter_map(Value::as_str);
    if let Some(extension) = used.into_iter().find(|name| compressed(name)) {
        return Err(unwritable(format!("{extension} cannot be kept")));
    }
    let buffers = Buffers::open(&root, binary, beside).map_err(malformed)?;
    let (file, made) = (Glb::default(), HashMap::new());
    let mut patch = Patch { root: &root, buffers: &buffers, document, file, mesh, targets, made };
    patch.take_in_buffers(beside);
    if !targets.is_empty() {
        patch.add(&placed)?;
    }
    patch.finish()
}

/// Whether all that is written to is an object: the reader takes lists of an object's values, too.
fn has_objects(document: &Value) -> bool {
    let objects = |list: &Value| list.as_array().into_iter().flatten().all(Value::is_object);
    document.is_object()
        && ["buffers", "bufferViews", "images", "meshes", "nodes"]
            .iter()
            .all(|name| objects(&document[*name]))
        && document["meshes"].as_array().into_iter().flatten().all(|mesh| objects(&mesh["primitives"]))
}

/// A document in the making. New data goes behind that of its buffers.
struct Patch<'a> {
    root: &'a Root,
    buffers: &'a Buffers<'a>,
    document: Value,
    file: Glb,
    mesh: &'a TriMesh,
    targets: &'a [MorphTarget],
    /// The targets of primitives that were made, by the list of their vertices and the accessor of normals that they turn:
    /// primitives that share their vertices share them.
    made: HashMap<(*const u32, Option<u64>), Vec<Value>>,
}

/// The kind of a picture that glTF knows, by itself or by an extension.
fn picture_kind(bytes: &[u8]) -> Option<&'static str> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => Some("image/png"),
        [0xff, 0xd8, 0xff, ..] => Some("image/jpeg"),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some("image/webp"),
        [_, _, _, _, b'f', b't', b'y', b'p', b'a', b'v', b'i', b'f', ..] => Some("image/avif"),
        [0xab, b'K', b'T', b'X', b' ', b'2', b'0', ..] => Some("image/ktx2"),
        _ => None,
    }
}

/// The array called `name`, made where it is not there.
fn list<'a>(value: &'a mut Value, name: &str) -> &'a mut Vec<Value> {
    let entry = &mut value[name];
    if !entry.is_array() {
        *entry = json!([]);
    }
    match entry {
        Value::Array(list) => list,
        _ => unreachable!("it was made an array"),
    }
}

impl Patch<'_> {
    /// Joins all buffers to one, which a GLB holds itself, and takes in pictures that lie beside the file.
    fn take_in_buffers(&mut self, beside: &beside::Beside<'_>) {
        let mut starts = Vec::new();
        let mut known = HashMap::new();
        for data in self.buffers.all() {
            // Buffers of one uri are taken in once.
            let at = *known.entry((data.as_ptr(), data.len())).or_insert(self.file.data.len());
            starts.push(at);
            if at < self.file.data.len() {
                continue;
            }
            self.file.data.extend_from_slice(data);
            self.file.data.resize(self.file.data.len().next_multiple_of(4), 0);
        }
        for (view, known) in list(&mut self.document, "bufferViews").iter_mut().zip(&self.root.buffer_views) {
            let start = starts.get(known.buffer).copied().unwrap_or(0);
            if known.buffer > 0 || start > 0 {
                view["buffer"] = json!(0);
                view["byteOffset"] = json!(start.saturating_add(known.byte_offset));
            }
        }
        let mut views = HashMap::new();
        for (i, image) in self.root.images.iter().enumerate() {
            let Some(uri) = image.uri.as_deref().filter(|uri| !uri.starts_with("data:")) else { continue };
            let taken_in = views.entry(beside::plain_uri(uri)).or_insert_with(|| {
                let bytes = Buffers::uri(uri, beside).ok()?;
                let kind = picture_kind(&bytes).or(image.mime_type.as_deref())?;
                Some((self.file.view(bytes.iter().copied(), None), kind))
            });
            let Some((view, kind)) = taken_in else { continue };
            let image = &mut self.document["images"][i];
            image["mimeType"] = json!(kind);
            image["bufferView"] = json!(self.root.buffer_views.len() + *view);
            if let Some(image) = image.as_object_mut() {
                image.remove("uri");
            }
        }
    }

    /// Adds the targets to every mesh that the scene places. A mesh that is placed twice becomes two, since its copies may
    /// be exaggerated differently.
    fn add(&mut self, placed: &[Placed]) -> Result<(), MeshError> {
        let shape = Shape::of(self.mesh, self.targets);
        let names = self.own_names(placed);
        let originals = list(&mut self.document, "meshes").clone();
        let (mut taken, mut before_at) = (HashSet::new(), HashMap::new());
        for same in placed.chunk_by(|a, b| (a.place, a.mesh) == (b.place, b.mesh)) {
            let Some(first) = same.first() else { continue };
            let Some(original) = originals.get(first.mesh) else { continue };
            let mut mesh = original.clone();
            let before = self.targets_before(first.mesh);
            for (index, primitive) in list(&mut mesh, "primitives").iter_mut().enumerate() {
                let own = same.iter().find(|placed| placed.primitive == index);
                self.add_to(primitive, own, &shape)?;
            }
            self.name_targets(&mut mesh, self.names_before(first.mesh), &names);
            let at = if taken.insert(first.mesh) {
                self.document["meshes"][first.mesh] = mesh;
                first.mesh
            } else {
                list(&mut self.document, "meshes").push(mesh);
                list(&mut self.document, "meshes").len() - 1
            };
            if let Some(node) = first.node {
                self.document["nodes"][node]["mesh"] = json!(at);
                before_at.insert(node, before);
            }
        }
        // Nodes outside the scene that was read have these meshes, too.
        for (node, known) in self.root.nodes.iter().enumerate() {
            if let Some(mesh) = known.mesh.filter(|mesh| taken.contains(mesh)) {
                before_at.entry(node).or_insert_with(|| self.targets_before(mesh));
            }
        }
        for node in before_at.keys() {
            if let Some(Value::Array(weights)) = self.document["nodes"][*node].get_mut("weights") {
                weights.extend(self.targets.iter().map(|_| json!(0.0)));
            }
        }
        before_at.retain(|_, before| *before > 0);
        self.lengthen_animations(&before_at)
    }

    /// How many targets a mesh has in the file.
    fn targets_before(&self, mesh: usize) -> usize {
        let mesh = self.root.meshes.get(mesh);
        mesh.and_then(|mesh| mesh.primitives.first()).map_or(0, |primitive| primitive.targets.len())
    }

    /// The new targets of one primitive; one that the mesh was not read from, such as lines, rests.
    fn add_to(
        &mut self,
        primitive: &mut Value,
        own: Option<&Placed>,
        shape: &Shape,
    ) -> Result<(), MeshError> {
        let Some(own) = own else {
            let position = primitive["attributes"]["POSITION"].as_u64().and_then(|i| usize::try_from(i).ok());
            let count =
                position.and_then(|i| self.root.accessors.get(i)).map_or(0, |accessor| accessor.count);
            for _ in self.targets {
                let rest = self.accessor_of_zeros(count);
                list(primitive, "targets").push(json!({ "POSITION": rest }));
            }
            return Ok(());
        };
        let local = Local::of(&own.matrix).ok_or_else(|| unwritable("a node makes its mesh flat"))?;
        let normals = self.own_normals(primitive, own)?;
        let turned = normals.as_ref().and_then(|_| primitive["attributes"]["NORMAL"].as_u64());
        let key = (own.vertices.as_ptr(), turned);
        if let Some(made) = self.made.get(&key) {
            list(primitive, "targets").extend(made.iter().cloned());
            return Ok(());
        }
        let mut made = Vec::with_capacity(self.targets.len());
        for (target, turned) in self.targets.iter().zip(&shape.turned) {
            let moved = own.vertices.iter().map(|v| local.offset(target.displacements[*v as usize]));
            let moved: Vec<[f32; 3]> = moved.map(|d| narrowed(d, FORMAT)).collect::<Result<_, _>>()?;
            let mut entry = json!({ "POSITION": self.floats(&moved) });
            if let Some(normals) = &normals {
                let turn = normals.iter().zip(&*own.vertices).map(|(own, v)| {
                    let v = *v as usize;
                    let there =
                        local.normal_here(turned_along(local.normal_there(*own), shape.rest[v], turned[v]));
                    sub(there, *own).map(|x| x as f32)
                });
                let turn: Vec<[f32; 3]> = turn.collect();
                entry["NORMAL"] = json!(self.floats(&turn));
            }
            made.push(entry);
        }
        list(primitive, "targets").extend(made.iter().cloned());
        self.made.insert(key, made);
        Ok(())
    }

    /// The primitive's normals, where it has some that its targets turn: targets of one primitive have the same attributes.
    fn own_normals(&self, primitive: &Value, own: &Placed) -> Result<Option<Vec<Vec3>>, MeshError> {
        let Some(accessor) = primitive["attributes"]["NORMAL"].as_u64() else { return Ok(None) };
        let before = primitive["targets"].get(0);
        if before.is_some_and(|target| target.get("NORMAL").is_none()) {
            return Ok(None);
        }
        let read = self.buffers.vectors::<3>(accessor as usize, "NORMAL");
        let read = read.map_err(|fault| unwritable(format!("{}: {}", fault.at, fault.reason)))?;
        if read.len() != own.vertices.len() {
            return Err(unwritable("a primitive has not one normal per vertex"));
        }
        Ok(Some(read))
    }

    /// The names of the targets that a mesh has in the file.
    fn names_before(&self, mesh: usize) -> Vec<Value> {
        let before = self.targets_before(mesh);
        let known = self.document["meshes"][mesh]["extras"]["targetNames"].as_array();
        let mut names: Vec<Value> = known.into_iter().flatten().take(before).cloned().collect();
        names.extend((names.len()..before).map(|i| json!(format!("target_{i}"))));
        names
    }

    /// The names of the new targets, which no mesh has yet: programs move the sliders of one name in all meshes together.
    fn own_names(&self, placed: &[Placed]) -> Vec<String> {
        let meshes: HashSet<usize> = placed.iter().map(|placed| placed.mesh).collect();
        let taken: Vec<Value> = meshes.into_iter().flat_map(|mesh| self.names_before(mesh)).collect();
        distinct_names(taken.iter().filter_map(Value::as_str), self.targets)
    }

    fn name_targets(&self, mesh: &mut Value, mut names: Vec<Value>, own: &[String]) {
        let weights = list(mesh, "weights");
        weights.resize(names.len(), json!(0.0));
        weights.extend(self.targets.iter().map(|_| json!(0.0)));
        match mesh.get("extras") {
            None => mesh["extras"] = json!({}),
            Some(extras) if extras.is_object() => {}
            // Somebody's own, in which names have no place.
            Some(_) => return,
        }
        names.extend(own.iter().map(|name| json!(name)));
        mesh["extras"]["targetNames"] = Value::Array(names);
    }

    /// Animations of the weights of `nodes` hold the new targets at 0; the value of each is its count of targets before.
    fn lengthen_animations(&mut self, nodes: &HashMap<usize, usize>) -> Result<(), MeshError> {
        let mut animations = std::mem::take(list(&mut self.document, "animations"));
        for animation in &mut animations {
            let Some(Value::Array(channels)) = animation.get_mut("channels") else { continue };
            let mut channels = std::mem::take(channels);
            for channel in &mut channels {
                let node = channel["target"]["node"].as_u64().and_then(|node| nodes.get(&(node as usize)));
                let (Some(before), Some("weights")) = (node, channel["target"]["path"].as_str()) else {
                    continue;
                };
                let samplers = list(animation, "samplers");
                let sampler = channel["sampler"].as_u64().and_then(|i| samplers.get(i as usize).cloned());
                let Some(mut sampler) = sampler else { continue };
                let Some(output) = sampler["output"].as_u64() else { continue };
                let read = self.buffers.scalars(output as usize, "animation");
                let read = read.map_err(|fault| unwritable(format!("{}: {}", fault.at, fault.reason)))?;
                let rest = std::iter::repeat_n(0.0_f32, self.targets.len());
                let lengthened = read
                    .chunks(*before)
                    .flat_map(|key| key.iter().map(|x| *x as f32).chain(rest.clone()).map(|x| [x]))
                    .collect::<Vec<_>>();
                let at = self.file.floats(lengthened.iter().copied(), false);
                // Data of an animation has no target, as that of vertices does.
                self.file.views.last_mut().and_then(Value::as_object_mut).map(|view| view.remove("target"));
                sampler["output"] = json!(self.root.accessors.len() + at);
                samplers.push(sampler);
                channel["sampler"] = json!(samplers.len() - 1);
            }
            animation["channels"] = json!(channels);
        }
        self.put_back("animations", animations);
        Ok(())
    }

    fn put_back(&mut self, name: &str, values: Vec<Value>) {
        if values.is_empty() {
            self.document.as_object_mut().map(|document| document.remove(name));
        } else {
            self.document[name] = json!(values);
        }
    }

    /// The index in the document of a new accessor.
    fn floats(&mut self, values: &[[f32; 3]]) -> usize {
        self.root.accessors.len() + self.file.floats(values.iter().copied(), true)
    }

    fn accessor_of_zeros(&mut self, count: usize) -> usize {
        let zero = [0.0; 3];
        self.file
            .accessors
            .push(json!({ "componentType": 5126, "count": count, "type": "VEC3", "min": zero, "max": zero }));
        self.root.accessors.len() + self.file.accessors.len() - 1
    }

    fn finish(mut self) -> Result<Vec<u8>, MeshError> {
        let views = self.root.buffer_views.len();
        for accessor in &mut self.file.accessors {
            if let Some(view) = accessor.get("bufferView").and_then(Value::as_u64) {
                accessor["bufferView"] = json!(views + view as usize);
            }
        }
        list(&mut self.document, "accessors").append(&mut self.file.accessors);
        list(&mut self.document, "bufferViews").append(&mut self.file.views);
        let mut buffer = self.document["buffers"].get(0).cloned().unwrap_or_else(|| json!({}));
        buffer["byteLength"] = json!(self.file.data.len());
        if let Some(buffer) = buffer.as_object_mut() {
            buffer.remove("uri");
        }
        self.document["buffers"] = json!([buffer]);
        container(&self.document, self.file.data)
    }
}
