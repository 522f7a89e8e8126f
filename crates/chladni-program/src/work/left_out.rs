//! What a file lacks of the shape that is written to it: warnings after the work.

use std::collections::BTreeSet;
use std::path::Path;

use chladni_mesh::{Format, ShapeSource, TriMesh, far_center, name_within, picture_name, pictures_beside};
use chladni_task::folder_of;

use super::Warning;

/// The part of a glTF file that a GLB lacks where it is written anew.
pub const LEFT_OF_GLTF: &str = "rigs, animations, normals and sliders that it had are left out of the GLB";

/// A warning of what the file at `path` lacks of `mesh`, which is written there without sliders and came from `source`.
pub fn left_by(source: &ShapeSource, mesh: &TriMesh, path: &Path) -> Option<Warning> {
    match (Format::of_path(path), source.file()) {
        (Some(Format::Stl), _) => rounded_in_stl(mesh),
        (Some(Format::Obj), Some(source)) => left_pictures(source, mesh, path),
        (_, source) => left_of_gltf(source?, path),
    }
}

/// A warning where the mesh of the file `source` is written anew to `path`, both glTF: only an export of layers keeps all
/// else that such a file holds.
pub fn left_of_gltf(source: &Path, path: &Path) -> Option<Warning> {
    (is_gltf(source) && is_gltf(path)).then(|| Warning::of(source.display(), LEFT_OF_GLTF))
}

/// A warning where the numbers of an STL are too coarse for a mesh that lies as far from the origin as `mesh` does.
pub fn rounded_in_stl(mesh: &TriMesh) -> Option<Warning> {
    let center = far_center(&mesh.positions)?;
    let step = center.iter().fold(0.0, |far: f64, x| far.max(x.abs())) * f64::from(f32::EPSILON);
    Some(Warning::Plain(format!(
        "the coordinates are so large that STL rounds them to about {step:.0e}: save PLY, or move the shape to the origin"
    )))
}

/// A warning where pictures beside `source` that the materials of its `mesh` name, such as bump maps, are not beside the OBJ
/// at `path`: only pictures of colors are brought there.
pub(super) fn left_pictures(source: &Path, mesh: &TriMesh, path: &Path) -> Option<Warning> {
    let is_left =
        |name: &String| folder_of(source).join(name).is_file() && !folder_of(path).join(name).is_file();
    let left = |statement: &String| other_picture(statement)?.find(is_left);
    let statements = mesh.appearance.materials.iter().flat_map(|material| &material.other_statements);
    let named = listed(&statements.filter_map(left).collect())?;
    let source = source.display();
    Some(Warning::of(
        path.display(),
        format_args!("its materials name {named}, which it lacks: copy what lies beside {source}"),
    ))
}

/// The names that the picture of a material's statement may have, with `/` between the parts; `None` where the statement
/// names no picture. A name may hold blanks, or be the last word after options that are not known.
pub(super) fn other_picture(statement: &str) -> Option<impl Iterator<Item = String>> {
    let (keyword, rest) = statement.split_once(char::is_whitespace)?;
    let is_picture =
        keyword.starts_with("map_") || ["bump", "norm", "disp", "decal", "refl"].contains(&keyword);
    let names = [picture_name(rest), rest.split_whitespace().next_back()?];
    is_picture.then(|| names.into_iter().filter_map(name_within))
}

/// A warning where `glb`, made of the glTF file `source`, names pictures that it does not hold: they are not there, or of an
/// unknown kind.
pub fn pictures_apart(source: &Path, glb: &[u8]) -> Option<Warning> {
    let named = listed(&pictures_beside(glb).into_iter().collect())?;
    Some(Warning::of(source.display(), format_args!("names {named}, which the GLB does not hold")))
}

/// The first of `names`, and how many there are besides; `None` where there are none.
fn listed(names: &BTreeSet<String>) -> Option<String> {
    let first = names.first()?;
    Some(match names.len() {
        1 => first.clone(),
        count => format!("{first} and {} more", count - 1),
    })
}

/// Whether a file's name is one of glTF.
pub fn is_gltf(path: &Path) -> bool {
    matches!(Format::of_path(path), Some(Format::Glb | Format::Gltf))
}
