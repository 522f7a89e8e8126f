//! The player in silence and, if PulseAudio is installed, through a real sink.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

mod ahead;
mod gapless;
mod jumps;
mod sinks;

use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use chladni_sound::{
    HeardTo, MIN_RATE_HZ, Player, PlayerEvent, PlayerSettings, PlayerState, Repeat, Song, WavSample,
    write_wav,
};
use chladni_testdata::HANGS;

fn silent() -> Player {
    Player::start(PlayerSettings { audible: false, ..PlayerSettings::default() }).unwrap()
}

fn write_tone(folder: &Path, name: &str, rate_hz: u32, secs: f64) -> PathBuf {
    let path = folder.join(name);
    let tone: Vec<f32> = (0..(secs * f64::from(rate_hz)) as usize)
        .map(|n| 0.5 * (std::f32::consts::TAU * 500.0 * n as f32 / rate_hz as f32).sin())
        .collect();
    let song = Song { rate_hz, right: tone.iter().map(|x| -x).collect(), left: tone };
    write_wav(&path, &song, WavSample::Int16).unwrap();
    path
}

/// A song that does not end while a test is held up, of the lowest rate that is read: its file is small.
fn write_endless(folder: &Path) -> PathBuf {
    write_tone(folder, "endless.wav", MIN_RATE_HZ, HANGS.as_secs_f64())
}

fn wait(what: &str, mut done: impl FnMut() -> bool) {
    let end = Instant::now() + HANGS;
    while !done() {
        assert!(Instant::now() < end, "waited {HANGS:?} for {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// What is heard of a player.
struct Ear {
    from: Option<HeardTo>,
    left: Vec<f32>,
    right: Vec<f32>,
}

impl Ear {
    /// From now on.
    fn new(player: &Player) -> Self {
        let mut ear = Self { from: None, left: Vec::new(), right: Vec::new() };
        ear.hear(player);
        ear
    }

    fn hear(&mut self, player: &Player) {
        player.take_heard(&mut self.from, &mut self.left, &mut self.right);
    }

    /// Until the list has ended; `each` looks at the player meanwhile.
    fn hear_to_the_end(&mut self, player: &Player, mut each: impl FnMut(&Player)) {
        wait("the end", || {
            self.hear(player);
            each(player);
            player.events().any(|event| event == PlayerEvent::Finished)
        });
        self.hear(player);
    }
}

/// All that is heard of `songs`, from the first frame on; `each` looks at the player meanwhile.
fn heard(player: &Player, songs: Vec<PathBuf>, each: impl FnMut(&Player)) -> [Vec<f32>; 2] {
    let mut ear = Ear::new(player);
    player.play_list(songs);
    ear.hear_to_the_end(player, each);
    [ear.left, ear.right]
}

/// The longest that a thread was kept waiting for a processor while `work` ran.
fn longest_wait<T>(work: impl FnOnce() -> T) -> (Duration, T) {
    const NAP: Duration = Duration::from_millis(1);
    let (done, is_done) = channel::<()>();
    std::thread::scope(|scope| {
        let watch = scope.spawn(move || {
            let mut longest = Duration::ZERO;
            loop {
                let began = Instant::now();
                if is_done.recv_timeout(NAP) != Err(RecvTimeoutError::Timeout) {
                    return longest;
                }
                longest = longest.max(began.elapsed().saturating_sub(NAP));
            }
        });
        let result = work();
        drop(done);
        (watch.join().unwrap(), result)
    })
}

/// Playback through a device follows the wall clock: attempts count during which the machine kept nobody waiting, and one
/// of four must succeed. Where twelve attempts have no such four, the test is skipped.
#[allow(clippy::print_stdout, reason = "a skipped test must say so")]
fn undisturbed(mut measure: impl FnMut() -> Result<(), String>) {
    let mut reports = Vec::new();
    for _ in 0..12 {
        let (waited, measured) = longest_wait(&mut measure);
        let Err(report) = measured else { return };
        if waited < Duration::from_millis(10) {
            reports.push(report);
        }
        assert!(reports.len() < 4, "never right: {reports:#?}");
    }
    println!("skipped: the machine is busy");
}

/// Pauses a player whose song is far from its end; the position, which stands still from now on.
fn paused_at(player: &Player) -> f64 {
    player.pause();
    wait("the pause", || player.status().state == PlayerState::Paused);
    player.status().position_secs
}

#[test]
fn time_passes_in_silence_and_obeys() {
    let folder = tempfile::tempdir().unwrap();
    let player = silent();
    player.play_list(vec![write_endless(folder.path())]);
    wait("the first sample", || player.status().position_secs > 0.0);
    wait("half a second more", || player.status().position_secs > 0.5);
    assert_eq!(player.status().state, PlayerState::Playing);
    assert_eq!(player.status().device, None);

    paused_at(&player);
    // What the engine took in its last round may still be on its way; then it stands still, over many rounds.
    let mut still = (player.status().position_secs, 0);
    wait("that time stands still", || {
        let now = player.status().position_secs;
        still = if now == still.0 { (now, still.1 + 1) } else { (now, 0) };
        still.1 == 50
    });

    player.seek(20.0);
    wait("the seek", || (player.status().position_secs - 20.0).abs() < 0.05);
    player.play();
    wait("going on", || player.status().position_secs > 20.1);
    assert_eq!(player.status().duration_secs, Some(HANGS.as_secs_f64()));
}

#[test]
fn the_window_shows_the_samples_that_are_heard() {
    let folder = tempfile::tempdir().unwrap();
    // Of whole swings, it goes on through its end.
    let song = write_tone(folder.path(), "tone.wav", 44_100, 10.0);
    let player = silent();
    player.repeat(Repeat::Song);
    player.play_list(vec![song]);
    wait("half a second", || player.status().position_secs > 0.5);
    // Where the player was held up, what comes next is not decoded for a moment; after a pause it is.
    paused_at(&player);
    let (mut left, mut right) = (vec![0.0; 2048], vec![0.0; 2048]);
    let secs = player.heard_window(1024, &mut left, &mut right);
    let rate_hz = f64::from(player.status().rate_hz);
    // Sample i lies (i − 1024) / rate after the position: the tone's phase tells.
    let worst = left.iter().zip(&right).enumerate().fold(0.0f64, |worst, (i, (l, r))| {
        let t = secs + (i as f64 - 1024.0) / rate_hz;
        let truth = 0.5 * (std::f64::consts::TAU * 500.0 * t).sin();
        worst.max((f64::from(*l) - truth).abs()).max((f64::from(*r) + truth).abs())
    });
    assert!(worst < 0.05, "{worst}");
}

#[test]
fn a_device_that_is_not_there_is_reported_each_time_one_is_chosen() {
    let settings = PlayerSettings { device: Some("nowhere".into()), ..PlayerSettings::default() };
    let player = Player::start(settings).unwrap();
    let is_lost = || player.events().any(|event| matches!(event, PlayerEvent::DeviceLost(_)));
    wait("the first report", is_lost);
    player.set_device(Some("nor there".into()));
    wait("the second one", is_lost);
}

#[test]
fn a_playlist_goes_on_over_a_broken_song_and_ends() {
    let folder = tempfile::tempdir().unwrap();
    let broken = folder.path().join("broken.mp3");
    std::fs::write(&broken, b"no music").unwrap();
    let songs = vec![
        write_tone(folder.path(), "a.wav", 44_100, 0.4),
        broken,
        write_tone(folder.path(), "c.wav", 22_050, 0.4),
    ];
    let player = silent();
    player.play_list(songs);
    let mut events = Vec::new();
    wait("the end", || {
        events.extend(player.events());
        events.contains(&PlayerEvent::Finished)
    });
    assert!(
        matches!(
            &events[..],
            [
                PlayerEvent::SongStarted(0),
                PlayerEvent::SongFailed { song: 1, .. },
                PlayerEvent::SongStarted(2),
                PlayerEvent::Finished
            ]
        ),
        "{events:?}"
    );
    assert_eq!((player.status().state, player.status().is_over), (PlayerState::Stopped, true));
    player.repeat(Repeat::List);
    player.play();
    wait("playing again", || player.status().state == PlayerState::Playing);
    assert!(!player.status().is_over);
    // A song that is left in the middle is not heard to its end. Repeating is turned off only now: the list before would
    // have ended by itself.
    player.play_list(vec![write_tone(folder.path(), "long.wav", 22_050, 60.0)]);
    player.repeat(Repeat::Off);
    player.next(true);
    wait("the end of the list", || player.status().state == PlayerState::Stopped);
    assert!(!player.status().is_over);
}

/// Writes a level on one side only, which says at every sample how loud its song is.
fn write_level(folder: &Path, name: &str, is_left: bool, secs: f64) -> PathBuf {
    let path = folder.join(name);
    let (level, silence) = (vec![0.5; (48_000.0 * secs) as usize], vec![0.0; (48_000.0 * secs) as usize]);
    let (left, right) = if is_left { (level, silence) } else { (silence, level) };
    write_wav(&path, &Song { rate_hz: 48_000, left, right }, WavSample::Float32).unwrap();
    path
}

#[test]
fn one_song_fades_into_the_next() {
    let folder = tempfile::tempdir().unwrap();
    let songs = [("a.wav", true, 2.0), ("b.wav", false, 2.5), ("c.wav", true, 0.6), ("d.wav", false, 1.0)];
    let songs = songs.map(|(name, is_left, secs)| write_level(folder.path(), name, is_left, secs));
    let player = silent();
    player.set_crossfade_secs(1.0);
    player.pause();
    let mut fades = Vec::new();
    let [left, right] = heard(&player, songs[..2].to_vec(), |player| {
        let status = player.status();
        fades.push((status.song, status.crossfade_secs));
    });
    fades.dedup();
    assert!(fades.ends_with(&[(0, 0.0), (1, 1.0)]), "{fades:?}");
    assert!((3.0..=3.5).contains(&(left.len() as f64 / 48_000.0)), "{}", left.len());
    let power = left.iter().zip(&right).map(|(l, r)| l * l + r * r);
    let worst = power.map(|power| (power - 0.25).abs()).fold(0.0, f32::max);
    assert!(worst < 1e-5, "{worst}");
    let middle = left.len() - 2 * 48_000;
    assert!(
        (left[middle] - right[middle]).abs() < 1e-3,
        "they are equally loud where the second one is heard"
    );
    assert!(left[middle - 24_000..middle + 24_000].is_sorted_by(|one, next| one >= next));

    // Songs that are shorter than two crossfades, and one that cannot be played, at the end, too.
    let broken = folder.path().join("broken.mp3");
    std::fs::write(&broken, b"no music").unwrap();
    let [a, _, c, d] = songs;
    player.play_list(vec![a, c, broken.clone(), d, broken]);
    let mut events = Vec::new();
    wait("the end", || {
        events.extend(player.events());
        events.contains(&PlayerEvent::Finished)
    });
    let started = |song| events.contains(&PlayerEvent::SongStarted(song));
    assert!([0, 1, 3].into_iter().all(started), "{events:?}");
}

#[test]
fn between_long_songs_a_short_one_fades_over_half_of_it_at_most() {
    let folder = tempfile::tempdir().unwrap();
    let songs = [("a.wav", true, 1.0), ("b.wav", false, 0.3), ("c.wav", true, 1.0)];
    let songs = songs.map(|(name, is_left, secs)| write_level(folder.path(), name, is_left, secs));
    let player = silent();
    player.set_crossfade_secs(1.0);
    player.pause();
    let [left, right] = heard(&player, songs.to_vec(), |_| ());
    assert!((1.5..=2.0).contains(&(left.len() as f64 / 48_000.0)), "{}", left.len());
    // The long ones are on one side: together they would be louder.
    let worst = left.iter().zip(&right).map(|(l, r)| (l * l + r * r - 0.25).abs()).fold(0.0, f32::max);
    assert!(worst < 1e-5, "{worst}");
}

#[test]
fn a_song_of_one_sample_that_repeats_leaves_the_player_time_to_obey() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("one.wav");
    let song = Song { rate_hz: 44_100, left: vec![0.5], right: vec![0.5] };
    write_wav(&path, &song, WavSample::Int16).unwrap();
    let player = silent();
    player.repeat(Repeat::List);
    player.play_list(vec![path]);
    let mut started = 0;
    wait("many rounds", || {
        started += player.events().count();
        started > 100
    });
    paused_at(&player);
    // Dropped, it waits for its thread, which obeys in the midst of them, too.
    player.play();
    drop(player);
}

#[test]
fn a_pause_after_the_last_sample_was_decoded_goes_on_where_it_began() {
    let folder = tempfile::tempdir().unwrap();
    // All of the song is decoded ahead of the device at once.
    let song = write_tone(folder.path(), "short.wav", 48_000, 0.35);
    let player = silent();
    // On a busy machine it may have ended before the pause: it begins again.
    let paused = loop {
        player.play_list(vec![song.clone()]);
        wait("a tenth of a second", || {
            let status = player.status();
            status.is_listed && status.position_secs > 0.1
        });
        player.pause();
        wait("the pause", || player.status().state != PlayerState::Playing);
        let status = player.status();
        if status.state == PlayerState::Paused {
            break status.position_secs;
        }
        wait("the end", || player.events().any(|event| event == PlayerEvent::Finished));
    };
    assert!((0.1..0.35).contains(&paused), "{paused}");
    player.play();
    wait("going on", || player.status().state != PlayerState::Paused);
    assert!(player.status().position_secs >= paused - 0.001, "{}", player.status().position_secs);
    let mut events = Vec::new();
    wait("the end", || {
        events.extend(player.events());
        events.contains(&PlayerEvent::Finished)
    });
    assert_eq!(events, [PlayerEvent::SongStarted(0), PlayerEvent::Finished]);
}

#[test]
fn a_paused_player_goes_to_other_songs_and_stays_paused_until_one_is_to_play() {
    let folder = tempfile::tempdir().unwrap();
    let player = silent();
    player.play_list(vec![write_endless(folder.path()); 3]);
    wait("the first song", || player.status().state == PlayerState::Playing);
    paused_at(&player);
    let begins = |song: usize| {
        wait("that song", || player.events().any(|event| event == PlayerEvent::SongStarted(song)));
    };
    begins(0);
    player.next(false);
    begins(1);
    player.next(false);
    begins(2);
    player.previous(false);
    begins(1);
    let status = player.status();
    assert_eq!((status.state, status.song), (PlayerState::Paused, 1));
    assert!(status.position_secs < 0.05, "{status:?}");
    player.next(true);
    wait("that it plays", || player.status().state == PlayerState::Playing);
}

#[test]
fn the_list_changes_around_the_song_that_plays() {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (write_tone(folder.path(), "a.wav", 44_100, 20.0), write_endless(folder.path()));
    let c_secs = HANGS.as_secs_f64() - 1.0;
    let c = write_tone(folder.path(), "c.wav", MIN_RATE_HZ, c_secs);
    let player = silent();
    player.play_list(vec![a.clone(), b.clone()]);
    player.select(1);
    wait("the second song", || player.status().song == 1 && player.status().position_secs > 0.3);
    player.set_songs(vec![b.clone(), c.clone(), a]);
    wait("its new number", || player.status().song == 0);
    assert!(player.status().position_secs > 0.3, "the song went on");
    let asked = Instant::now();
    player.set_songs(vec![c]);
    wait("the song in its place", || player.status().duration_secs == Some(c_secs));
    let place = player.status().position_secs;
    assert!(place <= asked.elapsed().as_secs_f64() + 0.001, "it begins at its beginning: {place}");
    wait("that it plays", || player.status().state == PlayerState::Playing);
    player.set_songs(Vec::new());
    wait("silence", || player.status().state == PlayerState::Stopped);
    player.set_songs(vec![b]);
    player.play();
    wait("a song again", || player.status().state == PlayerState::Playing);
}
