use super::*;
use crate::ringing::Signal;
use chladni_testdata::{DoubleDouble, TAU};
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
        // Divided into 300 pieces, and read at a time within the last one.
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

/// [`exact`] in numbers of twice the digits, and how large the terms are that it adds up.
fn to_the_last_digit(secs: f32, hz: f32, damping: f32) -> ([DoubleDouble; 4], [f64; 4]) {
    let [t, hz, zeta] = [secs, hz, damping].map(|x| DoubleDouble::from(f64::from(x)));
    let (one, omega) = (DoubleDouble::from(1.0), TAU * hz);
    let square = omega * omega * (one - zeta * zeta);
    let x = if square.rounded() < 0.0 { (-square).sqrt() } else { square.sqrt() };
    let (sine, cosine) = if x.rounded() == 0.0 {
        (t, one)
    } else if square.rounded() > 0.0 {
        let (sin, cos) = (x * t).sin_cos();
        (sin / x, cos)
    } else {
        let [up, down] = [(x * t).exp(), (-(x * t)).exp()];
        let half = DoubleDouble::from(0.5);
        ((up - down) * half / x, (up + down) * half)
    };
    let decay = (-(zeta * omega * t)).exp();
    let of_rate = zeta * omega * sine;
    let values =
        [cosine + of_rate, sine, -(omega * omega * sine), cosine - of_rate].map(|value| decay * value);
    let [c, s, r, w] = [cosine, sine, of_rate, omega].map(|x| x.rounded().abs());
    (values, [c + r, s, w * w * s, c + r].map(|size| decay.rounded() * size))
}

const DAMPINGS: [f32; 7] = [0.01, 0.04, 0.3, 0.999_999, 1.0, 1.000_001, 2.0];

/// Rounded once, to single precision; in doubles it loses as many bits as the oscillator turns.
#[test]
fn one_step_is_right_to_the_last_digit() {
    for damping in DAMPINGS {
        for tone in 0..TONES {
            for secs in [1e-5, 0.003, 1.0 / 128.0, 0.25, 4.0] {
                let (known, sizes) = to_the_last_digit(secs, tone_hz(tone), damping);
                let turned = f64::from(TAU.rounded() as f32 * tone_hz(tone) * secs);
                for ((found, known), size) in
                    exact(secs, tone_hz(tone), damping).into_iter().zip(known).zip(sizes)
                {
                    let bound = 0.5001 * f64::from(f32::EPSILON) * known.rounded().abs();
                    let lost = 8.0 * f64::EPSILON * (1.0 + turned) * size + f64::from(f32::MIN_POSITIVE);
                    let error = known.error_of(f64::from(found));
                    assert!(error <= bound + lost, "ζ {damping}, tone {tone}, {secs} s: {error:e}");
                }
            }
        }
    }
}

/// After twenty seconds of noise, single precision is off by less than 3·10⁻⁵ of the largest swing.
#[test]
fn twenty_seconds_of_ringing_keep_four_digits() {
    let piece = 1.0 / 128.0;
    let levels: Vec<f32> =
        (0..2560u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 16) as f32 / 65536.0).collect();
    for damping in DAMPINGS {
        let timbre = Timbre { damping, strike: 1.5, hold: 0.5, ..TIMBRE };
        let mut bank = Resonators::new(&timbre, 1);
        levels.iter().for_each(|level| bank.hear(&mono(&[*level]), piece));
        let ringing = bank.ring(0.0).clone();
        for tone in [0, 20, 41, TONES - 1] {
            let ([a, b, c, d], _) = to_the_last_digit(piece, tone_hz(tone), damping);
            let stroke = DoubleDouble::from(f64::from(timbre.strike)) * TAU * f64::from(tone_hz(tone)).into();
            let [mut q, mut speed] = [DoubleDouble::default(); 2];
            let (mut before, mut farthest) = (0.0, 0.0f64);
            for (i, level) in levels.iter().copied().enumerate() {
                if i > 0 {
                    let held = DoubleDouble::from(f64::from(timbre.hold)) * f64::from(levels[i - 1]).into();
                    let (y, rate) = (q - held, speed);
                    (q, speed) = (held + a * y + b * rate, c * y + d * rate);
                }
                speed = speed + stroke * f64::from((level - before).max(0.0)).into();
                before = level;
                farthest = farthest.max(q.rounded().abs());
            }
            let error = q.error_of(f64::from(ringing.at(Signal::Mid, tone as u8, 0)));
            assert!(error <= 3e-5 * farthest, "ζ {damping}, tone {tone}: {:e}", error / farthest);
        }
    }
}

#[test]
fn what_rings_for_long_comes_to_rest_however_it_is_damped() {
    for damping in [0.3, 1.0, 1.2, 2.0] {
        for hz in [12.0, 400.0] {
            let rest = exact(30.0, hz, damping);
            assert!(rest.iter().all(|x| x.abs() < 1e-6), "ζ = {damping}, {hz} Hz: {rest:?}");
        }
    }
}
