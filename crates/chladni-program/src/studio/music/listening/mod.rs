//! The ears of the room: the song that plays or live sound, its spectrum and its beat,
//! at the moment that is heard.

mod beats;
mod comparing;
mod ear;
mod learning;
mod live;
mod outer;
mod playlist;
mod study;
mod wanted;

pub use ear::Loudness;
pub use outer::Progress;
pub use wanted::{Input, MOST_GAIN_DB};

use std::path::PathBuf;
use std::time::{Duration, Instant};

use chladni_music::{
    BarLine, Beat, BeatReading, ClockTrack, Director, Framing, Moment, Parameters, Stretch, Taps,
};
use chladni_sound::{
    Beats, HeardTo, Level, Player, PlayerEvent, PlayerSettings, PlayerState, PlayerStatus, Repeat, SongTags,
    Spectrum, WavSample, sample_tune, write_wav,
};

use comparing::Comparison;
use egui::Context;
use live::Live;
use outer::Outer;
use study::{SongCover, Study};
use wanted::Wanted;

use crate::work::{BeatCount, Ear, Error, Heard, Hearing, Playing, ShowClock};

/// Player or capture, and the ears: a fully read song is heard exactly as in its films; live input, and a
/// song until it is read, through an ear that knows only the past.
pub struct Listening {
    player: Player,
    live: Option<Live>,
    /// A live input that is looked for.
    wanted: Option<Wanted>,
    /// Songs were playing when live input began, and do so again after it.
    resumes: bool,
    input: Input,
    clock: ShowClock,
    hearing: Hearing,
    /// The songs of the show, by number.
    repertoire: Vec<ShowSong>,
    study: Option<Study>,
    /// Songs of the show that was opened, while they are compared with those that it names.
    comparison: Option<Comparison>,
    /// The song that was heard when findings were taken in last.
    learned_of: Option<usize>,
    /// Where covers become textures.
    ctx: Context,
    /// Beats have become known that were unknown when some action was logged.
    beats_changed: bool,
    /// The ear below hears: live input, or a song until it is read.
    by_ear: bool,
    /// The beats of the song are known.
    had_beats: bool,
    /// Taps to a song with known beats, by its number.
    taps: Option<(usize, Taps)>,
    last_beat: Beat,
    /// When that was heard.
    heard_at: Instant,
    ear: Ear,
    left: Vec<f32>,
    right: Vec<f32>,
    last_secs: f64,
    last_position_secs: f64,
    /// Films sound that is not known as a whole.
    director: Director,
    /// Bars that began by ear, and up to when those of known songs were reported.
    fresh_bars: Vec<BarLine>,
    bars_told_secs: f64,
    /// The beat of an outer clock, and its last value.
    outer: Outer,
    outer_beat: Beat,
    progress: Progress,
    /// Sound since it was last taken, for a recording.
    tee: Option<HeardSound>,
    /// A shot that was called by hand, and when.
    called: Option<(usize, f64)>,
    levels: [Loudness; 2],
    songs: Vec<PathBuf>,
    repeat: Repeat,
    volume: f32,
    song_fade_secs: f64,
    device: Option<String>,
    warnings: Vec<String>,
    /// The sample tune lives in a file while the room is open.
    tune: PathBuf,
    _folder: tempfile::TempDir,
}

/// A song that was heard in this show.
#[derive(Clone)]
pub struct ShowSong {
    /// Its file, or `sample:tune`.
    pub path: PathBuf,
    /// How its beats are read.
    pub reading: BeatReading,
    /// As they were found.
    beats: Option<Beats>,
    /// It cannot be read as a whole.
    given_up: bool,
    /// The contents of its tags.
    tags: SongTags,
    /// The cover in its tags, or beside it.
    cover: Option<SongCover>,
}

impl ShowSong {
    /// A song about which nothing is known yet.
    pub fn new(path: PathBuf, reading: BeatReading) -> Self {
        Self { path, reading, beats: None, given_up: false, tags: SongTags::default(), cover: None }
    }
}

/// Sound as it was heard, before volume.
#[derive(Clone, Debug, Default)]
pub struct HeardSound {
    pub rate_hz: u32,
    pub left: Vec<f32>,
    pub right: Vec<f32>,
    /// Frames of it, or the one behind it, that do not follow from those before.
    pub breaks: Vec<usize>,
    /// Where in all that the player plays it ends.
    until: Option<HeardTo>,
}

/// A message of the player or of the ears.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Message {
    /// Something is not as it was wanted.
    Warning(String),
    /// The song goes on in silence, and why.
    Silence(String),
    /// There is sound again.
    Sound,
}

impl Message {
    fn of(event: PlayerEvent) -> Option<Self> {
        match event {
            PlayerEvent::SongFailed { reason, .. } => Some(Self::Warning(reason)),
            PlayerEvent::SongDamaged { what, .. } => Some(Self::Warning(what)),
            PlayerEvent::DeviceLost(why) => {
                Some(Self::Silence(format!("No sound ({why}): the song goes on in silence.")))
            }
            PlayerEvent::DeviceOpened(_) => Some(Self::Sound),
            PlayerEvent::BrokeOff => {
                let why = Error::BrokeOff("The player".into());
                Some(Self::Warning(format!("{why}. No song plays until the program is started again.")))
            }
            PlayerEvent::SongStarted(_) | PlayerEvent::Finished => None,
        }
    }
}

impl Listening {
    /// Starts the player on the sample tune, at a volume in [0, 1], on a device or the system's own.
    pub fn start(ctx: &Context, volume: f32, device: Option<String>) -> Result<Self, Error> {
        let folder = chladni_task::private_folder(".chladni-", &std::env::temp_dir())
            .map_err(|error| Error::other(format!("no room for the sample tune: {error}")))?;
        let tune = folder.path().join("sample tune.wav");
        write_wav(&tune, &sample_tune(), WavSample::Int16)?;
        let player = Player::start(PlayerSettings { device: device.clone(), volume, audible: true })?;
        let mut listening = Self {
            player,
            live: None,
            wanted: None,
            resumes: false,
            input: Input::default(),
            clock: ShowClock::default(),
            hearing: Hearing::default(),
            repertoire: Vec::new(),
            study: None,
            comparison: None,
            learned_of: None,
            ctx: ctx.clone(),
            beats_changed: false,
            by_ear: true,
            had_beats: false,
            taps: None,
            last_beat: Beat::default(),
            heard_at: Instant::now(),
            ear: Ear::new(44_100)?,
            left: Vec::new(),
            right: Vec::new(),
            last_secs: 0.0,
            last_position_secs: 0.0,
            // Its seed comes before its first bar.
            director: Director::live(0, 0.0),
            fresh_bars: Vec::new(),
            bars_told_secs: 0.0,
            outer: Outer::default(),
            outer_beat: Beat::default(),
            progress: Progress::default(),
            tee: None,
            called: None,
            levels: [Loudness::default(); 2],
            songs: vec![tune.clone()],
            repeat: Repeat::Off,
            volume,
            song_fade_secs: 0.0,
            device,
            warnings: Vec::new(),
            tune,
            _folder: folder,
        };
        listening.player.play_list(listening.songs.clone());
        listening.set_repeat(Repeat::List);
        Ok(listening)
    }

    /// Whether a song is heard.
    pub fn plays_songs(&self) -> bool {
        self.live.is_none() && self.player.status().state == PlayerState::Playing
    }

    /// How loud left and right are.
    pub fn levels(&self) -> [Loudness; 2] {
        self.levels
    }

    /// Name of the source: the song's file name or the live input's.
    pub fn source_name(&self) -> String {
        self.live.as_ref().map_or_else(|| self.name_of(self.player.status().song), |live| live.name.clone())
    }

    /// The time of the show.
    pub fn at_secs(&self) -> f64 {
        self.clock.at_secs()
    }

    /// The stretches of songs heard so far, and the songs that they number.
    pub fn heard(&self) -> (Vec<Stretch>, &[ShowSong]) {
        (self.hearing.stretches().collect(), &self.repertoire)
    }

    /// The song that is heard, as the show numbers it; none of live input.
    pub fn song_number(&self) -> Option<usize> {
        self.hearing.stretch().filter(|_| self.live.is_none())?.song
    }

    /// Since when of the show it is heard, or the live input.
    pub fn heard_since_secs(&self) -> Option<f64> {
        self.clock.stretch().map(|stretch| stretch.at_secs)
    }

    /// The outer clock of the show so far.
    pub fn clock(&self) -> &ClockTrack {
        self.hearing.clock()
    }

    /// Goes on with a show in which `heard` was heard of `songs`, in part to a `clock`, until `at`; they are
    /// played from now on.
    pub fn go_on(&mut self, songs: Vec<ShowSong>, heard: &[Stretch], clock: ClockTrack, at: Moment) {
        (self.live, self.wanted, self.study, self.comparison) = (None, None, None, None);
        self.hearing = Hearing::continued(heard, clock, at.at_secs);
        self.clock = ShowClock::from(at.at_secs);
        // No beat goes back: neither that which is heard nor that of an outer clock.
        self.last_beat.count = at.at_beat.max(self.hearing.beat_at(at.at_secs).count);
        self.ear.beats = BeatCount::from(self.last_beat.count);
        (self.outer.was_followed, self.outer.bar_count) = (false, None);
        (self.repertoire, self.taps) = (songs, None);
        let mut list: Vec<PathBuf> = Vec::new();
        for song in &self.repertoire {
            let path = self.file_of(&song.path);
            if !list.iter().any(|known| known == path) {
                list.push(path.to_owned());
            }
        }
        if !list.is_empty() {
            self.songs = list;
            self.player.play_list(self.songs.clone());
        }
        self.forget_beat();
    }

    /// Whether beats became known since the last call, so that the beats of logged actions must be
    /// recomputed.
    pub fn beats_changed(&mut self) -> bool {
        // The beats of an outer clock are not those of a song.
        !self.follows_clock() && std::mem::take(&mut self.beats_changed)
    }

    /// Beats gone by at a moment of the show so far at which something was done.
    pub fn beats_at(&self, moment: Moment) -> f64 {
        self.hearing.beats_at(moment)
    }

    /// The song after the one that plays; live input ends. Without `plays`, a paused song is followed by a paused one, and
    /// live input is heard on, or once it is open.
    pub fn next_song(&mut self, plays: bool) {
        self.leave_for(plays);
        self.player.next(plays);
    }

    /// The one before it, or its beginning, likewise.
    pub fn previous_song(&mut self, plays: bool) {
        self.leave_for(plays);
        self.player.previous(plays);
    }

    fn leave_for(&mut self, plays: bool) {
        if plays {
            self.stop_listening();
        }
    }

    /// The player.
    pub fn player(&self) -> &Player {
        &self.player
    }

    /// The player's state for the eye. Where a new list has no song that can be opened, the player still knows place and
    /// length of the one heard before; no song has them now.
    pub fn status(&self) -> PlayerStatus {
        let status = self.player.status();
        if status.is_listed || status.state != PlayerState::Stopped {
            return status;
        }
        PlayerStatus { position_secs: 0.0, duration_secs: None, ..status }
    }

    /// The last spectrum, and where its bands lie.
    pub fn spectrum(&self) -> (&Spectrum, &[f32]) {
        let by_ear = (self.ear.analyzer().spectrum(), self.ear.analyzer().bands_hz());
        self.hearing.spectrum().filter(|_| !self.by_ear).unwrap_or(by_ear)
    }

    /// The messages since the last call.
    pub fn messages(&mut self) -> Vec<Message> {
        let changed = self.comparison.iter().flat_map(Comparison::warnings);
        self.warnings.extend(changed.map(|warning| warning.to_string()));
        let messages: Vec<Message> = self.player.events().filter_map(Message::of).collect();
        self.warnings.drain(..).map(Message::Warning).chain(messages).collect()
    }

    /// Listens to the sound of this moment, which is `now_secs` by any steadily running clock. `before`
    /// listens first to whatever it wants before the time of the show that it is given.
    pub fn hear(
        &mut self,
        now_secs: f64,
        parameters: &Parameters,
        mut before: impl FnMut(&mut Hearing, f64) -> Result<(), Error>,
    ) -> Result<Heard<'_>, Error> {
        let since_last_secs = now_secs - self.last_secs;
        let dt_secs = since_last_secs.clamp(1e-3, Ear::LONGEST_SECS);
        self.last_secs = now_secs;
        self.keep_live(now_secs);
        self.keep_wanted();
        let status = self.player.status();
        self.heard_at = Instant::now();
        let had_changed = self.beats_changed;
        self.learn(&status);
        let have_changed = self.beats_changed && !had_changed;
        self.hearing.tune(self.clock.at_secs(), parameters);
        self.follow(now_secs, &status, &mut before)?;
        let at_secs = self.clock.at_secs();
        let is_playing = self.live.is_some() || status.state == PlayerState::Playing;
        if self.live.is_none() {
            before(&mut self.hearing, at_secs)?;
        }
        let known = self.live.is_none() && self.hearing.hear(at_secs)?.is_some();
        let has_beats = known && self.known_beats().is_some();
        let ear_secs = self.change_ears(at_secs, (known, has_beats), dt_secs);
        let rate_hz = self.live.as_ref().map_or(status.rate_hz, |live| live.capture.rate_hz());
        let rate_hz = if rate_hz > 0 { rate_hz } else { self.ear.rate_hz() };
        let level = if self.live.is_some() { self.input.level() } else { Level::Auto };
        self.ear.set_level(level);
        self.ear.tune(rate_hz, parameters)?;
        if self.live.is_some() {
            self.take_live(dt_secs);
        } else if !has_beats {
            self.follow_song(&status, since_last_secs);
        } else {
            self.last_position_secs = status.position_secs;
        }
        self.take_window(is_playing, ear_secs);
        let heard = [&self.left, &self.right];
        self.levels = std::array::from_fn(|side| Loudness::of(heard[side], self.levels[side], dt_secs));
        let by_ear = self.ear.beat();
        let confidence = if is_playing { by_ear.confidence } else { self.last_beat.confidence };
        // Until past actions are counted anew, the beat stays among those that they were done at.
        let by_ear = if have_changed { self.last_beat } else { Beat { confidence, ..by_ear } };
        let has_beats = has_beats && !have_changed;
        if !known {
            let beat = self.beat_or(by_ear);
            self.last_beat = beat;
            let (bands, harmony) = self.ear.hear((&self.left, &self.right), parameters, ear_secs);
            return Ok(Heard { at_secs, is_known: false, bands, harmony, beat, fading: None });
        }
        let by_music = if has_beats { self.hearing.beat_at(at_secs) } else { by_ear };
        let beat = self.beat_or(by_music);
        self.last_beat = beat;
        let is_given = self.follows_clock();
        let heard = self.hearing.hear(at_secs)?;
        let heard = heard.ok_or_else(|| Error::other("the song is forgotten"))?;
        Ok(Heard { beat, is_known: has_beats && !is_given, ..heard })
    }

    /// Follows the player, or live input, to this moment: a new stretch of the show may begin.
    fn follow(
        &mut self,
        now_secs: f64,
        status: &PlayerStatus,
        before: &mut impl FnMut(&mut Hearing, f64) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let playing = Playing {
            song: self.number_of_heard(status),
            position_secs: status.position_secs,
            duration_secs: status.duration_secs,
            crossfade_secs: status.crossfade_secs,
            is_over: status.is_over,
        };
        let was_live = self.hearing.stretch().is_some_and(|stretch| stretch.song.is_none());
        // Where another show was opened, what still sounds is not of that one.
        let follows = self.live.is_some() || status.is_listed || self.clock.stretch().is_some();
        if let Some(stretch) = follows.then(|| self.clock.follow(now_secs, playing)).flatten() {
            // A long absence is not made up for.
            if !self.hearing.goes_on_with(stretch) {
                before(&mut self.hearing, stretch.at_secs)?;
            }
            self.hearing.begin(stretch)?;
            // No beat goes back.
            if was_live && !self.follows_clock() {
                self.hearing.leave_live(stretch.at_secs, self.last_beat);
            }
        }
        Ok(())
    }

    /// Whether the beat is that of the ear: where no beats of a song are known.
    fn beat_is_by_ear(&self) -> bool {
        self.by_ear || self.known_beats().is_none()
    }

    /// The bars that have begun since the last call, by the time of the show.
    pub fn new_bars(&mut self) -> Vec<BarLine> {
        let to_secs = self.at_secs();
        let from_secs = std::mem::replace(&mut self.bars_told_secs, to_secs);
        let by_ear = std::mem::take(&mut self.fresh_bars);
        let bars = if self.beat_is_by_ear() { by_ear } else { self.hearing.bars_between(from_secs, to_secs) };
        self.bars_or(bars)
    }

    /// Draws the shots of sound that is not known as a whole by this seed from now on.
    pub fn set_seed(&mut self, seed: u64) {
        self.director.set_seed(seed);
    }

    /// How the camera frames the shape at the time heard last, by the seeds at times of the show.
    pub fn framing(&mut self, seed_at: impl Fn(f64) -> u64) -> Framing {
        if let Some((shot, since_secs)) = self.called {
            return Framing::of_shot(shot, self.last_secs - since_secs);
        }
        if self.follows_clock() {
            return self.director.at(self.shown_secs());
        }
        if self.beat_is_by_ear() {
            return self.director.at(self.ear.follower.now_secs());
        }
        self.hearing.framing_at(self.clock.at_secs(), seed_at)
    }

    /// Keeps the sound for a recording, or no longer.
    pub fn keep_sound(&mut self, on: bool) {
        self.tee = on.then(HeardSound::default);
    }

    /// Sound since the last call, while it is kept, and how long ago its end was heard.
    pub fn take_sound(&mut self) -> Option<(Duration, HeardSound)> {
        let tee = self.tee.as_mut()?;
        let mut age = self.heard_at.elapsed();
        if self.live.is_none() {
            let status = self.player.status();
            tee.rate_hz = status.rate_hz;
            age = Duration::ZERO;
            let breaks = self.player.take_heard(&mut tee.until, &mut tee.left, &mut tee.right);
            tee.breaks.extend(breaks);
        }
        let rest = HeardSound { rate_hz: tee.rate_hz, until: tee.until, ..HeardSound::default() };
        Some((age, std::mem::replace(tee, rest)))
    }

    /// The shot that was called by hand: a number of [`SHOTS`](chladni_music::SHOTS).
    pub fn called_shot(&self) -> Option<usize> {
        self.called.map(|(shot, _)| shot)
    }

    /// Calls a shot, which stays; or lets the camera choose again.
    pub fn call_shot(&mut self, shot: Option<usize>) {
        self.called = shot.map(|shot| (shot, self.last_secs));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_that_is_opened_ends_the_silence() {
        let silence = Message::of(PlayerEvent::DeviceLost("it is gone".into()));
        assert!(matches!(silence, Some(Message::Silence(why)) if why.contains("it is gone")));
        assert_eq!(Message::of(PlayerEvent::DeviceOpened("speaker".into())), Some(Message::Sound));
    }
}
