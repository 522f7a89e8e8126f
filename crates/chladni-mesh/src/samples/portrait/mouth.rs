//! A mouth: two lips, the line between them, its corners and the groove above.

use super::Face;
use crate::samples::field::{carve, ellipsoid, join, rod, sphere};
use crate::surface::vec3::Vec3;

/// The upper and the lower lip.
fn lips(p: Vec3, f: &Face) -> (f64, f64) {
    let (full, wide) = (0.016 * f.lips.max(-1.3), 1.10 + 0.22 * f.mouth);
    let peak =
        rod(p, [0.045, -0.536, 0.722 + full], [0.195 * wide, -0.574, 0.612], 0.040 + 0.6 * full, 0.018);
    let middle = sphere(p, [0.0, -0.556, 0.716 + full], 0.040 + 0.6 * full);
    let upper = join(peak, middle, 0.03);
    let lower =
        rod(p, [0.035, -0.634, 0.708 + full], [0.165 * wide, -0.602, 0.624], 0.052 + 0.7 * full, 0.024);
    (upper, lower)
}

/// Where the mouth is.
pub fn place(p: Vec3, f: &Face) -> f64 {
    let (upper, lower) = lips(p, f);
    upper.min(lower)
}

/// The mouth in the face `d`.
pub fn add(d: f64, p: Vec3, f: &Face) -> f64 {
    if sphere(p, [0.0, -0.58, 0.65], 0.45) > 0.1 {
        return d;
    }
    let (full, wide) = (0.016 * f.lips.max(-1.3), 1.10 + 0.22 * f.mouth);
    let mound = ellipsoid(p, [0.0, -0.565, 0.53], [0.27, 0.19, 0.20]);
    let groove = rod(p, [0.0, -0.43, 0.785], [0.0, -0.495, 0.775], 0.016, 0.024);
    let bow = sphere(p, [0.0, -0.500, 0.775 + full], 0.020);
    let under = ellipsoid(p, [0.0, -0.735, 0.745 + 0.5 * full], [0.15, 0.045, 0.045]);
    let (upper, lower) = lips(p, f);
    let slit = rod(p, [0.0, -0.590, 0.778 + full], [0.185 * wide, -0.584, 0.650], 0.010, 0.004);
    let mut d = join(d, mound, 0.15);
    d = carve(d, groove, 0.045);
    d = carve(d, under, 0.07);
    d = join(d, join(upper, lower, 0.012), 0.05);
    d = carve(d, bow, 0.03);
    carve(d, slit, 0.045)
}
