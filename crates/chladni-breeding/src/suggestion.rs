//! Which children to show next: ones that look different from each other, and like what was chosen so far.
//!
//! The paper shows whatever breeding gives. Here it gives [`CANDIDATES`] children, of which the gallery shows
//! those that are most worth looking at:
//!
//! 1. Each candidate is described by how it moves the shape ([`Descriptor`]).
//! 2. A preference is read off the generations so far: near what was chosen is good, near what was passed over
//!    is bad, and what happened lately counts most. The better part of the candidates goes on.
//! 3. Among them the best is taken, then again and again the one that is farthest from all taken so far
//!    (farthest-first traversal; T. Gonzalez, *Theoretical Computer Science* 38, 1985).
//!
//! Only the candidates' numbers become part of an action, so that a show repeats without describing anything.

use rayon::prelude::*;

use crate::gallery::CANDIDATES;
use crate::{BreedingError, Gallery, Genome};

/// A movement or deformation that is smaller is none.
const STILL: f32 = 1e-5;

/// What an item looks like, whatever its strength: numbers that are near each other where items look alike.
#[derive(Clone, Debug, PartialEq)]
pub struct Descriptor(Vec<f32>);

impl Descriptor {
    /// Of how an item moves a shape at some places: how it looks, not how large it is, else all that hardly moves
    /// would be alike.
    pub fn of(mut movement: Vec<f32>) -> Self {
        let length = movement.iter().map(|x| x * x).sum::<f32>().sqrt();
        let scale = if length > STILL { 1.0 / length } else { 0.0 };
        movement.iter_mut().for_each(|x| *x *= scale);
        Self(movement)
    }

    /// 0 for movements that are the same but for their size, 2 for opposite ones.
    pub fn distance(&self, other: &Self) -> f32 {
        let squares = self.0.iter().zip(&other.0).map(|(a, b)| (a - b) * (a - b));
        squares.sum::<f32>().sqrt()
    }
}

/// Says what items look like.
pub trait Describe<G>: Sync {
    /// Why one cannot be described.
    type Error: From<BreedingError> + Send;

    /// What it looks like.
    ///
    /// # Errors
    /// A genome that is not valid here.
    fn describe(&self, genome: &G) -> Result<Descriptor, Self::Error>;
}

/// Generations that the preference remembers.
const REMEMBERED: usize = 8;
/// How much less an earlier generation counts than the one after it.
const FADING: f32 = 0.6;
/// How much being passed over counts against being chosen.
const PASSED_OVER: f32 = 0.25;
/// The share of candidates that the preference lets through.
const PREFERRED: f32 = 0.3;

/// What was liked so far, and what was not.
#[derive(Clone, Debug, Default)]
struct Preference {
    seen: Vec<(Descriptor, f32)>,
    /// The distance over which a liking fades.
    width: f32,
}

impl Preference {
    /// Of the generations that led to the one that is shown.
    fn of<G: Genome, D: Describe<G>>(gallery: &Gallery<G>, describer: &D) -> Result<Self, D::Error> {
        let seen: Vec<(Descriptor, f32)> = gallery
            .opinions()
            .take(REMEMBERED)
            .enumerate()
            .flat_map(|(age, items)| items.iter().map(move |item| (age, item)))
            .collect::<Vec<_>>()
            .into_par_iter()
            .map(|(age, item)| {
                let weight = FADING.powi(age as i32) * if item.chosen { 1.0 } else { -PASSED_OVER };
                Ok((describer.describe(&item.genome)?, weight))
            })
            .collect::<Result<_, D::Error>>()?;
        let newest: Vec<&Descriptor> = seen.iter().take(gallery.items().len()).map(|(d, _)| d).collect();
        let mut apart: Vec<f32> = (newest.iter().enumerate())
            .flat_map(|(i, a)| newest[..i].iter().map(|b| a.distance(b)).collect::<Vec<_>>())
            .collect();
        apart.sort_by(f32::total_cmp);
        let width = apart.get(apart.len() / 4).copied().unwrap_or(1.0).max(f32::MIN_POSITIVE);
        Ok(Self { seen, width })
    }

    /// Large where it is liked.
    fn score(&self, candidate: &Descriptor) -> f32 {
        let near = |(seen, weight): &(Descriptor, f32)| {
            weight * (-(seen.distance(candidate) / self.width).powi(2)).exp()
        };
        self.seen.iter().map(near).sum()
    }
}

/// The numbers of the candidates to show, one for each place of the gallery; those of locked places are not
/// used.
///
/// # Errors
/// As breeding does: [`BreedingError::NotEnoughParents`] where nothing is chosen; what `describer` says.
pub fn suggest<G: Genome, D: Describe<G>>(gallery: &Gallery<G>, describer: &D) -> Result<Vec<u16>, D::Error> {
    let candidates = gallery.candidates()?;
    let described: Vec<Descriptor> =
        candidates.par_iter().map(|genome| describer.describe(genome)).collect::<Result<_, _>>()?;
    let preference = Preference::of(gallery, describer)?;
    let scores: Vec<f32> = described.par_iter().map(|d| preference.score(d)).collect();
    let mut order: Vec<usize> = (0..CANDIDATES).collect();
    order.sort_by(|&i, &j| scores[j].total_cmp(&scores[i]).then(i.cmp(&j)));
    let places = gallery.items().len();
    order.truncate(((PREFERRED * CANDIDATES as f32) as usize).max(places));
    let locked = gallery.items().iter().filter(|item| item.locked);
    let locked: Vec<Descriptor> =
        locked.map(|item| describer.describe(&item.genome)).collect::<Result<_, _>>()?;
    Ok(farthest_first(&described, &order, &locked, places).into_iter().map(|i| i as u16).collect())
}

/// As many of `described` as asked for, by their numbers: those that differ most from each other.
pub fn most_different(described: &[Descriptor], count: usize) -> Vec<usize> {
    farthest_first(described, &(0..described.len()).collect::<Vec<_>>(), &[], count)
}

/// The first of `order`, then again and again the one that is farthest from all taken so far and from `besides`.
fn farthest_first(
    described: &[Descriptor],
    order: &[usize],
    besides: &[Descriptor],
    count: usize,
) -> Vec<usize> {
    let from_besides = |i: usize| besides.iter().map(|d| d.distance(&described[i])).fold(f32::MAX, f32::min);
    let mut nearest: Vec<f32> = order.iter().map(|&i| from_besides(i)).collect();
    let mut taken: Vec<usize> = Vec::with_capacity(count);
    let mut next = 0;
    while taken.len() < count && !order.is_empty() {
        taken.push(order[next]);
        let last = &described[order[next]];
        nearest.iter_mut().zip(order).for_each(|(d, &i)| *d = d.min(last.distance(&described[i])));
        // Of several that are equally far the better liked one, which comes first.
        next = (0..order.len()).rev().max_by(|&a, &b| nearest[a].total_cmp(&nearest[b])).unwrap_or(0);
    }
    taken
}
