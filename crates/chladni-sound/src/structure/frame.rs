//! Features of a short moment: pitch classes, bass, timbre and power.

use std::sync::Arc;

use realfft::num_complex::Complex;
use realfft::{RealFftPlanner, RealToComplex};

use crate::SoundError;

/// Frames per second.
pub(super) const FRAME_RATE_HZ: f64 = 20.0;
/// Long enough to resolve the notes of a bass.
const WINDOW_SECS: f64 = 0.186;
pub(super) const CLASSES: usize = 12;
/// The number of octave bands, from 62.5 Hz on. The first also holds everything below, the last everything
/// above.
pub(super) const OCTAVES: usize = 9;
const LOWEST_HZ: f64 = 62.5;
/// Notes below the first are the bass; harmony is analyzed up to the second.
const BASS_HZ: f64 = 260.0;
const HARMONY_HZ: f64 = 2100.0;

/// A moment of the song.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Frame {
    /// Magnitude of each pitch class.
    pub chroma: [f32; CLASSES],
    /// Magnitude of each pitch class in the bass.
    pub bass: [f32; CLASSES],
    /// Power of each octave.
    pub octaves: [f32; OCTAVES],
    /// Mean square of both channels.
    pub power: f32,
}

/// Computes the frames of a stream. Frame n belongs to the time n / [`FRAME_RATE_HZ`].
pub(super) struct FrameReader {
    rate_hz: f64,
    fft: Arc<dyn RealToComplex<f32>>,
    window: Vec<f32>,
    input: Vec<f32>,
    bins: Vec<Complex<f32>>,
    scratch: Vec<Complex<f32>>,
    channels: [Vec<f32>; 2],
    /// Number of the first sample that is kept.
    kept_from: i64,
    done: u64,
}

impl FrameReader {
    pub fn new(rate_hz: u32) -> Result<Self, SoundError> {
        crate::check_rate("structure", rate_hz)?;
        let rate = f64::from(rate_hz);
        let n = ((rate * WINDOW_SECS) as usize).next_power_of_two();
        let n = if n as f64 > 1.5 * rate * WINDOW_SECS { n / 2 } else { n }.max(64);
        let fft = RealFftPlanner::new().plan_fft_forward(n);
        let hann = |i: usize| 0.5 - 0.5 * (std::f64::consts::TAU * i as f64 / n as f64).cos();
        // Before the first sample there is silence.
        let silence = vec![0.0; n / 2];
        Ok(Self {
            rate_hz: rate,
            window: (0..n).map(|i| (hann(i) * 2.0 / n as f64) as f32).collect(),
            input: fft.make_input_vec(),
            bins: fft.make_output_vec(),
            scratch: fft.make_scratch_vec(),
            fft,
            channels: [silence.clone(), silence],
            kept_from: -(n as i64) / 2,
            done: 0,
        })
    }

    /// How much sound after its time a frame needs, in seconds.
    pub fn latency_secs(&self) -> f64 {
        0.5 * self.window.len() as f64 / self.rate_hz
    }

    /// Takes the next samples and appends the frames that are now complete.
    pub fn push(&mut self, left: &[f32], right: &[f32], out: &mut Vec<Frame>) {
        let count = left.len().min(right.len());
        self.channels[0].extend_from_slice(&left[..count]);
        self.channels[1].extend_from_slice(&right[..count]);
        let n = self.window.len();
        loop {
            let center = (self.done as f64 * self.rate_hz / FRAME_RATE_HZ).round() as i64;
            let start = (center - n as i64 / 2 - self.kept_from) as usize;
            if start + n > self.channels[0].len() {
                break;
            }
            let frame = self.frame(start);
            out.push(frame);
            self.done += 1;
            if start > 4 * n {
                self.channels.iter_mut().for_each(|channel| drop(channel.drain(..start)));
                self.kept_from += start as i64;
            }
        }
    }

    fn frame(&mut self, start: usize) -> Frame {
        let mut frame = Frame::default();
        let per_bin_hz = self.rate_hz / self.window.len() as f64;
        for channel in &self.channels {
            let heard = &channel[start..start + self.window.len()];
            for ((to, from), w) in self.input.iter_mut().zip(heard).zip(&self.window) {
                *to = if from.is_finite() { from * w } else { 0.0 };
            }
            let done = self.fft.process_with_scratch(&mut self.input, &mut self.bins, &mut self.scratch);
            debug_assert!(done.is_ok(), "the buffers were made by this plan");
            for (k, bin) in self.bins.iter().enumerate().skip(2) {
                let (hz, power) = (k as f64 * per_bin_hz, bin.norm_sqr());
                let octave = (hz / LOWEST_HZ).log2().max(0.0) as usize;
                frame.octaves[octave.min(OCTAVES - 1)] += power;
                frame.power += 0.5 * power;
                if hz < HARMONY_HZ {
                    let class = (12.0 * (hz / 440.0).log2()).round().rem_euclid(12.0) as usize % CLASSES;
                    let notes = if hz < BASS_HZ { &mut frame.bass } else { &mut frame.chroma };
                    notes[class] += power.sqrt();
                }
            }
        }
        frame
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_note_is_its_class_whatever_its_octave_and_however_it_is_cut() {
        for (hz, bass) in [(110.0f32, true), (440.0, false), (880.0, false)] {
            let tone: Vec<f32> =
                (0..44_100).map(|n| (std::f32::consts::TAU * hz * n as f32 / 44_100.0).sin()).collect();
            let mut whole = Vec::new();
            FrameReader::new(44_100).unwrap().push(&tone, &tone, &mut whole);
            let mut pieces = Vec::new();
            let mut reader = FrameReader::new(44_100).unwrap();
            tone.chunks(777).for_each(|piece| reader.push(piece, piece, &mut pieces));
            assert_eq!(whole, pieces);
            let frame = &whole[10];
            let notes = if bass { &frame.bass } else { &frame.chroma };
            let loudest = (0..CLASSES).max_by(|&a, &b| notes[a].total_cmp(&notes[b])).unwrap();
            assert_eq!(loudest, 0, "{hz} Hz: {notes:?}");
        }
    }
}
