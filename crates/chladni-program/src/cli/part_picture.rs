//! The parts of a shape in colors, beside the bare shape.

use std::path::Path;

use chladni_mesh::TriMesh;
use chladni_view::{Camera, PictureRequest, PictureShape, Style, View, render_picture};

use super::Terminal;
use crate::work::{Error, Stance};

/// A shape with a color for each vertex.
pub struct Colored<'a> {
    pub name: &'a str,
    pub mesh: &'a TriMesh,
    /// Linear light.
    pub colors: Vec<[f32; 4]>,
}

/// Draws it beside the bare shape.
pub fn draw(
    path: &Path,
    Colored { name, mesh, colors }: Colored<'_>,
    terminal: &Terminal,
) -> Result<(), Error> {
    let positions: Vec<[f32; 3]> = mesh.positions.iter().map(|p| p.map(|x| x as f32)).collect();
    let plain = PictureShape { positions: &positions, triangles: &mesh.triangles, ..PictureShape::default() };
    let shapes = [PictureShape { colors: Some(&colors), ..plain }, plain];
    let stands = Stance::default().of(name, mesh, None, None, terminal)?;
    let from = Camera::on(stands, View::ThreeQuarter);
    let request = PictureRequest { shapes: &shapes, width: 1000, height: 600, from, style: Style::default() };
    let png = render_picture(&terminal.device()?, &request).and_then(|picture| picture.to_png())?;
    chladni_task::write_atomic(path, &png).map_err(|error| Error::unwritten(path, error))
}
