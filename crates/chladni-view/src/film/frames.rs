//! Lossless films: an animated PNG, or a folder of pictures.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use super::{Encode, FilmSettings, FrameRate, beside, persist, unwritten};
use crate::{Picture, ViewError};

/// One PNG with all frames.
pub(super) struct Apng {
    path: PathBuf,
    file: tempfile::NamedTempFile,
    writer: png::Writer<BufWriter<File>>,
}

impl Apng {
    pub(super) fn create(path: &Path, settings: &FilmSettings) -> Result<Self, ViewError> {
        let (numerator, denominator) = delay(settings.rate)?;
        let frames = u32::try_from(settings.frames)
            .map_err(|_| ViewError::Film(format!("an animated PNG of {} frames", settings.frames)))?;
        let file = beside(path)?;
        let handle = file.reopen().map_err(ViewError::at(path))?;
        let mut encoder = png::Encoder::new(BufWriter::new(handle), settings.width, settings.height);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_animated(frames, 0).map_err(ViewError::image)?;
        encoder.set_frame_delay(numerator, denominator).map_err(ViewError::image)?;
        let writer = encoder.write_header().map_err(failure(path))?;
        Ok(Self { path: path.to_owned(), file, writer })
    }
}

/// How long a frame is shown, in seconds, as the fraction of two short numbers that an animated PNG holds.
pub(super) fn delay(rate: FrameRate) -> Result<(u16, u16), ViewError> {
    let FrameRate { numerator, denominator } = rate;
    let (mut divisor, mut rest) = (numerator, denominator);
    while rest > 0 {
        (divisor, rest) = (rest, divisor % rest);
    }
    let short = |n: u32| u16::try_from(n / divisor.max(1)).ok();
    short(denominator).zip(short(numerator)).ok_or_else(|| {
        ViewError::Film(format!("an animated PNG cannot hold a rate of {numerator}/{denominator}"))
    })
}

/// That the animated PNG at `path` could not be encoded or written.
fn failure(path: &Path) -> impl Fn(png::EncodingError) -> ViewError {
    move |why| match why {
        png::EncodingError::IoError(why) => unwritten(path)(why),
        why => ViewError::image(why),
    }
}

impl Encode for Apng {
    fn frame(&mut self, picture: &Picture) -> Result<(), ViewError> {
        self.writer.write_image_data(&picture.rgba).map_err(failure(&self.path))
    }

    fn finish(self: Box<Self>) -> Result<(), ViewError> {
        let Self { path, file, writer } = *self;
        writer.finish().map_err(failure(&path))?;
        persist(file, &path)
    }
}

/// `frame-00000.png`, `frame-00001.png`, …
pub(super) struct Folder {
    path: PathBuf,
    next: u64,
}

/// The picture of frame `number` in `folder`; it is there whole or not at all.
pub fn frame_path(folder: &Path, number: u64) -> PathBuf {
    folder.join(format!("frame-{number:05}.png"))
}

impl Folder {
    pub(super) fn create(path: &Path, first: u64) -> Result<Self, ViewError> {
        chladni_task::create_folder(path).map_err(ViewError::at(path))?;
        Ok(Self { path: path.to_owned(), next: first })
    }
}

impl Encode for Folder {
    fn frame(&mut self, picture: &Picture) -> Result<(), ViewError> {
        let path = frame_path(&self.path, self.next);
        self.next += 1;
        let png = picture.to_png()?;
        chladni_task::write_atomic(&path, &png).map_err(ViewError::at(&path))
    }

    fn finish(self: Box<Self>) -> Result<(), ViewError> {
        Ok(())
    }
}
