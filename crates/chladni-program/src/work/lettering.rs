//! A line of text on a picture: outlines of a font, filled row by row.

use chladni_view::Picture;
use skrifa::instance::{LocationRef, Size};
use skrifa::outline::{DrawSettings, OutlinePen};
use skrifa::{FontRef, MetadataProvider};

use super::titles::{halo_offsets, halo_opacity};

/// The letters of the window.
const FONT: &[u8] = epaint_default_fonts::UBUNTU_LIGHT;
/// Rows in a row of pixels.
const FINER: usize = 4;
/// Lines for a curve.
const PIECES: u16 = 8;
/// Longer lines would leave any picture.
const LONGEST: usize = 300;
/// How opaque white letters get.
const WHITE: f32 = 220.0 / 255.0;

/// A line of text, as how much of each pixel it covers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lettering {
    width: usize,
    height: usize,
    covered: Vec<f32>,
    /// Rows above the line that letters stand on.
    ascent: usize,
}

impl Lettering {
    /// `text` in letters of this size, in pixels; empty if the font cannot be read. Characters that the font
    /// lacks become question marks.
    pub fn new(text: &str, size_px: f32) -> Self {
        let Ok(font) = FontRef::new(FONT) else { return Self::default() };
        let (size, place) = (Size::new(size_px), LocationRef::default());
        let (letters, outlines) = (font.charmap(), font.outline_glyphs());
        let (advances, line) = (font.glyph_metrics(size, place), font.metrics(size, place));
        let ascent = line.ascent.max(0.0).ceil();
        let mut pen = Pen { at: [0.0, ascent], ..Pen::default() };
        for letter in text.chars().take(LONGEST) {
            let Some(glyph) = letters.map(letter).or_else(|| letters.map('?')) else { continue };
            if let Some(outline) = outlines.get(glyph) {
                // A letter that the font cannot draw leaves a gap.
                drop(outline.draw(DrawSettings::unhinted(size, place), &mut pen));
            }
            pen.at[0] += advances.advance_width(glyph).unwrap_or(0.0);
        }
        let width = pen.at[0].max(0.0).ceil() as usize;
        let height = ascent as usize + (-line.descent).max(0.0).ceil() as usize;
        Self { width, height, covered: filled(&pen.edges, width, height), ascent: ascent as usize }
    }

    /// How many pixels wide it is.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Draws it over a picture in white with a dark halo, which is read on any ground, at an opacity. Its letters are of
    /// `size_px`, and it begins and stands at `place`.
    pub fn lay_with_halo(&self, picture: &mut Picture, place: [f32; 2], size_px: f32, opacity: f32) {
        for offset in halo_offsets(size_px) {
            let [x, y] = [0, 1].map(|axis| (place[axis] + offset[axis]).max(0.0).round() as usize);
            self.lay(picture, [x, y], [0; 3], halo_opacity(opacity));
        }
        self.lay(picture, place.map(|length| length as usize), [255; 3], WHITE * opacity);
    }

    /// Draws it over a picture in a color (sRGB) and an opacity, beginning at `left` and standing on row
    /// `foot`.
    pub fn lay(&self, picture: &mut Picture, [left, foot]: [usize; 2], color: [u8; 3], opacity: f32) {
        let (across, down) = (picture.width as usize, picture.height as usize);
        for (row, covered) in self.covered.chunks_exact(self.width.max(1)).enumerate() {
            let Some(y) = (foot + row).checked_sub(self.ascent).filter(|y| *y < down) else { continue };
            let Some(pixels) = picture.rgba.get_mut(4 * y * across..4 * (y + 1) * across) else { continue };
            let pixels = pixels.as_chunks_mut::<4>().0.iter_mut().skip(left);
            for (pixel, covered) in pixels.zip(covered) {
                // Porter & Duff's "over" on straight alpha.
                let share = opacity * covered;
                let below = f32::from(pixel[3]) / 255.0 * (1.0 - share);
                let alpha = share + below;
                if alpha > 0.0 {
                    for (channel, c) in pixel.iter_mut().zip(color) {
                        *channel = ((f32::from(*channel) * below + f32::from(c) * share) / alpha + 0.5) as u8;
                    }
                    pixel[3] = (255.0 * alpha + 0.5) as u8;
                }
            }
        }
    }
}

/// Draws outlines as edges, y down, from a place on the line.
#[derive(Default)]
struct Pen {
    at: [f32; 2],
    first: [f32; 2],
    last: [f32; 2],
    edges: Vec<[[f32; 2]; 2]>,
}

impl Pen {
    fn place(&self, x: f32, y: f32) -> [f32; 2] {
        [self.at[0] + x, self.at[1] - y]
    }

    fn go(&mut self, to: [f32; 2]) {
        self.edges.push([self.last, to]);
        self.last = to;
    }

    /// Along a curve in [0, 1].
    fn bend(&mut self, curve: impl Fn(f32) -> [f32; 2]) {
        (1..=PIECES).for_each(|i| self.go(curve(f32::from(i) / f32::from(PIECES))));
    }
}

fn between(a: [f32; 2], b: [f32; 2], share: f32) -> [f32; 2] {
    [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]
}

impl OutlinePen for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        self.first = self.place(x, y);
        self.last = self.first;
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.go(self.place(x, y));
    }

    fn quad_to(&mut self, cx: f32, cy: f32, x: f32, y: f32) {
        let (a, b, c) = (self.last, self.place(cx, cy), self.place(x, y));
        self.bend(|t| between(between(a, b, t), between(b, c, t), t));
    }

    fn curve_to(&mut self, cx0: f32, cy0: f32, cx1: f32, cy1: f32, x: f32, y: f32) {
        let (a, b, c, d) = (self.last, self.place(cx0, cy0), self.place(cx1, cy1), self.place(x, y));
        let quad = |a, b, c, t| between(between(a, b, t), between(b, c, t), t);
        self.bend(|t| between(quad(a, b, c, t), quad(b, c, d, t), t));
    }

    fn close(&mut self) {
        self.go(self.first);
    }
}

/// The share of each pixel within the edges: exact along rows, four of which sample each pixel.
fn filled(edges: &[[[f32; 2]; 2]], width: usize, height: usize) -> Vec<f32> {
    let mut covered = vec![0.0; width * height];
    let mut crossings: Vec<(f32, i32)> = Vec::new();
    for row in 0..FINER * height {
        let y = (row as f32 + 0.5) / FINER as f32;
        crossings.clear();
        crossings.extend(edges.iter().filter(|[a, b]| (a[1] <= y) != (b[1] <= y)).map(|[a, b]| {
            let x = a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
            (x, if b[1] > a[1] { 1 } else { -1 })
        }));
        crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
        let pixels = &mut covered[row / FINER * width..][..width];
        let mut winding = 0;
        for pair in crossings.windows(2) {
            winding += pair[0].1;
            if winding != 0 {
                let (from, to) = (pair[0].0.max(0.0), pair[1].0.min(width as f32));
                for (x, pixel) in pixels.iter_mut().enumerate().take(to.ceil() as usize).skip(from as usize) {
                    let part = (to.min(x as f32 + 1.0) - from.max(x as f32)).max(0.0);
                    *pixel += part / FINER as f32;
                }
            }
        }
    }
    covered
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_are_filled_to_their_area_and_holes_are_left() {
        let ring = |corners: [[f32; 2]; 4]| (0..4).map(move |i| [corners[i], corners[(i + 1) % 4]]);
        let square = ring([[1.25, 1.0], [6.0, 1.0], [6.0, 5.5], [1.25, 5.5]]);
        let hole = ring([[2.0, 2.0], [2.0, 4.0], [3.0, 4.0], [3.0, 2.0]]);
        let edges: Vec<_> = square.chain(hole).collect();
        let covered = filled(&edges, 8, 7);
        let area: f32 = covered.iter().sum();
        assert!((area - (4.75 * 4.5 - 2.0)).abs() < 1e-3, "{area}");
        assert!((covered[8 + 1] - 0.75).abs() < 1e-3 && covered[2 * 8 + 2] < 1e-3 && covered[0] == 0.0);
        assert!(covered.iter().all(|c| (0.0..1.001).contains(c)));
    }

    #[test]
    fn letters_stand_on_their_line_and_nothing_leaves_the_picture() {
        let line = Lettering::new("Hpé ?", 40.0);
        let row = |y: usize| line.covered[y * line.width..][..line.width].iter().sum::<f32>();
        // H stands on the line, p goes below.
        assert!(row(line.ascent - 1) > 1.5 * row(line.ascent + 4) && row(line.ascent + 4) > 0.5);
        let wide = Lettering::new("HHHH", 40.0).width;
        assert!(wide > 2 * Lettering::new("HH", 40.0).width - 3);
        assert_eq!(Lettering::new("\u{4e00}", 40.0), Lettering::new("?", 40.0));
        let mut picture = Picture::filled(30, 20, [0, 0, 0, 255]);
        line.lay(&mut picture, [25, 18], [255; 3], 1.0);
        line.lay(&mut picture, [200, 900], [255; 3], 1.0);
        Lettering::new("", 40.0).lay(&mut picture, [0, 0], [255; 3], 1.0);
        assert!(picture.rgba.chunks(4).any(|p| p[0] > 200) && picture.rgba.chunks(4).any(|p| p[0] == 0));
        // On nothing, letters keep their color up to their edges.
        let mut nothing = Picture::filled(30, 20, [0; 4]);
        line.lay(&mut nothing, [2, 18], [255; 3], 0.5);
        let mut drawn = nothing.rgba.chunks(4).filter(|p| p[3] > 0).peekable();
        assert!(drawn.peek().is_some() && drawn.all(|p| p[..3] == [255; 3] && p[3] <= 129));
    }
}
