//! The content of a gallery: genomes, the items that they define, and where each item comes from.

use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// A set of numbers that defines an item and can be bred.
pub trait Genome: Clone + Send + Sync {
    /// A child of two parents; a child of two equal parents is equal to them.
    fn child(mother: &Self, father: &Self, rng: &mut ChaCha8Rng) -> Self;

    /// A copy in which no number has moved by more than `amount`, in [0, 1], of its range.
    fn mutant(&self, amount: f32, rng: &mut ChaCha8Rng) -> Self;

    /// How many numbers the genome holds.
    fn genes(&self) -> usize;

    /// Whether an item with this genome is worth showing.
    fn is_viable(&self) -> bool {
        true
    }
}

/// Identifies one item permanently: no two items of a show share an id.
pub type ItemId = u32;

/// Where an item comes from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "from")]
pub enum Origin {
    /// Created with the initial gallery of a seed.
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
    /// A random change of one item.
    Mutated {
        /// Its id.
        parent: ItemId,
    },
    /// Read from a preset file.
    Loaded {
        /// The preset's name. It is stored as `preset`, because the item beside it in a line of lineage has
        /// a `name` already.
        #[serde(rename = "preset", default)]
        name: String,
    },
}

/// The longest name of an item, in characters.
const LONGEST_NAME: usize = 200;

/// A name as an item may have it, of what a user or a file says: one line, of at most 200 characters.
pub fn item_name(said: &str) -> String {
    said.chars().filter(|c| !c.is_control()).take(LONGEST_NAME).collect()
}

/// One item of a gallery.
#[derive(Clone, Debug, PartialEq)]
pub struct GalleryItem<G> {
    /// Its id.
    pub id: ItemId,
    /// The name that the user gave it; empty without one.
    pub name: String,
    /// The numbers that define it.
    pub genome: G,
    /// Where it comes from.
    pub origin: Origin,
    /// Whether it was changed by hand after it was created.
    pub edited: bool,
    /// Whether it is chosen as a parent.
    pub chosen: bool,
    /// Whether that choice no longer counts as a preference.
    pub forgotten: bool,
    /// Whether it stays in its place when the others are replaced.
    pub locked: bool,
}

/// The items that are shown together.
#[derive(Clone, Debug, PartialEq)]
pub struct Generation<G> {
    /// S items.
    pub items: Vec<GalleryItem<G>>,
    /// Index of the generation from which this one was made; `None` for the first.
    pub from: Option<usize>,
}
