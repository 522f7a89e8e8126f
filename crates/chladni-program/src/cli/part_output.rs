//! The files that the parts of a shape become, named or not: arrays, and a picture from both sides.

use std::f32::consts::PI;
use std::path::{Path, PathBuf};

use chladni_caricature::HEAD_PARTS;
use chladni_mesh::TriMesh;
use chladni_mesh::surface::drawn_triangles;
use chladni_mesh::surface::vec3::single;
use chladni_view::{
    Camera, PickTree, PictureRequest, PictureShape, Rect, Renderer, Style, framing, render_placed,
};

use super::Terminal;
use super::portrait::Portrait;
use crate::work::outputs::{check_arrays, check_picture};
use crate::work::{Error, Lettering, Watcher, write_file};

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
    /// Draw the shape from both sides, in the colors of its parts and with their names or numbers on them.
    #[arg(long, value_name = "P.png")]
    pub render: Option<PathBuf>,
    #[command(flatten)]
    portrait: Portrait,
}

impl PartOutput {
    /// Whether the files can be written, and no option is without effect, before work is done for them.
    pub fn check(&self) -> Result<(), Error> {
        self.portrait.check_used(self.render.is_some())?;
        self.portrait.check()?;
        self.output.as_deref().map_or(Ok(()), check_arrays)?;
        self.render.as_deref().map_or(Ok(()), check_picture)
    }

    /// Draws a shape in the colors of its parts from both sides, with the text of each part on it where it is seen.
    pub fn draw(&self, path: &Path, shape: &Divided<'_>, terminal: &Terminal) -> Result<(), Error> {
        let Divided { name, mesh, part, marks } = shape;
        let positions = single(&mesh.positions);
        let triangles = drawn_triangles(mesh);
        let color = |part: &Option<usize>| part.and_then(|part| marks.get(part));
        let colors: Vec<[f32; 4]> =
            part.iter().map(|part| color(part).map_or([1.0; 4], |(_, color)| *color)).collect();
        let from = self.portrait.camera(name, mesh, None, None, terminal)?;
        let [width, height] = self.portrait.size();
        let placed = both_sides(from, &positions, Rect::of_size(width, height));
        let drawn = PictureShape {
            positions: &positions,
            triangles: &triangles,
            colors: Some(&colors),
            ..PictureShape::default()
        };
        let request = PictureRequest { shapes: &[drawn; 2], width, height, from, style: Style::default() };
        let mut picture = render_placed(&mut Renderer::new(terminal.device()?), &request, &placed)?;
        let tree = PickTree::new(&positions, &triangles);
        let samples = shape.samples(&positions, &triangles);
        for view in &placed {
            let size_px = (view.0.width.min(view.0.height) as f32 / 30.0).max(12.0);
            let places = places_of_text(&samples, view, &tree, (&positions, &triangles));
            for ((text, _), place) in marks.iter().zip(places) {
                let Some([x, y]) = place else { continue };
                let letters = Lettering::new(text, size_px);
                let room = width as f32 - letters.width() as f32;
                let left = (x - 0.5 * letters.width() as f32).min(room).max(0.0);
                // Letters are some 0.7 of their size high.
                letters.lay_with_halo(&mut picture, [left, y + 0.35 * size_px], size_px, 1.0);
            }
        }
        let png = picture.to_png()?;
        terminal.task().check()?;
        write_file(path, &png)
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

/// A shape and its parts.
pub struct Divided<'a> {
    pub name: &'a str,
    pub mesh: &'a TriMesh,
    /// Where each vertex belongs; `None` where nowhere.
    pub part: Vec<Option<usize>>,
    /// For each part the text that is laid on it, and its color (linear light).
    pub marks: Vec<(String, [f32; 4])>,
}

/// Vertices of a part at most that are tried for its text: each is a search through the mesh.
const TRIED: usize = 300;
/// The share of a part's vertices that must be seen for it to have text.
const LEAST_SEEN: f64 = 0.05;
/// Vertices of a part that are nearer to each other than this share of its size count as that far apart.
const NEAR: f32 = 0.02;

impl Divided<'_> {
    /// Vertices of each part that are on the surface, spread over it.
    fn samples(&self, positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<Vec<[f32; 3]>> {
        let mut is_used = vec![false; positions.len()];
        for vertex in triangles.iter().flatten() {
            if let Some(is_used) = is_used.get_mut(*vertex as usize) {
                *is_used = true;
            }
        }
        let mut samples = vec![Vec::new(); self.marks.len()];
        for ((position, part), is_used) in positions.iter().zip(&self.part).zip(is_used) {
            if let Some(samples) = part.filter(|_| is_used).and_then(|part| samples.get_mut(part)) {
                samples.push(*position);
            }
        }
        let thinned = |all: Vec<[f32; 3]>| {
            let step = all.len().div_ceil(TRIED).max(1);
            all.into_iter().step_by(step).collect()
        };
        samples.into_iter().map(thinned).collect()
    }
}

/// For each part the pixel of its text in a cell, if it has one there; `samples` are vertices of the parts.
fn places_of_text(
    samples: &[Vec<[f32; 3]>],
    (cell, camera): &(Rect, Camera),
    tree: &PickTree,
    (positions, triangles): (&[[f32; 3]], &[[u32; 3]]),
) -> Vec<Option<[f32; 2]>> {
    let eye = camera.eye().map(f64::from);
    let pixel_if_seen = |p: [f32; 3]| {
        let is_hidden = tree.blocks(eye, p.map(f64::from), positions, triangles);
        camera.project(p, *cell).filter(|_| !is_hidden).map(|(pixel, _)| pixel)
    };
    samples.iter().map(|samples| middle(samples, pixel_if_seen)).collect()
}

/// The pixel of the vertex that has most of those that are seen near it: in the middle of a part, or of one of two halves
/// that lie apart, as eyes do. `None` of a part that is hidden, or nearly so: its text would lie on others.
fn middle(samples: &[[f32; 3]], pixel_if_seen: impl Fn([f32; 3]) -> Option<[f32; 2]>) -> Option<[f32; 2]> {
    let seen: Vec<[f32; 2]> = samples.iter().filter_map(|p| pixel_if_seen(*p)).collect();
    if (seen.len() as f64) < LEAST_SEEN * samples.len() as f64 {
        return None;
    }
    let apart = |a: &[f32; 2], b: &[f32; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let first = seen.first()?;
    let size = seen.iter().map(|at| apart(at, first)).fold(1.0, f32::max);
    // Of a sum of logarithms, unlike one of distances, the least is not between two halves.
    let far = |at: &[f32; 2]| seen.iter().map(|other| (apart(at, other) + NEAR * size).ln()).sum::<f32>();
    let all = seen.iter().map(|at| (far(at), *at));
    all.min_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, at)| at)
}

/// Two cells for a shape: as `from` sees it, and from the opposite side, which shows all that is turned away there.
fn both_sides(from: Camera, positions: &[[f32; 3]], area: Rect) -> Vec<(Rect, Camera)> {
    let mut placed = framing::side_by_side(from, &[positions; 2], area, framing::FILL);
    if let [_, (cell, camera)] = placed.as_mut_slice() {
        camera.yaw_rad += PI;
        camera.pitch_rad = -camera.pitch_rad;
        camera.fit(positions.iter().copied(), cell.aspect(), framing::FILL);
    }
    placed
}

#[cfg(test)]
mod tests {
    use chladni_mesh::samples::icosphere;

    use super::*;

    #[test]
    fn the_text_of_two_halves_is_on_one_of_them() {
        let grid = (0..81).map(|i| [3.0 * ((i % 9) as f32 - 4.0), 3.0 * ((i / 9) as f32 - 4.0)]);
        let halves = grid.flat_map(|[x, y]| [[x - 25.0, y, 0.0], [x + 25.0, y, 0.0]]);
        let samples: Vec<[f32; 3]> = halves.collect();
        let [x, y] = middle(&samples, |[x, y, _]| Some([x, y])).unwrap();
        assert!((x.abs() - 25.0).abs() < 8.0 && y.abs() < 5.0, "{x} {y}");
        assert_eq!(middle(&[], |[x, y, _]| Some([x, y])), None);
    }

    #[test]
    fn the_text_of_a_part_is_where_it_is_seen() {
        let mesh = icosphere(3);
        let part_at = |p: &[f64; 3]| match p {
            [_, _, z] if *z < -0.7 => Some(2),
            [x, ..] => Some(usize::from(*x > 0.0)),
        };
        let part = mesh.positions.iter().map(part_at).collect();
        let marks = ["left", "right", "back"].map(|text| (text.to_owned(), [1.0; 4])).into();
        let shape = Divided { name: "ball", mesh: &mesh, part, marks };
        let (positions, triangles) = (single(&mesh.positions), drawn_triangles(&mesh));
        let samples = shape.samples(&positions, &triangles);
        let tree = PickTree::new(&positions, &triangles);
        let placed = both_sides(Camera::default(), &positions, Rect::of_size(400, 200));
        let [front, back] =
            [0, 1].map(|side| places_of_text(&samples, &placed[side], &tree, (&positions, &triangles)));
        let across = |at: &Option<[f32; 2]>| at.map(|[x, _]| x);
        assert!(across(&front[0]).is_some_and(|x| (30.0..90.0).contains(&x)), "{front:?}");
        assert!(across(&front[1]).is_some_and(|x| (110.0..170.0).contains(&x)), "{front:?}");
        assert_eq!(front[2], None);
        assert!(back[2].is_some_and(|[x, y]| (x - 300.0).hypot(y - 100.0) < 15.0), "{back:?}");
    }
}
