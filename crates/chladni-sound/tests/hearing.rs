//! Spectra of tones whose amplitude is known.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

use std::sync::Arc;

use chladni_sound::{
    FrontEnd, Level, Song, SongReader, SongSpectrum, Spectrum, SpectrumAnalyzer, SpectrumSettings,
};
use chladni_testdata::shared;

const RATE_HZ: u32 = 44_100;

fn sweep(from_hz: f64, to_hz: f64, secs: f64, amplitude: f64) -> Vec<f32> {
    let octaves = (to_hz / from_hz).ln();
    (0..(secs * f64::from(RATE_HZ)) as usize)
        .map(|n| {
            let t = n as f64 / f64::from(RATE_HZ);
            let phase = from_hz * secs / octaves * ((octaves * t / secs).exp() - 1.0);
            (amplitude * (std::f64::consts::TAU * phase).sin()) as f32
        })
        .collect()
}

/// The loudest band and its amplitude for each window, with the window centered on a time.
fn peaks(settings: SpectrumSettings, left: &[f32], right: &[f32], step: usize) -> Vec<(usize, f32)> {
    let mut analyzer = SpectrumAnalyzer::new(settings).unwrap();
    let n = analyzer.window_frames();
    (0..left.len().saturating_sub(n))
        .step_by(step)
        .map(|at| {
            let s = analyzer.analyze(&left[at..at + n], &right[at..at + n], step as f64 / f64::from(RATE_HZ));
            let best = (0..s.mid.len()).max_by(|&a, &b| s.mid[a].total_cmp(&s.mid[b])).unwrap();
            (best, s.mid[best])
        })
        .collect()
}

fn plain(bands: usize) -> SpectrumSettings {
    SpectrumSettings { bands, decay: 0.0, level: Level::Fixed(1.0), ..SpectrumSettings::new(RATE_HZ) }
}

#[test]
fn a_swept_sine_keeps_its_level_and_never_jumps() {
    let tone = sweep(40.0, 16_000.0, 20.0, 0.5);
    for bands in [32, 64, 128, 256] {
        let found = peaks(plain(bands), &tone, &tone, 441);
        let db: Vec<f64> = found.iter().map(|(_, a)| 20.0 * f64::from(a / 0.5).log10()).collect();
        let (low, high) = db.iter().fold((f64::MAX, f64::MIN), |(l, h), &x| (l.min(x), h.max(x)));
        let jump = db.windows(2).fold(0.0f64, |a, w| a.max((w[1] - w[0]).abs()));
        eprintln!("{bands} bands: level {low:.2} to {high:.2} dB, largest step in 10 ms {jump:.2} dB");
        assert!(low > -1.5 && high < 1.5, "{bands} bands: {low} to {high} dB");
        assert!(jump < 0.7, "{bands} bands: {jump} dB");
        // The loudest band rises with the tone.
        assert!(found.windows(2).all(|w| w[1].0 + 1 >= w[0].0), "{bands} bands");
        assert!(found[0].0 <= bands / 20 + 1 && found[found.len() - 1].0 >= bands - bands / 20 - 2);
    }
}

#[test]
fn the_linear_front_end_has_equal_steps() {
    let settings = SpectrumSettings { front_end: FrontEnd::Linear, bands: 100, ..plain(100) };
    let tone = sweep(500.0, 15_000.0, 10.0, 1.0);
    for (_, amplitude) in peaks(settings, &tone, &tone, 4410) {
        assert!((20.0 * amplitude.log10()).abs() < 1.5, "{amplitude}");
    }
}

/// Pulses of a tone, similar to a beat.
fn pulses(amplitude: f32) -> Vec<f32> {
    (0..4 * RATE_HZ)
        .map(|n| {
            let t = n as f32 / RATE_HZ as f32;
            amplitude * (-8.0 * (t % 0.5)).exp() * (std::f32::consts::TAU * 330.0 * t).sin()
        })
        .collect()
}

#[test]
fn quiet_and_loud_masters_move_alike() {
    let settings = || SpectrumSettings { bands: 64, ..SpectrumSettings::new(RATE_HZ) };
    let after_all = |samples: &[f32]| {
        let found = peaks(settings(), samples, samples, 735);
        found[found.len() - 40..].to_vec()
    };
    let (loud, quiet) = (pulses(1.0), pulses(0.01));
    // A song that is 40 dB quieter, and one after 40 s of loud music (4 s are 240 whole steps).
    let mut after_loud = pulses(1.0);
    (0..10).for_each(|_| after_loud.extend(&quiet));
    for (name, other) in [("quiet", &quiet), ("after a loud song", &after_loud)] {
        for ((band, a), (other_band, b)) in after_all(&loud).iter().zip(after_all(other)) {
            assert_eq!(*band, other_band, "{name}");
            assert!((20.0 * (a / b).log10()).abs() < 2.0, "{name}: {a} and {b}");
        }
    }
}

#[test]
fn a_knob_turned_while_listening_keeps_level_and_spectrum() {
    let tone = sweep(440.0, 440.001, 0.5, 0.5);
    let soft: Vec<f32> = tone.iter().map(|x| 0.1 * x).collect();
    let settings = SpectrumSettings { decay: 0.0, bands: 32, ..SpectrumSettings::new(RATE_HZ) };
    let mut analyzer = SpectrumAnalyzer::new(settings.clone()).unwrap();
    for (sound, windows) in [(&tone, 60), (&soft, 80)] {
        for _ in 0..windows {
            analyzer.analyze(sound, sound, 0.05);
        }
    }
    let loudest = |s: &Spectrum| s.mid.iter().fold(0.0f32, |a, &b| a.max(b));
    let before = loudest(analyzer.spectrum());
    assert!((0.1..0.7).contains(&before), "a soft passage: {before}");
    // Other bands are heard anew, but it is still a soft passage.
    analyzer.retune(SpectrumSettings { bands: 64, ..settings.clone() }).unwrap();
    let after = loudest(analyzer.analyze(&soft, &soft, 0.01));
    assert!((after / before - 1.0).abs() < 0.3, "{before} and {after}");
    // A longer decay begins with what was heard.
    analyzer.retune(SpectrumSettings { bands: 64, decay: 0.9, side_gain: 2.0, ..settings.clone() }).unwrap();
    assert_eq!(analyzer.settings().decay, 0.9);
    assert!(analyzer.lag_secs() > 0.0);
    let later = loudest(analyzer.analyze(&soft, &soft, 0.001));
    assert!((later / after - 1.0).abs() < 0.1, "{after} and {later}");
    assert!(analyzer.retune(SpectrumSettings { bands: 64, decay: 1.0, ..settings }).is_err());
    assert_eq!(analyzer.settings().decay, 0.9);
}

#[test]
fn a_blend_of_spectra_leads_from_one_side_to_the_other() {
    let of = |side: f32, side_gain: f32| Spectrum {
        mid: vec![0.5],
        side: vec![side],
        left: vec![0.5],
        right: vec![0.5],
        side_gain,
    };
    // A wide passage with a low gain, and one that is nearly mono.
    let (wide, narrow) = (of(1.0, 1.2), of(0.2, 10.0));
    let mixed = |weight: f32| {
        let mut mixed = narrow.clone();
        mixed.mix(&wide, weight);
        mixed
    };
    assert_eq!(mixed(0.0), narrow);
    let end = mixed(1.0);
    assert!((end.side[0] - 1.0).abs() < 1e-5 && (end.side_gain - 1.2).abs() < 1e-5, "{end:?}");
    // The side without its gain, squared, is blended linearly.
    let half = mixed(0.5);
    let bare = |of: &Spectrum| (of.side[0] / of.side_gain).powi(2);
    assert!((half.side_gain - 5.6).abs() < 1e-5);
    assert!((bare(&half) - 0.5 * (bare(&wide) + bare(&narrow))).abs() < 1e-5);
    let mut silent = of(0.0, 0.0);
    silent.mix(&of(0.3, 0.0), 0.5);
    assert_eq!(silent.side, [0.0]);
}

#[test]
fn a_copy_of_a_spectrum_keeps_its_memory() {
    let of = |level: f32| {
        let [mid, side, left, right] = std::array::from_fn(|_| vec![level; 8]);
        Spectrum { mid, side, left, right, side_gain: level }
    };
    let (source, mut copy) = (of(0.5), of(0.1));
    let memory = |of: &Spectrum| [&of.mid, &of.side, &of.left, &of.right].map(Vec::as_ptr);
    let before = memory(&copy);
    copy.clone_from(&source);
    assert_eq!((memory(&copy), &copy), (before, &source));
}

#[test]
fn silence_stays_silent() {
    let silence = vec![0.0; 100_000];
    for (_, amplitude) in peaks(SpectrumSettings::new(RATE_HZ), &silence, &silence, 735) {
        assert_eq!(amplitude, 0.0);
    }
}

#[test]
fn middle_and_side_are_what_they_are_called() {
    let tone = sweep(440.0, 440.001, 0.5, 0.8);
    let inverted: Vec<f32> = tone.iter().map(|x| -x).collect();
    let silence = vec![0.0; tone.len()];
    let loudest = |left: &[f32], right: &[f32]| {
        let mut analyzer = SpectrumAnalyzer::new(SpectrumSettings { side_gain: 1.0, ..plain(64) }).unwrap();
        let s = analyzer.analyze(left, right, 0.05);
        let max = |bands: &[f32]| bands.iter().fold(0.0f32, |a, &b| a.max(b));
        (max(&s.mid), max(&s.side))
    };
    let close = |(mid, side): (f32, f32), true_mid: f32, true_side: f32| {
        assert!((mid - true_mid).abs() < 0.08 && (side - true_side).abs() < 0.08, "{mid} {side}");
    };
    close(loudest(&tone, &tone), 0.8, 0.0);
    close(loudest(&tone, &inverted), 0.0, 0.8);
    close(loudest(&tone, &silence), 0.4, 0.4);
}

#[test]
fn decay_does_not_depend_on_the_frame_rate() {
    let tone = sweep(440.0, 440.001, 1.0, 1.0);
    let run = |steps: u32| {
        let mut analyzer = SpectrumAnalyzer::new(SpectrumSettings { decay: 0.8, ..plain(32) }).unwrap();
        let n = analyzer.window_frames();
        for _ in 0..steps {
            analyzer.analyze(&tone[..n], &tone[..n], 0.2 / f64::from(steps));
        }
        analyzer.spectrum().mid.iter().fold(0.0f32, |a, &b| a.max(b))
    };
    let (slow, fast) = (run(4), run(24));
    assert!((slow - fast).abs() < 1e-4, "{slow} {fast}");
    assert!(slow < 0.65 && slow > 0.5, "w = 0.8 after 4 intervals: {slow}");
}

#[test]
fn the_lag_is_when_a_click_is_strongest() {
    for decay in [0.0, 0.2, 0.5, 0.9] {
        let mut analyzer = SpectrumAnalyzer::new(SpectrumSettings { decay, ..plain(32) }).unwrap();
        let n = analyzer.window_frames();
        let mut click = vec![0.0; 4 * n];
        click[2 * n] = 1.0;
        let step = 60;
        let loudness = |at: usize, analyzer: &mut SpectrumAnalyzer| {
            let window = &click[at..at + n];
            let s = analyzer.analyze(window, window, step as f64 / f64::from(RATE_HZ));
            s.mid.iter().sum::<f32>()
        };
        let found: Vec<f32> = (0..2 * n).step_by(step).map(|at| loudness(at, &mut analyzer)).collect();
        let best = (0..found.len()).max_by(|&a, &b| found[a].total_cmp(&found[b])).unwrap();
        // The window that begins at `at` has its center half its length later.
        let late = (best * step) as f64 - 1.5 * n as f64;
        let lag = analyzer.lag_secs() * f64::from(RATE_HZ);
        assert!((late - lag).abs() <= 3.0 * step as f64, "decay {decay}: {late} frames, stated {lag}");
    }
}

#[test]
fn four_codecs_have_one_spectrum() {
    let Some(wav) = shared("audio/dubstep.wav") else { return };
    let spectra = |extension: &str| {
        let song = Song::read(
            &mut SongReader::open(&wav.with_extension(extension)).unwrap(),
            &Default::default(),
            &chladni_task::Task::new(),
        )
        .unwrap();
        let mut analyzer = SpectrumAnalyzer::new(plain(64)).unwrap();
        let n = analyzer.window_frames();
        let mut all = Vec::new();
        // The MP3 has no LAME tag and begins with its encoder's delay.
        let delay = if extension == "mp3" { 576 } else { 0 };
        for at in (delay..250_000).step_by(4410) {
            all.extend_from_slice(
                &analyzer.analyze(&song.left[at..at + n], &song.right[at..at + n], 0.1).mid,
            );
        }
        all
    };
    let truth = spectra("wav");
    let norm = truth.iter().map(|x| f64::from(x * x)).sum::<f64>();
    for (extension, most) in [("flac", 0.0), ("mp3", 0.05), ("ogg", 0.05)] {
        let other = spectra(extension);
        let off = truth.iter().zip(&other).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>();
        let relative = (off / norm).sqrt();
        eprintln!("{extension}: spectra differ by {relative:.4}");
        assert!(relative <= most, "{extension}: {relative}");
    }
}

/// Amplitudes of the bands nearest to some tones, after `secs` of these tones at automatic level.
fn leveled(settings: SpectrumSettings, tones: &[(f32, f32)], secs: f64, sides: [f32; 2]) -> [Vec<f32>; 2] {
    let mut analyzer = SpectrumAnalyzer::new(settings).unwrap();
    let n = analyzer.window_frames();
    let wave = |i: usize| {
        let phase = |hz: f32| f64::from(hz) * i as f64 / f64::from(RATE_HZ) * std::f64::consts::TAU;
        tones.iter().map(|&(hz, amplitude)| amplitude * phase(hz).sin() as f32).sum::<f32>()
    };
    let song: Vec<f32> = (0..(secs * f64::from(RATE_HZ)) as usize + n).map(wave).collect();
    let [left, right] = sides.map(|gain| song.iter().map(|x| gain * x).collect::<Vec<f32>>());
    for at in (0..song.len() - n).step_by(735) {
        analyzer.analyze(&left[at..at + n], &right[at..at + n], 735.0 / f64::from(RATE_HZ));
    }
    let near = |hz: f32| {
        let off = |b: &usize| (analyzer.bands_hz()[*b] / hz).ln().abs();
        (0..analyzer.bands_hz().len()).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap()
    };
    let s = analyzer.spectrum();
    [&s.mid, &s.side].map(|f| tones.iter().map(|&(hz, _)| f[near(hz)]).collect())
}

#[test]
fn soft_treble_moves_beside_loud_bass_and_hiss_does_not() {
    let tones = [(80.0, 0.5), (6000.0, 0.005), (12_000.0, 2e-6)];
    let [mid, _] = leveled(SpectrumSettings::new(RATE_HZ), &tones, 2.0, [1.0, 1.0]);
    assert!((0.85..=1.01).contains(&mid[0]), "{mid:?}");
    // 40 dB softer: a fifth of that remains, and the compression leaves 70 % of the fifth.
    assert!((-6.2..-5.0).contains(&(20.0 * (mid[1] / mid[0]).log10())), "{mid:?}");
    assert!(mid[2] < 0.05, "{mid:?}");
}

#[test]
fn the_side_has_a_level_of_its_own() {
    let most = |f: &[f32]| f.iter().copied().fold(0.0, f32::max);
    let hear = |sides| leveled(SpectrumSettings::new(RATE_HZ), &[(220.0, 0.5), (900.0, 0.2)], 2.0, sides);
    // A wide song: ten times its side would exceed full scale by a factor of ten.
    let [mid, side] = hear([1.0, -1.0]);
    assert!(most(&mid) < 0.01 && (0.85..=1.01).contains(&most(&side)), "{mid:?} {side:?}");
    // A narrow song: its side is 40 dB softer than its mid, of which 20 dB are compensated.
    let [mid, side] = hear([1.0, 0.98]);
    assert!((0.06..0.14).contains(&(most(&side) / most(&mid))), "{mid:?} {side:?}");
}

/// A song with passages of a tone, each with its own amplitude and duration in seconds.
fn passages(parts: &[(f32, f64)]) -> Song {
    let mut left = Vec::new();
    for (amplitude, secs) in parts {
        let begun = left.len();
        left.extend((0..(secs * f64::from(RATE_HZ)) as usize).map(|i| {
            let phase = std::f64::consts::TAU * 440.0 * (begun + i) as f64 / f64::from(RATE_HZ);
            amplitude * phase.sin() as f32
        }));
    }
    Song { rate_hz: RATE_HZ, right: left.clone(), left }
}

/// The amplitude of the loudest band at some times of a song, with its loud level known or learned.
fn loudest(song: Song, is_known: bool, at_secs: &[f64]) -> Vec<f32> {
    let loud = is_known.then(|| song.loud_level().unwrap());
    let settings = SpectrumSettings { loud, ..SpectrumSettings::new(RATE_HZ) };
    let mut ear = SongSpectrum::new(Arc::new(song), settings, 0.0).unwrap();
    at_secs.iter().map(|&secs| ear.at(secs).mid.iter().copied().fold(0.0, f32::max)).collect()
}

#[test]
fn the_noise_before_a_song_does_not_move_what_the_song_moves() {
    // 70 dB softer than the song but above the floor: only the known loud level shows that this is not
    // music.
    let song = passages(&[(1.5e-4, 3.0), (0.5, 5.0)]);
    let heard = loudest(song, true, &[1.5, 6.0]);
    assert!(heard[0] < 0.05 && heard[1] > 0.9, "{heard:?}");
}

#[test]
fn the_noise_of_sixteen_bits_alone_moves_nothing() {
    let mut state = 1u32;
    let mut dither = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        ((state >> 16) % 3) as f32 / 32_768.0 - 1.0 / 32_768.0
    };
    let left: Vec<f32> = (0..4 * RATE_HZ).map(|_| dither()).collect();
    let song = Song { rate_hz: RATE_HZ, right: left.clone(), left };
    for is_known in [true, false] {
        let heard = loudest(song.clone(), is_known, &[1.0, 3.0]);
        assert!(heard.iter().all(|loudest| *loudest < 0.1), "{heard:?}");
    }
}

#[test]
fn a_soft_passage_is_shown_softer_by_half_of_its_decibels() {
    let song = || passages(&[(0.5, 8.0), (0.05, 8.0), (0.5, 8.0)]);
    let db = |heard: &[f32], i: usize| 20.0 * (heard[i] / heard[0]).log10();
    let known = loudest(song(), true, &[6.0, 14.0, 22.0]);
    assert!((-10.5..-9.5).contains(&db(&known, 1)) && db(&known, 2).abs() < 0.2, "{known:?}");
    // If the level is learned, the loud passage is forgotten slowly.
    let learned = loudest(song(), false, &[6.0, 12.0, 15.9, 22.0]);
    assert!(db(&learned, 1) < -5.0 && db(&learned, 1) + 1.0 < db(&learned, 2), "{learned:?}");
    assert!(db(&learned, 3).abs() < 0.2, "{learned:?}");
    // A master that is 30 dB softer looks the same.
    let mut soft = song();
    soft.left.iter_mut().chain(&mut soft.right).for_each(|x| *x *= 0.03);
    let heard = loudest(soft, true, &[6.0, 14.0, 22.0]);
    assert!(heard.iter().zip(&known).all(|(a, b)| (a - b).abs() < 0.01), "{heard:?} {known:?}");
    assert_eq!(passages(&[(0.0, 2.0)]).loud_level().unwrap(), 0.0);
}
