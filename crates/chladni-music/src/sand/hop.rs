//! How far a grain hops, and where to.

use chladni_mesh::surface::SurfacePoint;

use super::{FALL_STEPS, HOP_STEPS, POUR_STEPS, QUIET, Tray};
use crate::stage::mixed;

/// C: how fast grains slide down.
const SLIDE: f64 = 0.32;
/// J: how far grains are thrown about.
const THROW: f64 = 0.20;

/// What is the same for all grains in a step.
pub(super) struct Hop<'a> {
    pub seed: u64,
    pub step: u64,
    pub tray: &'a Tray,
    /// u of each vertex, and the largest without its sign.
    pub speed: &'a [f32],
    pub most_speed: f32,
    pub level: f32,
    /// √(E / E_max) where all grains rest.
    pub rest: f32,
    /// ℓ.
    pub wave: f64,
    pub vigor: f64,
    /// How far a new figure throws.
    pub scatter: f64,
}

impl Hop<'_> {
    /// The way that a grain takes, in the plane of its triangle; `None` where it stays.
    pub fn of(&self, i: usize, grain: &SurfacePoint) -> Option<[f64; 2]> {
        if !(self.step + i as u64).is_multiple_of(HOP_STEPS) || self.step < landing(self.seed, i) {
            return None;
        }
        let corners = self.tray.triangles[grain.triangle as usize];
        let speeds = corners.map(|v| f64::from(self.speed[v as usize] / self.most_speed));
        let here: f64 = (0..3).map(|c| grain.weights[c] * speeds[c]).sum();
        let moved = here.abs() as f32;
        if moved < self.rest * friction(self.seed, i) || moved * self.level < QUIET {
            return None;
        }
        let slide = -SLIDE * self.wave * self.wave * self.vigor;
        // ∇u² = 2 u ∇u.
        let slope = self.tray.ground.slope(grain.triangle, speeds).map(|s| 2.0 * here * s);
        let thrown = THROW * self.wave * self.vigor * f64::from(moved) + self.scatter;
        let [x, y] = at_random(draw(self.seed, i, 2 + self.step));
        Some([slide * slope[0] + thrown * x, slide * slope[1] + thrown * y])
    }
}

/// The step at which a grain that is poured has landed.
pub(super) fn landing(seed: u64, grain: usize) -> u64 {
    FALL_STEPS + draw(seed, grain, 0) % (POUR_STEPS - FALL_STEPS)
}

/// How well a grain holds, in [0, 1).
pub(super) fn friction(seed: u64, grain: usize) -> f32 {
    unit(draw(seed, grain, 1)) as f32
}

/// Random bits that are a function of seed, grain and number alone.
pub(super) fn draw(seed: u64, grain: usize, number: u64) -> u64 {
    let z = seed ^ (grain as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    mixed(z.wrapping_add(number.wrapping_mul(0xd1b5_4a32_d192_ed03)))
}

/// In [0, 1).
pub(super) fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

/// A random vector: two numbers in [−1, 1], out of one draw.
fn at_random(bits: u64) -> [f64; 2] {
    let part = |bits: u32| f64::from(bits) / f64::from(u32::MAX) * 2.0 - 1.0;
    [part(bits as u32), part((bits >> 32) as u32)]
}
