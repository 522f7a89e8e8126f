//! Candidates: the children from which a suggested generation is chosen.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::{Gallery, child};
use crate::BreedingError;
use crate::item::{GalleryItem, Genome, Origin};

/// The number of children from which a suggested generation is chosen.
pub const CANDIDATES: usize = 200;
/// The largest mutation of a candidate, as a share of each number's range.
const CANDIDATE_MUTATION: f32 = 0.4;

/// A mutation by at most the given amount.
pub type Mutation<G> = fn(&G, f32, &mut ChaCha8Rng) -> G;

/// A mutant that is worth showing, or `genome` itself.
fn viable<G: Genome>(genome: &G, amount: f32, rng: &mut ChaCha8Rng) -> G {
    let mutant = genome.mutant(amount, rng);
    if mutant.is_viable() { mutant } else { genome.clone() }
}

impl<G: Genome> Gallery<G> {
    /// The [`CANDIDATES`] from which the next generation may be chosen. With several chosen items they are
    /// children of these, half of them mutated; with a single one they are its mutants. Each candidate can
    /// be computed without the others.
    ///
    /// # Errors
    /// [`BreedingError::NotEnoughParents`] if nothing is chosen.
    pub fn candidates(&self) -> Result<Vec<G>, BreedingError> {
        let parents = self.parents(1)?;
        Ok((0..CANDIDATES).map(|number| self.candidate(&parents, number, viable).0).collect())
    }

    fn candidate(&self, parents: &[GalleryItem<G>], number: usize, mutation: Mutation<G>) -> (G, Origin) {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(((number as u64 + 1) << 40) | self.draws);
        let (genome, origin) = match parents {
            [alone] => (alone.genome.clone(), Origin::Mutated { parent: alone.id }),
            parents => {
                let (child, parents) = child(parents, &mut rng);
                (child, Origin::Bred { parents })
            }
        };
        if parents.len() > 1 && rng.random_bool(0.5) {
            return (genome, origin);
        }
        let amount = CANDIDATE_MUTATION * rng.random::<f32>();
        (mutation(&genome, amount, &mut rng), origin)
    }

    /// Appends a generation and shows it: each place gets the candidate with the given number, except that
    /// locked items stay.
    ///
    /// # Errors
    /// No chosen item, no room for more generations, a number of candidates that is not that of the items,
    /// or a candidate that does not exist.
    pub fn breed_from(&mut self, candidates: &[u16]) -> Result<(), BreedingError> {
        self.breed_from_by(candidates, viable)
    }

    /// The same with candidates that mutate otherwise.
    ///
    /// # Errors
    /// Those of [`breed_from`](Self::breed_from).
    pub fn breed_from_by(&mut self, candidates: &[u16], mutation: Mutation<G>) -> Result<(), BreedingError> {
        self.check_room()?;
        let (found, expected) = (candidates.len(), self.items().len());
        if found != expected {
            return Err(BreedingError::Size { what: "candidates", found, expected });
        }
        if let Some(&number) = candidates.iter().find(|number| usize::from(**number) >= CANDIDATES) {
            return Err(BreedingError::NoSuch { what: "candidate", index: number.into(), count: CANDIDATES });
        }
        let parents = self.parents(1)?;
        let born = candidates.iter().map(|&number| self.candidate(&parents, number.into(), mutation));
        let born: Vec<(G, Origin)> = born.collect();
        self.draws += 1;
        let places = self.items().to_vec().into_iter().zip(born);
        let items = places
            .map(|(item, (genome, origin))| match item.locked {
                true => GalleryItem { chosen: false, forgotten: false, ..item },
                false => self.item(genome, origin),
            })
            .collect();
        self.show_new(items);
        Ok(())
    }
}
