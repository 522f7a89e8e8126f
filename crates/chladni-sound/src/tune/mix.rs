//! A mixer: adds notes to two channels and limits the result.

use crate::Song;

/// Two channels that notes are added to.
pub(super) struct Mix {
    song: Song,
}

impl Mix {
    /// A silent mix of `secs` seconds.
    pub fn new(rate_hz: u32, secs: f64) -> Self {
        let silence = vec![0.0; (secs * f64::from(rate_hz)).ceil() as usize];
        Self { song: Song { rate_hz, left: silence.clone(), right: silence } }
    }

    /// Adds `secs` seconds of a voice at a time. `pan` runs from −1 (left) to 1 (right) at constant power.
    pub fn add(&mut self, at_secs: f64, secs: f64, pan: f32, gain: f32, mut voice: impl FnMut(f32) -> f32) {
        let rate_hz = f64::from(self.song.rate_hz);
        let start = (at_secs * rate_hz).round() as usize;
        let end = (start + (secs * rate_hz) as usize).min(self.song.frames());
        let angle = (pan + 1.0) * std::f32::consts::FRAC_PI_4;
        let (left, right) = (gain * angle.cos(), gain * angle.sin());
        for n in start..end {
            // The last 5 ms fade out: no note ends in a click.
            let fade = ((end - n) as f32 / (0.005 * rate_hz as f32)).min(1.0);
            let sample = fade * voice((n - start) as f32 / rate_hz as f32);
            self.song.left[n] += left * sample;
            self.song.right[n] += right * sample;
        }
    }

    /// The mix after a soft limiter: tanh compresses loud samples and never reaches 1.
    pub fn finish(mut self) -> Song {
        for sample in self.song.left.iter_mut().chain(&mut self.song.right) {
            *sample = 0.95 * (1.25 * *sample).tanh();
        }
        self.song
    }
}
