//! Exaggeration that keeps triangles: it neither folds the surface nor passes it through itself.

mod leveling;
mod pieces;
mod search;
mod turning;
mod unfolding;

use std::sync::{Arc, OnceLock};

use chladni_harmonics::{HarmonicsError, HeatFlow, HeatStep};
use chladni_mesh::surface::vec3::{Vec3, add, length, scaled};
use chladni_mesh::surface::{Rows, vertex_neighbors};
use chladni_task::Task;
use rayon::prelude::*;

use crate::softening::SharedFlow;
use crate::{Base, CaricatureError, Crossings, LayerId, Surface};
use pieces::SmallPieces;
use search::{KEPT_STEPS, Search};

/// Triangles per task.
const PIECE: usize = 4096;

/// The keeper of a shape, prepared when first needed and shared by all requests.
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
        Search::of(self.keeper.get()?, &self.base, &self.unlimited, self.mask.as_deref(), task)?.best()
    }

    /// Whether the other asks for the same.
    pub fn is_same(&self, other: &Self) -> bool {
        self.layer == other.layer
            && Arc::ptr_eq(&self.base, &other.base)
            && Arc::ptr_eq(&self.unlimited, &other.unlimited)
    }
}

/// A heat step, made when first needed.
type Step = OnceLock<Result<Arc<HeatStep>, HarmonicsError>>;

struct Keeper {
    surface: Arc<Surface>,
    neighbors: Rows,
    crossings: Crossings,
    pieces: SmallPieces,
    flow: Arc<HeatFlow>,
    /// The first of the heat steps.
    steps: [Step; KEPT_STEPS],
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
        Self { surface, neighbors, crossings, pieces, flow, steps: Default::default() }
    }
}

fn moved(base: &[Vec3], u: &[Vec3]) -> Vec<Vec3> {
    base.par_iter().zip(u).map(|(x, u)| add(*x, *u)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::base_and_target;

    #[test]
    fn rounding_is_no_movement_to_be_held_back() {
        let (_, surface, base, _) = base_and_target();
        let flow = HeatFlow::on_surface(&surface.positions, &surface.triangles).unwrap();
        let keeper = Keeper::of(Arc::new(surface), Arc::new(flow));
        let rounding: Vec<Vec3> = base.positions.iter().map(|x| x.map(|c| 1e-16 * (1e4 * c).sin())).collect();
        let kept = Search::of(&keeper, &base, &rounding, None, &Task::new()).unwrap().best().unwrap();
        assert_eq!((kept.share, kept.displacement.to_vec()), (1.0, rounding));
    }

    #[test]
    fn keeping_all_is_better_than_keeping_less_or_many_times_more() {
        let (_, surface, base, _) = base_and_target();
        let flow = HeatFlow::on_surface(&surface.positions, &surface.triangles).unwrap();
        let keeper = Keeper::of(Arc::new(surface), Arc::new(flow));
        let (still, task) = (vec![[0.0; 3]; base.positions.len()], Task::new());
        let search = Search::of(&keeper, &base, &still, None, &task).unwrap();
        let rank = |share: f64, folded: usize| {
            search.rank(&Kept { displacement: Arc::default(), share, folded, crossing: 0 })
        };
        assert!(rank(0.0, 0) < rank(0.8, 0) && rank(0.8, 0) < rank(1.0, 0));
        assert!(rank(900.0, 0) < rank(0.8, 0) && rank(1.0, 9) < rank(0.8, 0));
        assert_eq!(rank(1.1, 0), rank(1.0, 0));
    }

    #[test]
    fn only_the_first_heat_steps_are_kept_and_the_others_for_one_search() {
        let (_, surface, base, _) = base_and_target();
        let flow = HeatFlow::on_surface(&surface.positions, &surface.triangles).unwrap();
        let keeper = Keeper::of(Arc::new(surface), Arc::new(flow));
        let (still, task) = (vec![[0.0; 3]; base.positions.len()], Task::new());
        for (index, is_kept) in [(0, true), (KEPT_STEPS - 1, true), (KEPT_STEPS, false)] {
            let search = Search::of(&keeper, &base, &still, None, &task).unwrap();
            let step = Arc::downgrade(&search.step(index, 0.1).unwrap());
            drop(search);
            assert_eq!(step.upgrade().is_some(), is_kept, "{index}");
        }
        let search = Search::of(&keeper, &base, &still, None, &task).unwrap();
        let step = Arc::downgrade(&search.step(KEPT_STEPS, 0.1).unwrap());
        assert!(Arc::ptr_eq(&step.upgrade().unwrap(), &search.step(KEPT_STEPS, 0.1).unwrap()));
        drop(search);
        assert!(step.upgrade().is_none());
    }
}
