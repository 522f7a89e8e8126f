//! The name and the cover of a song on a picture, as they appear on stage.

use std::sync::Arc;

use chladni_view::Picture;

use super::Lettering;
use super::titles::{COVER, GAP, TITLE};

/// The caption of a song.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Caption {
    /// Its title.
    pub text: String,
    /// Its cover.
    pub cover: Option<Arc<Picture>>,
    drawn: Option<Drawn>,
}

/// What is laid over a picture of some size.
#[derive(Clone, Debug, PartialEq)]
struct Drawn {
    size: [u32; 2],
    letters: Lettering,
    cover: Picture,
}

impl Caption {
    /// The caption of a song.
    pub fn new(text: String, cover: Option<Arc<Picture>>) -> Self {
        Self { text, cover, drawn: None }
    }

    /// Draws it over a picture, as opaque as this, in [0, 1].
    pub fn lay(&mut self, picture: &mut Picture, opacity: f32) {
        if opacity <= 0.0 {
            return;
        }
        let (width, height) = (picture.width, picture.height);
        let [size, left, bottom] = TITLE.map(|length| length * width.min(height) as f32 / 720.0);
        let beside =
            |cover: &Picture| left + if cover.width > 0 { cover.width as f32 + GAP * size } else { 0.0 };
        if self.drawn.as_ref().is_none_or(|drawn| drawn.size != [width, height]) {
            let cover =
                self.cover.as_ref().map(|cover| Picture::clone(cover).thumbnail((COVER * size) as u32));
            let cover = cover.unwrap_or_default();
            let room = width as f32 - left - beside(&cover);
            let letters = Lettering::within(&self.text, size, room);
            self.drawn = Some(Drawn { size: [width, height], letters, cover });
        }
        let Some(Drawn { letters, cover, .. }) = &self.drawn else { return };
        let foot = (height as f32 - bottom - 0.2 * size).max(0.0).floor();
        letters.lay_with_halo(picture, [beside(cover).floor(), foot], size, opacity);
        let top = (height as f32 - bottom) as u32;
        picture.blend(cover, left as u32, top.saturating_sub(cover.height), opacity);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_mesh::linear_from_srgb;

    #[test]
    fn a_cover_stands_on_the_line_before_the_title() {
        let cover = Arc::new(Picture::filled(200, 100, [0, 200, 0, 255]));
        let mut caption = Caption::new("Song".into(), Some(cover));
        let mut picture = Picture::filled(1280, 720, [0, 0, 0, 255]);
        caption.lay(&mut picture, 1.0);
        let green = |x, y| picture.pixel(x, y).is_some_and(|p| p[1] > 150 && p[0] == 0);
        assert!(green(32, 671) && green(32 + 64, 640) && !green(32, 672) && !green(31, 671));
        // It is as opaque as it is asked to be, unlike letters.
        assert!(picture.pixel(64, 660).is_some_and(|p| p[1] > 197));
        let letters = |x| (600..680).any(|y| picture.pixel(x, y).is_some_and(|p| p[0] > 100));
        assert!((0..100).all(|x| !letters(x)) && (100..220).any(letters));
        // A picture of another size has letters of another size.
        let mut small = Picture::filled(640, 360, [0, 0, 0, 255]);
        caption.lay(&mut small, 1.0);
        assert!(
            small.pixel(16, 335).is_some_and(|p| p[1] > 150)
                && small.pixel(16, 337).is_some_and(|p| p[1] == 0)
        );
        let before = small.clone();
        caption.lay(&mut small, 0.0);
        assert_eq!(small, before);
    }

    #[test]
    fn a_long_title_ends_within_a_narrow_picture() {
        let long = "The Rolling Stones – Sympathy for the Devil (Live at Hyde Park, London)";
        for [width, height] in [[720, 1280], [1280, 720], [360, 360]] {
            let mut picture = Picture::filled(width, height, [0, 0, 0, 255]);
            Caption::new(long.into(), None).lay(&mut picture, 1.0);
            let is_lit = |x: u32| (0..height).any(|y| picture.pixel(x, y).is_some_and(|p| p[0] > 60));
            let last = (0..width).rev().find(|x| is_lit(*x)).unwrap();
            let edge = width - 32 * width.min(height) / 720;
            assert!(last <= edge + 1 && last > width / 2, "{width}×{height}: {last}");
        }
    }

    #[test]
    fn letters_are_read_on_white() {
        let mut picture = Picture::filled(1440, 1440, [255; 4]);
        Caption::new("I".into(), None).lay(&mut picture, 1.0);
        // Across the letter, from its halo on one side to that on the other.
        let row: Vec<u8> = (0..300).filter_map(|x| Some(picture.pixel(x, 1320)?[0])).collect();
        let is_dark = |value: &u8| *value < 120;
        let (first, last) = (row.iter().position(is_dark).unwrap(), row.iter().rposition(is_dark).unwrap());
        let between = &row[first..=last];
        let light = |value: Option<&u8>| linear_from_srgb(f64::from(*value.unwrap()) / 255.0) + 0.05;
        let contrast = light(between.iter().max()) / light(between.iter().min());
        assert!(contrast > 4.5 && last - first < 30, "{contrast} {between:?}");
    }
}
