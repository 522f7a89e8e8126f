//! The song that is being decoded.

use std::collections::VecDeque;

use super::tail::Tail;
use crate::history::Frame;
use crate::{SongReader, SoundError, StereoResampler};

/// A song being written into the ring.
pub(super) struct Decoding {
    pub(super) reader: SongReader,
    resampler: StereoResampler,
    /// At the device's rate, and not yet in the ring.
    ready: VecDeque<Frame>,
    /// The number of frames that were taken.
    taken: usize,
    block: Vec<f32>,
    /// Nothing more can be decoded, because of the error if there is one.
    ended: Option<Result<(), SoundError>>,
}

impl Decoding {
    pub(super) fn open(path: &std::path::Path, secs: f64, rate_hz: u32) -> Result<Self, SoundError> {
        let mut reader = SongReader::open(path)?;
        let resampler = StereoResampler::new(reader.rate_hz(), rate_hz)?;
        if secs > 0.0 {
            reader.seek((secs * f64::from(reader.rate_hz())).round() as u64)?;
        }
        let (ready, block) = (VecDeque::new(), Vec::new());
        Ok(Self { reader, resampler, ready, taken: 0, block, ended: None })
    }

    /// Lets the song follow another one, whose last frames lie in its resampler, without a gap; returns how many of its own
    /// frames are theirs. Where both have one rate they are resampled as one sound: no edge is heard where a sound was cut.
    pub(super) fn follow(&mut self, mut before: StereoResampler) -> Result<u64, SoundError> {
        let frames = before.pending_frames();
        if before.from_hz() == self.reader.rate_hz() {
            self.resampler = before;
        } else {
            before.finish(&mut self.block)?;
            self.ready.extend(self.block.as_chunks().0);
        }
        Ok(frames)
    }

    /// The next frame, as long as `kept` frames lie ready behind it: those may be the last ones, under which
    /// another song is to begin. Less is kept of the beginning, so that it does not wait for them, and no song
    /// is more than half crossfade. Where nothing is kept, the last frames stay in the resampler.
    pub(super) fn next(&mut self, kept: usize) -> Option<Frame> {
        let fades = kept > 0;
        let kept = kept.min(self.taken);
        while self.ready.len() <= kept && self.ended.is_none() {
            self.block.clear();
            let decoded = match self.reader.next_block() {
                Ok(Some(block)) => self.resampler.process(block, &mut self.block).map(|()| false),
                Ok(None) if fades => self.resampler.finish(&mut self.block).map(|()| true),
                Ok(None) => Ok(true),
                Err(error) => Err(error),
            };
            self.ready.extend(self.block.as_chunks().0);
            match decoded {
                Ok(false) => {}
                Ok(true) => self.ended = Some(Ok(())),
                Err(error) => self.ended = Some(Err(error)),
            }
        }
        if self.ready.len() <= kept {
            return None;
        }
        self.taken += 1;
        self.ready.pop_front()
    }

    /// The remaining frames once [`next`](Self::next) returns `None`: those under the next song and those before it; and the
    /// error that ended decoding early, if any.
    pub(super) fn rest(self) -> (Tail, StereoResampler, Result<(), SoundError>) {
        (Tail::of(self.ready.into_iter()), self.resampler, self.ended.unwrap_or(Ok(())))
    }
}
