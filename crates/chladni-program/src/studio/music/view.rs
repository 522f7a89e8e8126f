//! The content of the middle of the music room, and the marks of its items.

/// The content of the middle of the room while nothing is on stage.
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

/// The marks of an item.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Marks {
    /// As a parent.
    pub chosen: bool,
    /// As a favorite.
    pub favorite: bool,
    /// As one that stays in its place.
    pub locked: bool,
}
