//! A line of text on a picture, in the letters of the window.

use std::sync::LazyLock;

use chladni_view::Picture;
use epaint::mutex::Mutex;
use epaint::text::{FontDefinitions, FontId, Fonts, LayoutJob, TextOptions, TextWrapping, ViewportKey};
use epaint::{Color32, ColorImage, FontColorTransferFunction};

use super::system_fonts::system_fonts;
use super::titles::{halo_offsets, halo_opacity};

/// Longer lines would leave any picture.
const LONGEST: usize = 300;
/// How opaque white letters get.
const WHITE: f32 = 220.0 / 255.0;
/// Pictures have room for large letters, and blend them by the share of each pixel that they cover.
const OPTIONS: TextOptions = TextOptions {
    max_texture_side: 8192,
    color_transfer_function: FontColorTransferFunction::Off,
    font_hinting: false,
    subpixel_binning: true,
};

/// The window's letters, and those of the system for scripts that these lack.
static FONTS: LazyLock<Mutex<Fonts>> = LazyLock::new(|| {
    let fonts = Fonts::new(OPTIONS, FontDefinitions::default());
    Mutex::new(fonts.with_font_providers(vec![system_fonts()]))
});

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
    /// `text` in letters of this size, in pixels. Characters that no font has become boxes.
    pub fn new(text: &str, size_px: f32) -> Self {
        Self::within(text, size_px, f32::INFINITY)
    }

    /// The same, at most so wide: a longer text ends in an ellipsis.
    pub fn within(text: &str, size_px: f32, width_px: f32) -> Self {
        let visible = |letter: char| if letter.is_control() { ' ' } else { letter };
        let text: String = text.chars().take(LONGEST).map(visible).collect();
        let wrap = TextWrapping::truncate_at_width(width_px.max(0.0));
        let line = LayoutJob::simple_singleline(text, FontId::proportional(size_px), Color32::WHITE);
        let job = LayoutJob { wrap, ..line };
        let mut fonts = FONTS.lock();
        fonts.begin_pass(OPTIONS, ViewportKey::default());
        let galley = fonts.with_pixels_per_point(1.0).layout_job(job);
        let row = galley.rows.first();
        let Some((row, first)) = row.and_then(|row| Some((row, row.row.glyphs.first()?))) else {
            return Self::default();
        };
        let [width, height] = [galley.size().x, galley.size().y].map(|length| length.ceil() as usize);
        let ascent = (row.pos.y + first.pos.y).round() as usize;
        let mut line = Self { width, height, covered: vec![0.0; width * height], ascent };
        let letters = fonts.texture_atlas().image();
        for glyph in &row.row.glyphs {
            let corner = (row.pos + glyph.pos.to_vec2() + glyph.uv_rect.offset).round();
            line.add(letters, (glyph.uv_rect.min, glyph.uv_rect.max), [corner.x as isize, corner.y as isize]);
        }
        line
    }

    /// Adds what is between two corners of `letters`; its own first corner is at `at`.
    fn add(&mut self, letters: &ColorImage, (min, max): ([u16; 2], [u16; 2]), at: [isize; 2]) {
        let [min, max] = [min, max].map(|corner| corner.map(usize::from));
        for (down, y) in (min[1]..max[1]).enumerate() {
            let Some(row) = at[1].checked_add_unsigned(down).and_then(|y| usize::try_from(y).ok()) else {
                continue;
            };
            let Some(pixels) = self.covered.get_mut(row * self.width..(row + 1) * self.width) else {
                continue;
            };
            for (across, x) in (min[0]..max[0]).enumerate() {
                let column = at[0].checked_add_unsigned(across).and_then(|x| usize::try_from(x).ok());
                if let Some(pixel) = column.and_then(|x| pixels.get_mut(x)) {
                    let covered = letters.pixels.get(y * letters.width() + x).map_or(0, |color| color.a());
                    *pixel = (*pixel + f32::from(covered) / 255.0).min(1.0);
                }
            }
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_stand_on_their_line_and_nothing_leaves_the_picture() {
        let line = Lettering::new("Hpé ?", 40.0);
        let row = |y: usize| line.covered[y * line.width..][..line.width].iter().sum::<f32>();
        // H stands on the line, p goes below.
        assert!(row(line.ascent - 1) > 1.5 * row(line.ascent + 4) && row(line.ascent + 4) > 0.5);
        let wide = Lettering::new("HHHH", 40.0).width;
        assert!(wide > 2 * Lettering::new("HH", 40.0).width - 3);
        // An accent of its own is the same letter, and controls are blanks.
        assert_eq!(Lettering::new("e\u{301}a", 40.0).width, Lettering::new("éa", 40.0).width);
        assert_eq!(Lettering::new("a\nb\t", 40.0), Lettering::new("a b ", 40.0));
        assert_eq!(Lettering::new("a\u{200b}b", 40.0).width, Lettering::new("ab", 40.0).width);
        let cut = Lettering::within("HHHHHHHHHH", 40.0, 150.0);
        assert!(cut.width <= 150 && cut.width > 100, "{}", cut.width);
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
