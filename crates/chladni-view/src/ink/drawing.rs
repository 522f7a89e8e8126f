//! All strokes of a sheet of paper, and the files it becomes.

use std::fmt::Write;

use super::tones::{self, Area};
use super::{Ink, Mark, Plate, Stroke, StrokePoint};
use crate::{Camera, Picture, Rect, ViewError};

/// A sheet of paper with strokes in ink.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Color of the paper, sRGB.
    pub paper: [u8; 3],
    /// Color of the ink, sRGB.
    pub ink: [u8; 3],
    /// Below the strokes, in the order in which they are laid.
    pub areas: Vec<Area>,
    /// In pixels from the upper left corner.
    pub strokes: Vec<Stroke>,
}

impl Drawing {
    /// Pixels of the longest side.
    const LIMIT: u32 = 16_384;

    /// An empty sheet of the paper and for the ink of `ink`.
    ///
    /// # Errors
    /// [`ViewError::Size`] without pixels or with a side longer than 16,384.
    pub fn new(width: u32, height: u32, ink: &Ink) -> Result<Self, ViewError> {
        if width == 0 || height == 0 || width.max(height) > Self::LIMIT {
            return Err(ViewError::Size { width, height, limit: Self::LIMIT });
        }
        let (areas, strokes) = (Vec::new(), Vec::new());
        Ok(Self { width, height, paper: ink.paper, ink: ink.color, areas, strokes })
    }

    /// Draws a shape as `camera` sees it into `cell`: tones, lines and hatching.
    pub fn add(&mut self, plate: &Plate, ink: &Ink, camera: &Camera, cell: Rect) {
        self.areas.extend(plate.tones(ink, camera, cell));
        self.strokes.extend(plate.strokes(ink, camera, cell));
    }

    /// Paper with so much ink in it.
    fn mixed(&self, share: f64) -> [f32; 3] {
        std::array::from_fn(|i| {
            let (paper, ink) = (f32::from(self.paper[i]), f32::from(self.ink[i]));
            paper + (ink - paper) * share as f32
        })
    }

    /// As SVG 1.1: the paper, and above it a group for each kind of stroke, each stroke one filled outline.
    pub fn to_svg(&self) -> String {
        let (w, h) = (self.width, self.height);
        let hex = |[r, g, b]: [u8; 3]| format!("#{r:02x}{g:02x}{b:02x}");
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\">\n\
             <rect id=\"paper\" width=\"{w}\" height=\"{h}\" fill=\"{}\"/>\n",
            hex(self.paper)
        );
        if !self.areas.is_empty() {
            svg.push_str("<g id=\"tones\">\n");
            for area in &self.areas {
                let color = hex(self.mixed(area.shade).map(|c| c.round() as u8));
                let _ = write!(svg, "<path fill=\"{color}\" fill-rule=\"evenodd\" d=\"");
                for ring in &area.rings {
                    for (i, [x, y]) in ring.iter().enumerate() {
                        let _ = write!(svg, "{}{x:.2} {y:.2}", if i > 0 { "L" } else { "M" });
                    }
                    svg.push('Z');
                }
                svg.push_str("\"/>\n");
            }
            svg.push_str("</g>\n");
        }
        for mark in Mark::ALL {
            let _ = writeln!(svg, "<g id=\"{}\" fill=\"{}\">", mark.name(), hex(self.ink));
            for stroke in self.strokes.iter().filter(|stroke| stroke.mark == mark) {
                svg.push_str("<path d=\"");
                for (i, outline) in outlines(&stroke.points).into_iter().enumerate() {
                    for (j, [x, y]) in outline.into_iter().enumerate() {
                        let lead = if j > 0 {
                            "L"
                        } else if i > 0 {
                            "ZM"
                        } else {
                            "M"
                        };
                        let _ = write!(svg, "{lead}{x:.2} {y:.2}");
                    }
                }
                svg.push_str("Z\"/>\n");
            }
            svg.push_str("</g>\n");
        }
        svg.push_str("</svg>\n");
        svg
    }

    /// As pixels. How far each is covered with ink is measured across each stroke, exactly where it is straight.
    pub fn to_picture(&self) -> Picture {
        let mut pixels = vec![self.mixed(0.0); self.width as usize * self.height as usize];
        let areas: Vec<_> = self.areas.iter().map(|area| (area, self.mixed(area.shade))).collect();
        tones::fill(&mut pixels, self.width as usize, &areas);
        let inked = |(below, cover): ([f32; 3], f32)| {
            let channel = |i: usize| (below[i] + (f32::from(self.ink[i]) - below[i]) * cover).round() as u8;
            [channel(0), channel(1), channel(2), 255]
        };
        let rgba = pixels.into_iter().zip(self.cover()).flat_map(inked).collect();
        Picture { width: self.width, height: self.height, rgba }
    }

    /// The share of each pixel that is ink, rows from the top.
    fn cover(&self) -> Vec<f32> {
        let (w, h) = (self.width as usize, self.height as usize);
        let mut cover = vec![0.0_f32; w * h];
        let pieces = self.strokes.iter().flat_map(|stroke| stroke.points.windows(2));
        for piece in pieces {
            let [a, b] = [piece[0], piece[1]];
            let reach = 0.5 * a.width.max(b.width) + 1.0;
            let span = |i: usize, length: usize| {
                let low = (a.at[i].min(b.at[i]) - reach).floor().clamp(0.0, length as f64) as usize;
                let high = (a.at[i].max(b.at[i]) + reach).ceil().clamp(0.0, length as f64) as usize;
                low..high
            };
            for y in span(1, h) {
                for x in span(0, w) {
                    let inside = covered([x as f64 + 0.5, y as f64 + 0.5], &a, &b);
                    let pixel = &mut cover[y * w + x];
                    *pixel = pixel.max(inside as f32);
                }
            }
        }
        cover
    }
}

/// The share of a pixel, centered at `p`, that the piece from `a` to `b` covers, as if it were straight and endless
/// there.
fn covered(p: [f64; 2], a: &StrokePoint, b: &StrokePoint) -> f64 {
    let d = [b.at[0] - a.at[0], b.at[1] - a.at[1]];
    let e = [p[0] - a.at[0], p[1] - a.at[1]];
    let squared = d[0] * d[0] + d[1] * d[1];
    let t = if squared > 0.0 { ((d[0] * e[0] + d[1] * e[1]) / squared).clamp(0.0, 1.0) } else { 0.0 };
    let far = (e[0] - t * d[0]).hypot(e[1] - t * d[1]);
    let half = 0.5 * (a.width + t * (b.width - a.width));
    ((far + 0.5).min(half) - (far - 0.5).max(-half)).clamp(0.0, 1.0)
}

/// The outline of a stroke: once around, or, where it is closed, the outside and the inside.
fn outlines(points: &[StrokePoint]) -> Vec<Vec<[f64; 2]>> {
    let n = points.len();
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return Vec::new() };
    let is_closed = n > 3 && first.at == last.at;
    let across = |i: usize| {
        let (before, after) = match (i == 0 || i + 1 == n, is_closed) {
            (true, true) => (n - 2, 1),
            _ => (i.saturating_sub(1), (i + 1).min(n - 1)),
        };
        let (a, b) = (points[before].at, points[after].at);
        let (x, y) = (b[0] - a[0], b[1] - a[1]);
        let half = 0.5 * points[i].width / x.hypot(y).max(1e-12);
        [-y * half, x * half]
    };
    let beside = |i: usize, side: f64| {
        let [x, y] = across(i);
        [points[i].at[0] + side * x, points[i].at[1] + side * y]
    };
    let left: Vec<[f64; 2]> = (0..n).map(|i| beside(i, 1.0)).collect();
    let right: Vec<[f64; 2]> = (0..n).rev().map(|i| beside(i, -1.0)).collect();
    if is_closed { vec![left, right] } else { vec![[left, right].concat()] }
}
