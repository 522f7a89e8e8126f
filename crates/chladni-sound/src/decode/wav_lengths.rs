//! WAV files that do not state their length: those written to a pipe, and those whose recorder was interrupted.

use std::io::{Read, Result, Seek, SeekFrom};

use super::mended::{Lengths, MAX_CHUNKS, header, is_placeholder};

/// The lengths of a WAV file that were never filled in. They read as 0xff: as a length that means "unknown", and as a name a
/// chunk to be skipped.
pub(super) fn lengths<R: Read + Seek + ?Sized>(source: &mut R) -> Result<Lengths> {
    let patches = blanks(source)?.into_iter().map(|at| (at, [0xff; 4])).collect();
    Ok(Lengths { patches, ..Lengths::default() })
}

/// Where four bytes begin that are not true in a WAV file; nothing in any other.
fn blanks<R: Read + Seek + ?Sized>(source: &mut R) -> Result<Vec<u64>> {
    let end = source.seek(SeekFrom::End(0))?;
    let (riff, riff_length) = chunk(source, 0)?;
    if riff != *b"RIFF" || chunk(source, 8)?.0 != *b"WAVE" {
        return Ok(Vec::new());
    }
    let (mut at, mut counts) = (12, Vec::new());
    for _ in 0..MAX_CHUNKS {
        let (name, length) = chunk(source, at)?;
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
fn chunk<R: Read + Seek + ?Sized>(source: &mut R, at: u64) -> Result<([u8; 4], u64)> {
    header(source, at).map(|(name, length)| (name, u32::from_le_bytes(length).into()))
}

/// Whether a chunk that fits lies at `at`.
fn is_chunk<R: Read + Seek + ?Sized>(source: &mut R, at: u64, end: u64) -> bool {
    let is_named = |name: [u8; 4]| name.iter().all(|c| c.is_ascii_graphic() || *c == b' ');
    chunk(source, at).is_ok_and(|(name, length)| is_named(name) && at + 8 + length <= end)
}
