//! A short stereo piece composed in code, whose beats are known exactly.
//!
//! Two voices call and answer, one on the left and one on the right; drums, bass and chords are in the
//! middle. The samples, the demo and many tests use it.

mod mix;
mod voices;

use crate::Song;
use mix::Mix;
use voices::Noise;

/// Beats per minute of [`sample_tune`].
pub const TUNE_BPM: f64 = 112.0;
/// Frames per second of [`sample_tune`].
pub const TUNE_RATE_HZ: u32 = 44_100;

const BARS: usize = 8;
const BEATS_PER_BAR: usize = 4;
/// Silence before the first beat.
const LEAD_IN_SECS: f64 = 0.25;
/// How long the last notes ring.
const TAIL_SECS: f64 = 1.2;

/// MIDI notes of the chord of each bar: A minor, F, C, G, twice.
const CHORDS: [[u8; 3]; 4] = [[57, 60, 64], [53, 57, 60], [55, 60, 64], [55, 59, 62]];
const ROOTS: [u8; 4] = [33, 29, 36, 31];
/// (beat within two bars, MIDI note, length in beats): the calls of the left voice …
const CALLS: [&[(f64, u8, f64)]; 4] = [
    &[(0.0, 76, 0.5), (0.5, 74, 0.5), (1.0, 72, 0.75), (2.0, 69, 0.5), (2.5, 72, 0.5), (3.0, 74, 1.0)],
    &[(0.0, 76, 0.5), (0.75, 79, 0.5), (1.5, 76, 0.5), (2.0, 74, 0.5), (3.0, 72, 0.5), (3.5, 74, 0.5)],
    &[(0.0, 81, 0.5), (0.5, 79, 0.5), (1.0, 76, 0.75), (2.0, 72, 0.5), (2.5, 74, 0.5), (3.0, 76, 1.0)],
    &[(0.0, 79, 0.5), (0.75, 81, 0.5), (1.5, 79, 0.5), (2.0, 76, 1.0), (3.0, 74, 0.5), (3.5, 72, 0.5)],
];
/// … and the answers of the right voice.
const ANSWERS: [&[(f64, u8, f64)]; 4] = [
    &[(0.0, 84, 1.0), (1.5, 81, 0.5), (2.0, 77, 1.0), (3.0, 81, 0.5), (3.5, 84, 0.5)],
    &[(0.0, 83, 1.0), (1.0, 86, 0.5), (2.0, 79, 0.75), (3.0, 83, 1.0)],
    &[(0.0, 84, 0.5), (0.5, 88, 0.5), (1.5, 84, 0.5), (2.0, 81, 1.0), (3.5, 77, 0.5)],
    &[(0.0, 86, 1.0), (1.5, 83, 0.5), (2.0, 79, 1.5)],
];

/// The tune: 8 bars of 4/4 at [`TUNE_BPM`], about 18.6 s at [`TUNE_RATE_HZ`], peaks below 1.
/// It is the same on every call.
pub fn sample_tune() -> Song {
    let mut mix = Mix::new(TUNE_RATE_HZ, beat_secs(BARS * BEATS_PER_BAR) + TAIL_SECS);
    let mut noise = Noise::new(1787);
    for bar in 0..BARS {
        drums(&mut mix, &mut noise, bar);
        bass(&mut mix, bar);
        chord(&mut mix, bar);
        // The voices begin once the rhythm is established: calls in odd bars, answers in even ones.
        if bar.is_multiple_of(2) {
            melody(&mut mix, bar, CALLS[bar / 2], -0.85, voices::pluck);
        } else {
            melody(&mut mix, bar, ANSWERS[bar / 2], 0.85, voices::bell);
        }
    }
    mix.finish()
}

/// Times of the beats of [`sample_tune`], in seconds.
pub fn sample_tune_beats_secs() -> Vec<f64> {
    (0..BARS * BEATS_PER_BAR).map(beat_secs).collect()
}

fn beat_secs(beat: usize) -> f64 {
    LEAD_IN_SECS + beat as f64 * 60.0 / TUNE_BPM
}

/// Time of a place within a bar, in beats.
fn place_secs(bar: usize, beat: f64) -> f64 {
    beat_secs(bar * BEATS_PER_BAR) + beat * 60.0 / TUNE_BPM
}

fn drums(mix: &mut Mix, noise: &mut Noise, bar: usize) {
    for beat in 0..BEATS_PER_BAR {
        let at = place_secs(bar, beat as f64);
        if beat.is_multiple_of(2) || bar % 4 == 3 {
            mix.add(at, 0.5, 0.0, 0.85, voices::kick);
        }
        if !beat.is_multiple_of(2) {
            mix.add(at, 0.35, 0.0, 0.5, |t| voices::snare(t, noise.next()));
        }
        let mut before = 0.0;
        for (half, gain, decay_secs) in [(0.0, 0.12, 0.03), (0.5, 0.16, 0.06)] {
            let at = place_secs(bar, beat as f64 + half);
            mix.add(at, 0.3, 0.0, gain, |t| {
                // The difference of successive samples of noise leaves only its treble.
                let now = noise.next();
                let hiss = now - std::mem::replace(&mut before, now);
                hiss * (-t / decay_secs).exp()
            });
        }
    }
    if bar.is_multiple_of(2) {
        mix.add(place_secs(bar, 2.5), 0.5, 0.0, 0.6, voices::kick);
    }
}

fn bass(mix: &mut Mix, bar: usize) {
    let root = ROOTS[bar % 4];
    for (beat, up, beats) in [(0.0, 0, 0.9), (1.0, 12, 0.4), (1.5, 0, 0.5), (2.5, 0, 0.5), (3.0, 7, 0.9)] {
        let hz = note_hz(root + up);
        let secs = beats * 60.0 / TUNE_BPM;
        mix.add(place_secs(bar, beat), secs + 0.05, 0.0, 0.42, |t| voices::bass(t, hz, secs as f32));
    }
}

fn chord(mix: &mut Mix, bar: usize) {
    let secs = BEATS_PER_BAR as f64 * 60.0 / TUNE_BPM;
    for note in CHORDS[bar % 4] {
        let hz = note_hz(note);
        mix.add(place_secs(bar, 0.0), secs + 0.4, 0.0, 0.055, |t| voices::pad(t, hz, secs as f32));
    }
}

fn melody(mix: &mut Mix, bar: usize, notes: &[(f64, u8, f64)], pan: f32, voice: fn(f32, f32, f32) -> f32) {
    for &(beat, note, beats) in notes {
        let hz = note_hz(note);
        let secs = beats * 60.0 / TUNE_BPM;
        let rate_hz = TUNE_RATE_HZ as f32;
        let frames = ((secs + 0.6) * f64::from(TUNE_RATE_HZ)) as usize;
        // Ten partials are computed once and used three times: for the note, its echo three quarters of a
        // beat later on the same side, and the echo's echo.
        let note: Vec<f32> = (0..frames).map(|n| voice(n as f32 / rate_hz, hz, secs as f32)).collect();
        for (delay, gain) in [(0.0, 0.34), (0.75, 0.11), (1.5, 0.04)] {
            mix.add(place_secs(bar, beat + delay), secs + 0.6, pan, gain, |t| {
                note.get((t * rate_hz).round() as usize).copied().unwrap_or(0.0)
            });
        }
    }
}

/// Equal temperament, A4 = 440 Hz.
fn note_hz(midi: u8) -> f32 {
    440.0 * ((f32::from(midi) - 69.0) / 12.0).exp2()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rms(samples: impl Iterator<Item = f32>) -> f32 {
        let (sum, count) = samples.fold((0.0, 0.0), |(s, n), x| (s + x * x, n + 1.0f32));
        (sum / count).sqrt()
    }

    #[test]
    fn it_is_the_same_each_time_and_does_not_clip() {
        let tune = sample_tune();
        assert_eq!(tune, sample_tune());
        assert!((12.0..20.0).contains(&tune.duration_secs()));
        let peak = tune.left.iter().chain(&tune.right).fold(0.0f32, |a, x| a.max(x.abs()));
        assert!((0.5..0.99).contains(&peak), "{peak}");
        let ends = [tune.left[0], tune.right[0], tune.left[tune.frames() - 1]];
        assert!(ends.iter().all(|x| x.abs() < 1e-3));
    }

    #[test]
    fn calls_are_on_the_left_and_answers_on_the_right() {
        let tune = sample_tune();
        let side = |bar: usize| {
            let range = [bar, bar + 1].map(|b| (place_secs(b, 0.0) * f64::from(TUNE_RATE_HZ)) as usize);
            let (l, r) = (&tune.left[range[0]..range[1]], &tune.right[range[0]..range[1]]);
            rms(l.iter().copied()) / rms(r.iter().copied())
        };
        for bar in 0..BARS {
            let balance = side(bar);
            assert_eq!(balance > 1.0, bar.is_multiple_of(2), "bar {bar}: {balance}");
            assert!((balance.log2()).abs() > 0.1, "bar {bar}: {balance}");
        }
    }
}
