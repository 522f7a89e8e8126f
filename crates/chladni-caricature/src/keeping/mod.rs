//! Exaggeration that keeps triangles: it neither folds the surface nor passes it through itself.

mod leveling;
mod pieces;
mod turning;
mod unfolding;

use std::sync::{Arc, OnceLock};

use chladni_harmonics::{HarmonicsError, HeatFlow, HeatStep};
use chladni_mesh::surface::vec3::{Vec3, add, length, scaled};
use chladni_mesh::surface::{Rows, vertex_neighbors};
use chladni_task::{Cancelled, Task};
use rayon::prelude::*;

use crate::fold::flipped_triangles;
use crate::softening::SharedFlow;
use crate::{Base, CaricatureError, Crossings, LayerId, Surface};
use leveling::level;
use pieces::SmallPieces;
use turning::turned;
use unfolding::unfold;

/// Triangles per task.
const PIECE: usize = 4096;

/// Folded and crossing triangles that are left alone, as a share of all: one in 2000 of each.
const LEFT: usize = 2000;

/// √t of the steps that make room for folded triangles, in the working frame, and t.
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

/// How many rounds hold back at most, by how much each does, and how far around the places that need it.
const ROUNDS: i32 = 24;
const HOLD: f64 = 0.3;
const REACH: f64 = 0.05;
const WIDER: f64 = 1.1;
/// After this many rounds that did not help by a tenth, no more are tried.
const PATIENCE: usize = 8;

/// What is prepared for a shape when it is first needed, and shared by all requests.
#[derive(Debug)]
pub(crate) struct SharedKeeper {
    surface: Arc<Surface>,
    flow: Arc<SharedFlow>,
    keeper: OnceLock<Result<Keeper, HarmonicsError>>,
}

impl SharedKeeper {
    pub(crate) fn of(surface: Arc<Surface>, flow: Arc<SharedFlow>) -> Self {
        Self { surface, flow, keeper: OnceLock::new() }
    }

    fn get(&self) -> Result<&Keeper, CaricatureError> {
        let new = || Ok(Keeper::of(self.surface.clone(), self.flow.get()?.clone()));
        self.keeper.get_or_init(new).as_ref().map_err(|error| error.clone().into())
    }
}

/// A layer's displacement that is to be limited; see [`Stack::unsettled`](crate::Stack::unsettled).
#[derive(Clone, Debug)]
pub struct KeepRequest {
    pub(crate) layer: LayerId,
    pub(crate) base: Arc<Base>,
    pub(crate) unlimited: Arc<Vec<Vec3>>,
    pub(crate) mask: Option<Arc<[f32]>>,
    pub(crate) keeper: Arc<SharedKeeper>,
}

impl KeepRequest {
    /// Limits it: the displacement is changed so that hardly a triangle folds or newly passes through another.
    /// Takes from milliseconds to many seconds, by the size of the shape and by how much there is to do.
    ///
    /// # Errors
    /// A surface on which no heat flows; [`CaricatureError::Cancelled`].
    pub fn run(&self, task: &Task) -> Result<Kept, CaricatureError> {
        self.keeper.get()?.keep(&self.base, &self.unlimited, self.mask.as_deref(), task)
    }

    /// Whether the other asks for the same.
    pub fn is_same(&self, other: &Self) -> bool {
        self.layer == other.layer
            && Arc::ptr_eq(&self.base, &other.base)
            && Arc::ptr_eq(&self.unlimited, &other.unlimited)
    }
}

struct Keeper {
    surface: Arc<Surface>,
    neighbors: Rows,
    crossings: Crossings,
    pieces: SmallPieces,
    flow: Arc<HeatFlow>,
    steps: Vec<OnceLock<Result<HeatStep, HarmonicsError>>>,
}

impl std::fmt::Debug for Keeper {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Keeper").finish_non_exhaustive()
    }
}

/// A displacement that keeps triangles.
#[derive(Clone, Debug)]
pub struct Kept {
    /// N, working frame.
    pub displacement: Arc<Vec<Vec3>>,
    /// The mean length of it as a share of the unlimited one's.
    pub share: f64,
    /// Triangles that fold all the same.
    pub folded: usize,
    /// Triangles that pass through others all the same, and did not before.
    pub crossing: usize,
}

impl Kept {
    /// `unlimited`, but where this displacement was held back, no longer than it is. This is shown for another μ
    /// or curve until that is limited itself.
    pub(crate) fn cap(&self, before: &[Vec3], unlimited: &[Vec3]) -> Vec<Vec3> {
        let capped = |((kept, before), now): ((&Vec3, &Vec3), &Vec3)| {
            let [kept, before, length] = [kept, before, now].map(|d| length(*d));
            if kept < 0.98 * before && length > kept { scaled(*now, kept / length) } else { *now }
        };
        self.displacement.par_iter().zip(before).zip(unlimited).map(capped).collect()
    }
}

impl Keeper {
    fn of(surface: Arc<Surface>, flow: Arc<HeatFlow>) -> Self {
        let neighbors = vertex_neighbors(surface.vertices(), &surface.triangles);
        let (crossings, pieces) = (Crossings::of(surface.clone()), SmallPieces::of(&surface));
        let steps = (0..=ROUNDS).map(|_| OnceLock::new()).collect();
        Self { surface, neighbors, crossings, pieces, flow, steps }
    }

    /// The heat step of `round`, or, at [`ROUNDS`], the one that makes room.
    fn step(&self, round: i32) -> Result<&HeatStep, CaricatureError> {
        let reach = if round == ROUNDS { ROOM } else { REACH * WIDER.powi(round) };
        let step = self.steps[round as usize].get_or_init(|| self.flow.step(reach * reach));
        step.as_ref().map_err(|error| error.clone().into())
    }

    /// The best of [`ATTEMPTS`]: of those that leave next to nothing folded or crossing, the one that keeps most of the
    /// displacement. `share` is χ.
    fn keep(
        &self,
        base: &Base,
        displacement: &[Vec3],
        share: Option<&[f32]>,
        task: &Task,
    ) -> Result<Kept, CaricatureError> {
        let mass = &base.basis().mass;
        let size = |u: &[Vec3]| u.iter().zip(mass).map(|(u, a)| a * length(*u)).sum::<f64>();
        let whole = size(displacement);
        if whole == 0.0 {
            let displacement = Arc::new(displacement.to_vec());
            return Ok(Kept { displacement, share: 1.0, folded: 0, crossing: 0 });
        }
        let crossed = self.crossings.triangles(&base.positions, task)?;
        let mut best: Option<Kept> = None;
        for Attempt { smooth, levelings, enough } in ATTEMPTS {
            let x = &base.positions;
            let mut kept = turned(base, &self.surface, &self.neighbors, smooth, displacement, share);
            self.pieces.carry(&self.surface, x, &mut kept);
            for round in 0..levelings {
                level(
                    &self.surface,
                    &self.neighbors,
                    &self.folded(x, &kept),
                    2 + round,
                    4 + round,
                    &mut kept,
                );
            }
            let (folded, crossing) = self.limit(base, &crossed, &mut kept, task)?;
            let attempt = Kept { share: size(&kept) / whole, displacement: Arc::new(kept), folded, crossing };
            let rank = |kept: &Kept| (self.is_left(kept.folded) && self.is_left(kept.crossing), kept.share);
            if best.as_ref().is_none_or(|best| rank(best) < rank(&attempt)) {
                best = Some(attempt);
            }
            if best.as_ref().is_some_and(|best| rank(best) > (true, enough)) {
                break;
            }
        }
        best.ok_or_else(|| Cancelled.into())
    }

    fn is_left(&self, triangles: usize) -> bool {
        triangles * LEFT <= self.surface.triangles.len()
    }

    /// Makes room for what folds, and then shortens `u` around what still folds or crosses, in rounds. The numbers of
    /// folded and of newly crossing triangles that are left.
    fn limit(
        &self,
        base: &Base,
        crossed: &[u32],
        u: &mut [Vec3],
        task: &Task,
    ) -> Result<(usize, usize), CaricatureError> {
        let (surface, x, mass) = (&*self.surface, &base.positions, &base.basis().mass);
        for _ in 0..UNFOLDINGS {
            unfold(surface, x, self.step(ROUNDS)?, ROOM * ROOM, mass, u);
        }
        let mut round = 0;
        let mut left = Vec::new();
        loop {
            task.check()?;
            self.pieces.carry(surface, x, u);
            let mut bad = self.folded(x, u);
            let mut crossing = self.crossings.triangles(&moved(x, u), task)?;
            crossing.retain(|t| crossed.binary_search(t).is_err());
            let counts = (bad.len(), crossing.len());
            left.push(counts.0 + counts.1);
            let earlier = left.iter().rev().nth(PATIENCE).copied();
            let stuck = earlier.is_some_and(|earlier| 10 * (counts.0 + counts.1) > 9 * earlier);
            if round == ROUNDS || stuck || self.is_left(counts.0) && self.is_left(counts.1) {
                return Ok(counts);
            }
            if round < ROUNDS / 2 {
                unfold(surface, x, self.step(ROUNDS)?, ROOM * ROOM, mass, u);
            }
            bad.append(&mut crossing);
            self.hold_back(&bad, self.step(round)?, u);
            round += 1;
        }
    }

    fn folded(&self, base: &[Vec3], u: &[Vec3]) -> Vec<u32> {
        flipped_triangles(&self.surface, base, &moved(base, u))
    }

    /// Shortens the displacement around the triangles `bad`; heat makes the shortening fade out without a seam.
    fn hold_back(&self, bad: &[u32], step: &HeatStep, u: &mut [Vec3]) {
        let mut spots = vec![0.0_f32; u.len()];
        bad.iter().flat_map(|t| self.surface.triangles[*t as usize]).for_each(|v| spots[v as usize] = 1.0);
        let heat = step.apply(&spots);
        u.par_iter_mut().zip(heat).for_each(|(u, heat)| *u = scaled(*u, 1.0 - HOLD * (4.0 * heat).min(1.0)));
    }
}

fn moved(base: &[Vec3], u: &[Vec3]) -> Vec<Vec3> {
    base.par_iter().zip(u).map(|(x, u)| add(*x, *u)).collect()
}
