//! A gallery of caricatures: choose some, and see their children.

mod sitter;
mod title;
mod variant;
mod weights;

use chladni_breeding::{
    ChaCha8Rng, Describe, Descriptor, Gallery, GalleryItem, ItemId, most_different, suggest,
};
use rand_chacha::rand_core::SeedableRng;
use rayon::prelude::*;

pub use sitter::{MOST_FOLDS, Portrait, Sitter, SitterPart};
pub use variant::{Group, Variant};

use crate::CaricatureError;

/// How many caricatures a gallery shows.
pub const GALLERY_SIZE: usize = 12;
/// Random variants among which the first gallery finds those that differ most.
const FIRST: usize = 160;
/// How many that differ are drawn for each one that is shown.
const DRAWN: usize = 3;
/// Variants that move less, or that lose more of their strength to their limit, are not shown first.
const LEAST_MOVED: f64 = 0.02;
const LEAST_KEPT: f64 = 0.5;
/// Random variants to choose from: the one that keeps the most of its strength is taken.
const SURPRISES: usize = 6;

/// Generations of twelve variants of one sitter.
#[derive(Clone, Debug, PartialEq)]
pub struct VariantGallery {
    generations: Gallery<Variant>,
    favorites: Vec<GalleryItem<Variant>>,
}

impl VariantGallery {
    /// Twelve random variants that differ as much as possible.
    ///
    /// # Errors
    /// A seed above 2⁶³ − 1.
    pub fn new(seed: u64, sitter: &Sitter) -> Result<Self, CaricatureError> {
        let first = first(sitter, None, seed)?;
        let generations = Gallery::new(seed, GALLERY_SIZE, |_| first)?;
        Ok(Self { generations, favorites: Vec::new() })
    }

    /// Twelve random variants as they come, to compare with.
    ///
    /// # Errors
    /// A seed above 2⁶³ − 1.
    pub fn random(seed: u64, sitter: &Sitter) -> Result<Self, CaricatureError> {
        let random = |rng: &mut ChaCha8Rng| {
            let one = |_| Variant::random(sitter.parts().len(), sitter.templates(), rng);
            (0..GALLERY_SIZE).map(one).collect()
        };
        Ok(Self { generations: Gallery::new(seed, GALLERY_SIZE, random)?, favorites: Vec::new() })
    }

    /// Twelve others, except that those locked in their places stay; groups that are locked stay as the first chosen variant
    /// has them, or the first of all.
    ///
    /// # Errors
    /// A seed above 2⁶³ − 1.
    pub fn restart(&mut self, seed: u64, sitter: &Sitter) -> Result<(), CaricatureError> {
        let items = self.generations.items();
        let model = items.iter().find(|item| item.chosen).or(items.first()).map(|item| item.genome.clone());
        let first = first(sitter, model.as_ref(), seed)?;
        let locked = items.iter().cloned().enumerate().filter(|(_, item)| item.locked);
        let locked: Vec<(usize, GalleryItem<Variant>)> = locked.collect();
        self.generations = self.generations.restart(seed, GALLERY_SIZE, |_| first)?;
        for (index, item) in locked {
            *self.generations.item_mut(index)? = GalleryItem { chosen: false, ..item };
        }
        Ok(())
    }

    /// The generations, and those that are shown.
    pub fn generations(&self) -> &Gallery<Variant> {
        &self.generations
    }

    /// The variants that are shown.
    pub fn variants(&self) -> Vec<&Variant> {
        self.generations.items().iter().map(|item| &item.genome).collect()
    }

    /// Chooses one as a parent, or no longer.
    ///
    /// # Errors
    /// An index beyond the last.
    pub fn choose(&mut self, index: usize, on: bool) -> Result<(), CaricatureError> {
        self.generations.item_mut(index)?.chosen = on;
        Ok(())
    }

    /// Keeps one in its place when the others are replaced, or no longer.
    ///
    /// # Errors
    /// An index beyond the last.
    pub fn lock_place(&mut self, index: usize, on: bool) -> Result<(), CaricatureError> {
        self.generations.item_mut(index)?.locked = on;
        Ok(())
    }

    /// Whether children inherit a group unchanged.
    pub fn is_locked(&self, group: Group) -> bool {
        self.generations.items().iter().any(|item| item.genome.is_locked(group))
    }

    /// From now on children have a group unchanged from one parent, or no longer.
    pub fn lock(&mut self, group: Group, on: bool) {
        for index in 0..self.generations.items().len() {
            if let Ok(item) = self.generations.item_mut(index) {
                item.genome.lock(group, on);
            }
        }
    }

    /// Shows children of those that are chosen: different from each other, and similar to the choices so far. None of them
    /// leaves the shape as it is, unless all do.
    ///
    /// # Errors
    /// Nothing chosen, or no room for more.
    pub fn breed(&mut self, sitter: &Sitter) -> Result<(), CaricatureError> {
        let candidates = suggest(&self.generations, sitter)?;
        Ok(self.generations.breed_from(&candidates)?)
    }

    /// Changes one a little, so that it still moves the shape where that is possible.
    ///
    /// # Errors
    /// An index beyond the last, or no room for more.
    pub fn mutate(&mut self, index: usize, sitter: &Sitter) -> Result<(), CaricatureError> {
        let moves = |variant: &Variant| sitter.describe(variant).is_ok_and(|movement| !movement.is_still());
        Ok(self.generations.mutate_until(index, 0.3, moves)?)
    }

    /// Shows the generation again from which the shown one came; false where it is the first.
    pub fn back(&mut self) -> bool {
        self.generations.back().is_some_and(|from| self.generations.go_to(from).is_ok())
    }

    /// Those that were marked as favorites, in any generation.
    pub fn favorites(&self) -> &[GalleryItem<Variant>] {
        &self.favorites
    }

    /// Marks one as a favorite, or no longer.
    ///
    /// # Errors
    /// An index beyond the last.
    pub fn favor(&mut self, index: usize, on: bool) -> Result<(), CaricatureError> {
        let item = self.generations.item_mut(index)?.clone();
        self.favorites.retain(|known| known.id != item.id);
        if on {
            self.favorites.push(item);
        }
        Ok(())
    }

    /// Whether one is a favorite.
    pub fn is_favorite(&self, id: ItemId) -> bool {
        self.favorites.iter().any(|known| known.id == id)
    }
}

/// Twelve random variants, far from each other, with the locked groups of `model`.
fn first(sitter: &Sitter, model: Option<&Variant>, seed: u64) -> Result<Vec<Variant>, CaricatureError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut random = || {
        let random = Variant::random(sitter.parts().len(), sitter.templates(), &mut rng);
        model.map_or_else(|| random.clone(), |model| model.keeping_locked(random.clone()))
    };
    let all: Vec<Variant> = (0..FIRST).map(|_| random()).collect();
    let described: Vec<Descriptor> =
        all.par_iter().map(|variant| sitter.describe(variant)).collect::<Result<_, _>>()?;
    let drawn = most_different(&described, DRAWN * GALLERY_SIZE);
    let portraits = sitter.portray(&drawn.iter().map(|i| &all[*i]).collect::<Vec<_>>())?;
    let is_shown = |portrait: &Portrait| portrait.moved >= LEAST_MOVED && portrait.kept >= LEAST_KEPT;
    // The best come first, so that they fill up where too few are good enough.
    let mut order: Vec<usize> = (0..portraits.len()).collect();
    let score = |i: &usize| (is_shown(&portraits[*i]), portraits[*i].moved * portraits[*i].kept);
    order.sort_by(|a, b| score(b).partial_cmp(&score(a)).unwrap_or(std::cmp::Ordering::Equal));
    let good = order.iter().filter(|i| is_shown(&portraits[**i])).count().max(GALLERY_SIZE);
    order.truncate(good);
    let good: Vec<Descriptor> = order.iter().map(|i| described[drawn[*i]].clone()).collect();
    Ok(most_different(&good, GALLERY_SIZE).into_iter().map(|i| all[drawn[order[i]]].clone()).collect())
}

/// One random variant of `seed`: of a few the one that loses least to its limit.
///
/// # Errors
/// Errors of the synthesizer.
pub fn surprise(seed: u64, sitter: &Sitter) -> Result<(Variant, Portrait), CaricatureError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let all: Vec<Variant> =
        (0..SURPRISES).map(|_| Variant::random(sitter.parts().len(), sitter.templates(), &mut rng)).collect();
    let portraits = sitter.portray(&all.iter().collect::<Vec<_>>())?;
    let both = all.into_iter().zip(portraits);
    let score = |portrait: &Portrait| portrait.kept * portrait.kept * portrait.moved;
    let best = both.max_by(|a, b| score(&a.1).total_cmp(&score(&b.1)));
    best.ok_or_else(|| CaricatureError::Gallery("there are no variants".into()))
}

#[cfg(test)]
mod tests;
