//! Suggestions: which children to show next. They should look different from each other, and similar to
//! what was chosen so far.
//!
//! The paper shows whatever breeding gives. Here breeding gives [`CANDIDATES`] children, and the gallery
//! shows those that are most worth looking at:
//!
//! 1. Each candidate is described by how it moves the shape ([`Descriptor`]). Those without any effect are left out.
//! 2. A preference is derived from the generations so far: near a chosen item is good, near an item that was
//!    passed over is bad, and recent choices count most. Of candidates that look alike, only the best is kept, and
//!    of those only the better part. (Children of like parents are twins, which are all equally good.)
//! 3. Of these, the best is taken first, then repeatedly the one that is farthest from all those taken so
//!    far (farthest-first traversal; T. Gonzalez, *Theoretical Computer Science* 38, 1985).
//!
//! An action records only the numbers of the candidates, which lets a show be repeated without describing
//! any of them.

use rayon::prelude::*;

use crate::gallery::CANDIDATES;
use crate::{BreedingError, Gallery, Genome};

/// A movement or deformation with a smaller norm counts as none.
const STILL: f32 = 1e-5;

/// The appearance of an item, independent of its strength: a unit vector, or zeros for an item without any effect.
/// Items that look alike have vectors that are close to each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Descriptor(Vec<f32>);

impl Descriptor {
    /// The descriptor of an item that moves some places of a shape by `movement`. The vector is normalized;
    /// otherwise all items with small movements would seem alike.
    pub fn of(mut movement: Vec<f32>) -> Self {
        let length = movement.iter().map(|x| x * x).sum::<f32>().sqrt();
        let scale = if length > STILL { 1.0 / length } else { 0.0 };
        movement.iter_mut().for_each(|x| *x *= scale);
        Self(movement)
    }

    /// The Euclidean distance: 0 for movements that differ only in size, 2 for opposite ones.
    pub fn distance(&self, other: &Self) -> f32 {
        let squares = self.0.iter().zip(&other.0).map(|(a, b)| (a - b) * (a - b));
        squares.sum::<f32>().sqrt()
    }

    /// Whether it is that of an item without any effect.
    pub fn is_still(&self) -> bool {
        self.0.iter().all(|x| *x == 0.0)
    }
}

/// Computes the descriptors of items.
pub trait Describe<G>: Sync {
    /// Why an item cannot be described.
    type Error: From<BreedingError> + Send;

    /// The descriptor of `genome`.
    ///
    /// # Errors
    /// The genome is not valid for this describer.
    fn describe(&self, genome: &G) -> Result<Descriptor, Self::Error>;
}

/// How many generations the preference takes into account.
const REMEMBERED: usize = 8;
/// The weight of a generation relative to the one after it.
const FADING: f32 = 0.6;
/// The weight of an item that was passed over, relative to a chosen one.
const PASSED_OVER: f32 = 0.25;
/// The share of candidates that the preference keeps.
const PREFERRED: f32 = 0.3;

/// Items nearer to each other than this look alike: vectors of 3° between them.
const TWINS: f32 = 0.05;

/// Which descriptors were chosen so far and which were passed over, each with its weight.
#[derive(Clone, Debug, Default)]
struct Preference {
    seen: Vec<(Descriptor, f32)>,
    /// The distance over which a weight decays to 1/e.
    width: f32,
}

impl Preference {
    /// The preference expressed in the generations that led to the current one.
    fn of<G: Genome, D: Describe<G>>(gallery: &Gallery<G>, describer: &D) -> Result<Self, D::Error> {
        let seen: Vec<(Descriptor, f32)> = gallery
            .opinions()
            .take(REMEMBERED)
            .enumerate()
            .flat_map(|(age, items)| items.iter().map(move |item| (age, item)))
            .collect::<Vec<_>>()
            .into_par_iter()
            .map(|(age, item)| {
                let liked = match (item.chosen, item.forgotten) {
                    (true, true) => 0.0,
                    (true, false) => 1.0,
                    (false, _) => -PASSED_OVER,
                };
                Ok((describer.describe(&item.genome)?, liked * FADING.powi(age as i32)))
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

    /// The larger, the more `candidate` resembles chosen items.
    fn score(&self, candidate: &Descriptor) -> f32 {
        let near = |(seen, weight): &(Descriptor, f32)| {
            weight * (-(seen.distance(candidate) / self.width).powi(2)).exp()
        };
        self.seen.iter().map(near).sum()
    }
}

/// The numbers of the candidates to show, one for each place of the gallery. Those of locked places are 0, which
/// [`Gallery::breed_from`] does not use. If fewer candidates than places differ, they are repeated in turn.
///
/// # Errors
/// [`BreedingError::NotEnoughParents`] if nothing is chosen; the errors of `describer`.
pub fn suggest<G: Genome, D: Describe<G>>(gallery: &Gallery<G>, describer: &D) -> Result<Vec<u16>, D::Error> {
    let candidates = gallery.candidates()?;
    let described: Vec<Descriptor> =
        candidates.par_iter().map(|genome| describer.describe(genome)).collect::<Result<_, _>>()?;
    let preference = Preference::of(gallery, describer)?;
    let scores: Vec<f32> = described.par_iter().map(|d| preference.score(d)).collect();
    let mut order: Vec<usize> = (0..CANDIDATES).filter(|&i| !described[i].is_still()).collect();
    if order.is_empty() {
        order = (0..CANDIDATES).collect();
    }
    order.sort_by(|&i, &j| scores[j].total_cmp(&scores[i]).then(i.cmp(&j)));
    let places = gallery.items().len();
    let mut order = without_twins(&described, &order, places);
    order.truncate(((PREFERRED * order.len() as f32) as usize).max(places));
    let locked = gallery.items().iter().filter(|item| item.locked);
    let locked: Vec<Descriptor> =
        locked.map(|item| describer.describe(&item.genome)).collect::<Result<_, _>>()?;
    let shown = farthest_first(&described, &order, &locked, places - locked.len());
    let mut shown = shown.into_iter().map(|i| i as u16).cycle();
    let for_place = |is_locked: bool| if is_locked { 0 } else { shown.next().unwrap_or(0) };
    Ok(gallery.items().iter().map(|item| item.locked).map(for_place).collect())
}

/// The indices of `count` items of `described` that differ most from each other, each once; all of them if there
/// are fewer.
pub fn most_different(described: &[Descriptor], count: usize) -> Vec<usize> {
    farthest_first(described, &(0..described.len()).collect::<Vec<_>>(), &[], count)
}

/// Those of `order` that no earlier one of it looks like; at least `least` of them where there are that many.
fn without_twins(described: &[Descriptor], order: &[usize], least: usize) -> Vec<usize> {
    let mut apart = TWINS;
    loop {
        let mut distinct: Vec<usize> = Vec::new();
        for &i in order {
            if distinct.par_iter().all(|&j| described[i].distance(&described[j]) > apart) {
                distinct.push(i);
            }
        }
        if distinct.len() >= least.min(order.len()) || apart < STILL {
            return distinct;
        }
        apart *= 0.5;
    }
}

/// The first of `order`, then repeatedly the one that is farthest from all taken so far and from `besides`. Each is
/// taken once.
fn farthest_first(
    described: &[Descriptor],
    order: &[usize],
    besides: &[Descriptor],
    count: usize,
) -> Vec<usize> {
    let from_besides = |i: usize| besides.iter().map(|d| d.distance(&described[i])).fold(f32::MAX, f32::min);
    let mut nearest: Vec<f32> = order.iter().map(|&i| from_besides(i)).collect();
    let count = count.min(order.len());
    let mut taken: Vec<usize> = Vec::with_capacity(count);
    let mut next = 0;
    while taken.len() < count {
        taken.push(order[next]);
        let last = &described[order[next]];
        nearest.iter_mut().zip(order).for_each(|(d, &i)| *d = d.min(last.distance(&described[i])));
        nearest[next] = f32::NEG_INFINITY;
        // Among several at the same distance, the best liked one wins: it comes first in `order`.
        next = (0..order.len()).rev().max_by(|&a, &b| nearest[a].total_cmp(&nearest[b])).unwrap_or(0);
    }
    taken
}

#[cfg(test)]
mod tests {
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// +1, −1 or 0, which never changes.
    #[derive(Clone)]
    struct Side(f32);

    impl Genome for Side {
        fn child(mother: &Self, father: &Self, rng: &mut ChaCha8Rng) -> Self {
            if rng.random_bool(0.5) { mother.clone() } else { father.clone() }
        }

        fn mutant(&self, _: f32, _: &mut ChaCha8Rng) -> Self {
            self.clone()
        }

        fn genes(&self) -> usize {
            1
        }
    }

    struct BySide;

    impl Describe<Side> for BySide {
        type Error = BreedingError;

        fn describe(&self, genome: &Side) -> Result<Descriptor, BreedingError> {
            Ok(Descriptor::of(vec![genome.0]))
        }
    }

    #[test]
    fn each_is_named_once_also_where_all_look_alike() {
        let alike = vec![Descriptor::of(vec![1.0, 0.0]); 3];
        assert_eq!(most_different(&alike, 2), [0, 1]);
        assert_eq!(most_different(&alike, 5), [0, 1, 2]);
        assert!(most_different(&[], 5).is_empty());
    }

    #[test]
    fn two_candidates_that_differ_share_the_places() {
        let sides = |i: u8| Side(if i.is_multiple_of(2) { 1.0 } else { -1.0 });
        let mut gallery = Gallery::new(7, 6, |_| (0..6).map(sides).collect()).unwrap();
        gallery.choose(0, true).unwrap();
        gallery.choose(1, true).unwrap();
        let numbers = suggest(&gallery, &BySide).unwrap();
        assert_eq!(numbers.iter().filter(|number| **number == numbers[0]).count(), 3, "{numbers:?}");
    }

    #[test]
    fn candidates_without_effect_are_suggested_only_where_all_are() {
        let with = |second: f32| {
            let sides = |i: u8| Side(if i == 0 { 0.0 } else { second });
            let mut gallery = Gallery::new(7, 6, |_| (0..6).map(sides).collect()).unwrap();
            gallery.choose(0, true).unwrap();
            gallery.choose(1, true).unwrap();
            let numbers = suggest(&gallery, &BySide).unwrap();
            let candidates = gallery.candidates().unwrap();
            assert!(candidates.iter().any(|candidate| candidate.0 == 0.0));
            numbers.iter().filter(|number| candidates[usize::from(**number)].0 == 0.0).count()
        };
        assert_eq!((with(1.0), with(0.0)), (0, 6));
    }
}
