//! A gallery of mappings, its generations, and who descends from whom.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};

use crate::breeding::{breed, mutate};
use crate::{Mapping, MusicError, direct_transfer};

/// The sizes S a gallery may have.
pub const GALLERY_SIZES: [usize; 4] = [6, 9, 12, 16];
/// Children among which a suggested generation is chosen.
pub const CANDIDATES: usize = 200;
/// The largest mutation of a candidate.
const CANDIDATE_MUTATION: f32 = 0.4;

/// Curve values that all generations together may hold: half a gigabyte. By hand that takes weeks of
/// breeding, but a session file or a controller breeds faster.
const MOST_GENES: usize = 1 << 27;

/// Identifies one item permanently: no two items of a session share an id.
pub type ItemId = u32;

/// How an item came to be.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "from")]
pub enum Origin {
    /// Part of the initial gallery of a seed.
    Initial {
        /// The seed.
        seed: u64,
        /// Its place in that gallery.
        place: usize,
    },
    /// A child of two items.
    Bred {
        /// Their ids.
        parents: [ItemId; 2],
    },
    /// One item, changed a little at random.
    Mutated {
        /// Its id.
        parent: ItemId,
    },
    /// Came out of a preset file.
    Loaded {
        /// The preset's name; its key is not `name`, because a line of lineage has one, too.
        #[serde(rename = "preset", default)]
        name: String,
    },
}

/// One item of a gallery.
#[derive(Clone, Debug, PartialEq)]
pub struct GalleryItem {
    /// Its id.
    pub id: ItemId,
    /// What the user calls it; empty until named.
    pub name: String,
    /// What it plays.
    pub mapping: Mapping,
    /// How it came to be.
    pub origin: Origin,
    /// Whether t, a, μ or gain were changed by hand since.
    pub edited: bool,
    /// Chosen as a parent.
    pub chosen: bool,
    /// Stays in its place when the others are replaced.
    pub locked: bool,
}

/// The items that were shown together.
#[derive(Clone, Debug, PartialEq)]
pub struct Generation {
    /// S items.
    pub items: Vec<GalleryItem>,
    /// The generation this one was made from.
    pub from: Option<usize>,
}

/// What the initial gallery is made for.
#[derive(Clone, Debug, PartialEq)]
pub struct GalleryShape {
    /// λ_k of the body, ascending; K of them.
    pub eigenvalues: Vec<f64>,
    /// #ω.
    pub bands: usize,
}

impl GalleryShape {
    /// How many waves of each harmonic fit into the length of the body: √λ_k/π, because the longest side is 2
    /// in the working frame. It depends only on the body's shape, not on its size or on K.
    pub fn waves_per_size(&self) -> Vec<f32> {
        self.eigenvalues.iter().map(|l| (l.max(0.0).sqrt() / std::f64::consts::PI) as f32).collect()
    }
}

/// All generations of one seed. Everything random comes from the seed and from the number of
/// draws made before, so that the same calls give the same items, bit for bit.
#[derive(Clone, Debug, PartialEq)]
pub struct Gallery {
    seed: u64,
    draws: u64,
    next_id: ItemId,
    generations: Vec<Generation>,
    current: usize,
    /// Curve values of all generations.
    genes: usize,
    /// The earliest generation whose choices count as a preference.
    preference_since: usize,
}

impl Gallery {
    /// The initial gallery of `size` ∈ [`GALLERY_SIZES`] items.
    ///
    /// Seeds go up to 2⁶³ − 1, the largest number that session files can hold.
    pub fn new(seed: u64, size: usize, shape: &GalleryShape) -> Result<Self, MusicError> {
        Self::numbered_from(0, seed, size, shape)
    }

    fn numbered_from(
        next_id: ItemId,
        seed: u64,
        size: usize,
        shape: &GalleryShape,
    ) -> Result<Self, MusicError> {
        if !GALLERY_SIZES.contains(&size) {
            return Err(MusicError::GallerySize(size));
        }
        if i64::try_from(seed).is_err() {
            return Err(MusicError::OutOfRange {
                name: "seed",
                value: seed as f64,
                range: "[0, 2^63)".into(),
            });
        }
        let mut gallery = Self {
            seed,
            draws: 0,
            next_id,
            generations: Vec::new(),
            current: 0,
            genes: 0,
            preference_since: 0,
        };
        let mu = initial_mu(size, &mut gallery.rng());
        let items = initial_mappings(size, shape)
            .into_iter()
            .zip(mu)
            .enumerate()
            .map(|(place, (mapping, stereo_mu))| {
                gallery.item(Mapping { stereo_mu, ..mapping }, Origin::Initial { seed, place })
            })
            .collect();
        gallery.generations.push(Generation { items, from: None });
        Ok(gallery)
    }

    /// Another gallery whose items continue the numbering of this one.
    pub(crate) fn restart(&self, seed: u64, size: usize, shape: &GalleryShape) -> Result<Self, MusicError> {
        Self::numbered_from(self.next_id, seed, size, shape)
    }

    /// The seed.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// All generations, oldest first.
    pub fn generations(&self) -> &[Generation] {
        &self.generations
    }

    /// Index of the generation that is shown.
    pub fn current(&self) -> usize {
        self.current
    }

    /// The items that are shown.
    pub fn items(&self) -> &[GalleryItem] {
        &self.generations[self.current].items
    }

    /// The generation in which an item was first seen, and its place there.
    pub fn born(&self, id: ItemId) -> Option<(usize, usize)> {
        let place = |generation: &Generation| generation.items.iter().position(|item| item.id == id);
        self.generations.iter().enumerate().find_map(|(g, generation)| Some((g, place(generation)?)))
    }

    /// The newest state of an item of any generation.
    pub fn find(&self, id: ItemId) -> Option<&GalleryItem> {
        let shown = self.items().iter().find(|item| item.id == id);
        shown.or_else(|| self.generations.iter().rev().flat_map(|g| &g.items).find(|item| item.id == id))
    }

    pub(crate) fn item_mut(&mut self, index: usize) -> Result<&mut GalleryItem, MusicError> {
        let items = &mut self.generations[self.current].items;
        let count = items.len();
        items.get_mut(index).ok_or(MusicError::NoSuch { what: "item", index, count })
    }

    /// Shows an earlier (or later) generation again.
    pub(crate) fn go_to(&mut self, generation: usize) -> Result<(), MusicError> {
        let count = self.generations.len();
        if generation >= count {
            return Err(MusicError::NoSuch { what: "generation", index: generation, count });
        }
        self.current = generation;
        Ok(())
    }

    /// A new generation: S children of random pairs of distinct chosen items; locked items stay.
    pub(crate) fn breed(&mut self) -> Result<(), MusicError> {
        self.check_room()?;
        let parents = self.parents(2)?;
        let mut rng = self.rng();
        let items = self
            .items()
            .to_vec()
            .into_iter()
            .map(|item| {
                // Drawn for locked places too, so that a lock does not change its neighbors.
                let (child, parents) = child(&parents, &mut rng);
                if item.locked {
                    return GalleryItem { chosen: false, ..item };
                }
                self.item(child, Origin::Bred { parents })
            })
            .collect();
        self.show_new(items);
        Ok(())
    }

    /// The chosen items, at least so many.
    fn parents(&self, least: usize) -> Result<Vec<GalleryItem>, MusicError> {
        let parents: Vec<GalleryItem> = self.items().iter().filter(|i| i.chosen).cloned().collect();
        if parents.len() < least { Err(MusicError::NotEnoughParents(parents.len())) } else { Ok(parents) }
    }

    /// The [`CANDIDATES`] that the next generation may be chosen from: children of the chosen items, half of
    /// them mutated; of a single chosen item mutants alone. They do not depend on each other.
    ///
    /// # Errors
    /// [`MusicError::NotEnoughParents`] where nothing is chosen.
    pub fn candidates(&self) -> Result<Vec<Mapping>, MusicError> {
        let parents = self.parents(1)?;
        Ok((0..CANDIDATES).map(|number| self.candidate(&parents, number).0).collect())
    }

    fn candidate(&self, parents: &[GalleryItem], number: usize) -> (Mapping, Origin) {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(((number as u64 + 1) << 40) | self.draws);
        let (mapping, origin) = match parents {
            [alone] => (alone.mapping.clone(), Origin::Mutated { parent: alone.id }),
            parents => {
                let (child, parents) = child(parents, &mut rng);
                (child, Origin::Bred { parents })
            }
        };
        if parents.len() > 1 && rng.random_bool(0.5) {
            return (mapping, origin);
        }
        let amount = CANDIDATE_MUTATION * rng.random::<f32>();
        let mutant = mutate(&mapping, amount, &mut rng);
        // A mutant that no sound would move is not worth a candidate.
        (if mutant.loudness() > 0.0 { mutant } else { mapping }, origin)
    }

    /// A new generation: in each place the candidate of that number; locked items stay.
    pub(crate) fn breed_from(&mut self, candidates: &[u16]) -> Result<(), MusicError> {
        self.check_room()?;
        let (found, expected) = (candidates.len(), self.items().len());
        if found != expected {
            return Err(MusicError::Size { what: "candidates", found, expected });
        }
        if let Some(&number) = candidates.iter().find(|number| usize::from(**number) >= CANDIDATES) {
            return Err(MusicError::NoSuch { what: "candidate", index: number.into(), count: CANDIDATES });
        }
        let parents = self.parents(1)?;
        let born: Vec<(Mapping, Origin)> =
            candidates.iter().map(|&number| self.candidate(&parents, number.into())).collect();
        self.draws += 1;
        let places = self.items().to_vec().into_iter().zip(born);
        let items = places
            .map(|(item, (mapping, origin))| match item.locked {
                true => GalleryItem { chosen: false, ..item },
                false => self.item(mapping, origin),
            })
            .collect();
        self.show_new(items);
        Ok(())
    }

    /// The choices of earlier generations no longer count as a preference.
    pub(crate) fn forget_preference(&mut self) {
        self.preference_since = self.generations.len();
    }

    /// The generation that is shown and those that it came from, newest first: those in which something was
    /// chosen, as far as they count as a preference.
    pub fn opinions(&self) -> impl Iterator<Item = &[GalleryItem]> {
        let back = std::iter::successors(Some(self.current), |&g| self.generations[g].from);
        let counted = back.take_while(|&g| g >= self.preference_since);
        let items = counted.map(|g| &self.generations[g].items[..]);
        items.filter(|items| items.iter().any(|item| item.chosen))
    }

    /// A new generation in which one item is changed a little.
    pub(crate) fn mutate(&mut self, index: usize, amount: f32) -> Result<(), MusicError> {
        if !(0.0..=1.0).contains(&amount) {
            return Err(MusicError::OutOfRange {
                name: "mutation",
                value: amount.into(),
                range: "[0, 1]".into(),
            });
        }
        self.check_room()?;
        let parent = self.item_mut(index)?.clone();
        let mapping = mutate(&parent.mapping, amount, &mut self.rng());
        let child = self.item(mapping, Origin::Mutated { parent: parent.id });
        self.replace(index, child);
        Ok(())
    }

    /// A new generation in which one item is replaced by a mapping from elsewhere.
    pub(crate) fn load(&mut self, index: usize, name: &str, mapping: Mapping) -> Result<(), MusicError> {
        mapping.validate()?;
        self.check_room()?;
        self.item_mut(index)?;
        let mut item = self.item(mapping, Origin::Loaded { name: name.to_owned() });
        item.name = name.to_owned();
        self.replace(index, item);
        Ok(())
    }

    fn replace(&mut self, index: usize, item: GalleryItem) {
        let mut items = self.items().to_vec();
        items[index] = item;
        self.show_new(items);
    }

    fn check_room(&self) -> Result<(), MusicError> {
        if self.genes < MOST_GENES {
            Ok(())
        } else {
            Err(MusicError::TooManyGenerations(self.generations.len()))
        }
    }

    fn show_new(&mut self, items: Vec<GalleryItem>) {
        let genes = |item: &GalleryItem| item.mapping.transfer.len() + item.mapping.amplification.len();
        self.genes += items.iter().map(genes).sum::<usize>();
        self.generations.push(Generation { items, from: Some(self.current) });
        self.current = self.generations.len() - 1;
    }

    fn item(&mut self, mapping: Mapping, origin: Origin) -> GalleryItem {
        let id = self.next_id;
        self.next_id += 1;
        let name = String::new();
        GalleryItem { id, name, mapping, origin, edited: false, chosen: false, locked: false }
    }

    /// A fresh stream of the seed for each draw: what is drawn does not depend on how much
    /// randomness an earlier draw used.
    fn rng(&mut self) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(self.draws);
        self.draws += 1;
        rng
    }
}

/// A child of a random pair of distinct parents, at least two, and who they are.
fn child(parents: &[GalleryItem], rng: &mut ChaCha8Rng) -> (Mapping, [ItemId; 2]) {
    let first = rng.random_range(0..parents.len());
    let second = (first + rng.random_range(1..parents.len())) % parents.len();
    let (p, q) = (&parents[first], &parents[second]);
    let mut child = breed(&p.mapping, &q.mapping, rng);
    // A child inherits how much louder or softer than their even gain its parents are.
    let loudness = [p, q].map(|parent| parent.mapping.gain / parent.mapping.even_gain());
    child.gain = (0.5 * (loudness[0] + loudness[1]) * child.even_gain()).clamp(0.0, 100.0);
    (child, [p.id, q.id])
}

/// μ of the initial items: random, with 0 and 1 always among them.
fn initial_mu(size: usize, rng: &mut ChaCha8Rng) -> Vec<f32> {
    let mut mu: Vec<f32> = (0..size).map(|_| rng.random()).collect();
    let zero = rng.random_range(0..size);
    let one = (zero + rng.random_range(1..size)) % size;
    mu[zero] = 0.0;
    mu[one] = 1.0;
    mu
}

/// The initial gallery without μ (docs/music.md, "The initial gallery"): each amplification gets a transfer
/// of its own. The paper leaves open which. Paired in order, most items are silent, because their sound goes
/// to harmonics that they do not amplify.
fn initial_mappings(size: usize, shape: &GalleryShape) -> Vec<Mapping> {
    let k = shape.eigenvalues.len().max(1);
    let mut transfers = initial_transfers(size, shape);
    let mut amplifications: Vec<Vec<f32>> =
        (0..size).map(|item| initial_amplification(size, item, k)).collect();
    let targets = |t: &[f32]| t.iter().map(|t| (t * (k - 1) as f32).round() as usize).collect::<Vec<_>>();
    let driven: Vec<Vec<usize>> = transfers.iter().map(|t| targets(t)).collect();
    let feeds: Vec<Vec<usize>> = (amplifications.iter())
        .map(|a| driven.iter().map(|ks| ks.iter().filter(|&&k| a[k] != 0.0).count()).collect())
        .collect();
    let choice = pairs(&feeds);
    for (item, (a, &t)) in amplifications.iter_mut().zip(&choice).enumerate() {
        if feeds[item][t] == 0 {
            reach_out(a, &driven[t]);
        }
    }
    (amplifications.into_iter().zip(choice))
        .map(|(amplification, t)| {
            let transfer = std::mem::take(&mut transfers[t]);
            let mapping = Mapping { transfer, amplification, stereo_mu: 0.0, gain: 1.0 };
            Mapping { gain: mapping.even_gain(), ..mapping }
        })
        .collect()
}

/// A different transfer for each amplification: a maximum matching in which transfers feed their
/// amplification (with `feeds[amplification][transfer]` bands), preferring the one that feeds it most.
fn pairs(feeds: &[Vec<usize>]) -> Vec<usize> {
    /// Finds a transfer for `item`, moving other items to another one where needed (Kuhn's algorithm).
    fn place(item: usize, feeds: &[Vec<usize>], seen: &mut [bool], owner: &mut [Option<usize>]) -> bool {
        let mut wanted: Vec<usize> = (0..owner.len()).filter(|&t| feeds[item][t] > 0).collect();
        wanted.sort_by_key(|&t| (std::cmp::Reverse(feeds[item][t]), t));
        for t in wanted {
            if !std::mem::replace(&mut seen[t], true)
                && owner[t].is_none_or(|other| place(other, feeds, seen, owner))
            {
                owner[t] = Some(item);
                return true;
            }
        }
        false
    }
    let mut owner = vec![None; feeds.len()];
    let without: Vec<usize> = (0..feeds.len())
        .filter(|&item| !place(item, feeds, &mut vec![false; feeds.len()], &mut owner))
        .collect();
    let free: Vec<usize> = (0..owner.len()).filter(|&t| owner[t].is_none()).collect();
    free.into_iter().zip(without).for_each(|(t, item)| owner[t] = Some(item));
    let mut choice = vec![0; feeds.len()];
    for (t, item) in owner.into_iter().enumerate() {
        if let Some(item) = item {
            choice[item] = t;
        }
    }
    choice
}

/// Extends an amplification that covers none of the `driven` harmonics to the nearest of them.
fn reach_out(a: &mut [f32], driven: &[usize]) {
    let Some(first) = a.iter().position(|a| *a != 0.0) else { return };
    let last = a.iter().rposition(|a| *a != 0.0).unwrap_or(first);
    let away = |k: usize| first.saturating_sub(k).max(k.saturating_sub(last));
    if let Some(nearest) = driven.iter().copied().filter(|&k| k > 0).min_by_key(|&k| away(k)) {
        let sign = a[first];
        a[first.min(nearest)..=last.max(nearest)].fill(sign);
    }
}

/// t_ini(α ω) with α in ⌈S/2⌉ even steps from 0 to 1, then t_rev(α ω) likewise: S transfers, each once. Odd S
/// has room for one less of the latter: t_rev(0) is left out; like t_ini(0), it is constant.
fn initial_transfers(size: usize, shape: &GalleryShape) -> Vec<Vec<f32>> {
    let half = size.div_ceil(2);
    let transfer = |i: usize, reversed: bool| {
        let alpha = i as f64 / (half - 1) as f64;
        direct_transfer(&shape.eigenvalues, shape.bands, alpha, reversed)
    };
    let straight = (0..half).map(|i| transfer(i, false));
    straight.chain((size % 2..half).map(|i| transfer(i, true))).collect()
}

/// Band b covers k/K in [(2b/S)², (2(b+1)/S)²); the first ⌊S/2⌋ items amplify, the rest damp.
/// A band too narrow for any harmonic that moves the shape takes the next one up.
fn initial_amplification(size: usize, item: usize, harmonics: usize) -> Vec<f32> {
    let half = size / 2;
    let (band, sign) = if item < half { (item, 1.0) } else { (item - half, -1.0) };
    let edge = |b: usize| (2.0 * b as f64 / size as f64).powi(2);
    let mut a: Vec<f32> = (0..harmonics)
        .map(|k| {
            let at = k as f64 / harmonics as f64;
            if at >= edge(band) && at < edge(band + 1) { sign } else { 0.0 }
        })
        .collect();
    if a.iter().skip(1).all(|a| *a == 0.0) {
        let next =
            ((edge(band) * harmonics as f64).ceil() as usize).clamp(1.min(harmonics - 1), harmonics - 1);
        a[next] = sign;
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape() -> GalleryShape {
        // Weyl: λ_k grows like k.
        GalleryShape { eigenvalues: (0..256).map(f64::from).collect(), bands: 128 }
    }

    #[test]
    fn bands_cover_all_harmonics_once_per_sign() {
        for size in GALLERY_SIZES {
            for sign in [1.0, -1.0] {
                let items = if sign > 0.0 { 0..size / 2 } else { size / 2..size };
                let sum = items.fold(vec![0.0f32; 1000], |mut sum, item| {
                    sum.iter_mut().zip(initial_amplification(size, item, 1000)).for_each(|(s, a)| *s += a);
                    sum
                });
                // With odd S the amplifying half ends at ((S−1)/S)².
                let covered = if sign > 0.0 { ((size / 2 * 2) as f64 / size as f64).powi(2) } else { 1.0 };
                let end = (covered * 1000.0) as usize;
                assert!(sum[..end].iter().all(|a| *a == sign), "S = {size}");
            }
        }
    }

    #[test]
    fn every_initial_transfer_is_used_once_and_every_amplification_is_fed() {
        for size in GALLERY_SIZES {
            let transfers = initial_transfers(size, &shape());
            assert_eq!(transfers.len(), size);
            let direct = |reversed| direct_transfer(&shape().eigenvalues, 128, 1.0, reversed);
            assert!(transfers.contains(&direct(false)) && transfers.contains(&direct(true)), "S = {size}");
            let items = initial_mappings(size, &shape());
            let mut reached = 0;
            for (i, item) in items.iter().enumerate() {
                assert_eq!(items.iter().filter(|other| other.transfer == item.transfer).count(), 1);
                assert!(transfers.contains(&item.transfer), "S = {size}");
                assert!(item.loudness() > 0.0, "S = {size}, item {i}");
                reached += usize::from(item.amplification != initial_amplification(size, i, 256));
            }
            // Three, four of t_rev stay in the highest band, which has two amplifications.
            assert!(reached <= size / 8, "S = {size}: {reached}");
        }
    }

    #[test]
    fn every_initial_item_sounds_and_mu_spans_its_range() {
        for size in GALLERY_SIZES {
            let gallery = Gallery::new(3, size, &shape()).unwrap();
            assert_eq!(gallery.items().len(), size);
            for item in gallery.items() {
                item.mapping.validate().unwrap();
                let targets = item.mapping.targets(128, 256);
                let heard = targets.iter().any(|&k| k > 0 && item.mapping.amplification[k as usize] != 0.0);
                assert!(heard, "item {} of {size}", item.id);
            }
            let mu: Vec<f32> = gallery.items().iter().map(|i| i.mapping.stereo_mu).collect();
            assert!(mu.contains(&0.0) && mu.contains(&1.0));
        }
        assert!(Gallery::new(3, 7, &shape()).is_err());
    }

    #[test]
    fn generations_end_where_memory_would_and_begin_again_with_another_gallery() {
        let mut gallery = Gallery::new(9, 6, &shape()).unwrap();
        for genes in [6 * 384, 2 * 6 * 384] {
            gallery.mutate(0, 0.5).unwrap();
            assert_eq!(gallery.genes, genes);
        }
        gallery.genes = MOST_GENES;
        let before = gallery.clone();
        (0..3).for_each(|i| gallery.item_mut(i).unwrap().chosen = false);
        assert!(matches!(gallery.breed(), Err(MusicError::TooManyGenerations(3))));
        assert!(gallery.mutate(0, 0.5).is_err() && gallery.load(0, "", Mapping::rest(1, 1)).is_err());
        assert_eq!(gallery, before);
        gallery.go_to(1).unwrap();
        assert!(gallery.restart(9, 6, &shape()).unwrap().mutate(0, 0.5).is_ok());
    }

    #[test]
    fn breeding_keeps_locked_items_and_records_parents() {
        let mut gallery = Gallery::new(9, 12, &shape()).unwrap();
        assert!(matches!(gallery.breed(), Err(MusicError::NotEnoughParents(0))));
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
