//! The ears of the room: the song that plays or what a microphone hears, its spectrum and its beat,
//! at the moment that is heard.

use std::ffi::OsString;
use std::path::PathBuf;

use chladni_music::{Bands, Beat, Parameter, Parameters, Switch};
use chladni_sound::{
    BeatFollower, BeatMoment, Capture, CaptureSource, FrontEnd, Player, PlayerEvent, PlayerSettings,
    PlayerState, PlayerStatus, Repeat, Spectrum, SpectrumAnalyser, SpectrumSettings, WavSample, sample_tune,
    write_wav,
};

/// Where the song has moved on by so much more or less than the clock, someone sought: the beat
/// tracker starts afresh.
const SEEK_SECS: f64 = 0.3;
/// A longer pause between two frames is not made up for.
const LONGEST_STEP_SECS: f64 = 2.0;

/// Player or capture, analyser and beat tracker in step.
pub struct Listening {
    player: Player,
    live: Option<Live>,
    analyser: SpectrumAnalyser,
    follower: BeatFollower,
    left: Vec<f32>,
    right: Vec<f32>,
    last_secs: f64,
    last_position_secs: f64,
    beats: BeatCount,
    levels: [Level; 2],
    songs: Vec<PathBuf>,
    repeat: Repeat,
    warnings: Vec<String>,
    /// The sample tune lives in a file while the room is open.
    tune: PathBuf,
    _folder: tempfile::TempDir,
}

/// How loud one channel is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Level {
    /// Largest amplitude, falling by 20 dB a second.
    pub peak: f32,
    /// Root mean square of what is heard now.
    pub rms: f32,
}

impl Level {
    fn of(samples: &[f32], before: Self, dt_secs: f64) -> Self {
        let (peak, square) =
            samples.iter().fold((0.0f32, 0.0f32), |(peak, square), s| (peak.max(s.abs()), square + s * s));
        let fallen = before.peak * 0.1f32.powf(dt_secs as f32);
        let rms = (square / samples.len().max(1) as f32).sqrt();
        Self { peak: peak.max(if fallen > 1e-3 { fallen } else { 0.0 }), rms }
    }
}

/// Beats gone by. A tracker thinks better of a phase now and then; what the beat has moved must not
/// fly back for that.
#[derive(Clone, Copy, Debug, Default)]
struct BeatCount {
    gone: f64,
    shown: f64,
}

impl BeatCount {
    /// With the place within the present beat; never less than before.
    fn at(&mut self, phase: f64) -> f64 {
        self.shown = self.shown.max(self.gone + phase.clamp(0.0, 1.0));
        self.shown
    }
}

/// What is listened to instead of a song.
struct Live {
    capture: Capture,
    name: String,
    heard_secs: f64,
}

/// What is heard at one moment.
pub struct Heard<'a> {
    /// Position in the song, or seconds of live input so far.
    pub at_secs: f64,
    /// The beat there.
    pub beat: Beat,
    /// The sound there.
    pub bands: Bands<'a>,
}

impl Listening {
    /// Starts the player on the sample tune.
    pub fn start() -> Result<Self, String> {
        let folder = tempfile::tempdir().map_err(|error| format!("no room for the sample tune: {error}"))?;
        let tune = folder.path().join("sample tune.wav");
        write_wav(&tune, &sample_tune(), WavSample::Int16).map_err(|error| error.to_string())?;
        let player = Player::start(PlayerSettings::default()).map_err(|error| error.to_string())?;
        let rate_hz = 44_100;
        let analyser =
            SpectrumAnalyser::new(SpectrumSettings::new(rate_hz)).map_err(|error| error.to_string())?;
        let follower = BeatFollower::new(rate_hz).map_err(|error| error.to_string())?;
        let mut listening = Self {
            player,
            live: None,
            analyser,
            follower,
            left: Vec::new(),
            right: Vec::new(),
            last_secs: 0.0,
            last_position_secs: 0.0,
            beats: BeatCount::default(),
            levels: [Level::default(); 2],
            songs: vec![tune.clone()],
            repeat: Repeat::Off,
            warnings: Vec::new(),
            tune,
            _folder: folder,
        };
        listening.player.play_list(listening.songs.clone());
        listening.set_repeat(Repeat::List);
        Ok(listening)
    }

    /// The playlist.
    pub fn songs(&self) -> &[PathBuf] {
        &self.songs
    }

    /// Adds songs at the end of the list and plays the first of them; the sample tune goes.
    pub fn add(&mut self, songs: Vec<PathBuf>) {
        if songs.is_empty() {
            return;
        }
        self.songs.retain(|song| *song != self.tune);
        let first = self.songs.len();
        self.songs.extend(songs);
        self.player.set_songs(self.songs.clone());
        self.select(first);
    }

    /// Takes a song out of the list; the last one makes room for the sample tune.
    pub fn remove(&mut self, song: usize) {
        if song >= self.songs.len() {
            return;
        }
        self.songs.remove(song);
        if self.songs.is_empty() {
            self.songs.push(self.tune.clone());
        }
        self.player.set_songs(self.songs.clone());
    }

    /// Plays a song of the list.
    pub fn select(&mut self, song: usize) {
        self.live = None;
        self.player.select(song);
    }

    /// What comes after a song.
    pub fn repeat(&self) -> Repeat {
        self.repeat
    }

    /// Changes what comes after a song.
    pub fn set_repeat(&mut self, repeat: Repeat) {
        self.repeat = repeat;
        self.player.repeat(repeat);
    }

    /// Listens to a microphone or to what the machine plays; the song pauses.
    pub fn listen_to(&mut self, source: &CaptureSource) -> Result<(), String> {
        let capture = Capture::start(source).map_err(|error| error.to_string())?;
        self.listen_on(capture, source.name.clone());
        Ok(())
    }

    /// Listens to a capture that is called `name`; the song pauses.
    pub fn listen_on(&mut self, capture: Capture, name: String) {
        self.player.pause();
        self.live = Some(Live { capture, name, heard_secs: 0.0 });
        self.forget_beat();
    }

    /// Back to the songs.
    pub fn stop_listening(&mut self) {
        self.live = None;
        self.forget_beat();
    }

    /// The live input's name.
    pub fn live(&self) -> Option<&str> {
        self.live.as_ref().map(|live| live.name.as_str())
    }

    /// How loud left and right are.
    pub fn levels(&self) -> [Level; 2] {
        self.levels
    }

    /// The name of a song of the list.
    pub fn name_of(&self, song: usize) -> String {
        let stem = self.songs.get(song).and_then(|path| path.file_stem());
        stem.map_or_else(String::new, |stem| stem.to_string_lossy().into_owned())
    }

    /// What is heard: the song's file name or the live input's.
    pub fn source_name(&self) -> String {
        self.live.as_ref().map_or_else(|| self.name_of(self.player.status().song), |live| live.name.clone())
    }

    /// The song's file, as a session keeps it; empty for live input and the sample tune.
    pub fn session_song(&self) -> String {
        let song = self.songs.get(self.player.status().song).filter(|_| self.live.is_none());
        let song = song.filter(|song| **song != self.tune);
        song.map_or_else(String::new, |path| path.display().to_string())
    }

    /// The song as the command line calls it; none of live input.
    pub fn song_name(&self) -> Option<OsString> {
        let song = self.songs.get(self.player.status().song).filter(|_| self.live.is_none())?;
        Some(if *song == self.tune { "sample:tune".into() } else { song.clone().into_os_string() })
    }

    /// The player.
    pub fn player(&self) -> &Player {
        &self.player
    }

    /// Plays or pauses; leaves live input.
    pub fn toggle(&mut self) {
        if self.live.take().is_some() {
            return self.player.play();
        }
        if self.player.status().state == PlayerState::Playing {
            self.player.pause();
        } else {
            self.player.play();
        }
    }

    /// A beat by hand.
    pub fn tap(&mut self) {
        self.follower.tap(self.follower.now_secs());
    }

    /// The beat tracker, for halve and double.
    pub fn follower(&mut self) -> &mut BeatFollower {
        &mut self.follower
    }

    /// What is known about the beat now.
    pub fn beat_moment(&self) -> BeatMoment {
        self.follower.moment()
    }

    /// The last spectrum.
    pub fn spectrum(&self) -> &Spectrum {
        self.analyser.spectrum()
    }

    /// Where its bands lie.
    pub fn bands_hz(&self) -> &[f32] {
        self.analyser.bands_hz()
    }

    /// What the player has to say.
    pub fn messages(&mut self) -> Vec<String> {
        let tell = |event| match event {
            PlayerEvent::SongFailed { reason, .. } => Some(reason),
            PlayerEvent::SongDamaged { what, .. } => Some(what),
            PlayerEvent::DeviceLost(why) => Some(format!("No sound: {why}. The song goes on in silence.")),
            PlayerEvent::SongStarted(_) | PlayerEvent::Finished | PlayerEvent::DeviceOpened(_) => None,
        };
        let told: Vec<String> = self.player.events().filter_map(tell).collect();
        self.warnings.drain(..).chain(told).collect()
    }

    /// Listens to what is heard at this moment, which is `now_secs` by any clock that goes on.
    pub fn hear(&mut self, now_secs: f64, parameters: &Parameters) -> Result<Heard<'_>, String> {
        let since_last_secs = now_secs - self.last_secs;
        let dt_secs = since_last_secs.clamp(1e-3, 0.25);
        self.last_secs = now_secs;
        if let Some(live) = self.live.take_if(|live| live.capture.is_lost()) {
            self.warnings.push(format!("{} is gone; choose it again when it is back.", live.name));
        }
        let status = self.player.status();
        let rate_hz = self.live.as_ref().map_or(status.rate_hz, |live| live.capture.rate_hz());
        self.follow_rate(rate_hz, parameters)?;
        let at_secs = match self.live.is_some() {
            true => self.take_live(),
            false => {
                self.follow_song(&status, since_last_secs);
                status.position_secs
            }
        };
        let playing = self.live.is_some() || status.state == PlayerState::Playing;
        self.take_window(playing);
        let heard = [&self.left, &self.right];
        self.levels = std::array::from_fn(|side| Level::of(heard[side], self.levels[side], dt_secs));
        let moment = self.follower.moment();
        let beat = Beat {
            count: self.beats.at(moment.phase),
            confidence: if playing { moment.confidence as f32 } else { 0.0 },
        };
        let spectrum = self.analyser.analyse(&self.left, &self.right, dt_secs);
        let bands = Bands {
            left: &spectrum.left,
            right: &spectrum.right,
            mid: &spectrum.mid,
            side: &spectrum.side,
            side_gain: spectrum.side_gain,
        };
        Ok(Heard { at_secs, beat, bands })
    }

    fn follow_rate(&mut self, rate_hz: u32, parameters: &Parameters) -> Result<(), String> {
        let rate_hz = if rate_hz > 0 { rate_hz } else { self.analyser.settings().rate_hz };
        if rate_hz != self.analyser.settings().rate_hz {
            self.follower = BeatFollower::new(rate_hz).map_err(|error| error.to_string())?;
        }
        let wanted = SpectrumSettings {
            bands: parameters.get(Parameter::Bands).round() as usize,
            decay: parameters.get(Parameter::Decay),
            side_gain: parameters.get(Parameter::SideGain),
            front_end: if parameters.is_on(Switch::LogBands) { FrontEnd::LogBands } else { FrontEnd::Linear },
            ..SpectrumSettings::new(rate_hz)
        };
        if *self.analyser.settings() != wanted {
            self.analyser = SpectrumAnalyser::new(wanted).map_err(|error| error.to_string())?;
        }
        Ok(())
    }

    /// The samples to analyse: around what is heard of a song, later by what the decay holds back;
    /// the newest ones of live input.
    fn take_window(&mut self, playing: bool) {
        let window = self.analyser.window_frames();
        self.left.resize(window, 0.0);
        self.right.resize(window, 0.0);
        match &self.live {
            Some(live) => live.capture.window(&mut self.left, &mut self.right),
            None => {
                let late = self.analyser.lag_secs() * f64::from(self.analyser.settings().rate_hz);
                let ahead = window / 2 + late as usize;
                self.player.heard_window(ahead, &mut self.left, &mut self.right);
            }
        }
        if !playing {
            self.left.fill(0.0);
            self.right.fill(0.0);
        }
    }

    /// Feeds the tracker with what has come in; the seconds heard so far.
    fn take_live(&mut self) -> f64 {
        let Some(live) = &mut self.live else { return 0.0 };
        self.left.clear();
        self.right.clear();
        let frames = live.capture.take(&mut self.left, &mut self.right);
        live.heard_secs += frames as f64 / f64::from(live.capture.rate_hz().max(1));
        let heard_secs = live.heard_secs;
        self.follower.push(&self.left, &self.right);
        self.count_beats();
        heard_secs
    }

    /// Feeds the tracker with what was heard since the last frame.
    fn follow_song(&mut self, status: &PlayerStatus, since_last_secs: f64) {
        let step_secs = status.position_secs - self.last_position_secs;
        self.last_position_secs = status.position_secs;
        let paused = step_secs == 0.0;
        let sought = !paused && (step_secs - since_last_secs).abs() > SEEK_SECS;
        if sought || !(0.0..LONGEST_STEP_SECS).contains(&step_secs) {
            return self.forget_beat();
        }
        let frames = (step_secs * f64::from(status.rate_hz)).round() as usize;
        self.left.resize(frames, 0.0);
        self.right.resize(frames, 0.0);
        self.player.heard_window(0, &mut self.left, &mut self.right);
        self.follower.push(&self.left, &self.right);
        self.count_beats();
    }

    fn count_beats(&mut self) {
        while self.follower.take_beat().is_some() {
            self.beats.gone += 1.0;
        }
    }

    /// After a seek the old beat means nothing; a tracker that cannot start over goes on as it is.
    fn forget_beat(&mut self) {
        let _ = self.follower.reset();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beats_never_go_back() {
        let mut beats = BeatCount::default();
        // The tracker takes a beat back that it had not announced yet.
        assert_eq!([0.5, 0.99, 0.02, 0.6].map(|phase| beats.at(phase)), [0.5, 0.99, 0.99, 0.99]);
        beats.gone += 1.0;
        assert_eq!([0.05, 0.5].map(|phase| beats.at(phase)), [1.05, 1.5]);
    }
}
