//! `chladni open FILE…`: the window.

use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;
use std::time::Instant;

use super::{Failure, Terminal};
use crate::studio::{self, FirstPicture, Measure};

/// Open the window, on files where some are given.
#[derive(clap::Args, Default)]
pub struct Open {
    /// Meshes or a project, songs, a preset or a session; the first mesh is the shape, the next
    /// ones are templates for it.
    files: Vec<PathBuf>,
    /// Close by itself after so many seconds of a song, and print as JSON how the frames came and
    /// whether the sound kept in step.
    #[arg(long, value_name = "SECS", requires = "files")]
    measure: Option<f64>,
    /// Close as soon as the shape is on screen, and print as JSON how many seconds that took.
    #[arg(long, requires = "files", conflicts_with = "measure")]
    until_picture: bool,
}

/// What `--until-picture` prints.
#[derive(serde::Serialize)]
struct Start {
    first_picture_secs: f64,
}

impl Open {
    /// Returns when the window is closed.
    pub fn run(self, terminal: &Terminal) -> Result<(), Failure> {
        let measure = self.measure.map(|secs| Rc::new(RefCell::new(Measure::new(secs))));
        let first_picture = self.until_picture.then(|| Rc::new(FirstPicture::since(Instant::now())));
        studio::open(self.files, measure.clone(), first_picture.clone()).map_err(Failure::other)?;
        if let Some(first_picture) = first_picture {
            return match first_picture.outcome() {
                Some(Ok(first_picture_secs)) => terminal.json(&Start { first_picture_secs }),
                Some(Err(why)) => Err(Failure::BadInput(why)),
                None => Err(Failure::other("the window was closed before a shape was seen")),
            };
        }
        match measure {
            Some(measure) => match measure.borrow().report() {
                Some(report) => terminal.json(&report),
                None => Err(Failure::other("the window was closed before a song was heard")),
            },
            None => Ok(()),
        }
    }
}
