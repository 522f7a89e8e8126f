//! A caricature in numbers that belong to no shape in particular: what galleries breed.

use chladni_breeding::{ChaCha8Rng, Genome, inherit, shift};
use rand::RngExt;

use crate::{CaricatureError, Model, ScaleCurve};

/// Numbers that are inherited and locked together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Group {
    /// μ: how far the exaggeration goes, and how much larger or smaller parts become.
    Strength,
    /// Which of the three models.
    Model,
    /// Which scales.
    Scales,
    /// Which parts, and whether they grow or shrink.
    Parts,
    /// Which template, and how much of the shape's own magnification is mixed in.
    Templates,
}

impl Group {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Strength, Self::Model, Self::Scales, Self::Parts, Self::Templates];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Strength => "strength",
            Self::Model => "model",
            Self::Scales => "scales",
            Self::Parts => "parts",
            Self::Templates => "templates",
        }
    }

    /// The least value of its numbers; the largest is 1.
    fn least(self) -> f32 {
        if self == Self::Parts { -1.0 } else { 0.0 }
    }
}

impl std::str::FromStr for Group {
    type Err = CaricatureError;

    fn from_str(text: &str) -> Result<Self, CaricatureError> {
        let known = Self::ALL.into_iter().find(|group| group.name() == text);
        known.ok_or_else(|| {
            CaricatureError::syntax("group", text, "must be strength, model, scales, parts or templates")
        })
    }
}

/// Wavelengths between which the gains of a variant's curve run; below the last nothing is exaggerated.
const WAVELENGTHS: [f64; 5] = [ScaleCurve::BROADEST, 1.1, 0.6, 0.34, 0.17];

/// One caricature: for each [`Group`] numbers from 0 (parts: −1) to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    genes: [Vec<f32>; Group::ALL.len()],
    locked: [bool; Group::ALL.len()],
}

impl Variant {
    /// A random variant for a sitter with these numbers of parts and templates: up to three parts become much larger,
    /// and up to two much smaller.
    pub fn random(parts: usize, templates: usize, rng: &mut ChaCha8Rng) -> Self {
        let mut some = |count: usize| -> Vec<f32> { (0..count).map(|_| rng.random()).collect() };
        let strength = some(2).into_iter().map(|x| 0.45 + 0.55 * x).collect();
        let (model, mut scales) = (some(Model::ALL.len()), some(WAVELENGTHS.len() - 1));
        let templates = some(templates + 1);
        let most = scales.iter().copied().fold(0.05, f32::max);
        scales.iter_mut().for_each(|gain| *gain /= most);
        let mut signed: Vec<f32> = (0..parts).map(|_| rng.random_range(-0.25..0.35)).collect();
        let (grow, shrink) = (rng.random_range(1..=3), rng.random_range(0..=2));
        for change in 0..(grow + shrink).min(parts) {
            let part = rng.random_range(0..parts);
            let far: f32 = rng.random_range(0.6..1.0);
            signed[part] = if change < grow { far } else { -far };
        }
        Self { genes: [strength, model, scales, signed, templates], locked: Default::default() }
    }

    /// The numbers of a group.
    pub fn genes(&self, group: Group) -> &[f32] {
        &self.genes[group as usize]
    }

    /// Whether a group is passed on as it is.
    pub fn is_locked(&self, group: Group) -> bool {
        self.locked[group as usize]
    }

    /// Locks a group, so that children have it from one parent unchanged, or unlocks it.
    pub fn lock(&mut self, group: Group, on: bool) {
        self.locked[group as usize] = on;
    }

    /// The locked groups of this one and the others of another.
    pub fn keeping_locked(&self, other: Self) -> Self {
        let genes =
            std::array::from_fn(
                |i| {
                    if self.locked[i] { self.genes[i].clone() } else { other.genes[i].clone() }
                },
            );
        Self { genes, locked: self.locked }
    }

    /// The model whose weight is the largest.
    pub fn model(&self) -> Model {
        Model::ALL[largest(self.genes(Group::Model)).min(Model::ALL.len() - 1)]
    }

    /// Φ: its gains in even steps of the wavelength; the finest detail stays as it is.
    pub fn curve(&self) -> ScaleCurve {
        let gains = self.genes(Group::Scales).iter().map(|gain| f64::from(*gain)).chain([0.0]);
        ScaleCurve {
            points: WAVELENGTHS.into_iter().zip(gains).map(|(w, g)| [w, g]).collect(),
            residual: 0.0,
        }
    }

    /// The template whose weight is the largest, an index below `templates`.
    pub fn template(&self, templates: usize) -> usize {
        largest(self.genes(Group::Templates).get(..templates).unwrap_or_default())
    }

    /// How much of the shape's own magnification is mixed in, 0 to 1.
    pub fn magnification(&self) -> f32 {
        self.genes(Group::Templates).last().copied().unwrap_or(0.0)
    }
}

/// The first of the largest.
fn largest(weights: &[f32]) -> usize {
    (0..weights.len()).rev().max_by(|a, b| weights[*a].total_cmp(&weights[*b])).unwrap_or(0)
}

impl Genome for Variant {
    fn child(mother: &Self, father: &Self, rng: &mut ChaCha8Rng) -> Self {
        let genes = Group::ALL.map(|group| {
            let [p, q] = [mother, father].map(|parent| parent.genes(group));
            if !mother.is_locked(group) && p.len() == q.len() {
                inherit(p, q, rng)
            } else if rng.random_bool(0.5) {
                p.to_vec()
            } else {
                q.to_vec()
            }
        });
        Self { genes, locked: mother.locked }
    }

    fn mutant(&self, amount: f32, rng: &mut ChaCha8Rng) -> Self {
        let mut mutant = self.clone();
        for group in Group::ALL.into_iter().filter(|group| !self.is_locked(*group)) {
            shift(&mut mutant.genes[group as usize], amount, group.least(), rng);
        }
        mutant
    }

    fn genes(&self) -> usize {
        self.genes.iter().map(Vec::len).sum()
    }

    /// Some part is exaggerated.
    fn is_viable(&self) -> bool {
        self.genes(Group::Scales).iter().any(|gain| *gain > 0.05)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_breeding::ChaCha8Rng;
    use proptest::prelude::*;
    use rand_chacha::rand_core::SeedableRng;

    fn within(variant: &Variant) -> bool {
        let of = |group: Group| variant.genes(group).iter().all(|x| (group.least()..=1.0).contains(x));
        Group::ALL.into_iter().all(of) && variant.curve().validate().is_ok()
    }

    proptest! {
        #[test]
        fn children_and_mutants_stay_in_range_and_what_is_locked_comes_from_one_parent(
            seed: u64, parts in 0usize..12, templates in 1usize..5, locked in 0usize..5, amount in 0.0f32..=1.0)
        {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut parents = [0, 1].map(|_| Variant::random(parts, templates, &mut rng));
            prop_assert!(parents.iter().all(within));
            let group = Group::ALL[locked];
            parents.iter_mut().for_each(|parent| parent.lock(group, true));
            let [mother, father] = &parents;
            let child = Variant::child(mother, father, &mut rng);
            let mutant = child.mutant(amount, &mut rng);
            for descendant in [&child, &mutant] {
                prop_assert!(within(descendant));
                let own = descendant.genes(group);
                prop_assert!(own == mother.genes(group) || own == father.genes(group));
                prop_assert!(descendant.template(templates) < templates);
            }
            let near = |(a, b): (&f32, &f32)| (a - b).abs() <= amount + 1e-6;
            let is_near = |group| child.genes(group).iter().zip(mutant.genes(group)).all(near);
            prop_assert!(Group::ALL.into_iter().all(is_near));
            prop_assert_eq!(&Variant::child(mother, mother, &mut rng), mother);
            let other = Variant::random(parts, templates, &mut rng);
            let kept = mother.keeping_locked(other.clone());
            prop_assert_eq!(kept.genes(group), mother.genes(group));
            let free = Group::ALL[(locked + 1) % 5];
            prop_assert_eq!(kept.genes(free), other.genes(free));
        }
    }

    #[test]
    fn every_group_mutates_that_is_not_locked() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut variant = Variant::random(6, 3, &mut rng);
        variant.lock(Group::Model, true);
        let mutant = variant.mutant(0.2, &mut rng);
        for group in Group::ALL {
            let stays = mutant.genes(group) == variant.genes(group);
            assert_eq!(stays, group == Group::Model, "{group:?}");
        }
    }
}
