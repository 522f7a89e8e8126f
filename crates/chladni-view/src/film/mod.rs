//! Films: frames in, one file (or a folder of frames) out, encoded while the next frames are drawn.

mod camera;
mod cut_off;
mod feed;
mod ffmpeg;
mod frames;
mod gif;
mod live;
mod mp4;
mod palette;
mod raw;
mod shoot;
mod whole;

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use chladni_task::temporary_beside;

use crate::picture::is_opaque;
use crate::{Picture, ViewError};

pub use camera::{CameraTarget, HAS_SYPHON, LiveCamera, video_devices};
pub use cut_off::CutOff;
pub use ffmpeg::{add_input, ffmpeg, ffmpeg_is_there};
pub use frames::frame_path;
pub use live::LiveFilm;
pub use raw::RawFormat;
pub use shoot::{Waits, shoot, shoot_retouched};

/// Frames per second as a fraction, so that 29.97 (30000/1001) stays exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRate {
    /// Frames …
    pub numerator: u32,
    /// … in this many seconds.
    pub denominator: u32,
}

impl FrameRate {
    /// Rates of films that a person may ask for, frames per second.
    pub const WANTED_PER_SECOND: RangeInclusive<f64> = 1.0..=240.0;

    /// `fps` frames per second.
    pub const fn per_second(fps: u32) -> Self {
        Self { numerator: fps, denominator: 1 }
    }

    /// `fps` frames per second as a person writes them: 29.97 means NTSC's 30000/1001. Others are rounded to
    /// thousandths. No frames at all where `fps` is not a number, or not above 0.
    pub fn decimal(fps: f64) -> Self {
        if fps.fract() == 0.0 {
            return Self::per_second(fps as u32);
        }
        let is_ntsc = (fps.ceil() / fps - 1.001).abs() < 2e-4;
        if is_ntsc {
            Self { numerator: 1000 * fps.ceil() as u32, denominator: 1001 }
        } else {
            Self { numerator: (fps * 1000.0).round() as u32, denominator: 1000 }
        }
    }

    /// When frame `index` begins, seconds.
    pub fn start_secs(self, index: u64) -> f64 {
        index as f64 * f64::from(self.denominator) / f64::from(self.numerator)
    }

    /// The frame that is shown at a time; the first one before it begins.
    pub fn slot(self, at_secs: f64) -> u64 {
        (at_secs * f64::from(self.numerator) / f64::from(self.denominator)).max(0.0) as u64
    }

    /// The frame that a picture shown live is meant for. Screens show pictures where frames begin, a little early or late;
    /// a quarter of a frame of room keeps each of them in its own.
    pub fn live_slot(self, at_secs: f64) -> u64 {
        self.slot(at_secs + 0.25 * self.start_secs(1))
    }

    /// The number of frames that fill `secs`, at least 1.
    pub fn frames_in(self, secs: f64) -> u64 {
        (secs * f64::from(self.numerator) / f64::from(self.denominator)).round().max(1.0) as u64
    }
}

/// The kind of file that a film becomes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilmFormat {
    /// H.264 and AAC through ffmpeg.
    Mp4,
    /// An animated GIF of at most 50 frames per second, looped, without sound.
    Gif,
    /// An animated PNG, looped, without sound; all colors and alpha.
    Apng,
    /// A folder of `frame-00000.png` …, without sound.
    Frames,
}

impl FilmFormat {
    /// The most frames a second that a GIF shows.
    pub const GIF_MOST_FPS: u32 = 50;

    /// By the ending of `path`: `.mp4`, `.gif`, `.png` or `.apng`, and none for a folder.
    ///
    /// # Errors
    /// [`ViewError::Film`] for any other ending.
    pub fn of(path: &Path) -> Result<Self, ViewError> {
        let Some(ending) = path.extension() else { return Ok(Self::Frames) };
        match ending.to_string_lossy().to_lowercase().as_str() {
            "mp4" | "m4v" => Ok(Self::Mp4),
            "gif" => Ok(Self::Gif),
            "png" | "apng" => Ok(Self::Apng),
            other => Err(ViewError::Film(format!(
                "{}: a film ends in .mp4, .gif or .png, or is a folder; not .{other}",
                path.display()
            ))),
        }
    }
}

/// Pixels without alpha, laid on black. `memory` holds them where any is.
fn on_black<'a>(rgba: &'a [u8], memory: &'a mut Vec<u8>) -> &'a [u8] {
    if is_opaque(rgba) {
        return rgba;
    }
    let pixels = rgba.as_chunks::<4>().0;
    memory.clear();
    memory.extend(pixels.iter().flat_map(|pixel| {
        let [r, g, b] = Picture::on_black(*pixel);
        [r, g, b, 255]
    }));
    memory
}

/// Size, rate and sound of a film.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FilmSettings {
    /// Pixels in a row; MP4 drops the last column of an odd width.
    pub width: u32,
    /// Rows; MP4 drops the last of an odd height.
    pub height: u32,
    /// Frames per second.
    pub rate: FrameRate,
    /// How many frames there will be.
    pub frames: u64,
    /// The number of the first frame, used in the names of pictures in a folder: not 0 in a piece of a longer film.
    pub first: u64,
    /// A sound file that ffmpeg reads (WAV), laid under an MP4 from its first frame on and cut or
    /// filled with silence to the film's length. The other formats have no sound.
    pub audio: Option<PathBuf>,
}

impl FilmSettings {
    /// Checks that a film of this format can have them.
    ///
    /// # Errors
    /// [`ViewError::Size`], and [`ViewError::Film`] for a rate or a size that the format does not know.
    pub fn check_for(&self, format: FilmFormat) -> Result<(), ViewError> {
        self.check()?;
        let most = u64::from(FilmFormat::GIF_MOST_FPS);
        let fast = u64::from(self.rate.numerator) > most * u64::from(self.rate.denominator);
        match format {
            FilmFormat::Gif if fast => {
                Err(ViewError::Film(format!("a GIF shows at most {most} frames per second")))
            }
            FilmFormat::Mp4 if self.width < 2 || self.height < 2 => {
                Err(ViewError::Film("an MP4 needs at least 2×2 pixels".into()))
            }
            FilmFormat::Apng => frames::delay(self.rate).map(drop),
            _ => Ok(()),
        }
    }

    fn check(&self) -> Result<(), ViewError> {
        let Self { width, height, rate, frames, .. } = *self;
        let sane = 1..=16_384;
        if !sane.contains(&width) || !sane.contains(&height) {
            return Err(ViewError::Size { width, height, limit: 16_384 });
        }
        if rate.numerator == 0 || rate.denominator == 0 || frames == 0 {
            return Err(ViewError::Film("no frames, or none per second".into()));
        }
        Ok(())
    }
}

/// A film that is being written. One that is dropped before [`finish`](Self::finish) leaves nothing behind, except
/// complete frames in a folder. [`shoot`] encodes beside drawing.
pub struct Film {
    settings: FilmSettings,
    pushed: u64,
    encoder: Box<dyn Encode>,
}

/// One file format. Dropped without `finish`, it leaves nothing behind.
trait Encode: Send {
    fn frame(&mut self, picture: &Picture) -> Result<(), ViewError>;
    fn finish(self: Box<Self>) -> Result<(), ViewError>;
}

impl Film {
    /// Begins a film at `path`, in the format of its ending.
    ///
    /// # Errors
    /// [`ViewError::NoFfmpeg`] for an MP4 without ffmpeg, [`ViewError::Film`] for settings the
    /// format cannot hold, [`ViewError::File`] where the file cannot be made.
    pub fn create(path: &Path, settings: FilmSettings) -> Result<Self, ViewError> {
        Self::create_as(FilmFormat::of(path)?, path, settings)
    }

    /// Begins a film of this format, whatever its name ends in: that of a folder may have a dot.
    ///
    /// # Errors
    /// As [`create`](Self::create).
    pub fn create_as(format: FilmFormat, path: &Path, settings: FilmSettings) -> Result<Self, ViewError> {
        settings.check_for(format)?;
        let encoder: Box<dyn Encode> = match format {
            FilmFormat::Mp4 => Box::new(mp4::Mp4::create(path, &settings, mp4::Layout::Whole)?),
            FilmFormat::Gif => Box::new(gif::Gif::create(path, &settings)?),
            FilmFormat::Apng => Box::new(frames::Apng::create(path, &settings)?),
            FilmFormat::Frames => Box::new(frames::Folder::create(path, settings.first)?),
        };
        Ok(Self { settings, pushed: 0, encoder })
    }

    /// Begins a film whose frames go to `pipe` as they are, without sound.
    ///
    /// # Errors
    /// [`ViewError::Film`] for settings that no film has, and where the pipe cannot be written to.
    pub fn to_pipe(
        pipe: impl std::io::Write + Send + 'static,
        format: RawFormat,
        settings: FilmSettings,
    ) -> Result<Self, ViewError> {
        settings.check()?;
        let encoder = Box::new(raw::Raw::begin(pipe, format, &settings)?);
        Ok(Self { settings, pushed: 0, encoder })
    }

    /// Size, rate and sound.
    pub fn settings(&self) -> &FilmSettings {
        &self.settings
    }

    /// Encodes the next frame.
    ///
    /// # Errors
    /// [`ViewError::Film`] for a picture of another size or one too many, and whatever the encoder says.
    pub fn push(&mut self, picture: &Picture) -> Result<(), ViewError> {
        let FilmSettings { width, height, frames, .. } = self.settings;
        let bytes = 4 * width as usize * height as usize;
        if (picture.width, picture.height, picture.rgba.len()) != (width, height, bytes) {
            let (w, h) = (picture.width, picture.height);
            return Err(ViewError::Film(format!("a frame of {w}×{h} in a film of {width}×{height}")));
        }
        if self.pushed == frames {
            return Err(ViewError::Film(format!("more than the {frames} frames it was to have")));
        }
        self.encoder.frame(picture)?;
        self.pushed += 1;
        Ok(())
    }

    /// Ends the film: its file appears.
    ///
    /// # Errors
    /// [`ViewError::Film`] where frames are missing, and whatever the encoder says.
    pub fn finish(self) -> Result<(), ViewError> {
        let wanted = self.settings.frames;
        if self.pushed != wanted {
            return Err(ViewError::Film(format!("{} frames of {wanted}", self.pushed)));
        }
        self.encoder.finish()
    }
}

/// A temporary file beside `path`, with its ending, that becomes `path` when it is complete.
fn beside(path: &Path) -> Result<tempfile::NamedTempFile, ViewError> {
    let ending = path.extension().map(|e| format!(".{}", e.to_string_lossy())).unwrap_or_default();
    temporary_beside(path, &ending).map_err(ViewError::at(path))
}

/// Flushes a complete temporary file and gives it its name.
fn persist(file: tempfile::NamedTempFile, path: &Path) -> Result<(), ViewError> {
    chladni_task::persist(file, path).map_err(ViewError::at(path))
}

/// That bytes of the film at `path` could not be written, with advice.
fn unwritten(path: &Path) -> impl Fn(std::io::Error) -> ViewError {
    move |why| ViewError::at(path)(chladni_task::advised(why))
}
