//! Solids as signed distance functions: negative inside, about the distance near the surface.

use crate::surface::vec3::{Vec3, add, dot, length, scaled, sub};

/// Distance to a sphere.
pub(crate) fn sphere(p: Vec3, center: Vec3, r: f64) -> f64 {
    length(sub(p, center)) - r
}

/// About the distance to an ellipsoid of half axes `r` (exact on its surface).
pub(crate) fn ellipsoid(p: Vec3, center: Vec3, r: Vec3) -> f64 {
    let q: Vec3 = std::array::from_fn(|i| (p[i] - center[i]) / r[i]);
    let k0 = length(q);
    let k1 = length(std::array::from_fn(|i| q[i] / r[i]));
    if k1 > 0.0 { k0 * (k0 - 1.0) / k1 } else { -r[0].min(r[1]).min(r[2]) }
}

/// About the distance to a rod from `a` to `b` whose radius goes from `ra` to `rb`.
pub(crate) fn rod(p: Vec3, a: Vec3, b: Vec3, ra: f64, rb: f64) -> f64 {
    let (ap, ab) = (sub(p, a), sub(b, a));
    let t = (dot(ap, ab) / dot(ab, ab)).clamp(0.0, 1.0);
    length(sub(ap, scaled(ab, t))) - (ra + (rb - ra) * t)
}

/// The union of two solids with a seam rounded over a width of about `k`.
pub(crate) fn join(a: f64, b: f64, k: f64) -> f64 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - h * h * k / 4.0
}

/// The part of `a` outside `b`, with the edge rounded over a width of about `k`.
pub(crate) fn carve(a: f64, b: f64, k: f64) -> f64 {
    -join(-a, b, k)
}

/// The intersection of two solids, with its edge rounded over a width of about `k`.
pub(crate) fn common(a: f64, b: f64, k: f64) -> f64 {
    -join(-a, -b, k)
}

/// `p` turned by `angle_rad` about the axis (0 = x, 1 = y, 2 = z) through `center`, which
/// goes to the origin.
pub(crate) fn turned(p: Vec3, center: Vec3, axis: usize, angle_rad: f64) -> Vec3 {
    let mut q = sub(p, center);
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let (s, c) = angle_rad.sin_cos();
    (q[i], q[j]) = (c * q[i] - s * q[j], s * q[i] + c * q[j]);
    q
}

/// The gradient of `field` by central differences of `step`, which mirror where the field does.
pub(crate) fn gradient(field: &impl Fn(Vec3) -> f64, p: Vec3, step: f64) -> Vec3 {
    std::array::from_fn(|i| {
        let mut d = [0.0; 3];
        d[i] = step;
        (field(add(p, d)) - field(sub(p, d))) / (2.0 * step)
    })
}
