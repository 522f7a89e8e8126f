//! `chladni controls`: the targets that a controller can learn or OSC can address.

use clap::Args;

use super::Terminal;
use crate::work::Error;

/// Print all that controllers and OSC can turn, as a page in Markdown.
#[derive(Args)]
pub struct Controls {}

impl Controls {
    /// Runs the command.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        terminal.page(chladni_music::controls_page().trim_end())
    }
}
