//! Binary little-endian PLY with coordinates as doubles.

use crate::appearance::srgb_from_linear;
use crate::read::ply::{Role, named_role};
use crate::{Appearance, CornerUvs, TriMesh};

/// The bytes of `mesh`. Texture coordinates go to the vertices where each has one, else to the
/// corners of the faces; of the materials only the first texture's name is kept.
pub(crate) fn write(mesh: &TriMesh) -> Vec<u8> {
    let look = &mesh.appearance;
    let vertex_uvs = vertex_uvs(mesh);
    let corner_uvs = look.uvs.as_ref().filter(|_| vertex_uvs.is_none());
    let most_corners = (0..mesh.face_count()).map(|f| mesh.face(f).len()).max().unwrap_or(0);
    // A texcoord list has two entries per corner.
    let wide = most_corners > 127;
    let mut header = String::from("ply\nformat binary_little_endian 1.0\n");
    if let Some(texture) = mesh.base_color_texture() {
        let name = texture.name.replace(['\n', '\r'], " ");
        header.push_str(&format!("comment TextureFile {name}\n"));
    }
    header.push_str(&format!("element vertex {}\n", mesh.positions.len()));
    header.push_str("property double x\nproperty double y\nproperty double z\n");
    if look.colors.is_some() {
        for channel in ["red", "green", "blue", "alpha"] {
            header.push_str(&format!("property uchar {channel}\n"));
        }
    }
    if vertex_uvs.is_some() {
        header.push_str("property double s\nproperty double t\n");
    }
    for name in attribute_names(look, vertex_uvs.is_some()) {
        header.push_str(&format!("property double {name}\n"));
    }
    let length = if wide { "uint" } else { "uchar" };
    header.push_str(&format!(
        "element face {}\nproperty list {length} int vertex_indices\n",
        mesh.face_count()
    ));
    if corner_uvs.is_some() {
        header.push_str(&format!("property list {length} double texcoord\n"));
    }
    header.push_str("end_header\n");

    let mut bytes = header.into_bytes();
    let doubles = |bytes: &mut Vec<u8>, values: &[f64]| {
        values.iter().for_each(|x| bytes.extend_from_slice(&x.to_le_bytes()));
    };
    for (v, p) in mesh.positions.iter().enumerate() {
        doubles(&mut bytes, p);
        if let Some(colors) = &look.colors {
            let [r, g, b, alpha] = colors[v].map(f64::from);
            let [r, g, b] = [r, g, b].map(srgb_from_linear);
            bytes.extend([r, g, b, alpha].map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8));
        }
        if let Some(uvs) = &vertex_uvs {
            doubles(&mut bytes, &uvs[v]);
        }
        look.attributes.iter().for_each(|attribute| doubles(&mut bytes, &attribute.values[v..=v]));
    }
    let push_length = |bytes: &mut Vec<u8>, length: usize| {
        let length = (length as u32).to_le_bytes();
        bytes.extend_from_slice(if wide { &length } else { &length[..1] });
    };
    for f in 0..mesh.face_count() {
        let face = mesh.face(f);
        push_length(&mut bytes, face.len());
        face.iter().for_each(|v| bytes.extend_from_slice(&v.to_le_bytes()));
        let Some(uvs) = corner_uvs else { continue };
        let first = mesh.first_corner(f);
        let indices = &uvs.corners[first..first + face.len()];
        let has_any = indices.iter().any(|&uv| uv != CornerUvs::NONE);
        push_length(&mut bytes, if has_any { 2 * face.len() } else { 0 });
        for uv in indices.iter().filter(|_| has_any) {
            // A corner without one among others has a place in the list, too.
            doubles(&mut bytes, &uvs.points.get(*uv as usize).copied().unwrap_or([f64::NAN; 2]));
        }
    }
    bytes
}

/// The names of the attributes. One that would be read as a coordinate, a color or a texture coordinate, beside the mesh's
/// own, begins with `_`.
fn attribute_names(look: &Appearance, has_vertex_uvs: bool) -> impl Iterator<Item = String> {
    let is_taken = move |name: &str| match named_role(name) {
        Role::Position(_) => true,
        Role::Color(_) => look.colors.is_some(),
        Role::Uv(_) => has_vertex_uvs,
        Role::Attribute(_) | Role::Other => false,
    };
    let is_attribute = move |name: &str| look.attributes.iter().any(|attribute| attribute.name == name);
    look.attributes.iter().map(move |attribute| {
        let mut name = attribute.name.clone();
        while is_taken(&name) || (name != attribute.name && is_attribute(&name)) {
            name.insert(0, '_');
        }
        name
    })
}

/// One texture coordinate per vertex where all corners at a vertex agree.
fn vertex_uvs(mesh: &TriMesh) -> Option<Vec<[f64; 2]>> {
    let uvs = mesh.appearance.uvs.as_ref()?;
    let mut known: Vec<Option<[f64; 2]>> = vec![None; mesh.positions.len()];
    let corners = (0..mesh.face_count()).flat_map(|f| mesh.face(f));
    for (&v, &uv) in corners.zip(&uvs.corners) {
        let point = *uvs.points.get(uv as usize)?;
        if *known[v as usize].get_or_insert(point) != point {
            return None;
        }
    }
    Some(known.into_iter().map(Option::unwrap_or_default).collect())
}
