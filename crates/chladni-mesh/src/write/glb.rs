//! glTF 2.0 in one binary file, with morph targets.

use std::collections::{HashMap, HashSet};

use chladni_task::Task;
use serde_json::{Value, json};

use super::{check, far_center, narrowed};
use crate::read::gltf::MOST_VERTICES;
use crate::surface::vec3::{Vec3, add, cross, dot, length, scaled, sub};
use crate::surface::{STAND_IN_NORMAL, corners, places, seamless_triangles, vertex_normals};
use crate::{AlphaMode, CornerUvs, Format, Material, MeshError, TriMesh};

/// A named deformation that viewers offer as a slider from 0 (rest) to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct MorphTarget {
    /// Name of the slider. A number is added to it where another slider of the mesh has it.
    pub name: String,
    /// Displacement of each of the mesh's n vertices at 1, in file units.
    pub displacements: Vec<[f64; 3]>,
}

/// How the weights of morph targets change over time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MorphAnimation<'a> {
    /// Name of the animation.
    pub name: &'a str,
    /// When the keys are, in seconds, ascending.
    pub times_secs: &'a [f32],
    /// For each key the weight of each target; linear in between.
    pub weights: &'a [f32],
}

const FORMAT: Format = Format::Glb;

/// Writes `mesh` as GLB: one mesh, one primitive per material, one morph target per entry of `targets`, all at
/// weight 0, with smooth normals at rest and in every target. Coordinates are rounded to `f32`, far from the origin
/// relative to the shape's [middle](far_center), where its node lies then. Polygons become triangles. A vertex with
/// several texture coordinates is stored several times, the first time at its own index; an attribute `_VERTEX`
/// identifies the copies, so that reading the file back gives the same vertices. Colors of vertices are left out
/// where textures are seen alone.
///
/// # Errors
/// [`MeshError::Unwritable`] where coordinates, also those of textures, do not fit `f32`, a shape is smaller than 1e-30, a
/// target has not n displacements, the mesh's parts do not belong together, or the file would pass 4 GiB or 2^24 vertices.
pub fn write_glb(mesh: &TriMesh, targets: &[MorphTarget]) -> Result<Vec<u8>, MeshError> {
    write(mesh, targets, None, &Task::new())
}

/// As [`write_glb`], with an animation of the targets' weights. The normals of these targets are derivatives, which add up
/// as displacements do: where those of several targets cancel, normals are those at rest.
///
/// # Errors
/// As [`write_glb`], where keys and weights do not belong together, do not ascend or are not finite, and
/// [`MeshError::Cancelled`].
pub fn write_animated_glb(
    mesh: &TriMesh,
    targets: &[MorphTarget],
    animation: MorphAnimation<'_>,
    task: &Task,
) -> Result<Vec<u8>, MeshError> {
    let MorphAnimation { times_secs, weights, .. } = animation;
    let (keys, count) = (times_secs.len(), targets.len());
    let unwritable = |reason: &str| Err(MeshError::Unwritable { format: FORMAT, reason: reason.into() });
    if keys == 0 || count == 0 || keys.checked_mul(count) != Some(weights.len()) {
        return unwritable(&format!("{} weights for {keys} keys of {count} targets", weights.len()));
    }
    if !times_secs.is_sorted_by(|a, b| a < b) || !times_secs.iter().chain(weights).all(|x| x.is_finite()) {
        return unwritable("the keys of its animation do not ascend or are not finite");
    }
    write(mesh, targets, Some(animation), task)
}

/// Checks, before the work that makes them, that `mesh` can be written as GLB with this number of morph `targets`.
///
/// # Errors
/// [`MeshError::Unwritable`] as from [`write_glb`], as far as it can be known without displacements and textures.
pub fn check_glb(mesh: &TriMesh, targets: usize) -> Result<(), MeshError> {
    check(mesh, FORMAT)?;
    // Texture coordinates alone make more vertices.
    let vertices = match &mesh.appearance.uvs {
        Some(_) => Entries::of(mesh).vertices.len(),
        None => mesh.positions.len(),
    };
    check_count(vertices)?;
    check_size(targets, vertices)
}

fn write(
    mesh: &TriMesh,
    targets: &[MorphTarget],
    animation: Option<MorphAnimation<'_>>,
    task: &Task,
) -> Result<Vec<u8>, MeshError> {
    let unwritable = |reason: String| MeshError::Unwritable { format: FORMAT, reason };
    check(mesh, FORMAT)?;
    for target in targets {
        let (there, n) = (target.displacements.len(), mesh.positions.len());
        if there != n {
            return Err(unwritable(format!(
                "target '{}' has {there} displacements for {n} vertices",
                target.name
            )));
        }
    }
    let entries = Entries::of(mesh);
    check_count(entries.vertices.len())?;
    check_size(targets.len(), entries.vertices.len())?;
    let mut file = Glb::default();
    let (center, together) = (far_center(&mesh.positions), animation.is_some());
    let origin = center.unwrap_or_default();
    let (attributes, morphs) = vertex_data(&mut file, mesh, &entries, origin, targets, together, task)?;
    let (materials, default_material) = materials(&mut file, mesh);
    let mut primitives = Vec::new();
    for (material, indices) in primitives_by_material(mesh, &entries, default_material) {
        let accessor = file.indices(&indices);
        let mut primitive = json!({ "attributes": &attributes, "indices": accessor, "material": material });
        if !morphs.is_empty() {
            primitive["targets"] = json!(&morphs);
        }
        primitives.push(primitive);
    }
    if attributes.get("_VERTEX").is_none() && primitives.len() > 1 {
        let accessor = file.floats(entries.vertices.iter().map(|&v| [v as f32]), false);
        primitives.iter_mut().for_each(|primitive| primitive["attributes"]["_VERTEX"] = json!(accessor));
    }
    let mut gltf_mesh = json!({ "primitives": primitives });
    if !targets.is_empty() {
        gltf_mesh["weights"] = json!(vec![0.0; targets.len()]);
        gltf_mesh["extras"] = json!({ "targetNames": distinct_names([], targets) });
    }
    let animations = animation.map(|animation| file.animation(animation));
    let mut node = json!({ "mesh": 0 });
    if let Some(center) = center {
        node["translation"] = json!(center);
    }
    let mut root = json!({
        "asset": { "version": "2.0", "generator": "Chladni" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [node],
        "meshes": [gltf_mesh],
        "materials": materials,
        "accessors": std::mem::take(&mut file.accessors),
        "bufferViews": std::mem::take(&mut file.views),
        "buffers": [{ "byteLength": file.data.len() }],
    });
    if let Some(animation) = animations {
        root["animations"] = json!([animation]);
    }
    if !file.images.is_empty() {
        let textures: Vec<Value> = (0..file.images.len()).map(|image| json!({ "source": image })).collect();
        root["textures"] = json!(textures);
        root["images"] = json!(std::mem::take(&mut file.images));
    }
    container(&root, file.data)
}

/// The names of `targets`, with numbers added where they agree with each other or with those that are `taken`: many programs
/// find a slider by its name.
pub(super) fn distinct_names<'a>(
    taken: impl IntoIterator<Item = &'a str>,
    targets: &[MorphTarget],
) -> Vec<String> {
    let wanted: HashSet<&str> = targets.iter().map(|target| target.name.as_str()).collect();
    let mut found: HashSet<String> = taken.into_iter().map(str::to_owned).collect();
    let distinct = |target: &MorphTarget| {
        let (mut name, mut number) = (target.name.clone(), 1);
        while found.contains(&name) || (number > 1 && wanted.contains(name.as_str())) {
            number += 1;
            name = format!("{} {number}", target.name);
        }
        found.insert(name.clone());
        name
    };
    targets.iter().map(distinct).collect()
}

fn too_large() -> MeshError {
    MeshError::Unwritable { format: FORMAT, reason: "the file would pass 4 GiB".into() }
}

/// Refuses targets that are too large together, before memory is taken for them.
fn check_size(targets: usize, vertices: usize) -> Result<(), MeshError> {
    // A displacement and a change of the normal.
    const BYTES: u64 = 24;
    if targets as u64 * vertices as u64 <= u64::from(u32::MAX) / BYTES {
        return Ok(());
    }
    Err(too_large())
}

/// Refuses more vertices than `_VERTEX` can number, which are more than the reader takes, too.
fn check_count(vertices: usize) -> Result<(), MeshError> {
    if vertices <= MOST_VERTICES {
        return Ok(());
    }
    let reason = format!("it would have more than {MOST_VERTICES} vertices; save PLY or OBJ");
    Err(MeshError::Unwritable { format: FORMAT, reason })
}

/// The vertices as glTF stores them: one per pair of vertex and texture coordinate.
struct Entries {
    /// The mesh's vertex of each entry; entry v is of vertex v for v < n.
    vertices: Vec<u32>,
    uvs: Vec<[f32; 2]>,
    /// For each triangle its entries.
    triangles: Vec<[u32; 3]>,
}

impl Entries {
    fn of(mesh: &TriMesh) -> Self {
        let n = mesh.positions.len();
        let mut vertices: Vec<u32> = (0..n as u32).collect();
        let Some(uvs) = &mesh.appearance.uvs else {
            return Self { vertices, uvs: Vec::new(), triangles: mesh.triangles.clone() };
        };
        let mut first: Vec<Option<u32>> = vec![None; n];
        let mut further = HashMap::new();
        let mut entry = |v: u32, uv: u32| {
            if *first[v as usize].get_or_insert(uv) == uv {
                return v;
            }
            *further.entry((v, uv)).or_insert_with(|| {
                vertices.push(v);
                vertices.len() as u32 - 1
            })
        };
        let mut triangles = Vec::with_capacity(mesh.triangles.len());
        for (f, corners) in mesh.triangle_corners() {
            let (face, start) = (mesh.face(f), mesh.first_corner(f));
            triangles.push(corners.map(|i| entry(face[i], uvs.corners[start + i])));
        }
        // glTF's v runs downward.
        let point =
            |uv: u32| uvs.points.get(uv as usize).map_or([0.0; 2], |&[u, v]| [u as f32, (1.0 - v) as f32]);
        let mut points: Vec<[f32; 2]> = first.iter().map(|uv| point(uv.unwrap_or(CornerUvs::NONE))).collect();
        points.resize(vertices.len(), [0.0; 2]);
        for (&(_, uv), &entry) in &further {
            points[entry as usize] = point(uv);
        }
        Self { vertices, uvs: points, triangles }
    }
}

/// The attributes that all primitives share, with positions from `origin`, and the targets, whose normals are derivatives
/// where they act together.
fn vertex_data(
    file: &mut Glb,
    mesh: &TriMesh,
    entries: &Entries,
    origin: Vec3,
    targets: &[MorphTarget],
    together: bool,
    task: &Task,
) -> Result<(Value, Vec<Value>), MeshError> {
    let from = |origin: Vec3, values: &[Vec3]| -> Result<Vec<[f32; 3]>, MeshError> {
        entries.vertices.iter().map(|&v| narrowed(sub(values[v as usize], origin), FORMAT)).collect()
    };
    let narrow = |values: &[Vec3]| from([0.0; 3], values);
    if !entries.uvs.as_flattened().iter().all(|x| x.is_finite()) {
        let reason = "a texture coordinate is too large for 32 bits, or not a number".into();
        return Err(MeshError::Unwritable { format: FORMAT, reason });
    }
    let place = places(&mesh.positions);
    let triangles = seamless_triangles(mesh, &place);
    let normals = smooth_normals(&place, &mesh.positions, &triangles);
    let mut attributes = json!({
        "POSITION": file.floats(from(origin, &mesh.positions)?.into_iter(), true),
        "NORMAL": file.floats(narrow(&normals)?.into_iter(), false),
    });
    if !entries.uvs.is_empty() {
        attributes["TEXCOORD_0"] = json!(file.floats(entries.uvs.iter().copied(), false));
    }
    if let Some(colors) = mesh.appearance.colors.as_ref().filter(|_| shows_colors(mesh)) {
        let colors = entries.vertices.iter().map(|&v| colors[v as usize]);
        attributes["COLOR_0"] = json!(file.floats(colors, false));
    }
    if entries.vertices.len() > mesh.positions.len() {
        let ids = entries.vertices.iter().map(|&v| [v as f32]);
        attributes["_VERTEX"] = json!(file.floats(ids, false));
    }
    let mut morphs = Vec::new();
    for target in targets {
        task.check()?;
        let turn: Vec<[f64; 3]> = if together {
            normal_derivatives(&place, &mesh.positions, &triangles, &target.displacements)
        } else {
            let moved = mesh.positions.iter().zip(&target.displacements);
            let deformed: Vec<[f64; 3]> = moved.map(|(&p, &d)| add(p, d)).collect();
            let turned = smooth_normals(&place, &deformed, &triangles);
            turned.iter().zip(&normals).map(|(&a, &b)| sub(a, b)).collect()
        };
        morphs.push(json!({
            "POSITION": file.floats(narrow(&target.displacements)?.into_iter(), true),
            "NORMAL": file.floats(narrow(&turn)?.into_iter(), false),
        }));
    }
    Ok((attributes, morphs))
}

/// Unit normals that are one where vertices coincide at rest; `triangles` are the [`seamless_triangles`] of that.
pub(super) fn smooth_normals(place: &[u32], positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Vec<[f64; 3]> {
    let normals = vertex_normals(positions, triangles);
    let normal = |&v: &u32| Some(normals[v as usize]).filter(|n| *n != [0.0; 3]).unwrap_or(STAND_IN_NORMAL);
    place.iter().map(normal).collect()
}

/// The derivative of [`smooth_normals`] along `displacements`, of which it is a linear function; zero where it is none.
///
/// With N the sum of u × v over the triangles at a vertex, u and v their edges and n = N/‖N‖, it is
/// (I − n nᵀ) N′/‖N‖, where N′ is the sum of u′ × v + u × v′.
fn normal_derivatives(
    place: &[u32],
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    displacements: &[Vec3],
) -> Vec<Vec3> {
    let mut sums = vec![([0.0; 3], [0.0; 3]); place.len()];
    for triangle in triangles {
        let edges = |[a, b, c]: [Vec3; 3]| [sub(b, a), sub(c, a)];
        let [u, v] = edges(corners(positions, triangle));
        let [du, dv] = edges(corners(displacements, triangle));
        let (normal, change) = (cross(u, v), add(cross(du, v), cross(u, dv)));
        for &corner in triangle {
            let (normals, changes) = &mut sums[corner as usize];
            *normals = add(*normals, normal);
            *changes = add(*changes, change);
        }
    }
    let derivative = |&v: &u32| {
        let (normal, change) = sums[v as usize];
        let size = length(normal);
        let (n, change) = (normal.map(|x| x / size), change.map(|x| x / size));
        let turn = sub(change, scaled(n, dot(n, change)));
        // Also not where the triangles have no area.
        if turn.iter().all(|x| x.abs() <= f64::from(f32::MAX)) { turn } else { [0.0; 3] }
    };
    place.iter().map(derivative).collect()
}

/// Whether the colors of vertices are seen, also where there are textures, which glTF would multiply with them.
fn shows_colors(mesh: &TriMesh) -> bool {
    let look = &mesh.appearance;
    let is_textured =
        |material: &u32| look.materials.get(*material as usize).and_then(Material::read_texture).is_some();
    look.colors_tint || look.uvs.is_none() || !look.face_materials.iter().flatten().any(is_textured)
}

/// The triangles of each material in use, in the order of the materials.
fn primitives_by_material(mesh: &TriMesh, entries: &Entries, default: usize) -> Vec<(usize, Vec<u32>)> {
    let mut groups: Vec<Vec<u32>> = vec![Vec::new(); default + 1];
    for (triangle, material) in entries.triangles.iter().zip(mesh.triangle_materials()) {
        groups[material.map_or(default, |m| m as usize)].extend(triangle);
    }
    groups.into_iter().enumerate().filter(|(_, indices)| !indices.is_empty()).collect()
}

/// All materials, and the index of the one for faces without: plain white, since glTF's own
/// default is a metal.
fn materials(file: &mut Glb, mesh: &TriMesh) -> (Vec<Value>, usize) {
    let look = &mesh.appearance;
    let mut materials = Vec::new();
    // Many materials may share one picture, under several names.
    let (mut pictures, mut views) = (HashMap::new(), HashMap::new());
    for material in &look.materials {
        let texture = material.read_texture();
        let base_color = match material.base_color {
            // Some programs write black beside a picture, which glTF would multiply with it.
            [0.0, 0.0, 0.0, alpha] if texture.is_some() => [1.0, 1.0, 1.0, alpha],
            color => color,
        };
        let mut pbr = json!({ "baseColorFactor": base_color, "metallicFactor": 0.0, "roughnessFactor": 0.8 });
        if let Some(texture) = texture {
            let picture = (&texture.name, texture.bytes.as_ptr());
            let index = pictures.entry(picture).or_insert_with(|| {
                let view = views.entry(texture.bytes.as_ptr());
                let view = *view.or_insert_with(|| file.view(texture.bytes.iter().copied(), None));
                file.image(&texture.name, view, &texture.bytes)
            });
            pbr["baseColorTexture"] = json!({ "index": index });
        }
        let mut entry = json!({ "name": material.name, "pbrMetallicRoughness": pbr, "doubleSided": true });
        match material.alpha_mode {
            AlphaMode::Mask { cutoff } => {
                entry["alphaMode"] = json!("MASK");
                entry["alphaCutoff"] = json!(cutoff);
            }
            AlphaMode::Usual if material.base_color[3] >= 1.0 => {}
            AlphaMode::Usual | AlphaMode::Blend => entry["alphaMode"] = json!("BLEND"),
        }
        materials.push(entry);
    }
    let default = materials.len();
    if look.face_materials.is_empty() || look.face_materials.contains(&None) {
        materials.push(json!({ "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 0.8 }, "doubleSided": true }));
    }
    (materials, default)
}

#[derive(Default)]
pub(super) struct Glb {
    pub data: Vec<u8>,
    pub views: Vec<Value>,
    pub accessors: Vec<Value>,
    images: Vec<Value>,
}

impl Glb {
    pub fn view(&mut self, bytes: impl Iterator<Item = u8>, target: Option<u32>) -> usize {
        let start = self.data.len();
        self.data.extend(bytes);
        let mut view = json!({ "buffer": 0, "byteOffset": start, "byteLength": self.data.len() - start });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.data.resize(self.data.len().next_multiple_of(4), 0);
        self.views.push(view);
        self.views.len() - 1
    }

    /// An accessor of vectors of N floats, with its bounds where glTF asks for them.
    pub fn floats<const N: usize>(
        &mut self,
        values: impl Iterator<Item = [f32; N]> + Clone,
        bounds: bool,
    ) -> usize {
        let (mut count, mut least, mut greatest) = (0, [f32::INFINITY; N], [f32::NEG_INFINITY; N]);
        for value in values.clone() {
            count += 1;
            for i in 0..N {
                least[i] = least[i].min(value[i]);
                greatest[i] = greatest[i].max(value[i]);
            }
        }
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        let view = self.view(values.flatten().flat_map(f32::to_le_bytes), Some(34962));
        let mut accessor = json!({ "bufferView": view, "componentType": 5126, "count": count, "type": kind });
        if bounds {
            accessor["min"] = json!(least.to_vec());
            accessor["max"] = json!(greatest.to_vec());
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// The animation of the weights of the only node.
    fn animation(&mut self, animation: MorphAnimation<'_>) -> Value {
        let mut series = |values: &[f32]| {
            let view = self.view(values.iter().flat_map(|x| x.to_le_bytes()), None);
            let (least, greatest) =
                values.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
            self.accessors.push(json!({
                "bufferView": view, "componentType": 5126, "count": values.len(), "type": "SCALAR",
                "min": [least], "max": [greatest],
            }));
            self.accessors.len() - 1
        };
        let (input, output) = (series(animation.times_secs), series(animation.weights));
        json!({
            "name": animation.name,
            "samplers": [{ "input": input, "output": output, "interpolation": "LINEAR" }],
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "weights" } }],
        })
    }

    fn indices(&mut self, indices: &[u32]) -> usize {
        let view = self.view(indices.iter().flat_map(|v| v.to_le_bytes()), Some(34963));
        self.accessors.push(
            json!({ "bufferView": view, "componentType": 5125, "count": indices.len(), "type": "SCALAR" }),
        );
        self.accessors.len() - 1
    }

    /// A texture of the picture with these `bytes`, which lie in `view`; returns its index, which is the image's too.
    fn image(&mut self, name: &str, view: usize, bytes: &[u8]) -> usize {
        let kind = if bytes.starts_with(b"\x89PNG") { "image/png" } else { "image/jpeg" };
        self.images.push(json!({ "name": name, "bufferView": view, "mimeType": kind }));
        self.images.len() - 1
    }
}

/// Header and chunks, whose lengths must fit 32 bits.
pub(super) fn container(root: &Value, data: Vec<u8>) -> Result<Vec<u8>, MeshError> {
    let mut json = root.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let total = u32::try_from(12 + 8 + json.len() + 8 + data.len()).map_err(|_| too_large())?;
    let mut bytes = Vec::with_capacity(total as usize);
    bytes.extend_from_slice(b"glTF");
    bytes.extend([2, total, json.len() as u32].iter().flat_map(|word| word.to_le_bytes()));
    bytes.extend_from_slice(b"JSON");
    bytes.extend_from_slice(&json);
    bytes.extend_from_slice(&(data.len() as u32).to_le_bytes());
    bytes.extend_from_slice(b"BIN\0");
    bytes.extend_from_slice(&data);
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_more_vertices_are_written_than_are_read() {
        assert!(check_count(1 << 24).is_ok());
        let refused = check_count((1 << 24) + 1).unwrap_err().to_string();
        assert!(refused.contains("save PLY or OBJ"), "{refused}");
    }

    #[test]
    fn targets_of_more_than_4_gib_are_refused_before_they_are_made() {
        assert!(check_size(1024, 170_000).is_ok());
        let refused = check_size(1024, 180_000).unwrap_err().to_string();
        assert!(refused.contains("4 GiB"), "{refused}");
        let ball = crate::samples::icosphere(0);
        assert!(check_glb(&ball, 2).is_ok() && check_glb(&ball, 20_000_000).is_err());
        assert!(check_glb(&TriMesh::default(), 0).is_err());
    }
}
