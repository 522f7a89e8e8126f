//! What the middle of the music room shows, and what its items are marked as.

/// What the middle of the room shows while nothing is on stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum View {
    /// All items.
    #[default]
    Gallery,
    /// One item of the gallery, with its curves.
    CloseUp(usize),
    /// The harmonics of the body from this one on, and their symmetry.
    Harmonics(usize),
}

/// What an item is marked as.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Marks {
    /// As a parent.
    pub chosen: bool,
    /// As a favorite.
    pub favorite: bool,
    /// As one that stays in its place.
    pub locked: bool,
}
