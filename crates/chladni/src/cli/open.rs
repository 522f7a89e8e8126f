//! `chladni open FILE…`: the window.

use std::path::PathBuf;

use super::{Failure, Terminal};
use crate::studio;

/// Open the window, on files where some are given.
#[derive(clap::Args, Default)]
pub struct Open {
    /// Meshes or a project; the first mesh is the shape, the next ones are templates for it.
    files: Vec<PathBuf>,
}

impl Open {
    /// Returns when the window is closed.
    pub fn run(self, _terminal: &Terminal) -> Result<(), Failure> {
        studio::open(self.files).map_err(Failure::other)
    }
}
