//! The show file: the shape, the songs, the viewpoint and all actions. The window, films and the command read
//! and write this one file.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::gallery::GalleryShape;
use crate::text_file::{self, FORMAT_VERSION};
use crate::{ClockTrack, Instrument, LoggedAction, MusicError, Parameters, Settings};

/// An external file that a show needs.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileRef {
    /// A path, or `sample:NAME`. A relative one starts from the show's own folder.
    pub path: String,
    /// The file's BLAKE3 hash when the show was saved, in hexadecimal digits; `None` for a sample.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blake3: Option<String>,
}

/// A song of a show: its file, and how its beats were corrected by hand.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SongRef {
    /// As a [`FileRef`] has it.
    pub path: String,
    /// As a [`FileRef`] has it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blake3: Option<String>,
    /// How its beats are to be read.
    #[serde(default)]
    pub reading: BeatReading,
}

impl SongRef {
    /// A song in a file, its beats as they are found.
    pub fn of(FileRef { path, blake3 }: FileRef) -> Self {
        Self { path, blake3, reading: BeatReading::default() }
    }

    /// Its file.
    pub fn file(&self) -> FileRef {
        FileRef { path: self.path.clone(), blake3: self.blake3.clone() }
    }
}

/// Corrections of a song's detected beats by the user.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BeatReading {
    /// How often their tempo is doubled; below 0 it is halved.
    #[serde(default)]
    pub octave: i32,
    /// How much later they are.
    #[serde(default)]
    pub shift_secs: f64,
}

impl BeatReading {
    /// The corrected beats (ascending).
    pub fn of(self, beats_secs: &[f64]) -> Vec<f64> {
        let mut read = beats_secs.to_vec();
        for _ in 0..self.octave.clamp(0, MOST_OCTAVES) {
            let between = read.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
            let mut both: Vec<f64> = read.iter().copied().chain(between).collect();
            both.sort_by(f64::total_cmp);
            read = both;
        }
        for _ in 0..(-self.octave).clamp(0, MOST_OCTAVES) {
            read = read.into_iter().step_by(2).collect();
        }
        read.iter_mut().for_each(|beat| *beat += self.shift_secs);
        read
    }
}

/// A tempo is doubled or halved at most this often.
const MOST_OCTAVES: i32 = 3;

/// From `at_secs` of the show on, a song plays from `song_secs`, or is paused there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stretch {
    /// Since the show began.
    pub at_secs: f64,
    /// Which of the show's songs; `None` is live input, which is not recorded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub song: Option<usize>,
    /// Where in the song.
    #[serde(default)]
    pub song_secs: f64,
    /// False: it is paused.
    pub playing: bool,
    /// How long what was heard before fades into this, from half of it before `at_secs` to half after it.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub crossfade_secs: f64,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks for it")]
fn is_zero(secs: &f64) -> bool {
    *secs == 0.0
}

impl Stretch {
    /// The song's time at `at_secs` of the show, within this stretch.
    pub fn song_secs_at(&self, at_secs: f64) -> f64 {
        if self.playing { self.song_secs + (at_secs - self.at_secs) } else { self.song_secs }
    }
}

/// What a dance looks like, by names: a whole scene, and what takes the place of its parts. Empty names are the
/// scene's own parts, and the plain scene.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Looks {
    /// The whole scene.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub look: String,
    /// What colors the movement.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub palette: String,
    /// Of the shapes.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub material: String,
    /// On them.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub lights: String,
    /// Behind them.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub background: String,
    /// The file of a picture that stands behind them.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub picture: String,
    /// The file of a panorama that shines on them.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub panorama: String,
    /// How soft is what is not in focus, percent of the most; the scene's own where there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub blur_percent: Option<u8>,
}

/// The viewpoint, before the beat turns the shape. The default shows the whole shape.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Viewpoint {
    /// About the vertical; positive moves the viewer to the right.
    pub yaw_rad: f32,
    /// Above the horizon.
    pub pitch_rad: f32,
    /// The distance, in multiples of the smallest one that shows the whole shape.
    pub distance: f32,
    /// How far the picture is shifted to the right and downward, in heights of a cell.
    pub shift: [f32; 2],
}

impl Default for Viewpoint {
    fn default() -> Self {
        Self { yaw_rad: 0.0, pitch_rad: 0.14, distance: 1.0, shift: [0.0; 2] }
    }
}

/// What was played and all actions, so that the show can be continued or filmed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Show {
    /// 2.
    pub format_version: u32,
    /// K of the body; `None` in older files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub harmonics: Option<usize>,
    /// The seed of the gallery.
    pub seed: u64,
    /// S.
    pub size: usize,
    /// How long it lasts; `None` is as long as its song.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub duration_secs: Option<f64>,
    /// Who dances: a mesh, or a caricature whose layers are voices.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub body: Option<FileRef>,
    /// What the shapes look like.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub looks: Option<Looks>,
    /// Where the viewer stands.
    #[serde(default)]
    pub viewpoint: Viewpoint,
    /// Where the knobs stood in the beginning.
    #[serde(default)]
    pub beginning: Settings,
    /// What was heard.
    #[serde(default)]
    pub songs: Vec<SongRef>,
    /// When each was heard, in order; if empty, the first song from its beginning.
    #[serde(default)]
    pub heard: Vec<Stretch>,
    /// The beat of an outer clock, where one was followed.
    #[serde(default, skip_serializing_if = "ClockTrack::is_empty")]
    pub clock: ClockTrack,
    /// All that was done, oldest first.
    #[serde(default)]
    pub actions: Vec<LoggedAction>,
    /// The version of the file that this was read from.
    #[serde(skip)]
    pub read_from_version: u32,
}

/// A session, as version 1 called it.
#[derive(Deserialize)]
struct Session {
    #[serde(default)]
    song: String,
    seed: u64,
    size: usize,
    #[serde(default)]
    actions: Vec<LoggedAction>,
}

/// One song fades into the next in at most this time.
const LONGEST_CROSSFADE_SECS: f64 = 60.0;
/// The longest show: 24 hours.
const LONGEST_SECS: f64 = 86_400.0;

impl Show {
    /// All actions of an instrument; body, songs and looks are still to be filled in.
    pub fn of(instrument: &Instrument) -> Self {
        Self {
            format_version: FORMAT_VERSION,
            harmonics: Some(instrument.shape().eigenvalues.len()),
            seed: instrument.seed(),
            size: instrument.size(),
            duration_secs: None,
            body: None,
            looks: None,
            viewpoint: Viewpoint::default(),
            beginning: instrument.beginning(),
            songs: Vec::new(),
            heard: Vec::new(),
            clock: ClockTrack::default(),
            actions: instrument.log().to_vec(),
            read_from_version: FORMAT_VERSION,
        }
    }

    /// The instrument at its beginning, for a body; apply `actions` as time goes by.
    ///
    /// # Errors
    /// A setting out of its range, or a size that a gallery cannot have.
    pub fn begin(&self, shape: GalleryShape) -> Result<Instrument, MusicError> {
        let mut parameters = Parameters::default();
        parameters.apply(&self.beginning)?;
        Instrument::beginning_with(parameters, self.seed, self.size, shape)
    }

    /// The instrument after all actions.
    ///
    /// # Errors
    /// As [`begin`](Self::begin), or an action that cannot be done ([`Instrument::apply`]).
    pub fn replay(&self, shape: GalleryShape) -> Result<Instrument, MusicError> {
        let mut instrument = self.begin(shape)?;
        for line in &self.actions {
            instrument.apply(line.moment, line.action.clone())?;
        }
        Ok(instrument)
    }

    /// The same, to be danced to something else from its beginning.
    #[must_use]
    pub fn unheard(self) -> Self {
        Self { heard: Vec::new(), clock: ClockTrack::default(), duration_secs: None, ..self }
    }

    /// A warning for the user who opens it; only old files have one.
    pub fn caution(&self) -> Option<&'static str> {
        (self.read_from_version < 2).then_some(
            "A session of an older version, which names no shape, no look and no number of harmonics: it \
             goes on with those of now. Save it again to bring it up to date.",
        )
    }

    /// Reads the text of a show file, or of a session of version 1.
    ///
    /// # Errors
    /// Text that is neither, with its line; a newer format version; a value out of its range.
    pub fn from_text(text: &str) -> Result<Self, MusicError> {
        let version = text_file::version("show", text)?;
        let mut show = if version < 2 {
            let Session { song, seed, size, actions } = text_file::parse("session", text)?;
            let song = SongRef::of(FileRef { path: song, blake3: None });
            let songs = Some(song).filter(|song| !song.path.is_empty());
            Self {
                format_version: FORMAT_VERSION,
                harmonics: None,
                seed,
                size,
                duration_secs: None,
                body: None,
                looks: None,
                viewpoint: Viewpoint::default(),
                beginning: Settings::of_version_1(),
                songs: songs.into_iter().collect(),
                heard: Vec::new(),
                clock: ClockTrack::default(),
                actions,
                read_from_version: version,
            }
        } else {
            text_file::parse("show", text)?
        };
        if version == 2 {
            show.beginning = show.beginning.of_version_2();
        }
        show.beginning = show.beginning.of_a_show();
        show.read_from_version = version;
        show.validate()?;
        Ok(show)
    }

    /// The text of a show file.
    ///
    /// # Errors
    /// Bugs only: every show can be written.
    pub fn to_text(&self) -> Result<String, MusicError> {
        text_file::print("show", self)
    }

    /// Reads a show file of at most 64 MiB: enough for hours of continuously turned knobs.
    ///
    /// # Errors
    /// A file that cannot be read or is too large, and what [`from_text`](Self::from_text) refuses.
    pub fn load(path: &Path) -> Result<Self, MusicError> {
        Self::from_text(&text_file::read(path, 64)?)
    }

    /// Writes a show file whole or not at all.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), MusicError> {
        text_file::write(path, &self.to_text()?)
    }

    fn validate(&self) -> Result<(), MusicError> {
        self.beginning.validate()?;
        let bad = |why: String| Err(MusicError::Parse { kind: "show", why });
        let is_time = |secs: f64| (0.0..=LONGEST_SECS).contains(&secs);
        if !self.heard.iter().all(|s| is_time(s.at_secs) && is_time(s.song_secs))
            || !self.duration_secs.is_none_or(is_time)
        {
            return bad(format!("times must lie from 0 to {LONGEST_SECS} seconds"));
        }
        if !self.heard.iter().all(|s| (0.0..=LONGEST_CROSSFADE_SECS).contains(&s.crossfade_secs)) {
            return bad(format!("crossfades take 0 to {LONGEST_CROSSFADE_SECS} seconds"));
        }
        let wrong = |r: &BeatReading| {
            r.octave.abs() > MOST_OCTAVES || r.shift_secs.abs().partial_cmp(&60.0).is_none_or(|o| o.is_gt())
        };
        if self.songs.iter().any(|song| wrong(&song.reading)) {
            return bad("the beats of a song cannot be read so".into());
        }
        if self.heard.windows(2).any(|pair| pair[1].at_secs < pair[0].at_secs) {
            return bad("what was heard must be in order".into());
        }
        if !self.clock.is_sound() || !self.clock.marks().iter().all(|mark| is_time(mark.at_secs)) {
            return bad("the marks of the clock must be in order and within bounds".into());
        }
        if let Some(song) = self.heard.iter().filter_map(|s| s.song).find(|&song| song >= self.songs.len()) {
            return bad(format!("there is no song {song}: there are {}", self.songs.len()));
        }
        if !self.harmonics.is_none_or(|k| (1..=crate::MAX_GENES).contains(&k)) {
            return bad(format!("there are 1 to {} harmonics", crate::MAX_GENES));
        }
        let v = &self.viewpoint;
        let finite = [v.yaw_rad, v.pitch_rad, v.shift[0], v.shift[1]].iter().all(|x| x.abs() <= 1e3);
        if !finite || !(1e-3..=1e3).contains(&v.distance) {
            return bad("the viewpoint is out of all bounds".into());
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beats_are_read_twice_and_half_as_fast_and_later() {
        let read = |octave, shift_secs| BeatReading { octave, shift_secs }.of(&[1.0, 2.0, 3.0]);
        assert_eq!(read(0, 0.0), [1.0, 2.0, 3.0]);
        assert_eq!(read(1, 0.25), [1.25, 1.75, 2.25, 2.75, 3.25]);
        assert_eq!(read(-1, 0.0), [1.0, 3.0]);
        assert_eq!(BeatReading { octave: 3, shift_secs: 0.0 }.of(&[]), [0.0; 0]);
    }
}
