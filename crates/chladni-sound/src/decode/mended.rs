//! A file whose lengths are read otherwise than it states them.

use std::io::{Read, Result, Seek, SeekFrom};

use symphonia::core::io::MediaSource;

/// Where the sound of a file ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Ending {
    /// Where the file states it, as far as that was looked at.
    #[default]
    Stated,
    /// The file states more than it holds.
    Cut,
    /// Where the file ends: it states nothing.
    Open,
}

/// How the lengths in a file are to be read.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Lengths {
    /// Where four bytes are replaced, and by which.
    pub patches: Vec<(u64, [u8; 4])>,
    /// Where the file is taken to end, in bytes; beyond its own end there is nothing to read.
    pub end: Option<u64>,
    /// Whether it is read from front to back, without looking for what should lie behind.
    pub is_stream: bool,
    /// Where the sound ends.
    pub ending: Ending,
    /// How many frames of sound are stated, where fewer are left.
    pub frames: Option<u64>,
}

/// A file that is read with these lengths.
pub(super) struct Mended {
    pub source: Box<dyn MediaSource>,
    pub lengths: Lengths,
}

impl Read for Mended {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let from = self.source.stream_position()?;
        let left = self.lengths.end.map_or(u64::MAX, |end| end.saturating_sub(from));
        let count = Read::take(&mut self.source, left).read(buffer)?;
        for (patch, bytes) in &self.lengths.patches {
            for (at, byte) in (*patch..).zip(bytes) {
                if let Some(place) = at.checked_sub(from).filter(|place| *place < count as u64) {
                    buffer[place as usize] = *byte;
                }
            }
        }
        Ok(count)
    }
}

impl Seek for Mended {
    fn seek(&mut self, to: SeekFrom) -> Result<u64> {
        match (to, self.lengths.end) {
            (SeekFrom::End(by), Some(end)) => {
                self.source.seek(SeekFrom::Start(end.saturating_add_signed(by)))
            }
            _ => self.source.seek(to),
        }
    }
}

impl MediaSource for Mended {
    fn is_seekable(&self) -> bool {
        !self.lengths.is_stream && self.source.is_seekable()
    }

    /// The bytes that are there: tags are looked for before their end.
    fn byte_len(&self) -> Option<u64> {
        let there = self.source.byte_len().filter(|_| !self.lengths.is_stream)?;
        Some(self.lengths.end.map_or(there, |end| end.min(there)))
    }
}

/// The most chunks that are visited; valid files have a few before their sound.
pub(super) const MAX_CHUNKS: usize = 4096;

/// The first two words at `at`: of a chunk its name and its length, of a box of an MP4 its length and its name.
pub(super) fn header<R: Read + Seek + ?Sized>(source: &mut R, at: u64) -> Result<([u8; 4], [u8; 4])> {
    let mut bytes = [0; 8];
    source.seek(SeekFrom::Start(at))?;
    source.read_exact(&mut bytes)?;
    let [a, b, c, d, rest @ ..] = bytes;
    Ok(([a, b, c, d], rest))
}

/// Whether programs that write to a pipe state `length` for one that they do not know: 0x7ffff000 (SoX), 0x80000000 (ALSA)
/// or 0xffffffff (FFmpeg), some less a header.
pub(super) fn is_placeholder(length: u64) -> bool {
    (0x7fff_0000..=0x8000_0000).contains(&length) || length >= 0xffff_0000
}
