//! Computes the amplitudes that move a shape from a window of stereo samples.

use realfft::num_complex::Complex;

use super::bands::{Bands, FrontEnd};
use super::level::{Level, Leveler};
use crate::SoundError;
use crate::windowed::WindowedFft;

/// The interval for which the decay w is stated, in seconds: the paper analyzes every 50 ms.
const DECAY_INTERVAL_SECS: f64 = 0.05;

/// The settings of a [`SpectrumAnalyzer`].
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SpectrumSettings {
    /// Rate of the samples, in Hz.
    pub rate_hz: u32,
    /// Samples under the window, a power of two in [256, 65536].
    pub window_frames: usize,
    /// Number of bands #ω, in [2, 4096].
    pub bands: usize,
    /// Center of the first band, in Hz.
    pub low_hz: f32,
    /// Center of the last band, in Hz; reduced to 0.45 times the rate if it exceeds that.
    pub high_hz: f32,
    /// How the bands are placed between `low_hz` and `high_hz`.
    pub front_end: FrontEnd,
    /// Decay w in [0, 1): the share of the spectrum that remains after 50 ms.
    pub decay: f32,
    /// The largest gain of the side, which is weak in most music. With automatic level the gain is lower if
    /// the side is strong, and makes the side's loudest band 1.
    pub side_gain: f32,
    /// Automatic or fixed level.
    pub level: Level,
    /// The level of the song's loud passages for the automatic level, from
    /// [`Song::loud_level`](crate::Song::loud_level); with it, soft passages are softer from the first moment
    /// on. `None` learns it while listening.
    pub loud: Option<f32>,
}

impl SpectrumSettings {
    /// The usual settings at a rate: a window of about 93 ms, 128 log bands from 40 Hz to
    /// 16 kHz, w = ½, side × 10, automatic level.
    pub fn new(rate_hz: u32) -> Self {
        let window = (f64::from(rate_hz) * 0.07).max(256.0) as usize;
        Self {
            rate_hz,
            window_frames: window.next_power_of_two().min(1 << 16),
            bands: 128,
            low_hz: 40.0,
            high_hz: 16_000.0,
            front_end: FrontEnd::LogBands,
            decay: 0.5,
            side_gain: 10.0,
            level: Level::Auto,
            loud: None,
        }
    }

    fn check(&self) -> Result<(), SoundError> {
        crate::check_rate("spectrum", self.rate_hz)?;
        let complaint =
            if !self.window_frames.is_power_of_two() || !(256..=1 << 16).contains(&self.window_frames) {
                "the window must be a power of two from 256 to 65536 frames"
            } else if !(2..=4096).contains(&self.bands) {
                "there must be 2 to 4096 bands"
            } else if !(self.low_hz >= 1.0 && self.low_hz < self.top_hz()) {
                "the lowest band must lie above 1 Hz and below the highest"
            } else if !(0.0..1.0).contains(&self.decay) {
                "the decay must lie in [0, 1)"
            } else if !(self.side_gain >= 0.0 && self.side_gain.is_finite()) {
                "the side's gain must not be negative"
            } else if matches!(self.level, Level::Fixed(gain) if !(gain >= 0.0 && gain.is_finite())) {
                "the fixed level must not be negative"
            } else {
                return Ok(());
            };
        Err(SoundError::Setting { what: complaint.to_owned() })
    }

    fn top_hz(&self) -> f32 {
        self.high_hz.min(0.45 * self.rate_hz as f32)
    }
}

/// Amplitudes of the bands. At fixed level 1, a sine of full scale has amplitude 1. At automatic level, 1
/// is the louder channel of the loudest band of the last two seconds of a loud passage.
#[derive(Debug, Default, PartialEq)]
pub struct Spectrum {
    /// Amplitudes of (left + right) / 2, one per band.
    pub mid: Vec<f32>,
    /// Amplitudes of (left − right) / 2, times the side's gain, one per band.
    pub side: Vec<f32>,
    /// Amplitudes of the left channel, one per band. (The magnitudes of mid and side alone do not distinguish left
    /// from right.)
    pub left: Vec<f32>,
    /// Amplitudes of the right channel, one per band.
    pub right: Vec<f32>,
    /// The gain by which `side` was multiplied.
    pub side_gain: f32,
}

impl Clone for Spectrum {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Keeps the memory, since each picture copies one.
    fn clone_from(&mut self, source: &Self) {
        let Self { mid, side, left, right, side_gain } = source;
        self.mid.clone_from(mid);
        self.side.clone_from(side);
        self.left.clone_from(left);
        self.right.clone_from(right);
        self.side_gain = *side_gain;
    }
}

impl Spectrum {
    fn silent(bands: usize) -> Self {
        let silence = vec![0.0; bands];
        let right = silence.clone();
        Self { mid: silence.clone(), side: silence.clone(), left: silence, right, side_gain: 1.0 }
    }

    /// Blends toward `other` by `weight` in [0, 1]. The squares are blended, which keeps the four
    /// amplitudes consistent with one pair of channels, and so is the gain of the side. Does nothing if `other`
    /// has another number of bands.
    pub fn mix(&mut self, other: &Self, weight: f32) {
        if self.side.len() != other.side.len() {
            return;
        }
        let side_gain = self.side_gain + weight * (other.side_gain - self.side_gain);
        // Both sides are brought to the gain in between.
        let [own_gain, other_gain] =
            [self.side_gain, other.side_gain].map(|gain| if gain > 0.0 { side_gain / gain } else { 0.0 });
        self.side_gain = side_gain;
        for (own, other, [own_gain, other_gain]) in [
            (&mut self.mid, &other.mid, [1.0; 2]),
            (&mut self.side, &other.side, [own_gain, other_gain]),
            (&mut self.left, &other.left, [1.0; 2]),
            (&mut self.right, &other.right, [1.0; 2]),
        ] {
            for (own, other) in own.iter_mut().zip(other) {
                let [from, to] = [own_gain * *own, other_gain * other].map(|amplitude| amplitude * amplitude);
                *own = (from + weight * (to - from)).max(0.0).sqrt();
            }
        }
    }
}

/// The decaying state of one band: the squares of its four amplitudes, each divided by the total amplitude
/// √(|L|² + |R|²).
///
/// The decay is linear in these values. Their sum therefore follows the total amplitude as the paper's f
/// follows its own, and the four stay consistent with one pair of channels: |S|² + |U|² = ½ (|L|² + |R|²)
/// for any mixture of moments. Magnitudes that decay separately would not have this property.
#[derive(Clone, Copy, Debug, Default)]
struct Followed {
    left: f32,
    right: f32,
    mid: f32,
    side: f32,
}

impl Followed {
    /// The state of one moment.
    fn of(left: f32, right: f32, mid: f32, side: f32) -> Self {
        let total = left.hypot(right);
        if total <= 0.0 {
            return Self::default();
        }
        let over = |amplitude: f32| amplitude * (amplitude / total);
        Self { left: over(left), right: over(right), mid: over(mid), side: over(side) }
    }

    /// Keeps the share `keep` of the state and takes the rest from `now`.
    fn follow(&mut self, now: Self, keep: f32) {
        let mix = |was: f32, is: f32| keep * was + (1.0 - keep) * is;
        self.left = mix(self.left, now.left);
        self.right = mix(self.right, now.right);
        self.mid = mix(self.mid, now.mid);
        self.side = mix(self.side, now.side);
    }

    /// The amplitude that belongs to one of the four values.
    fn amplitude(&self, part: f32) -> f32 {
        (part * (self.left + self.right)).sqrt()
    }
}

/// Computes spectra from windows of samples. The result depends only on the samples and times it was given;
/// an offline rendering therefore shows what was seen live.
///
/// [`analyze`](Self::analyze) does not allocate.
pub struct SpectrumAnalyzer {
    settings: SpectrumSettings,
    bands: Bands,
    fft: WindowedFft,
    left_bins: Vec<Complex<f32>>,
    right_bins: Vec<Complex<f32>>,
    power: Vec<f32>,
    /// The amplitudes of this frame before decay and level.
    fresh: Spectrum,
    followed: Vec<Followed>,
    spectrum: Spectrum,
    leveler: Leveler,
    /// The gain of each band.
    gains: Vec<f32>,
    lag_secs: f64,
}

impl SpectrumAnalyzer {
    /// Computes the window, the bands and the FFT plan.
    ///
    /// # Errors
    /// A setting is out of range.
    pub fn new(settings: SpectrumSettings) -> Result<Self, SoundError> {
        settings.check()?;
        let n = settings.window_frames;
        let fft = WindowedFft::new(n, 1.0);
        let bands = Bands::new(
            settings.front_end,
            settings.bands,
            f64::from(settings.low_hz),
            f64::from(settings.top_hz()),
            f64::from(settings.rate_hz),
            n,
        );
        let silence = Spectrum::silent(settings.bands);
        Ok(Self {
            bands,
            left_bins: fft.make_bins(),
            right_bins: fft.make_bins(),
            power: vec![0.0; n / 2 + 1],
            fft,
            fresh: silence.clone(),
            followed: vec![Followed::default(); settings.bands],
            spectrum: silence,
            leveler: Leveler::new(settings.bands, settings.loud),
            gains: vec![0.0; settings.bands],
            lag_secs: lag_secs(&settings),
            settings,
        })
    }

    /// The settings in use.
    pub fn settings(&self) -> &SpectrumSettings {
        &self.settings
    }

    /// How many frames [`analyze`](Self::analyze) uses.
    pub fn window_frames(&self) -> usize {
        self.settings.window_frames
    }

    /// Center of each band, in Hz.
    pub fn bands_hz(&self) -> &[f32] {
        &self.bands.centers_hz
    }

    /// The spectrum that was computed last.
    pub fn spectrum(&self) -> &Spectrum {
        &self.spectrum
    }

    /// Forgets level and decay, as after a seek or for a new song.
    pub fn reset(&mut self) {
        self.spectrum = Spectrum::silent(self.settings.bands);
        self.followed.fill(Followed::default());
        self.leveler = Leveler::new(self.settings.bands, self.settings.loud);
    }

    /// Takes other settings from the next window on, as a knob is turned while it listens. It keeps the level that it
    /// has followed, unless that of loud passages is known otherwise, and the spectrum where only decay, the side's
    /// gain or the kind of level differ.
    ///
    /// # Errors
    /// A setting is out of range; the earlier ones stay in use.
    pub fn retune(&mut self, settings: SpectrumSettings) -> Result<(), SoundError> {
        let SpectrumSettings { decay, side_gain, level, .. } = settings;
        if settings == (SpectrumSettings { decay, side_gain, level, ..self.settings.clone() }) {
            settings.check()?;
            self.lag_secs = lag_secs(&settings);
            self.settings = settings;
            return Ok(());
        }
        let before = std::mem::replace(self, Self::new(settings)?);
        if self.settings.loud == before.settings.loud {
            self.leveler.remember(before.leveler);
        }
        Ok(())
    }

    /// The delay, in seconds, from a click to the peak of its spectrum, caused by the decay. A window
    /// placed this much later than the moment being heard compensates for it.
    pub fn lag_secs(&self) -> f64 {
        self.lag_secs
    }

    /// Analyzes the last [`window_frames`](Self::window_frames) of `left` and `right`, `dt_secs` after the
    /// previous window; shorter slices are taken as preceded by silence. If the song is known ahead, center the
    /// window on the playback position; otherwise let it end there.
    ///
    /// Mid and side are combined as complex spectra, and then magnitudes are taken. Then, for each band,
    /// f ← w′ f + (1 − w′) f_new with w′ = w^(`dt_secs` / 50 ms): two steps of 25 ms do what one of 50 ms
    /// does. f is √(|L|² + |R|²); the four amplitudes are its shares.
    pub fn analyze(&mut self, left: &[f32], right: &[f32], dt_secs: f64) -> &Spectrum {
        let dt_secs = if dt_secs.is_finite() { dt_secs.max(0.0) } else { 0.0 };
        // The same moment of both: their ends are together.
        let count = left.len().min(right.len());
        self.fft.transform(&left[left.len() - count..], &mut self.left_bins);
        self.fft.transform(&right[right.len() - count..], &mut self.right_bins);
        let Self { bands, power, left_bins, right_bins, fresh, .. } = self;
        let mut amplitudes = |left_gain: f32, right_gain: f32, out: &mut [f32]| {
            for ((power, l), r) in power.iter_mut().zip(&*left_bins).zip(&*right_bins) {
                *power = (l * left_gain + r * right_gain).norm_sqr();
            }
            bands.amplitudes(power, out);
        };
        amplitudes(0.5, 0.5, &mut fresh.mid);
        amplitudes(0.5, -0.5, &mut fresh.side);
        amplitudes(1.0, 0.0, &mut fresh.left);
        amplitudes(0.0, 1.0, &mut fresh.right);
        let side_gain = self.level(dt_secs);
        let keep = f64::from(self.settings.decay).powf(dt_secs / DECAY_INTERVAL_SECS) as f32;
        let (fresh, spectrum) = (&self.fresh, &mut self.spectrum);
        spectrum.side_gain = side_gain;
        for (b, followed) in self.followed.iter_mut().enumerate() {
            let gain = self.gains[b];
            let [left, right, mid, side] =
                [&fresh.left, &fresh.right, &fresh.mid, &fresh.side].map(|amplitudes| gain * amplitudes[b]);
            followed.follow(Followed::of(left, right, mid, side), keep);
            spectrum.left[b] = followed.amplitude(followed.left);
            spectrum.right[b] = followed.amplitude(followed.right);
            spectrum.mid[b] = followed.amplitude(followed.mid);
            spectrum.side[b] = side_gain * followed.amplitude(followed.side);
        }
        &self.spectrum
    }

    /// Computes the gain of each band into `gains`. Returns the gain of the side.
    fn level(&mut self, dt_secs: f64) -> f32 {
        let Self { fresh, gains, leveler, settings, .. } = self;
        if let Level::Fixed(gain) = settings.level {
            gains.fill(gain);
            return settings.side_gain;
        }
        let louder = fresh.left.iter().zip(&fresh.right).map(|(l, r)| l.max(*r));
        gains.iter_mut().zip(louder).for_each(|(gain, amplitude)| *gain = amplitude);
        leveler.follow(gains, dt_secs);
        let side = fresh.side.iter().zip(&*gains).fold(0.0f32, |most, (u, gain)| most.max(u * gain));
        leveler.side_gain(side, settings.side_gain, dt_secs)
    }
}

/// Computes [`SpectrumAnalyzer::lag_secs`].
fn lag_secs(settings: &SpectrumSettings) -> f64 {
    if settings.decay <= 0.0 {
        return 0.0;
    }
    // Simulates a click that passes under the Hann window, with the decay applied.
    const STEPS: u32 = 1000;
    let half_secs = 0.5 * settings.window_frames as f64 / f64::from(settings.rate_hz);
    let step_secs = half_secs / f64::from(STEPS);
    let left = f64::from(settings.decay).powf(step_secs / DECAY_INTERVAL_SECS);
    let mut followed = 0.0;
    for step in 0..2 * STEPS {
        let heard = (std::f64::consts::PI * f64::from(step) / f64::from(2 * STEPS)).sin().powi(2);
        followed = left * followed + (1.0 - left) * heard;
        // The response peaks where it crosses the falling half of the window.
        if step > STEPS && followed >= heard {
            return f64::from(step - STEPS) * step_secs;
        }
    }
    half_secs
}
