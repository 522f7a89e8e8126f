//! `chladni choose-file REQUEST`: the file window, for the program itself.

use super::{Failure, Terminal};
use crate::studio;

/// Ask for a file in a small window and print the answer as JSON.
#[derive(clap::Args)]
pub struct ChooseFile {
    /// What is asked for, as JSON.
    request: String,
}

impl ChooseFile {
    /// Returns when the window is closed.
    pub fn run(self, terminal: &Terminal) -> Result<(), Failure> {
        let request = serde_json::from_str(&self.request).map_err(Failure::input)?;
        terminal.json(&studio::choose_file(request).map_err(Failure::other)?)
    }
}
