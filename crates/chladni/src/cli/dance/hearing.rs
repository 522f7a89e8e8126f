//! What is heard at each frame of a film: spectrum and beat.

use chladni_music::{Bands, Beat, Parameter, Parameters, Switch};
use chladni_sound::{Beats, FrontEnd, Song, SpectrumAnalyser, SpectrumSettings};

use crate::cli::Failure;

/// A song that is analysed at the moments of a film.
pub struct Hearing {
    song: Song,
    beats: Beats,
    analyser: SpectrumAnalyser,
    left: Vec<f32>,
    right: Vec<f32>,
}

impl Hearing {
    /// Listens to `song` as `parameters` say.
    pub fn new(song: Song, beats: Beats, parameters: &Parameters) -> Result<Self, Failure> {
        let analyser = SpectrumAnalyser::new(settings(&song, parameters)).map_err(Failure::input)?;
        let window = vec![0.0; analyser.window_frames()];
        Ok(Self { song, beats, analyser, left: window.clone(), right: window })
    }

    /// The song.
    pub fn song(&self) -> &Song {
        &self.song
    }

    /// The beat at `secs` from the beginning of what was read.
    pub fn beat(&self, secs: f64) -> Beat {
        Beat::among(&self.beats.beats_secs, self.beats.confidence as f32, secs)
    }

    /// The bands at `secs`, `dt_secs` after the last call. The window lies around the moment
    /// that is heard, later by what the decay holds back, so that shape and sound meet.
    pub fn bands(&mut self, secs: f64, dt_secs: f64, parameters: &Parameters) -> Result<Bands<'_>, Failure> {
        let wanted = settings(&self.song, parameters);
        if *self.analyser.settings() != wanted {
            self.analyser = SpectrumAnalyser::new(wanted).map_err(Failure::input)?;
        }
        let window = self.analyser.window_frames();
        self.left.resize(window, 0.0);
        self.right.resize(window, 0.0);
        let center = (secs + self.analyser.lag_secs()) * f64::from(self.song.rate_hz);
        let end = center.round() as i64 + window as i64 / 2;
        self.song.window_ending_at(end, &mut self.left, &mut self.right);
        let spectrum = self.analyser.analyse(&self.left, &self.right, dt_secs);
        Ok(Bands {
            left: &spectrum.left,
            right: &spectrum.right,
            mid: &spectrum.mid,
            side: &spectrum.side,
            side_gain: spectrum.side_gain,
        })
    }
}

fn settings(song: &Song, parameters: &Parameters) -> SpectrumSettings {
    SpectrumSettings {
        bands: parameters.get(Parameter::Bands).round() as usize,
        decay: parameters.get(Parameter::Decay),
        side_gain: parameters.get(Parameter::SideGain),
        front_end: if parameters.is_on(Switch::LogBands) { FrontEnd::LogBands } else { FrontEnd::Linear },
        ..SpectrumSettings::new(song.rate_hz)
    }
}
