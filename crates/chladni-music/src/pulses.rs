//! Pulses at places that should be evenly spaced.

use std::collections::VecDeque;

/// Places and times of pulses that should be evenly spaced, and the straight line through the last of them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pulses {
    /// The place of each, in whole steps, and its time in seconds.
    pulses: VecDeque<(f64, f64)>,
    /// At most this many are kept, and at least `least` are needed.
    most: usize,
    least: usize,
    /// A longer gap, for each step, begins anew.
    pub(crate) longest_gap_secs: f64,
}

impl Pulses {
    pub(crate) fn new(most: usize, least: usize, longest_gap_secs: f64) -> Self {
        Self { pulses: VecDeque::with_capacity(most), most, least, longest_gap_secs }
    }

    pub(crate) fn clear(&mut self) {
        self.pulses.clear();
    }

    /// When the last one came.
    pub(crate) fn last_secs(&self) -> Option<f64> {
        self.pulses.back().map(|(_, secs)| *secs)
    }

    /// Takes the next one; true where it begins anew after a gap.
    pub(crate) fn add(&mut self, secs: f64) -> bool {
        self.add_after(1.0, 1.0, secs)
    }

    /// Takes one that comes `steps` after the last; `least_steps` say how long the gap may be. True where it begins
    /// anew.
    pub(crate) fn add_after(&mut self, steps: f64, least_steps: f64, secs: f64) -> bool {
        let longest_gap_secs = least_steps * self.longest_gap_secs;
        let gap_secs = self.last_secs().map(|last_secs| secs - last_secs);
        let anew = gap_secs.is_some_and(|gap_secs| !(0.0..=longest_gap_secs).contains(&gap_secs));
        if anew {
            self.pulses.clear();
        }
        if self.pulses.len() == self.most {
            self.pulses.pop_front();
        }
        let place = self.pulses.back().map_or(0.0, |(place, _)| place + steps);
        self.pulses.push_back((place, secs));
        anew
    }

    /// Takes the last one again, at another time.
    pub(crate) fn put_again(&mut self, at_secs: f64) {
        if let Some((_, secs)) = self.pulses.back_mut() {
            *secs = at_secs;
        }
    }

    /// The places of the oldest one that is kept and of the last one, counted from the one with which they began.
    pub(crate) fn places(&self) -> Option<(f64, f64)> {
        Some((self.pulses.front()?.0, self.pulses.back()?.0))
    }

    /// Whether all lie within `share` of a step of the line; true without a line.
    pub(crate) fn are_even(&self, share: f64) -> bool {
        let (Some((due_secs, gap_secs)), Some((_, last_place))) = (self.line(), self.places()) else {
            return true;
        };
        let off = |&(place, secs): &(f64, f64)| (secs - due_secs - (place - last_place) * gap_secs).abs();
        self.pulses.iter().all(|pulse| off(pulse) <= share * gap_secs)
    }

    /// When the last pulse should have come, and the time of a step: least squares.
    pub(crate) fn line(&self) -> Option<(f64, f64)> {
        let count = self.pulses.len();
        let (last_place, last) = *self.pulses.back().filter(|_| count >= self.least.max(2))?;
        // From the last one backward, so that nothing large is subtracted.
        let pulses = || self.pulses.iter().map(|(place, secs)| (place - last_place, secs - last));
        let n = count as f64;
        let (mean_x, mean_y) = pulses().fold((0.0, 0.0), |(x, y), (i, t)| (x + i / n, y + t / n));
        let (xx, xy) = pulses().fold((0.0, 0.0), |(xx, xy), (i, t)| {
            (xx + (i - mean_x) * (i - mean_x), xy + (i - mean_x) * (t - mean_y))
        });
        let gap = xy / xx;
        Some((last + mean_y - gap * mean_x, gap))
    }
}
