//! Sand: grains on a surface, which vibrations drive to where nothing moves.
//!
//! The sound makes vertex v vibrate at a speed of u(v) = Σ_k w_k a_k H_k(v): a_k is the root mean square amplitude of
//! harmonic k over about [`MEMORY_SECS`], times its frequency √λ_k; w_k lets the strongest ones draw the figure. All
//! are in phase, like those of a plate that is driven at one frequency. With E = u², grains hop: at each hop a grain
//! walks along the surface by
//!
//! ```text
//! −C ℓ² ∇E / E_max + J ℓ √(E / E_max) ξ,      ℓ = 1/√λ,
//! ```
//!
//! ξ being a random vector and ℓ the length of the waves that sound, both times a vigor in [0, 1] that grows
//! with the level of the sound; when the figure changes they are thrown farther. Near nodal lines, and wherever the surface hardly moves, grains rest. docs/sand.md has the sources.

use std::sync::Arc;

use chladni_harmonics::{Basis, Body};
use chladni_mesh::surface::{Ground, SurfacePoint};
use chladni_synth::{Coefficients, Item};
use rayon::prelude::*;

use crate::dancer::box_diagonal;
use crate::symmetry::first_waving;

/// Time between two steps of the sand.
pub const SAND_STEP_SECS: f64 = 1.0 / 60.0;

/// Steps from one hop of a grain to its next; its neighbors hop at others.
const HOP_STEPS: u64 = 3;
/// The energy of a harmonic is its mean over about this time.
const MEMORY_SECS: f32 = 0.2;
/// The most harmonics that drive the sand: those of the most energy.
const MOST_DRIVERS: usize = 12;
/// Harmonics of less than this share of the strongest one's energy do not drive it.
const LEAST_SHARE: f32 = 0.02;
/// A figure is new as far as it differs from that of about this time.
const HABIT_SECS: f32 = 0.8;
/// S, and the most: how far a new figure throws grains about, as a share of the bounding box's diagonal.
const SCATTER: f32 = 1.5;
const MOST_SCATTER: f32 = 0.2;
/// C: how fast grains slide down.
const SLIDE: f64 = 0.32;
/// J: how far grains are thrown about.
const THROW: f64 = 0.20;
/// Half the width of a line of sand, as a share of the bounding box's diagonal: so near to a nodal line grains
/// may rest. Some slide more easily than others, which is why they fill the line.
const LINE: f32 = 0.008;
/// But none rests where √(E / E_max) is larger than this.
const MOST_REST: f32 = 0.3;
/// Where the speed is less than this share of that of a full movement of the slowest wave, grains rest.
const QUIET: f32 = 0.003;
/// The share of it at which the vigor is one half.
const HALF_VIGOR: f32 = 0.1;
/// How high grains hop at full vigor, as a share of the bounding box's diagonal.
const HOP_HEIGHT: f32 = 0.012;
/// From how high they are poured.
const POUR_HEIGHT: f32 = 0.30;
/// How long the pouring takes, and of it one grain's fall, in steps.
const POUR_STEPS: u64 = 60;
const FALL_STEPS: u64 = 27;
/// Grains that one thread takes at a time.
const CHUNK: usize = 1024;

/// The surface and the harmonics of a body, as sand needs them.
#[derive(Clone, Debug)]
pub struct Tray {
    ground: Ground,
    triangles: Vec<[u32; 3]>,
    basis: Arc<Basis>,
    /// λ of the slowest wave.
    slowest: f64,
    box_diagonal: f32,
}

impl Tray {
    /// The tray of a body.
    pub fn new(body: &Body) -> Self {
        Self {
            ground: Ground::new(&body.positions, &body.triangles),
            triangles: body.triangles.clone(),
            slowest: body.basis.eigenvalues.get(first_waving(&body.basis)).copied().unwrap_or(1.0),
            basis: Arc::clone(&body.basis),
            box_diagonal: box_diagonal(&body.positions),
        }
    }

    /// The diagonal of the body's bounding box, in the working frame.
    pub fn box_diagonal(&self) -> f32 {
        self.box_diagonal
    }
}

/// A grain as it is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grain {
    /// The corners of its triangle, and their weights.
    pub corners: [u32; 3],
    /// They sum to 1.
    pub weights: [f32; 3],
    /// How high it flies, in the working frame.
    pub lift: f32,
}

/// Sand on a body. It changes only in [`step`](Self::step), and in the same way on any number of threads.
#[derive(Clone, Debug)]
pub struct Sand {
    tray: Arc<Tray>,
    seed: u64,
    grains: Vec<SurfacePoint>,
    /// Steps since it was poured, and those of them in which something moved.
    steps: u64,
    moves: u64,
    /// a_k² of each term of the dance, smoothed.
    powers: Vec<Vec<f32>>,
    /// u of each vertex, and the largest without its sign.
    speed: Vec<f32>,
    most_speed: f32,
    /// A slower mean of E, and how little the present one is like it, in [0, 1].
    habit: Vec<f32>,
    novelty: f32,
    /// ℓ.
    wave: f64,
    vigor: f32,
    /// The largest speed, as a share of that of a full movement of the slowest wave.
    level: f32,
}

impl Sand {
    /// Pours the given number of grains evenly on the surface; none where it has no area.
    pub fn pour(tray: Arc<Tray>, grains: usize, seed: u64) -> Self {
        let vertices = tray.basis.vertices();
        let place = |i: usize| {
            let share = (i as f64 + 0.5) / grains as f64;
            tray.ground.point_at(share, [unit(draw(seed, i, 0)), unit(draw(seed, i, 1))])
        };
        Self {
            grains: (0..grains).filter_map(place).collect(),
            seed,
            steps: 0,
            moves: 0,
            powers: Vec::new(),
            speed: vec![0.0; vertices],
            most_speed: 0.0,
            habit: vec![0.0; vertices],
            novelty: 0.0,
            wave: 1.0,
            vigor: 0.0,
            level: 0.0,
            tray,
        }
    }

    /// The tray that it lies on.
    pub fn tray(&self) -> &Tray {
        &self.tray
    }

    /// A number that changes whenever grains may have moved.
    pub fn version(&self) -> u64 {
        self.moves
    }

    /// How many grains there are: as many as were poured.
    pub fn count(&self) -> usize {
        self.grains.len()
    }

    /// Where the grains lie.
    pub fn places(&self) -> &[SurfacePoint] {
        &self.grains
    }

    /// Goes on by [`SAND_STEP_SECS`], in which `item` sounds; `full` is how far a full movement moves the
    /// shape, in the working frame.
    pub fn step(&mut self, item: &Item, full: f32) {
        self.feel(item, full);
        let step = self.steps;
        self.steps += 1;
        let moves = self.most_speed > 0.0 && self.level >= QUIET;
        self.moves += u64::from(moves || self.steps <= POUR_STEPS);
        if !moves {
            return;
        }
        let (seed, tray, speed) = (self.seed, &*self.tray, &self.speed);
        let (most, level, rest) = (self.most_speed, self.level, self.rest());
        let slide = -SLIDE * self.wave * self.wave * f64::from(self.vigor);
        let new = (SCATTER * self.novelty.powi(3)).min(MOST_SCATTER);
        let scatter = f64::from(new * tray.box_diagonal * self.vigor);
        let throw = THROW * self.wave * f64::from(self.vigor);
        self.grains.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, grains)| {
            for (i, grain) in (chunk * CHUNK..).zip(grains) {
                if !(step + i as u64).is_multiple_of(HOP_STEPS) || step < landing(seed, i) {
                    continue;
                }
                let corners = tray.triangles[grain.triangle as usize];
                let speeds = corners.map(|v| f64::from(speed[v as usize] / most));
                let here: f64 = (0..3).map(|c| grain.weights[c] * speeds[c]).sum();
                let moved = here.abs() as f32;
                if moved < rest * friction(seed, i) || moved * level < QUIET {
                    continue;
                }
                // ∇u² = 2 u ∇u.
                let slope = tray.ground.slope(grain.triangle, speeds).map(|s| 2.0 * here * s);
                let thrown = throw * f64::from(moved) + scatter;
                let [x, y] = at_random(draw(seed, i, 2 + step));
                let way = [slide * slope[0] + thrown * x, slide * slope[1] + thrown * y];
                *grain = tray.ground.walk(*grain, way);
            }
        });
    }

    /// Takes in the sounding item: the energy of each vertex, the length of the waves, the vigor.
    fn feel(&mut self, item: &Item, full: f32) {
        let keep = (-SAND_STEP_SECS as f32 / MEMORY_SECS).exp();
        let (basis, slowest) = (Arc::clone(&self.tray.basis), self.tray.slowest);
        let silence = vec![0.0; basis.harmonics()];
        self.powers.resize(self.powers.len().max(item.terms.len()), silence);
        for (t, powers) in self.powers.iter_mut().enumerate() {
            for (k, power) in powers.iter_mut().enumerate() {
                let now = item.terms.get(t).map_or(0.0, |term| strength(&term.coefficients, k));
                let fast = (basis.eigenvalues[k] / slowest) as f32;
                *power = keep * *power + (1.0 - keep) * fast * now;
            }
        }
        let drivers = self.drivers();
        let sum = |of: fn(f64) -> f64| -> f64 {
            drivers.iter().map(|&(k, share)| f64::from(share).powi(3) * of(basis.eigenvalues[k])).sum()
        };
        let (total, curved) = (sum(|_| 1.0), sum(|lambda| lambda));
        if curved > 0.0 {
            self.wave = (total / curved).sqrt();
        }
        let waves_of = |powers: &Vec<f32>| -> Waves<'_> {
            drivers.iter().map(|&(k, share)| (share * powers[k].sqrt(), basis.harmonic(k))).collect()
        };
        let waves: Vec<Waves<'_>> = self.powers.iter().map(waves_of).collect();
        let masks: Vec<Option<&[f32]>> =
            (0..waves.len()).map(|t| item.terms.get(t).and_then(|term| term.mask.as_deref())).collect();
        self.speed.par_iter_mut().enumerate().with_min_len(CHUNK).for_each(|(v, speed)| {
            let of_term = |(waves, mask): (&Waves<'_>, &Option<&[f32]>)| {
                mask.map_or(1.0, |mask| mask[v]) * waves.iter().map(|(a, h)| a * h[v] as f32).sum::<f32>()
            };
            *speed = waves.iter().zip(&masks).map(of_term).sum();
        });
        let forget = (-SAND_STEP_SECS as f32 / HABIT_SECS).exp();
        let (mut both, mut new, mut old) = (0.0_f32, 0.0_f32, 0.0_f32);
        for (habit, speed) in self.habit.iter_mut().zip(&self.speed) {
            let energy = speed * speed;
            *habit = forget * *habit + (1.0 - forget) * energy;
            both += *habit * energy;
            new += energy * energy;
            old += *habit * *habit;
        }
        let alike = (new * old).sqrt();
        self.novelty = if alike > 0.0 { (1.0 - both / alike).clamp(0.0, 1.0) } else { 0.0 };
        self.most_speed = self.speed.iter().fold(0.0, |most, speed| speed.abs().max(most));
        self.level = if full > 0.0 { self.most_speed / full } else { 0.0 };
        self.vigor = self.level / (self.level + HALF_VIGOR);
    }

    /// The harmonics that drive the sand, and the weights of their movements: one weaker than the strongest
    /// counts less still, so that few of them draw the figure. Constant ones have no frequency.
    fn drivers(&self) -> Vec<(usize, f32)> {
        let power = |k: usize| self.powers.iter().map(|powers| powers[k]).sum::<f32>();
        let mut all: Vec<(usize, f32)> = (0..self.tray.basis.harmonics()).map(|k| (k, power(k))).collect();
        all.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        all.truncate(MOST_DRIVERS);
        let most = all.first().map_or(0.0, |(_, power)| *power).max(f32::MIN_POSITIVE);
        all.iter_mut().for_each(|(_, power)| *power /= most);
        all.retain(|(_, share)| *share >= LEAST_SHARE);
        all
    }

    /// √(E / E_max) where all grains rest: near a nodal line it is the distance over ℓ.
    fn rest(&self) -> f32 {
        (LINE * self.tray.box_diagonal / self.wave as f32).min(MOST_REST)
    }

    /// The grains as they are to be drawn after the last step.
    pub fn grains(&self) -> impl IndexedParallelIterator<Item = Grain> + '_ {
        self.grains.par_iter().enumerate().with_min_len(CHUNK).map(|(i, grain)| {
            let corners = self.tray.triangles[grain.triangle as usize];
            Grain { corners, weights: grain.weights.map(|w| w as f32), lift: self.lift(i, corners, grain) }
        })
    }

    fn lift(&self, i: usize, corners: [u32; 3], grain: &SurfacePoint) -> f32 {
        let landing = landing(self.seed, i);
        if self.steps < landing {
            let left = (landing - self.steps) as f32 / FALL_STEPS as f32;
            // It falls faster and faster; before, it is not there yet, but high above.
            let fallen = 1.0 - left;
            let from = POUR_HEIGHT * self.tray.box_diagonal;
            return if left >= 1.0 { from } else { from * (1.0 - fallen * fallen) };
        }
        if self.most_speed <= 0.0 || self.level < QUIET {
            return 0.0;
        }
        let here: f32 = (0..3).map(|c| grain.weights[c] as f32 * self.speed[corners[c] as usize]).sum();
        let moved = here.abs() / self.most_speed;
        if moved < self.rest() * friction(self.seed, i) || moved * self.level < QUIET {
            return 0.0;
        }
        let phase = ((self.steps + i as u64) % HOP_STEPS) as f32 / HOP_STEPS as f32;
        let own = 0.2 + 0.8 * friction(self.seed, i);
        4.0 * phase * (1.0 - phase) * own * moved * self.vigor * HOP_HEIGHT * self.tray.box_diagonal
    }
}

/// Harmonics and what each is multiplied by.
type Waves<'a> = Vec<(f32, &'a [f64])>;

/// The step at which a grain that is poured has landed.
fn landing(seed: u64, grain: usize) -> u64 {
    FALL_STEPS + draw(seed, grain, 0) % (POUR_STEPS - FALL_STEPS)
}

/// How well a grain holds, in [0, 1).
fn friction(seed: u64, grain: usize) -> f32 {
    unit(draw(seed, grain, 1)) as f32
}

/// The squared amplitude of harmonic k.
fn strength(coefficients: &Coefficients, k: usize) -> f32 {
    match coefficients {
        Coefficients::Vector(c) => c.get(k).map_or(0.0, |c| c.iter().map(|c| c * c).sum()),
        Coefficients::Normal(c) => c.get(k).map_or(0.0, |c| c * c),
    }
}

/// Random bits that are a function of seed, grain and number alone (SplitMix64's finalizer; Steele, Lea and
/// Flood 2014).
fn draw(seed: u64, grain: usize, number: u64) -> u64 {
    let mut z = seed ^ (grain as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = z.wrapping_add(number.wrapping_mul(0xd1b5_4a32_d192_ed03));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// In [0, 1).
fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

/// A random vector: two numbers in [−1, 1], out of one draw.
fn at_random(bits: u64) -> [f64; 2] {
    let part = |bits: u32| f64::from(bits) / f64::from(u32::MAX) * 2.0 - 1.0;
    [part(bits as u32), part((bits >> 32) as u32)]
}
