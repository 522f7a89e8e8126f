//! The titles of songs on the pictures of a film, as they appear on stage.

use std::path::Path;
use std::sync::Arc;

use chladni_music::{BeatReading, Stretch};
use chladni_sound::SongReader;
use chladni_view::Picture;

use crate::work::cover::cover_of;
use crate::work::formats::TUNE;
use crate::work::{Caption, title_opacity};

/// The songs' titles and when each is shown, in the time of the show; none where live input or nothing is heard.
#[derive(Debug, Default)]
pub struct Titles(Vec<(f64, Option<Caption>)>);

impl Titles {
    /// Titles of `songs`, by number, as they are heard in a film that begins at `start_secs`.
    pub fn of(songs: &[(String, BeatReading)], heard: &[Stretch], start_secs: f64) -> Self {
        // What begins when, no song included.
        let mut begun: Vec<(f64, Option<&str>)> = Vec::new();
        let mut last = None;
        for stretch in heard {
            let song = stretch.song.and_then(|number| Some((number, songs.get(number)?)));
            let number = song.map(|(number, _)| number);
            if number != last {
                begun.push((stretch.at_secs, song.map(|(_, (name, _))| name.as_str())));
            }
            last = number;
        }
        // A song that began before the film is named at the film's beginning.
        let before = begun.partition_point(|(at_secs, _)| *at_secs <= start_secs);
        let shown = begun.into_iter().skip(before.saturating_sub(1));
        let shown = shown.map(|(at_secs, name)| (at_secs.max(start_secs), name.map(caption_of)));
        Self(shown.collect())
    }

    /// Draws the title of this time of the show over a picture.
    pub fn lay(&mut self, at_secs: f64, picture: &mut Picture) {
        let begun = self.0.partition_point(|(begins_secs, _)| *begins_secs <= at_secs);
        if let Some((begins_secs, Some(caption))) = self.0.get_mut(begun.wrapping_sub(1)) {
            caption.lay(picture, title_opacity(at_secs - *begins_secs));
        }
    }
}

/// The title in a song's tags, else the name of its file, and its cover.
fn caption_of(song: &str) -> Caption {
    if song == TUNE {
        return Caption::new("sample tune".into(), None);
    }
    let path = Path::new(song);
    // The player that opens the song reports its errors.
    let mut reader = SongReader::open(path).ok();
    let cover = reader.as_mut().and_then(|reader| cover_of(path, reader));
    let stem = || path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let title = reader.and_then(|mut reader| reader.title()).unwrap_or_else(stem);
    Caption::new(title, cover.map(|cover| Arc::new(cover.picture)))
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
        let titles = |start_secs| Titles::of(&songs, &heard, start_secs).0;
        let named = |at_secs: f64, name: &str| (at_secs, Some(Caption::new(name.to_owned(), None)));
        let last = [named(9.0, "the second"), (20.0, None), named(25.0, "sample tune")];
        assert_eq!(titles(0.0), [&[named(0.0, "first")][..], &last].concat());
        assert_eq!(titles(5.0), [&[named(5.0, "first")][..], &last].concat());
        assert_eq!(titles(22.0), [(22.0, None), named(25.0, "sample tune")]);
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
    fn a_title_goes_at_once_where_live_input_begins() {
        let songs = [("first.wav".to_owned(), BeatReading::default())];
        let mut titles = Titles::of(&songs, &[stretch(0.0, Some(0)), stretch(2.0, None)], 0.0);
        let is_seen = [1.5, 2.5].map(|at_secs| {
            let mut picture = Picture::filled(320, 180, [0, 0, 0, 255]);
            titles.lay(at_secs, &mut picture);
            picture != Picture::filled(320, 180, [0, 0, 0, 255])
        });
        assert_eq!(is_seen, [true, false]);
    }
}
