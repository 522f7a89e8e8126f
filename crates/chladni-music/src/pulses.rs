//! Pulses that should be evenly spaced.

use std::collections::VecDeque;

/// Times of pulses that should be evenly spaced, and the straight line through the last of them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pulses {
    pub(crate) secs: VecDeque<f64>,
    /// At most this many are kept, and at least `least` are needed.
    most: usize,
    least: usize,
    /// A longer gap begins anew.
    pub(crate) longest_gap_secs: f64,
}

impl Pulses {
    pub(crate) fn new(most: usize, least: usize, longest_gap_secs: f64) -> Self {
        Self { secs: VecDeque::with_capacity(most), most, least, longest_gap_secs }
    }

    /// Takes one; true where it begins anew after a gap.
    pub(crate) fn add(&mut self, secs: f64) -> bool {
        let gap = self.secs.back().map(|last| secs - last);
        let anew = gap.is_some_and(|gap| !(0.0..=self.longest_gap_secs).contains(&gap));
        if anew {
            self.secs.clear();
        }
        if self.secs.len() == self.most {
            self.secs.pop_front();
        }
        self.secs.push_back(secs);
        anew
    }

    /// When the last pulse should have come, and the time between two: least squares.
    pub(crate) fn line(&self) -> Option<(f64, f64)> {
        let count = self.secs.len();
        let last = *self.secs.back().filter(|_| count >= self.least.max(2))?;
        // Numbered from the last one backward, so that nothing large is subtracted.
        let at = |i: usize| (i as f64 - (count - 1) as f64, self.secs[i] - last);
        let n = count as f64;
        let (mean_x, mean_y) = (0..count).map(at).fold((0.0, 0.0), |(x, y), (i, t)| (x + i / n, y + t / n));
        let (xx, xy) = (0..count).map(at).fold((0.0, 0.0), |(xx, xy), (i, t)| {
            (xx + (i - mean_x) * (i - mean_x), xy + (i - mean_x) * (t - mean_y))
        });
        let gap = xy / xx;
        Some((last + mean_y - gap * mean_x, gap))
    }
}
