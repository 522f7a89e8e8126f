//! A nose: bridge, tip, wings and nostrils.

use super::Face;
use crate::samples::field::{carve, ellipsoid, join, rod, sphere};
use crate::surface::vec3::Vec3;

/// Its tip and the tip's radius.
fn tip(f: &Face) -> (Vec3, f64) {
    let out = f.nose.max(-1.3);
    ([0.0, -0.30 - 0.045 * out, 0.825 + 0.085 * out], 0.088 + 0.012 * out.max(0.0) + 0.018 * f.nose_width)
}

/// The nose without its nostrils.
pub fn form(p: Vec3, f: &Face) -> f64 {
    let (tip, r) = tip(f);
    let broad = 1.0 + 0.35 * f.nose_width;
    let out = tip[2] - 0.825;
    let middle = [0.0, -0.08, 0.735 + 0.45 * out + 0.040 * f.bridge];
    let upper = rod(p, [0.0, 0.16, 0.652 + 0.012 * f.bridge], middle, 0.062 * broad, 0.066 * broad);
    let lower = rod(p, middle, tip, 0.066 * broad, r);
    // The form between the ridge and the face.
    let side =
        rod(p, [0.0, -0.02, 0.58], [0.0, tip[1] + 0.03, 0.66 + 0.45 * out], 0.10 * broad, 0.115 * broad);
    let wing = ellipsoid(
        p,
        [(0.108 * broad).max(0.8 * r), tip[1] - 0.008, 0.735 + 0.60 * out],
        [0.056 * broad, 0.060, 0.078 + 0.25 * out],
    );
    join(join(join(upper, lower, 0.07), side, 0.10), wing, 0.035)
}

/// The nose on the face `d`.
pub fn add(d: f64, p: Vec3, f: &Face) -> f64 {
    let (tip, r) = tip(f);
    if sphere(p, tip, 0.75) > 0.1 {
        return d;
    }
    let broad = 1.0 + 0.35 * f.nose_width;
    let out = tip[2] - 0.825;
    let nostril = ellipsoid(
        p,
        [0.058 * broad + 0.1 * (r - 0.088), tip[1] - 0.078, 0.775 + 0.72 * out],
        [0.030 * broad, 0.034, 0.050],
    );
    // The crease behind the wing.
    let crease = rod(
        p,
        [0.150 * broad, tip[1] + 0.065, 0.685 + 0.45 * out],
        [0.172 * broad, tip[1] - 0.030, 0.668 + 0.45 * out],
        0.010,
        0.012,
    );
    let d = join(d, form(p, f), 0.085);
    carve(carve(d, crease, 0.035), nostril, 0.022)
}
