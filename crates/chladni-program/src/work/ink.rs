//! Shapes as drawings in ink: how the window and the page draw them live, and the files that they save.

use chladni_view::ink::{Drawing, Ink, Plate};
use chladni_view::{Camera, Rect, ViewError};

/// How much is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// Lines alone, in a fraction of the time: while something moves.
    Lines,
    /// All of it.
    Shade,
}

impl Depth {
    /// Draws a shape as `camera` sees it into `cell`.
    pub fn draw(self, drawing: &mut Drawing, plate: &Plate, ink: &Ink, camera: &Camera, cell: Rect) {
        match self {
            Self::Lines => drawing.strokes.extend(plate.outlines(ink, camera, cell)),
            Self::Shade => drawing.add(plate, ink, camera, cell),
        }
    }
}

/// How a drawing in ink is made: what the command's options say, and the window's panel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pen {
    /// Colors, and how much is drawn.
    pub ink: Ink,
    /// How far curvature is averaged before lines are drawn along it, as a share of the shape's size.
    pub smoothing: f64,
    /// Lines are the wider the farther the shape is exaggerated there.
    pub exaggeration: bool,
}

impl Default for Pen {
    fn default() -> Self {
        Self { ink: Ink::default(), smoothing: Plate::SMOOTHING, exaggeration: false }
    }
}

/// A shape to be drawn.
pub struct Inked<'a> {
    /// Its vertices.
    pub positions: &'a [[f32; 3]],
    /// How far each of them is exaggerated; empty where none is.
    pub moved: Vec<f64>,
}

impl<'a> Inked<'a> {
    /// A shape that was moved from `rest`.
    pub fn moved(positions: &'a [[f32; 3]], rest: impl Iterator<Item = [f64; 3]>) -> Self {
        let far = |(a, b): (&[f32; 3], [f64; 3])| {
            let [x, y, z] = std::array::from_fn(|i| f64::from(a[i]) - b[i]);
            f64::hypot(x, y).hypot(z)
        };
        Self { positions, moved: positions.iter().zip(rest).map(far).collect() }
    }
}

/// What moved less than this share of the largest coordinate was only rounded.
const ROUNDED: f64 = 1e-6;

impl Pen {
    /// The most detail that can be asked for.
    pub const MOST_DETAIL: f64 = 10.0;
    /// The most smoothing that can be asked for.
    pub const MOST_SMOOTHING: f64 = 0.1;

    /// With light as this many flat tones in place of hatching, or, with none, hatching again.
    pub fn toned(mut self, tones: usize) -> Self {
        match (self.ink.tones, tones) {
            (0, 0) => {}
            (0, _) => self.ink.hatching = 0.0,
            (_, 0) => self.ink.hatching = Ink::default().hatching,
            _ => {}
        }
        self.ink.tones = tones;
        self
    }

    /// Shapes with these triangles on one sheet, made ready to be drawn.
    ///
    /// # Errors
    /// As [`Plate::new`].
    pub fn plates(&self, shapes: &[Inked<'_>], triangles: &[[u32; 3]]) -> Result<Vec<Plate>, ViewError> {
        let farthest = shapes.iter().flat_map(|shape| &shape.moved).copied().fold(0.0, f64::max);
        let coordinates = shapes.iter().flat_map(|shape| shape.positions.as_flattened());
        let largest = f64::from(coordinates.fold(0.0, |largest: f32, c| largest.max(c.abs())));
        let is_moved = farthest > ROUNDED * largest;
        let plates = shapes.iter().map(|Inked { positions, moved }| {
            let exact: Vec<[f64; 3]> = positions.iter().map(|p| p.map(f64::from)).collect();
            let plate = Plate::new(&exact, triangles, self.smoothing)?;
            if !self.exaggeration || !is_moved {
                return Ok(plate);
            }
            let weight = |v: usize| (0.55 + 1.1 * moved.get(v).copied().unwrap_or(0.0) / farthest) as f32;
            plate.weighted((0..exact.len()).map(weight).collect())
        });
        plates.collect()
    }
}

/// The usual pen, with light as flat `tones` in place of hatching where they are wanted.
pub fn pen(tones: bool) -> Ink {
    Pen::default().toned(if tones { USUAL_TONES } else { 0 }).ink
}

/// How many flat tones there are where no number is given.
pub const USUAL_TONES: usize = 3;

/// A shape made ready to be drawn with the usual pen.
///
/// # Errors
/// As [`Plate::new`].
pub fn plate(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<Plate, ViewError> {
    let positions: Vec<[f64; 3]> = positions.iter().map(|p| p.map(f64::from)).collect();
    Plate::new(&positions, triangles, Plate::SMOOTHING)
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_mesh::surface::vec3::single;
    use chladni_view::View;

    #[test]
    fn flat_tones_take_the_place_of_hatching_and_give_it_back() {
        let usual = Pen::default();
        assert_eq!((pen(false), pen(true).tones, pen(true).hatching), (usual.ink, 3, 0.0));
        assert_eq!(usual.toned(2).toned(0), usual);
        let mut hatched = usual.toned(2);
        hatched.ink.hatching = 0.7;
        assert_eq!((hatched.toned(4).ink.hatching, hatched.toned(4).ink.tones), (0.7, 4));
    }

    #[test]
    fn lines_of_a_shape_that_is_only_rounded_keep_their_width() {
        let ball = chladni_mesh::samples::icosphere(2);
        // No f32 is a third.
        let rest: Vec<[f64; 3]> = ball.positions.iter().map(|p| p.map(|x| x / 3.0)).collect();
        let rounded = single(&rest);
        let strokes = |pen: Pen| {
            let shape = Inked::moved(&rounded, rest.iter().copied());
            assert!(shape.moved.iter().any(|moved| *moved > 0.0));
            let mut camera = Camera::looking(View::Front);
            camera.fit(rounded.iter().copied(), 1.0, 0.9);
            let plates = pen.plates(&[shape], &ball.triangles).unwrap();
            let strokes = plates[0].outlines(&pen.ink, &camera, Rect::of_size(200, 200));
            strokes.iter().flat_map(|s| &s.points).map(|p| p.width).collect::<Vec<f64>>()
        };
        let plain = strokes(Pen::default());
        assert!(!plain.is_empty());
        assert_eq!(strokes(Pen { exaggeration: true, ..Pen::default() }), plain);
    }

    #[test]
    fn lines_are_wider_where_it_moved_farther_by_one_measure_for_the_sheet() {
        let ball = chladni_mesh::samples::icosphere(3);
        let rest = single(&ball.positions);
        let large: Vec<[f32; 3]> = rest.iter().map(|p| p.map(|x| 1.5 * x)).collect();
        let from = |positions| Inked::moved(positions, ball.positions.iter().copied());
        // The widest line of each: a contour, whose width does not depend on the size of what it goes around.
        let widest = |pen: Pen| -> Vec<f64> {
            let plates = pen.plates(&[from(&rest), from(&large)], &ball.triangles).unwrap();
            let widths = plates.iter().map(|plate| {
                let mut camera = Camera::looking(View::Front);
                camera.fit(large.iter().copied(), 1.0, 0.9);
                let strokes = plate.outlines(&pen.ink, &camera, Rect::of_size(400, 400));
                strokes.iter().flat_map(|s| &s.points).map(|p| p.width).fold(0.0, f64::max)
            });
            widths.collect()
        };
        let plain = widest(Pen::default());
        let weighted = widest(Pen { exaggeration: true, ..Pen::default() });
        for (i, factor) in [(0, 0.55), (1, 1.65)] {
            assert!((weighted[i] / plain[i] - factor).abs() < 0.02, "{weighted:?} of {plain:?}");
        }
    }
}
