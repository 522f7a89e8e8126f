//! An ear: its bowl, the rim around, the inner fold, tragus and lobe.

use super::Face;
use crate::samples::field::{carve, ellipsoid, join, rod, sphere, turned};
use crate::surface::vec3::Vec3;

/// Where the ear is fixed: before its bowl.
const ROOT: Vec3 = [0.585, -0.12, -0.06];

/// The rim in the plane of the ear, as (back, up) from the root: from the bowl over the top and down the back.
const RIM: [[f64; 2]; 11] = [
    [0.050, 0.030],
    [0.015, 0.090],
    [0.000, 0.170],
    [0.035, 0.250],
    [0.110, 0.300],
    [0.195, 0.300],
    [0.260, 0.250],
    [0.285, 0.165],
    [0.270, 0.070],
    [0.225, -0.030],
    [0.160, -0.115],
];
/// The inner fold, from the lower fork up.
const FOLD: [[f64; 2]; 5] =
    [[0.120, -0.085], [0.180, -0.010], [0.200, 0.080], [0.180, 0.160], [0.120, 0.225]];

/// The point in the plane of the ear: outward, up and back; and the ear's scale.
fn local(p: Vec3, f: &Face) -> (Vec3, f64) {
    let scale = 1.1 + 0.18 * f.ears.clamp(-1.2, 1.5);
    let off = 0.42 + 0.28 * f.ears.clamp(-1.0, 1.2);
    let [x, y, z] = turned(turned(p, ROOT, 1, off), [0.0; 3], 0, 0.16);
    ([x / scale, y / scale, -z / scale], scale)
}

/// A tube through points of the plane of the ear, at `out` from it; its radius swells from the ends.
fn tube<const N: usize>(q: Vec3, points: &[[f64; 2]; N], out: f64, r: f64) -> f64 {
    let at = |[back, up]: [f64; 2]| [out, up, back];
    let piece = |pair: &[[f64; 2]]| rod(q, at(pair[0]), at(pair[1]), r, r);
    points.windows(2).map(piece).fold(f64::MAX, |a, b| join(a, b, 0.03))
}

/// The ear alone.
pub fn form(p: Vec3, f: &Face) -> f64 {
    let (q, scale) = local(p, f);
    let far = sphere(q, [0.0, 0.08, 0.14], 0.36);
    if far > 0.15 {
        return far * scale;
    }
    let plate = ellipsoid(q, [0.012, 0.105, 0.140], [0.052, 0.205, 0.150]);
    let lobe = ellipsoid(q, [0.022, -0.155, 0.095], [0.045, 0.085, 0.070]);
    let rim = tube(q, &RIM, 0.060, 0.036);
    let fold = tube(q, &FOLD, 0.042, 0.030);
    let mut d = join(plate, lobe, 0.07);
    d = join(d, rim, 0.05);
    d = join(d, fold, 0.05);
    // The bowl and the trough between rim and fold.
    let bowl = ellipsoid(q, [0.075, 0.015, 0.100], [0.072, 0.090, 0.066]);
    d = carve(d, bowl, 0.04);
    let upper = ellipsoid(q, [0.075, 0.200, 0.110], [0.045, 0.050, 0.050]);
    d = carve(d, upper, 0.03);
    let tragus = ellipsoid(q, [0.045, 0.000, 0.022], [0.032, 0.042, 0.024]);
    let anti = ellipsoid(q, [0.045, -0.085, 0.085], [0.028, 0.026, 0.034]);
    d = join(join(d, tragus, 0.04), anti, 0.05);
    d * scale
}

/// The ear on the head `d`.
pub fn add(d: f64, p: Vec3, f: &Face) -> f64 {
    if sphere(p, ROOT, 0.75) > 0.1 {
        return d;
    }
    join(d, form(p, f), 0.06)
}
