//! `chladni symmetry MESH`: which harmonics are symmetric, which antisymmetric, and why.

use std::path::{Path, PathBuf};

use chladni_harmonics::Body;
use chladni_mesh::Orientation;
use chladni_mesh::surface::vec3::single;
use chladni_music::{Class, Symmetry, SymmetryMethod};
use chladni_task::counted;
use chladni_view::{
    Camera, ColorMap, Device, Marker, PictureRequest, PictureShape, Rect, Renderer, Scale, Style, View,
    layout, render_placed,
};
use serde::Serialize;

use super::Terminal;
use crate::work::body::{self, laplacian};
use crate::work::dancer::classes;
use crate::work::outputs::{check_no_texture, check_picture};
use crate::work::{Error, Stance, Watcher, figure_markers, source, write_file};

/// Tell symmetric from antisymmetric harmonics.
#[derive(clap::Args)]
pub struct SymmetryCommand {
    /// A mesh file or sample:NAME.
    mesh: PathBuf,
    /// K, the number of harmonics.
    #[arg(short = 'k', long, value_name = "K", default_value_t = 100)]
    harmonics: usize,
    /// Paper mode: harmonics of the plain cotangent Laplacian, which not every mesh can have, and
    /// classes by the vote of the extrema alone.
    #[arg(long)]
    paper: bool,
    /// Print classes and pairs as JSON.
    #[arg(long)]
    json: bool,
    /// Draw the extrema and their pairs, and the first harmonics with their classes.
    #[arg(long, value_name = "P.png")]
    render: Option<PathBuf>,
}

/// The output of `--json`. Vertices are those of the file, from zero.
#[derive(Serialize)]
struct Printed {
    /// 1 symmetric, −1 antisymmetric, 0 undecided.
    classes: Vec<i8>,
    pairs: Vec<[usize; 2]>,
    extrema: Vec<usize>,
    scores: Vec<f64>,
    /// `mirror` or `vote`.
    method: &'static str,
    /// Unit normal of the mirror plane.
    mirror_normal: Option<[f64; 3]>,
    /// A point on the mirror plane, in the file's units.
    mirror_point: Option<[f64; 3]>,
    /// Root mean square distance of mirrored vertices, as a share of the bounding box.
    mirror_misfit: Option<f64>,
    /// Groups of repeated eigenvalues that were rotated: first harmonic and size.
    rotated: Vec<[usize; 2]>,
}

impl SymmetryCommand {
    /// Classifies and prints.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        self.render.as_deref().map_or(Ok(()), check_picture)?;
        let mesh = source::mesh(&self.mesh, terminal)?;
        self.render.as_deref().map_or(Ok(()), |path| check_no_texture(path, &self.mesh, &mesh))?;
        let name = self.mesh.display().to_string();
        let (body, _) = body::build(&name, &mesh, self.harmonics, laplacian(self.paper), terminal)?;
        let symmetry = terminal
            .watch("finding the mirror", |task| classes(&body, self.paper, task))
            .map_err(|error| error.of(&name))?;
        if let Some(path) = &self.render {
            let stands = Stance::default().of(&name, &mesh, None, None, terminal)?;
            draw(path, &body, &symmetry, stands, &terminal.device()?)?;
        }
        let report = report(&body, &symmetry);
        if self.json {
            return terminal.json(&report);
        }
        let count = |class| symmetry.classes.iter().filter(|c| **c == class).count();
        terminal.result(format_args!(
            "{} symmetric, {} antisymmetric, {} undecided of {}",
            count(Class::Symmetric),
            count(Class::Antisymmetric),
            count(Class::Undecided),
            counted(symmetry.classes.len(), "harmonic", "harmonics")
        ))?;
        match (report.mirror_normal, report.mirror_misfit) {
            (Some([x, y, z]), Some(misfit)) => terminal.result(format_args!(
                "mirror plane with normal ({x:.4}, {y:.4}, {z:.4}), missed by {:.3} % of the bounding box",
                100.0 * misfit
            )),
            _ if self.paper => terminal.result(
                "classes by the vote of the extrema alone, as in the paper (no mirror plane was looked for)",
            ),
            _ => terminal.result("no mirror plane: classes by the vote of the extrema alone, which is rough"),
        }?;
        self.render.as_deref().map_or(Ok(()), |path| terminal.wrote(path))
    }
}

fn report(body: &Body, symmetry: &Symmetry) -> Printed {
    let mut file_vertex = vec![0; body.positions.len()];
    for (v, operator) in body.operator_vertex.iter().enumerate().rev() {
        if let Some(o) = operator {
            file_vertex[*o as usize] = v;
        }
    }
    let file = |v: u32| file_vertex[v as usize];
    let plane = match symmetry.method {
        SymmetryMethod::Mirror(plane) => Some(plane),
        SymmetryMethod::Vote => None,
    };
    Printed {
        classes: symmetry.classes.iter().map(|c| c.sign()).collect(),
        pairs: symmetry.pairs.iter().map(|p| p.map(file)).collect(),
        extrema: symmetry.extrema.iter().map(|&v| file(v)).collect(),
        scores: symmetry.scores.clone(),
        method: if plane.is_some() { "mirror" } else { "vote" },
        mirror_normal: plane.map(|p| p.normal),
        mirror_point: plane.map(|p| body.frame.to_file(p.normal.map(|c| c * p.offset))),
        mirror_misfit: plane.map(|p| p.misfit),
        rotated: symmetry.rotations.iter().map(|r| [r.first, r.mix.len()]).collect(),
    }
}

/// First how often each vertex is an extremum, with both ends of a pair in one color; then the
/// first harmonics: warm markers above for symmetric ones, cool for antisymmetric, gray for none.
fn draw(
    path: &Path,
    body: &Body,
    symmetry: &Symmetry,
    stands: Orientation,
    device: &Device,
) -> Result<(), Error> {
    const SHOWN: usize = 11;
    let rotated = symmetry.rotated(body);
    let basis = &*rotated.basis;
    let positions = single(&body.positions);
    let counts: Vec<f32> = symmetry.extrema_counts.iter().map(|&c| f32::from(c)).collect();
    let most = counts.iter().copied().fold(1.0, f32::max);
    let dots = figure_markers(body, symmetry);
    let from = Camera::on(stands, View::ThreeQuarter);
    let up = stands.up().map(|c| c as f32);
    let height = |p: &[f32; 3]| -> f32 { (0..3).map(|i| up[i] * p[i]).sum() };
    let top = positions.iter().copied().max_by(|p, q| height(p).total_cmp(&height(q))).unwrap_or_default();
    let flag_at: [f32; 3] = std::array::from_fn(|i| top[i] + 0.12 * up[i]);
    let first =
        basis.eigenvalues.partition_point(|&l| l <= 1e-9 * basis.eigenvalues.last().copied().unwrap_or(0.0));
    let harmonics: Vec<(Vec<f32>, Scale, [Marker; 1])> = (first..basis.harmonics().min(first + SHOWN))
        .map(|k| {
            let values: Vec<f32> = basis.harmonic(k).iter().map(|h| *h as f32).collect();
            let color = match symmetry.classes[k] {
                Class::Symmetric => [235, 120, 30],
                Class::Antisymmetric => [40, 110, 230],
                Class::Undecided => [130, 130, 130],
            };
            let [r, g, b] = color;
            let flag = [Marker { position: flag_at, radius_px: 9.0, color: [r, g, b, 255] }];
            let largest = values.iter().fold(1e-12f32, |m, v| m.max(v.abs()));
            (values, Scale { map: ColorMap::BlueRed, low: -largest, high: largest }, flag)
        })
        .collect();
    let shape = PictureShape { positions: &positions, triangles: &body.triangles, ..PictureShape::default() };
    let scale = Scale { map: ColorMap::Viridis, low: 0.0, high: most };
    let mut shapes = vec![PictureShape { values: Some((&counts, scale)), markers: &dots, ..shape }];
    shapes.extend(harmonics.iter().map(|(v, scale, flag)| PictureShape {
        values: Some((v, *scale)),
        markers: flag,
        ..shape
    }));
    let request = PictureRequest { shapes: &shapes, width: 1280, height: 960, from, style: Style::default() };
    // The flags stand above the shape: room for them, too.
    let area = Rect::of_size(request.width, request.height);
    let (mut camera, cells) = (from, layout::grid(area, 3, 4, 0, shapes.len()));
    let raised = positions.iter().copied().chain([flag_at]);
    camera.fit(raised, cells.first().map_or(1.0, Rect::aspect), 0.9);
    let placed: Vec<_> = cells.into_iter().map(|cell| (cell, camera)).collect();
    let picture = render_placed(&mut Renderer::new(device), &request, &placed)?;
    let png = picture.to_png()?;
    write_file(path, &png)
}
