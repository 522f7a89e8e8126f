//! Windowed transforms of samples, and the windows that slide over a stream of them.

use std::sync::Arc;

use realfft::num_complex::Complex;
use realfft::{RealFftPlanner, RealToComplex};

/// The loudest sample that counts as sound, 120 dB above full scale; damaged files have others, whose squares would
/// overflow.
pub(crate) const LOUDEST: f32 = 1e6;

/// The sample, or silence where it is NaN or louder than [`LOUDEST`].
pub(crate) fn sounding(sample: f32) -> f32 {
    if sample.abs() <= LOUDEST { sample } else { 0.0 }
}

/// The transform of real samples under a Hann window.
pub(crate) struct WindowedFft {
    fft: Arc<dyn RealToComplex<f32>>,
    window: Vec<f32>,
    samples: Vec<f32>,
    scratch: Vec<Complex<f32>>,
}

impl WindowedFft {
    /// For `n` samples, scaled so that a sine of amplitude 1 on a bin has the magnitude `gain` there.
    pub fn new(n: usize, gain: f64) -> Self {
        let fft = RealFftPlanner::new().plan_fft_forward(n);
        let phase_rad = |i: usize| std::f64::consts::TAU * i as f64 / n as f64;
        Self {
            // The mean of the Hann window is ½, and half of a sine's power is at positive frequencies.
            window: (0..n)
                .map(|i| (0.5 * (1.0 - phase_rad(i).cos()) * 4.0 * gain / n as f64) as f32)
                .collect(),
            samples: fft.make_input_vec(),
            scratch: fft.make_scratch_vec(),
            fft,
        }
    }

    /// How many samples it takes.
    pub fn window_frames(&self) -> usize {
        self.window.len()
    }

    /// Room for what [`transform`](Self::transform) finds.
    pub fn make_bins(&self) -> Vec<Complex<f32>> {
        self.fft.make_output_vec()
    }

    /// The transform of the last samples of `heard`, preceded by silence where there are too few. Samples louder than
    /// [`LOUDEST`] or NaN count as silence. Does not allocate.
    pub fn transform(&mut self, heard: &[f32], bins: &mut [Complex<f32>]) {
        let n = self.window.len();
        let have = heard.len().min(n);
        self.samples[..n - have].fill(0.0);
        let tail = self.samples[n - have..].iter_mut().zip(&self.window[n - have..]);
        for ((sample, w), x) in tail.zip(&heard[heard.len() - have..]) {
            *sample = w * sounding(*x);
        }
        let done = self.fft.process_with_scratch(&mut self.samples, bins, &mut self.scratch);
        debug_assert!(done.is_ok(), "the buffers were made by this plan");
    }
}

/// The power of two of samples that is nearest to a time, at least 64.
pub(crate) fn window_frames(rate_hz: f64, secs: f64) -> usize {
    let n = ((rate_hz * secs) as usize).next_power_of_two();
    if n as f64 > 1.5 * rate_hz * secs { n / 2 } else { n }.max(64)
}

/// A window that slides over a stream in even steps. Its center is at the times 0, 1 / `steps_hz`, 2 / `steps_hz` …, and
/// before the first sample there is silence.
pub(crate) struct SlidingWindow {
    rate_hz: f64,
    steps_hz: f64,
    window_frames: usize,
    channels: [Vec<f32>; 2],
    /// Number of the first sample that is kept.
    kept_from: i64,
    done: u64,
}

impl SlidingWindow {
    pub fn new(rate_hz: f64, steps_hz: f64, window_frames: usize) -> Self {
        let silence = vec![0.0; window_frames / 2];
        Self {
            rate_hz,
            steps_hz,
            window_frames,
            channels: [silence.clone(), silence],
            kept_from: -(window_frames as i64) / 2,
            done: 0,
        }
    }

    /// How much sound after its time a window needs, in seconds.
    pub fn latency_secs(&self) -> f64 {
        0.5 * self.window_frames as f64 / self.rate_hz
    }

    /// Takes the next samples.
    pub fn push(&mut self, left: &[f32], right: &[f32]) {
        let count = left.len().min(right.len());
        self.channels[0].extend_from_slice(&left[..count]);
        self.channels[1].extend_from_slice(&right[..count]);
    }

    /// Left and right under the next window, where all of its samples are there.
    pub fn next(&mut self) -> Option<[&[f32]; 2]> {
        let n = self.window_frames;
        let center = (self.done as f64 * self.rate_hz / self.steps_hz).round() as i64;
        let mut start = (center - n as i64 / 2 - self.kept_from) as usize;
        if start + n > self.channels[0].len() {
            return None;
        }
        // Moving the rest to the front now and then is cheaper than after every window.
        if start > 8 * n {
            self.channels.iter_mut().for_each(|channel| drop(channel.drain(..start)));
            self.kept_from += start as i64;
            start = 0;
        }
        self.done += 1;
        Some(self.channels.each_ref().map(|channel| &channel[start..start + n]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_sine_on_a_bin_has_the_gain_as_its_magnitude() {
        for gain in [1.0, 0.5] {
            let mut fft = WindowedFft::new(256, gain);
            let sine: Vec<f32> =
                (0..256).map(|i| (std::f32::consts::TAU * 10.0 * i as f32 / 256.0).sin()).collect();
            let mut bins = fft.make_bins();
            fft.transform(&sine, &mut bins);
            assert!((f64::from(bins[10].norm()) - gain).abs() < 1e-5, "{}", bins[10].norm());
        }
    }

    #[test]
    fn too_few_samples_are_preceded_by_silence_and_what_is_not_finite_is_silence() {
        let mut fft = WindowedFft::new(64, 1.0);
        let (mut short, mut long) = (fft.make_bins(), fft.make_bins());
        fft.transform(&[0.5, f32::NAN, 0.25], &mut short);
        let mut padded = [0.0; 64];
        padded[61..].copy_from_slice(&[0.5, 0.0, 0.25]);
        fft.transform(&padded, &mut long);
        assert_eq!(short, long);
    }

    #[test]
    fn windows_stand_where_their_times_say_however_the_stream_is_cut() {
        // 30 steps a second of 1,000 samples: a third of a sample is left over each time.
        let samples: Vec<f32> = (0..3000).map(|i| i as f32).collect();
        for piece in [1, 7, 3000] {
            let mut sliding = SlidingWindow::new(1000.0, 30.0, 64);
            let mut step = 0;
            for part in samples.chunks(piece) {
                sliding.push(part, part);
                while let Some([left, right]) = sliding.next() {
                    let center = (f64::from(step) * 1000.0 / 30.0).round() as i64;
                    let due = |i: i64| (center - 32 + i).max(0) as f32;
                    assert_eq!((left[0], left[63]), (due(0), due(63)), "step {step}");
                    assert_eq!(left, right);
                    step += 1;
                }
            }
            // The last that fits has its center at 2,967.
            assert_eq!(step, 90, "pieces of {piece}");
        }
    }
}
