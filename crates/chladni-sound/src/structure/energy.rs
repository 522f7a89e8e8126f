//! Energy of the music: its loudness, combined with how many onsets it has.

use super::frame::{FRAME_RATE_HZ, Frame};
use crate::{ONSET_RATE_HZ, Onset};

/// Values of the energy curve per second.
pub const ENERGY_RATE_HZ: f64 = 2.0;
/// Standard deviation of the Gaussian that smooths the curve, in seconds.
const SMOOTH_SECS: f64 = 1.5;
/// Below the loud parts by this many decibels, the loudness counts as 0.
const RANGE_DB: f32 = 24.0;
/// The weight of loudness; the rest is that of activity (onsets).
const LOUDNESS: f32 = 0.65;
/// The quantile of the song's values that counts as full energy.
const LOUD: f64 = 0.95;
/// Below the loud parts by this many decibels, the sound counts as silence.
const SILENT_DB: f32 = 50.0;
/// Mean square below which the sound counts as silence, however soft the loud parts are (−100 dB).
const SILENCE: f32 = 1e-10;

/// The energy curve of a whole song, each value in [0, 1].
pub(super) fn energy(frames: &[Frame], onsets: &[Onset]) -> Vec<f32> {
    let secs = frames.len() as f64 / FRAME_RATE_HZ;
    let powers: Vec<f32> = frames.iter().map(|frame| frame.power).collect();
    let strokes: Vec<f32> = onsets.iter().map(|onset| onset.all).collect();
    let times: Vec<f64> =
        (0..(secs * ENERGY_RATE_HZ).ceil() as usize).map(|i| i as f64 / ENERGY_RATE_HZ).collect();
    let power: Vec<f32> = times.iter().map(|&at| smooth(&powers, FRAME_RATE_HZ, at)).collect();
    let activity: Vec<f32> = times.iter().map(|&at| smooth(&strokes, ONSET_RATE_HZ, at)).collect();
    let (loud, busy) = (high(&power), high(&activity));
    power.iter().zip(&activity).map(|(&power, &activity)| mix(power, loud, activity, busy)).collect()
}

/// The energy of a moment, relative to what counts as loud and as busy.
pub(super) fn mix(power: f32, loud: f32, activity: f32, busy: f32) -> f32 {
    let below_db = 10.0 * (loud / power).max(1e-6).log10();
    if power < SILENCE || below_db > SILENT_DB {
        return 0.0;
    }
    let loudness = (1.0 - below_db / RANGE_DB).clamp(0.0, 1.0);
    let activity = if busy > 0.0 { (activity / busy).clamp(0.0, 1.0) } else { 0.0 };
    LOUDNESS * loudness + (1.0 - LOUDNESS) * activity
}

/// The mean of the energy curve between two times.
pub(super) fn between(energy: &[f32], from_secs: f64, to_secs: f64) -> f32 {
    let at = |secs: f64| ((secs * ENERGY_RATE_HZ).round().max(0.0) as usize).min(energy.len());
    let (from, to) = (at(from_secs), at(to_secs).max(at(from_secs) + 1).min(energy.len()));
    let part = energy.get(from..to).unwrap_or_default();
    part.iter().sum::<f32>() / part.len().max(1) as f32
}

fn smooth(values: &[f32], rate_hz: f64, at_secs: f64) -> f32 {
    let near = |secs: f64| ((secs * rate_hz).round().max(0.0) as usize).min(values.len());
    let (mut sum, mut weights) = (0.0, 0.0);
    let from = near(at_secs - 2.5 * SMOOTH_SECS);
    for (i, value) in (from..).zip(&values[from..near(at_secs + 2.5 * SMOOTH_SECS).max(from)]) {
        let off = (i as f64 / rate_hz - at_secs) / SMOOTH_SECS;
        let weight = (-0.5 * off * off).exp();
        sum += weight * f64::from(*value);
        weights += weight;
    }
    if weights > 0.0 { (sum / weights) as f32 } else { 0.0 }
}

fn high(values: &[f32]) -> f32 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f32::total_cmp);
    sorted.get((LOUD * sorted.len() as f64) as usize).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quiet_part_has_less_and_silence_has_none() {
        let part = |power: f32, secs: usize| vec![Frame { power, ..Frame::default() }; 20 * secs];
        let powers = [0.1, 0.001, 0.0];
        let [frames, soft] =
            [1.0, 1e-4].map(|gain: f32| powers.map(|power: f32| part(gain * power, 20)).concat());
        let beat = |i: usize, strength: f32| Onset {
            all: if i.is_multiple_of(50) { strength } else { 0.0 },
            bass: 0.0,
        };
        let onsets: Vec<Onset> = (0..6000).map(|i| beat(i, [1.0, 0.3, 0.0][(i / 2000).min(2)])).collect();
        let (energy, of_soft) = (energy(&frames, &onsets), energy(&soft, &onsets));
        assert!(energy.iter().zip(&of_soft).all(|(a, b)| (a - b).abs() < 1e-3), "{energy:?} {of_soft:?}");
        assert_eq!(energy.len(), 120);
        assert!(energy.iter().all(|e| (0.0..=1.0).contains(e)));
        let [loud, quiet, none] =
            [(5.0, 15.0), (25.0, 35.0), (50.0, 58.0)].map(|(a, b)| between(&energy, a, b));
        assert!(loud > 0.9 && (0.1..0.5).contains(&quiet) && none == 0.0, "{loud} {quiet} {none}");
    }
}
