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

/// The usual pen, with light as flat `tones` in place of hatching where they are wanted.
pub fn pen(tones: bool) -> Ink {
    let usual = Ink::default();
    if tones { Ink { tones: 3, hatching: 0.0, ..usual } } else { usual }
}

/// A shape made ready to be drawn.
///
/// # Errors
/// As [`Plate::new`].
pub fn plate(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<Plate, ViewError> {
    let positions: Vec<[f64; 3]> = positions.iter().map(|p| p.map(f64::from)).collect();
    Plate::new(&positions, triangles, Plate::SMOOTHING)
}
