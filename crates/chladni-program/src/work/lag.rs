//! How far what dances has come lately: what palettes know of speed.

use chladni_synth::{Coefficients, Item, Term};

/// What a shape lags behind itself is forgotten over this time, to a third.
const MEMORY_SECS: f64 = 0.08;
/// After a pause or a jump of this length nothing is known of the past.
const LONGEST_SECS: f64 = 0.5;
/// Smaller coefficients (the shape's area is one) are rest.
const REST: f32 = 1e-6;

/// Remembers an item from frame to frame. With x the coefficients and y what follows them by ẏ = (x − y)/τ, the lag is
/// x − y: for what moves evenly its speed times τ, and never more than it went. Between two frames x is taken for a
/// straight line, for which the step is exact, so that frames may come as often as they like.
#[derive(Clone, Debug, Default)]
pub struct Lag {
    /// What was there last, what it lagged, and when.
    last: Option<(Item, Item, f64)>,
}

impl Lag {
    /// Adds to `items` the rest moved by what the only one of them lags at `at_secs`, where that is `wanted`. Of many it
    /// adds nothing.
    pub fn follow(&mut self, items: &mut Vec<Item>, at_secs: f64, wanted: bool) {
        let [item] = &items[..] else { return self.last = None };
        if !wanted {
            return self.last = None;
        }
        let lag = match self.last.take() {
            Some((before, lag, then_secs)) => lagging(item, &before, lag, at_secs - then_secs),
            None => none_of(item),
        };
        self.last = Some((item.clone(), lag.clone(), at_secs));
        items.push(lag);
    }
}

/// An item like `item` that moves nothing.
fn none_of(item: &Item) -> Item {
    let none = |term: &Term| {
        let coefficients = match &term.coefficients {
            Coefficients::Vector(all) => Coefficients::Vector(vec![[0.0; 3]; all.len()]),
            Coefficients::Normal(all) => Coefficients::Normal(vec![0.0; all.len()]),
        };
        Term { coefficients, residual_gain: 0.0, ..term.clone() }
    };
    Item { terms: item.terms.iter().map(none).collect() }
}

/// The lag after a step, of `lag` before it.
fn lagging(item: &Item, before: &Item, mut lag: Item, secs: f64) -> Item {
    if !(0.0..LONGEST_SECS).contains(&secs) || lag.terms.len() != item.terms.len() {
        return none_of(item);
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
    for ((lag, now), then) in lag.terms.iter_mut().zip(&item.terms).zip(&before.terms) {
        match (&mut lag.coefficients, &now.coefficients, &then.coefficients) {
            (Coefficients::Vector(lag), Coefficients::Vector(now), Coefficients::Vector(then))
                if now.len() == then.len() =>
            {
                let all = lag.as_flattened_mut().iter_mut().zip(now.as_flattened()).zip(then.as_flattened());
                all.for_each(|((lag, now), then)| step(lag, *now, *then));
            }
            (Coefficients::Normal(lag), Coefficients::Normal(now), Coefficients::Normal(then))
                if now.len() == then.len() =>
            {
                let all = lag.iter_mut().zip(now).zip(then);
                all.for_each(|((lag, now), then)| step(lag, *now, *then));
            }
            // Another form or another number of harmonics.
            _ => return none_of(item),
        }
        step(&mut lag.residual_gain, now.residual_gain, then.residual_gain);
        (lag.residual, lag.mask) = (now.residual.clone(), now.mask.clone());
    }
    lag
}

#[cfg(test)]
mod tests {
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

    /// What swings at 1 Hz, at the end of two seconds of so many frames each.
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
        for (mut items, wanted) in [(vec![longer.clone(), longer.clone()], true), (vec![longer], false)] {
            let before = items.len();
            lag.follow(&mut items, 5.1, wanted);
            assert_eq!(items.len(), before);
        }
    }
}
