//! The ears of the room: the song that plays, its spectrum and its beat, at the moment that is heard.

use std::path::PathBuf;
use std::time::Instant;

use chladni_music::{Bands, Beat, Parameter, Parameters, Switch};
use chladni_sound::{
    BeatFollower, BeatMoment, FrontEnd, Player, PlayerEvent, PlayerSettings, PlayerState, PlayerStatus,
    Spectrum, SpectrumAnalyser, SpectrumSettings, WavSample, sample_tune, write_wav,
};

/// A step of the song longer than this is a seek: the beat tracker starts afresh.
const LONGEST_STEP_SECS: f64 = 0.5;

/// Player, analyser and beat tracker in step.
pub struct Listening {
    player: Player,
    analyser: SpectrumAnalyser,
    follower: BeatFollower,
    left: Vec<f32>,
    right: Vec<f32>,
    last: Instant,
    last_position_secs: f64,
    beats_gone: f64,
    songs: Vec<PathBuf>,
    /// The sample tune lives in a file while the room is open.
    _tune: tempfile::TempDir,
}

impl Listening {
    /// Starts the player on the sample tune, paused.
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
            analyser,
            follower,
            left: Vec::new(),
            right: Vec::new(),
            last: Instant::now(),
            last_position_secs: 0.0,
            beats_gone: 0.0,
            songs: Vec::new(),
            _tune: folder,
        };
        listening.play_list(vec![tune]);
        Ok(listening)
    }

    /// Plays these songs in order.
    pub fn play_list(&mut self, songs: Vec<PathBuf>) {
        self.songs = songs.clone();
        self.player.play_list(songs);
        self.player.repeat(chladni_sound::Repeat::List);
        self.player.play();
    }

    /// The song that is heard, by its file name.
    pub fn song_name(&self) -> String {
        let path = self.songs.get(self.player.status().song);
        path.map_or_else(String::new, |path| {
            path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned())
        })
    }

    /// The player.
    pub fn player(&self) -> &Player {
        &self.player
    }

    /// Plays or pauses.
    pub fn toggle(&self) {
        if self.player.status().state == PlayerState::Playing {
            self.player.pause()
        } else {
            self.player.play()
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

    /// What the player has to say.
    pub fn messages(&mut self) -> Vec<String> {
        let tell = |event| match event {
            PlayerEvent::SongFailed { reason, .. } => Some(reason),
            PlayerEvent::DeviceLost(why) => Some(format!("No sound: {why}. The song goes on in silence.")),
            PlayerEvent::SongStarted(_) | PlayerEvent::Finished | PlayerEvent::DeviceOpened(_) => None,
        };
        self.player.events().filter_map(tell).collect()
    }

    /// Listens to what is heard at this moment: the player's status, the beat, and the bands.
    pub fn hear(&mut self, parameters: &Parameters) -> Result<(PlayerStatus, Beat, Bands<'_>), String> {
        let status = self.player.status();
        let now = Instant::now();
        let dt_secs = (now - self.last).as_secs_f64().clamp(1e-3, 0.25);
        self.last = now;
        self.follow_rate(&status, parameters)?;
        self.follow_beat(&status);
        let window = self.analyser.window_frames();
        self.left.resize(window, 0.0);
        self.right.resize(window, 0.0);
        self.player.heard_window(window / 2, &mut self.left, &mut self.right);
        if status.state != PlayerState::Playing {
            self.left.fill(0.0);
            self.right.fill(0.0);
        }
        let moment = self.follower.moment();
        let playing = status.state == PlayerState::Playing;
        let beat = Beat {
            count: self.beats_gone + moment.phase.clamp(0.0, 1.0),
            confidence: if playing { moment.confidence as f32 } else { 0.0 },
        };
        let spectrum = self.analyser.analyse(&self.left, &self.right, dt_secs);
        let bands =
            Bands { left: &spectrum.left, right: &spectrum.right, mid: &spectrum.mid, side: &spectrum.side };
        Ok((status, beat, bands))
    }

    fn follow_rate(&mut self, status: &PlayerStatus, parameters: &Parameters) -> Result<(), String> {
        let rate_hz = if status.rate_hz > 0 { status.rate_hz } else { self.analyser.settings().rate_hz };
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

    /// Feeds the tracker with what was heard since the last frame.
    fn follow_beat(&mut self, status: &PlayerStatus) {
        let step_secs = status.position_secs - self.last_position_secs;
        self.last_position_secs = status.position_secs;
        if !(0.0..LONGEST_STEP_SECS).contains(&step_secs) {
            // After a seek the old beat means nothing; a tracker that cannot start over goes on as it is.
            let _ = self.follower.reset();
            return;
        }
        let frames = (step_secs * f64::from(status.rate_hz)).round() as usize;
        self.left.resize(frames, 0.0);
        self.right.resize(frames, 0.0);
        self.player.heard_window(0, &mut self.left, &mut self.right);
        self.follower.push(&self.left, &self.right);
        while self.follower.take_beat().is_some() {
            self.beats_gone += 1.0;
        }
    }
}
