//! The search for the longest displacement that keeps triangles.

use std::sync::Arc;

use chladni_harmonics::HeatStep;
use chladni_mesh::surface::vec3::{Vec3, add, length, scaled, sub};
use chladni_task::{Cancelled, Task};
use rayon::prelude::*;

use super::leveling::level;
use super::turning::turned;
use super::unfolding::unfold;
use super::{Keeper, Kept, Step, moved};
use crate::fold::flipped_triangles;
use crate::{Base, CaricatureError};

/// Folded and crossing triangles that are left alone, as a share of all: one in 2000 of each.
const LEFT: usize = 2000;
/// A displacement of more than this share of the unlimited one is not near it, and all the worse the longer it is.
const LONG: f64 = 2.0;
/// A displacement whose size is no more than this is rounding, in the working frame.
const STILL: f64 = 1e-12;

/// √t of the steps that make room for folded triangles, in the working frame.
const ROOM: f64 = 0.3;
/// How many such steps are taken before anything is held back.
const UNFOLDINGS: usize = 3;

/// One way to limit a displacement.
struct Attempt {
    /// Harmonics that count as the smooth form, in whose frames detail is carried.
    smooth: usize,
    /// Rounds that first level what folds.
    levelings: usize,
    /// The share of the exaggeration beyond which no further way is tried.
    enough: f64,
}

/// Where a displacement folds like noise, leveling keeps more of it; where it folds like cloth, making room does.
const ATTEMPTS: [Attempt; 4] = [
    Attempt { smooth: 64, levelings: 0, enough: 0.9 },
    Attempt { smooth: 64, levelings: 6, enough: 0.72 },
    Attempt { smooth: 16, levelings: 0, enough: 0.72 },
    Attempt { smooth: 16, levelings: 6, enough: 0.0 },
];

/// Rounds of holding back at most; the share that each takes off; √t of the heat around the bad places in the first
/// round, in the working frame; and the factor by which it grows each round.
const ROUNDS: usize = 24;
const HOLD: f64 = 0.3;
const REACH: f64 = 0.05;
const WIDER: f64 = 1.1;
/// A search gives up after this many rounds without progress. Holding back progresses if a tenth fewer triangles fold
/// or cross, giving back if [`GAIN`] more of the displacement is kept.
const PATIENCE: usize = 8;
const GAIN: f64 = 0.005;

/// If less than this share is kept, up to [`RETURNS`] rounds give back what was held back in excess. Each gives back
/// at most the share [`GIVEN`] of what is missing; less around the triangles that this spoils, then [`AGAIN`] times
/// more each time nothing is spoiled.
const SCANT: f64 = 0.85;
const RETURNS: usize = 24;
const GIVEN: f32 = 0.2;
const AGAIN: f32 = 1.5;
/// √t of the heat around triangles that a return would spoil, in the working frame.
const CLOSE: f64 = 0.015;

/// The heat steps of a search: these two, then one for each round that holds back.
const MAKES_ROOM: usize = 0;
const GIVES_BACK: usize = 1;
const HOLDS_BACK: usize = 2;
/// How many of them are kept: most searches need few rounds, and a factorization of 50,000 vertices takes about 25 MB.
pub(super) const KEPT_STEPS: usize = HOLDS_BACK + 4;
/// How many more a search keeps for its other attempts: all of them would take gigabytes on a large shape.
const SHARED_STEPS: usize = 4;

/// The search for the longest displacement near `unlimited`, from `base`, that keeps triangles.
pub(super) struct Search<'a> {
    keeper: &'a Keeper,
    base: &'a Base,
    unlimited: &'a [Vec3],
    /// χ.
    mask: Option<&'a [f32]>,
    task: &'a Task,
    /// Triangles that cross others in the base already, ascending.
    crossed: Vec<u32>,
    /// The next heat steps after those that the keeper keeps: each attempt takes the same.
    later_steps: [Step; SHARED_STEPS],
}

impl<'a> Search<'a> {
    pub(super) fn of(
        keeper: &'a Keeper,
        base: &'a Base,
        unlimited: &'a [Vec3],
        mask: Option<&'a [f32]>,
        task: &'a Task,
    ) -> Result<Self, CaricatureError> {
        // A shape that does not move crosses nothing new.
        let moves = size(unlimited, &base.basis().mass) > STILL;
        let crossed = if moves { keeper.crossings.triangles(&base.positions, task)? } else { Vec::new() };
        Ok(Self { keeper, base, unlimited, mask, task, crossed, later_steps: Default::default() })
    }

    /// The best of [`ATTEMPTS`]: it leaves next to nothing folded or crossing and, among those that do, keeps the
    /// most of the displacement.
    pub(super) fn best(&self) -> Result<Kept, CaricatureError> {
        if size(self.unlimited, &self.base.basis().mass) <= STILL {
            return Ok(self.kept(self.unlimited.to_vec(), (0, 0)));
        }
        let mut best: Option<(Kept, Vec<Vec3>)> = None;
        for attempt in &ATTEMPTS {
            let (kept, turned) = self.attempt(attempt)?;
            if best.as_ref().is_none_or(|(best, _)| self.rank(best) < self.rank(&kept)) {
                best = Some((kept, turned));
            }
            if best.as_ref().is_some_and(|(best, _)| self.rank(best) > (true, attempt.enough)) {
                break;
            }
        }
        let (mut best, turned) = best.ok_or(Cancelled)?;
        for wanted in [&turned, self.unlimited] {
            self.give_back(wanted, &mut best)?;
        }
        Ok(best)
    }

    /// The larger, the better.
    pub(super) fn rank(&self, kept: &Kept) -> (bool, f64) {
        let near = kept.share.min(1.0).min(LONG / kept.share);
        (self.are_few((kept.folded, kept.crossing)), near)
    }

    /// The displacement that one attempt keeps, and the unlimited one with only its frames turned.
    fn attempt(&self, attempt: &Attempt) -> Result<(Kept, Vec<Vec3>), CaricatureError> {
        let Keeper { surface, neighbors, pieces, .. } = self.keeper;
        // A small piece has hardly a smooth form that could turn.
        let share = self.mask.map(|mask| pieces.without_meant(surface, mask));
        let share = share.as_deref();
        let mut turned = turned(self.base, surface, neighbors, attempt.smooth, self.unlimited, share);
        self.carry_pieces(&mut turned);
        let mut wanted = turned.clone();
        for round in 0..attempt.levelings {
            level(surface, neighbors, &self.folded(&wanted), 2 + round, 4 + round, &mut wanted);
        }
        for _ in 0..UNFOLDINGS {
            self.unfold(&mut wanted)?;
        }
        let mut kept = self.limited(wanted.clone())?;
        self.give_back(&wanted, &mut kept)?;
        Ok((kept, turned))
    }

    /// Shortens `u` around what folds or crosses, in rounds.
    fn limited(&self, mut u: Vec<Vec3>) -> Result<Kept, CaricatureError> {
        let mut left = Vec::new();
        loop {
            let round = left.len();
            self.task.check()?;
            self.carry_pieces(&mut u);
            let [mut bad, mut crossing] = self.spoiled(&u)?;
            let counts = (bad.len(), crossing.len());
            left.push(counts.0 + counts.1);
            let earlier = left.iter().rev().nth(PATIENCE).copied();
            let stuck = earlier.is_some_and(|earlier| 10 * (counts.0 + counts.1) > 9 * earlier);
            if round == ROUNDS || stuck || self.are_few(counts) {
                return Ok(self.kept(u, counts));
            }
            if round < ROUNDS / 2 {
                self.unfold(&mut u)?;
            }
            bad.append(&mut crossing);
            let step = self.step(HOLDS_BACK + round, REACH * WIDER.powi(round as i32))?;
            let heat = self.heat_around(&bad, &step);
            u.par_iter_mut().zip(heat).for_each(|(u, heat)| *u = scaled(*u, 1.0 - HOLD * f64::from(heat)));
        }
    }

    /// The heat step of number `index`, of the reach `sqrt_t`: √t in the working frame.
    pub(super) fn step(&self, index: usize, sqrt_t: f64) -> Result<Arc<HeatStep>, CaricatureError> {
        let new = || self.keeper.flow.step(sqrt_t * sqrt_t).map(Arc::new);
        let kept = self.keeper.steps.iter().chain(&self.later_steps).nth(index);
        kept.map_or_else(new, |kept| kept.get_or_init(new).clone()).map_err(CaricatureError::from)
    }

    /// Moves `kept` toward `wanted` wherever that spoils no triangle, if it keeps [little](SCANT) and only a few
    /// triangles are spoiled already. Ends with the largest share that it reached.
    fn give_back(&self, wanted: &[Vec3], kept: &mut Kept) -> Result<(), CaricatureError> {
        if kept.share >= SCANT || !self.are_few((kept.folded, kept.crossing)) {
            return Ok(());
        }
        let close = self.step(GIVES_BACK, CLOSE)?;
        let mut u = kept.displacement.to_vec();
        let mut given = vec![GIVEN; wanted.len()];
        let mut shares = vec![kept.share];
        for _ in 0..RETURNS {
            self.task.check()?;
            let toward = |((u, wanted), given): ((&Vec3, &Vec3), &f32)| {
                add(*u, scaled(sub(*wanted, *u), f64::from(*given)))
            };
            let mut more: Vec<Vec3> = u.par_iter().zip(wanted).zip(&given).map(toward).collect();
            self.carry_pieces(&mut more);
            let [folded, crossing] = self.spoiled(&more)?;
            let counts = (folded.len(), crossing.len());
            if self.are_few(counts) {
                given.par_iter_mut().for_each(|given| *given = (*given * AGAIN).min(GIVEN));
                u.clone_from(&more);
                let more = self.kept(more, counts);
                if more.share > kept.share {
                    *kept = more;
                }
            } else {
                let heat = self.heat_around(&[folded, crossing].concat(), &close);
                given.par_iter_mut().zip(heat).for_each(|(given, heat)| *given *= 1.0 - heat);
            }
            if shares.iter().rev().nth(PATIENCE - 1).is_some_and(|before| kept.share < before + GAIN) {
                break;
            }
            shares.push(kept.share);
        }
        Ok(())
    }

    fn carry_pieces(&self, u: &mut [Vec3]) {
        self.keeper.pieces.carry(&self.keeper.surface, &self.base.positions, self.mask, u);
    }

    fn kept(&self, u: Vec<Vec3>, (folded, crossing): (usize, usize)) -> Kept {
        let mass = &self.base.basis().mass;
        let whole = size(self.unlimited, mass);
        let share = if whole > STILL { size(&u, mass) / whole } else { 1.0 };
        Kept { displacement: Arc::new(u), share, folded, crossing }
    }

    /// Whether these counts of folded and crossing triangles are few enough to be left alone.
    fn are_few(&self, (folded, crossing): (usize, usize)) -> bool {
        folded.max(crossing) * LEFT <= self.keeper.surface.whole_triangles()
    }

    /// The triangles that `u` folds, and those that it makes cross others.
    fn spoiled(&self, u: &[Vec3]) -> Result<[Vec<u32>; 2], Cancelled> {
        let moved = moved(&self.base.positions, u);
        let mut crossing = self.keeper.crossings.triangles(&moved, self.task)?;
        crossing.retain(|t| self.crossed.binary_search(t).is_err());
        Ok([self.folded(u), crossing])
    }

    fn folded(&self, u: &[Vec3]) -> Vec<u32> {
        let x = &self.base.positions;
        flipped_triangles(&self.keeper.surface, x, &moved(x, u))
    }

    fn unfold(&self, u: &mut [Vec3]) -> Result<(), CaricatureError> {
        let (step, mass) = (self.step(MAKES_ROOM, ROOM)?, &self.base.basis().mass);
        unfold(&self.keeper.surface, &self.base.positions, &step, ROOM * ROOM, mass, u);
        Ok(())
    }

    /// 1 at the triangles `bad` and close by, fading out as far as `step` reaches.
    fn heat_around(&self, bad: &[u32], step: &HeatStep) -> Vec<f32> {
        let surface = &self.keeper.surface;
        let mut spots = vec![0.0_f32; surface.vertices()];
        bad.iter().flat_map(|t| surface.triangles[*t as usize]).for_each(|v| spots[v as usize] = 1.0);
        step.apply(&spots).into_iter().map(|heat| (4.0 * heat).min(1.0) as f32).collect()
    }
}

/// ∫ |u| over the surface.
fn size(u: &[Vec3], mass: &[f64]) -> f64 {
    u.iter().zip(mass).map(|(u, a)| a * length(*u)).sum()
}
