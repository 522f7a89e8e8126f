//! Writing stereo WAV files.

use std::io::{self, Write};
use std::path::Path;

use crate::{Song, SoundError};

/// How samples are stored in a WAV file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WavSample {
    /// 16-bit integers, rounded to nearest; what exceeds ±1 is clipped.
    Int16,
    /// 32-bit floats, exact.
    Float32,
}

/// A stereo WAV file in memory; as [`write_wav`].
///
/// # Errors
/// Bugs only: memory takes all that is written.
pub fn wav_bytes(song: &Song, sample: WavSample) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    write_to(&mut bytes, song, sample)?;
    Ok(bytes)
}

/// Writes a stereo WAV file, whole or not at all; of more than 4 GiB, which WAV cannot hold, as RF64. A
/// [`SongReader`](crate::SongReader) refuses those.
///
/// # Errors
/// The file cannot be written.
pub fn write_wav(path: &Path, song: &Song, sample: WavSample) -> Result<(), SoundError> {
    chladni_task::write_atomic_with(path, |file| write_to(file, song, sample))
        .map_err(|source| SoundError::Write { path: path.to_owned(), source })
}

fn write_to(out: &mut impl Write, song: &Song, sample: WavSample) -> io::Result<()> {
    write_header(out, song.rate_hz, song.frames() as u64, sample)?;
    for (&left, &right) in song.left.iter().zip(&song.right) {
        for value in [left, right] {
            match sample {
                // The decoder's full scale is 32768: with the same scale, reading the file back gives the
                // same bits.
                WavSample::Int16 => {
                    out.write_all(&((value * 32768.0).round() as i16).to_le_bytes())?;
                }
                WavSample::Float32 => out.write_all(&value.to_le_bytes())?,
            }
        }
    }
    Ok(())
}

/// All that stands before `frames` of sound. Sizes beyond 32 bits are those of a chunk `ds64` (EBU Tech 3306).
fn write_header(out: &mut impl Write, rate_hz: u32, frames: u64, sample: WavSample) -> io::Result<()> {
    let (format_tag, bytes_per_sample) = match sample {
        WavSample::Int16 => (1u16, 2u16),
        WavSample::Float32 => (3, 4),
    };
    let block = 2 * bytes_per_sample;
    let data_len = frames * u64::from(block);
    // All that follows it.
    let riff_len = u32::try_from(data_len + 36);
    if let Ok(riff_len) = riff_len {
        out.write_all(b"RIFF")?;
        out.write_all(&riff_len.to_le_bytes())?;
        out.write_all(b"WAVE")?;
    } else {
        out.write_all(b"RF64\xff\xff\xff\xffWAVEds64\x1c\0\0\0")?;
        for size in [data_len + 72, data_len, frames] {
            out.write_all(&size.to_le_bytes())?;
        }
        // No other chunk is that large.
        out.write_all(&[0; 4])?;
    }
    out.write_all(b"fmt \x10\0\0\0")?;
    out.write_all(&format_tag.to_le_bytes())?;
    out.write_all(&2u16.to_le_bytes())?;
    out.write_all(&rate_hz.to_le_bytes())?;
    out.write_all(&rate_hz.saturating_mul(u32::from(block)).to_le_bytes())?;
    out.write_all(&block.to_le_bytes())?;
    out.write_all(&(8 * bytes_per_sample).to_le_bytes())?;
    out.write_all(b"data")?;
    out.write_all(&riff_len.map_or(u32::MAX, |len| len - 36).to_le_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sound_of_more_than_4_gib_has_sizes_of_64_bits() {
        let header = |frames: u64| {
            let mut header = Vec::new();
            write_header(&mut header, 48_000, frames, WavSample::Int16).unwrap();
            header
        };
        // The longest that 32 bits can hold, and one frame more.
        let most = u64::from(u32::MAX - 36) / 4;
        let (last, first) = (header(most), header(most + 1));
        assert_eq!((last.len(), &last[..4], &first[..4]), (44, &b"RIFF"[..], &b"RF64"[..]));
        let size = |at: usize| u64::from(u32::from_le_bytes(last[at..at + 4].try_into().unwrap()));
        assert_eq!((size(4) + 8, size(40)), (44 + 4 * most, 4 * most));
        let size = |at: usize| u64::from_le_bytes(first[at..at + 8].try_into().unwrap());
        assert_eq!(size(20) + 8, first.len() as u64 + size(28));
        assert_eq!((size(28), size(36)), (4 * (most + 1), most + 1));
        // The same format, and a size that says that it is elsewhere.
        assert_eq!(first[48..76], last[12..40]);
        assert_eq!([&first[4..8], &first[76..]], [&[0xff_u8; 4][..]; 2]);
    }
}
