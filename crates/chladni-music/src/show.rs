//! The show file: the shape, the songs, the viewpoint and all actions. The window, films and the command read
//! and write this one file.

use std::collections::BTreeMap;
use std::path::Path;

use chladni_mesh::Orientation;
use serde::{Deserialize, Serialize};

pub use self::appearance::{Looks, Viewpoint};
pub use self::songs::{BeatReading, FileRef, Recording, SongRef, Stretch, heard_again};
use self::songs::{MOST_OCTAVES, MOST_SHIFT_SECS};
use crate::gallery::GalleryShape;
use crate::text_file::{self, FORMAT_VERSION};
use crate::{ClockTrack, Instrument, LoggedAction, MusicError, Parameters, Settings};

mod appearance;
mod songs;

/// The songs that were played and all actions, so that the show can be continued or filmed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Show {
    /// The format of the file: [`FORMAT_VERSION`], or an older one.
    pub format_version: u32,
    /// K of the body; `None` in older files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub harmonics: Option<usize>,
    /// The seed it began with.
    pub seed: u64,
    /// S.
    pub size: usize,
    /// How long it lasts; `None` is as long as its song.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub duration_secs: Option<f64>,
    /// How its body stands, where that was set by hand; `None` as it stands by itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stands: Option<Orientation>,
    /// The dancing body: a mesh, or a caricature whose layers are voices.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub body: Option<FileRef>,
    /// The look of the shapes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub looks: Option<Looks>,
    /// Where the viewer stands.
    #[serde(default)]
    pub viewpoint: Viewpoint,
    /// Where the knobs stood in the beginning.
    #[serde(default)]
    pub beginning: Settings,
    /// The songs that were heard.
    #[serde(default)]
    pub songs: Vec<SongRef>,
    /// When each was heard, in order; if empty, the first song from its beginning.
    #[serde(default)]
    pub heard: Vec<Stretch>,
    /// The beat of an outer clock, where one was followed.
    #[serde(default, skip_serializing_if = "ClockTrack::is_empty")]
    pub clock: ClockTrack,
    /// In copies against a crash: how the show names files of other machines, by the places that stand for them above.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub far: BTreeMap<String, FileRef>,
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
/// The longest show, as of an installation that plays day and night: 400 days.
const LONGEST_SECS: f64 = 400.0 * 86_400.0;
/// The largest show file.
const MOST_MIB: u64 = 256;

impl Show {
    /// All actions of an instrument; body, its stance, songs and looks are still to be filled in.
    pub fn of(instrument: &Instrument) -> Self {
        Self {
            format_version: FORMAT_VERSION,
            harmonics: Some(instrument.shape().eigenvalues.len()),
            seed: instrument.first_seed(),
            size: instrument.size(),
            duration_secs: None,
            stands: None,
            body: None,
            looks: None,
            viewpoint: Viewpoint::default(),
            beginning: instrument.beginning(),
            songs: Vec::new(),
            heard: Vec::new(),
            clock: ClockTrack::default(),
            far: BTreeMap::new(),
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

    /// Where it has come to: the time that it lasts, where the file says that, and at least its last action.
    pub fn ends_secs(&self) -> f64 {
        let last = self.actions.iter().map(|line| line.moment.at_secs).fold(0.0, f64::max);
        self.duration_secs.unwrap_or(0.0).max(last)
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

    /// A warning for the user where it goes on with another number of harmonics than it was bred with. Chance draws one
    /// harmonic after another, so another number of them gives other dances.
    pub fn caution_on(&self, harmonics: usize) -> Option<String> {
        let bred_with = self.harmonics.filter(|own| *own != harmonics)?;
        let caution = format!(
            "The dances were bred with {bred_with} harmonics; with {harmonics}, those bred or varied come out \
             differently."
        );
        self.actions.iter().any(|line| line.action.is_bred()).then_some(caution)
    }

    /// Reads the text of a show file, or of a session of version 1. A viewpoint out of all bounds is replaced by the
    /// default.
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
                stands: None,
                body: None,
                looks: None,
                viewpoint: Viewpoint::default(),
                beginning: Settings::of_version_1(),
                songs: songs.into_iter().collect(),
                heard: Vec::new(),
                clock: ClockTrack::default(),
                far: BTreeMap::new(),
                actions,
                read_from_version: version,
            }
        } else {
            text_file::parse("show", text)?
        };
        if version == 2 {
            show.beginning = show.beginning.of_version_2();
        }
        if version < 4 {
            let as_then = |line: LoggedAction| LoggedAction { action: line.action.of_version_3(), ..line };
            show.actions = show.actions.into_iter().map(as_then).collect();
        }
        show.beginning = show.beginning.of_a_show();
        show.read_from_version = version;
        // From there nothing is seen: no reason to refuse all the rest.
        if !show.viewpoint.is_sound() {
            show.viewpoint = Viewpoint::default();
        }
        show.validate()?;
        Ok(show)
    }

    /// The text of a show file.
    ///
    /// # Errors
    /// A show that is too large to be [read](Self::load) again.
    pub fn to_text(&self) -> Result<String, MusicError> {
        text_file::readable("show", text_file::print("show", self)?, MOST_MIB)
    }

    /// Reads a show file of at most 256 MiB: enough for hours of continuously turned knobs, and for some nine days of the
    /// autopilot.
    ///
    /// # Errors
    /// A file that cannot be read or is too large, and what [`from_text`](Self::from_text) refuses.
    pub fn load(path: &Path) -> Result<Self, MusicError> {
        Self::from_text(&text_file::read(path, MOST_MIB)?)
    }

    /// Writes a show file whole or not at all.
    ///
    /// # Errors
    /// As [`to_text`](Self::to_text), or the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), MusicError> {
        text_file::write(path, &self.to_text()?)
    }

    fn validate(&self) -> Result<(), MusicError> {
        self.beginning.validate()?;
        let bad = |why: String| Err(MusicError::Parse { kind: "show", why });
        let is_time = |secs: f64| (0.0..=LONGEST_SECS).contains(&secs);
        if !self.heard.iter().all(|s| is_time(s.at_secs) && is_time(s.song_secs))
            || !self.duration_secs.is_none_or(is_time)
            || !self
                .actions
                .iter()
                .all(|line| is_time(line.moment.at_secs) && line.moment.at_beat.is_finite())
        {
            return bad(format!("times must lie from 0 to {LONGEST_SECS} seconds"));
        }
        if !self.heard.iter().all(|s| (0.0..=LONGEST_CROSSFADE_SECS).contains(&s.crossfade_secs)) {
            return bad(format!("crossfades take 0 to {LONGEST_CROSSFADE_SECS} seconds"));
        }
        let wrong = |r: &BeatReading| {
            !(-MOST_OCTAVES..=MOST_OCTAVES).contains(&r.octave)
                || r.shift_secs.abs().partial_cmp(&MOST_SHIFT_SECS).is_none_or(|o| o.is_gt())
                || r.tapped.is_some_and(|t| !t.has_tempo() || !is_time(t.at_secs.abs()))
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
        Ok(())
    }
}
