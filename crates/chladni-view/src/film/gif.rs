//! Animated GIF with one palette for the whole clip and a dither that does not crawl.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use gif::{DisposalMethod, Encoder, EncodingError, Frame, Repeat};

use super::palette::Palette;
use super::{Encode, FilmSettings, FrameRate, beside, persist, unwritten};
use crate::{Picture, ViewError};

/// Bytes of frames that are kept back to choose the palette from; a longer clip takes the
/// palette of its beginning.
const KEPT_BACK: usize = 192 << 20;

pub(super) struct Gif {
    path: PathBuf,
    file: tempfile::NamedTempFile,
    rate: FrameRate,
    width: u16,
    height: u16,
    frames: u64,
    /// Frames that wait for the palette.
    waiting: Vec<Picture>,
    writer: Option<Writer>,
}

/// The writer, which exists once the palette does.
struct Writer {
    encoder: Encoder<BufWriter<File>>,
    palette: Palette,
    /// The indices that a viewer shows at this moment.
    shown: Vec<u8>,
    written: u64,
}

impl Gif {
    pub(super) fn create(path: &Path, settings: &FilmSettings) -> Result<Self, ViewError> {
        let rate = settings.rate;
        Ok(Self {
            path: path.to_owned(),
            file: beside(path)?,
            rate,
            // Film::create bounds both sides by 16384.
            width: settings.width as u16,
            height: settings.height as u16,
            frames: settings.frames,
            waiting: Vec::new(),
            writer: None,
        })
    }

    fn write(&mut self, picture: &Picture) -> Result<(), ViewError> {
        let (width, height) = (self.width, self.height);
        let Some(writer) = &mut self.writer else { return Ok(()) };
        let indices = writer.palette.indices(picture);
        let start = |index: u64| (self.rate.start_secs(index) * 100.0).round() as u64;
        let delay = start(writer.written + 1) - start(writer.written);
        writer.written += 1;
        let mut frame = Frame {
            delay: u16::try_from(delay).unwrap_or(u16::MAX),
            width,
            height,
            transparent: Some(Palette::CLEAR),
            ..Frame::default()
        };
        if writer.palette.has_clear {
            // Where the clip has holes, each frame stands alone.
            frame.dispose = DisposalMethod::Background;
            frame.buffer = indices.into();
            return writer.encoder.write_frame(&frame).map_err(failure(&self.path));
        }
        frame.dispose = DisposalMethod::Keep;
        let changed = changed_box(&indices, &writer.shown, usize::from(width));
        let [left, top, right, bottom] = changed;
        (frame.left, frame.top) = (left as u16, top as u16);
        (frame.width, frame.height) = ((right - left) as u16, (bottom - top) as u16);
        let mut buffer = Vec::with_capacity((right - left) * (bottom - top));
        for y in top..bottom {
            for x in left..right {
                let at = y * usize::from(width) + x;
                // Unchanged pixels are clear: long runs compress well.
                let same = writer.shown.get(at) == Some(&indices[at]);
                buffer.push(if same { Palette::CLEAR } else { indices[at] });
            }
        }
        frame.buffer = buffer.into();
        writer.shown = indices;
        writer.encoder.write_frame(&frame).map_err(failure(&self.path))
    }

    /// Chooses the palette from the frames that wait, and writes them.
    fn settle(&mut self) -> Result<(), ViewError> {
        let palette = Palette::of(&self.waiting);
        let handle = self.file.reopen().map_err(ViewError::at(&self.path))?;
        let mut encoder = Encoder::new(BufWriter::new(handle), self.width, self.height, &palette.bytes())
            .map_err(failure(&self.path))?;
        encoder.set_repeat(Repeat::Infinite).map_err(failure(&self.path))?;
        self.writer = Some(Writer { encoder, palette, shown: Vec::new(), written: 0 });
        for picture in std::mem::take(&mut self.waiting) {
            self.write(&picture)?;
        }
        Ok(())
    }
}

/// That the GIF at `path` could not be encoded or written.
fn failure(path: &Path) -> impl Fn(EncodingError) -> ViewError {
    move |why| match why {
        EncodingError::Io(why) => unwritten(path)(why),
        why => ViewError::image(why),
    }
}

impl Encode for Gif {
    fn frame(&mut self, picture: &Picture) -> Result<(), ViewError> {
        if self.writer.is_some() {
            return self.write(picture);
        }
        self.waiting.push(picture.clone());
        let kept: usize = self.waiting.iter().map(|picture| picture.rgba.len()).sum();
        let are_all = self.waiting.len() as u64 == self.frames;
        if kept >= KEPT_BACK || are_all { self.settle() } else { Ok(()) }
    }

    fn finish(mut self: Box<Self>) -> Result<(), ViewError> {
        if self.writer.is_none() {
            self.settle()?;
        }
        let Self { path, file, writer, .. } = *self;
        if let Some(writer) = writer {
            let buffered = writer.encoder.into_inner().map_err(failure(&path))?;
            buffered.into_inner().map_err(|why| unwritten(&path)(why.into_error()))?;
        }
        persist(file, &path)
    }
}

/// Left, top, right, bottom (exclusive) of what differs; one pixel where nothing does.
fn changed_box(now: &[u8], before: &[u8], width: usize) -> [usize; 4] {
    if now.len() != before.len() {
        return [0, 0, width, now.len() / width];
    }
    let (mut left, mut top, mut right, mut bottom) = (width, usize::MAX, 0, 0);
    for (y, (a, b)) in now.chunks_exact(width).zip(before.chunks_exact(width)).enumerate() {
        let Some(first) = a.iter().zip(b).position(|(a, b)| a != b) else { continue };
        let last = a.iter().zip(b).rposition(|(a, b)| a != b).unwrap_or(first);
        (left, right) = (left.min(first), right.max(last + 1));
        (top, bottom) = (top.min(y), y + 1);
    }
    if top == usize::MAX { [0, 0, 1, 1] } else { [left, top, right, bottom] }
}
