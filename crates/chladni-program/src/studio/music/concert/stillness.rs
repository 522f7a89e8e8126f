//! Whether anything on screen moves: a still picture is neither deformed nor drawn again.

use std::hash::{DefaultHasher, Hash, Hasher};

use chladni_synth::{Coefficients, Item, Residual, Term};

use crate::work::Staged;

/// Differences of coefficients below this (the shape's area is one) are invisible, so that a decaying
/// movement comes to rest.
const FINEST: f32 = 1e-5;

/// All that a picture of the gallery depends on.
#[derive(Clone, Debug, PartialEq)]
pub struct StillPicture {
    /// [`pose`] of the items.
    pub pose: u64,
    /// Camera, look and viewports.
    pub staged: Staged,
}

/// A number that says how items are deformed, for one `normal_blending`.
pub fn pose(items: &[Item], normal_blending: f32) -> u64 {
    let mut hasher = DefaultHasher::new();
    normal_blending.to_bits().hash(&mut hasher);
    for item in items {
        item.terms.len().hash(&mut hasher);
        item.terms.iter().for_each(|term| hash_term(term, &mut hasher));
    }
    hasher.finish()
}

fn hash_term(term: &Term, hasher: &mut DefaultHasher) {
    let mut coarsely = |value: f32| ((value / FINEST).round() as i64).hash(hasher);
    match &term.coefficients {
        Coefficients::Vector(all) => all.as_flattened().iter().for_each(|c| coarsely(*c)),
        Coefficients::Normal(all) => all.iter().for_each(|c| coarsely(*c)),
    }
    coarsely(term.residual_gain);
    // Signals are shared and never change in place.
    match &term.residual {
        Some(Residual::Vector(signal)) => signal.as_ptr().hash(hasher),
        Some(Residual::Normal(signal)) => signal.as_ptr().hash(hasher),
        None => 0.hash(hasher),
    }
    term.mask.as_ref().map(|mask| mask.as_ptr()).hash(hasher);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_changes_with_what_is_seen_and_with_nothing_less() {
        let item = |c: f32, gain: f32| {
            let coefficients = Coefficients::Vector(vec![[0.1, c, 0.0]]);
            Item { terms: vec![Term { coefficients, residual: None, residual_gain: gain, mask: None }] }
        };
        let still = pose(&[item(0.2, 0.0)], 0.5);
        assert_eq!(still, pose(&[item(0.2 + 1e-8, 1e-9)], 0.5));
        let others = [
            pose(&[item(0.201, 0.0)], 0.5),
            pose(&[item(0.2, 0.1)], 0.5),
            pose(&[item(0.2, 0.0)], 0.4),
            pose(&[item(0.2, 0.0), Item::default()], 0.5),
        ];
        assert!(others.iter().all(|other| *other != still));
    }
}
