//! Onset strength: how much new sound begins at each moment.
//!
//! Spectral flux over logarithmic bands with a maximum filter, which keeps a vibrato that moves into the
//! next band from counting as an onset: SuperFlux (S. Böck and G. Widmer, "Maximum filter vibrato
//! suppression for onset detection", DAFx 2013). Differences from the paper: magnitudes are taken relative
//! to a slow follower of the level, which gives a quiet master the same onsets; and both channels are used.
//! Onsets in the bass are kept separately, because a drum is more often on the beat than a cymbal.

use realfft::num_complex::Complex;

use crate::SoundError;
use crate::windowed::{SlidingWindow, WindowedFft, window_frames};

/// Onset values per second.
pub const ONSET_RATE_HZ: f64 = 100.0;

const WINDOW_SECS: f64 = 0.046;
const BANDS_PER_OCTAVE: f64 = 24.0;
const LOWEST_HZ: f64 = 30.0;
const HIGHEST_HZ: f64 = 17_000.0;
/// Bands below this frequency are the bass.
const BASS_HZ: f64 = 250.0;
/// Compression: a band 20 dB below the level counts as ln 2. Loud sounds count more.
const COMPRESSION: f32 = 10.0;
/// The level falls to 1/e in this time.
const LEVEL_SECS: f64 = 10.0;
/// Amplitude of the loudest band below which everything counts as noise (−90 dB).
const FLOOR: f32 = 3e-5;
/// A frame is compared with the one this many frames before it: by then the window has moved by about half
/// its effective width.
const LAG: usize = 2;

/// Strength of the onsets at one moment; each value is at least 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Onset {
    /// The mean flux of all bands.
    pub all: f32,
    /// The mean flux of the bands below 250 Hz.
    pub bass: f32,
}

/// Computes onset strength from a stream. Value n belongs to the time n / [`ONSET_RATE_HZ`] and needs
/// [`latency_secs`](Self::latency_secs) of sound after it.
pub struct OnsetDetector {
    fft: WindowedFft,
    bins: Vec<Complex<f32>>,
    sliding: SlidingWindow,
    /// For each band, its first bin and its triangular weights.
    bands: Vec<(usize, Vec<f32>)>,
    /// How many of the bands are the bass.
    bass: usize,
    /// The magnitudes of the last frames of each channel, newest last.
    past: [[Vec<f32>; LAG + 1]; 2],
    level: f32,
}

impl OnsetDetector {
    /// A detector for samples at `rate_hz`.
    ///
    /// # Errors
    /// A rate outside [[`MIN_RATE_HZ`](crate::MIN_RATE_HZ), [`MAX_RATE_HZ`](crate::MAX_RATE_HZ)].
    pub fn new(rate_hz: u32) -> Result<Self, SoundError> {
        crate::check_rate("onset detector", rate_hz)?;
        let rate = f64::from(rate_hz);
        let n = window_frames(rate, WINDOW_SECS);
        let fft = WindowedFft::new(n, 1.0);
        let bands = bands(rate, n);
        let center_hz = |band: &(usize, Vec<f32>)| (band.0 + band.1.len() / 2) as f64 * rate / n as f64;
        let bass = bands.iter().take_while(|band| center_hz(band) < BASS_HZ).count();
        let quiet = vec![0.0; bands.len()];
        Ok(Self {
            bins: fft.make_bins(),
            fft,
            sliding: SlidingWindow::new(rate, ONSET_RATE_HZ, n),
            past: std::array::from_fn(|_| std::array::from_fn(|_| quiet.clone())),
            bands,
            bass,
            level: FLOOR,
        })
    }

    /// How much sound after its time a value needs, in seconds.
    pub fn latency_secs(&self) -> f64 {
        self.sliding.latency_secs()
    }

    /// Takes the next samples and appends the values that are now complete to `out`.
    pub fn push(&mut self, left: &[f32], right: &[f32], out: &mut Vec<Onset>) {
        self.sliding.push(left, right);
        while let Some(channels) = self.sliding.next() {
            let mut loudest = 0.0f32;
            for (heard, past) in channels.into_iter().zip(&mut self.past) {
                self.fft.transform(heard, &mut self.bins);
                past.rotate_left(1);
                for ((first, weights), value) in self.bands.iter().zip(&mut past[LAG]) {
                    let bins = &self.bins[*first..*first + weights.len()];
                    *value = weights.iter().zip(bins).map(|(w, bin)| w * bin.norm()).sum();
                    loudest = loudest.max(*value);
                }
            }
            out.push(self.onset(loudest));
        }
    }

    /// The rise of the newest magnitudes; `loudest` is the greatest of them.
    fn onset(&mut self, loudest: f32) -> Onset {
        let fade = (-1.0 / (LEVEL_SECS * ONSET_RATE_HZ)).exp() as f32;
        self.level = loudest.max(self.level * fade).max(FLOOR);
        let scale = COMPRESSION / self.level;
        let (mut all, mut bass) = (0.0, 0.0);
        for past in &self.past {
            let low = flux(past, scale, 0..self.bass);
            bass += low;
            all += low + flux(past, scale, self.bass..self.bands.len());
        }
        let mean = |sum: f32, bands: usize| sum / (2 * bands).max(1) as f32;
        Onset { all: mean(all, self.bands.len()), bass: mean(bass, self.bass) }
    }
}

/// The sum over some bands of the rise above the loudest of the three neighboring bands `LAG` frames ago.
fn flux(past: &[Vec<f32>; LAG + 1], scale: f32, bands: std::ops::Range<usize>) -> f32 {
    let (before, now) = (&past[0], &past[LAG]);
    let last = now.len().saturating_sub(1);
    let mut sum = 0.0;
    for b in bands {
        let magnitude = now[b];
        let neighbors = &before[b.saturating_sub(1)..=(b + 1).min(last)];
        let loudest = neighbors.iter().fold(0.0f32, |a, &x| a.max(x));
        if magnitude > loudest {
            sum += ((1.0 + scale * magnitude) / (1.0 + scale * loudest)).ln();
        }
    }
    sum
}

/// Triangular bands in equal steps of pitch; where the bins are farther apart than that, one band per bin.
fn bands(rate_hz: f64, n: usize) -> Vec<(usize, Vec<f32>)> {
    let bin_hz = rate_hz / n as f64;
    let top = HIGHEST_HZ.min(0.48 * rate_hz);
    let mut centers: Vec<usize> = Vec::new();
    let mut hz = LOWEST_HZ;
    while hz < top {
        let bin = (hz / bin_hz).round().max(1.0) as usize;
        if centers.last() != Some(&bin) {
            centers.push(bin);
        }
        hz *= (1.0 / BANDS_PER_OCTAVE).exp2();
    }
    let triangle = |w: &[usize]| {
        let (a, b, c) = (w[0], w[1], w[2]);
        let weights: Vec<f32> =
            (a + 1..c)
                .map(|bin| {
                    if bin <= b {
                        (bin - a) as f32 / (b - a) as f32
                    } else {
                        (c - bin) as f32 / (c - b) as f32
                    }
                })
                .collect();
        let sum: f32 = weights.iter().sum();
        (a + 1, weights.iter().map(|w| w / sum).collect())
    };
    centers.windows(3).map(triangle).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn onsets(left: &[f32], right: &[f32]) -> Vec<f32> {
        let mut out = Vec::new();
        OnsetDetector::new(44_100).unwrap().push(left, right, &mut out);
        out.iter().map(|onset| onset.all).collect()
    }

    #[test]
    fn a_click_is_found_in_either_channel_at_its_time_and_at_any_level() {
        let silence = vec![0.0f32; 88_200];
        for gain in [1.0, 0.01] {
            let mut click = silence.clone();
            click[44_100] = gain;
            for (left, right) in [(&click, &silence), (&silence, &click)] {
                let found = onsets(left, right);
                let peak = (0..found.len()).max_by(|&a, &b| found[a].total_cmp(&found[b])).unwrap();
                assert!((98..=101).contains(&peak), "{peak}");
                assert!(found[..95].iter().all(|&x| x < 1e-6));
            }
        }
    }

    #[test]
    fn a_drum_is_heard_in_the_bass_and_a_cymbal_is_not() {
        let hit = |wave: &dyn Fn(f32) -> f32| -> Onset {
            // Two clicks: the second one is measured against the level of the first.
            let sound: Vec<f32> = (0..66_150)
                .map(|n| (n % 33_075) as f32 / 44_100.0)
                .map(|t| wave(t) * (t / 0.02).min(1.0) * (-t / 0.1).exp())
                .collect();
            let mut out = Vec::new();
            OnsetDetector::new(44_100).unwrap().push(&sound, &sound, &mut out);
            let second = &out[50..];
            let bass = second.iter().fold(0.0f32, |a, o| a.max(o.bass));
            Onset { all: second.iter().fold(0.0f32, |a, o| a.max(o.all)), bass }
        };
        let drum = hit(&|t| (std::f32::consts::TAU * 60.0 * t).sin());
        let cymbal = hit(&|t| {
            (1..40).map(|h| (std::f32::consts::TAU * (6000.0 + 211.0 * h as f32) * t).sin() / 40.0).sum()
        });
        assert!(drum.bass > 2.0 * drum.all, "{drum:?}");
        assert!(cymbal.bass < 0.2 * cymbal.all, "{cymbal:?}");
    }

    #[test]
    fn it_does_not_matter_how_the_sound_is_cut_into_blocks() {
        let tune = crate::sample_tune();
        let (left, right) = (&tune.left[..200_000], &tune.right[..200_000]);
        let whole = onsets(left, right);
        let mut detector = OnsetDetector::new(44_100).unwrap();
        let mut pieces = Vec::new();
        for (l, r) in left.chunks(733).zip(right.chunks(733)) {
            detector.push(l, r, &mut pieces);
        }
        let pieces: Vec<f32> = pieces.iter().map(|onset| onset.all).collect();
        assert_eq!(whole, pieces);
    }

    #[test]
    fn a_vibrato_is_no_onset() {
        let tone: Vec<f32> = (0..132_300)
            .map(|n| {
                let t = n as f32 / 44_100.0;
                0.3 * (std::f32::consts::TAU * 440.0 * t + 4.0 * (std::f32::consts::TAU * 6.0 * t).sin())
                    .sin()
            })
            .collect();
        let found = onsets(&tone, &tone);
        let start = found[..20].iter().fold(0.0f32, |a, &b| a.max(b));
        let later = found[50..280].iter().fold(0.0f32, |a, &b| a.max(b));
        assert!(later < 0.15 * start, "{later} against {start}");
    }
}
