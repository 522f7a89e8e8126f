//! The content of the middle of the music room.

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
