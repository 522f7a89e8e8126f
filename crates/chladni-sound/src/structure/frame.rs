//! Features of a short moment: pitch classes, bass, timbre and power.

use realfft::num_complex::Complex;

use crate::SoundError;
use crate::windowed::{SlidingWindow, WindowedFft, window_frames};

/// Frames per second.
pub(super) const FRAME_RATE_HZ: f64 = 20.0;
/// Long enough to resolve the notes of a bass.
pub(super) const WINDOW_SECS: f64 = 0.186;
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
    fft: WindowedFft,
    bins: Vec<Complex<f32>>,
    sliding: SlidingWindow,
}

impl FrameReader {
    pub fn new(rate_hz: u32) -> Result<Self, SoundError> {
        crate::check_rate("structure", rate_hz)?;
        let rate = f64::from(rate_hz);
        let n = window_frames(rate, WINDOW_SECS);
        let fft = WindowedFft::new(n, 0.5);
        let sliding = SlidingWindow::new(rate, FRAME_RATE_HZ, n);
        Ok(Self { rate_hz: rate, bins: fft.make_bins(), fft, sliding })
    }

    /// How much sound after its time a frame needs, in seconds.
    pub fn latency_secs(&self) -> f64 {
        self.sliding.latency_secs()
    }

    /// Takes the next samples and appends the frames that are now complete.
    pub fn push(&mut self, left: &[f32], right: &[f32], out: &mut Vec<Frame>) {
        self.sliding.push(left, right);
        let per_bin_hz = self.rate_hz / self.fft.window_frames() as f64;
        while let Some(channels) = self.sliding.next() {
            let mut frame = Frame::default();
            for heard in channels {
                self.fft.transform(heard, &mut self.bins);
                frame.add(&self.bins, per_bin_hz);
            }
            out.push(frame);
        }
    }
}

impl Frame {
    /// Adds the sound of one channel, by the bins of its transform.
    fn add(&mut self, bins: &[Complex<f32>], per_bin_hz: f64) {
        for (k, bin) in bins.iter().enumerate().skip(2) {
            let (hz, power) = (k as f64 * per_bin_hz, bin.norm_sqr());
            let octave = (hz / LOWEST_HZ).log2().max(0.0) as usize;
            self.octaves[octave.min(OCTAVES - 1)] += power;
            self.power += 0.5 * power;
            if hz < HARMONY_HZ {
                let class = (12.0 * (hz / 440.0).log2()).round().rem_euclid(12.0) as usize % CLASSES;
                let notes = if hz < BASS_HZ { &mut self.bass } else { &mut self.chroma };
                notes[class] += power.sqrt();
            }
        }
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
