//! Sand: grains on a surface, which vibrations drive to where nothing moves.
//!
//! The sound makes vertex v vibrate at a speed of u(v) = Σ_k w_k a_k H_k(v): a_k is the root mean square amplitude of
//! harmonic k over 0.2 s, times its frequency √λ_k; w_k lets the strongest ones draw the figure. All
//! are in phase, like those of a plate that is driven at one frequency. With E = u², grains hop: at each hop a grain
//! walks along the surface by
//!
//! ```text
//! −C ℓ² ∇E / E_max + J ℓ √(E / E_max) ξ,      ℓ = 1/√λ,
//! ```
//!
//! ξ being a random vector and ℓ the length of the waves that sound, both times a vigor in [0, 1] that grows
//! with the level of the sound; when the figure changes they are thrown farther, and are some steps on their way. Near nodal lines, and wherever the surface hardly moves, grains rest. docs/sand.md has the sources.

use std::sync::Arc;

use chladni_harmonics::{Basis, Body};
use chladni_mesh::surface::{Ground, SurfacePoint};
use chladni_synth::Item;
use rayon::prelude::*;

use crate::dancer::box_diagonal;
use crate::symmetry::slowest;
use hop::{Hop, draw, friction, landing, unit};

mod feeling;
mod hop;

/// Time between two steps of the sand.
pub const SAND_STEP_SECS: f64 = 1.0 / 60.0;

/// Steps from one hop of a grain to its next; its neighbors hop at others.
const HOP_STEPS: u64 = 3;
/// S, and the most: how far a new figure throws grains about, as a share of the bounding box's diagonal.
const SCATTER: f32 = 1.5;
const MOST_SCATTER: f32 = 0.2;
/// Half the width of a line of sand, as a share of the bounding box's diagonal: so near to a nodal line grains
/// may rest. Some slide more easily than others, which is why they fill the line.
const LINE: f32 = 0.008;
/// But none rests where √(E / E_max) is larger than this.
const MOST_REST: f32 = 0.3;
/// Where the speed is less than this share of that of a full movement of the slowest wave, grains rest.
const QUIET: f32 = 0.003;
/// How high grains hop at full vigor, as a share of the bounding box's diagonal.
const HOP_HEIGHT: f32 = 0.012;
/// From how high they are poured.
const POUR_HEIGHT: f32 = 0.30;
/// How long the pouring takes, and of it one grain's fall, in steps.
const POUR_STEPS: u64 = 60;
const FALL_STEPS: u64 = 27;
/// The most edges that a grain crosses in a step: one that is thrown farther is still on its way at the next.
const MOST_EDGES: usize = 6;
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
            slowest: slowest(&body.basis.eigenvalues),
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
    /// What each still has to go, in the plane of its triangle; 0 where it has landed.
    ways: Vec<[f32; 2]>,
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
        let grains: Vec<SurfacePoint> = (0..grains).filter_map(place).collect();
        Self {
            ways: vec![[0.0; 2]; grains.len()],
            grains,
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
            return self.ways.fill([0.0; 2]);
        }
        let new = (SCATTER * self.novelty.powi(3)).min(MOST_SCATTER);
        let hop = Hop {
            seed: self.seed,
            step,
            tray: &self.tray,
            speed: &self.speed,
            most_speed: self.most_speed,
            level: self.level,
            rest: self.rest(),
            wave: self.wave,
            vigor: f64::from(self.vigor),
            scatter: f64::from(new * self.tray.box_diagonal * self.vigor),
        };
        let chunks = self.grains.par_chunks_mut(CHUNK).zip(self.ways.par_chunks_mut(CHUNK)).enumerate();
        chunks.for_each(|(chunk, (grains, ways))| {
            for (i, (grain, left)) in (chunk * CHUNK..).zip(grains.iter_mut().zip(ways)) {
                let flies = *left != [0.0; 2];
                let way = if flies { Some(left.map(f64::from)) } else { hop.of(i, grain) };
                let Some(way) = way else { continue };
                let (at, rest) = hop.tray.ground.walk(*grain, way, MOST_EDGES);
                (*grain, *left) = (at, rest.map(|x| x as f32));
            }
        });
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
