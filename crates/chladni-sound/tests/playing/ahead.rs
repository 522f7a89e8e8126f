//! A picture that is seen late is drawn for a moment ahead of what is heard.

use chladni_sound::PlayerEvent;

use super::{paused_at, silent, wait, write_tone};

#[test]
fn the_moment_that_is_shown_lies_ahead_of_the_one_that_is_heard_or_behind_it() {
    let folder = tempfile::tempdir().unwrap();
    let song = write_tone(folder.path(), "tone.wav", 48_000, 10.0);
    let player = silent();
    player.play_list(vec![song]);
    wait("half a second", || player.status().position_secs > 0.5);
    let mut heard = paused_at(&player);
    wait("stillness", || std::mem::replace(&mut heard, player.status().position_secs) == heard);
    for ahead_secs in [0.1, -0.1, 0.5] {
        player.show_ahead(ahead_secs);
        let shown = player.status().position_secs;
        assert!((shown - heard - ahead_secs).abs() < 1e-6, "{heard} {shown}");
        let (mut left, mut right) = (vec![0.0; 2048], vec![0.0; 2048]);
        let at_secs = player.heard_window(1024, &mut left, &mut right);
        let worst = left.iter().enumerate().fold(0.0f64, |worst, (n, sample)| {
            let secs = at_secs + (n as f64 - 1024.0) / 48_000.0;
            worst.max((f64::from(*sample) - 0.5 * (std::f64::consts::TAU * 500.0 * secs).sin()).abs())
        });
        // The frame is a whole one; its time is not.
        assert!((at_secs - shown).abs() < 1e-9 && worst < 0.05, "{worst}");
    }
    player.show_ahead(f64::NAN);
    assert_eq!((player.shown_ahead_secs(), player.status().position_secs), (0.0, heard));
    player.show_ahead(9.0);
    assert_eq!(player.shown_ahead_secs(), chladni_sound::MOST_AHEAD_SECS);
}

#[test]
fn the_next_song_is_shown_before_it_is_heard_and_a_jump_is_not_foreseen() {
    let folder = tempfile::tempdir().unwrap();
    let songs = [("a.wav", 1.0), ("b.wav", 20.0)];
    let songs = songs.map(|(name, secs)| write_tone(folder.path(), name, 48_000, secs));
    let player = silent();
    player.show_ahead(0.3);
    player.play_list(songs.to_vec());
    wait("the second song", || player.status().song == 1);
    paused_at(&player);
    let ahead = player.status();
    player.show_ahead(0.0);
    let heard = player.status();
    // A busy machine may have gone on to the second song meanwhile.
    if heard.song == 0 {
        assert!(
            (ahead.position_secs - (heard.position_secs - 1.0 + 0.3)).abs() < 1e-6,
            "{ahead:?} {heard:?}"
        );
    }
    player.show_ahead(-0.3);
    // Still paused.
    player.events().for_each(drop);
    player.seek(0.25);
    wait("the jump", || player.events().any(|event| matches!(event, PlayerEvent::SongStarted(_))));
    assert_eq!(player.status().position_secs, 0.25);
    player.select(1);
    player.seek(19.8);
    player.play();
    wait("the end", || player.events().any(|event| event == PlayerEvent::Finished));
}
