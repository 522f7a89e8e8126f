//! Regions that other programs painted.

use std::path::Path;

use chladni_caricature::Painted;
use chladni_harmonics::npz::read_numbers;
use chladni_mesh::{TriMesh, weld};

use crate::work::Error;

/// χ01 from the file at `path`: a number in [0, 1] for each vertex of `mesh`, in the order of its file. In an archive
/// it is the array `mask`.
pub fn region(path: &Path, mesh: &TriMesh) -> Result<Painted, Error> {
    let refused = |why: String| Err(Error::input(format_args!("{}: {why}", path.display())));
    let values = match read_numbers(path, "mask") {
        Ok(values) => values,
        Err(why) => return refused(format!("no mask can be read from it: {why}")),
    };
    let vertices = mesh.positions.len();
    if values.len() != vertices {
        return refused(format!(
            "a mask has a number for each of the {vertices} vertices, this has {}",
            values.len()
        ));
    }
    if let Some((vertex, value)) = values.iter().enumerate().find(|(_, x)| !(0.0..=1.0).contains(*x)) {
        return refused(format!("a mask lies in [0, 1], at vertex {vertex} it is {value}"));
    }
    Ok(Painted::of_file(values.into_iter().map(|x| x as f32), &weld(mesh).operator_vertex))
}
