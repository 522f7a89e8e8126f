//! The parts of the sample heads, in the frame of the plain one.
//!
//! Eyes, nose, mouth and ears lie where they are modeled. The other parts are regions of the plain head, as in a labeled
//! template: forms that are weaker on another head move no border, and those that have moved take their borders along.

use crate::surface::vec3::{Vec3, dot, sub};

/// Their names.
pub(crate) const PARTS: [&str; 10] =
    ["nose", "brow", "eyes", "mouth", "chin", "jaw", "cheeks", "ears", "crown", "neck"];

/// The distances of a point from the features of its own head.
pub(crate) struct Features {
    pub nose: f64,
    pub eyes: f64,
    pub mouth: f64,
    pub ears: f64,
}

/// For each of [`PARTS`], about how far a point is from its border, negative within it; `forms` are how far the point is
/// from brow, chin, jaw, cheeks, cranium and neck where it lies on the plain head.
pub(crate) fn borders(of: &Features, forms: [f64; 6]) -> [f64; PARTS.len()] {
    // The first feature goes before the next, and all of them before the forms, of which the nearest counts.
    let eyes = of.eyes - 0.01;
    let nose = (of.nose - 0.02).max(-eyes);
    let mouth = (of.mouth - 0.04).max(-eyes.min(nose));
    let ears = (of.ears - 0.02).max(-eyes.min(nose).min(mouth));
    let feature = eyes.min(nose).min(mouth).min(ears);
    let [brow, chin, jaw, cheeks, crown, neck] = std::array::from_fn(|i| {
        let others = (0..forms.len()).filter(|j| *j != i).map(|j| forms[j]);
        (0.5 * (forms[i] - others.fold(f64::MAX, f64::min))).max(-feature)
    });
    [nose, brow, eyes, mouth, chin, jaw, cheeks, ears, crown, neck]
}

/// The part within whose borders a point lies, an index of [`PARTS`].
pub(crate) fn within(borders: &[f64; PARTS.len()]) -> u8 {
    (0..PARTS.len()).min_by(|a, b| borders[*a].total_cmp(&borders[*b])).unwrap_or(0) as u8
}

/// Where `p` is on a head whose chin is not at `chin`, `moved` from its place: what surrounds the chin moves with it.
pub(crate) fn chin_back(p: Vec3, chin: Vec3, moved: Vec3) -> Vec3 {
    /// The distance from the chin's middle at which the surface moves by 1/e of what the chin does.
    const REACH: f64 = 0.30;
    let away = sub(p, chin);
    let share = (-dot(away, away) / (REACH * REACH)).exp();
    std::array::from_fn(|i| p[i] - share * moved[i])
}
