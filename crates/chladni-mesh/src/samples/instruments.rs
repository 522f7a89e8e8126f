//! A bell and a drum.

use super::field::{common, join, rod, sphere};
use super::surface_nets::{Grid, surface};
use crate::TriMesh;
use crate::surface::vec3::Vec3;

/// The middle of a bell's wall, from the crown to the lip: distance from the axis, height, half the thickness.
const WALL: [[f64; 3]; 10] = [
    [0.0, 0.78, 0.075],
    [0.28, 0.77, 0.075],
    [0.44, 0.68, 0.075],
    [0.51, 0.50, 0.070],
    [0.55, 0.20, 0.070],
    [0.60, -0.12, 0.070],
    [0.68, -0.42, 0.075],
    [0.80, -0.66, 0.085],
    [0.93, -0.83, 0.095],
    [1.02, -0.92, 0.080],
];

/// The wall as a curve through its points (Catmull and Rom, 1974), in straight parts too short to be seen.
fn smooth_wall() -> Vec<[f64; 3]> {
    const PARTS: usize = 5;
    let last = WALL.len() - 1;
    let point = |i: usize| {
        let (span, t) = (i / PARTS, (i % PARTS) as f64 / PARTS as f64);
        let [a, b, c, d] =
            [span.saturating_sub(1), span, (span + 1).min(last), (span + 2).min(last)].map(|i| WALL[i]);
        std::array::from_fn(|k| {
            let (a, b, c, d) = (a[k], b[k], c[k], d[k]);
            let cubic = (3.0 * (b - c) + d - a) * t + 2.0 * a - 5.0 * b + 4.0 * c - d;
            b + 0.5 * t * (c - a + t * cubic)
        })
    };
    (0..=last * PARTS).map(point).collect()
}

/// A bell with its knob and its clapper, y up.
pub(crate) fn bell() -> TriMesh {
    let grid =
        Grid { center: [0.0; 3], low: [-1.2, -1.25, -1.2], high: [1.2, 1.4, 1.2], cell: 0.041, growth: 0.0 };
    let wall = smooth_wall();
    surface(
        |p| {
            let axial = [p[0].hypot(p[2]), p[1], 0.0];
            let at = |[r, y, _]: [f64; 3]| [r, y, 0.0];
            let parts =
                wall.windows(2).map(|ends| rod(axial, at(ends[0]), at(ends[1]), ends[0][2], ends[1][2]));
            let mut d = parts.fold(f64::INFINITY, f64::min);
            // Two moldings around it, broad enough for the cells.
            d = join(d, sphere(axial, [0.59, 0.44, 0.0], 0.050), 0.07);
            d = join(d, sphere(axial, [0.785, -0.50, 0.0], 0.050), 0.07);
            d = join(d, rod(p, [0.0, 0.80, 0.0], [0.0, 1.02, 0.0], 0.12, 0.07), 0.10);
            d = join(d, sphere(p, [0.0, 1.14, 0.0], 0.15), 0.06);
            let clapper = rod(p, [0.0, 0.70, 0.0], [0.0, -0.70, 0.0], 0.062, 0.075);
            join(d, join(clapper, sphere(p, [0.0, -0.88, 0.0], 0.19), 0.10), 0.08)
        },
        &grid,
    )
}

/// A drum, its skin up: a shell between two hoops, with tension rods around it.
pub(crate) fn drum() -> TriMesh {
    let grid =
        Grid { center: [0.0; 3], low: [-1.3, -0.85, -1.3], high: [1.3, 0.85, 1.3], cell: 0.040, growth: 0.0 };
    surface(
        |p| {
            let axial = [p[0].hypot(p[2]), p[1], 0.0];
            let mut d = common(axial[0] - 1.0, p[1].abs() - 0.56, 0.10);
            // The skin lies a little below the hoop's edge.
            let hoop = common((axial[0] - 1.06).abs() - 0.065, (p[1].abs() - 0.52).abs() - 0.11, 0.06);
            d = join(d, hoop, 0.05);
            d.min(lugs(p, d))
        },
        &grid,
    )
}

/// Ten rods around the drum's shell, joined to the form at distance `d`.
fn lugs(p: Vec3, d: f64) -> f64 {
    let sector = std::f64::consts::TAU / 10.0;
    // One in front: the circle is folded onto a sector around it.
    let angle = p[0].atan2(p[2]);
    let folded = angle - sector * (angle / sector).round();
    let (s, c) = folded.sin_cos();
    let r = p[0].hypot(p[2]);
    let q = [r * s, p[1], r * c];
    let lug = rod(q, [0.0, -0.46, 1.055], [0.0, 0.46, 1.055], 0.055, 0.055);
    let middle = rod(q, [0.0, -0.10, 1.04], [0.0, 0.10, 1.04], 0.095, 0.095);
    join(d, join(lug, middle, 0.06), 0.05)
}
