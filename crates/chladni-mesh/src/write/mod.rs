//! From a mesh to bytes, and to files.

mod glb;
mod gltf_patch;
mod obj;
mod ply;
mod stl;

use std::path::Path;

use chladni_task::write_atomic;

pub use glb::{MorphAnimation, MorphTarget, check_glb, write_animated_glb, write_glb};
pub use gltf_patch::{add_morph_targets, add_morph_targets_in};

use crate::read::draft::GREATEST_COORDINATE;
use crate::surface::Bounds;
use crate::{Attribute, Format, MeshError, TriMesh};

/// The least extent of a shape that is rounded to `f32`, which below 1e-38 holds fewer and fewer digits.
const LEAST_EXTENT: f64 = 1e-30;

/// Writes `mesh` as OBJ, binary PLY, binary STL or GLB.
///
/// OBJ and PLY hold coordinates exactly; STL and GLB round them to `f32`, GLB far from the origin relative to the shape's
/// [middle](far_center). An OBJ with materials names the library `materials.mtl`, which [`save_mesh`] writes too, under a
/// name of its own; without it, blanks take the place of number signs in names of materials.
///
/// # Errors
/// [`MeshError::Unwritable`] for another format, for coordinates that the format cannot hold, for a shape of less than
/// 1e-30 units as STL or GLB, and for a mesh whose triangles, faces or appearance do not belong together.
pub fn write_mesh(mesh: &TriMesh, format: Format) -> Result<Vec<u8>, MeshError> {
    check(mesh, format)?;
    match format {
        Format::Obj => Ok(obj::write(mesh)),
        Format::Ply => Ok(ply::write(mesh)),
        Format::Stl => stl::write(mesh),
        Format::Glb => write_glb(mesh, &[]),
        _ => Err(MeshError::Unwritable { format, reason: "only OBJ, PLY, STL and GLB are written".into() }),
    }
}

/// Writes `mesh` to `path` in the format of its extension, whole or not at all. An OBJ with
/// materials brings a library and its pictures along, into the same folder; a picture never
/// replaces another file, and a library only that of the file that was at `path`.
///
/// # Errors
/// Those of [`write_mesh`] and of the file system, each inside a [`MeshError::InFile`].
pub fn save_mesh(mesh: &TriMesh, path: &Path) -> Result<(), MeshError> {
    let save = || {
        let Some(format) = Format::of_path(path) else {
            let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
            let reason = format!("no mesh format is called '.{extension}' (written are obj, ply, stl, glb)");
            return Err(MeshError::UnknownFormat(reason));
        };
        if format == Format::Obj && !mesh.appearance.materials.is_empty() {
            check(mesh, format)?;
            return obj::save_with_materials(mesh, path);
        }
        write_atomic(path, &write_mesh(mesh, format)?).map_err(MeshError::Io)
    };
    save().map_err(|error| MeshError::InFile { path: path.to_owned(), error: Box::new(error) })
}

/// Whether all coordinates can be read again, all indices are in range and the appearance belongs to the triangles.
fn check(mesh: &TriMesh, format: Format) -> Result<(), MeshError> {
    let refused = |reason: &str| Err(MeshError::Unwritable { format, reason: reason.into() });
    let n = mesh.positions.len();
    let look = &mesh.appearance;
    let in_range = |vertices: &[u32]| vertices.iter().all(|&v| (v as usize) < n);
    if mesh.triangles.is_empty() {
        return refused("it has no triangle");
    }
    if !in_range(mesh.triangles.as_flattened()) {
        return refused("a triangle names a vertex that is not there");
    }
    // The readers refuse what lies beyond. Not a number is not below it, either.
    let beyond = |p: &[f64; 3]| !p.iter().all(|x| x.abs() <= GREATEST_COORDINATE);
    if let Some(v) = mesh.positions.iter().position(beyond) {
        return refused(&format!(
            "vertex {v} has a coordinate that is not a number, or beyond {GREATEST_COORDINATE:e}"
        ));
    }
    if matches!(format, Format::Stl | Format::Glb) {
        let Bounds { low, high } =
            Bounds::of(mesh.triangles.as_flattened().iter().map(|&v| mesh.positions[v as usize]));
        // Not the diagonal: its square would underflow.
        let extent = low.iter().zip(high).fold(0.0, |extent: f64, (low, high)| extent.max(high - low));
        if extent > 0.0 && extent < LEAST_EXTENT {
            return refused(&format!("it is {extent:.0e} across, too small for 32 bits: scale it"));
        }
    }
    let mut corners = 3 * mesh.triangles.len();
    if let Some(polygons) = &look.polygons {
        let ends = polygons.starts.windows(2).all(|pair| pair[0] <= pair[1]);
        let whole = polygons.starts.first() == Some(&0)
            && polygons.starts.last().map(|&end| end as usize) == Some(polygons.items.len());
        if !ends || !whole || !in_range(&polygons.items) {
            return refused("its polygons are not what they should be");
        }
        let fan: usize = (0..polygons.len()).map(|f| polygons.row(f).len().saturating_sub(2)).sum();
        if fan != mesh.triangles.len() {
            return refused("its polygons are not those of its triangles");
        }
        corners = polygons.items.len();
    }
    let is_of_its_face = |(f, triangles): (&u32, &Vec<[u32; 3]>)| {
        let f = *f as usize;
        let count = if f < mesh.face_count() { mesh.face(f).len() } else { 0 };
        triangles.len() + 2 == count && triangles.as_flattened().iter().all(|&c| (c as usize) < count)
    };
    if !look.divided.iter().all(is_of_its_face) {
        return refused("its polygons are not divided into triangles of their corners");
    }
    if look.colors.as_ref().is_some_and(|colors| colors.len() != n) {
        return refused("it has not one color per vertex");
    }
    for Attribute { name, values } in &look.attributes {
        if values.len() != n {
            return refused(&format!("it has not one '{name}' per vertex"));
        }
        if name.is_empty() || name.contains(|c: char| c.is_ascii_whitespace()) {
            return refused(&format!("the name of its attribute '{name}' is not one word"));
        }
    }
    if look.uvs.as_ref().is_some_and(|uvs| uvs.corners.len() != corners) {
        return refused("it has not one texture coordinate per corner");
    }
    if !look.face_materials.is_empty() && look.face_materials.len() != mesh.face_count() {
        return refused("it has not one material per face");
    }
    if look.face_materials.iter().flatten().any(|&m| m as usize >= look.materials.len()) {
        return refused("a face names a material that is not there");
    }
    Ok(())
}

/// The middle, as `f32` holds it, of positions that lie more than a thousand times their extent from the origin, such as
/// those of a georeferenced scan. `f32` is too coarse for these, unless they are written relative to it.
pub fn far_center(positions: &[[f64; 3]]) -> Option<[f64; 3]> {
    const FAR: f64 = 1000.0;
    let bounds = Bounds::of(positions.iter().copied());
    let farthest = bounds.low.iter().chain(&bounds.high).fold(0.0, |far: f64, x| far.max(x.abs()));
    // Beyond `f32` there is no such middle.
    let is_far = farthest > FAR * bounds.diagonal() && farthest <= f64::from(f32::MAX);
    is_far.then(|| std::array::from_fn(|i| f64::from(((bounds.low[i] + bounds.high[i]) / 2.0) as f32)))
}

/// `position` as `f32`, for formats that hold no more.
fn narrowed(position: [f64; 3], format: Format) -> Result<[f32; 3], MeshError> {
    let narrow = position.map(|x| x as f32);
    if narrow.iter().all(|x| x.is_finite()) {
        return Ok(narrow);
    }
    Err(MeshError::Unwritable {
        format,
        reason: "a coordinate is too large for 32 bits, or not a number".into(),
    })
}
