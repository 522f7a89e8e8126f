//! `chladni choose-file REQUEST`: the file window, for the program itself.

use super::Terminal;
use crate::window;
use crate::work::Error;

/// Ask for a file in a small window and print the answer as JSON.
#[derive(clap::Args)]
pub struct ChooseFile {
    /// The request, as JSON.
    request: String,
}

impl ChooseFile {
    /// Returns when the window is closed.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        terminal.json(&window::choose_file(&self.request, terminal.draw())?)
    }
}
