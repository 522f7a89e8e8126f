//! Drawings in ink: contours, suggestive contours, ridges, valleys and hatching, as strokes on paper.
//!
//! A [`Plate`] is a shape prepared for drawing, [`Plate::strokes`] draws it from one side, and a [`Drawing`] holds
//! all strokes of a sheet, from which the picture and the SVG are made.

mod drawing;
mod hatching;
mod lines;
mod plate;
mod sight;
mod strokes;
mod tones;
mod turntable;

pub use drawing::Drawing;
pub use plate::Plate;
pub use tones::Area;
pub use turntable::film_turntable;

use crate::{Camera, Rect};
use sight::Sight;

/// How a drawing is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ink {
    /// Color of the paper, sRGB.
    pub paper: [u8; 3],
    /// Color of the ink, sRGB.
    pub color: [u8; 3],
    /// Width of a contour halfway into the shape, as a share of the shorter side of its cell, but at least a pixel;
    /// positive.
    pub pen: f64,
    /// How many lines there are inside the contours: 0 none, 1 as a draftsman would, 2 far more; at least 0.
    pub detail: f64,
    /// How far hatching reaches out of the shade: 0 draws none, 1 hatches all but what faces the light; in [0, 1].
    pub hatching: f64,
    /// How many flat tones light has, the paper among them: 2 to [`MOST_TONES`](Self::MOST_TONES), or 0 for none.
    pub tones: usize,
}

impl Ink {
    /// More tones would no longer look flat.
    pub const MOST_TONES: usize = 4;

    fn pen_px(&self, cell: Rect) -> f64 {
        (self.pen * f64::from(cell.width.min(cell.height))).max(1.0)
    }
}

impl Default for Ink {
    fn default() -> Self {
        Self {
            paper: [250, 247, 240],
            color: [28, 25, 23],
            pen: 0.0028,
            detail: 1.0,
            hatching: 0.5,
            tones: 0,
        }
    }
}

/// The feature that a stroke shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Mark {
    /// Where the surface turns away from the viewer, or ends.
    Contour,
    /// Where it would do so from a little to the side (DeCarlo et al. 2003).
    Suggestive,
    /// The bottom of a furrow.
    Valley,
    /// The top of an edge.
    Ridge,
    /// Shade.
    Hatching,
}

impl Mark {
    /// All of them, in the order in which they are drawn.
    pub const ALL: [Self; 5] = [Self::Contour, Self::Suggestive, Self::Valley, Self::Ridge, Self::Hatching];

    /// In one word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Contour => "contours",
            Self::Suggestive => "suggestive-contours",
            Self::Valley => "valleys",
            Self::Ridge => "ridges",
            Self::Hatching => "hatching",
        }
    }
}

/// A point of a [`Stroke`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrokePoint {
    /// Pixels, y downward.
    pub at: [f64; 2],
    /// Width of the stroke there, pixels.
    pub width: f64,
}

/// A visible line on paper, as a polyline within a tenth of a pixel of the smooth line that was traced.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// The feature that it shows.
    pub mark: Mark,
    /// Two points or more. A closed stroke ends where it begins.
    pub points: Vec<StrokePoint>,
}

impl Plate {
    /// The strokes of this shape seen by `camera` in `cell`. The same for any number of threads.
    pub fn strokes(&self, ink: &Ink, camera: &Camera, cell: Rect) -> Vec<Stroke> {
        let mut strokes = self.outlines(ink, camera, cell);
        strokes.extend(hatching::strokes(&Sight::new(self, camera, cell), ink));
        strokes
    }

    /// The flat tones of this shape seen by `camera` in `cell`, if `ink` has any: the lightest first, each on the one before.
    pub fn tones(&self, ink: &Ink, camera: &Camera, cell: Rect) -> Vec<Area> {
        tones::areas(&Sight::new(self, camera, cell), ink)
    }

    /// As [`strokes`](Self::strokes), without hatching, in a fraction of the time: while something moves.
    pub fn outlines(&self, ink: &Ink, camera: &Camera, cell: Rect) -> Vec<Stroke> {
        let sight = Sight::new(self, camera, cell);
        strokes::visible(&sight, ink, lines::lines(&sight, ink))
    }
}
