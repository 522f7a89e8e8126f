//! Photosensitive safety: how many flashes a second, and a limiter that keeps them at three.
//!
//! WCAG 2.3.1 counts a general flash as a pair of opposing changes in relative luminance of
//! at least 0.1, where the darker of the two is below 0.8. At most three may fall into any
//! one second.

use std::collections::VecDeque;

/// The change of relative luminance that counts.
pub const FLASH_STEP: f32 = 0.1;
/// The darker state of a flash lies below this.
pub const FLASH_DARK: f32 = 0.8;
/// Flashes allowed in any one second.
pub const MAX_FLASHES: usize = 3;

/// How many flashes fall into the worst second of `luminances` (relative, [0, 1]), taken at
/// `times_secs`.
pub fn most_flashes_per_second(times_secs: &[f64], luminances: &[f32]) -> usize {
    let mut worst = WorstSecond::default();
    times_secs.iter().zip(luminances).for_each(|(&t, &l)| worst.show(t, l));
    worst.flashes()
}

/// Counts the flashes of a luminance as it comes, and keeps no more of it than a second.
#[derive(Clone, Debug)]
pub(crate) struct WorstSecond {
    swings: Swings,
    /// Times of the changes within the last second.
    edges_secs: VecDeque<f64>,
    most_edges: usize,
}

impl Default for WorstSecond {
    fn default() -> Self {
        Self { swings: Swings::of(FLASH_STEP, FLASH_DARK), edges_secs: VecDeque::new(), most_edges: 0 }
    }
}

impl WorstSecond {
    /// Takes the luminance at `time_secs`.
    pub(crate) fn show(&mut self, time_secs: f64, luminance: f32) {
        if self.swings.push(luminance) {
            while self.edges_secs.pop_front_if(|edge_secs| time_secs - *edge_secs > 1.0).is_some() {}
            self.edges_secs.push_back(time_secs);
            self.most_edges = self.most_edges.max(self.edges_secs.len());
        }
    }

    /// Two opposing changes make one flash.
    pub(crate) fn flashes(&self) -> usize {
        self.most_edges / 2
    }
}

/// The limiters count changes from this share of a step on, because their input may be the mean of only a sample of
/// the pixels.
pub(crate) const GUARDED: f32 = 0.88;
const GUARDED_STEP: f32 = GUARDED * FLASH_STEP;
pub(crate) const GUARDED_DARK: f32 = FLASH_DARK + 0.02;

/// Finds opposing changes of at least a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Swings {
    step: f32,
    /// The darker of the two lies below this.
    dark: f32,
    /// Lowest and highest value since the last change.
    range: Option<(f32, f32)>,
    /// +1 after a rise, −1 after a fall.
    direction: i8,
}

impl Swings {
    pub(crate) fn of(step: f32, dark: f32) -> Self {
        Self { step, dark, range: None, direction: 0 }
    }

    /// Which change a value would make: a rise (+1), a fall (−1) or none.
    pub(crate) fn change(&self, value: f32) -> i8 {
        let Some((low, high)) = self.range else { return 0 };
        if self.direction <= 0 && value - low >= self.step && low < self.dark {
            1
        } else if self.direction >= 0 && high - value >= self.step && value < self.dark {
            -1
        } else {
            0
        }
    }

    /// Takes the value; returns whether it completes an opposing change.
    fn push(&mut self, value: f32) -> bool {
        let change = self.change(value);
        self.take(value, change);
        change != 0
    }

    /// Takes the value as what [`change`](Self::change) said, or as none.
    pub(crate) fn take(&mut self, value: f32, change: i8) {
        self.range = match self.range {
            Some((low, high)) if change == 0 => Some((low.min(value), high.max(value))),
            _ => Some((value, value)),
        };
        if change != 0 {
            self.direction = change;
        }
    }
}

/// Lets a luminance follow the wanted one, but never with more than three flashes in a second, nor faster
/// than a set slope.
///
/// It works on any signal to which the picture's relative luminance is proportional, such as the intensity of
/// the lights: pass the wanted luminance in, use the returned one.
#[derive(Clone, Debug)]
pub struct FlashLimiter {
    swings: Swings,
    /// Times of the last changes, a ring.
    edges_secs: [f64; 2 * MAX_FLASHES - 1],
    next_edge: usize,
    last: Option<(f64, f32)>,
    max_slope_per_sec: f32,
}

impl Default for FlashLimiter {
    fn default() -> Self {
        Self::new(4.0)
    }
}

impl FlashLimiter {
    /// A limiter that changes the luminance by at most `max_slope_per_sec` (at 4, black to white takes a
    /// quarter of a second); a slope that is not positive and finite counts as 4.
    pub fn new(max_slope_per_sec: f32) -> Self {
        let is_slope = max_slope_per_sec.is_finite() && max_slope_per_sec > 0.0;
        let max_slope_per_sec = if is_slope { max_slope_per_sec } else { 4.0 };
        Self {
            swings: Swings::of(GUARDED_STEP, GUARDED_DARK),
            edges_secs: [f64::NEG_INFINITY; 2 * MAX_FLASHES - 1],
            next_edge: 0,
            last: None,
            max_slope_per_sec,
        }
    }

    /// The luminance to show at `time_secs`, which must not fall from call to call, where `wanted` is asked
    /// for. Values outside [0, 1] and NaN are clamped. Allocates nothing.
    pub fn limit(&mut self, time_secs: f64, wanted: f32) -> f32 {
        let shown = self.allowed(time_secs, wanted);
        self.show(time_secs, shown);
        shown
    }

    /// The value that [`limit`](Self::limit) would return, without counting it as shown: one between `wanted` and the
    /// last value shown.
    pub fn allowed(&self, time_secs: f64, wanted: f32) -> f32 {
        let wanted = clamped(wanted);
        let Some((last_secs, last)) = self.last else { return wanted };
        let step = self.max_slope_per_sec * (time_secs - last_secs).max(0.0) as f32;
        let shown = wanted.clamp(last - step, last + step);
        if self.swings.change(shown) != 0 && self.is_spent(time_secs) {
            self.held(shown, last)
        } else {
            shown
        }
    }

    /// Counts the value shown at `time_secs`, clamped as by [`limit`](Self::limit); it should be as near to what was
    /// [`allowed`](Self::allowed) as the picture permits.
    pub fn show(&mut self, time_secs: f64, shown: f32) {
        let shown = clamped(shown);
        if self.swings.push(shown) {
            self.count_edge(time_secs);
        }
        self.last = Some((time_secs, shown));
    }

    /// Whether a change that cannot be softened may happen at `time_secs`; if so, it is counted.
    pub fn may_step(&mut self, time_secs: f64) -> bool {
        let may = !self.is_spent(time_secs);
        if may {
            self.count_edge(time_secs);
        }
        may
    }

    /// Five changes in the last second: one more would complete the third flash, and the edges
    /// of a fourth could follow within the same second.
    fn is_spent(&self, time_secs: f64) -> bool {
        time_secs - self.edges_secs[self.next_edge] <= 1.0
    }

    fn count_edge(&mut self, time_secs: f64) {
        self.edges_secs[self.next_edge] = time_secs;
        self.next_edge = (self.next_edge + 1) % self.edges_secs.len();
    }

    /// The value nearest to `wanted` that makes no change: after a rise, above the last peak minus a step;
    /// after a fall, below the last trough plus a step; never beyond `last`, which made none.
    fn held(&self, wanted: f32, last: f32) -> f32 {
        let Some((low, high)) = self.swings.range else { return wanted };
        let within = 0.9 * GUARDED_STEP;
        let floor = if self.swings.direction >= 0 { (high - within).min(last) } else { 0.0 };
        let ceiling = if self.swings.direction <= 0 { (low + within).max(last) } else { 1.0 };
        wanted.max(floor).min(ceiling)
    }
}

/// A luminance within [0, 1]; what is not finite counts as 0.
fn clamped(luminance: f32) -> f32 {
    if luminance.is_finite() { luminance.clamp(0.0, 1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn limited(times: &[f64], wanted: &[f32]) -> Vec<f32> {
        let mut limiter = FlashLimiter::default();
        times.iter().zip(wanted).map(|(&t, &w)| limiter.limit(t, w)).collect()
    }

    #[test]
    fn a_strobe_is_counted_and_tamed() {
        let times: Vec<f64> = (0..600).map(|i| f64::from(i) / 60.0).collect();
        let strobe: Vec<f32> = times.iter().map(|t| f32::from(u8::from((t * 5.0).fract() < 0.5))).collect();
        assert!(most_flashes_per_second(&times, &strobe) >= 5);
        let shown = limited(&times, &strobe);
        let flashes = most_flashes_per_second(&times, &shown);
        assert!((1..=3).contains(&flashes), "{flashes}");
    }

    #[test]
    fn slow_light_passes_unchanged() {
        let times: Vec<f64> = (0..600).map(|i| f64::from(i) / 60.0).collect();
        let slow: Vec<f32> = times.iter().map(|t| 0.5 + 0.4 * (t * 2.0).sin() as f32).collect();
        assert_eq!(limited(&times, &slow), slow);
    }

    #[test]
    fn any_slope_and_any_luminance_give_one_that_can_be_shown() {
        for slope in [f32::INFINITY, f32::NAN, f32::MAX, -1.0] {
            let mut limiter = FlashLimiter::new(slope);
            for (time_secs, wanted) in [(0.0, 0.2), (0.0, 0.9), (1.0, f32::NAN), (2.0, 0.5)] {
                assert!((0.0..=1.0).contains(&limiter.limit(time_secs, wanted)), "{slope}");
            }
            limiter.show(2.5, f32::NAN);
            assert!((0.0..=1.0).contains(&limiter.limit(3.0, 1.0)), "{slope}");
        }
    }

    proptest! {
        #[test]
        fn nothing_gets_more_than_three_flashes_through(
            wanted in prop::collection::vec(-0.2f32..1.2, 1..400), rate in 10.0f64..240.0)
        {
            let times: Vec<f64> = (0..wanted.len()).map(|i| i as f64 / rate).collect();
            let shown = limited(&times, &wanted);
            prop_assert!(most_flashes_per_second(&times, &shown) <= MAX_FLASHES);
            prop_assert!(shown.iter().all(|v| (0.0..=1.0).contains(v)));
        }
    }
}
