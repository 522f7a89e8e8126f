//! Resonators: harmonics as damped oscillators that the bands of sound strike.
//!
//! Between the sound and a mapping lies a bank of oscillators
//!
//! ```text
//! q̈ + 2 ζ ω q̇ + ω² q = ω² h f(t),      q̇ += ω s max(0, Δf) where f rises by Δf,
//! ```
//!
//! one for each band of sound and each of [`TONES`] frequencies ω; h holds the level, s strikes. A mapping is
//! linear in its bands, so that a harmonic of frequency ω that hears the sum of some bands moves as the same
//! sum of their oscillators: one bank serves all dances, and none of them has a state of its own. So the
//! movement at any time depends only on the sound up to then, not on how often it was drawn or what was bred
//! or chosen in between.

use serde::{Deserialize, Serialize};

use crate::stereo::StereoMix;
use crate::{Action, Bands, Parameter, Parameters, Switch};

/// Frequencies of the bank, in even factors from 0.4 to 12 Hz: neighbors differ by 5.5 %.
pub const TONES: usize = 64;
/// The lowest frequency of the bank.
pub const LOWEST_HZ: f32 = 0.4;
/// The highest one: a period of two and a half frames at 30 Hz.
pub const HIGHEST_HZ: f32 = 12.0;

/// How harmonics ring, which makes a shape look like a certain material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Timbre {
    /// ζ in [0.01, 2]: from 1 on nothing overshoots.
    pub damping: f32,
    /// The frequency of the slowest harmonic, in Hz.
    pub tuning_hz: f32,
    /// Frequencies go with √λ to this power: 1 is the ratio of a membrane, 0 one frequency for all.
    pub stretch: f32,
    /// s: a rise of the sound by 1 makes a harmonic swing about this far.
    pub strike: f32,
    /// h: how far a steady sound of level 1 displaces it.
    pub hold: f32,
}

impl Timbre {
    /// Named ones, the default first.
    pub const NAMED: [(&'static str, Self); 6] = [
        ("rubber", Self { damping: 0.7, tuning_hz: 5.0, stretch: 0.45, strike: 2.4, hold: 0.5 }),
        ("jelly", Self { damping: 0.3, tuning_hz: 3.0, stretch: 0.45, strike: 3.5, hold: 0.25 }),
        ("bell", Self { damping: 0.04, tuning_hz: 2.5, stretch: 0.6, strike: 1.0, hold: 0.1 }),
        ("drum", Self { damping: 0.3, tuning_hz: 3.0, stretch: 0.5, strike: 1.8, hold: 0.15 }),
        ("cloth", Self { damping: 0.55, tuning_hz: 0.7, stretch: 0.6, strike: 1.6, hold: 0.8 }),
        ("metal", Self { damping: 0.08, tuning_hz: 4.0, stretch: 0.8, strike: 1.1, hold: 0.25 }),
    ];

    /// The one of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMED.into_iter().find(|(known, _)| *known == name).map(|(_, timbre)| timbre)
    }

    /// The timbre that the knobs give; `None` while the resonators are off.
    pub fn of(parameters: &Parameters) -> Option<Self> {
        parameters.is_on(Switch::Resonate).then(|| Self {
            damping: parameters.get(Parameter::Damping),
            tuning_hz: parameters.get(Parameter::TuningHz),
            stretch: parameters.get(Parameter::Stretch),
            strike: parameters.get(Parameter::Strike),
            hold: parameters.get(Parameter::Hold),
        })
    }

    /// The actions that set an instrument's knobs to it.
    pub fn actions(&self) -> [Action; 6] {
        let set = |parameter, value| Action::Set { parameter, value };
        [
            Action::Switch { switch: Switch::Resonate, on: true },
            set(Parameter::Damping, self.damping),
            set(Parameter::TuningHz, self.tuning_hz),
            set(Parameter::Stretch, self.stretch),
            set(Parameter::Strike, self.strike),
            set(Parameter::Hold, self.hold),
        ]
    }

    /// The tone of the bank with which a harmonic of eigenvalue `lambda` rings; `slowest` is the eigenvalue
    /// of the slowest wave.
    pub(crate) fn tone(&self, lambda: f64, slowest: f64) -> u8 {
        let ratio = (lambda / slowest).max(1.0).sqrt() as f32;
        let hz = self.tuning_hz * ratio.powf(self.stretch);
        let share = (hz / LOWEST_HZ).ln() / (HIGHEST_HZ / LOWEST_HZ).ln();
        (share.clamp(0.0, 1.0) * (TONES - 1) as f32).round() as u8
    }
}

/// Frequency of a tone of the bank, in Hz.
fn tone_hz(tone: usize) -> f32 {
    LOWEST_HZ * (HIGHEST_HZ / LOWEST_HZ).powf(tone as f32 / (TONES - 1) as f32)
}

/// The oscillators of all bands at one moment, for each signal that a form may listen to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ringing {
    bands: usize,
    /// Left, right, middle, side, and swing toward the left: TONES rows of bands each.
    q: [Vec<f32>; SIGNALS],
}

/// A signal of [`Ringing`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Signal {
    Left,
    Right,
    Mid,
    Side,
    Swing,
}

const SIGNALS: usize = 5;

impl Ringing {
    /// #ω.
    pub fn bands(&self) -> usize {
        self.bands
    }

    pub(crate) fn at(&self, signal: Signal, tone: u8, band: usize) -> f32 {
        self.q[signal as usize][usize::from(tone) * self.bands + band]
    }

    /// Sets it to rest, with `bands` bands.
    pub fn still(&mut self, bands: usize) {
        self.bands = bands;
        for q in &mut self.q {
            q.clear();
            q.resize(TONES * bands, 0.0);
        }
    }

    /// Mixes in the ringing from before a jump in the song; weight 1 replaces this one.
    pub fn mix(&mut self, other: &Self, weight: f32) {
        if other.bands == self.bands {
            for (q, other) in self.q.iter_mut().zip(&other.q) {
                q.iter_mut().zip(other).for_each(|(q, other)| *q += weight * (other - *q));
            }
        }
    }
}

/// How many pieces of sound wait at most before the oscillators go through them together.
const WAITING: usize = 32;

/// The bank of oscillators.
///
/// Sound comes in as pieces of constant level, each solved exactly: [`hear`](Self::hear) begins one, and
/// [`ring`](Self::ring) gives the oscillators at a time within it. Pieces are solved together, tone by tone, when
/// somebody asks: the state of a tone is then read from memory once for all of them.
#[derive(Clone, Debug)]
pub struct Resonators {
    damping: f32,
    strike: f32,
    hold: f32,
    bands: usize,
    /// s ω of each tone: what a rise of 1 adds to q̇.
    strokes: [f32; TONES],
    signals: [Row; SIGNALS],
    /// Pieces of sound that were heard and not yet solved, each of which began when the one before it had
    /// lasted as long as `piece`.
    waiting: usize,
    piece: Step,
    /// From the beginning of the current piece to now.
    within: Step,
    now: Ringing,
}

/// The oscillators of one signal.
#[derive(Clone, Debug)]
struct Row {
    /// q and q̇ at the beginning of the last piece that was solved.
    q: Vec<f32>,
    speed: Vec<f32>,
    /// f of that piece and of those that wait: rows of bands.
    levels: Vec<f32>,
    /// What strikes at the beginning of each that waits.
    rises: Vec<f32>,
}

/// The exact solution over one time step, for each tone: with y = q − h f, y(t) = a y + b ẏ and ẏ(t) = c y +
/// d ẏ.
#[derive(Clone, Debug)]
struct Step {
    secs: f32,
    tones: [[f32; 4]; TONES],
}

impl Step {
    fn of(secs: f32, damping: f32) -> Self {
        Self { secs, tones: std::array::from_fn(|tone| exact(secs, tone_hz(tone), damping)) }
    }

    fn set(&mut self, secs: f32, damping: f32) {
        if self.secs != secs {
            *self = Self::of(secs, damping);
        }
    }
}

/// What dies away comes to rest before its numbers lose their leading digit: with such numbers processors are some
/// fifty times slower, and each pause of a song would be full of them.
#[inline]
fn audible(x: f32) -> f32 {
    if x.abs() < 1e-18 { 0.0 } else { x }
}

/// a, b, c and d of one oscillator, underdamped (ζ < 1) or not.
fn exact(secs: f32, hz: f32, damping: f32) -> [f32; 4] {
    let (t, omega, zeta) = (f64::from(secs), std::f64::consts::TAU * f64::from(hz), f64::from(damping));
    let decay = (-zeta * omega * t).exp();
    // sin(ω_d t)/ω_d and cos(ω_d t), or their hyperbolic twins; the first is t where ω_d is 0.
    let square = omega * omega * (1.0 - zeta * zeta);
    let x = square.abs().sqrt();
    let (sine, cosine) = match () {
        () if x * t < 1e-6 => (t, 1.0),
        () if square > 0.0 => ((x * t).sin() / x, (x * t).cos()),
        () => ((x * t).sinh() / x, (x * t).cosh()),
    };
    let of_rate = zeta * omega * sine;
    [decay * (cosine + of_rate), decay * sine, -decay * omega * omega * sine, decay * (cosine - of_rate)]
        .map(|x| x as f32)
}

impl Resonators {
    /// A bank at rest for `bands` bands.
    pub fn new(timbre: &Timbre, bands: usize) -> Self {
        let silence = vec![0.0; TONES * bands];
        let row = Row {
            q: silence.clone(),
            speed: silence.clone(),
            levels: vec![0.0; (WAITING + 1) * bands],
            rises: vec![0.0; WAITING * bands],
        };
        Self {
            damping: timbre.damping,
            strike: timbre.strike,
            hold: timbre.hold,
            bands,
            strokes: std::array::from_fn(|tone| timbre.strike * std::f32::consts::TAU * tone_hz(tone)),
            signals: std::array::from_fn(|_| row.clone()),
            waiting: 0,
            piece: Step::of(0.0, timbre.damping),
            within: Step::of(0.0, timbre.damping),
            now: Ringing { bands, q: std::array::from_fn(|_| silence.clone()) },
        }
    }

    /// Makes `bank` ring with `timbre`; a new bank starts at rest. Tuning and stretch concern only the
    /// mappings.
    pub fn follow(bank: &mut Option<Self>, timbre: Option<&Timbre>, bands: usize) {
        let has = bank.as_ref().map(|bank| (bank.damping, bank.strike, bank.hold, bank.bands));
        let wants = timbre.map(|timbre| (timbre.damping, timbre.strike, timbre.hold, bands));
        if has != wants {
            *bank = timbre.map(|timbre| Self::new(timbre, bands));
        }
    }

    /// Brings all to rest.
    pub fn still(&mut self) {
        self.waiting = 0;
        for row in &mut self.signals {
            [&mut row.levels, &mut row.q, &mut row.speed].into_iter().for_each(|values| values.fill(0.0));
        }
        self.now.q.iter_mut().for_each(|q| q.fill(0.0));
    }

    /// Begins a piece of sound, after the last one has lasted for `lasted_secs`. A different number of bands
    /// is ignored.
    pub fn hear(&mut self, bands: &Bands<'_>, lasted_secs: f32) {
        if bands.mid.len() != self.bands {
            return;
        }
        if self.waiting == WAITING || self.piece.secs != lasted_secs {
            self.solve();
        }
        self.piece.set(lasted_secs, self.damping);
        let mix = StereoMix::new(0.0, bands, false);
        for (number, row) in self.signals.iter_mut().enumerate() {
            row.hear(self.waiting, self.bands, |band| match number {
                0 => bands.left[band],
                1 => bands.right[band],
                2 => bands.mid[band],
                3 => bands.side[band],
                _ => mix.swing(bands, band),
            });
        }
        self.waiting += 1;
    }

    /// The oscillators `after_secs` into the current piece of sound.
    pub fn ring(&mut self, after_secs: f32) -> &Ringing {
        self.solve();
        self.within.set(after_secs, self.damping);
        for (row, out) in self.signals.iter().zip(&mut self.now.q) {
            for (tone, &[a, b, ..]) in self.within.tones.iter().enumerate() {
                let of = tone * self.bands..(tone + 1) * self.bands;
                let (q, speed) = (&row.q[of.clone()], &row.speed[of.clone()]);
                for (((out, q), speed), level) in out[of].iter_mut().zip(q).zip(speed).zip(&row.levels) {
                    let held = self.hold * level;
                    *out = held + a * (q - held) + b * speed;
                }
            }
        }
        &self.now
    }

    /// Brings the oscillators to the beginning of the current piece.
    fn solve(&mut self) {
        for row in &mut self.signals {
            row.solve(self.waiting, &self.piece, self.hold, &self.strokes);
        }
        self.waiting = 0;
    }

    /// What [`ring`](Self::ring) gave last.
    pub fn ringing(&self) -> &Ringing {
        &self.now
    }
}

impl Row {
    /// Takes in the piece after `waiting` others.
    fn hear(&mut self, waiting: usize, bands: usize, level: impl Fn(usize) -> f32) {
        let (before, after) = self.levels[waiting * bands..].split_at_mut(bands);
        let rises = &mut self.rises[waiting * bands..];
        for (band, ((before, after), rise)) in before.iter().zip(after).zip(rises).enumerate() {
            *after = level(band);
            // The side has a sign: a growing magnitude strikes, a falling one does not.
            let grown = after.abs() - before.abs();
            *rise = if grown > 0.0 { after.signum() * grown } else { 0.0 };
        }
    }

    /// Goes to the beginning of the last of `waiting` pieces.
    fn solve(&mut self, waiting: usize, piece: &Step, hold: f32, strokes: &[f32; TONES]) {
        let bands = self.levels.len() / (WAITING + 1);
        if waiting == 0 || bands == 0 {
            return;
        }
        let tones = self.q.chunks_exact_mut(bands).zip(self.speed.chunks_exact_mut(bands));
        for (((q, speed), &[a, b, c, d]), stroke) in tones.zip(&piece.tones).zip(strokes) {
            let pieces = self.levels.chunks_exact(bands).zip(self.rises.chunks_exact(bands));
            for (levels, rises) in pieces.take(waiting) {
                for (((q, speed), level), rise) in q.iter_mut().zip(&mut *speed).zip(levels).zip(rises) {
                    let held = hold * level;
                    let (y, rate) = (*q - held, *speed);
                    *q = audible(held + a * y + b * rate);
                    *speed = audible(c * y + d * rate + stroke * rise);
                }
            }
        }
        self.levels.copy_within(waiting * bands..(waiting + 1) * bands, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const TIMBRE: Timbre = Timbre { damping: 0.1, tuning_hz: 1.0, stretch: 0.5, strike: 0.0, hold: 1.0 };

    fn mono(level: &[f32]) -> Bands<'_> {
        const SILENCE: [f32; 8] = [0.0; 8];
        let side = &SILENCE[..level.len()];
        Bands { left: level, right: level, mid: level, side, side_gain: 1.0, ringing: None }
    }

    #[test]
    fn a_step_of_sound_is_answered_as_the_closed_form_says() {
        for damping in [0.05f32, 0.3, 0.999_999, 1.0, 1.7] {
            let mut bank = Resonators::new(&Timbre { damping, ..TIMBRE }, 1);
            bank.hear(&mono(&[0.8]), 0.0);
            // In 300 pieces, and at a time within the last one.
            for _ in 0..300 {
                bank.hear(&mono(&[0.8]), 1.0 / 128.0);
            }
            let t = 300.0 / 128.0 + 0.003;
            let ringing = bank.ring(0.003);
            for tone in [0, 20, TONES - 1] {
                let omega = std::f64::consts::TAU * f64::from(tone_hz(tone));
                let zeta = f64::from(damping);
                let answer = if zeta < 0.9999 {
                    let free = omega * (1.0 - zeta * zeta).sqrt();
                    let lag = zeta / (1.0 - zeta * zeta).sqrt();
                    1.0 - (-zeta * omega * t).exp() * ((free * t).cos() + lag * (free * t).sin())
                } else if zeta < 1.1 {
                    1.0 - (-omega * t).exp() * (1.0 + omega * t)
                } else {
                    let root = (zeta * zeta - 1.0).sqrt();
                    let [slow, fast] = [omega * (zeta - root), omega * (zeta + root)];
                    1.0 - (fast * (-slow * t).exp() - slow * (-fast * t).exp()) / (fast - slow)
                };
                let q = f64::from(ringing.at(Signal::Mid, tone as u8, 0));
                assert!((q - 0.8 * answer).abs() < 2e-4, "ζ {zeta} tone {tone}: {q} not {}", 0.8 * answer);
            }
        }
    }

    #[test]
    fn a_stroke_swings_as_far_as_it_says_and_dies_away_with_its_energy() {
        let mut bank = Resonators::new(&Timbre { damping: 0.02, strike: 0.7, hold: 0.0, ..TIMBRE }, 1);
        bank.hear(&mono(&[1.0]), 0.0);
        let tone = 30;
        let quarter = 0.25 / tone_hz(tone);
        let swing = bank.ring(quarter).at(Signal::Left, tone as u8, 0);
        assert!((swing / (0.7 * (-0.02 * std::f32::consts::FRAC_PI_2).exp()) - 1.0).abs() < 1e-3, "{swing}");
        let energy = |bank: &mut Resonators| {
            bank.solve();
            let omega = std::f32::consts::TAU * tone_hz(tone);
            let row = &bank.signals[0];
            (omega * row.q[tone]).powi(2) + row.speed[tone].powi(2)
        };
        let mut before = energy(&mut bank);
        for _ in 0..500 {
            bank.hear(&mono(&[1.0]), 1.0 / 128.0);
            let now = energy(&mut bank);
            assert!(now < before);
            before = now;
        }
    }

    #[test]
    fn it_does_not_matter_how_often_one_looks() {
        let sound = |i: usize| [(0.3 * i as f32).sin().abs(), (i % 7) as f32 / 7.0];
        let run = |fps: usize| {
            let timbre = Timbre::NAMED[0].1;
            let mut bank = Resonators::new(&timbre, 2);
            let (mut hop, mut shots) = (0, Vec::new());
            for frame in 0..2 * fps {
                let secs = frame as f64 / fps as f64;
                let now = (secs * 128.0) as usize;
                while hop <= now {
                    bank.hear(&mono(&sound(hop)), if hop == 0 { 0.0 } else { 1.0 / 128.0 });
                    hop += 1;
                }
                let ringing = bank.ring((secs - now as f64 / 128.0) as f32);
                if frame % (fps / 2) == 0 {
                    shots.push(ringing.clone());
                }
            }
            shots
        };
        assert_eq!(run(60), run(24));
        assert_eq!(run(60), run(30));
        assert!(run(60)[3].q[0].iter().any(|q| q.abs() > 0.1));
    }

    #[test]
    fn all_comes_to_rest_in_silence() {
        for (_, timbre) in Timbre::NAMED {
            let mut bank = Resonators::new(&timbre, 2);
            bank.hear(&mono(&[1.0, 0.3]), 0.0);
            // The slowest tone of the bell rings for minutes.
            for _ in 0..128 * 600 {
                bank.hear(&mono(&[0.0; 2]), 1.0 / 128.0);
            }
            assert!(bank.ring(0.001).q.iter().flatten().all(|q| *q == 0.0), "{timbre:?}");
        }
    }

    #[test]
    fn harmonics_ring_higher_the_finer_they_are() {
        let timbre = Timbre { tuning_hz: 0.8, stretch: 1.0, ..TIMBRE };
        let tones = [1.0, 4.0, 100.0, 1e6].map(|lambda| timbre.tone(lambda, 1.0));
        assert!(tones.is_sorted() && tones[0] > 0 && usize::from(tones[3]) == TONES - 1);
        assert!((tone_hz(tones[1].into()) / 1.6 - 1.0).abs() < 0.03);
        assert_eq!(Timbre { stretch: 0.0, ..timbre }.tone(50.0, 1.0), tones[0]);
        // The constant harmonic has no frequency of its own.
        assert_eq!(timbre.tone(0.0, 1.0), tones[0]);
    }

    proptest! {
        #[test]
        fn no_sound_and_no_knob_makes_it_run_away(
            damping in 0.01f32..2.0, strike in 0.0f32..4.0, hold in 0.0f32..2.0,
            levels in prop::collection::vec(0.0f32..1.0, 1..60), lasted in 0.0f32..3.0)
        {
            let mut bank = Resonators::new(&Timbre { damping, strike, hold, ..TIMBRE }, 1);
            let mut risen = 0.0;
            let mut last = 0.0;
            for level in levels {
                risen += (level - last).max(0.0);
                last = level;
                bank.hear(&mono(&[level]), lasted);
                let most = bank.ring(lasted).q.iter().flatten().fold(0.0f32, |m, q| m.max(q.abs()));
                prop_assert!(most.is_finite() && most <= 2.0 * hold * (1.0 + risen) + strike * risen + 1e-3, "{}", most);
            }
        }
    }
}
