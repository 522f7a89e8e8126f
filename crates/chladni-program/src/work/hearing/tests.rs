use super::*;
use crate::work::{Playing, ShowClock};
use chladni_music::Parameter;
use chladni_sound::{sample_tune, sample_tune_beats_secs};

pub(super) fn known() -> KnownSong {
    let beats = Beats { beats_secs: sample_tune_beats_secs(), confidence: 1.0, ..Beats::default() };
    KnownSong { beats: Some(beats), ..KnownSong::new(Arc::new(sample_tune())).unwrap() }
}

pub(super) fn stretch(at_secs: f64, song_secs: f64, playing: bool) -> Stretch {
    Stretch { at_secs, song: Some(0), song_secs, playing, crossfade_secs: 0.0 }
}

pub(super) fn hearing() -> Hearing {
    let mut hearing = Hearing::default();
    hearing.know(0, known());
    hearing.tune(0.0, &Parameters::default());
    hearing
}

#[test]
fn pausing_and_seeking_snap_nothing_and_beats_only_grow() {
    let mut hearing = hearing();
    // Plays, stands still, goes on, leaps ahead and far back.
    let script = [
        stretch(0.0, 2.0, true),
        stretch(1.5, 3.5, false),
        stretch(3.0, 3.5, true),
        stretch(4.0, 9.0, true),
        stretch(5.0, 0.5, true),
        stretch(5.1, 7.0, true),
    ];
    let mut script = script.into_iter().peekable();
    let (mut last, mut count) = (Vec::new(), 0.0);
    let (mut most, mut snap) = (0.0f32, 0.0f32);
    for frame in 0..1400 {
        let at_secs = f64::from(frame) / 200.0;
        let mut begins = false;
        while let Some(stretch) = script.next_if(|stretch| stretch.at_secs <= at_secs) {
            hearing.begin(stretch).unwrap();
            begins = true;
        }
        let heard = hearing.hear(at_secs).unwrap().unwrap();
        assert!(heard.beat.count >= count, "beat {} after {count}", heard.beat.count);
        count = heard.beat.count;
        let mid = heard.bands.mid.to_vec();
        let step = mid.iter().zip(&last).map(|(a, b): (&f32, &f32)| (a - b).abs()).fold(0.0, f32::max);
        if at_secs > 1.55 && at_secs < 3.0 {
            assert_eq!(step, 0.0, "the pose changes in a pause");
            assert!(mid.iter().any(|f| *f > 0.05) && heard.beat.confidence > 0.0, "it is let go");
        }
        let of = if begins && frame > 0 { &mut snap } else { &mut most };
        *of = of.max(step);
        last = mid;
    }
    assert!(snap <= most && most < 0.3, "{snap} at a leap, else {most}");
}

#[test]
fn a_pause_is_no_leap_however_many_beats_were_added() {
    const FRAME_SECS: f64 = 1.0 / 60.0;
    let (mut hearing, mut clock) = (hearing(), ShowClock::default());
    let mut now_secs = 0.0;
    for round in 0..40 {
        // Each round leaps back, plays, pauses and goes on.
        let mut position_secs = 2.0 + 0.0137 * f64::from(round);
        let mut paused_at = 0.0;
        for frame in 0..60 {
            now_secs += FRAME_SECS;
            let pauses = (25..45).contains(&frame);
            position_secs += if pauses { 0.0 } else { FRAME_SECS };
            let (song, duration_secs, crossfade_secs) = (Some(0), Some(100.0), 0.0);
            let playing = Playing { song, position_secs, duration_secs, crossfade_secs, is_over: false };
            if let Some(stretch) = clock.follow(now_secs, playing) {
                let before = hearing.beat_at(stretch.at_secs).count;
                hearing.begin(stretch).unwrap();
                let step = hearing.beat_at(stretch.at_secs).count - before;
                assert!(frame == 0 || step.abs() < 1e-9, "{step} beats in frame {frame} of round {round}");
            }
            let heard = hearing.hear(clock.at_secs()).unwrap().unwrap();
            if frame == 24 {
                paused_at = heard.beat.count;
            }
            assert!(frame < 24 || heard.fading.is_none(), "it fades in frame {frame} of round {round}");
            assert!(!pauses || (heard.beat.count - paused_at).abs() < 1e-9, "the beat goes on in a pause");
        }
    }
    assert!(hearing.stretches().filter(|stretch| !stretch.playing).count() == 40);
    assert!(hearing.beat_at(clock.at_secs()).count > 30.0);
}

#[test]
fn a_loop_has_its_own_number_of_beats() {
    /// Eight beats, and 6 ms more.
    const LOOP_SECS: f64 = 4.006;
    let mut hearing = Hearing::default();
    hearing.know(0, known());
    let beats_secs = (0..8).map(|i| 0.5 * f64::from(i)).collect();
    hearing.know_beats(0, Beats { beats_secs, confidence: 1.0, ..Beats::default() });
    for round in 0..4 {
        hearing.begin(stretch(LOOP_SECS * f64::from(round), 0.0, true)).unwrap();
    }
    let mut last = 1.0;
    for i in 0..1600 {
        let count = hearing.beat_at(0.01 * f64::from(i)).count;
        assert!((last..last + 0.05).contains(&count), "{count} after {last}");
        last = count;
    }
    let count = hearing.beat_at(3.0 * LOOP_SECS + 2.0).count;
    assert!((count - 29.0).abs() < 1e-9, "{count}");
}

#[test]
fn after_a_long_absence_the_ear_begins_anew_and_nothing_fades() {
    let (mut hearing, mut clock) = (hearing(), ShowClock::default());
    let look = |hearing: &mut Hearing, clock: &mut ShowClock, now_secs: f64| {
        let (song, position_secs, duration_secs) = (Some(0), 0.5 + now_secs, Some(100.0));
        let playing = Playing { song, position_secs, duration_secs, crossfade_secs: 0.0, is_over: false };
        let begun = clock.follow(now_secs, playing);
        let before = begun.map(|stretch| hearing.beat_at(stretch.at_secs).count);
        begun.into_iter().for_each(|stretch| hearing.begin(stretch).unwrap());
        let heard = hearing.hear(clock.at_secs()).unwrap().unwrap();
        assert!(heard.fading.is_none());
        (begun, heard.beat.count - before.unwrap_or_default())
    };
    look(&mut hearing, &mut clock, 0.0);
    assert_eq!(look(&mut hearing, &mut clock, 0.25).0, None);
    let (begun, step) = look(&mut hearing, &mut clock, 12.25);
    assert_eq!((hearing.from_song_secs, begun.map(|stretch| stretch.song_secs)), (12.75, Some(12.75)));
    assert!(step.abs() < 1e-9, "{step} beats");
}

#[test]
fn whoever_hears_the_same_show_hears_the_same_bits() {
    let mut parameters = Parameters::default();
    let run = |parameters: &mut Parameters, fps: f64, from_secs: f64| {
        *parameters = Parameters::default();
        let mut hearing = Hearing::from(from_secs);
        hearing.know(0, known());
        hearing.tune(0.0, parameters);
        let mut shots = Vec::new();
        let mut script = [stretch(0.0, 1.0, true), stretch(2.0, 3.0, false), stretch(2.5, 8.0, true)]
            .into_iter()
            .peekable();
        let mut turned = false;
        for frame in (from_secs * fps) as u32..(4.0 * fps) as u32 {
            let at_secs = f64::from(frame) / fps;
            while let Some(stretch) = script.next_if(|stretch| stretch.at_secs <= at_secs) {
                hearing.begin(stretch).unwrap();
            }
            if at_secs >= 3.0 && !turned {
                turned = true;
                parameters.set(Parameter::Decay, 0.8).unwrap();
                hearing.tune(2.9, parameters);
            }
            let heard = hearing.hear(at_secs).unwrap().unwrap();
            if at_secs.fract() == 0.5 || at_secs.fract() == 0.75 {
                shots.push((at_secs, heard.beat, heard.bands.mid.to_vec(), heard.bands.right.to_vec()));
            }
        }
        shots
    };
    let window = run(&mut parameters, 100.0, 0.0);
    assert_eq!(window.len(), 8);
    assert_eq!(window, run(&mut parameters, 8.0, 0.0));
    assert_eq!(window[4..], run(&mut parameters, 20.0, 2.25)[..]);
}

#[test]
fn what_is_not_known_is_not_heard() {
    let mut hearing = Hearing::default();
    hearing.tune(0.0, &Parameters::default());
    hearing.begin(stretch(0.0, 0.0, true)).unwrap();
    assert!(hearing.hear(1.0).unwrap().is_none());
    hearing.begin(Stretch { song: None, ..stretch(1.5, 0.0, true) }).unwrap();
    let heard = hearing.hear(2.0).unwrap().unwrap();
    assert!(heard.bands.mid.iter().all(|f| *f == 0.0));
    hearing.begin(stretch(2.5, 1.0, true)).unwrap();
    hearing.know(0, known());
    assert!(hearing.hear(3.0).unwrap().is_some());
}
