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

/// A stereo WAV file in memory.
///
/// # Errors
/// The file would exceed the format's limit of 4 GiB.
pub fn wav_bytes(song: &Song, sample: WavSample) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    write_to(&mut bytes, song, sample)?;
    Ok(bytes)
}

/// Writes a stereo WAV file, whole or not at all.
///
/// # Errors
/// The file cannot be written, or would exceed the format's limit of 4 GiB.
pub fn write_wav(path: &Path, song: &Song, sample: WavSample) -> Result<(), SoundError> {
    chladni_task::write_atomic_with(path, |file| write_to(file, song, sample))
        .map_err(|source| SoundError::Write { path: path.to_owned(), source })
}

fn write_to(out: &mut impl Write, song: &Song, sample: WavSample) -> io::Result<()> {
    let (format_tag, bytes_per_sample) = match sample {
        WavSample::Int16 => (1u16, 2u16),
        WavSample::Float32 => (3, 4),
    };
    let block = 2 * bytes_per_sample;
    let data_len = (song.frames() as u64) * u64::from(block);
    let too_long = |_| io::Error::other("a WAV file holds at most 4 GiB");
    let data_len = u32::try_from(data_len).map_err(too_long)?;
    let riff_len =
        data_len.checked_add(36).ok_or_else(|| io::Error::other("a WAV file holds at most 4 GiB"))?;
    out.write_all(b"RIFF")?;
    out.write_all(&riff_len.to_le_bytes())?;
    out.write_all(b"WAVEfmt \x10\0\0\0")?;
    out.write_all(&format_tag.to_le_bytes())?;
    out.write_all(&2u16.to_le_bytes())?;
    out.write_all(&song.rate_hz.to_le_bytes())?;
    out.write_all(&(song.rate_hz.saturating_mul(u32::from(block))).to_le_bytes())?;
    out.write_all(&block.to_le_bytes())?;
    out.write_all(&(8 * bytes_per_sample).to_le_bytes())?;
    out.write_all(b"data")?;
    out.write_all(&data_len.to_le_bytes())?;
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
