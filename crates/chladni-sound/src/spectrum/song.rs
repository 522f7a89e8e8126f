//! The spectrum at any time of a song that is known as a whole.

use std::sync::Arc;

use super::{Spectrum, SpectrumAnalyser, SpectrumSettings};
use crate::{Song, SoundError};

/// The song is analysed so often: a power of two, so that the times of all hops are exact; three times in
/// the shortest silence that a strobe of five flashes a second leaves under a window.
const HOPS_PER_SEC: f64 = 128.0;
/// Level and decay have heard so much before the moment that a stretch begins at: as long as the level of
/// a band takes to follow. More would be heard as a pause in the frames at each leap.
const WARM_HOPS: i64 = 512;

/// What a listener of [`SongSpectrum::at_after`] is given.
#[derive(Clone, Copy, Debug)]
pub enum Hop<'a> {
    /// All that was heard is forgotten.
    Beginning,
    /// The next spectrum, [`SongSpectrum::HOP_SECS`] after the one before.
    Heard(&'a Spectrum),
}

/// What a song sounds like at any time of a stretch of it, level and decay included.
///
/// It is a function of the song, the settings, the time at which the stretch begins and the time asked for,
/// and of nothing else: not of how often or in which order it is asked. So a window and a film at any rate
/// hear the same, bit for bit.
pub struct SongSpectrum {
    song: Arc<Song>,
    analyser: SpectrumAnalyser,
    first_hop: i64,
    /// The hop of `after`.
    hop: i64,
    before: Spectrum,
    after: Spectrum,
    now: Spectrum,
    left: Vec<f32>,
    right: Vec<f32>,
}

impl SongSpectrum {
    /// Seconds between two hops.
    pub const HOP_SECS: f32 = 1.0 / HOPS_PER_SEC as f32;

    /// Of the stretch of `song` that begins at `from_secs`. Errors where a setting is out of range.
    pub fn new(song: Arc<Song>, settings: SpectrumSettings, from_secs: f64) -> Result<Self, SoundError> {
        let analyser = SpectrumAnalyser::new(settings)?;
        let window = vec![0.0; analyser.window_frames()];
        // Before the song there is only silence, which a window reaches into.
        let first_hop = (hop_at(from_secs) - WARM_HOPS).max(-32);
        let silence = analyser.spectrum().clone();
        Ok(Self {
            song,
            analyser,
            first_hop,
            hop: first_hop - 1,
            before: silence.clone(),
            after: silence.clone(),
            now: silence,
            left: window.clone(),
            right: window,
        })
    }

    /// The settings in use.
    pub fn settings(&self) -> &SpectrumSettings {
        self.analyser.settings()
    }

    /// Centre of each band, in Hz.
    pub fn bands_hz(&self) -> &[f32] {
        self.analyser.bands_hz()
    }

    /// The spectrum at `secs` of the song. Going on costs little; going back begins anew.
    pub fn at(&mut self, secs: f64) -> &Spectrum {
        self.at_after(secs, |_| ());
        &self.now
    }

    /// The same for whoever listens to all that comes before it: `hops` is given every hop up to the one that
    /// follows `secs`, in order, and a beginning where the song is heard anew. Returns how long before `secs` the
    /// hop before it lies, in seconds.
    pub fn at_after(&mut self, secs: f64, mut hops: impl FnMut(Hop<'_>)) -> f32 {
        let secs = if secs.is_finite() { secs } else { 0.0 };
        let hop = hop_at(secs).max(self.first_hop);
        if hop + 1 < self.hop {
            self.analyser.reset();
            self.hop = self.first_hop - 1;
            self.after.clone_from(self.analyser.spectrum());
        }
        if self.hop < self.first_hop {
            hops(Hop::Beginning);
        }
        while self.hop < hop + 1 {
            self.step();
            hops(Hop::Heard(&self.after));
        }
        let weight = (secs * HOPS_PER_SEC - hop as f64).clamp(0.0, 1.0) as f32;
        self.now.clone_from(&self.before);
        self.now.mix(&self.after, weight);
        weight / HOPS_PER_SEC as f32
    }

    /// The last spectrum.
    pub fn spectrum(&self) -> &Spectrum {
        &self.now
    }

    /// One hop on. The window lies around its moment, later by what the decay holds back, so that shape and
    /// sound meet.
    fn step(&mut self) {
        self.hop += 1;
        std::mem::swap(&mut self.before, &mut self.after);
        let secs = self.hop as f64 / HOPS_PER_SEC + self.analyser.lag_secs();
        let center = (secs * f64::from(self.song.rate_hz)).round() as i64;
        let end = center + self.left.len() as i64 / 2;
        self.song.window_ending_at(end, &mut self.left, &mut self.right);
        self.after.clone_from(self.analyser.analyse(&self.left, &self.right, 1.0 / HOPS_PER_SEC));
    }
}

fn hop_at(secs: f64) -> i64 {
    (secs * HOPS_PER_SEC).floor() as i64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample_tune;

    #[test]
    fn it_does_not_matter_how_often_and_in_which_order_it_is_asked() {
        let song = Arc::new(sample_tune());
        let settings = SpectrumSettings { bands: 24, ..SpectrumSettings::new(song.rate_hz) };
        let ear = |from_secs| SongSpectrum::new(Arc::clone(&song), settings.clone(), from_secs).unwrap();
        let (mut often, mut seldom, mut back) = (ear(8.0), ear(8.0), ear(8.0));
        back.at(11.0);
        for frame in 0..240 {
            let secs = 8.0 + f64::from(frame) / 113.0;
            let heard = often.at(secs).clone();
            if frame % 40 == 7 {
                assert!(heard.mid.iter().any(|f| *f > 0.1));
                assert_eq!(heard, *seldom.at(secs));
            }
            if frame == 47 {
                assert_eq!(heard, *back.at(secs));
            }
        }
        // It is nearly what the analyser hears that has heard all of the song: a band's level remembers more.
        let mut whole = ear(0.0);
        let (a, b) = (whole.at(10.0).clone(), often.at(10.0));
        let farthest = a.mid.iter().zip(&b.mid).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(farthest < 0.05, "{farthest}");
    }

    #[test]
    fn any_time_has_a_spectrum() {
        let song = Arc::new(Song { rate_hz: 8000, left: vec![0.5; 100], right: vec![0.5; 100] });
        let mut ear = SongSpectrum::new(song, SpectrumSettings::new(8000), 0.0).unwrap();
        for secs in [-5.0, 0.0, f64::NAN, 0.01, 2.0, 1.0] {
            assert!(ear.at(secs).mid.iter().all(|f| f.is_finite()), "{secs}");
        }
    }
}
