//! Bars, sections and energy while listening, from past samples only.

use super::bars::BarPointer;
use super::beat_features::{BeatFeatures, cosine};
use super::energy;
use super::frame::{FRAME_RATE_HZ, Frame, FrameReader};
use crate::{ONSET_RATE_HZ, Onset, SoundError};

/// A bar that begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeardBar {
    /// When it begins, in seconds.
    pub at_secs: f64,
    /// Its likely number of beats.
    pub beats: u8,
    /// Energy in [0, 1], relative to the last minutes.
    pub energy: f32,
    /// Whether a new section begins with it.
    pub begins_section: bool,
}

/// Seconds of frames and onsets that are kept: longer than the slowest beat.
const KEPT_SECS: f64 = 4.0;
/// The number of recent bars that are compared with as many bars before them.
const COMPARED: usize = 4;
/// The smallest number of bars between two sections.
const SHORTEST: usize = 8;
/// A section begins if the recent bars are this much less similar to the bars before them than to each
/// other.
const NOVEL: f32 = 0.12;
/// The running maxima of loudness and activity decay to 1/e in this many beats.
const MEMORY_BEATS: f32 = 200.0;
/// Where nothing louder than this mean square was heard (−70 dB), there is only the noise of a room.
const NOISE: f32 = 1e-7;

/// Groups the beats that a [`BeatFollower`](crate::BeatFollower) announces into bars.
pub(crate) struct BarFollower {
    reader: FrameReader,
    frames: Vec<Frame>,
    onsets: Vec<Onset>,
    /// How many frames and onsets have been dropped from the front.
    gone: [usize; 2],
    pointer: BarPointer,
    last_beat_secs: Option<f64>,
    /// The beats of this bar, then the means of the bars before it, newest last.
    beats: Vec<BeatFeatures>,
    bars: Vec<Vec<f32>>,
    since_section: usize,
    loud: f32,
    busy: f32,
    energy: f32,
}

impl BarFollower {
    /// A follower for samples at `rate_hz`.
    pub fn new(rate_hz: u32) -> Result<Self, SoundError> {
        Ok(Self {
            reader: FrameReader::new(rate_hz)?,
            frames: Vec::new(),
            onsets: Vec::new(),
            gone: [0; 2],
            pointer: BarPointer::default(),
            last_beat_secs: None,
            beats: Vec::new(),
            bars: Vec::new(),
            since_section: 0,
            loud: 0.0,
            busy: 0.0,
            energy: 0.0,
        })
    }

    /// Takes the next samples that were heard, and the onsets found in them.
    pub(crate) fn push(&mut self, left: &[f32], right: &[f32], onsets: &[Onset]) {
        self.reader.push(left, right, &mut self.frames);
        self.onsets.extend_from_slice(onsets);
        let kept = (KEPT_SECS * FRAME_RATE_HZ) as usize;
        if self.frames.len() > 2 * kept {
            let frames = self.frames.len() - kept;
            // Onsets come sooner than frames: those from the first frame on that is kept stay.
            let from_secs = (self.gone[0] + frames) as f64 / FRAME_RATE_HZ;
            let before = ((from_secs * ONSET_RATE_HZ).round() as usize).saturating_sub(self.gone[1]);
            let onsets = before.min(self.onsets.len());
            self.frames.drain(..frames);
            self.onsets.drain(..onsets);
            self.gone = [self.gone[0] + frames, self.gone[1] + onsets];
        }
    }

    /// Takes a beat that begins now. Returns the bar that begins with it, if one does.
    pub(crate) fn beat(&mut self, at_secs: f64) -> Option<HeardBar> {
        let begin_secs = self.last_beat_secs.replace(at_secs)?;
        let from_secs = self.gone[0] as f64 / FRAME_RATE_HZ;
        // Both are counted from the first frame that is kept; onsets have the finer clock of the two.
        let skipped = (from_secs * ONSET_RATE_HZ).round() as usize;
        let onsets = self.onsets.get(skipped.saturating_sub(self.gone[1])..).unwrap_or_default();
        let ended = BeatFeatures::between(begin_secs - from_secs, at_secs - from_secs, &self.frames, onsets);
        self.measure(&ended);
        self.beats.push(ended.clone());
        let beats = self.pointer.beat(ended)?;
        let bar = std::mem::take(&mut self.beats);
        self.bars.push(mean(&bar));
        if self.bars.len() > 2 * COMPARED {
            self.bars.remove(0);
        }
        self.since_section += 1;
        let begins_section = self.since_section >= SHORTEST && self.is_another();
        if begins_section {
            self.since_section = 0;
        }
        Some(HeardBar { at_secs, beats: beats as u8, energy: self.energy, begins_section })
    }

    fn measure(&mut self, beat: &BeatFeatures) {
        let activity = beat.rhythm[0].iter().sum::<f32>();
        let keep = (-1.0 / MEMORY_BEATS).exp();
        self.loud = (self.loud * keep).max(beat.power);
        self.busy = (self.busy * keep).max(activity);
        let is_music = self.loud > NOISE;
        let now = if is_music { energy::mix(beat.power, self.loud, activity, self.busy) } else { 0.0 };
        self.energy += 0.25 * (now - self.energy);
    }

    /// Whether the recent bars differ from those before them.
    fn is_another(&self) -> bool {
        if self.bars.len() < 2 * COMPARED {
            return false;
        }
        let (before, after) = self.bars.split_at(COMPARED);
        let alike = |a: &[Vec<f32>], b: &[Vec<f32>]| {
            let pairs = a.iter().flat_map(|a| b.iter().map(move |b| cosine(a, b)));
            pairs.sum::<f32>() / (a.len() * b.len()) as f32
        };
        0.5 * (alike(before, before) + alike(after, after)) - alike(before, after) > NOVEL
    }
}

fn mean(beats: &[BeatFeatures]) -> Vec<f32> {
    let values = |beat: &BeatFeatures| -> Vec<f32> {
        // A tenth of the powers' natural logarithms, which gives them about the weight of notes and onsets.
        let octaves = beat.octaves.iter().map(|power| 0.1 * (power + 8.0).max(0.0));
        beat.chroma
            .iter()
            .chain(&beat.bass)
            .copied()
            .chain(octaves)
            .chain(beat.rhythm.as_flattened().iter().copied())
            .collect()
    };
    let mut mean = vec![];
    for beat in beats {
        let values = values(beat);
        mean.resize(values.len(), 0.0);
        mean.iter_mut()
            .zip(values)
            .for_each(|(mean, value): (&mut f32, f32)| *mean += value / beats.len() as f32);
    }
    mean
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_onset_of_what_is_kept_is_dropped() {
        for rate_hz in [16_000, 44_100, 48_000] {
            let mut bars = BarFollower::new(rate_hz).unwrap();
            let block = vec![0.1; rate_hz as usize / 100];
            for _ in 0..3000 {
                bars.push(&block, &block, &[Onset::default()]);
                let from_secs = bars.gone[0] as f64 / FRAME_RATE_HZ;
                assert!(bars.gone[1] <= (from_secs * ONSET_RATE_HZ).round() as usize, "{rate_hz} Hz");
            }
            assert!(bars.gone[1] > 2000, "what is old goes");
        }
    }

    /// The energy after twenty strokes, one a second, of which the last ten are 20 dB softer.
    fn energy_of_strokes(loudest: f32) -> f32 {
        let mut bars = BarFollower::new(16_000).unwrap();
        let tone = |n: u16| if n < 160 { (0.4 * f32::from(n)).sin() } else { 0.0 };
        let onset = |n: u16| Onset { all: if n == 0 { 1.0 } else { 0.0 }, bass: 0.0 };
        let onsets: Vec<Onset> = (0..100).map(onset).collect();
        for second in 0..20 {
            let gain = if second < 10 { loudest } else { 0.1 * loudest };
            let beat: Vec<f32> = (0..16_000).map(|n| gain * tone(n)).collect();
            bars.beat(f64::from(second));
            bars.push(&beat, &beat, &onsets);
        }
        bars.energy
    }

    #[test]
    fn soft_parts_of_a_soft_master_have_energy_and_the_noise_of_a_room_has_none() {
        let [loud, soft, noise] = [0.5, 0.01, 0.001].map(energy_of_strokes);
        assert!(loud > 0.3 && (loud - soft).abs() < 0.01 && noise == 0.0, "{loud} {soft} {noise}");
    }

    #[test]
    fn a_short_stroke_on_each_beat_is_as_loud_as_it_is() {
        let mut bars = BarFollower::new(16_000).unwrap();
        // One beat a second: a tone of 10 ms, then silence.
        let tone = |n: u16| if n < 160 { 0.5 * (0.4 * f32::from(n)).sin() } else { 0.0 };
        let beat: Vec<f32> = (0..16_000).map(tone).collect();
        for second in 0..20 {
            bars.beat(f64::from(second));
            bars.push(&beat, &beat, &[Onset::default(); 100]);
        }
        // There are no onsets: loudness alone.
        assert!(bars.energy > 0.6, "{}", bars.energy);
    }
}
