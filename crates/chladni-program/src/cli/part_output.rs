//! What becomes of the parts of a shape, named or not: files, a picture beside the bare shape, lines.

use std::path::{Path, PathBuf};

use chladni_caricature::HEAD_PARTS;
use chladni_mesh::TriMesh;
use chladni_mesh::surface::drawn_triangles;
use chladni_mesh::surface::vec3::single;
use chladni_view::{Camera, PictureRequest, PictureShape, Style, View, render_picture};

use super::Terminal;
use crate::work::outputs::{check_arrays, check_picture};
use crate::work::{Error, Stance, write_file};

/// What to make of the parts.
#[derive(clap::Args)]
pub struct PartOutput {
    /// Write the part of each vertex here (NumPy archive: part, and of a head confidence; parts are numbered from 0 as
    /// they are printed).
    #[arg(short, long, value_name = "P.npz")]
    pub output: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
    /// Draw the shape with its parts.
    #[arg(long, value_name = "P.png")]
    pub render: Option<PathBuf>,
}

impl PartOutput {
    /// Whether the files can be written, before work is done for them.
    pub fn check(&self) -> Result<(), Error> {
        self.output.as_deref().map_or(Ok(()), check_arrays)?;
        self.render.as_deref().map_or(Ok(()), check_picture)
    }

    /// Prints where the files are.
    pub fn print_files(&self, terminal: &Terminal) -> Result<(), Error> {
        [&self.output, &self.render].into_iter().flatten().try_for_each(|path| terminal.wrote(path))
    }
}

/// A color for each part.
pub const COLORS: [[f32; 4]; HEAD_PARTS.len()] = [
    [0.84, 0.23, 0.18, 1.0],
    [0.95, 0.62, 0.18, 1.0],
    [0.16, 0.45, 0.78, 1.0],
    [0.78, 0.30, 0.55, 1.0],
    [0.22, 0.60, 0.38, 1.0],
    [0.55, 0.72, 0.28, 1.0],
    [0.93, 0.77, 0.62, 1.0],
    [0.45, 0.33, 0.68, 1.0],
    [0.62, 0.66, 0.70, 1.0],
    [0.36, 0.62, 0.66, 1.0],
];

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
    let positions = single(&mesh.positions);
    let triangles = drawn_triangles(mesh);
    let plain = PictureShape { positions: &positions, triangles: &triangles, ..PictureShape::default() };
    let shapes = [PictureShape { colors: Some(&colors), ..plain }, plain];
    let stands = Stance::default().of(name, mesh, None, None, terminal)?;
    let from = Camera::on(stands, View::ThreeQuarter);
    let request = PictureRequest { shapes: &shapes, width: 1000, height: 600, from, style: Style::default() };
    let png = render_picture(&terminal.device()?, &request).and_then(|picture| picture.to_png())?;
    write_file(path, &png)
}
