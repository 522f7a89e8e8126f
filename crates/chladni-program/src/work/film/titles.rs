//! The names of a film's songs, which appear on its pictures as they do on stage.

use std::path::Path;

use chladni_music::{BeatReading, Stretch};
use chladni_sound::SongReader;
use chladni_view::Picture;

use crate::work::Lettering;
use crate::work::source::TUNE;
use crate::work::titles::{TITLE, title_opacity};

/// How opaque letters get on the picture, as on stage.
const WHITE: f32 = 220.0 / 255.0;

/// What is read when.
#[derive(Debug, Default)]
pub struct Titles {
    /// When each begins, in the time of the show.
    shown: Vec<(f64, String)>,
    /// The one that was drawn last, and for which height.
    drawn: Option<(String, u32, Lettering)>,
}

impl Titles {
    /// Of `songs`, by number, as they are heard in a film that begins at `start_secs`.
    pub fn of(songs: &[(String, BeatReading)], heard: &[Stretch], start_secs: f64) -> Self {
        let mut shown: Vec<(f64, String)> = Vec::new();
        let mut last = None;
        for stretch in heard {
            let Some((number, (name, _))) = stretch.song.and_then(|n| Some((n, songs.get(n)?))) else {
                last = None;
                continue;
            };
            if last.replace(number) != Some(number) {
                shown.push((stretch.at_secs, name.clone()));
            }
        }
        // What began before the film is named as it begins.
        let before = shown.partition_point(|(at_secs, _)| *at_secs <= start_secs);
        let mut shown = shown.split_off(before.saturating_sub(1));
        for (at_secs, name) in &mut shown {
            (*at_secs, *name) = (at_secs.max(start_secs), title_of(name));
        }
        Self { shown, drawn: None }
    }

    /// Lays over a picture of the film what is read at this time of the show.
    pub fn lay(&mut self, at_secs: f64, picture: &mut Picture) {
        let begun = self.shown.partition_point(|(begins_secs, _)| *begins_secs <= at_secs);
        let Some((begins_secs, title)) = self.shown.get(begun.wrapping_sub(1)) else { return };
        let opacity = WHITE * title_opacity(at_secs - begins_secs);
        if opacity <= 0.0 {
            return;
        }
        let height = picture.height;
        let [size, left, bottom] = TITLE.map(|length| length * height as f32 / 720.0);
        let is_drawn = self.drawn.as_ref().is_some_and(|(of, high, _)| of == title && *high == height);
        if !is_drawn {
            self.drawn = Some((title.clone(), height, Lettering::new(title, size)));
        }
        if let Some((.., lettering)) = &self.drawn {
            let foot = (height as f32 - bottom - 0.2 * size).max(0.0);
            lettering.lay(picture, [left as usize, foot as usize], [255; 3], opacity);
        }
    }
}

/// The title in a song's tags, else the name of its file.
fn title_of(song: &str) -> String {
    if song == TUNE {
        return "sample tune".into();
    }
    let path = Path::new(song);
    // Whoever reads the song itself says what is wrong with it.
    let title = SongReader::open(path).ok().and_then(|mut reader| reader.title());
    let stem = || path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    title.unwrap_or_else(stem)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stretch(at_secs: f64, song: Option<usize>) -> Stretch {
        Stretch { at_secs, song, song_secs: 0.0, playing: true }
    }

    #[test]
    fn each_song_is_named_when_it_begins_and_never_again_for_a_leap() {
        let songs: Vec<(String, BeatReading)> =
            ["first.wav", "the second.wav", TUNE].map(|name| (name.into(), BeatReading::default())).into();
        let heard = [(0.0, Some(0)), (4.0, Some(0)), (9.0, Some(1)), (20.0, None), (25.0, Some(2))];
        let heard = heard.map(|(at_secs, song)| stretch(at_secs, song));
        let titles = |start_secs| Titles::of(&songs, &heard, start_secs).shown;
        let named = |at_secs: f64, name: &str| (at_secs, name.to_owned());
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
}
