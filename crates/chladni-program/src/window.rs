//! The link between commands and the window: the only place that opens it.

use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;
use std::time::Instant;

use chladni_task::Task;
use chladni_view::Draw;
use serde::Serialize;

use crate::studio::{self, FirstPicture, FrameReport, Measure};
pub use crate::studio::{CHOOSE_FILE, Live, SetOutput, SetPlan, SetTarget};
use crate::work::Error;

/// The event at which the window closes by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Until {
    /// Nothing: a person closes it.
    Closed,
    /// The shape is on screen.
    Picture,
    /// So many seconds of a song were measured.
    Measured(f64),
}

/// The measurement for which it closed, as JSON.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub enum Outcome {
    /// How long the first picture took.
    Picture {
        /// Since the window was asked for.
        first_picture_secs: f64,
    },
    /// How the frames came.
    Measured(FrameReport),
}

/// Opens the window on `files`, drawn as `draw` asks for, and returns when it is closed; it closes by itself once `ends` is
/// cancelled. The music room begins the `set`.
///
/// # Errors
/// [`Error::Other`] where it cannot open, or was closed before what was waited for; [`Error::Input`] where a
/// file shows no picture.
pub fn open(
    files: Vec<PathBuf>,
    set: SetPlan,
    until: Until,
    draw: Draw,
    ends: Task,
) -> Result<Option<Outcome>, Error> {
    let measure = match until {
        Until::Measured(secs) => Some(Rc::new(RefCell::new(Measure::new(secs)))),
        Until::Closed | Until::Picture => None,
    };
    let picture = (until == Until::Picture).then(|| Rc::new(FirstPicture::since(Instant::now())));
    studio::open(files, set, measure.clone(), picture.clone(), draw, ends).map_err(Error::other)?;
    if let Some(picture) = picture {
        let first_picture_secs = match picture.outcome() {
            Some(seen) => seen.map_err(Error::Input)?,
            None => return Err(Error::other("the window was closed before a shape was seen")),
        };
        return Ok(Some(Outcome::Picture { first_picture_secs }));
    }
    let Some(measure) = measure else { return Ok(None) };
    match measure.borrow().report() {
        Some(report) => Ok(Some(Outcome::Measured(report))),
        None => Err(Error::other("the window was closed before a song was heard")),
    }
}

/// Opens the small window that asks for a file, with `request` as JSON, drawn as `draw` asks for, and returns the answer.
///
/// # Errors
/// [`Error::Input`] for an invalid request, [`Error::Other`] where the window cannot open.
pub fn choose_file(request: &str, draw: Draw) -> Result<Vec<PathBuf>, Error> {
    let request = serde_json::from_str(request).map_err(Error::input)?;
    studio::choose_file(request, draw).map_err(Error::other)
}
