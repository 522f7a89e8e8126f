//! Beat tracking of files and songs whose beats are known.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

mod songs;

use chladni_sound::{
    BeatFollower, Song, TUNE_BPM, beat_score, sample_tune, sample_tune_beats_secs, track_beats,
    track_beats_causally,
};
use chladni_task::Task;
use chladni_testdata::shared;

fn truth(name: &str) -> Option<Vec<f64>> {
    let text = std::fs::read_to_string(shared(&format!("audio/{name}"))?).unwrap();
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    Some(lines.filter_map(|line| line.split_whitespace().next()?.parse().ok()).collect())
}

#[test]
fn files_with_known_beats() {
    let listed = [
        ("impulses_1second_44100_st.wav", "impulses.beats.txt", 0.95),
        ("impulses_1second_48000_st.mp3", "impulses.beats.txt", 0.95),
        ("impulses_1second_22050_st.ogg", "impulses.beats.txt", 0.95),
        ("techno_loop.mp3", "techno_loop.beats.txt", 0.95),
        ("Chord_Detection_Test.flac", "Chord_Detection_Test.beats.txt", 0.9),
        ("sample.wav", "sample.beats", 0.7),
    ];
    for (name, beats, least) in listed {
        let (Some(path), Some(truth)) = (shared(&format!("audio/{name}")), truth(beats)) else { return };
        let found = track_beats(&Song::open(&path).unwrap(), &Task::new()).unwrap();
        let score = beat_score(&found.beats_secs, &truth, 0.07);
        let true_bpm = 60.0 * (truth.len() - 1) as f64 / (truth[truth.len() - 1] - truth[0]);
        eprintln!("{name}: {score:?}, {} bpm, confidence {}", found.tempo_bpm, found.confidence);
        assert!(score.f_measure >= least, "{name}: {score:?}");
        assert!((found.tempo_bpm / true_bpm - 1.0).abs() < 0.02, "{name}: {} bpm", found.tempo_bpm);
    }
}

#[test]
fn our_own_tune_is_followed_exactly() {
    let (tune, truth) = (sample_tune(), sample_tune_beats_secs());
    let found = track_beats(&tune, &Task::new()).unwrap();
    let score = beat_score(&found.beats_secs, &truth, 0.07);
    assert!(score.f_measure > 0.95, "{score:?}");
    assert!((found.tempo_bpm / TUNE_BPM - 1.0).abs() < 0.01, "{}", found.tempo_bpm);
    let heard = track_beats_causally(&tune, &Task::new()).unwrap();
    let later = |beats: &[f64]| beats.iter().copied().filter(|b| *b > 5.0).collect::<Vec<_>>();
    let score = beat_score(&later(&heard.beats_secs), &later(&truth), 0.07);
    assert!(score.f_measure > 0.9, "while listening: {score:?}");
}

#[test]
fn many_manners_and_tempi() {
    let mut sum = 0.0;
    let made = songs::songs();
    for made in &made {
        let found = track_beats(&made.song, &Task::new()).unwrap();
        let score = beat_score(&found.beats_secs, &made.beats_secs, 0.07);
        eprintln!("{}: {:.1} bpm, F {:.3}", made.name, found.tempo_bpm, score.f_measure);
        sum += score.f_measure;
    }
    let mean = sum / made.len() as f64;
    assert!(mean > 0.97, "mean F-measure {mean}");
}

#[test]
fn a_listener_does_not_know_what_comes() {
    let tune = sample_tune();
    let cut = 10 * tune.rate_hz as usize;
    let mut half = tune.clone();
    half.left[cut..].fill(0.0);
    half.right[cut..].reverse();
    let beats = |song: &Song| {
        let all = track_beats_causally(song, &Task::new()).unwrap().beats_secs;
        all.into_iter().filter(|b| *b <= 10.0).collect::<Vec<_>>()
    };
    let known = beats(&tune);
    assert!(known.len() > 12);
    assert_eq!(known, beats(&half));
}

#[test]
fn beats_and_bars_do_not_depend_on_how_much_sound_comes_at_once() {
    let tune = sample_tune();
    let frames = tune.frames().min(25 * tune.rate_hz as usize);
    let heard = |block: usize| {
        let mut follower = BeatFollower::new(tune.rate_hz).unwrap();
        let (mut beats, mut bars) = (Vec::new(), Vec::new());
        for (left, right) in tune.left[..frames].chunks(block).zip(tune.right[..frames].chunks(block)) {
            follower.push(left, right);
            beats.extend(std::iter::from_fn(|| follower.take_beat()));
            bars.extend(std::iter::from_fn(|| follower.take_bar()));
        }
        (beats, bars)
    };
    let block = tune.rate_hz as usize / 100;
    let (beats, bars) = heard(block);
    assert!(beats.len() > 12 && bars.len() > 2, "{} beats, {} bars", beats.len(), bars.len());
    // Frames of 250 ms and of 2 s.
    for blocks in [25, 200] {
        assert!(heard(blocks * block) == (beats.clone(), bars.clone()), "{blocks} blocks at once");
    }
}

#[test]
fn noise_before_a_song_and_silence_behind_it_change_no_beat() {
    let tune = sample_tune();
    let rate = tune.rate_hz as usize;
    let mut state = 1u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (f64::from(state) / f64::from(u32::MAX) - 0.5) as f32 / 500.0
    };
    let before: Vec<f32> = (0..30 * rate).map(|_| noise()).collect();
    let around = |channel: &[f32]| [&before[..], channel, &vec![0.0; 60 * rate]].concat();
    let song = Song { rate_hz: tune.rate_hz, left: around(&tune.left), right: around(&tune.right) };
    let found = track_beats(&song, &Task::new()).unwrap();
    let truth: Vec<f64> = sample_tune_beats_secs().iter().map(|secs| secs + 30.0).collect();
    let score = beat_score(&found.beats_secs, &truth, 0.07);
    assert!(score.f_measure > 0.9, "{score:?}");
    assert!(found.beats_secs.iter().all(|secs| (27.9..30.1 + tune.duration_secs()).contains(secs)));
    assert!((found.tempo_bpm / TUNE_BPM - 1.0).abs() < 0.01, "{}", found.tempo_bpm);
}

/// A click every half second for 12 s, a silence, and clicks again, the first of them at once.
fn clicks_around_silence(silent_secs: usize, secs_after: usize) -> Song {
    let rate = 44_100;
    let click = |n: usize| if n >= 441 { 0.0 } else { 0.8 - 1.6 * (n % 2) as f32 };
    let clicks = |secs: usize| (0..secs * rate).map(move |n| click(n % (rate / 2)));
    let silence = std::iter::repeat_n(0.0, silent_secs * rate);
    let channel: Vec<f32> = clicks(12).chain(silence).chain(clicks(secs_after)).collect();
    Song { rate_hz: rate as u32, left: channel.clone(), right: channel }
}

#[test]
fn a_beat_that_is_heard_goes_on_through_a_break_and_ends_in_a_long_silence() {
    let beats = |song: &Song| track_beats_causally(song, &Task::new()).unwrap().beats_secs;
    let off = |secs: f64| (2.0 * secs - (2.0 * secs).round()).abs() / 2.0;
    let before = beats(&clicks_around_silence(20, 0));
    let silent: Vec<f64> = before.iter().copied().filter(|secs| *secs > 12.0).collect();
    assert!(silent.len() > 4 && silent.iter().all(|secs| off(*secs) < 0.07), "the tempo goes on: {silent:?}");
    assert!(silent.iter().all(|secs| *secs < 17.0), "then nothing is announced: {silent:?}");
    let around = beats(&clicks_around_silence(2, 4));
    let heard: Vec<f64> = around.into_iter().filter(|secs| *secs > 11.8).collect();
    assert!((12..=13).contains(&heard.len()), "{heard:?}");
    assert!(heard.iter().all(|secs| off(*secs) < 0.07), "in step at once: {heard:?}");
}

#[test]
fn taps_in_a_long_silence_are_beats() {
    let song = clicks_around_silence(12, 0);
    let mut follower = BeatFollower::new(song.rate_hz).unwrap();
    let mut tapped = 0;
    for (piece, block) in song.left.chunks(4410).enumerate() {
        follower.push(block, block);
        let beats = std::iter::from_fn(|| follower.take_beat()).count();
        match piece {
            190..200 => assert_eq!(beats, 0, "after {piece} tenths"),
            200.. => tapped += beats,
            _ => {}
        }
        if piece >= 200 && piece % 6 == 2 {
            follower.tap(follower.now_secs());
        }
    }
    assert!((5..=8).contains(&tapped), "{tapped} beats of 7 taps");
}

#[test]
fn silence_behind_a_song_does_not_change_the_confidence_of_a_listener() {
    let confidence = |silent_secs: usize| {
        track_beats_causally(&clicks_around_silence(silent_secs, 0), &Task::new()).unwrap().confidence
    };
    let alone = confidence(0);
    assert!(alone > 0.5, "{alone}");
    for silent_secs in [5, 10] {
        assert!((confidence(silent_secs) - alone).abs() < 0.1, "{alone} and {}", confidence(silent_secs));
    }
}

#[test]
fn nothing_has_no_beat() {
    let silence = Song { rate_hz: 44_100, left: vec![0.0; 200_000], right: vec![0.0; 200_000] };
    let empty = Song { rate_hz: 44_100, left: Vec::new(), right: Vec::new() };
    for song in [&silence, &empty] {
        let found = track_beats(song, &Task::new()).unwrap();
        assert!(found.beats_secs.is_empty() && found.tempo_bpm == 0.0 && found.confidence == 0.0);
        assert!(track_beats_causally(song, &Task::new()).unwrap().beats_secs.is_empty());
    }
}

#[test]
fn taps_halving_and_doubling_are_obeyed() {
    let mut follower = BeatFollower::new(44_100).unwrap();
    let silence = vec![0.0; 4410];
    for step in 0..40 {
        follower.push(&silence, &silence);
        // Four taps at 100 beats per minute.
        if step % 6 == 5 && step < 30 {
            follower.tap(follower.now_secs());
        }
    }
    let moment = follower.moment();
    assert!((moment.tempo_bpm - 100.0).abs() < 3.0, "{moment:?}");
    // The last tap was at 3.0 s; a beat must be at 4.2 s.
    let off = (follower.moment_at(4.2).phase + 0.5).fract() - 0.5;
    assert!(off.abs() < 0.12, "{off}");
    follower.double();
    assert!((follower.moment().tempo_bpm - 200.0).abs() < 6.0);
    follower.halve();
    follower.halve();
    assert!((follower.moment().tempo_bpm - 50.0).abs() < 1.5);
    // A tap after a pause says where a beat is, and no tempo.
    (0..30).for_each(|_| follower.push(&silence, &silence));
    let before_bpm = follower.moment().tempo_bpm;
    follower.tap(follower.now_secs());
    assert_eq!(follower.moment().tempo_bpm, before_bpm);
}

#[test]
fn taps_faster_or_slower_than_all_tracked_tempi_are_obeyed() {
    let silence = vec![0.0; 4410];
    let tapped = |steps: usize| {
        let mut follower = BeatFollower::new(44_100).unwrap();
        for step in 1..=6 * steps {
            follower.push(&silence, &silence);
            if step % steps == 0 {
                follower.tap(follower.now_secs());
            }
        }
        follower
    };
    for steps in [2, 18] {
        let follower = tapped(steps);
        let (gap_secs, tap_secs) = (0.1 * steps as f64, follower.now_secs());
        let bpm = follower.moment().tempo_bpm;
        assert!((bpm * gap_secs / 60.0 - 1.0).abs() < 0.03, "{bpm} bpm of taps each {gap_secs} s");
        // The tap is a beat, and what is tracked between two taps is none.
        for share in [0.0, 0.5, 1.0] {
            let phase = follower.moment_at(tap_secs + share * gap_secs).phase;
            let off = (phase - share + 1.5).fract() - 0.5;
            assert!(off.abs() < 0.12, "{phase} after {share} of {gap_secs} s");
        }
    }
    // A key that bounces says no tempo.
    let mut follower = BeatFollower::new(44_100).unwrap();
    follower.push(&silence, &silence);
    (0..3).for_each(|_| follower.tap(follower.now_secs()));
    assert!(follower.moment().tempo_bpm < 230.0, "{:?}", follower.moment());
}

#[test]
fn a_key_that_bounces_takes_no_tempo_away() {
    let mut follower = BeatFollower::new(44_100).unwrap();
    let mut step = 0_usize;
    // 10 ms at a time of a click every half second.
    let mut listen = |follower: &mut BeatFollower, steps: usize| {
        for _ in 0..steps {
            let mut block = vec![0.0; 441];
            if step.is_multiple_of(50) {
                block.iter_mut().enumerate().for_each(|(n, x)| *x = if n % 2 == 0 { 0.8 } else { -0.8 });
            }
            follower.push(&block, &block);
            step += 1;
        }
    };
    listen(&mut follower, 1200);
    for after in [0, 3, 47] {
        listen(&mut follower, after);
        follower.tap(follower.now_secs());
        let bpm = follower.moment().tempo_bpm;
        assert!((bpm - 120.0).abs() < 5.0, "{bpm} after {after} steps");
    }
}

#[test]
fn beats_at_half_the_speed_take_twice_as_long() {
    let rate_hz = 44_100;
    let mut follower = BeatFollower::new(rate_hz).unwrap();
    // 10 ms at a time of a click every half second.
    let hear = |follower: &mut BeatFollower, step: usize| {
        let mut block = vec![0.0; 441];
        if step.is_multiple_of(50) {
            block.iter_mut().enumerate().for_each(|(n, x)| *x = if n % 2 == 0 { 0.8 } else { -0.8 });
        }
        follower.push(&block, &block);
        (std::iter::from_fn(|| follower.take_beat()).count(), follower.moment())
    };
    let mut step = 0;
    let mut listen = |follower: &mut BeatFollower, secs: usize| {
        let (mut beats, mut restarts, mut highest, mut last) = (0, 0, 0.0_f64, 0.0);
        for _ in 0..100 * secs {
            let (count, moment) = hear(follower, step);
            step += 1;
            beats += count;
            restarts += usize::from(moment.phase < last - 0.4);
            (highest, last) = (highest.max(moment.phase), moment.phase);
        }
        (beats, restarts, highest, follower.moment().tempo_bpm)
    };
    listen(&mut follower, 10);
    let (beats, restarts, highest, bpm) = listen(&mut follower, 12);
    assert!((bpm - 120.0).abs() < 3.0 && beats.abs_diff(24) <= 1, "{beats} beats at {bpm}");
    assert!(restarts.abs_diff(24) <= 1 && highest > 0.9, "{restarts} {highest}");
    for (expected_bpm, expected) in [(60.0, 12), (30.0, 6)] {
        follower.halve();
        listen(&mut follower, 8);
        let (beats, restarts, highest, bpm) = listen(&mut follower, 12);
        assert!((bpm - expected_bpm).abs() < 2.0 && beats.abs_diff(expected) <= 1, "{beats} beats at {bpm}");
        assert!(restarts.abs_diff(expected) <= 1 && highest > 0.9, "{restarts} {highest} at {bpm}");
    }
}

#[test]
fn bars_and_sections_of_songs_with_a_known_form() {
    let found_at =
        |found: &[f64], truth: &[f64], window_secs: f64| beat_score(found, truth, window_secs).f_measure;
    let formed = songs::formed();
    let (mut sums, count) = ([0.0; 3], formed.len() as f64);
    for formed in &formed {
        let song = &formed.made.song;
        let found = track_beats(song, &Task::new()).unwrap();
        let heard = track_beats_causally(song, &Task::new()).unwrap();
        let bars =
            |beats: &chladni_sound::Beats| beats.bars.iter().map(|bar| bar.at_secs).collect::<Vec<_>>();
        let sections: Vec<f64> = found.sections.iter().map(|section| section.at_secs).collect();
        let bar_secs = formed.downbeats_secs[1] - formed.downbeats_secs[0];
        let scores = [
            found_at(&bars(&found), &formed.downbeats_secs, 0.07),
            // A section found one bar early or late still counts.
            found_at(&sections, &formed.sections_secs, 1.01 * bar_secs),
            found_at(&bars(&heard), &formed.downbeats_secs, 0.07),
        ];
        let names: String = found.sections.iter().map(|section| section.name).collect();
        let beats = beat_score(&found.beats_secs, &formed.made.beats_secs, 0.07).f_measure;
        eprintln!(
            "{}: beats {beats:.2}, bars, sections, bars listening {scores:.2?}, form {names}",
            formed.made.name
        );
        eprintln!("    {sections:.1?} for {:.1?}", formed.sections_secs);
        sums.iter_mut().zip(scores).for_each(|(sum, score)| *sum += score / count);
        assert!(found.energy.iter().all(|energy| (0.0..=1.0).contains(energy)));
        assert!(found.bars.iter().all(|bar| found.beats_secs.contains(&bar.at_secs)));
    }
    eprintln!("means {sums:.3?}");
    assert!(sums[0] > 0.75 && sums[1] > 0.75 && sums[2] > 0.5, "{sums:?}");
}
