//! Songs in many tempi and styles, made in code, whose beats are known exactly.

use chladni_sound::Song;
use std::f32::consts::TAU;

pub const RATE_HZ: u32 = 44_100;

/// A song, its name and its true beats.
pub struct Made {
    pub name: String,
    pub song: Song,
    pub beats_secs: Vec<f64>,
}

/// Tempo in beats per minute at a beat.
type Tempo = fn(f64, usize) -> f64;

/// (place in the bar in beats, instrument, loudness)
type Pattern = &'static [(f64, Instrument, f32)];

#[derive(Clone, Copy)]
enum Instrument {
    Kick,
    Snare,
    Hat,
    Ride,
    Click,
    Bass(u8),
    /// A chord whose notes swell for 60 ms.
    Strings(u8),
    Piano(u8),
}
use Instrument::*;

const ROCK: Pattern = &[
    (0.0, Kick, 0.9),
    (2.0, Kick, 0.8),
    (2.5, Kick, 0.6),
    (1.0, Snare, 0.7),
    (3.0, Snare, 0.7),
    (0.0, Hat, 0.3),
    (0.5, Hat, 0.2),
    (1.0, Hat, 0.3),
    (1.5, Hat, 0.2),
    (2.0, Hat, 0.3),
    (2.5, Hat, 0.2),
    (3.0, Hat, 0.3),
    (3.5, Hat, 0.2),
    (0.0, Bass(33), 0.5),
    (1.5, Bass(33), 0.4),
    (2.0, Bass(40), 0.5),
    (3.5, Bass(36), 0.4),
];
const HOUSE: Pattern = &[
    (0.0, Kick, 1.0),
    (1.0, Kick, 1.0),
    (2.0, Kick, 1.0),
    (3.0, Kick, 1.0),
    (1.0, Snare, 0.4),
    (3.0, Snare, 0.4),
    (0.5, Hat, 0.25),
    (1.5, Hat, 0.25),
    (2.5, Hat, 0.25),
    (3.5, Hat, 0.25),
    (0.5, Bass(33), 0.4),
    (1.5, Bass(33), 0.4),
    (2.5, Bass(36), 0.4),
    (3.5, Bass(31), 0.4),
];
const SWING: Pattern = &[
    (0.0, Ride, 0.4),
    (1.0, Ride, 0.5),
    (1.667, Ride, 0.3),
    (2.0, Ride, 0.4),
    (3.0, Ride, 0.5),
    (3.667, Ride, 0.3),
    (1.0, Hat, 0.4),
    (3.0, Hat, 0.4),
    (0.0, Bass(36), 0.6),
    (1.0, Bass(40), 0.6),
    (2.0, Bass(43), 0.6),
    (3.0, Bass(45), 0.6),
    (1.667, Piano(60), 0.3),
    (3.0, Piano(64), 0.2),
];
const SYNCOPATED: Pattern = &[
    (0.0, Kick, 0.9),
    (0.75, Kick, 0.6),
    (1.5, Kick, 0.8),
    (2.75, Kick, 0.6),
    (1.0, Snare, 0.7),
    (3.0, Snare, 0.7),
    (0.0, Hat, 0.2),
    (0.25, Hat, 0.1),
    (0.5, Hat, 0.2),
    (0.75, Hat, 0.1),
    (1.0, Hat, 0.2),
    (1.25, Hat, 0.1),
    (1.5, Hat, 0.2),
    (1.75, Hat, 0.1),
    (2.0, Hat, 0.2),
    (2.25, Hat, 0.1),
    (2.5, Hat, 0.2),
    (2.75, Hat, 0.1),
    (3.0, Hat, 0.2),
    (3.25, Hat, 0.1),
    (3.5, Hat, 0.2),
    (3.75, Hat, 0.1),
    (0.75, Bass(33), 0.5),
    (1.5, Bass(36), 0.5),
    (3.25, Bass(31), 0.5),
];
const WALTZ: Pattern = &[
    (0.0, Bass(36), 0.7),
    (1.0, Piano(60), 0.4),
    (2.0, Piano(60), 0.4),
    (0.0, Piano(72), 0.4),
    (1.5, Piano(74), 0.25),
    (2.0, Piano(76), 0.3),
];
const CHORALE: Pattern =
    &[(0.0, Strings(57), 0.5), (1.0, Strings(60), 0.5), (2.0, Strings(64), 0.5), (3.0, Strings(62), 0.5)];
const PIANO: Pattern = &[
    (0.0, Piano(48), 0.6),
    (0.0, Piano(64), 0.5),
    (0.5, Piano(67), 0.3),
    (1.0, Piano(72), 0.5),
    (1.5, Piano(67), 0.3),
    (2.0, Piano(45), 0.6),
    (2.0, Piano(64), 0.5),
    (2.5, Piano(69), 0.3),
    (3.0, Piano(72), 0.5),
    (3.5, Piano(69), 0.3),
];
const CLICKS: Pattern = &[(0.0, Click, 0.8), (1.0, Click, 0.8), (2.0, Click, 0.8), (3.0, Click, 0.8)];
const BREAKBEAT: Pattern = &[
    (0.0, Kick, 1.0),
    (2.5, Kick, 0.9),
    (1.0, Snare, 0.8),
    (3.0, Snare, 0.8),
    (0.0, Hat, 0.3),
    (0.5, Hat, 0.3),
    (1.0, Hat, 0.3),
    (1.5, Hat, 0.3),
    (2.0, Hat, 0.3),
    (2.5, Hat, 0.3),
    (3.0, Hat, 0.3),
    (3.5, Hat, 0.3),
    (1.75, Snare, 0.25),
    (2.25, Snare, 0.25),
    (0.0, Bass(28), 0.6),
    (2.5, Bass(31), 0.5),
];

const JAZZ_WALTZ: Pattern = &[
    (0.0, Ride, 0.5),
    (1.0, Ride, 0.4),
    (1.667, Ride, 0.3),
    (2.0, Ride, 0.4),
    (1.0, Hat, 0.3),
    (0.0, Kick, 0.4),
    (0.0, Bass(36), 0.6),
    (1.0, Bass(43), 0.4),
    (2.0, Bass(40), 0.5),
    (0.0, Piano(60), 0.3),
    (1.667, Piano(67), 0.3),
];
const THREE_CHORALE: Pattern =
    &[(0.0, Strings(57), 0.6), (0.0, Bass(33), 0.5), (1.0, Strings(57), 0.4), (2.0, Strings(60), 0.4)];
const DRONE: Pattern = &[(0.0, Strings(57), 0.3), (2.0, Strings(57), 0.2)];
const NOTHING: Pattern = &[];

fn steady(bpm: f64, _: usize) -> f64 {
    bpm
}
/// Up by a fifth over 60 beats.
fn faster(bpm: f64, beat: usize) -> f64 {
    bpm * (1.0 + 0.2 * (beat as f64 / 60.0).min(1.0))
}
/// As a person plays: slow changes by ±3 %.
fn human(bpm: f64, beat: usize) -> f64 {
    bpm * (1.0 + 0.03 * (beat as f64 * 0.35).sin())
}

/// The whole collection, 24 s each.
pub fn songs() -> Vec<Made> {
    let list: [(&str, f64, f64, Pattern, Tempo); 24] = [
        ("clicks", 60.0, 4.0, CLICKS, steady),
        ("clicks", 93.0, 4.0, CLICKS, steady),
        ("clicks", 140.0, 4.0, CLICKS, steady),
        ("clicks", 180.0, 4.0, CLICKS, steady),
        ("rock", 84.0, 4.0, ROCK, steady),
        ("rock", 104.0, 4.0, ROCK, steady),
        ("rock", 128.0, 4.0, ROCK, steady),
        ("rock-human", 116.0, 4.0, ROCK, human),
        ("rock-faster", 96.0, 4.0, ROCK, faster),
        ("house", 121.5, 4.0, HOUSE, steady),
        ("house", 132.0, 4.0, HOUSE, steady),
        ("house-faster", 112.0, 4.0, HOUSE, faster),
        ("swing", 112.0, 4.0, SWING, steady),
        ("swing", 152.0, 4.0, SWING, steady),
        ("swing-human", 132.0, 4.0, SWING, human),
        ("syncopated", 92.0, 4.0, SYNCOPATED, steady),
        ("syncopated", 108.0, 4.0, SYNCOPATED, steady),
        ("waltz", 90.0, 3.0, WALTZ, steady),
        ("waltz", 144.0, 3.0, WALTZ, human),
        ("chorale", 72.0, 4.0, CHORALE, steady),
        ("chorale", 100.0, 4.0, CHORALE, human),
        ("piano", 76.0, 4.0, PIANO, human),
        ("piano", 110.0, 4.0, PIANO, steady),
        ("breakbeat", 170.0, 4.0, BREAKBEAT, steady),
    ];
    list.iter().map(|&(name, bpm, bar, pattern, tempo)| make(name, bpm, bar, pattern, tempo)).collect()
}

/// A song whose bars and sections are known as well.
pub struct Formed {
    pub made: Made,
    /// First beats of bars.
    pub downbeats_secs: Vec<f64>,
    /// Where a new part begins, and each repetition of a part that does not directly follow it.
    pub sections_secs: Vec<f64>,
}

/// A part of a song: what is played, beats per bar, number of bars, and the steps of its harmony.
type Part = (Pattern, usize, usize, [u8; 4]);

const TURN: [u8; 4] = [0, 5, 3, 7];
const OTHER: [u8; 4] = [9, 2, 10, 4];
const STILL: [u8; 4] = [0, 0, 5, 0];

/// Songs with a form: 4/4, 3/4, changes of meter, breaks, AABA, an upbeat, a bar that is cut short.
pub fn formed() -> Vec<Formed> {
    let list: [(&str, f64, Tempo, usize, &[Part]); 14] = [
        (
            "verse-chorus",
            112.0,
            steady,
            0,
            &[
                (PIANO, 4, 4, TURN),
                (ROCK, 4, 8, TURN),
                (SYNCOPATED, 4, 8, OTHER),
                (ROCK, 4, 8, TURN),
                (SYNCOPATED, 4, 8, OTHER),
            ],
        ),
        ("waltz", 138.0, human, 0, &[(WALTZ, 3, 8, TURN), (WALTZ, 3, 8, OTHER), (WALTZ, 3, 8, TURN)]),
        ("to-three", 104.0, steady, 0, &[(ROCK, 4, 12, TURN), (WALTZ, 3, 12, TURN), (ROCK, 4, 12, TURN)]),
        (
            "house-break",
            124.0,
            steady,
            0,
            &[(HOUSE, 4, 12, TURN), (DRONE, 4, 8, STILL), (HOUSE, 4, 12, TURN)],
        ),
        (
            "aaba",
            132.0,
            human,
            0,
            &[(SWING, 4, 8, TURN), (SWING, 4, 8, TURN), (SWING, 4, 8, OTHER), (SWING, 4, 8, TURN)],
        ),
        (
            "jazz-waltz",
            152.0,
            steady,
            0,
            &[(JAZZ_WALTZ, 3, 16, TURN), (WALTZ, 3, 8, OTHER), (JAZZ_WALTZ, 3, 16, TURN)],
        ),
        ("upbeat", 96.0, steady, 2, &[(PIANO, 4, 8, TURN), (BREAKBEAT, 4, 8, OTHER), (PIANO, 4, 8, TURN)]),
        ("three-chorale", 92.0, human, 1, &[(THREE_CHORALE, 3, 8, TURN), (THREE_CHORALE, 3, 8, OTHER)]),
        ("silence", 120.0, steady, 0, &[(ROCK, 4, 8, TURN), (NOTHING, 4, 2, TURN), (ROCK, 4, 8, TURN)]),
        ("cut-bar", 110.0, steady, 0, &[(ROCK, 4, 8, TURN), (ROCK, 2, 1, TURN), (SYNCOPATED, 4, 8, OTHER)]),
        (
            "four-on-the-floor",
            128.0,
            steady,
            0,
            &[(HOUSE, 4, 8, STILL), (HOUSE, 4, 8, OTHER), (ROCK, 4, 8, STILL)],
        ),
        ("chorale", 80.0, human, 0, &[(CHORALE, 4, 8, TURN), (PIANO, 4, 8, OTHER), (CHORALE, 4, 8, TURN)]),
        ("three-to-four", 120.0, steady, 0, &[(JAZZ_WALTZ, 3, 12, TURN), (SWING, 4, 12, TURN)]),
        (
            "breakbeat",
            168.0,
            steady,
            0,
            &[(BREAKBEAT, 4, 16, TURN), (DRONE, 4, 8, STILL), (BREAKBEAT, 4, 16, OTHER)],
        ),
    ];
    list.iter().map(|(name, bpm, tempo, upbeat, parts)| form(name, *bpm, *tempo, *upbeat, parts)).collect()
}

fn form(name: &str, bpm: f64, tempo: Tempo, upbeat: usize, parts: &[Part]) -> Formed {
    let bars: Vec<(Pattern, usize, u8, bool)> = parts
        .iter()
        .flat_map(|&(pattern, beats, count, steps)| {
            (0..count).map(move |bar| (pattern, beats, steps[bar % 4], bar == 0))
        })
        .collect();
    let count = upbeat + bars.iter().map(|bar| bar.1).sum::<usize>();
    let mut times = vec![0.613];
    (0..count).for_each(|beat| times.push(times[beat] + 60.0 / tempo(bpm, beat)));
    let silence = vec![0.0; ((times[count] + 0.8) * f64::from(RATE_HZ)) as usize];
    let mut song = Song { rate_hz: RATE_HZ, left: silence.clone(), right: silence };
    let (mut noise, mut beat) = (0x2545_f491u32, 0);
    let (mut downbeats_secs, mut sections_secs) = (Vec::new(), Vec::new());
    let played =
        |beat: usize, place: f64| times[beat] + (place - place.floor()) * (times[beat + 1] - times[beat]);
    for place in 0..upbeat {
        add(&mut song, times[place], 0.4, Piano(67), place as u8, &mut noise);
        beat += 1;
    }
    for (i, &(pattern, beats, step, begins)) in bars.iter().enumerate() {
        downbeats_secs.push(times[beat]);
        // Repeating the same part directly does not begin a section.
        let same = i > 0 && bars[i - 1].0.as_ptr() == pattern.as_ptr() && {
            let steps = |bar: usize| bars[bar..].iter().take(4).map(|bar| bar.2).collect::<Vec<_>>();
            i >= 4 && steps(i) == steps(i - 4)
        };
        if begins && !same {
            sections_secs.push(times[beat]);
        }
        for &(place, instrument, gain) in pattern.iter().filter(|note| note.0 < beats as f64) {
            add(&mut song, played(beat + place as usize, place), gain, instrument, step, &mut noise);
        }
        beat += beats;
    }
    for sample in song.left.iter_mut().chain(&mut song.right) {
        *sample = 0.9 * sample.tanh();
    }
    times.truncate(count);
    Formed { made: Made { name: name.into(), song, beats_secs: times }, downbeats_secs, sections_secs }
}

fn make(name: &str, bpm: f64, beats_per_bar: f64, pattern: Pattern, tempo: Tempo) -> Made {
    const SECS: f64 = 24.0;
    let silence = vec![0.0; (SECS * f64::from(RATE_HZ)) as usize];
    let mut song = Song { rate_hz: RATE_HZ, left: silence.clone(), right: silence };
    let mut beats_secs = Vec::new();
    // A start that does not lie on a frame boundary.
    let mut at = 0.413;
    let mut noise = 0x2545_f491u32;
    for beat in 0.. {
        let gap = 60.0 / tempo(bpm, beat);
        if at + gap > SECS - 0.3 {
            break;
        }
        beats_secs.push(at);
        let in_bar = beat as f64 % beats_per_bar;
        for &(place, instrument, gain) in pattern {
            if place >= in_bar && place < in_bar + 1.0 {
                // The harmony moves from bar to bar, as music does.
                let step = [0u8, 5, 3, 7][(beat as f64 / beats_per_bar) as usize % 4];
                add(&mut song, at + (place - in_bar) * gap, gain, instrument, step, &mut noise);
            }
        }
        at += gap;
    }
    for sample in song.left.iter_mut().chain(&mut song.right) {
        *sample = 0.9 * sample.tanh();
    }
    Made { name: format!("{name}-{bpm}"), song, beats_secs }
}

fn add(song: &mut Song, at: f64, gain: f32, instrument: Instrument, step: u8, noise: &mut u32) {
    let start = (at * f64::from(RATE_HZ)) as usize;
    let len = (1.2 * f64::from(RATE_HZ)) as usize;
    let hz = |note: u8| 440.0 * ((f32::from(note + step) - 69.0) / 12.0).exp2();
    for n in 0..len.min(song.frames().saturating_sub(start)) {
        let t = n as f32 / RATE_HZ as f32;
        *noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let hiss = *noise as f32 / u32::MAX as f32 * 2.0 - 1.0;
        let attack = |secs: f32| (t / secs).min(1.0);
        let value = match instrument {
            Kick => {
                let skin = (TAU * (50.0 * t + 3.0 * (1.0 - (-t / 0.03).exp()))).sin() * (-t / 0.12).exp();
                skin + 0.4 * hiss * (-t / 0.004).exp()
            }
            Snare => (0.6 * hiss + 0.4 * (TAU * 190.0 * t).sin()) * (-t / 0.09).exp(),
            Hat => hiss * (-t / 0.03).exp(),
            Ride => (0.5 * hiss + 0.5 * (TAU * 5200.0 * t).sin()) * (-t / 0.2).exp(),
            Click => (TAU * 1500.0 * t).sin() * (-t / 0.01).exp(),
            Bass(note) => harmonics(hz(note), t, 5) * attack(0.008) * (-t / 0.3).exp(),
            Piano(note) => harmonics(hz(note), t, 8) * attack(0.003) * (-t / 0.5).exp(),
            Strings(note) => {
                let chord =
                    harmonics(hz(note), t, 5) + harmonics(hz(note + 4), t, 5) + harmonics(hz(note + 7), t, 5);
                0.4 * chord * attack(0.06) * (-((t - 0.3).max(0.0)) / 0.15).exp()
            }
        };
        song.left[start + n] += gain * 0.6 * value;
        song.right[start + n] += gain * 0.6 * value;
    }
}

fn harmonics(hz: f32, t: f32, count: usize) -> f32 {
    (1..=count).map(|h| (TAU * hz * h as f32 * t).sin() / h as f32).sum()
}
