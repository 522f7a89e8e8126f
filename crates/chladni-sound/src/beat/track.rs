//! Beat tracking of a whole song.

use std::ops::Range;

use chladni_task::{Cancelled, Task};

use super::follow::BeatFollower;
use super::meter::{FASTEST_BPM, Meter, Normalizer, ring};
use crate::structure::{HeardBar, section_name, structure};
use crate::{Bar, ENERGY_RATE_HZ, ONSET_RATE_HZ, Onset, OnsetDetector, Section, Song, SoundError};

/// The beats of a song, its bars and sections, and its energy.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Beats {
    /// Beats per minute; 0 with fewer than two beats. Which octave (half, double) is right is a matter of taste:
    /// see [`other_octaves_bpm`](Self::other_octaves_bpm).
    pub tempo_bpm: f64,
    /// Times of the beats, ascending.
    pub beats_secs: Vec<f64>,
    /// How much of the onset strength lies on the beats, from 0 (none) to 1 (all); while listening, the mean confidence at
    /// the beats.
    pub confidence: f64,
    /// Half and twice the tempo, which other listeners may tap.
    pub other_octaves_bpm: [f64; 2],
    /// The bars, ascending; each begins with a beat.
    pub bars: Vec<Bar>,
    /// The sections, ascending; each begins with a bar.
    pub sections: Vec<Section>,
    /// Energy in [0, 1]: [`ENERGY_RATE_HZ`] values per second, from the beginning of the song.
    pub energy: Vec<f32>,
}

impl Beats {
    fn new(beats_secs: Vec<f64>, confidence: f64) -> Self {
        let tempo_bpm = tempo_of(&beats_secs);
        let other_octaves_bpm = [tempo_bpm / 2.0, tempo_bpm * 2.0];
        Self { tempo_bpm, beats_secs, confidence, other_octaves_bpm, ..Self::default() }
    }

    /// Adds the bars that were found while listening.
    fn with_heard(self, bars: &[HeardBar], secs: f64) -> Self {
        let sections = bars.iter().enumerate().filter(|(i, bar)| *i == 0 || bar.begins_section);
        let named = |(i, (_, bar)): (usize, (usize, &HeardBar))| Section {
            at_secs: bar.at_secs,
            // While listening, sections are not compared with earlier ones: each gets the next letter.
            name: section_name(i),
            energy: bar.energy,
        };
        let energy_at = |secs: f64| {
            let begun = bars.partition_point(|bar| bar.at_secs <= secs);
            begun.checked_sub(1).map_or(0.0, |bar| bars[bar].energy)
        };
        Self {
            sections: sections.enumerate().map(named).collect(),
            energy: (0..(secs * ENERGY_RATE_HZ).ceil() as usize)
                .map(|i| energy_at(i as f64 / ENERGY_RATE_HZ))
                .collect(),
            bars: bars.iter().map(|bar| Bar { at_secs: bar.at_secs, beats: bar.beats }).collect(),
            ..self
        }
    }
}

/// The most probable beats, given the whole song: the best path of the bar pointer (Viterbi).
///
/// # Errors
/// A rate outside the supported range, or a cancelled task.
pub fn track_beats(song: &Song, task: &Task) -> Result<Beats, SoundError> {
    let onsets = onsets(song, task)?;
    let music = music(song, onsets.len());
    let heard = Normalizer::both_ways(&onsets[music.clone()]);
    let frames = best_path(&Meter::new(), &heard, task)?;
    let frames = at_the_pulse(within_the_music(&frames, &heard), &heard);
    let strengths = frames.iter().map(|&f| peak_near(&heard, f));
    let confidence = agreement(strengths, &heard);
    let beats_secs: Vec<f64> =
        frames.iter().map(|&f| (music.start as f64 + refined(&heard, f)) / ONSET_RATE_HZ).collect();
    let structure = structure(song, &beats_secs, &onsets, task)?;
    let beats = Beats::new(beats_secs, confidence);
    Ok(Beats { bars: structure.bars, sections: structure.sections, energy: structure.energy, ..beats })
}

/// The beats found without knowledge of the future: those that [`BeatFollower`] announces while it gets the
/// song in blocks of 10 ms.
///
/// # Errors
/// A rate outside the supported range, or a cancelled task.
pub fn track_beats_causally(song: &Song, task: &Task) -> Result<Beats, SoundError> {
    let mut follower = BeatFollower::new(song.rate_hz)?;
    let block = (song.rate_hz / 100) as usize;
    let (mut beats_secs, mut bars) = (Vec::new(), Vec::new());
    let mut confidences = 0.0;
    song.in_blocks(block, "following the beat", task, |left, right| {
        follower.push(left, right);
        if let Some(beat_secs) = follower.take_beat() {
            beats_secs.push(beat_secs);
            confidences += follower.moment().confidence;
        }
        bars.extend(follower.take_bar());
    })?;
    let confidence = confidences / beats_secs.len().max(1) as f64;
    Ok(Beats::new(beats_secs, confidence).with_heard(&bars, song.duration_secs()))
}

fn onsets(song: &Song, task: &Task) -> Result<Vec<Onset>, SoundError> {
    let mut detector = OnsetDetector::new(song.rate_hz)?;
    let mut onsets = Vec::new();
    song.in_blocks(1 << 16, "finding onsets", task, |left, right| detector.push(left, right, &mut onsets))?;
    let silence = song.silence_after(detector.latency_secs());
    detector.push(&silence, &silence, &mut onsets);
    Ok(onsets)
}

/// Sound below this share (−50 dB) of the peak that one frame in twenty exceeds is noise.
const NOISE: f32 = 3.2e-3;
/// How much noise or silence stays before the music and behind it.
const EDGE_SECS: f64 = 2.0;

/// The onset frames in which there is music, of all `frames`: beats would be found in the noise around it, and slow ones
/// would cost less in silence.
fn music(song: &Song, frames: usize) -> Range<usize> {
    let hop = f64::from(song.rate_hz) / ONSET_RATE_HZ;
    let peak = |frame: usize| {
        let of = |samples: &[f32]| {
            let begin = ((frame as f64 * hop) as usize).min(samples.len());
            let end = (((frame + 1) as f64 * hop) as usize).min(samples.len());
            samples[begin..end].iter().fold(0.0f32, |peak, x| peak.max(x.abs()))
        };
        of(&song.left).max(of(&song.right))
    };
    let peaks: Vec<f32> = (0..frames).map(peak).collect();
    let mut sorted = peaks.clone();
    sorted.sort_by(f32::total_cmp);
    let loud = sorted.get(frames * 19 / 20).copied().unwrap_or(0.0);
    let is_music = |peak: &f32| *peak > NOISE * loud;
    let edge = (EDGE_SECS * ONSET_RATE_HZ) as usize;
    match (peaks.iter().position(is_music), peaks.iter().rposition(is_music)) {
        (Some(first), Some(last)) => first.saturating_sub(edge)..(last + edge).min(frames),
        _ => 0..frames,
    }
}

/// The frames at which the most probable path through the meter begins a beat.
fn best_path(meter: &Meter, heard: &[f32], task: &Task) -> Result<Vec<usize>, Cancelled> {
    let stage = task.stage("tracking beats", heard.len() as u64);
    let count = meter.tempi.len();
    let mut score = vec![0.0f32; meter.expected.len()];
    let mut came_from = vec![0u16; heard.len() * count];
    let mut arriving = vec![0.0f32; count];
    for (t, &z) in heard.iter().enumerate() {
        if t % 1024 == 0 {
            task.check()?;
            stage.advance(1024);
        }
        let begin = |i: usize| meter.tempi[i].first + ring(0, t as u64, meter.tempi[i].period);
        // Paths at the last position of each tempo begin a beat now.
        for (i, value) in arriving.iter_mut().enumerate() {
            *value = score[begin(i)];
        }
        for i in 0..count {
            let mut best = (f32::MIN, 0);
            for (j, &value) in arriving.iter().enumerate() {
                let candidate = value + meter.change[j * count + i];
                if candidate > best.0 {
                    best = (candidate, j);
                }
            }
            score[begin(i)] = best.0;
            came_from[t * count + i] = best.1 as u16;
        }
        for tempo in &meter.tempi {
            let start = ring(0, t as u64, tempo.period);
            meter.expect(tempo, start, &mut score, |s, e| *s += z * e);
        }
    }
    Ok(walk_back(meter, &score, &came_from, heard.len()))
}

fn walk_back(meter: &Meter, score: &[f32], came_from: &[u16], frames: usize) -> Vec<usize> {
    let count = meter.tempi.len();
    let Some(last) = frames.checked_sub(1) else { return Vec::new() };
    let best =
        (0..count).flat_map(|i| (0..meter.tempi[i].period).map(move |place| (i, place))).max_by(|&a, &b| {
            let value = |(i, place): (usize, usize)| {
                score[meter.tempi[i].first + ring(place, last as u64, meter.tempi[i].period)]
            };
            value(a).total_cmp(&value(b))
        });
    let Some((mut tempo, place)) = best else { return Vec::new() };
    let mut beats = Vec::new();
    let mut at = last.checked_sub(place);
    while let Some(t) = at {
        beats.push(t);
        tempo = usize::from(came_from[t * count + tempo]);
        at = t.checked_sub(meter.tempi[tempo].period);
    }
    beats.reverse();
    beats
}

/// The largest value within ±50 ms of a frame.
fn peak_near(heard: &[f32], frame: usize) -> f32 {
    let range = frame.saturating_sub(5)..(frame + 6).min(heard.len());
    heard[range].iter().fold(0.0f32, |a, &b| a.max(b))
}

/// Removes beats before the first onset and after the last one: they are only extrapolated.
fn within_the_music<'a>(beats: &'a [usize], heard: &[f32]) -> &'a [usize] {
    let strengths: Vec<f32> = beats.iter().map(|&f| peak_near(heard, f)).collect();
    let mean = strengths.iter().sum::<f32>() / strengths.len().max(1) as f32;
    let strong = |s: &f32| *s > 0.25 * mean;
    match (strengths.iter().position(strong), strengths.iter().rposition(strong)) {
        (Some(first), Some(last)) => &beats[first..=last],
        _ => &[],
    }
}

/// If the pulses halfway between the beats have at least this share of the beats' strength, nothing groups
/// the pulses in pairs.
const UNGROUPED: f32 = 0.95;

/// The beats, or twice as many if the pulses between them are as strong.
fn at_the_pulse(beats: &[usize], heard: &[f32]) -> Vec<usize> {
    let between: Vec<usize> = beats.windows(2).map(|w| (w[0] + w[1]).div_ceil(2)).collect();
    let strength = |frames: &[usize]| frames.iter().map(|&f| peak_near(heard, f)).sum::<f32>();
    let fast = beats.len() > 1 && tempo_of_frames(beats) * 2.0 <= FASTEST_BPM;
    // There is no pulse after the last beat.
    if !fast || strength(&between) < UNGROUPED * strength(&beats[..between.len()]) {
        return beats.to_vec();
    }
    let pairs = beats.iter().zip(&between).flat_map(|(&beat, &between)| [beat, between]);
    pairs.chain(beats.last().copied()).collect()
}

fn tempo_of_frames(beats: &[usize]) -> f64 {
    tempo_of(&beats.iter().map(|&frame| frame as f64 / ONSET_RATE_HZ).collect::<Vec<_>>())
}

/// The mean strength at the beats, relative to the mean of equally many of the strongest peaks, scaled to
/// give 0 for random beats.
fn agreement(strengths: impl ExactSizeIterator<Item = f32>, heard: &[f32]) -> f64 {
    let count = strengths.len();
    if count < 2 {
        return 0.0;
    }
    let mean = strengths.sum::<f32>() / count as f32;
    let mut peaks: Vec<f32> =
        heard.windows(3).filter(|w| w[1] > 0.0 && w[1] >= w[0] && w[1] > w[2]).map(|w| w[1]).collect();
    peaks.sort_by(|a, b| b.total_cmp(a));
    peaks.truncate(count);
    let best = peaks.iter().sum::<f32>() / peaks.len().max(1) as f32;
    const CHANCE: f32 = 0.3;
    if best <= 0.0 { 0.0 } else { f64::from(((mean / best - CHANCE) / (1.0 - CHANCE)).clamp(0.0, 1.0)) }
}

/// The time of the onset near a beat, finer than a frame: the centroid of the strength above the mean.
fn refined(heard: &[f32], frame: usize) -> f64 {
    let (mut sum, mut moment) = (0.0, 0.0);
    for f in frame.saturating_sub(2)..(frame + 3).min(heard.len()) {
        let weight = f64::from(heard[f].max(0.0));
        sum += weight;
        moment += weight * f as f64;
    }
    if sum > 0.5 { moment / sum } else { frame as f64 }
}

/// The tempo of the straight line through the beats. If the tempo changes, the median gap selects a piece,
/// and the mean of the gaps near it is exact.
fn tempo_of(beats_secs: &[f64]) -> f64 {
    let mut gaps: Vec<f64> = beats_secs.windows(2).map(|w| w[1] - w[0]).collect();
    gaps.sort_by(f64::total_cmp);
    let Some(&median) = gaps.get(gaps.len() / 2) else { return 0.0 };
    let near: Vec<f64> = gaps.iter().copied().filter(|g| (g / median - 1.0).abs() < 0.1).collect();
    let mean = near.iter().sum::<f64>() / near.len().max(1) as f64;
    if mean > 0.0 { 60.0 / mean } else { 0.0 }
}
