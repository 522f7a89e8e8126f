//! The titles of songs on the pictures of a film, as they appear on stage.

use std::path::Path;

use chladni_music::{BeatReading, Stretch};
use chladni_sound::SongReader;
use chladni_view::Picture;

use crate::work::Lettering;
use crate::work::cover::cover_of;
use crate::work::source::TUNE;
use crate::work::titles::{COVER, GAP, TITLE, title_opacity};

/// How opaque letters get on the picture, as on stage.
const WHITE: f32 = 220.0 / 255.0;

/// The songs' titles and when each is shown.
#[derive(Debug, Default)]
pub struct Titles {
    /// When each begins, in the time of the show.
    shown: Vec<(f64, Title)>,
    /// The number of the one that was drawn last, and for which height.
    drawn: Option<(usize, u32, Lettering, Picture)>,
}

/// The caption of a song.
#[derive(Clone, Debug, PartialEq)]
struct Title {
    text: String,
    cover: Option<Picture>,
}

impl Titles {
    /// Titles of `songs`, by number, as they are heard in a film that begins at `start_secs`.
    pub fn of(songs: &[(String, BeatReading)], heard: &[Stretch], start_secs: f64) -> Self {
        let mut shown: Vec<(f64, &str)> = Vec::new();
        let mut last = None;
        for stretch in heard {
            let Some((number, (name, _))) = stretch.song.and_then(|n| Some((n, songs.get(n)?))) else {
                last = None;
                continue;
            };
            if last.replace(number) != Some(number) {
                shown.push((stretch.at_secs, name.as_str()));
            }
        }
        // A song that began before the film is named at the film's beginning.
        let before = shown.partition_point(|(at_secs, _)| *at_secs <= start_secs);
        let shown = shown.into_iter().skip(before.saturating_sub(1));
        let shown = shown.map(|(at_secs, name)| (at_secs.max(start_secs), Title::of(name))).collect();
        Self { shown, drawn: None }
    }

    /// Draws the title of this time of the show over a picture.
    pub fn lay(&mut self, at_secs: f64, picture: &mut Picture) {
        let begun = self.shown.partition_point(|(begins_secs, _)| *begins_secs <= at_secs);
        let number = begun.wrapping_sub(1);
        let Some((begins_secs, title)) = self.shown.get(number) else { return };
        let opacity = WHITE * title_opacity(at_secs - begins_secs);
        if opacity <= 0.0 {
            return;
        }
        let height = picture.height;
        let [size, left, bottom] = TITLE.map(|length| length * height as f32 / 720.0);
        let is_drawn = self
            .drawn
            .as_ref()
            .is_some_and(|(of, high, ..)| [*of, *high as usize] == [number, height as usize]);
        if !is_drawn {
            let cover = title.cover.clone().unwrap_or_default().thumbnail((COVER * size) as u32);
            self.drawn = Some((number, height, Lettering::new(&title.text, size), cover));
        }
        if let Some((.., lettering, cover)) = &self.drawn {
            let foot = (height as f32 - bottom - 0.2 * size).max(0.0);
            let beside = if cover.width > 0 { cover.width as f32 + GAP * size } else { 0.0 };
            lettering.lay(picture, [(left + beside) as usize, foot as usize], [255; 3], opacity);
            let top = (height as f32 - bottom) as u32;
            let mut cover = cover.clone();
            cover
                .rgba
                .iter_mut()
                .skip(3)
                .step_by(4)
                .for_each(|alpha| *alpha = (f32::from(*alpha) * opacity) as u8);
            picture.paste(&cover, left as u32, top.saturating_sub(cover.height));
        }
    }
}

impl Title {
    /// The title in a song's tags, else the name of its file, and its cover.
    fn of(song: &str) -> Self {
        if song == TUNE {
            return Self { text: "sample tune".into(), cover: None };
        }
        let path = Path::new(song);
        // The player that opens the song reports its errors.
        let mut reader = SongReader::open(path).ok();
        let cover = reader.as_mut().and_then(|reader| cover_of(path, reader)).map(|cover| cover.picture);
        let stem = || path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        Self { text: reader.and_then(|mut reader| reader.title()).unwrap_or_else(stem), cover }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stretch(at_secs: f64, song: Option<usize>) -> Stretch {
        Stretch { at_secs, song, song_secs: 0.0, playing: true, crossfade_secs: 0.0 }
    }

    #[test]
    fn each_song_is_named_when_it_begins_and_never_again_for_a_leap() {
        let songs: Vec<(String, BeatReading)> =
            ["first.wav", "the second.wav", TUNE].map(|name| (name.into(), BeatReading::default())).into();
        let heard = [(0.0, Some(0)), (4.0, Some(0)), (9.0, Some(1)), (20.0, None), (25.0, Some(2))];
        let heard = heard.map(|(at_secs, song)| stretch(at_secs, song));
        let titles = |start_secs| Titles::of(&songs, &heard, start_secs).shown;
        let named = |at_secs: f64, name: &str| (at_secs, Title { text: name.to_owned(), cover: None });
        let last = [named(9.0, "the second"), named(25.0, "sample tune")];
        assert_eq!(titles(0.0), [&[named(0.0, "first")][..], &last].concat());
        assert_eq!(titles(5.0), [&[named(5.0, "first")][..], &last].concat());
        assert_eq!(titles(30.0), [named(30.0, "sample tune")]);
        let mut titles = Titles::of(&songs, &heard, 0.0);
        let mut light = |at_secs: f64| {
            let mut picture = Picture::filled(320, 180, [0, 0, 0, 255]);
            titles.lay(at_secs, &mut picture);
            picture.rgba.chunks(4).map(|p| u32::from(p[0])).sum::<u32>()
        };
        assert_eq!([light(0.0), light(7.5), light(21.0)], [0; 3]);
        assert!(light(0.5) > 1000 && light(3.0) > light(0.5) && light(12.0) > light(3.0));
    }

    #[test]
    fn a_cover_stands_on_the_line_before_the_title() {
        let cover = Picture::filled(200, 100, [0, 200, 0, 255]);
        let title = Title { text: "Song".into(), cover: Some(cover) };
        let mut titles = Titles { shown: vec![(0.0, title)], drawn: None };
        let mut picture = Picture::filled(1280, 720, [0, 0, 0, 255]);
        titles.lay(3.0, &mut picture);
        let green = |x, y| picture.pixel(x, y).is_some_and(|p| p[1] > 150 && p[0] == 0);
        assert!(green(32, 671) && green(32 + 64, 640) && !green(32, 672) && !green(31, 671));
        let letters = |x| (600..680).any(|y| picture.pixel(x, y).is_some_and(|p| p[0] > 100));
        assert!((0..100).all(|x| !letters(x)) && (100..220).any(letters));
    }
}
