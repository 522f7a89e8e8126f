//! AIFF files that state another length than they have: those that were cut, and those whose recorder was interrupted.

use std::io::{Read, Result, Seek, SeekFrom};

use super::mended::{Ending, Lengths, MAX_CHUNKS, header, is_placeholder};

/// The length of a chunk has 32 bits.
const LONGEST: u64 = u32::MAX as u64;

/// The lengths of an AIFF or AIFC file, as far as they are not those of what is there.
pub(super) fn lengths<R: Read + Seek + ?Sized>(source: &mut R) -> Result<Lengths> {
    let end = source.seek(SeekFrom::End(0))?;
    let (_, form_length) = chunk(source, 0)?;
    if ![*b"AIFF", *b"AIFC"].contains(&chunk(source, 8)?.0) {
        return Ok(Lengths::default());
    }
    let form_end = 8 + form_length;
    let (mut at, mut frames) = (12, None);
    for _ in 0..MAX_CHUNKS {
        let (name, length) = chunk(source, at)?;
        let begin = at + 8;
        match &name {
            b"COMM" => {
                let ([_, _, a, b], [c, d, ..]) = header(source, begin)?;
                frames = Some(u64::from(u32::from_be_bytes([a, b, c, d])));
            }
            b"SSND" => {
                let is_beyond = begin + length > end;
                let is_unknown = length == 0 || is_beyond && is_placeholder(length);
                let is_cut = is_beyond && !is_unknown;
                let there = if is_beyond || is_unknown {
                    end.saturating_sub(begin).min(LONGEST.saturating_sub(begin))
                } else {
                    length
                };
                let mut lengths = Lengths::default();
                if there != length {
                    lengths.patches.push((at + 4, (there as u32).to_be_bytes()));
                }
                // What is inside may not be longer than the whole, and what is not there is not looked for.
                if form_end < begin + there || form_end > end {
                    let sound = begin + there;
                    let whole = if there == length { whole_chunks(source, sound, end) } else { sound };
                    let form = (whole - 8).min(LONGEST) as u32;
                    lengths.patches.push((4, form.to_be_bytes()));
                }
                if is_cut {
                    lengths.ending = Ending::Cut;
                    // A frame takes a byte or more.
                    lengths.frames = frames.filter(|frames| (1..=length).contains(frames));
                }
                return Ok(lengths);
            }
            _ => {}
        }
        at = begin + length.next_multiple_of(2);
    }
    Ok(Lengths::default())
}

/// The end of the last chunk that is whole, from the one that ends at `at` on: taggers write theirs behind the sound.
fn whole_chunks<R: Read + Seek + ?Sized>(source: &mut R, mut at: u64, end: u64) -> u64 {
    for _ in 0..MAX_CHUNKS {
        let begin = at.next_multiple_of(2);
        let Ok((_, length)) = chunk(source, begin) else { break };
        let next = begin + 8 + length;
        if next > end {
            break;
        }
        at = next;
    }
    at
}

/// The name of the chunk at `at`, and its length in bytes.
fn chunk<R: Read + Seek + ?Sized>(source: &mut R, at: u64) -> Result<([u8; 4], u64)> {
    header(source, at).map(|(name, length)| (name, u32::from_be_bytes(length).into()))
}
