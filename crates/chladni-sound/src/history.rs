//! The last samples, for analysis.

/// A stereo frame.
pub(crate) type Frame = [f32; 2];

/// Frames kept: 2.7 s at 48 kHz, more than a ring and the longest window together.
const KEPT: usize = 1 << 17;

/// The last frames of a stream, by their number.
pub(crate) struct History {
    frames: Vec<Frame>,
    written: u64,
}

impl History {
    pub fn new() -> Self {
        Self { frames: vec![[0.0; 2]; KEPT], written: 0 }
    }

    /// How many frames there have been.
    pub fn written(&self) -> u64 {
        self.written
    }

    /// Numbers begin at 0 again.
    pub fn restart(&mut self) {
        self.frames.fill([0.0; 2]);
        self.written = 0;
    }

    pub fn push(&mut self, frame: Frame) {
        self.frames[(self.written % KEPT as u64) as usize] = frame;
        self.written += 1;
    }

    /// Frames `end − left.len()` to `end`; silence where there is none (any more).
    pub fn window(&self, end: i64, left: &mut [f32], right: &mut [f32]) {
        let start = end - left.len() as i64;
        for (i, (l, r)) in left.iter_mut().zip(right).enumerate() {
            let at = u64::try_from(start + i as i64).ok();
            let known = at.filter(|&at| at < self.written && at + KEPT as u64 > self.written);
            [*l, *r] = known.map_or([0.0; 2], |at| self.frames[(at % KEPT as u64) as usize]);
        }
    }
}
