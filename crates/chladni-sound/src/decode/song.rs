//! A whole song in memory.

use std::path::Path;

use chladni_task::{Cancelled, Task};

use super::{SongReader, StereoResampler};
use crate::SoundError;

/// A stereo song in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Song {
    /// Frames per second.
    pub rate_hz: u32,
    /// Left channel, full scale ±1.
    pub left: Vec<f32>,
    /// Right channel, as long as the left.
    pub right: Vec<f32>,
}

/// Which part of a song to read, at which rate, and with how much memory.
#[derive(Clone, Debug, PartialEq)]
pub struct SongOptions {
    /// Where to begin, in seconds.
    pub start_secs: f64,
    /// How much to read at most, in seconds; `None` for all.
    pub duration_secs: Option<f64>,
    /// The rate wanted; `None` keeps the file's own.
    pub rate_hz: Option<u32>,
    /// The size of the samples in bytes above which reading fails with [`SoundError::TooLong`].
    pub max_bytes: usize,
}

impl Default for SongOptions {
    /// The whole song at its own rate, in at most 1 GiB (50 minutes at 44.1 kHz).
    fn default() -> Self {
        Self { start_secs: 0.0, duration_secs: None, rate_hz: None, max_bytes: 1 << 30 }
    }
}

impl Song {
    /// Reads a whole file at its own rate.
    ///
    /// # Errors
    /// Those of [`SongReader::open`] and [`Song::read`].
    pub fn open(path: &Path) -> Result<Self, SoundError> {
        Self::read(&mut SongReader::open(path)?, &SongOptions::default(), &Task::new())
    }

    /// Reads the part given by `options` from `reader`; afterwards [`SongReader::damage`] reports which parts were
    /// missing in the file.
    ///
    /// # Errors
    /// A part outside the song or shorter than a frame ([`SoundError::Setting`]), a song that needs more than the memory
    /// allowed, a damaged file, or a cancelled task.
    pub fn read(reader: &mut SongReader, options: &SongOptions, task: &Task) -> Result<Self, SoundError> {
        let positive = |secs: f64| secs.is_finite() && secs >= 0.0;
        if !positive(options.start_secs) || options.duration_secs.is_some_and(|d| !positive(d)) {
            return Err(SoundError::Setting {
                what: "start and duration must be finite and not negative".into(),
            });
        }
        let from_hz = f64::from(reader.rate_hz());
        let rate_hz = options.rate_hz.unwrap_or(reader.rate_hz());
        let mut resampler = StereoResampler::new(reader.rate_hz(), rate_hz)?;
        if options.start_secs > 0.0 {
            reader.seek((options.start_secs * from_hz).round() as u64)?;
        }
        let wanted = options.duration_secs.map_or(u64::MAX, |d| (d * from_hz).round() as u64);
        let declared = reader.total_frames().unwrap_or(0).min(wanted);
        let stage = task.stage("decoding", declared);
        let max_frames = options.max_bytes / 8;
        let mut song = Self { rate_hz, ..Self::default() };
        let mut taken = 0u64;
        let mut stereo = Vec::new();
        while taken < wanted {
            task.check()?;
            let Some(block) = reader.next_block()? else { break };
            let frames = ((block.len() / 2) as u64).min(wanted - taken);
            stereo.clear();
            resampler.process(&block[..2 * frames as usize], &mut stereo)?;
            taken += frames;
            stage.advance(frames);
            song.append(&stereo);
            if song.frames() > max_frames {
                return Err(SoundError::TooLong {
                    name: reader.name().to_owned(),
                    limit_secs: max_frames as f64 / f64::from(rate_hz),
                });
            }
        }
        stereo.clear();
        resampler.finish(&mut stereo)?;
        song.append(&stereo);
        if song.frames() == 0 {
            return Err(nothing_read(reader.name(), options, wanted));
        }
        Ok(song)
    }

    /// Number of stereo frames.
    pub fn frames(&self) -> usize {
        self.left.len().min(self.right.len())
    }

    /// Length in seconds; 0 if the rate is 0.
    pub fn duration_secs(&self) -> f64 {
        if self.rate_hz == 0 { 0.0 } else { self.frames() as f64 / f64::from(self.rate_hz) }
    }

    /// Copies the `left.len()` frames that end just before frame `end` into `left` and `right`, with silence
    /// outside the song.
    pub fn window_ending_at(&self, end: i64, left: &mut [f32], right: &mut [f32]) {
        let start = end - left.len() as i64;
        for (channel, window) in [(&self.left, left), (&self.right, right)] {
            for (i, sample) in window.iter_mut().enumerate() {
                let at = usize::try_from(start + i as i64).ok();
                *sample = at.and_then(|at| channel.get(at)).copied().unwrap_or(0.0);
            }
        }
    }

    /// Gives all of it to `hear`, `block` frames at a time; `task` is told how far that is and may end it.
    pub(crate) fn in_blocks(
        &self,
        block: usize,
        stage: &str,
        task: &Task,
        mut hear: impl FnMut(&[f32], &[f32]),
    ) -> Result<(), Cancelled> {
        let stage = task.stage(stage, self.frames() as u64);
        for (left, right) in self.left.chunks(block).zip(self.right.chunks(block)) {
            task.check()?;
            hear(left, right);
            stage.advance(left.len() as u64);
        }
        Ok(())
    }

    /// As much silence as completes the windows of what hears the end of the song `secs` later.
    pub(crate) fn silence_after(&self, secs: f64) -> Vec<f32> {
        vec![0.0; (secs * f64::from(self.rate_hz)) as usize + 1]
    }

    fn append(&mut self, stereo: &[f32]) {
        self.left.extend(stereo.iter().step_by(2));
        self.right.extend(stereo.iter().skip(1).step_by(2));
    }
}

/// Why nothing was read where `wanted` frames were asked for.
fn nothing_read(name: &str, options: &SongOptions, wanted: u64) -> SoundError {
    let SongOptions { start_secs, duration_secs, .. } = *options;
    if wanted == 0 {
        let secs = duration_secs.unwrap_or(0.0);
        SoundError::Setting {
            what: format!("{name}: a duration of {secs} s holds no sample; give a longer one"),
        }
    } else if start_secs > 0.0 {
        SoundError::Setting {
            what: format!("{name}: the start at {start_secs} s lies beyond the end; give an earlier one"),
        }
    } else {
        SoundError::Empty { name: name.to_owned() }
    }
}
