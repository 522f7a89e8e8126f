//! `chladni open FILE…`: the window.

use std::path::{Path, PathBuf};

use chladni_view::film::{FilmFormat, RawFormat};

use super::Terminal;
use super::choice::one_of;
use super::frames::Size;
use super::number::number;
use crate::window::{self, Live, SetOutput, SetPlan, SetTarget, Until};
use crate::work::outputs::{check_apart, check_ffmpeg, check_file};
use crate::work::{Error, Watcher};

/// Open the window, on files where some are given.
#[derive(clap::Args, Default)]
pub struct Open {
    /// Meshes or a project, songs, folders of songs, lists of them (.m3u, .m3u8), a preset or a show; the first mesh is the
    /// shape, the next ones are templates for it.
    files: Vec<PathBuf>,
    /// Listen to this live input, as the drawer Songs calls it; without a name, to the one that was chosen last.
    #[arg(long, value_name = "NAME", num_args = 0..=1, require_equals = true)]
    live: Option<Option<String>>,
    /// Lean back: the autopilot takes the stage as soon as the shape is there, for songs and for live input.
    #[arg(long)]
    autopilot: bool,
    /// Close by itself after this many seconds of a song, and print as JSON how the frames came and
    /// whether the sound kept in step.
    #[arg(long, value_name = "SECS", value_parser = seconds, requires = "files",
        allow_negative_numbers = true)]
    measure: Option<f64>,
    /// Close as soon as the shape is on screen, and print as JSON how many seconds that took.
    #[arg(long, requires = "files", conflicts_with = "measure")]
    until_picture: bool,
    /// Record the set from its first picture on: an .mp4 with what is heard (needs ffmpeg). Or -: the stage's frames as they
    /// are on standard output, silent, 30 a second, for a program that streams or mixes them.
    #[arg(short, long, value_name = "FILM")]
    output: Option<PathBuf>,
    /// What -o - writes: rgba (8 bits each, row by row; the reader has to know size and rate), the default,
    /// or y4m, which says both.
    #[arg(long, value_name = "FORMAT", value_parser = one_of(RawFormat::NAMED), requires = "output")]
    format: Option<RawFormat>,
    /// Width and height of what -o gets, in pixels; those of the stage unless given. An .mp4 leaves out the last column
    /// or row of odd ones.
    #[arg(long, value_name = "WIDTHxHEIGHT", requires = "output")]
    size: Option<Size>,
}

fn seconds(text: &str) -> Result<f64, Error> {
    number(text, |secs: &f64| secs.is_finite() && *secs > 0.0, "a number of seconds above 0")
}

impl Open {
    /// Returns when the window is closed.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        let until = match self.measure {
            Some(secs) => Until::Measured(secs),
            None if self.until_picture => Until::Picture,
            None => Until::Closed,
        };
        let output = self.set_output(until)?;
        let live = self.live.map(|name| name.map_or(Live::Last, Live::Named));
        let set = SetPlan { live, autopilot: self.autopilot, output };
        let outcome = window::open(self.files, set, until, terminal.draw(), terminal.task().clone())?;
        outcome.map_or(Ok(()), |outcome| terminal.json(&outcome))
    }

    /// Where the set goes.
    fn set_output(&self, until: Until) -> Result<Option<SetOutput>, Error> {
        let Some(path) = &self.output else { return Ok(None) };
        let to = if path == Path::new("-") {
            if until != Until::Closed {
                return Err(Error::input("-o - and what is measured would both write to standard output"));
            }
            SetTarget::Frames(self.format.unwrap_or_default())
        } else if self.format.is_some() {
            return Err(Error::input("--format says what -o - writes; a recording is an .mp4"));
        } else if !FilmFormat::of(path).is_ok_and(|format| format == FilmFormat::Mp4) {
            return Err(Error::input(format!("{}: a set is recorded as an .mp4", path.display())));
        } else {
            // A window would play the whole set before anybody sees that none of it is recorded.
            check_file(path)?;
            check_ffmpeg().map_err(|why| Error::from(why).of(path.display()))?;
            check_apart(path, &self.files.iter().map(PathBuf::as_path).collect::<Vec<_>>())?;
            SetTarget::Film(path.clone())
        };
        Ok(Some(SetOutput { to, size: self.size.map(|size| [size.width, size.height]) }))
    }
}
