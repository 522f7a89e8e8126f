//! The most recent samples, kept for analysis.

/// A stereo frame.
pub(crate) type Frame = [f32; 2];

/// The longest window that callers ask for.
const LONGEST_WINDOW: usize = 1 << 16;
/// The seconds that are kept: those written ahead of the playback position, and two that were
/// heard, for late readers.
const KEPT_SECS: usize = 3;

/// The last frames of a stream, addressed by their number.
pub(crate) struct History {
    frames: Vec<Frame>,
    written: u64,
}

impl History {
    /// The history of a stream at `rate_hz`.
    pub fn new(rate_hz: u32) -> Self {
        Self { frames: vec![[0.0; 2]; LONGEST_WINDOW + KEPT_SECS * rate_hz as usize], written: 0 }
    }

    /// How many frames have been written.
    pub fn written(&self) -> u64 {
        self.written
    }

    pub fn push(&mut self, frame: Frame) {
        let at = self.place(self.written);
        self.frames[at] = frame;
        self.written += 1;
    }

    fn place(&self, frame: u64) -> usize {
        (frame % self.frames.len() as u64) as usize
    }

    /// Copies frames `end − left.len()` to `end`; frames that are not kept are silence.
    pub fn window(&self, end: i64, left: &mut [f32], right: &mut [f32]) {
        let start = end - left.len() as i64;
        for (i, (l, r)) in left.iter_mut().zip(right).enumerate() {
            let at = u64::try_from(start + i as i64).ok();
            let kept = self.frames.len() as u64;
            let known = at.filter(|&at| at < self.written && at + kept >= self.written);
            [*l, *r] = known.map_or([0.0; 2], |at| self.frames[self.place(at)]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_seconds_are_there_while_a_whole_ring_lies_ahead_at_any_rate() {
        for rate_hz in [8_000, 48_000, 192_000, 768_000] {
            let mut history = History::new(rate_hz);
            let second = rate_hz as usize;
            for n in 0..5 * second {
                history.push([n as f32, -(n as f32)]);
            }
            // The playback position may be up to a ring's length behind the newest frame.
            let (mut left, mut right) = (vec![0.0; 2 * second], vec![0.0; 2 * second]);
            history.window(4 * second as i64, &mut left, &mut right);
            let first = 2 * second;
            let known =
                (0..2 * second).all(|i| [left[i], right[i]] == [(first + i) as f32, -((first + i) as f32)]);
            assert!(known, "{rate_hz} Hz");
        }
    }
}
