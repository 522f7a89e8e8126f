//! The errors of this crate.

/// Why an action on a gallery was refused.
#[derive(Debug, thiserror::Error)]
pub enum BreedingError {
    /// A gallery of a size that is not offered.
    #[error("a gallery holds 6, 9, 12 or 16 items, not {0}")]
    GallerySize(usize),
    /// An action names an item, a generation or a candidate that does not exist.
    #[error("there is no {what} {index}: there are {count}")]
    NoSuch {
        /// The kind of thing: `item`, `generation` or `candidate`.
        what: &'static str,
        /// The index that was asked for, from 0.
        index: usize,
        /// How many of them exist.
        count: usize,
    },
    /// Too few items are chosen as parents.
    #[error("breeding needs at least 2 chosen items: {0} chosen")]
    NotEnoughParents(usize),
    /// More generations would not fit into memory.
    #[error("no more than these {0} generations are kept: begin another gallery")]
    TooManyGenerations(usize),
    /// A list with the wrong length for the gallery.
    #[error("{what}: {found} where {expected} are needed")]
    Size {
        /// The content of the list.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there must be.
        expected: usize,
    },
    /// A number out of its range.
    #[error("{name} = {value} is outside {range}")]
    OutOfRange {
        /// Name of the number.
        name: &'static str,
        /// The value that was given.
        value: f64,
        /// The values that are allowed.
        range: &'static str,
    },
}
