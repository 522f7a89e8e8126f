//! The spectrum at any time of a song that is fully known.

use std::sync::Arc;

use super::{Level, Spectrum, SpectrumAnalyzer, SpectrumSettings};
use crate::{Song, SoundError};

/// Analyses per second. A power of two makes the times of all hops exact, and this one puts three hops
/// under a window into the shortest silence that a strobe of five flashes per second leaves.
const HOPS_PER_SEC: f64 = 128.0;
/// How many hops before the start of a stretch are analyzed for level and decay: as long as the level of a
/// band takes to settle. More would delay a frame noticeably at each jump.
const WARM_HOPS: i64 = 512;

/// An argument of the callback of [`SongSpectrum::at_after`].
#[derive(Clone, Copy, Debug)]
pub enum Hop<'a> {
    /// The analysis restarts: everything heard before must be forgotten.
    Beginning,
    /// The next spectrum, [`SongSpectrum::HOP_SECS`] after the previous one, and the center frequency of
    /// each of its bands, in Hz.
    Heard(&'a Spectrum, &'a [f32]),
}

/// The spectrum at any time of a stretch of a song, including level and decay.
///
/// The result depends only on the song, the settings, the start of the stretch and the time asked for, not
/// on how often or in which order the methods are called. A window and a film at any frame rate therefore
/// get the same spectra, bit for bit.
pub struct SongSpectrum {
    song: Arc<Song>,
    analyzer: SpectrumAnalyzer,
    first_hop: i64,
    /// The number of the hop in `after`.
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

    /// Analyzes the stretch of `song` that begins at `from_secs`.
    ///
    /// # Errors
    /// A setting is out of range.
    pub fn new(song: Arc<Song>, settings: SpectrumSettings, from_secs: f64) -> Result<Self, SoundError> {
        let analyzer = SpectrumAnalyzer::new(settings)?;
        let window = vec![0.0; analyzer.window_frames()];
        // Before the song there is only silence, which the first windows overlap.
        let first_hop = (hop_at(from_secs) - WARM_HOPS).max(-32);
        let silence = analyzer.spectrum().clone();
        Ok(Self {
            song,
            analyzer,
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
        self.analyzer.settings()
    }

    /// Center of each band, in Hz.
    pub fn bands_hz(&self) -> &[f32] {
        self.analyzer.bands_hz()
    }

    /// The spectrum at `secs` of the song. Going forward is cheap; going back restarts the analysis.
    pub fn at(&mut self, secs: f64) -> &Spectrum {
        self.at_after(secs, |_| ());
        &self.now
    }

    /// The same, and calls `hops` with every hop up to the one after `secs`, in order, and with a
    /// [`Hop::Beginning`] whenever the analysis restarts. Returns the time from the last hop before `secs`
    /// to `secs`, in seconds.
    pub fn at_after(&mut self, secs: f64, mut hops: impl FnMut(Hop<'_>)) -> f32 {
        let secs = if secs.is_finite() { secs } else { 0.0 };
        let hop = hop_at(secs).max(self.first_hop);
        if hop + 1 < self.hop {
            self.analyzer.reset();
            self.hop = self.first_hop - 1;
            self.after.clone_from(self.analyzer.spectrum());
        }
        if self.hop < self.first_hop {
            hops(Hop::Beginning);
        }
        while self.hop < hop + 1 {
            self.step();
            hops(Hop::Heard(&self.after, self.analyzer.bands_hz()));
        }
        let weight = (secs * HOPS_PER_SEC - hop as f64).clamp(0.0, 1.0) as f32;
        self.now.clone_from(&self.before);
        self.now.mix(&self.after, weight);
        weight / HOPS_PER_SEC as f32
    }

    /// The spectrum that was computed last.
    pub fn spectrum(&self) -> &Spectrum {
        &self.now
    }

    /// Advances by one hop. The center of the window is delayed by the lag of the decay, which puts shape
    /// and sound in step.
    fn step(&mut self) {
        self.hop += 1;
        std::mem::swap(&mut self.before, &mut self.after);
        let secs = self.hop as f64 / HOPS_PER_SEC + self.analyzer.lag_secs();
        let center = (secs * f64::from(self.song.rate_hz)).round() as i64;
        let end = center + self.left.len() as i64 / 2;
        self.song.window_ending_at(end, &mut self.left, &mut self.right);
        self.after.clone_from(self.analyzer.analyze(&self.left, &self.right, 1.0 / HOPS_PER_SEC));
    }
}

/// The largest number of moments at which the loudness of a song is sampled.
const PROBES: usize = 240;

impl Song {
    /// The amplitude of the loudest band that is exceeded at one moment in ten, measured with the default
    /// settings at fixed level 1; 0 for silence. Takes some 40 ms for a long song.
    ///
    /// # Errors
    /// The song's rate is out of range.
    pub fn loud_level(&self) -> Result<f32, SoundError> {
        let settings =
            SpectrumSettings { decay: 0.0, level: Level::Fixed(1.0), ..SpectrumSettings::new(self.rate_hz) };
        let mut analyzer = SpectrumAnalyzer::new(settings)?;
        let (mut left, mut right) =
            (vec![0.0; analyzer.window_frames()], vec![0.0; analyzer.window_frames()]);
        let probes = PROBES.min(self.frames() / left.len() + 1);
        let mut levels: Vec<f32> = (0..probes)
            .map(|i| {
                let center = (self.frames() as f64 * (i as f64 + 0.5) / probes as f64) as i64;
                self.window_ending_at(center + left.len() as i64 / 2, &mut left, &mut right);
                let heard = analyzer.analyze(&left, &right, 1.0);
                heard.left.iter().chain(&heard.right).fold(0.0, |most: f32, level| most.max(*level))
            })
            .collect();
        levels.sort_unstable_by(f32::total_cmp);
        Ok(levels.get(levels.len() * 9 / 10).copied().unwrap_or(0.0))
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
        // The result is close to that of an analysis of the whole song; it differs because the level of a
        // band has a longer memory.
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
