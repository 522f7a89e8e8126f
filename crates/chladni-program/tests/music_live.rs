//! The music room on live input: sound comes in, the beat is found, the shape moves; and whatever
//! comes in, the window never flashes more than three times a second.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]
#![allow(dead_code, reason = "each test program uses a part of the driving")]

mod driving;

use std::f32::consts::TAU;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use chladni_mesh::{samples, save_mesh};
use chladni_music::{FlashCount, Histogram, MAX_FLASHES, Show, Veil, most_flashes_per_second};
use chladni_program::studio::{Folders, Opening};
use chladni_sound::{Capture, CaptureFeed};
use driving::{Answers, Window, control, no_time, open_with, shows, wait};
use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, Pos2, Rect, ViewportCommand};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

const RATE_HZ: u32 = 44_100;

/// The music room with a ball and live input, `fps` steps a second by the window's clock.
struct Evening {
    window: Window,
    feed: CaptureFeed,
    fps: u32,
    heard: usize,
    answers: Answers,
    _folder: tempfile::TempDir,
}

impl Evening {
    fn begin(fps: u32, settings: &str, actions: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        // It is drawn quickly.
        save_mesh(&samples::icosphere(3), &path("ball.obj")).unwrap();
        std::fs::write(path("settings.toml"), format!("harmonics = 24\n{settings}")).unwrap();
        let session = format!("format_version = 1\nseed = 5\nsize = 6\n{actions}");
        std::fs::write(path("session.toml"), session).unwrap();
        let files = vec![path("ball.obj"), path("session.toml")];
        let (input, feed) = Capture::fed(RATE_HZ).unwrap();
        let folders = Folders { settings: Some(path("settings.toml")), ..Folders::default() };
        let answers = Answers::default();
        let chooser = Box::new(answers.clone());
        let opening =
            Opening { folders, files, chooser, input: Some(input), now: no_time, ..Opening::default() };
        let builder = Harness::builder().with_size([640.0, 640.0]).with_step_dt(1.0 / fps as f32);
        let mut window = open_with(opening, builder);
        // The sample that opens meanwhile has twelve items; the stage has no top bar.
        wait(&mut window, "the ball", |w| shows(w, "6 items") || !shows(w, "Chladni"));
        window.run_steps(3);
        Self { window, feed, fps, heard: 0, answers, _folder: folder }
    }

    /// Saves the show, and reads it.
    fn save_show(&mut self) -> (PathBuf, Show) {
        let path = self._folder.path().join("set.toml");
        self.answers.add(&path);
        self.window.key_press_modifiers(Modifiers::COMMAND, Key::S);
        wait(&mut self.window, "the show", |_| path.exists());
        let show = Show::load(&path).unwrap();
        (path, show)
    }

    /// One step, with what `sound` says of each sample since the last one.
    fn step(&mut self, sound: impl Fn(usize) -> f32) {
        let count = (RATE_HZ / self.fps) as usize;
        let samples: Vec<f32> = (self.heard..self.heard + count).map(sound).collect();
        self.heard += count;
        self.feed.push(&samples, &samples);
        self.window.run_steps(1);
    }

    /// Begins to record the set.
    fn record(&mut self) -> PathBuf {
        let path = self._folder.path().join("set.mp4");
        self.answers.add(&path);
        // A picture is there once its brightness is known.
        (0..10).for_each(|_| self.step(kick));
        // The second window may lie over it.
        control(&self.window, "file").click_accesskit();
        self.window.run_steps(2);
        control(&self.window, "file/record").click_accesskit();
        self.window.run_steps(1);
        path
    }

    fn end_recording(&mut self) {
        control(&self.window, "recording-end").click_accesskit();
        wait(&mut self.window, "the recording", |w| shows(w, "Recorded"));
    }

    /// Width and height of a short recording.
    fn recorded_size(&mut self) -> String {
        let film = self.record();
        (0..20).for_each(|_| self.step(kick));
        self.end_recording();
        let size = ["-v", "error", "-show_entries", "stream=width,height", "-of", "csv=p=0"];
        let probe = Command::new("ffprobe").args(size).arg(&film).output().unwrap();
        String::from_utf8(probe.stdout).unwrap()
    }

    /// All pixels of a part of the window.
    fn seen(&mut self, part: Rect) -> Histogram {
        let picture = self.window.render().unwrap();
        let part = part.intersect(Rect::from_min_max(Pos2::ZERO, Pos2::new(640.0, 640.0))).round();
        let [left, top] = [part.left(), part.top()].map(|edge| edge as u32);
        let size = [part.width(), part.height()].map(|side| side as u32);
        let mut histogram = Histogram::default();
        for (x, y, pixel) in picture.enumerate_pixels().filter(|(x, y, _)| *x >= left && *y >= top) {
            histogram.add([x - left, y - top], size, [pixel[0], pixel[1], pixel[2]]);
        }
        histogram
    }

    /// Whether a part of the window holds more red than blue.
    fn is_red(&mut self, part: Rect) -> bool {
        let picture = self.window.render().unwrap();
        let inside = |x: u32, y: u32| part.contains(Pos2::new(x as f32, y as f32));
        let (mut red, mut blue) = (0, 0);
        for (_, _, pixel) in picture.enumerate_pixels().filter(|(x, y, _)| inside(*x, *y)) {
            (red, blue) = (red + u64::from(pixel[0]), blue + u64::from(pixel[2]));
        }
        red > blue
    }

    /// Puts the picture `next` behind the dances in place of the one called `name`, and waits until a part of the window is
    /// red, or no longer. It is read on a thread: meanwhile the window's clock stands, so that on any machine each picture is
    /// seen for as long.
    fn put_behind(&mut self, name: &str, next: &Path, (part, is_red): (Rect, bool)) {
        let now_secs = self.window.ctx.input(|input| input.time);
        self.window.input_mut().time = Some(now_secs);
        self.answers.add(next);
        self.window.get_by_role_and_label(Role::Button, name).click_accesskit();
        self.window.run_steps(1);
        let began = Instant::now();
        while self.is_red(part) != is_red {
            assert!(began.elapsed() < chladni_testdata::HANGS, "{} is not seen", next.display());
            std::thread::sleep(Duration::from_millis(5));
            self.window.run_steps(1);
        }
        self.window.input_mut().time = None;
    }

    /// What is counted, in a part of the window, of `steps` steps, each of which begins with `act`.
    fn counted(&mut self, part: Rect, steps: usize, mut act: impl FnMut(&mut Self, usize)) -> FlashCount {
        let mut count = FlashCount::default();
        for step in 0..steps {
            act(self, step);
            let time_secs = self.window.ctx.input(|input| input.time);
            count.note(time_secs, &self.seen(part), Veil::Clear);
        }
        count
    }

    /// Flashes in the worst second of `steps` steps, each of which begins with `act`, of the mean of the window. Its panels
    /// are judged in no other way.
    fn mean_flashes(&mut self, steps: usize, mut act: impl FnMut(&mut Self, usize)) -> usize {
        let (mut times_secs, mut luminances) = (Vec::new(), Vec::new());
        for step in 0..steps {
            act(self, step);
            times_secs.push(self.window.ctx.input(|input| input.time));
            luminances.push(self.seen(Rect::EVERYTHING).luminance(Veil::Clear));
        }
        most_flashes_per_second(&times_secs, &luminances)
    }
}

/// Noise that is on and off five times a second.
fn strobe(sample: usize) -> f32 {
    let noise = (sample as u32).wrapping_mul(2_654_435_761).rotate_left(13).wrapping_mul(1_664_525);
    let on = (sample * 10 / RATE_HZ as usize).is_multiple_of(2);
    if on { noise as f32 / u32::MAX as f32 * 1.8 - 0.9 } else { 0.0 }
}

/// A kick drum, twice a second.
fn kick(sample: usize) -> f32 {
    let t = sample as f32 / RATE_HZ as f32 % 0.5;
    0.8 * (-18.0 * t).exp() * (TAU * 60.0 * t + 4.0 * (1.0 - (-40.0 * t).exp())).sin()
}

#[test]
fn what_comes_in_finds_the_beat_and_moves_the_shape() {
    let mut evening = Evening::begin(10, "", "");
    // So narrow a window has no room for the input's name.
    assert!(shows(&evening.window, "Live"));
    // The left half of the shapes: no panel, no meter.
    let shot = |evening: &mut Evening, sound: fn(usize) -> f32| {
        evening.step(sound);
        let picture = evening.window.render().unwrap();
        let stride = 4 * picture.width() as usize;
        let rows = picture.into_raw();
        rows.chunks(stride).skip(150).take(250).flat_map(|row| row[..1200].to_vec()).collect::<Vec<u8>>()
    };
    // A picture is shown once the device has said how bright it is: on a busy machine some steps later.
    let mut still = shot(&mut evening, |_| 0.0);
    let rests = (0..40).any(|_| {
        let next = shot(&mut evening, |_| 0.0);
        std::mem::replace(&mut still, next.clone()) == next
    });
    assert!(rests, "it moves in silence");
    for _ in 0..60 {
        evening.step(kick);
    }
    assert!(shows(&evening.window, "120 BPM"), "another tempo");
    assert!((0..4).any(|_| shot(&mut evening, kick) != still), "it stands still");
    driving::screenshot(&mut evening.window, "window-music-live.png");
}

fn action(text: &str) -> String {
    format!("[[actions]]\nat_secs = 0.0\nat_beat = 0.0\n{text}\n")
}

fn limit(on: bool) -> String {
    action(&format!("do = \"switch\"\nswitch = \"flash-limit\"\non = {on}"))
}

/// Flashes without the limiter and with it, of an evening that `count` counts.
fn free_and_limited(fps: u32, settings: &str, session: &str, count: impl Fn(&mut Evening) -> usize) {
    let [free, limited] =
        [false, true].map(|on| count(&mut Evening::begin(fps, settings, &format!("{session}{}", limit(on)))));
    assert!(free > MAX_FLASHES, "nothing flashes: {free}");
    assert!(limited <= MAX_FLASHES, "{limited} flashes a second, {free} without the limit");
}

/// A ball on stage that a strobe blows up.
fn strobing_session() -> String {
    // All sound goes to the harmonics that blow the ball up, without decay.
    let mapping =
        "{ transfer = [0.0435, 0.087, 0.1305], amplification = [1.0], stereo_mu = 0.0, gain = 1.0 }";
    [
        &format!("do = \"load\"\nitem = 0\nname = \"strobe\"\nmapping = {mapping}"),
        "do = \"set\"\nparameter = \"decay\"\nvalue = 0.0",
        "do = \"set\"\nparameter = \"limit\"\nvalue = 0.5",
        "do = \"set\"\nparameter = \"gain\"\nvalue = 8.0",
        "do = \"perform\"\nitem = 0",
    ]
    .map(action)
    .concat()
}

const DARK_ON_WHITE: &str = "[music]\nmaterial = \"dark\"\nbackground = \"white\"\n";

#[test]
fn a_strobing_track_on_stage_never_flashes_more_than_three_times_a_second() {
    free_and_limited(30, DARK_ON_WHITE, &strobing_session(), |evening| {
        assert!(!shows(&evening.window, "6 items"), "not on stage");
        let count = evening.counted(Rect::EVERYTHING, 45, |evening, _| evening.step(strobe));
        driving::screenshot(&mut evening.window, "window-music-strobe.png");
        count.most_per_second()
    });
}

/// Its recording shows the picture alone; tests draw the second window into the first.
#[test]
fn nor_does_it_in_a_window_of_its_own() {
    if !chladni_view::ffmpeg_is_there() {
        return println!("skipped: no ffmpeg");
    }
    let look = format!("{DARK_ON_WHITE}own_window = true\n");
    free_and_limited(30, &look, &strobing_session(), |evening| {
        assert!(shows(&evening.window, "On stage"));
        let film = evening.record();
        (0..45).for_each(|_| evening.step(strobe));
        evening.end_recording();
        let scale = ["-vf", "scale=96:64:flags=area", "-pix_fmt", "rgb24", "-f", "rawvideo", "-"];
        let decoded = Command::new("ffmpeg").args(["-v", "error", "-i"]).arg(&film).args(scale).output();
        let bytes = decoded.unwrap().stdout;
        let (mut count, mut histogram) = (FlashCount::default(), Histogram::default());
        for (frame, pixels) in bytes.chunks_exact(3 * 96 * 64).enumerate() {
            histogram.clear();
            for (rgb, i) in pixels.as_chunks().0.iter().zip(0..) {
                histogram.add([i % 96, i / 96], [96, 64], *rgb);
            }
            count.note(frame as f64 / 30.0, &histogram, Veil::Clear);
        }
        count.most_per_second()
    });
}

#[test]
fn bars_behind_a_stage_are_darkened_within_half_a_second() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bars.png");
    let bars = image::RgbImage::from_fn(640, 640, |x, _| image::Rgb([if x % 20 < 10 { 245 } else { 0 }; 3]));
    bars.save(&path).unwrap();
    let settings = format!("[music]\nbackground = \"night\"\npicture = '{}'\n", path.display());
    let [free, limited] = [false, true].map(|on| {
        let session = format!("{}{}", action("do = \"perform\"\nitem = 0"), limit(on));
        let mut evening = Evening::begin(10, &settings, &session);
        assert!(!shows(&evening.window, "6 items"), "not on stage");
        // They are read beside the window.
        wait(&mut evening.window, "the bars", |w| !driving::is_busy(w));
        evening.counted(Rect::EVERYTHING, 30, |evening, _| {
            std::thread::sleep(Duration::from_millis(5));
            evening.step(|_| 0.0);
        })
    });
    assert!(free.longest_stripes_secs() > 1.0, "no bars are seen");
    let (secs, flashes) = (limited.longest_stripes_secs(), limited.most_per_second());
    assert!(secs < 0.5 && flashes <= MAX_FLASHES, "{secs} s, {flashes} flashes");
}

#[test]
fn nor_does_a_background_that_changes_all_the_time() {
    free_and_limited(60, "", "", |evening| {
        control(&evening.window, "drawer/look").click();
        evening.window.run_steps(2);
        let part = control(&evening.window, "dance/1").rect();
        let count = evening.counted(part, 24, |evening, step| {
            let background = if step % 2 == 0 { "background/white" } else { "background/night" };
            control(&evening.window, background).click();
            evening.step(|_| 0.0);
        });
        count.most_per_second()
    });
}

#[test]
fn nor_does_red_that_keeps_its_luminance() {
    let folder = tempfile::tempdir().unwrap();
    // Both have a relative luminance of 0.07.
    let pictures = [("blue.png", [0, 0, 255]), ("red.png", [156, 0, 0])].map(|(name, color)| {
        image::RgbImage::from_pixel(64, 64, image::Rgb(color)).save(folder.path().join(name)).unwrap();
        name
    });
    let first = folder.path().join(pictures[1]);
    let look = format!("[music]\nlook = \"\"\nmaterial = \"dark\"\npicture = '{}'\n", first.display());
    free_and_limited(30, &look, "", |evening| {
        control(&evening.window, "drawer/look").click();
        evening.window.run_steps(2);
        let part = control(&evening.window, "dance/1").rect();
        let (mut times_secs, mut luminances, mut count) = (Vec::new(), Vec::new(), FlashCount::default());
        // Ten changes a second.
        for change in 0..15 {
            let [next, shown] = [change % 2, (change + 1) % 2];
            let is_red = next == 1;
            evening.put_behind(pictures[shown], &folder.path().join(pictures[next]), (part, is_red));
            for _ in 0..3 {
                evening.step(|_| 0.0);
                let (time_secs, seen) = (evening.window.ctx.input(|input| input.time), evening.seen(part));
                times_secs.push(time_secs);
                luminances.push(seen.luminance(Veil::Clear));
                count.note(time_secs, &seen, Veil::Clear);
            }
        }
        assert_eq!(most_flashes_per_second(&times_secs, &luminances), 0, "not only red changes");
        count.most_per_second()
    });
}

#[test]
fn nor_does_a_stage_that_opens_and_closes_all_the_time() {
    free_and_limited(60, "light = true\n", "", |evening| {
        evening.window.event(Event::PointerMoved(Pos2::new(100.0, 200.0)));
        evening.window.run_steps(3);
        evening.mean_flashes(24, |evening, step| {
            evening.window.key_press(if step % 2 == 0 { Key::S } else { Key::Escape });
            evening.step(|_| 0.0);
        })
    });
}

#[test]
fn the_stage_fills_the_chosen_screen_and_gives_it_back() {
    let asked = |evening: &Evening| -> Vec<ViewportCommand> {
        let outputs = evening.window.output().viewport_output.values();
        outputs.flat_map(|output| output.commands.clone()).collect()
    };
    for (screen, command) in
        [("{ monitor = 1 }", ViewportCommand::SetMonitor(1)), ("\"full\"", ViewportCommand::Fullscreen(true))]
    {
        let mut evening = Evening::begin(10, &format!("[music]\nscreen = {screen}\n"), "");
        evening.window.event(Event::PointerMoved(Pos2::new(100.0, 200.0)));
        evening.window.run_steps(3);
        let mut seen = Vec::new();
        // The other room does not stay on that screen, and the stage fills it again.
        let (none, other_room) = (Modifiers::NONE, (Modifiers::CTRL, Key::Tab));
        for (modifiers, key) in [(none, Key::S), other_room, other_room, (none, Key::Escape)] {
            let event = |pressed| Event::Key { key, physical_key: None, pressed, repeat: false, modifiers };
            evening.window.event(event(true));
            for step in 0..4 {
                if step == 1 {
                    evening.window.event(event(false));
                }
                evening.window.run_steps(1);
                seen.extend(asked(&evening));
            }
        }
        let back = ViewportCommand::Fullscreen(false);
        seen.retain(|sent| *sent == command || *sent == back);
        assert_eq!(seen, [command.clone(), back.clone(), command, back], "{screen}");
    }
}

#[test]
fn the_set_is_recorded_with_its_sound_while_it_is_played() {
    if !chladni_view::ffmpeg_is_there() {
        return println!("skipped: no ffmpeg");
    }
    let mut evening = Evening::begin(20, "", "");
    let path = evening.record();
    for step in 0..60 {
        evening.step(kick);
        if step == 30 {
            // The stage fills the window: the picture has another size.
            evening.window.event(Event::PointerMoved(Pos2::new(100.0, 200.0)));
            evening.window.run_steps(3);
            evening.window.key_press(Key::S);
        }
    }
    evening.window.key_press(Key::Escape);
    evening.window.run_steps(20);
    evening.end_recording();
    let probe = Command::new("ffprobe")
        .args(["-v", "error", "-count_frames", "-show_entries", "stream=codec_type,duration,nb_read_frames"])
        .args(["-of", "csv=p=0"])
        .arg(&path)
        .output()
        .unwrap();
    let probed = String::from_utf8(probe.stdout).unwrap();
    let of = |kind: &str| -> Vec<f64> {
        let line = probed.lines().find(|line| line.starts_with(kind)).unwrap();
        line.split(',').skip(1).filter_map(|number| number.parse().ok()).collect()
    };
    let (video, audio) = (of("video"), of("audio"));
    // Some 80 steps of a twentieth of a second.
    assert!((3.5..5.0).contains(&video[0]) && (video[0] - audio[0]).abs() < 0.1, "{probed}");
    assert!((video[1] - 30.0 * video[0]).abs() < 1.5, "{probed}");
    let song = chladni_sound::Song::open(&path).unwrap();
    let loudest = song.left.iter().fold(0.0f32, |most, sample| most.max(sample.abs()));
    assert!(loudest > 0.4, "{loudest}");
}

/// The frames of a film in gray, 64×64 each.
fn gray_frames(film: &Path) -> Vec<Vec<u8>> {
    let scale = ["-vf", "scale=64:64", "-pix_fmt", "gray", "-f", "rawvideo", "-"];
    let frames = Command::new("ffmpeg").args(["-v", "error", "-i"]).arg(film).args(scale).output().unwrap();
    frames.stdout.chunks_exact(64 * 64).map(<[u8]>::to_vec).collect()
}

#[test]
fn a_frozen_stage_that_goes_black_is_black_in_the_recording_too() {
    if !chladni_view::ffmpeg_is_there() {
        return println!("skipped: no ffmpeg");
    }
    let mut evening = Evening::begin(20, "[music]\nlook = \"\"\nbackground = \"white\"\n", "");
    let film = evening.record();
    evening.window.event(Event::PointerMoved(Pos2::new(100.0, 200.0)));
    evening.window.run_steps(3);
    for key in [Key::S, Key::X, Key::B] {
        evening.window.key_press(key);
        (0..30).for_each(|_| evening.step(kick));
        assert!(!shows(&evening.window, "6 items"), "not on stage");
    }
    // What was black is light again only after the stage is left.
    evening.window.key_press(Key::Escape);
    evening.window.run_steps(1);
    evening.end_recording();
    let mean = |frame: &Vec<u8>| frame.iter().map(|&level| f32::from(level)).sum::<f32>() / 4096.0;
    let means: Vec<f32> = gray_frames(&film).iter().map(mean).collect();
    let (first, darkest) = (means[0], means.iter().fold(f32::INFINITY, |least, mean| least.min(*mean)));
    assert!(first > 100.0 && darkest < 20.0, "{means:?}");
}

#[test]
fn the_harmonics_are_in_the_recording_while_they_are_shown() {
    if !chladni_view::ffmpeg_is_there() {
        return println!("skipped: no ffmpeg");
    }
    let mut evening = Evening::begin(20, "[music]\nlook = \"\"\nbackground = \"white\"\n", "");
    let film = evening.record();
    (0..10).for_each(|_| evening.step(kick));
    for id in ["drawer/body", "show-harmonics"] {
        control(&evening.window, id).click_accesskit();
        (0..15).for_each(|_| evening.step(kick));
    }
    assert!(shows(&evening.window, "Extrema and their"));
    evening.end_recording();
    // They stand on slate.
    let mean = |frame: &Vec<u8>| frame.iter().map(|&level| f32::from(level)).sum::<f32>() / 4096.0;
    let means: Vec<f32> = gray_frames(&film).iter().map(mean).collect();
    let (first, last) = (means[0], means[means.len() - 1]);
    assert!(first > 100.0 && last < 0.8 * first, "{means:?}");
}

#[test]
fn a_show_hears_live_input_again_from_its_recording() {
    if !chladni_view::ffmpeg_is_there() {
        return println!("skipped: no ffmpeg");
    }
    let mut evening = Evening::begin(20, "", "");
    let film = evening.record();
    (0..60).for_each(|_| evening.step(kick));
    evening.end_recording();
    (0..10).for_each(|_| evening.step(|_| 0.0));
    let (path, show) = evening.save_show();
    assert_eq!(show.songs.len(), 1);
    assert!(film.ends_with(&show.songs[0].path), "{:?}", show.songs);
    let songs: Vec<Option<usize>> = show.heard.iter().map(|stretch| stretch.song).collect();
    assert_eq!(songs, [None, Some(0), None]);
    let recorded = show.heard[2].at_secs - show.heard[1].at_secs;
    assert!((2.8..3.4).contains(&recorded), "{:?}", show.heard);
    // The film of the show hears what came in: the shape moves only while it is recorded.
    let dance = Command::new(env!("CARGO_BIN_EXE_chladni"))
        .args(["--quiet", "dance", "--show"])
        .arg(&path)
        .args(["--size", "96x96", "--fps", "10", "-o", "-"])
        .output()
        .unwrap();
    assert!(dance.status.success(), "{}", String::from_utf8_lossy(&dance.stderr));
    let frames: Vec<&[u8]> = dance.stdout.chunks_exact(4 * 96 * 96).collect();
    let change = |of: &[&[u8]]| -> f64 {
        let difference = |pair: &[&[u8]]| -> f64 {
            pair[0].iter().zip(pair[1]).map(|(a, b)| f64::from(a.abs_diff(*b))).sum()
        };
        of.windows(2).map(difference).sum::<f64>() / (of.len() - 1) as f64
    };
    let begins = (10.0 * show.heard[1].at_secs).ceil() as usize;
    let (live, heard) = (change(&frames[..begins]), change(&frames[begins + 5..begins + 25]));
    assert!(heard > 5.0 * live + 1000.0, "{live} before the recording, {heard} in it");
}

#[test]
fn a_show_that_is_saved_while_its_recording_is_written_names_it() {
    if !chladni_view::ffmpeg_is_there() {
        return println!("skipped: no ffmpeg");
    }
    let mut evening = Evening::begin(20, "", "");
    let film = evening.record();
    (0..20).for_each(|_| evening.step(kick));
    control(&evening.window, "recording-end").click_accesskit();
    let (_, show) = evening.save_show();
    assert!(show.songs.iter().any(|song| film.ends_with(&song.path)), "{:?}", show.songs);
}

/// Tests draw the second window into the first.
#[test]
fn a_recording_has_the_size_of_the_stage_that_has_a_window_of_its_own() {
    if !chladni_view::ffmpeg_is_there() {
        return println!("skipped: no ffmpeg");
    }
    let [gallery, stage] = [false, true].map(|on_stage| {
        let mut evening = Evening::begin(20, "[music]\nown_window = true\n", "");
        if on_stage {
            evening.window.event(Event::PointerMoved(Pos2::new(100.0, 200.0)));
            evening.window.run_steps(3);
            evening.window.key_press(Key::S);
            (0..10).for_each(|_| evening.step(kick));
            assert!(shows(&evening.window, "On stage"));
        }
        evening.recorded_size()
    });
    assert_ne!(stage, gallery);
}
