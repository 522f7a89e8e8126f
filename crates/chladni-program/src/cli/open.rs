//! `chladni open FILE…`: the window.

use std::path::PathBuf;

use super::Terminal;
use crate::window::{self, Live, Until};
use crate::work::{Error, Watcher};

/// Open the window, on files where some are given.
#[derive(clap::Args, Default)]
pub struct Open {
    /// Meshes or a project, songs, a preset or a session; the first mesh is the shape, the next
    /// ones are templates for it.
    files: Vec<PathBuf>,
    /// Listen to this live input, as the drawer Songs calls it; without a name, to the one that was chosen last.
    #[arg(long, value_name = "NAME", num_args = 0..=1, require_equals = true)]
    live: Option<Option<String>>,
    /// Close by itself after this many seconds of a song, and print as JSON how the frames came and
    /// whether the sound kept in step.
    #[arg(long, value_name = "SECS", requires = "files")]
    measure: Option<f64>,
    /// Close as soon as the shape is on screen, and print as JSON how many seconds that took.
    #[arg(long, requires = "files", conflicts_with = "measure")]
    until_picture: bool,
}

impl Open {
    /// Returns when the window is closed.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        let until = match self.measure {
            Some(secs) => Until::Measured(secs),
            None if self.until_picture => Until::Picture,
            None => Until::Closed,
        };
        let live = self.live.map(|name| name.map_or(Live::Last, Live::Named));
        let outcome = window::open(self.files, live, until, terminal.draw(), terminal.task().clone())?;
        outcome.map_or(Ok(()), |outcome| terminal.json(&outcome))
    }
}
