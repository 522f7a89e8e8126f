use super::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Sends ticks from `from_secs` on, each off by up to half of `jitter_secs`. Returns the exact time of the last one.
fn play(tempo: &mut Tempo, (from_secs, bpm, ticks): (f64, f64, u32), jitter_secs: f64, seed: u64) -> f64 {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let gap_secs = 60.0 / bpm / TICKS_PER_QUARTER;
    for tick in 0..ticks {
        let late_secs = jitter_secs * random.random_range(-0.5..0.5);
        tempo.hear(ClockMessage::Tick, from_secs + f64::from(tick) * gap_secs + late_secs);
    }
    from_secs + f64::from(ticks - 1) * gap_secs
}

#[test]
fn ticks_go_on_from_the_beat_that_runs_already() {
    // Taps, and two minutes later a clock that never said where it is; and one that was silent for 30 s before it
    // continues, stopped meanwhile or not.
    let begins: [(bool, &[ClockMessage]); 3] = [
        (false, &[]),
        (true, &[ClockMessage::Continue]),
        (true, &[ClockMessage::Stop, ClockMessage::Continue]),
    ];
    for (nth, (ticked, said)) in begins.into_iter().enumerate() {
        let mut tempo = Tempo::default();
        if ticked {
            play(&mut tempo, (0.0, 120.0, 193), 0.0, 0);
        } else {
            (0..8).for_each(|i| tempo.hear(ClockMessage::Beat { in_bar: None }, 0.5 * f64::from(i)));
        }
        let before = tempo.at(60.0).count;
        assert!(before > 100.0, "{nth}: {before}");
        said.iter().for_each(|message| tempo.hear(*message, 60.0));
        let at_secs = play(&mut tempo, (60.1, 120.0, 49), 0.0, 0);
        let gone = tempo.at(at_secs).count - before;
        assert!((gone - 2.2).abs() < 1.0, "{nth}: {gone}");
    }
}

#[test]
fn jitter_is_filtered() {
    for (seed, bpm) in [(1, 61.3), (2, 120.0), (3, 174.0)] {
        let mut tempo = Tempo::default();
        tempo.hear(ClockMessage::Start, 0.99);
        // 4 ms either way, a fifth to a half of a tick: the jitter of a busy computer.
        let at_secs = play(&mut tempo, (1.0, bpm, 24 * 16 + 1), 8e-3, seed);
        assert!((tempo.bpm().unwrap() / bpm - 1.0).abs() < 0.004, "{:?} {bpm}", tempo.bpm());
        let off_secs = (tempo.at(at_secs).count - 16.0) * 60.0 / bpm;
        assert!(off_secs.abs() < 2.5e-3, "{off_secs} s at {bpm}");
        // A change of tempo is followed within two quarters.
        let next_secs = at_secs + 60.0 / bpm / TICKS_PER_QUARTER;
        play(&mut tempo, (next_secs, 1.1 * bpm, 50), 8e-3, seed);
        assert!((tempo.bpm().unwrap() / bpm - 1.1).abs() < 0.006);
    }
}

#[test]
fn the_count_never_goes_back_and_stays_near_the_clock() {
    let mut tempo = Tempo::default();
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let (gap_secs, mut shown) = (0.5 / TICKS_PER_QUARTER, 0.0);
    for tick in 0..2000 {
        let exact_secs = f64::from(tick) * gap_secs;
        tempo.hear(ClockMessage::Tick, exact_secs + random.random_range(0.0..0.01));
        let count = tempo.at(exact_secs + 0.01).count;
        assert!(count >= shown);
        if tick > 60 {
            // On average a tick comes 5 ms late, and the count is read 10 ms after the exact time.
            let step = count - shown;
            assert!(step < 3.0 / TICKS_PER_QUARTER, "a step of {step}");
        }
        shown = count;
    }
    assert!((shown - 2000.0 / TICKS_PER_QUARTER).abs() < 1.1, "{shown}");
}

#[test]
fn start_stop_continue_and_song_position_lead_to_the_bar() {
    let mut tempo = Tempo::default();
    // The clock has been ticking for a while when the song starts.
    let last_secs = play(&mut tempo, (0.0, 120.0, 101), 0.0, 0);
    let before = tempo.at(last_secs).count;
    tempo.hear(ClockMessage::Start, last_secs + 0.005);
    let first_secs = last_secs + 0.5 / TICKS_PER_QUARTER;
    let at_secs = play(&mut tempo, (first_secs, 120.0, 24 * 6 + 1), 0.0, 0);
    let now = tempo.at(at_secs);
    assert!((now.count - now.count.round()).abs() < 1e-6 && now.confidence == 1.0, "{now:?}");
    assert!((now.count - before - 6.0).abs() <= 0.5 + 1.0 / TICKS_PER_QUARTER, "{before} {now:?}");
    assert_eq!(tempo.beat_in_bar(at_secs + 0.01), Some(3));
    let bar = tempo.bar(at_secs, 0.5, true).unwrap();
    let off_secs = [bar.at_secs - first_secs - 2.0, bar.secs - 2.0];
    assert!(off_secs.iter().all(|off| off.abs() < 1e-6), "{bar:?}");
    assert_eq!(tempo.bar(at_secs + 0.9, 0.5, true), None);
    assert!((tempo.bar(at_secs + 1.01, 0.5, false).unwrap().at_secs - at_secs - 1.0).abs() < 1e-6);
    // While stopped, the count stands still although the clock ticks.
    tempo.hear(ClockMessage::Stop, at_secs + 0.01);
    let still = tempo.at(at_secs + 0.02);
    let later_secs = play(&mut tempo, (at_secs + 0.02, 120.0, 100), 0.0, 0);
    assert_eq!((tempo.at(later_secs).count, still.confidence), (still.count, 0.0));
    assert_eq!(tempo.bar(later_secs, 0.5, false), None);
    // Continue from the third beat of a bar.
    tempo.hear(ClockMessage::Position { quarters: 10.0 }, later_secs + 0.001);
    assert_eq!(tempo.at(later_secs + 0.3).confidence, 0.0);
    tempo.hear(ClockMessage::Continue, later_secs + 0.002);
    let at_secs = play(&mut tempo, (later_secs + 0.1, 120.0, 25), 0.0, 0);
    assert_eq!(tempo.beat_in_bar(at_secs + 0.02), Some(4));
    assert!(tempo.at(at_secs).count >= still.count);
}

#[test]
fn it_goes_on_where_a_clock_falls_silent_and_meets_it_again() {
    let mut tempo = Tempo::default();
    let last_secs = play(&mut tempo, (0.0, 120.0, 24 * 8 + 1), 0.0, 0);
    let before = tempo.at(last_secs).count;
    assert!((tempo.at(last_secs + 10.1).count - before - 20.2).abs() < 1e-6);
    // The clock is heard again with the first tick after a beat.
    let again_secs = play(&mut tempo, (last_secs + 10.25, 120.0, 24 * 2 + 1), 0.0, 0);
    let count = tempo.at(again_secs).count;
    let off = count - count.round() - 1.0 / TICKS_PER_QUARTER;
    assert!((count - before - 22.5).abs() < 0.6 && off.abs() < 1e-6, "{count}");
}

#[test]
fn taps_and_osc_give_tempo_and_phase() {
    let mut tempo = Tempo::default();
    assert_eq!((tempo.at(1.0), tempo.bpm()), (Beat::default(), None));
    for (i, off_secs) in [0.01, -0.012, 0.004, 0.0, -0.007, 0.009].into_iter().enumerate() {
        tempo.hear(ClockMessage::Beat { in_bar: None }, 3.0 + 0.5 * i as f64 + off_secs);
    }
    assert!((tempo.bpm().unwrap() - 120.0).abs() < 2.0, "{:?}", tempo.bpm());
    let phase = tempo.at(5.75).count.fract();
    assert!((phase - 0.5).abs() < 0.03, "{phase}");
    tempo.hear(ClockMessage::Tempo { bpm: 90.0 }, 6.0);
    assert_eq!(tempo.bpm(), Some(90.0));
    tempo.hear(ClockMessage::Tempo { bpm: 1e9 }, 6.0);
    tempo.hear(ClockMessage::Tempo { bpm: f64::NAN }, 6.0);
    assert_eq!(tempo.bpm(), Some(90.0));
    tempo.hear(ClockMessage::Beat { in_bar: Some(2) }, 10.0);
    assert_eq!(tempo.beat_in_bar(10.01), Some(2));
}

#[test]
fn it_is_nudged_halved_doubled_and_locked() {
    let mut tempo = Tempo::default();
    tempo.set(100.0, 7.25, 7.0, 20.0);
    assert_eq!((tempo.at(20.0).count, tempo.bpm()), (7.25, Some(100.0)));
    tempo.nudge(0.06);
    assert!((tempo.at(20.0).count - 7.35).abs() < 1e-9);
    tempo.nudge(-0.06);
    tempo.double(20.6);
    assert_eq!(tempo.bpm(), Some(200.0));
    let begun = tempo.at(21.2).count;
    assert!((tempo.at(21.8).count - begun - 2.0).abs() < 1e-9);
    tempo.halve(22.0);
    tempo.halve(22.0);
    assert_eq!(tempo.bpm(), Some(50.0));
    assert!(tempo.at(22.0).count >= begun);
    tempo.lock(true);
    let locked = tempo.clone();
    tempo.hear(ClockMessage::Tempo { bpm: 150.0 }, 23.0);
    tempo.hear(ClockMessage::Start, 23.0);
    assert!(tempo == locked && tempo.is_locked());
}

#[test]
fn a_bar_does_not_begin_again_where_the_tempo_cannot_be_doubled_or_halved_further() {
    for change in [Tempo::double, Tempo::halve] {
        let mut tempo = Tempo::default();
        tempo.set(120.0, 0.0, 0.0, 10.0);
        (0..9).for_each(|_| change(&mut tempo, 10.0));
        assert!(tempo.bar(60.0, 0.5, false).is_some());
        let before = tempo.clone();
        change(&mut tempo, 60.0);
        assert!(tempo == before);
        assert_eq!(tempo.bar(60.0, 0.5, false), None);
    }
}

#[test]
fn a_bar_that_is_under_way_does_not_begin_where_a_clock_is_taken_up_or_its_tempo_doubled() {
    let mut taken_up = Tempo::default();
    taken_up.hear(ClockMessage::Tempo { bpm: 120.0 }, 10.0);
    let mut held = Tempo::default();
    // The bar of beat 21 is two beats old.
    held.set(120.0, 23.0, 21.0, 11.0);
    assert_eq!((held.at(11.0).count, held.bar_offset()), (23.0, 1.0));
    for mut tempo in [taken_up, held] {
        assert_eq!(tempo.bar(11.1, 0.5, false), None);
        assert!((tempo.bar(12.1, 0.5, false).unwrap().at_secs - 12.0).abs() < 1e-9);
        tempo.double(12.1);
        assert_eq!(tempo.bar(12.9, 0.5, false), None);
        assert!((tempo.bar(13.1, 0.5, false).unwrap().at_secs - 13.0).abs() < 1e-9);
    }
}

#[test]
fn a_bar_begins_where_another_beat_is_said_to_be_the_first() {
    for (at_secs, said, next_secs) in [(11.5, 1, 11.5), (10.6, 1, 10.6), (10.5, 3, 11.5)] {
        let mut tempo = Tempo::default();
        tempo.set(120.0, 0.0, 0.0, 10.0);
        tempo.hear(ClockMessage::Beat { in_bar: Some(said) }, at_secs);
        assert_eq!(tempo.bar(next_secs - 0.01, 0.5, false), None, "{said} at {at_secs}");
        assert!(tempo.bar(next_secs + 0.01, 0.5, false).is_some(), "{said} at {at_secs}");
    }
}

#[test]
fn a_bar_does_not_begin_again_where_its_first_beat_is_heard_late_at_twice_the_tempo() {
    let mut tempo = Tempo::default();
    tempo.set(60.0, 0.0, 0.0, 0.0);
    tempo.double(0.0);
    // Its bars take two seconds.
    assert!(tempo.bar(4.1, 0.5, false).is_some());
    tempo.hear(ClockMessage::Beat { in_bar: Some(1) }, 4.3);
    assert_eq!(tempo.bar(4.4, 0.5, false), None);
    assert!((tempo.bar(6.4, 0.5, false).unwrap().at_secs - 6.3).abs() < 1e-9);
}

#[test]
fn a_jump_begins_one_bar() {
    let two_bars = ClockMessage::Position { quarters: 8.0 };
    for (jump, octave) in [(ClockMessage::Start, 0), (two_bars, 0), (two_bars, 1), (two_bars, -1)] {
        let mut tempo = Tempo::default();
        tempo.set(60.0, 0.0, 0.0, 0.0);
        tempo.change_octave(octave, 0.0);
        assert!(tempo.bar(10.0, 0.5, false).is_some());
        tempo.hear(jump, 10.5);
        // The next frame may still show what lies before the message.
        assert_eq!(tempo.bar(10.49, 0.5, false), None, "{jump:?} {octave}");
        let bar = tempo.bar(10.51, 0.5, false).unwrap();
        assert!((bar.at_secs - 10.5).abs() < 1e-9, "{jump:?} {octave}: {bar:?}");
        assert_eq!(tempo.bar(10.53, 0.5, false), None, "{jump:?} {octave}");
    }
}

#[test]
fn lost_ticks_are_counted() {
    let gap_secs = 0.5 / TICKS_PER_QUARTER;
    // Few are lost, or so many that the clock seems to have been silent.
    for lost in [1u32, 7, 31, 1000] {
        let mut tempo = Tempo::default();
        tempo.hear(ClockMessage::Start, -0.01);
        let last_secs = play(&mut tempo, (0.0, 120.0, 24 * 8 + 1), 0.0, 0);
        tempo.hear(ClockMessage::Lost { ticks: lost }, last_secs + 0.001);
        assert!((tempo.bpm().unwrap() - 120.0).abs() < 1e-6 && tempo.is_known());
        // Also with the first tick alone, before its line is known.
        let again_secs = last_secs + f64::from(lost + 1) * gap_secs;
        for ticks in [1, 40] {
            let mut tempo = tempo.clone();
            let at_secs = play(&mut tempo, (again_secs, 120.0, ticks), 0.0, 0);
            let beats = tempo.at(at_secs).count - f64::from(24 * 8 + lost + ticks) / TICKS_PER_QUARTER;
            assert!((beats - beats.round()).abs() < 1e-6, "{beats} after {lost} lost");
            assert!((tempo.bpm().unwrap() - 120.0).abs() < 1e-6, "{:?}", tempo.bpm());
        }
    }
    // While the clock stands still, ticks do not move the song.
    let mut tempo = Tempo::default();
    let last_secs = play(&mut tempo, (0.0, 120.0, 49), 0.0, 0);
    tempo.hear(ClockMessage::Stop, last_secs + 0.01);
    let still = tempo.at(last_secs + 0.02);
    tempo.hear(ClockMessage::Lost { ticks: 5 }, last_secs + 0.03);
    tempo.hear(ClockMessage::Tick, last_secs + 0.2);
    assert_eq!(tempo.at(last_secs + 0.3), still);
}

#[test]
fn a_beat_without_a_place_in_its_bar_is_the_first() {
    let mut tempo = Tempo::default();
    tempo.set(120.0, 0.0, 0.0, 10.0);
    tempo.hear(ClockMessage::Beat { in_bar: Some(0) }, 11.0);
    assert_eq!(tempo.beat_in_bar(11.01), Some(1));
}

#[test]
fn a_clock_that_was_stopped_goes_on_from_where_it_stood() {
    let mut stopped = Tempo::default();
    stopped.set(120.0, 3.25, 3.0, 0.0);
    stopped.hear(ClockMessage::Stop, 10.0);
    let still = stopped.at(10.0).count;
    assert!((still - 23.25).abs() < 1e-9, "{still}");
    let in_bar = stopped.beat_in_bar(10.0);
    // Whatever comes while it stands; taps may move it to a whole beat.
    type Comes<'a> = &'a dyn Fn(&mut Tempo);
    let meanwhile: [(&str, Comes<'_>, f64); 5] = [
        ("nothing", &|_| {}, 1e-9),
        ("a tempo", &|tempo| tempo.hear(ClockMessage::Tempo { bpm: 125.0 }, 15.0), 1e-9),
        ("a beat", &|tempo| tempo.hear(ClockMessage::Beat { in_bar: None }, 15.2), 0.5),
        (
            "taps",
            &|tempo| {
                (0..6)
                    .for_each(|i| tempo.hear(ClockMessage::Beat { in_bar: None }, 13.1 + 0.6 * f64::from(i)));
            },
            0.5,
        ),
        (
            "twice as fast and back",
            &|tempo| {
                tempo.double(13.0);
                tempo.halve(17.0);
            },
            1.5,
        ),
    ];
    for (name, comes, off) in meanwhile {
        let mut tempo = stopped.clone();
        comes(&mut tempo);
        let now = tempo.at(19.0);
        assert!((now.count - still).abs() <= off && now.confidence == 0.0, "{name}: {now:?} after {still}");
        assert!(off > 1e-9 || tempo.beat_in_bar(19.0) == in_bar, "{name}");
        tempo.hear(ClockMessage::Continue, 20.0);
        let next = tempo.at(20.01);
        assert!(
            (next.count - now.count).abs() < 0.6 && next.confidence == 1.0,
            "{name}: {next:?} after {now:?}"
        );
        // And it does go on.
        let [before, after] = [22.0, 24.0].map(|secs| tempo.at(secs).count);
        let gone = after - before;
        let beats = 2.0 * tempo.bpm().unwrap() / 60.0;
        assert!((gone - beats).abs() < 1e-6, "{name}: {gone} beats");
    }
    let mut tempo = stopped;
    tempo.hear(ClockMessage::Continue, 20.0);
    assert!((tempo.at(20.01).count - still).abs() < 0.1);
}

/// Hears these beats of a bar, which come at these times in seconds.
fn beats(said: impl IntoIterator<Item = (f64, u32)>) -> Tempo {
    let mut tempo = Tempo::default();
    for (secs, beat) in said {
        tempo.hear(ClockMessage::Beat { in_bar: Some(beat) }, 10.0 + secs);
    }
    tempo
}

#[test]
fn beats_that_come_twice_or_not_at_all_leave_tempo_and_place() {
    let beat = |i: u32| (0.5 * f64::from(i), 1 + i % 4);
    // Every bar begins with a message of its own, as it is sent here.
    let doubled = (0..24).flat_map(|i| std::iter::repeat_n(beat(i), if i % 4 == 0 { 2 } else { 1 }));
    let bars = (0..24).step_by(4).map(beat);
    let one_lost = (0..24).filter(|i| *i != 21).map(beat);
    let bar_lost = (0..24).step_by(4).filter(|i| *i != 12).map(beat);
    for (name, mut tempo) in [
        ("doubled", beats(doubled)),
        ("bars alone", beats(bars)),
        ("one lost", beats(one_lost)),
        ("a bar lost", beats(bar_lost)),
    ] {
        let bpm = tempo.bpm().unwrap();
        assert!((bpm - 120.0).abs() < 1.0, "{name}: {bpm}");
        // Number 22 was the third of its bar.
        assert_eq!(tempo.beat_in_bar(10.0 + 11.01), Some(3), "{name}");
        let count = tempo.at(10.0 + 11.0).count;
        assert!((count - count.round()).abs() < 0.02, "{name}: {count}");
    }
    // Also where the second message comes a little later, and does not say which beat it is.
    let mut tempo = Tempo::default();
    for i in 0..24 {
        let at_secs = 0.5 * f64::from(i);
        if i % 4 == 0 {
            tempo.hear(ClockMessage::Beat { in_bar: Some(1) }, at_secs);
        }
        tempo.hear(ClockMessage::Beat { in_bar: None }, at_secs + 2e-3);
    }
    assert!((tempo.bpm().unwrap() - 120.0).abs() < 1.0, "{:?}", tempo.bpm());
    assert_eq!(tempo.beat_in_bar(11.52), Some(4));
}

#[test]
fn a_steady_beat_whose_bar_is_counted_anew_keeps_its_tempo() {
    let mut tempo = Tempo::default();
    tempo.hear(ClockMessage::Tempo { bpm: 120.0 }, 10.0);
    for (i, beat) in [1, 2, 3, 4, 1, 2, 3, 1, 2, 3, 4, 1].into_iter().enumerate() {
        tempo.hear(ClockMessage::Beat { in_bar: Some(beat) }, 10.0 + 0.5 * i as f64);
        assert!((tempo.bpm().unwrap() - 120.0).abs() < 1e-6, "{:?} at number {i}", tempo.bpm());
    }
    assert_eq!(tempo.beat_in_bar(15.51), Some(1));
}

#[test]
fn beats_of_a_bar_that_are_much_slower_are_followed() {
    // All four beats, and bars alone.
    for (every, [before_bpm, after_bpm]) in [(1, [180.0, 45.0]), (4, [120.0, 68.0])] {
        let beat = |i: u32| {
            let (before, after) = (f64::from(i.min(16)), f64::from(i.saturating_sub(16)));
            (60.0 * (before / before_bpm + after / after_bpm), 1 + i % 4)
        };
        let bpm = beats((0..64).step_by(every).map(beat)).bpm().unwrap();
        assert!((bpm - after_bpm).abs() < 0.1, "every {every}: {bpm}");
    }
}

#[test]
fn taps_that_are_much_slower_are_followed() {
    let mut tempo = Tempo::default();
    tempo.set(120.0, 0.0, 0.0, 10.0);
    (0..9).for_each(|i| tempo.hear(ClockMessage::Beat { in_bar: None }, 12.0 + 0.8 * f64::from(i)));
    assert!((tempo.bpm().unwrap() - 75.0).abs() < 0.1, "{:?}", tempo.bpm());
}
