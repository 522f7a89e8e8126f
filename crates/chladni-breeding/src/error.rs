//! What can go wrong with a gallery.

/// An error of this crate: what, where and why.
#[derive(Debug, thiserror::Error)]
pub enum BreedingError {
    /// A gallery of a size that is not offered.
    #[error("a gallery holds 6, 9, 12 or 16 items, not {0}")]
    GallerySize(usize),
    /// An action names an item, a generation or a candidate that does not exist.
    #[error("there is no {what} {index}: there are {count}")]
    NoSuch {
        /// What was asked for.
        what: &'static str,
        /// Its index, from 0.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// Breeding needs two parents.
    #[error("breeding needs at least 2 chosen items: {0} chosen")]
    NotEnoughParents(usize),
    /// More generations would not fit into memory.
    #[error("no more than these {0} generations are kept: begin another gallery")]
    TooManyGenerations(usize),
    /// A list whose length does not fit the gallery.
    #[error("{what}: {found} where {expected} are needed")]
    Size {
        /// What was counted.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there must be.
        expected: usize,
    },
    /// A number out of its range.
    #[error("{name} = {value} is outside {range}")]
    OutOfRange {
        /// The number.
        name: &'static str,
        /// What was asked for.
        value: f64,
        /// What is allowed.
        range: &'static str,
    },
}
