//! Two human heads: one of character, one plain.

use super::field::{carve, common, ellipsoid, join, rod, sphere, turned};
use super::head_parts;
use super::surface_nets::{Grid, surface};
use crate::TriMesh;
use crate::surface::vec3::{Vec3, sub};

/// The features that tell one face from another. Lengths in units of half a head's height.
pub(super) struct Features {
    /// How far the tip of the nose stands out, and its radius.
    nose: f64,
    nose_radius: f64,
    /// How far the bridge is humped.
    hump: f64,
    /// How far the chin stands out and reaches down.
    chin: f64,
    /// Radius of the brow ridge.
    brow: f64,
    /// Scale of the ears, and how far they stand off, in radians.
    ears: f64,
    ears_off: f64,
    /// How far the corners of the jaw stand out.
    jaw: f64,
    /// Fullness of lips and cheekbones.
    lips: f64,
    cheeks: f64,
    /// Adam's apple.
    larynx: f64,
    /// Height of the crown.
    crown: f64,
}

const CHARACTER: Features = Features {
    nose: 0.15,
    nose_radius: 0.135,
    hump: 0.045,
    chin: 0.10,
    brow: 0.115,
    ears: 1.22,
    ears_off: 0.55,
    jaw: 0.05,
    lips: 0.020,
    cheeks: 0.05,
    larynx: 0.07,
    crown: 0.06,
};

pub(super) const PLAIN: Features = Features {
    nose: 0.0,
    nose_radius: 0.095,
    hump: 0.0,
    chin: 0.0,
    brow: 0.085,
    ears: 1.0,
    ears_off: 0.30,
    jaw: 0.0,
    lips: 0.0,
    cheeks: 0.0,
    larynx: 0.0,
    crown: 0.0,
};

/// A bald man's head with a big nose and chin and ears that stand off: the sample shape. It
/// looks along +z, y is up, x its left, and its two sides are mirror images.
pub(crate) fn head() -> TriMesh {
    modeled(&CHARACTER, CELL)
}

/// A plain head in the same pose: the sample template.
pub(crate) fn template() -> TriMesh {
    modeled(&PLAIN, CELL)
}

/// The sample template with a tenth of its vertices, quick to make: the model by which heads are recognized.
pub(crate) fn coarse_template() -> TriMesh {
    modeled(&PLAIN, 3.0 * CELL)
}

/// Side of the finest cells of the samples.
const CELL: f64 = 0.0255;

fn modeled(features: &Features, cell: f64) -> TriMesh {
    let grid =
        Grid { center: [0.0, -0.2, 0.5], low: [-1.2, -1.62, -1.3], high: [1.2, 1.4, 1.4], cell, growth: 0.9 };
    surface(|p| solid(p, features), &grid)
}

/// The [`borders`](head_parts::borders) around a point on the plain head, or on that of character.
pub(crate) fn borders([x, y, z]: Vec3, of_character: bool) -> [f64; head_parts::PARTS.len()] {
    let f = if of_character { &CHARACTER } else { &PLAIN };
    let p = [x.abs(), y, z];
    let (upper, lower) = lips(p, f);
    let features = head_parts::Features {
        nose: nose_of(p, f),
        eyes: socket(p).min(sphere(p, EYE, 0.195)),
        mouth: upper.min(lower),
        ears: ear(p, f),
    };
    let moved = sub(chin(f), chin(&PLAIN));
    head_parts::borders(&features, plain_forms(head_parts::chin_back(p, chin(f), moved)))
}

/// How far a point of the half at x ≥ 0 is from brow, chin, jaw, cheeks, cranium and neck of the plain head.
pub(super) fn plain_forms(p: Vec3) -> [f64; 6] {
    let form = Skull::at(p, &PLAIN);
    let cheeks = form.face.min(form.bone).min(form.flesh);
    // Places that join two forms lie off both: the smaller forms reach out for them.
    [form.brow - 0.03, form.chin - 0.03, form.jaw, cheeks, form.cranium, neck(p, &PLAIN)]
}

/// The half of the head at x ≥ 0.
fn solid(p: Vec3, f: &Features) -> f64 {
    let mut d = skull(p, f);
    d = join(d, neck(p, f), 0.20);
    d = eye(d, p);
    d = nose(d, p, f);
    d = mouth(d, p, f);
    d = join(d, ear(p, f), 0.09);
    common(d, -1.42 - p[1], 0.12)
}

/// The distances of a point from the forms of the skull.
pub(super) struct Skull {
    pub cranium: f64,
    pub face: f64,
    pub jaw: f64,
    pub chin: f64,
    pub bone: f64,
    pub flesh: f64,
    pub brow: f64,
}

impl Skull {
    pub fn at(p: Vec3, f: &Features) -> Self {
        let cranium = ellipsoid(p, [0.0, 0.28 + 0.5 * f.crown, -0.12], [0.70, 0.70 + 0.5 * f.crown, 0.85]);
        let face = ellipsoid(p, [0.0, -0.26, 0.14], [0.57, 0.70, 0.58]);
        let jaw =
            rod(p, [0.36 + f.jaw, -0.52, 0.02], [0.13, -0.83 - 0.5 * f.chin, 0.44 + f.chin], 0.20, 0.16);
        let chin = ellipsoid(p, chin(f), [0.19, 0.14, 0.15]);
        let bone = sphere(p, [0.40, -0.13, 0.43 + 0.4 * f.cheeks], 0.19 + 0.5 * f.cheeks);
        let flesh = sphere(p, [0.27, -0.44, 0.42], 0.19);
        let brow = rod(p, [0.08, 0.165, 0.66], [0.42, 0.175, 0.50], f.brow, 0.85 * f.brow);
        Self { cranium, face, jaw, chin, bone, flesh, brow }
    }
}

/// The middle of the chin.
fn chin(f: &Features) -> Vec3 {
    [0.0, -0.87 - 0.6 * f.chin, 0.50 + 1.2 * f.chin]
}

fn skull(p: Vec3, f: &Features) -> f64 {
    let Skull { cranium, face, jaw, chin, bone, flesh, brow } = Skull::at(p, f);
    let mut d = join(cranium, face, 0.35);
    d = join(d, jaw, 0.25);
    d = join(d, chin, 0.14);
    d = join(d, bone, 0.22);
    d = join(d, flesh, 0.20);
    join(d, brow, 0.14)
}

/// The center of the ball.
const EYE: Vec3 = [0.265, 0.0, 0.565];

fn socket(p: Vec3) -> f64 {
    ellipsoid(p, [0.275, 0.005, 0.76], [0.20, 0.125, 0.13])
}

/// The socket, the ball with its iris, and the lids.
fn eye(d: f64, p: Vec3) -> f64 {
    let center = EYE;
    let iris = sphere(p, [center[0] - 0.008, center[1] + 0.004, center[2] + 0.178], 0.062);
    let ball = carve(sphere(p, center, 0.155), iris, 0.03);
    // The opening between the lids: a lens that rises a little outward.
    let q = turned(p, center, 2, 0.08);
    let opening = common(
        rod(q, [0.0, -0.118, 0.0], [0.0, -0.118, 1.0], 0.196, 0.196),
        rod(q, [0.0, 0.138, 0.0], [0.0, 0.138, 1.0], 0.200, 0.200),
        0.02,
    );
    let lids = carve(sphere(p, center, 0.195), opening, 0.05);
    let d = carve(d, socket(p), 0.10);
    join(join(d, lids, 0.05), ball, 0.025)
}

fn tip_of_nose(f: &Features) -> Vec3 {
    [0.0, -0.29 - 0.25 * f.nose, 0.82 + f.nose]
}

/// The nose alone, without nostrils.
fn nose_of(p: Vec3, f: &Features) -> f64 {
    let r = f.nose_radius;
    let tip = tip_of_nose(f);
    let middle = [0.0, -0.06, 0.735 + 0.45 * f.nose + f.hump];
    let upper = rod(p, [0.0, 0.16, 0.66], middle, 0.072, 0.082);
    let lower = rod(p, middle, tip, 0.082, r);
    // The form between the ridge and the face.
    let body = rod(p, [0.0, -0.02, 0.58], [0.0, tip[1] + 0.03, 0.66 + 0.45 * f.nose], 0.12, 0.9 * r + 0.03);
    let wing = ellipsoid(
        p,
        [0.74 * r + 0.045, tip[1] - 0.015, 0.745 + 0.62 * f.nose],
        [0.5 * r + 0.02, 0.55 * r + 0.015, 0.09 + 0.25 * f.nose],
    );
    join(join(join(upper, lower, 0.08), body, 0.10), wing, 0.05)
}

fn nose(d: f64, p: Vec3, f: &Features) -> f64 {
    let (r, tip) = (f.nose_radius, tip_of_nose(f));
    let nostril =
        ellipsoid(p, [0.52 * r + 0.012, tip[1] - 0.80 * r, 0.775 + 0.72 * f.nose], [0.034, 0.036, 0.052]);
    carve(join(d, nose_of(p, f), 0.10), nostril, 0.03)
}

/// The upper and the lower lip.
fn lips(p: Vec3, f: &Features) -> (f64, f64) {
    let full = f.lips;
    let upper = rod(p, [0.04, -0.540, 0.712 + full], [0.19, -0.568, 0.608], 0.042 + 0.5 * full, 0.020);
    let lower = rod(p, [0.0, -0.636, 0.704 + full], [0.155, -0.602, 0.620], 0.060 + 0.6 * full, 0.028);
    (upper, lower)
}

fn mouth(d: f64, p: Vec3, f: &Features) -> f64 {
    let full = f.lips;
    let mound = ellipsoid(p, [0.0, -0.565, 0.53], [0.28, 0.19, 0.20]);
    let (upper, lower) = lips(p, f);
    let slit = rod(p, [0.0, -0.586, 0.786 + full], [0.195, -0.574, 0.658], 0.018, 0.012);
    let groove = rod(p, [0.0, -0.42, 0.79], [0.0, -0.49, 0.77], 0.022, 0.026);
    let mut d = join(d, mound, 0.15);
    d = carve(d, groove, 0.05);
    d = join(d, join(upper, lower, 0.02), 0.07);
    carve(d, slit, 0.07)
}

/// A disc with a hollow and a lobe, its back edge standing off the head.
fn ear(p: Vec3, f: &Features) -> f64 {
    let root = [0.60, -0.12, -0.05];
    let q = turned(turned(p, root, 1, f.ears_off), [0.0; 3], 0, 0.18).map(|x| x / f.ears);
    let disc = ellipsoid(q, [0.035, 0.05, -0.13], [0.095, 0.27, 0.20]);
    let hollow = ellipsoid(q, [0.142, 0.055, -0.125], [0.085, 0.20, 0.135]);
    let lobe = ellipsoid(q, [0.030, -0.19, -0.06], [0.075, 0.10, 0.10]);
    let d = carve(disc, hollow, 0.05);
    join(d, lobe, 0.06) * f.ears
}

pub(super) fn neck(p: Vec3, f: &Features) -> f64 {
    let column = rod(p, [0.0, -0.50, -0.20], [0.0, -1.20, -0.28], 0.42, 0.40);
    let base = ellipsoid(p, [0.0, -1.62, -0.28], [0.70, 0.36, 0.50]);
    let muscle = rod(p, [0.56, -0.40, -0.24], [0.10, -1.32, 0.12], 0.07, 0.07);
    let throat = rod(p, [0.0, -0.74, 0.26], [0.0, -1.02, 0.02], 0.20, 0.20);
    let apple = sphere(p, [0.0, -1.02, 0.20 + 0.5 * f.larynx], 0.055 + 0.5 * f.larynx);
    let d = join(join(join(column, base, 0.35), muscle, 0.14), throat, 0.25);
    join(d, apple, 0.12)
}
