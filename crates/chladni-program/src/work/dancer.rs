//! A body prepared to dance, with symmetry classes of its harmonics.

use std::sync::Arc;

use chladni_harmonics::Body;
use chladni_mesh::Orientation;
use chladni_music::{Dancer, Symmetry, SymmetrySettings};
use chladni_task::Task;

use super::Error;

/// The classes of a body's harmonics, by its mirror plane or, `by_vote`, as in the paper.
///
/// # Errors
/// [`Error::Music`], or [`Error::Cancelled`].
pub fn classes(body: &Body, by_vote: bool, task: &Task) -> Result<Symmetry, Error> {
    Ok(Symmetry::with(body, &SymmetrySettings { by_vote, ..SymmetrySettings::default() }, task)?)
}

/// A body that can dance.
pub struct Dancing {
    /// Harmonics of repeated eigenvalues are mixed so that they have a class.
    pub body: Body,
    /// Its harmonics' classes.
    pub symmetry: Symmetry,
    /// The data that players need.
    pub dancer: Arc<Dancer>,
}

impl Dancing {
    /// `body`, which stands as `stands` says, with the classes that were found.
    ///
    /// # Errors
    /// [`Error::Music`].
    pub fn new(body: &Body, symmetry: Symmetry, stands: &Orientation) -> Result<Self, Error> {
        let body = symmetry.rotated(body);
        let dancer = Arc::new(Dancer::new(&body, &symmetry.classes, stands)?);
        Ok(Self { body, symmetry, dancer })
    }
}
