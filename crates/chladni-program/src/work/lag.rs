//! How far each shape has moved lately, which palettes read as its speed.

use chladni_synth::{Coefficients, Item};

/// Time in which the lag of a resting shape falls to a third.
const MEMORY_SECS: f64 = 0.08;
/// After a pause or a jump of this length nothing is known of the past.
const LONGEST_SECS: f64 = 0.5;
/// Smaller coefficients (the shape's area is one) are rest.
const REST: f32 = 1e-6;

/// Remembers items from frame to frame. With x the coefficients and y their followers by ẏ = (x − y)/τ, the lag is
/// x − y: the speed times τ where the movement is even, and never more than the movement itself. Between two frames
/// x is taken for a straight line, for which the step is exact, so the frame rate does not matter.
#[derive(Clone, Debug, Default)]
pub struct Lag {
    /// The last items and their lags, in the same order.
    last: Vec<Item>,
    lags: Vec<Item>,
    /// When that was.
    then_secs: f64,
}

impl Lag {
    /// If `wanted`, appends to `items`, in their order, the rest shape moved by the lag of each at `at_secs`.
    /// Items that were not there last time have no lag at first.
    pub fn follow(&mut self, items: &mut Vec<Item>, at_secs: f64, wanted: bool) {
        if !wanted {
            self.last.clear();
            return self.lags.clear();
        }
        // An item that comes or goes in a gallery shifts all others.
        if self.last.len() != items.len() {
            self.lags.clear();
            self.lags.resize_with(items.len(), Item::default);
            self.last.resize_with(items.len(), Item::default);
        }
        let secs = at_secs - self.then_secs;
        for ((item, last), lag) in items.iter().zip(&mut self.last).zip(&mut self.lags) {
            step(item, last, lag, secs);
            remember(item, last);
        }
        self.then_secs = at_secs;
        items.extend_from_slice(&self.lags);
    }
}

/// Makes `last` the same as `item`, in the memory that it has where it has it.
fn remember(item: &Item, last: &mut Item) {
    let is_alike = last.terms.len() == item.terms.len();
    if !is_alike {
        return last.clone_from(item);
    }
    for (term, last) in item.terms.iter().zip(&mut last.terms) {
        match (&term.coefficients, &mut last.coefficients) {
            (Coefficients::Vector(now), Coefficients::Vector(last)) => last.clone_from(now),
            (Coefficients::Normal(now), Coefficients::Normal(last)) => last.clone_from(now),
            (now, last) => last.clone_from(now),
        }
        (last.residual, last.mask) = (term.residual.clone(), term.mask.clone());
        last.residual_gain = term.residual_gain;
    }
}

/// Makes `lag` an item like `item` that moves nothing.
fn rest(item: &Item, lag: &mut Item) {
    remember(item, lag);
    for term in &mut lag.terms {
        match &mut term.coefficients {
            Coefficients::Vector(all) => all.fill([0.0; 3]),
            Coefficients::Normal(all) => all.fill(0.0),
        }
        term.residual_gain = 0.0;
    }
}

/// Brings `lag` from the moment of `before` to that of `item`, `secs` later.
fn step(item: &Item, before: &Item, lag: &mut Item, secs: f64) {
    let is_next = (0.0..LONGEST_SECS).contains(&secs);
    let terms = item.terms.len();
    if !is_next || before.terms.len() != terms || lag.terms.len() != terms {
        return rest(item, lag);
    }
    let steps = secs / MEMORY_SECS;
    let left = (-steps).exp();
    // (1 − e⁻ᵃ)/a.
    let share = if steps > 1e-9 { (1.0 - left) / steps } else { 1.0 };
    let (left, share) = (left as f32, share as f32);
    let step = |lag: &mut f32, now: f32, then: f32| {
        let next = *lag * left + (now - then) * share;
        *lag = if next.abs() < REST { 0.0 } else { next };
    };
    for ((lagging, now), then) in lag.terms.iter_mut().zip(&item.terms).zip(&before.terms) {
        match (&mut lagging.coefficients, &now.coefficients, &then.coefficients) {
            (Coefficients::Vector(lag), Coefficients::Vector(now), Coefficients::Vector(then))
                if now.len() == then.len() && now.len() == lag.len() =>
            {
                let all = lag.as_flattened_mut().iter_mut().zip(now.as_flattened()).zip(then.as_flattened());
                all.for_each(|((lag, now), then)| step(lag, *now, *then));
            }
            (Coefficients::Normal(lag), Coefficients::Normal(now), Coefficients::Normal(then))
                if now.len() == then.len() && now.len() == lag.len() =>
            {
                let all = lag.iter_mut().zip(now).zip(then);
                all.for_each(|((lag, now), then)| step(lag, *now, *then));
            }
            // Another form or another number of harmonics.
            _ => return rest(item, lag),
        }
        step(&mut lagging.residual_gain, now.residual_gain, then.residual_gain);
        (lagging.residual, lagging.mask) = (now.residual.clone(), now.mask.clone());
    }
}

#[cfg(test)]
mod tests {
    use chladni_synth::Term;

    use super::*;

    fn item(c: f32) -> Item {
        let coefficients = Coefficients::Normal(vec![0.0, c]);
        Item { terms: vec![Term { coefficients, residual: None, residual_gain: 2.0 * c, mask: None }] }
    }

    fn amplitude(item: &Item) -> f32 {
        let [Term { coefficients: Coefficients::Normal(c), residual_gain, .. }] = &item.terms[..] else {
            panic!()
        };
        assert!((2.0 * c[1] - residual_gain).abs() < 1e-5);
        c[1]
    }

    /// The lag of a swing at 1 Hz after two seconds at a frame rate.
    fn swung(fps: u32) -> f32 {
        let mut lag = Lag::default();
        let mut last = 0.0;
        for frame in 0..=2 * fps {
            let at_secs = f64::from(frame) / f64::from(fps);
            let mut items = vec![item((std::f64::consts::TAU * at_secs).sin() as f32)];
            lag.follow(&mut items, at_secs, true);
            last = amplitude(&items[1]);
        }
        last
    }

    #[test]
    fn a_swing_lags_as_the_filter_says_at_any_frame_rate() {
        // Of sin ωt the part x − y is ωτ/(1 + ω²τ²) · (cos ωt + ωτ sin ωt).
        let a = std::f64::consts::TAU * MEMORY_SECS;
        let exact = (a / (1.0 + a * a)) as f32;
        for fps in [24, 30, 60, 240] {
            assert!((swung(fps) - exact).abs() < 0.01, "{fps}: {} for {exact}", swung(fps));
        }
    }

    #[test]
    fn what_rests_or_jumps_in_time_or_changes_its_form_does_not_lag() {
        let mut lag = Lag::default();
        let mut at = |c: f32, at_secs: f64| {
            let mut items = vec![item(c)];
            lag.follow(&mut items, at_secs, true);
            amplitude(&items[1])
        };
        assert_eq!(at(1.0, 0.0), 0.0);
        assert!(at(2.0, 0.02) > 0.5);
        assert_eq!(at(9.0, 2.0), 0.0);
        assert!(at(8.0, 2.1) < -0.3);
        // A pause comes to rest, exactly.
        assert_eq!((0..60).map(|i| at(8.0, 2.1 + 0.05 * f64::from(i))).last(), Some(0.0));
        let longer = Item { terms: [item(1.0).terms, item(1.0).terms].concat() };
        let mut items = vec![longer.clone()];
        lag.follow(&mut items, 5.05, true);
        assert_eq!(items[1].terms.len(), 2);
        let mut unwanted = vec![longer];
        lag.follow(&mut unwanted, 5.1, false);
        assert_eq!(unwanted.len(), 1);
    }

    #[test]
    fn each_of_a_gallery_lags_by_itself_until_others_come() {
        let mut lag = Lag::default();
        let mut at = |amplitudes: &[f32], at_secs: f64| {
            let mut items: Vec<Item> = amplitudes.iter().map(|c| item(*c)).collect();
            lag.follow(&mut items, at_secs, true);
            items[amplitudes.len()..].iter().map(amplitude).collect::<Vec<_>>()
        };
        assert_eq!(at(&[1.0, 5.0, 0.0], 0.0), [0.0; 3]);
        let [rising, still, falling] = at(&[2.0, 5.0, -1.0], 0.02)[..] else { panic!() };
        assert!(rising > 0.5 && still == 0.0 && falling == -rising, "{rising} {still} {falling}");
        assert_eq!(at(&[2.0, 9.0], 0.04), [0.0; 2]);
        assert!(at(&[3.0, 9.0], 0.06)[0] > 0.5);
    }
}
