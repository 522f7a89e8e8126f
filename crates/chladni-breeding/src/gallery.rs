//! A gallery of items and its generations.

mod candidates;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

pub use self::candidates::{CANDIDATES, Mutation};
use crate::BreedingError;
use crate::item::{GalleryItem, Generation, Genome, ItemId, Origin, item_name};

/// The sizes S that a gallery may have.
pub const GALLERY_SIZES: [usize; 4] = [6, 9, 12, 16];

/// How many numbers all generations together may hold: half a gigabyte. Breeding by hand takes weeks to get
/// there, but a show file or a controller breeds faster.
const MOST_GENES: usize = 1 << 27;

/// How often a mutation is drawn at most, where not every change is wanted.
const MUTANTS: usize = 24;

/// All generations of one seed. Each random draw depends only on the seed and on the number of draws made
/// before it: the same calls give the same items, bit for bit.
#[derive(Clone, Debug, PartialEq)]
pub struct Gallery<G> {
    seed: u64,
    draws: u64,
    next_id: ItemId,
    generations: Vec<Generation<G>>,
    current: usize,
    /// How many numbers all generations hold together.
    genes: usize,
}

impl<G: Genome> Gallery<G> {
    /// A gallery of `size` ∈ [`GALLERY_SIZES`] items, which `initial` creates.
    ///
    /// # Errors
    /// Another size; a seed above 2⁶³ − 1, the largest number that show files can hold; a number of
    /// items from `initial` that is not `size`.
    pub fn new(
        seed: u64,
        size: usize,
        initial: impl FnOnce(&mut ChaCha8Rng) -> Vec<G>,
    ) -> Result<Self, BreedingError> {
        Self::numbered_from(0, seed, size, initial)
    }

    /// A new gallery whose item ids continue those of this one.
    ///
    /// # Errors
    /// Those of [`new`](Self::new).
    pub fn restart(
        &self,
        seed: u64,
        size: usize,
        initial: impl FnOnce(&mut ChaCha8Rng) -> Vec<G>,
    ) -> Result<Self, BreedingError> {
        Self::numbered_from(self.next_id, seed, size, initial)
    }

    fn numbered_from(
        next_id: ItemId,
        seed: u64,
        size: usize,
        initial: impl FnOnce(&mut ChaCha8Rng) -> Vec<G>,
    ) -> Result<Self, BreedingError> {
        if !GALLERY_SIZES.contains(&size) {
            return Err(BreedingError::GallerySize(size));
        }
        if i64::try_from(seed).is_err() {
            return Err(BreedingError::OutOfRange { name: "seed", value: seed as f64, range: "[0, 2^63)" });
        }
        let mut gallery = Self { seed, draws: 0, next_id, generations: Vec::new(), current: 0, genes: 0 };
        let genomes = initial(&mut gallery.rng());
        if genomes.len() != size {
            return Err(BreedingError::Size { what: "initial items", found: genomes.len(), expected: size });
        }
        let of = |(place, genome)| (genome, Origin::Initial { seed, place });
        let items = genomes.into_iter().enumerate().map(of);
        let items = items.map(|(genome, origin)| gallery.item(genome, origin)).collect();
        gallery.generations.push(Generation { items, from: None });
        Ok(gallery)
    }

    /// The seed of all random draws.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// The seed of another gallery, a number that JavaScript holds exactly.
    pub fn next_seed(&self) -> u64 {
        (self.seed + 1) % (1 << 53)
    }

    /// All generations, oldest first.
    pub fn generations(&self) -> &[Generation<G>] {
        &self.generations
    }

    /// Index of the generation that is shown now.
    pub fn current(&self) -> usize {
        self.current
    }

    /// The generation from which the current one was made; `None` for the first.
    pub fn back(&self) -> Option<usize> {
        self.generations[self.current].from
    }

    /// The latest generation that was made from the current one, else the next.
    pub fn forth(&self) -> Option<usize> {
        let child = self.generations.iter().rposition(|generation| generation.from == Some(self.current));
        child.or_else(|| Some(self.current + 1).filter(|next| *next < self.generations.len()))
    }

    /// The items of the current generation.
    pub fn items(&self) -> &[GalleryItem<G>] {
        &self.generations[self.current].items
    }

    /// The generation in which an item first appeared, and its place in it.
    pub fn born(&self, id: ItemId) -> Option<(usize, usize)> {
        let place = |generation: &Generation<G>| generation.items.iter().position(|item| item.id == id);
        self.generations.iter().enumerate().find_map(|(g, generation)| Some((g, place(generation)?)))
    }

    /// An item, in whichever generation it is.
    pub fn find(&self, id: ItemId) -> Option<&GalleryItem<G>> {
        let shown = self.items().iter().find(|item| item.id == id);
        shown.or_else(|| self.generations.iter().rev().flat_map(|g| &g.items).find(|item| item.id == id))
    }

    /// An item of the current generation, to be chosen, locked or named.
    ///
    /// # Errors
    /// [`BreedingError::NoSuch`] for an index that is out of range.
    pub fn item_mut(&mut self, index: usize) -> Result<&mut GalleryItem<G>, BreedingError> {
        let items = &mut self.generations[self.current].items;
        let count = items.len();
        items.get_mut(index).ok_or(BreedingError::NoSuch { what: "item", index, count })
    }

    /// All copies of an item: one that keeps its place is in several generations.
    pub fn copies_mut(&mut self, id: ItemId) -> impl Iterator<Item = &mut GalleryItem<G>> {
        self.generations.iter_mut().flat_map(|g| &mut g.items).filter(move |item| item.id == id)
    }

    /// Chooses an item of the current generation as a parent, or no longer.
    ///
    /// # Errors
    /// [`BreedingError::NoSuch`] for an index that is out of range.
    pub fn choose(&mut self, index: usize, on: bool) -> Result<(), BreedingError> {
        let item = self.item_mut(index)?;
        (item.chosen, item.forgotten) = (on, false);
        Ok(())
    }

    /// Makes an earlier or later generation the current one.
    ///
    /// # Errors
    /// [`BreedingError::NoSuch`] for a generation that does not exist.
    pub fn go_to(&mut self, generation: usize) -> Result<(), BreedingError> {
        let count = self.generations.len();
        if generation >= count {
            return Err(BreedingError::NoSuch { what: "generation", index: generation, count });
        }
        self.current = generation;
        Ok(())
    }

    /// Appends a generation and shows it: a child of a random pair of distinct chosen items in each place,
    /// except that locked items stay.
    ///
    /// # Errors
    /// Fewer than two chosen items, or no room for more generations.
    pub fn breed(&mut self) -> Result<(), BreedingError> {
        self.check_room()?;
        let parents = self.parents(2)?;
        let mut rng = self.rng();
        let items = self
            .items()
            .to_vec()
            .into_iter()
            .map(|item| {
                // Drawn for locked places too, so that locking an item does not change the others.
                let (child, parents) = child(&parents, &mut rng);
                if item.locked {
                    return GalleryItem { chosen: false, forgotten: false, ..item };
                }
                self.item(child, Origin::Bred { parents })
            })
            .collect();
        self.show_new(items);
        Ok(())
    }

    /// The chosen items; an error if there are fewer than `least`.
    fn parents(&self, least: usize) -> Result<Vec<GalleryItem<G>>, BreedingError> {
        let parents: Vec<GalleryItem<G>> = self.items().iter().filter(|i| i.chosen).cloned().collect();
        if parents.len() < least { Err(BreedingError::NotEnoughParents(parents.len())) } else { Ok(parents) }
    }

    /// Makes all choices so far count no longer as a preference. What is chosen stays chosen as a parent.
    pub fn forget_preference(&mut self) {
        let items = self.generations.iter_mut().flat_map(|generation| &mut generation.items);
        items.for_each(|item| item.forgotten = item.chosen);
    }

    /// The generations whose choices count as a preference, newest first: the current one and its
    /// ancestors, where something was chosen that was not
    /// [forgotten](Self::forget_preference) since.
    pub fn opinions(&self) -> impl Iterator<Item = &[GalleryItem<G>]> {
        let back = std::iter::successors(Some(self.current), |&g| self.generations[g].from);
        let items = back.map(|g| &self.generations[g].items[..]);
        items.filter(|items| items.iter().any(|item| item.chosen && !item.forgotten))
    }

    /// Appends a generation in which one item is changed by at most `amount`, and shows it.
    ///
    /// # Errors
    /// An amount outside [0, 1], an item that does not exist, or no room for more generations.
    pub fn mutate(&mut self, index: usize, amount: f32) -> Result<(), BreedingError> {
        self.mutate_by(index, amount, G::mutant)
    }

    /// The same, but the change is drawn again while the changed item is not `wanted`, up to a number of times.
    ///
    /// # Errors
    /// Those of [`mutate`](Self::mutate).
    pub fn mutate_until(
        &mut self,
        index: usize,
        amount: f32,
        wanted: impl Fn(&G) -> bool,
    ) -> Result<(), BreedingError> {
        self.mutate_by(index, amount, |parent, amount, rng| {
            let mut mutant = parent.mutant(amount, rng);
            for _ in 1..MUTANTS {
                if wanted(&mutant) {
                    break;
                }
                mutant = parent.mutant(amount, rng);
            }
            mutant
        })
    }

    /// The same with a mutation of the caller's.
    ///
    /// # Errors
    /// Those of [`mutate`](Self::mutate).
    pub fn mutate_by(
        &mut self,
        index: usize,
        amount: f32,
        mutation: impl Fn(&G, f32, &mut ChaCha8Rng) -> G,
    ) -> Result<(), BreedingError> {
        if !(0.0..=1.0).contains(&amount) {
            return Err(BreedingError::OutOfRange {
                name: "mutation",
                value: amount.into(),
                range: "[0, 1]",
            });
        }
        self.check_room()?;
        let parent = self.item_mut(index)?.clone();
        let mut rng = self.rng();
        let genome = mutation(&parent.genome, amount, &mut rng);
        let child = self.item(genome, Origin::Mutated { parent: parent.id });
        self.replace(index, child);
        Ok(())
    }

    /// Appends a generation in which one item is replaced by `genome`, called `name` ([`item_name`]), and shows it. Where there is no
    /// room for more generations, the item is replaced in the one that is shown: a show of many days goes on.
    ///
    /// # Errors
    /// An item that does not exist.
    pub fn load(&mut self, index: usize, name: &str, genome: G) -> Result<(), BreedingError> {
        self.item_mut(index)?;
        let name = item_name(name);
        let mut item = self.item(genome, Origin::Loaded { name: name.clone() });
        item.name = name;
        if self.check_room().is_ok() {
            self.replace(index, item);
        } else {
            *self.item_mut(index)? = item;
        }
        Ok(())
    }

    fn replace(&mut self, index: usize, item: GalleryItem<G>) {
        let mut items = self.items().to_vec();
        items[index] = item;
        self.show_new(items);
    }

    fn check_room(&self) -> Result<(), BreedingError> {
        if self.genes < MOST_GENES {
            Ok(())
        } else {
            Err(BreedingError::TooManyGenerations(self.generations.len()))
        }
    }

    fn show_new(&mut self, items: Vec<GalleryItem<G>>) {
        self.genes += items.iter().map(|item| item.genome.genes()).sum::<usize>();
        self.generations.push(Generation { items, from: Some(self.current) });
        self.current = self.generations.len() - 1;
    }

    fn item(&mut self, genome: G, origin: Origin) -> GalleryItem<G> {
        let id = self.next_id;
        self.next_id += 1;
        let name = String::new();
        GalleryItem {
            id,
            name,
            genome,
            origin,
            edited: false,
            chosen: false,
            forgotten: false,
            locked: false,
        }
    }

    /// A fresh random stream for each draw: the result does not depend on how much randomness earlier
    /// draws used.
    fn rng(&mut self) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(self.draws);
        self.draws += 1;
        rng
    }
}

/// A child of a random pair of distinct `parents`, of which there must be at least two, and the ids of the
/// pair.
fn child<G: Genome>(parents: &[GalleryItem<G>], rng: &mut ChaCha8Rng) -> (G, [ItemId; 2]) {
    let first = rng.random_range(0..parents.len());
    let second = (first + rng.random_range(1..parents.len())) % parents.len();
    let (p, q) = (&parents[first], &parents[second]);
    (G::child(&p.genome, &q.genome, rng), [p.id, q.id])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{inherit, shift};

    #[derive(Clone, Debug, PartialEq)]
    struct Numbers(Vec<f32>);

    impl Genome for Numbers {
        fn child(mother: &Self, father: &Self, rng: &mut ChaCha8Rng) -> Self {
            Self(inherit(&mother.0, &father.0, rng))
        }

        fn mutant(&self, amount: f32, rng: &mut ChaCha8Rng) -> Self {
            let mut mutant = self.clone();
            shift(&mut mutant.0, amount, 0.0, rng);
            mutant
        }

        fn genes(&self) -> usize {
            self.0.len()
        }
    }

    fn initial(size: usize) -> impl FnOnce(&mut ChaCha8Rng) -> Vec<Numbers> {
        move |rng| (0..size).map(|_| Numbers((0..384).map(|_| rng.random()).collect())).collect()
    }

    #[test]
    fn where_there_is_no_room_a_loaded_item_takes_a_place_in_the_last_generation() {
        let mut gallery = Gallery::new(3, 6, initial(6)).unwrap();
        gallery.genes = MOST_GENES;
        let (generations, before) = (gallery.generations.len(), gallery.items()[2].id);
        gallery.load(2, "late", Numbers(vec![0.5; 384])).unwrap();
        assert_eq!((gallery.generations.len(), gallery.items()[2].name.as_str()), (generations, "late"));
        assert_ne!(gallery.items()[2].id, before);
        assert!(gallery.load(9, "nowhere", Numbers(vec![0.5; 384])).is_err());
        assert!(gallery.mutate(1, 0.2).is_err());
    }

    #[test]
    fn choices_count_again_after_those_before_are_forgotten() {
        let mut gallery = Gallery::new(3, 6, initial(6)).unwrap();
        gallery.choose(1, true).unwrap();
        assert_eq!(gallery.opinions().count(), 1);
        gallery.forget_preference();
        // It is still a parent, also in the next generation, but no preference.
        gallery.mutate(0, 0.5).unwrap();
        assert!(gallery.items()[1].chosen && gallery.opinions().count() == 0);
        // In the same generation, in an earlier one, and for the same item.
        for (generation, item) in [(1, 4), (0, 2), (0, 1)] {
            gallery.go_to(generation).unwrap();
            gallery.forget_preference();
            assert_eq!(gallery.opinions().count(), 0);
            gallery.choose(item, true).unwrap();
            assert_eq!(gallery.opinions().count(), 1, "item {item} of generation {generation}");
        }
        gallery.choose(1, false).unwrap();
        assert_eq!(gallery.opinions().count(), 0);
    }

    #[test]
    fn sizes_and_seeds_that_are_not_offered_are_refused() {
        assert!(matches!(Gallery::new(3, 7, initial(7)), Err(BreedingError::GallerySize(7))));
        assert!(Gallery::new(1 << 63, 6, initial(6)).is_err());
        assert!(Gallery::new(3, 6, initial(5)).is_err());
    }

    #[test]
    fn another_seed_is_the_next_one_that_javascript_holds_exactly() {
        for (seed, next) in [(3, 4), ((1 << 53) - 1, 0), ((1 << 53) + 1, 2)] {
            assert_eq!(Gallery::new(seed, 6, initial(6)).unwrap().next_seed(), next);
        }
        assert!(Gallery::new((1 << 63) - 1, 6, initial(6)).unwrap().next_seed() < 1 << 53);
    }

    #[test]
    fn back_leads_to_the_parents_and_forth_to_their_latest_children() {
        let mut gallery = Gallery::new(3, 6, initial(6)).unwrap();
        assert_eq!((gallery.back(), gallery.forth()), (None, None));
        gallery.mutate(0, 0.5).unwrap();
        gallery.mutate(1, 0.5).unwrap();
        gallery.go_to(0).unwrap();
        gallery.mutate(2, 0.5).unwrap();
        assert_eq!((gallery.current(), gallery.back()), (3, Some(0)));
        gallery.go_to(0).unwrap();
        assert_eq!(gallery.forth(), Some(3));
        // The second has a child of its own; the third has none, and what comes next is offered.
        gallery.go_to(1).unwrap();
        assert_eq!((gallery.back(), gallery.forth()), (Some(0), Some(2)));
        gallery.go_to(2).unwrap();
        assert_eq!((gallery.back(), gallery.forth()), (Some(1), Some(3)));
    }

    #[test]
    fn generations_end_where_memory_would_and_begin_again_with_another_gallery() {
        let mut gallery = Gallery::new(9, 6, initial(6)).unwrap();
        for genes in [6 * 384, 2 * 6 * 384] {
            gallery.mutate(0, 0.5).unwrap();
            assert_eq!(gallery.genes, genes);
        }
        gallery.genes = MOST_GENES;
        let before = gallery.clone();
        (0..3).for_each(|i| gallery.item_mut(i).unwrap().chosen = false);
        assert!(matches!(gallery.breed(), Err(BreedingError::TooManyGenerations(3))));
        assert!(gallery.mutate(0, 0.5).is_err());
        assert_eq!(gallery, before);
        gallery.go_to(1).unwrap();
        assert!(gallery.restart(9, 6, initial(6)).unwrap().mutate(0, 0.5).is_ok());
    }

    #[test]
    fn breeding_keeps_locked_items_and_records_parents() {
        let mut gallery = Gallery::new(9, 12, initial(12)).unwrap();
        assert!(matches!(gallery.breed(), Err(BreedingError::NotEnoughParents(0))));
        for i in [1, 4, 6] {
            gallery.item_mut(i).unwrap().chosen = true;
        }
        gallery.item_mut(2).unwrap().locked = true;
        let kept = gallery.items()[2].clone();
        let before = gallery.items().to_vec();
        gallery.breed().unwrap();
        assert_eq!(gallery.items()[2], kept);
        for (i, item) in gallery.items().iter().enumerate().filter(|(i, _)| *i != 2) {
            let Origin::Bred { parents: [p, q] } = item.origin else { panic!("item {i}: {:?}", item.origin) };
            assert!(p != q && [1, 4, 6].contains(&p) && [1, 4, 6].contains(&q));
        }
        gallery.go_to(0).unwrap();
        assert_eq!(gallery.items(), &before[..]);
        assert!(gallery.go_to(2).is_err());
        gallery.breed().unwrap();
        assert_eq!(gallery.generations()[2].from, Some(0));
    }
}
