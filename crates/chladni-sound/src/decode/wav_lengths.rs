//! WAV files that do not state their length: those written to a pipe, and those whose recorder was interrupted.

use std::io::{Read, Result, Seek, SeekFrom};

use symphonia::core::io::MediaSource;

/// The most chunks that are visited; valid files have a few before their sound.
const MAX_CHUNKS: usize = 4096;

/// A file of which some bytes read as 0xff. As a length that means "unknown", and as a name a chunk to be skipped.
struct Blanked {
    source: Box<dyn MediaSource>,
    /// Where four such bytes begin.
    blanks: Vec<u64>,
}

impl Read for Blanked {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let from = self.source.stream_position()?;
        let count = self.source.read(buffer)?;
        for at in self.blanks.iter().flat_map(|blank| *blank..*blank + 4) {
            if let Some(place) = at.checked_sub(from).filter(|place| *place < count as u64) {
                buffer[place as usize] = 0xff;
            }
        }
        Ok(count)
    }
}

impl Seek for Blanked {
    fn seek(&mut self, to: SeekFrom) -> Result<u64> {
        self.source.seek(to)
    }
}

impl MediaSource for Blanked {
    fn is_seekable(&self) -> bool {
        self.source.is_seekable()
    }

    fn byte_len(&self) -> Option<u64> {
        self.source.byte_len()
    }
}

/// `source` itself or, where it is a WAV file with lengths that were never filled in, one that says so.
pub(super) fn without_false_lengths(mut source: Box<dyn MediaSource>) -> Box<dyn MediaSource> {
    match blanks(source.as_mut()) {
        Ok(blanks) if !blanks.is_empty() => Box::new(Blanked { source, blanks }),
        _ => source,
    }
}

/// What is not true in a WAV file; nothing in any other.
fn blanks<R: Read + Seek + ?Sized>(source: &mut R) -> Result<Vec<u64>> {
    let end = source.seek(SeekFrom::End(0))?;
    let (riff, riff_length) = header(source, 0)?;
    if riff != *b"RIFF" || header(source, 8)?.0 != *b"WAVE" {
        return Ok(Vec::new());
    }
    let (mut at, mut counts) = (12, Vec::new());
    for _ in 0..MAX_CHUNKS {
        let (name, length) = header(source, at)?;
        let begin = at + 8;
        let next = begin + length.next_multiple_of(2);
        match &name {
            b"data" => {
                let is_unknown = match length {
                    0 => begin < end && !is_chunk(source, begin, end),
                    _ => is_placeholder(length) && begin + length > end,
                };
                // What is inside may not be longer than the whole.
                return Ok(if is_unknown {
                    counts.extend([4, at + 4]);
                    counts
                } else if 8 + riff_length < begin + length {
                    vec![4]
                } else {
                    Vec::new()
                });
            }
            // It counts the frames, and is as wrong as the length.
            b"fact" => counts.push(at),
            _ => {}
        }
        at = next;
    }
    Ok(Vec::new())
}

/// The name of the chunk at `at`, and its length in bytes.
fn header<R: Read + Seek + ?Sized>(source: &mut R, at: u64) -> Result<([u8; 4], u64)> {
    let mut bytes = [0; 8];
    source.seek(SeekFrom::Start(at))?;
    source.read_exact(&mut bytes)?;
    let [a, b, c, d, length @ ..] = bytes;
    Ok(([a, b, c, d], u32::from_le_bytes(length).into()))
}

/// Whether a chunk that fits lies at `at`.
fn is_chunk<R: Read + Seek + ?Sized>(source: &mut R, at: u64, end: u64) -> bool {
    let is_named = |name: [u8; 4]| name.iter().all(|c| c.is_ascii_graphic() || *c == b' ');
    header(source, at).is_ok_and(|(name, length)| is_named(name) && at + 8 + length <= end)
}

/// Whether programs that write to a pipe state `length` for one that they do not know: 0x7ffff000 (SoX), 0x80000000 (ALSA)
/// or 0xffffffff (FFmpeg), some less a header.
fn is_placeholder(length: u64) -> bool {
    (0x7fff_0000..=0x8000_0000).contains(&length) || length >= 0xffff_0000
}
