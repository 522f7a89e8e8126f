//! The song that is being decoded.

use crate::{SongReader, SoundError, StereoResampler};

/// A song being written into the ring.
pub(super) struct Decoding {
    pub(super) reader: SongReader,
    resampler: StereoResampler,
    /// Interleaved samples at the device's rate, and how many of them are in the ring.
    pub(super) ready: Vec<f32>,
    pub(super) used: usize,
    ended: bool,
}

impl Decoding {
    pub(super) fn open(path: &std::path::Path, secs: f64, rate_hz: u32) -> Result<Self, SoundError> {
        let mut reader = SongReader::open(path)?;
        let resampler = StereoResampler::new(reader.rate_hz(), rate_hz)?;
        if secs > 0.0 {
            reader.seek((secs * f64::from(reader.rate_hz())).round() as u64)?;
        }
        Ok(Self { reader, resampler, ready: Vec::new(), used: 0, ended: false })
    }

    /// Makes sure that some frames are ready; false at the end of the song.
    pub(super) fn refill(&mut self) -> Result<bool, SoundError> {
        while self.used >= self.ready.len() {
            self.ready.clear();
            self.used = 0;
            if self.ended {
                return Ok(false);
            }
            match self.reader.next_block()? {
                Some(block) => self.resampler.process(block, &mut self.ready)?,
                None => {
                    self.ended = true;
                    self.resampler.finish(&mut self.ready)?;
                }
            }
        }
        Ok(true)
    }
}
