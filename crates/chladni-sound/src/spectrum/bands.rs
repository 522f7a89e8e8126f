//! Frequency bands: their places, and the weight of each FFT bin in them.

/// How the bands ω are placed on the frequency axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FrontEnd {
    /// Equal steps in Hz, as in the paper.
    Linear,
    /// Equal steps in pitch (constant Q where the window is long enough).
    LogBands,
}

/// Half the width of a band, in steps from band to band. At 2, the raised cosines of neighboring bands
/// overlap by three quarters. A tone halfway between two bands is only 0.7 dB lower in both, and nothing
/// jumps while it glides.
const HALF_WIDTH_STEPS: f64 = 2.0;
/// The smallest half width of a band, in bins: the main lobe of a Hann window is ±2 bins.
const MIN_HALF_WIDTH_BINS: f64 = 2.5;

/// The bands of one analyzer, over the bins of one FFT.
pub(super) struct Bands {
    pub centers_hz: Vec<f32>,
    /// First bin of each band, and where its weights begin in `weights`.
    starts: Vec<(usize, usize)>,
    weights: Vec<f32>,
}

impl Bands {
    /// `count` bands from `low_hz` to `high_hz` over an FFT of `window` samples at `rate_hz`.
    pub fn new(
        front_end: FrontEnd,
        count: usize,
        low_hz: f64,
        high_hz: f64,
        rate_hz: f64,
        window: usize,
    ) -> Self {
        let bin_hz = rate_hz / window as f64;
        let steps = (count.max(2) - 1) as f64;
        let ratio = (high_hz / low_hz).powf(1.0 / steps);
        let step = (high_hz - low_hz) / steps;
        let mut bands = Self {
            centers_hz: Vec::with_capacity(count),
            starts: Vec::with_capacity(count + 1),
            weights: Vec::new(),
        };
        for k in 0..count {
            let (center, below, above) = match front_end {
                FrontEnd::Linear => (low_hz + k as f64 * step, step, step),
                FrontEnd::LogBands => {
                    let center = low_hz * ratio.powi(k as i32);
                    // The band is symmetric in pitch, and therefore not in Hz.
                    let reach = ratio.powf(HALF_WIDTH_STEPS);
                    let below = center * (1.0 - 1.0 / reach) / HALF_WIDTH_STEPS;
                    (center, below, center * (reach - 1.0) / HALF_WIDTH_STEPS)
                }
            };
            let bins = |hz: f64| (HALF_WIDTH_STEPS * hz / bin_hz).max(MIN_HALF_WIDTH_BINS);
            bands.push(center / bin_hz, bins(below), bins(above), window / 2);
            bands.centers_hz.push(center as f32);
        }
        bands.starts.push((0, bands.weights.len()));
        bands
    }

    /// One band: raised-cosine weights around `center`, scaled so that a sine of amplitude 1
    /// at the center gives 1.
    fn push(&mut self, center: f64, below: f64, above: f64, last_bin: usize) {
        // Bin 0 holds the mean, which is inaudible.
        let first = ((center - below).ceil().max(1.0) as usize).min(last_bin);
        let last = ((center + above).floor() as usize).clamp(first, last_bin);
        self.starts.push((first, self.weights.len()));
        let from = self.weights.len();
        let mut response = 0.0;
        for bin in first..=last {
            let off = bin as f64 - center;
            let reach = if off < 0.0 { below } else { above };
            let weight = 0.5 * (1.0 + (std::f64::consts::PI * (off / reach).clamp(-1.0, 1.0)).cos());
            response += weight * hann_lobe(off).powi(2);
            self.weights.push(weight as f32);
        }
        let scale = if response > 0.0 { 1.0 / response } else { 0.0 };
        for weight in &mut self.weights[from..] {
            *weight *= scale as f32;
        }
    }

    /// Amplitude of each band from the power of each bin.
    pub fn amplitudes(&self, power: &[f32], out: &mut [f32]) {
        for ((pair, value), _) in self.starts.windows(2).zip(out.iter_mut()).zip(&self.centers_hz) {
            let (first, from) = pair[0];
            let weights = &self.weights[from..pair[1].1];
            let sum: f32 = weights.iter().zip(&power[first..]).map(|(w, p)| w * p).sum();
            *value = sum.sqrt();
        }
    }
}

/// Amplitude that a unit sine `off` bins away gives in a bin under a Hann window.
fn hann_lobe(off: f64) -> f64 {
    let x = std::f64::consts::PI * off;
    if off.abs() < 1e-9 {
        1.0
    } else if (off.abs() - 1.0).abs() < 1e-9 {
        0.5
    } else {
        x.sin() / (x * (1.0 - off * off))
    }
}
