//! Pictures in ink: how they are asked for, and the file they become.

use std::path::Path;

use chladni_view::ink::{Drawing, Ink};
use chladni_view::{Camera, Rect};

use super::number::number;
use crate::work::formats::ends_in;
use crate::work::outputs::check_endings;
use crate::work::{Error, Inked, Pen, write_file};

/// How a drawing in ink is made. Each of these asks for one, and so does a picture that ends in .svg.
#[derive(clap::Args, Clone, Copy, Debug, Default)]
pub struct InkOptions {
    /// Draw in ink: contours, lines of the form, and hatching in the shade. A picture that ends in .svg always is.
    #[arg(long, requires = "picture")]
    ink: bool,
    /// How many lines there are inside the contours: 0 none, 1 as a draftsman would, 2 far more [default: 1].
    #[arg(long, value_name = "X", requires = "picture", value_parser = detail, allow_negative_numbers = true)]
    ink_detail: Option<f64>,
    /// How far hatching reaches out of the shade, 0 (none) to 1 (up to the light) [default: 0.5].
    #[arg(long, value_name = "X", requires = "picture", value_parser = share, allow_negative_numbers = true)]
    ink_hatching: Option<f64>,
    /// How far curvature is averaged before lines are drawn along it, as a share of the shape's size: more for a noisy
    /// scan, less for fine detail [default: 0.01].
    #[arg(long, value_name = "X", requires = "picture", value_parser = smoothing,
        allow_negative_numbers = true)]
    ink_smoothing: Option<f64>,
    /// Colors of the ink and the paper [default: #1c1917,#faf7f0].
    #[arg(long, value_name = "#RRGGBB,#RRGGBB", requires = "picture", value_parser = colors)]
    ink_colors: Option<[[u8; 3]; 2]>,
    /// Light as this many flat tones, 2 to 4, in place of hatching, which is drawn over them where --ink-hatching asks for it.
    #[arg(long, value_name = "N", requires = "picture", value_parser = clap::value_parser!(u8).range(2..=Ink::MOST_TONES as i64))]
    ink_tones: Option<u8>,
    /// Lines are the wider the farther the shape is exaggerated there.
    #[arg(long, requires = "picture")]
    ink_exaggeration: bool,
}

fn within(text: &str, high: f64) -> Result<f64, Error> {
    number(text, |x| (0.0..=high).contains(x), format_args!("a number from 0 to {high}"))
}

fn detail(text: &str) -> Result<f64, Error> {
    within(text, Pen::MOST_DETAIL)
}

fn share(text: &str) -> Result<f64, Error> {
    within(text, 1.0)
}

fn smoothing(text: &str) -> Result<f64, Error> {
    within(text, Pen::MOST_SMOOTHING)
}

fn colors(text: &str) -> Result<[[u8; 3]; 2], Error> {
    let color = |text: &str| {
        let digits = text.trim().strip_prefix('#').filter(|d| d.len() == 6 && d.is_ascii())?;
        let channel = |i: usize| u8::from_str_radix(digits.get(2 * i..2 * i + 2)?, 16).ok();
        Some([channel(0)?, channel(1)?, channel(2)?])
    };
    let parsed = text.split_once(',').and_then(|(ink, paper)| Some([color(ink)?, color(paper)?]));
    parsed.ok_or_else(|| Error::input("write two colors, ink and paper, such as #1c1917,#faf7f0"))
}

impl InkOptions {
    /// Whether the picture at `path` is one in ink.
    pub fn wanted(&self, path: &Path) -> bool {
        is_svg(path) || self.is_asked_for()
    }

    /// Whether pictures are drawn in ink whatever their names.
    pub fn is_asked_for(&self) -> bool {
        self.ink
            || self.ink_exaggeration
            || self.ink_colors.is_some()
            || self.ink_tones.is_some()
            || [self.ink_detail, self.ink_hatching, self.ink_smoothing].iter().any(Option::is_some)
    }

    /// Pen, colors and how much is drawn.
    pub fn pen(&self) -> Pen {
        let usual = Pen::default();
        let mut pen = usual.toned(self.ink_tones.map_or(0, usize::from));
        let ink = &mut pen.ink;
        [ink.color, ink.paper] = self.ink_colors.unwrap_or([ink.color, ink.paper]);
        ink.detail = self.ink_detail.unwrap_or(ink.detail);
        ink.hatching = self.ink_hatching.unwrap_or(ink.hatching);
        Pen {
            smoothing: self.ink_smoothing.unwrap_or(usual.smoothing),
            exaggeration: self.ink_exaggeration,
            ..pen
        }
    }

    /// Draws shapes with these triangles on one sheet, each in its place, and writes it: as SVG or PNG, by its name.
    pub fn write(
        &self,
        path: &Path,
        shapes: &[Inked<'_>],
        placed: &[(Rect, Camera)],
        triangles: &[[u32; 3]],
        [width, height]: [u32; 2],
    ) -> Result<(), Error> {
        let pen = self.pen();
        let mut drawing = Drawing::new(width, height, &pen.ink)?;
        for (plate, (cell, camera)) in pen.plates(shapes, triangles)?.iter().zip(placed) {
            drawing.add(plate, &pen.ink, camera, *cell);
        }
        let bytes =
            if is_svg(path) { drawing.to_svg().into_bytes() } else { drawing.to_picture().to_png()? };
        write_file(path, &bytes)
    }
}

fn is_svg(path: &Path) -> bool {
    ends_in(path, &["svg"])
}

/// Checks that a picture can be written at `path`, whose name must end in `.png` or `.svg`.
pub fn check_drawing(path: &Path) -> Result<(), Error> {
    check_endings(path, &["png", "svg"])
}
