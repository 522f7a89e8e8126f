//! Converts a stream of stereo samples to another rate.

use rubato::audioadapter_buffers::direct::InterleavedSlice;
use rubato::{Fft, FixedSync, Indexing, Resampler};

use crate::SoundError;

/// How many frames are given to the resampler at once.
const CHUNK_FRAMES: usize = 1024;

/// Converts interleaved stereo from one rate to another by FFT, without delay: output frame n
/// is heard at the time n / `to_hz`, and n input frames give ⌈n · `to_hz` / `from_hz`⌉.
pub struct StereoResampler {
    from_hz: u32,
    to_hz: u32,
    /// `None` if both rates are the same.
    fft: Option<Fft<f32>>,
    waiting: Vec<f32>,
    chunk: Vec<f32>,
    delay_left: usize,
    frames_in: u64,
    frames_out: u64,
}

impl StereoResampler {
    /// A resampler from `from_hz` to `to_hz`, both in [[`MIN_RATE_HZ`](crate::MIN_RATE_HZ),
    /// [`MAX_RATE_HZ`](crate::MAX_RATE_HZ)].
    ///
    /// # Errors
    /// A rate outside this range.
    pub fn new(from_hz: u32, to_hz: u32) -> Result<Self, SoundError> {
        for rate_hz in [from_hz, to_hz] {
            crate::check_rate("resampler", rate_hz)?;
        }
        let fft = if from_hz == to_hz {
            None
        } else {
            let fft = Fft::new(from_hz as usize, to_hz as usize, CHUNK_FRAMES, 2, FixedSync::Input).map_err(
                |error| SoundError::Setting {
                    what: format!("cannot resample from {from_hz} to {to_hz} Hz: {error}"),
                },
            )?;
            Some(fft)
        };
        let (delay_left, chunk) = match &fft {
            Some(fft) => (fft.output_delay(), vec![0.0; 2 * fft.output_frames_max()]),
            None => (0, Vec::new()),
        };
        Ok(Self { from_hz, to_hz, fft, waiting: Vec::new(), chunk, delay_left, frames_in: 0, frames_out: 0 })
    }

    /// The rate of what it takes.
    pub fn from_hz(&self) -> u32 {
        self.from_hz
    }

    /// How many frames [`finish`](Self::finish) would append now.
    pub fn pending_frames(&self) -> u64 {
        self.due().saturating_sub(self.frames_out)
    }

    /// How many frames all that was taken gives.
    fn due(&self) -> u64 {
        (self.frames_in * u64::from(self.to_hz)).div_ceil(u64::from(self.from_hz))
    }

    /// Takes interleaved stereo samples and appends those that are ready to `out`.
    ///
    /// # Errors
    /// Only an internal error of the transform.
    pub fn process(&mut self, interleaved: &[f32], out: &mut Vec<f32>) -> Result<(), SoundError> {
        self.frames_in += (interleaved.len() / 2) as u64;
        if self.fft.is_none() {
            out.extend_from_slice(interleaved);
            self.frames_out = self.frames_in;
            return Ok(());
        }
        self.waiting.extend_from_slice(interleaved);
        self.drain(out)
    }

    /// Ends the stream: appends the remaining frames. Then the resampler can be used for another stream.
    ///
    /// # Errors
    /// Only an internal error of the transform.
    pub fn finish(&mut self, out: &mut Vec<f32>) -> Result<(), SoundError> {
        let due = self.due();
        // The transform spans at most two seconds of input: that much silence flushes it.
        let mut chunks_left = 8 + 2 * self.from_hz as usize / CHUNK_FRAMES;
        while self.fft.is_some() && self.frames_out < due && chunks_left > 0 {
            chunks_left -= 1;
            self.waiting.resize(self.waiting.len() + 2 * CHUNK_FRAMES, 0.0);
            self.drain(out)?;
        }
        let excess = self.frames_out.saturating_sub(due) as usize;
        out.truncate(out.len().saturating_sub(2 * excess));
        self.reset();
        Ok(())
    }

    /// Forgets the stream, as after a seek.
    pub fn reset(&mut self) {
        self.waiting.clear();
        self.frames_in = 0;
        self.frames_out = 0;
        if let Some(fft) = &mut self.fft {
            fft.reset();
            self.delay_left = fft.output_delay();
        }
    }

    fn drain(&mut self, out: &mut Vec<f32>) -> Result<(), SoundError> {
        let Some(fft) = &mut self.fft else { return Ok(()) };
        let failed = |what: String| SoundError::Setting { what: format!("resampler: {what}") };
        let mut start = 0;
        loop {
            let need = fft.input_frames_next();
            let Some(input) = self.waiting.get(start..start + 2 * need) else { break };
            let input = InterleavedSlice::new(input, 2, need).map_err(|e| failed(e.to_string()))?;
            let capacity = self.chunk.len() / 2;
            let mut output =
                InterleavedSlice::new_mut(&mut self.chunk, 2, capacity).map_err(|e| failed(e.to_string()))?;
            let (_, written) = fft
                .process_into_buffer(&input, &mut output, Some(&Indexing::new()))
                .map_err(|e| failed(e.to_string()))?;
            start += 2 * need;
            let skipped = self.delay_left.min(written);
            self.delay_left -= skipped;
            out.extend_from_slice(&self.chunk[2 * skipped..2 * written]);
            self.frames_out += (written - skipped) as u64;
        }
        self.waiting.drain(..start);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sine_keeps_its_pitch_level_and_time() {
        // The rates of the last pair have no common factor: its filter has an odd number of frames and is
        // therefore half a frame (10 µs) off.
        for (from_hz, to_hz, most) in
            [(44_100, 48_000, 1e-4), (48_000, 44_100, 1e-4), (22_050, 44_100, 1e-4), (44_101, 48_000, 0.04)]
        {
            // Faded in and out: a tone that starts abruptly has frequencies beyond both rates.
            let wave = |n: usize, rate_hz: u32| {
                let t = n as f64 / f64::from(rate_hz);
                let fade = (std::f64::consts::PI * t).sin().powi(2);
                (0.5 * fade * (std::f64::consts::TAU * 1000.0 * t).sin()) as f32
            };
            let input: Vec<f32> =
                (0..from_hz as usize).flat_map(|n| [wave(n, from_hz), -wave(n, from_hz)]).collect();
            let mut resampler = StereoResampler::new(from_hz, to_hz).unwrap();
            let mut out = Vec::new();
            for block in input.chunks(2 * 777) {
                resampler.process(block, &mut out).unwrap();
            }
            resampler.finish(&mut out).unwrap();
            assert_eq!(out.len(), 2 * to_hz as usize, "{from_hz} to {to_hz}");
            for n in 0..to_hz as usize {
                let truth = wave(n, to_hz);
                assert!((out[2 * n] - truth).abs() < most, "{from_hz} to {to_hz} at {n}");
                assert!((out[2 * n + 1] + truth).abs() < most);
            }
        }
    }
}
