//! Galleries that are bred: a person chooses items they like and sees children of them.
//!
//! The things bred are [`Genome`]s, such as dances or caricatures. A [`Gallery`] holds their generations.
//! [`suggest`] picks children that look different from each other and similar to what was chosen, by their
//! [`Descriptor`]s.
//!
//! ```
//! use chladni_breeding::{ChaCha8Rng, Gallery, Genome, inherit, shift};
//!
//! #[derive(Clone)]
//! struct Color(Vec<f32>);
//!
//! impl Genome for Color {
//!     fn child(mother: &Self, father: &Self, rng: &mut ChaCha8Rng) -> Self {
//!         Self(inherit(&mother.0, &father.0, rng))
//!     }
//!     fn mutant(&self, amount: f32, rng: &mut ChaCha8Rng) -> Self {
//!         let mut mutant = self.clone();
//!         shift(&mut mutant.0, amount, 0.0, rng);
//!         mutant
//!     }
//!     fn genes(&self) -> usize {
//!         self.0.len()
//!     }
//! }
//!
//! let mut gallery = Gallery::new(7, 6, |_| (0..6).map(|i| Color(vec![i as f32 / 5.0; 3])).collect())?;
//! gallery.item_mut(0)?.chosen = true;
//! gallery.item_mut(5)?.chosen = true;
//! gallery.breed()?;
//! assert!(gallery.items().iter().all(|item| item.genome.0.iter().all(|x| (0.0..=1.0).contains(x))));
//! # Ok::<(), chladni_breeding::BreedingError>(())
//! ```
//!
//! Nothing here reads a clock or draws entropy: the same seed and the same calls give the same items, bit
//! for bit.

#![warn(clippy::missing_errors_doc)]

mod crossing;
mod error;
mod gallery;
mod item;
mod suggestion;

pub use crossing::{inherit, shift};
pub use error::BreedingError;
pub use gallery::{CANDIDATES, GALLERY_SIZES, Gallery, Mutation};
pub use item::{GalleryItem, Generation, Genome, ItemId, Origin, item_name};
pub use rand_chacha::ChaCha8Rng;
pub use rand_chacha::rand_core::SeedableRng;
pub use suggestion::{Describe, Descriptor, most_different, suggest};

/// The examples of README.md, compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
