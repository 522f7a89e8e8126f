//! A human figure.

use super::field::{ellipsoid, join, rod, sphere, turned};
use super::surface_nets::{Grid, surface};
use crate::TriMesh;
use crate::surface::vec3::Vec3;

/// A standing figure with its arms raised a little to the sides, about seven and a half heads high; it looks
/// along +z, y is up.
pub(crate) fn human() -> TriMesh {
    let grid = Grid {
        center: [0.0, 0.0, 0.0],
        low: [-1.0, -1.12, -0.45],
        high: [1.0, 1.12, 0.45],
        cell: 0.0165,
        growth: 0.0,
    };
    surface(solid, &grid)
}

/// The half at x ≥ 0.
fn solid(p: Vec3) -> f64 {
    let mut d = trunk(p);
    d = join(d, head(p), 0.05);
    d = join(d, arm(p), 0.06);
    // The legs part below the crotch: no seam may close the gap between them.
    let leg = leg(p);
    join(d, leg, 0.055)
}

fn head(p: Vec3) -> f64 {
    let skull = ellipsoid(p, [0.0, 0.905, -0.005], [0.098, 0.118, 0.118]);
    let face = ellipsoid(p, [0.0, 0.845, 0.030], [0.076, 0.098, 0.084]);
    let chin = sphere(p, [0.0, 0.772, 0.070], 0.034);
    let nose = rod(p, [0.0, 0.880, 0.108], [0.0, 0.848, 0.126], 0.013, 0.020);
    let ear = ellipsoid(turned(p, [0.097, 0.868, -0.005], 1, 0.35), [0.0; 3], [0.018, 0.036, 0.024]);
    let mut d = join(join(skull, face, 0.07), chin, 0.05);
    d = join(d, nose, 0.03);
    d = join(d, ear, 0.015);
    join(d, rod(p, [0.0, 0.80, -0.022], [0.0, 0.67, -0.030], 0.058, 0.064), 0.05)
}

fn trunk(p: Vec3) -> f64 {
    let chest = ellipsoid(p, [0.0, 0.46, -0.005], [0.192, 0.215, 0.122]);
    let breast = ellipsoid(p, [0.088, 0.475, 0.062], [0.088, 0.070, 0.058]);
    let shoulder = rod(p, [0.0, 0.615, -0.025], [0.205, 0.580, -0.020], 0.066, 0.064);
    let waist = ellipsoid(p, [0.0, 0.23, 0.0], [0.145, 0.190, 0.100]);
    let belly = ellipsoid(p, [0.0, 0.13, 0.030], [0.135, 0.130, 0.085]);
    let hips = ellipsoid(p, [0.0, 0.055, -0.008], [0.178, 0.125, 0.118]);
    let buttock = sphere(p, [0.082, 0.005, -0.060], 0.092);
    let mut d = join(chest, waist, 0.10);
    d = join(d, breast, 0.05);
    d = join(d, shoulder, 0.09);
    d = join(d, belly, 0.10);
    d = join(d, hips, 0.10);
    join(d, buttock, 0.05)
}

fn arm(p: Vec3) -> f64 {
    let (shoulder, elbow, wrist) = ([0.225, 0.575, -0.020], [0.455, 0.330, -0.040], [0.665, 0.150, 0.045]);
    let deltoid = sphere(p, [0.232, 0.562, -0.018], 0.072);
    let upper = rod(p, shoulder, elbow, 0.058, 0.044);
    let biceps = ellipsoid(turned(p, [0.335, 0.462, -0.018], 2, 0.82), [0.0; 3], [0.10, 0.052, 0.050]);
    let lower = rod(p, elbow, wrist, 0.046, 0.029);
    let forearm = ellipsoid(turned(p, [0.520, 0.276, -0.012], 2, 0.71), [0.0; 3], [0.095, 0.045, 0.043]);
    let palm = ellipsoid(turned(p, [0.715, 0.104, 0.066], 2, 0.74), [0.0; 3], [0.068, 0.030, 0.042]);
    let fingers = rod(p, [0.748, 0.074, 0.078], [0.812, 0.012, 0.104], 0.033, 0.022);
    let thumb = rod(p, [0.690, 0.128, 0.088], [0.722, 0.108, 0.142], 0.023, 0.018);
    let mut d = join(deltoid, upper, 0.05);
    d = join(d, biceps, 0.05);
    d = join(d, lower, 0.03);
    d = join(d, forearm, 0.05);
    d = join(d, palm, 0.03);
    d = join(d, fingers, 0.025);
    join(d, thumb, 0.02)
}

fn leg(p: Vec3) -> f64 {
    let (hip, knee, ankle) = ([0.098, 0.02, -0.005], [0.118, -0.455, 0.005], [0.126, -0.925, -0.040]);
    let thigh = rod(p, hip, knee, 0.102, 0.060);
    let muscle = ellipsoid(p, [0.112, -0.18, 0.015], [0.092, 0.225, 0.092]);
    let cap = sphere(p, [0.118, -0.450, 0.020], 0.058);
    let shin = rod(p, knee, ankle, 0.056, 0.036);
    let calf = ellipsoid(p, [0.124, -0.615, -0.030], [0.060, 0.155, 0.062]);
    let heel = sphere(p, [0.126, -0.990, -0.062], 0.045);
    let foot = rod(p, [0.128, -0.985, -0.02], [0.152, -1.005, 0.115], 0.048, 0.036);
    let toes = rod(p, [0.150, -1.008, 0.115], [0.162, -1.013, 0.160], 0.038, 0.026);
    let mut d = join(thigh, muscle, 0.06);
    d = join(d, cap, 0.05);
    d = join(d, shin, 0.03);
    d = join(d, calf, 0.06);
    d = join(d, heel, 0.04);
    d = join(d, foot, 0.05);
    join(d, toes, 0.03)
}
