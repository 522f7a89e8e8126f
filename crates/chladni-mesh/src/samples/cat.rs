//! A cat that sits.

use super::field::{carve, ellipsoid, join, rod, sphere, turned};
use super::surface_nets::{Grid, surface};
use crate::TriMesh;
use crate::surface::vec3::Vec3;

/// A sitting cat; it looks along +z, y is up. Its tail rises behind it.
pub(crate) fn cat() -> TriMesh {
    let grid = Grid {
        center: [0.0, 0.62, 0.2],
        low: [-0.8, -1.15, -1.25],
        high: [0.8, 1.3, 1.0],
        cell: 0.0235,
        growth: 0.5,
    };
    surface(solid, &grid)
}

/// The half at x ≥ 0.
fn solid(p: Vec3) -> f64 {
    let mut d = body(p);
    d = join(d, head(p), 0.10);
    d = join(d, front_leg(p), 0.07);
    d = join(d, haunch(p), 0.07);
    join(d, tail(p), 0.08)
}

fn body(p: Vec3) -> f64 {
    let rump = ellipsoid(p, [0.0, -0.58, -0.30], [0.44, 0.42, 0.48]);
    let back = rod(p, [0.0, -0.42, -0.26], [0.0, 0.16, 0.06], 0.36, 0.26);
    let chest = ellipsoid(p, [0.0, -0.05, 0.15], [0.28, 0.40, 0.25]);
    let neck = rod(p, [0.0, 0.10, 0.08], [0.0, 0.46, 0.14], 0.24, 0.20);
    join(join(join(rump, back, 0.20), chest, 0.15), neck, 0.15)
}

fn head(p: Vec3) -> f64 {
    let skull = ellipsoid(p, [0.0, 0.66, 0.20], [0.345, 0.285, 0.300]);
    let cheek = ellipsoid(p, [0.175, 0.565, 0.275], [0.165, 0.130, 0.150]);
    let muzzle = ellipsoid(p, [0.062, 0.555, 0.455], [0.088, 0.066, 0.080]);
    let chin = sphere(p, [0.0, 0.495, 0.430], 0.058);
    let nose = ellipsoid(p, [0.0, 0.625, 0.515], [0.044, 0.032, 0.032]);
    let bridge = rod(p, [0.0, 0.72, 0.40], [0.0, 0.635, 0.490], 0.075, 0.050);
    let mut d = join(skull, cheek, 0.12);
    d = join(d, bridge, 0.08);
    d = join(d, muzzle, 0.06);
    d = join(d, chin, 0.05);
    d = join(d, nose, 0.025);
    d = join(d, ear(p), 0.06);
    let socket = ellipsoid(turned(p, [0.150, 0.690, 0.480], 2, 0.30), [0.0; 3], [0.078, 0.060, 0.070]);
    let ball = ellipsoid(p, [0.145, 0.688, 0.405], [0.072, 0.072, 0.070]);
    let pupil = ellipsoid(p, [0.152, 0.690, 0.492], [0.018, 0.052, 0.034]);
    let d = join(carve(d, socket, 0.05), ball, 0.02);
    carve(d, pupil, 0.02)
}

/// A cone with a hollow that opens forward.
fn ear(p: Vec3) -> f64 {
    let tip = [0.285, 1.10, 0.130];
    let outer = rod(p, [0.205, 0.80, 0.165], tip, 0.150, 0.028);
    let hollow = rod(p, [0.215, 0.83, 0.275], [0.278, 1.05, 0.185], 0.110, 0.020);
    carve(outer, hollow, 0.03)
}

fn front_leg(p: Vec3) -> f64 {
    let shoulder = ellipsoid(p, [0.190, -0.16, 0.20], [0.130, 0.26, 0.170]);
    let leg = rod(p, [0.155, -0.20, 0.30], [0.140, -0.86, 0.40], 0.120, 0.080);
    let paw = ellipsoid(p, [0.145, -0.93, 0.460], [0.110, 0.085, 0.150]);
    let toe = |x: f64| sphere(p, [x, -0.945, 0.570], 0.048);
    let toes = toe(0.085).min(toe(0.150)).min(toe(0.213));
    join(join(join(shoulder, leg, 0.12), paw, 0.08), toes, 0.03)
}

fn haunch(p: Vec3) -> f64 {
    let thigh = ellipsoid(turned(p, [0.360, -0.60, -0.08], 0, 0.35), [0.0; 3], [0.170, 0.330, 0.350]);
    let foot = rod(p, [0.400, -0.930, -0.05], [0.425, -0.950, 0.330], 0.085, 0.078);
    let toe = |x: f64| sphere(p, [x, -0.955, 0.400], 0.046);
    let toes = toe(0.368).min(toe(0.430)).min(toe(0.490));
    join(join(thigh, foot, 0.08), toes, 0.03)
}

/// Along the ground, then up, its tip curled back.
fn tail(p: Vec3) -> f64 {
    const WAY: [[f64; 2]; 9] = [
        [-0.88, -0.55],
        [-0.93, -0.80],
        [-0.84, -0.98],
        [-0.60, -1.06],
        [-0.32, -1.04],
        [-0.06, -0.97],
        [0.18, -0.94],
        [0.38, -1.00],
        [0.50, -1.12],
    ];
    let at = |[y, z]: [f64; 2]| [0.0, y, z];
    let radius = |i: usize| 0.105 - 0.005 * i as f64;
    let rods = WAY.windows(2).enumerate().map(|(i, w)| rod(p, at(w[0]), at(w[1]), radius(i), radius(i + 1)));
    rods.fold(f64::INFINITY, |d, part| join(d.min(9.0), part, 0.03))
}
