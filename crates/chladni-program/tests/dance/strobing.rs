//! A strobing song, the film of a shape that dances to it, and how bright its frames are.

use chladni_music::{
    Action, FlashArea, FlashCount, Histogram, LoggedAction, MAX_FLASHES, Moment, Show, Switch, Veil,
};

use super::*;

/// Four seconds of noise, five times a second on for 80 ms: the spectrum's window lies in silence between.
pub fn strobe(path: &Path) {
    let rate_hz = 44_100;
    let mut state = 1u32;
    let left: Vec<f32> = (0..4 * rate_hz as usize)
        .map(|n| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = state as f32 / u32::MAX as f32 * 1.8 - 0.9;
            if n * 5 % rate_hz as usize * 5 < 2 * rate_hz as usize { noise } else { 0.0 }
        })
        .collect();
    write_wav(path, &Song { rate_hz, right: left.clone(), left }, WavSample::Int16).unwrap();
}

/// The PNGs of a folder, in order.
pub fn frames(folder: &Path) -> Vec<chladni_view::Picture> {
    let mut frames: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    frames.retain(|path| path.extension().is_some_and(|e| e == "png"));
    frames.sort();
    let read = |path| chladni_view::Picture::decode(&std::fs::read(path).unwrap()).unwrap();
    frames.into_iter().map(read).collect()
}

/// Mean relative luminance (WCAG 2.3.1) of each PNG of a folder, in order.
pub fn luminances(folder: &Path) -> Vec<f32> {
    let linear = |byte: u8| {
        let c = f32::from(byte) / 255.0;
        if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
    };
    let mean = |picture: &chladni_view::Picture| {
        let pixels = picture.rgba.chunks_exact(4);
        let count = pixels.len() as f32;
        pixels.map(|p| 0.2126 * linear(p[0]) + 0.7152 * linear(p[1]) + 0.0722 * linear(p[2])).sum::<f32>()
            / count
    };
    frames(folder).iter().map(mean).collect()
}

/// Flashes in the worst second of the PNGs of a folder, 30 a second, where a quarter of an area counts.
fn flashes_in(area: FlashArea, folder: &Path) -> usize {
    counted(area, folder).most_per_second()
}

/// What is counted of the PNGs of a folder, 30 a second.
fn counted(area: FlashArea, folder: &Path) -> FlashCount {
    let (mut count, mut histogram) = (FlashCount::of(area), Histogram::default());
    for (frame, picture) in frames(folder).iter().enumerate() {
        histogram.clear();
        for (&[r, g, b, _], i) in picture.rgba.as_chunks::<4>().0.iter().zip(0..) {
            histogram.add([i % picture.width, i / picture.width], [picture.width, picture.height], [r, g, b]);
        }
        count.note(frame as f64 / 30.0, &histogram, Veil::Clear);
    }
    count
}

/// A ball: it grows and shrinks as a whole, and is drawn quickly.
pub fn ball(path: &Path) {
    save_mesh(&samples::icosphere(3), path).unwrap();
}

/// Films a dark ball on white that the strobe blows up as far as it goes; 30 frames a second.
pub fn strobing_film(folder: &Path, name: &str, more: &[&str]) -> std::path::PathBuf {
    let session = strobing_show(folder);
    film_of(folder, &session, name, more)
}

/// The ball, the strobe and what it does to the ball.
fn strobing_show(folder: &Path) -> std::path::PathBuf {
    ball(&folder.join("ball.obj"));
    strobe(&folder.join("strobe.wav"));
    let session = folder.join("session.toml");
    // All sound goes to the harmonics that widen the ball and that heighten it, without decay.
    let action = |text: &str| format!("[[actions]]\nat_secs = 0.0\nat_beat = 0.0\n{text}\n");
    let mapping =
        "{ transfer = [0.0435, 0.087, 0.1305], amplification = [1.0], stereo_mu = 0.0, gain = 1.0 }";
    let wild: String = [
        format!("do = \"load\"\nitem = 0\nname = \"strobe\"\nmapping = {mapping}"),
        "do = \"perform\"\nitem = 0".into(),
        "do = \"set\"\nparameter = \"decay\"\nvalue = 0.0".into(),
        "do = \"set\"\nparameter = \"limit\"\nvalue = 0.5".into(),
        "do = \"set\"\nparameter = \"gain\"\nvalue = 8.0".into(),
    ]
    .map(|text| action(&text))
    .concat();
    std::fs::write(&session, format!("format_version = 1\nseed = 5\nsize = 6\n{wild}")).unwrap();
    session
}

/// Films the ball as a show says.
fn film_of(folder: &Path, show: &Path, name: &str, more: &[&str]) -> std::path::PathBuf {
    let [mesh, wav, out] = ["ball.obj", "strobe.wav", name].map(|name| folder.join(name));
    let [mesh, wav, session, frames] = [&mesh, &wav, show, &out].map(|path| path.to_str().unwrap());
    let look = ["--size", "64x64", "--material", "dark", "--lights", "studio", "--background", "white"];
    let fixed = ["dance", mesh, wav, "-k", "24", "--session", session, "--frames", frames];
    assert_eq!(run(&[&fixed[..], &look, more].concat()), 0);
    out
}

#[test]
fn a_strobing_song_never_flashes_more_than_three_times_a_second() {
    let folder = tempfile::tempdir().unwrap();
    let flashes = |name: &str, more: &[&str]| {
        let shown = luminances(&strobing_film(folder.path(), name, more));
        assert_eq!(shown.len(), 120);
        let times_secs: Vec<f64> = (0..120).map(|i| f64::from(i) / 30.0).collect();
        chladni_music::most_flashes_per_second(&times_secs, &shown)
    };
    let (free, limited) = (flashes("free", &["--allow-flashes"]), flashes("limited", &[]));
    assert!(free > MAX_FLASHES, "the song does not strobe: {free}");
    assert!(limited <= MAX_FLASHES, "{limited} flashes a second, {free} without the limit");
    // Parts of it still flash, until fields are judged.
    let [screen, field] = [FlashArea::Screen, FlashArea::Field]
        .map(|area| flashes_in(area, &folder.path().join("limited")).cmp(&MAX_FLASHES));
    assert!(screen.is_le() && field.is_gt(), "{screen:?} {field:?}");
    let fields = strobing_film(folder.path(), "fields", &["--flash-fields"]);
    let left = flashes_in(FlashArea::Field, &fields);
    assert!(left <= MAX_FLASHES, "{left} flashes a second in a field");
}

#[test]
fn a_film_is_limited_throughout_where_its_show_is_at_any_time() {
    let folder = tempfile::tempdir().unwrap();
    let session = strobing_show(folder.path());
    let flashes = |name: &str, first: bool, then: Option<bool>, more: &[&str]| {
        let mut show = Show::load(&session).unwrap();
        let switch = Switch::FlashLimit;
        show.beginning.switches.insert(switch, first);
        show.actions.extend(then.map(|on| LoggedAction {
            moment: Moment { at_secs: 3.5, at_beat: 0.0 },
            action: Action::Switch { switch, on },
        }));
        let path = folder.path().join(format!("{name}.show.toml"));
        show.save(&path).unwrap();
        flashes_in(FlashArea::Screen, &film_of(folder.path(), &path, name, more))
    };
    let never = flashes("never", false, None, &[]);
    assert!(never > MAX_FLASHES, "{never}: the show does not limit them");
    for (name, first, then) in [("off-on", false, true), ("on-off", true, false)] {
        let limited = flashes(name, first, Some(then), &[]);
        assert!(limited <= MAX_FLASHES, "{name}: {limited} flashes a second");
    }
    // Fields are judged only in a film that is limited.
    let asked = flashes("asked", false, None, &["--flash-fields"]);
    assert!(asked <= MAX_FLASHES, "{asked} flashes a second");
}

/// Films two seconds of a dark ball before a picture or a film; the folder of the frames.
fn film_before(folder: &Path, behind: &Path, name: &str, more: &[&str]) -> std::path::PathBuf {
    ball(&folder.join("ball.obj"));
    let [mesh, out] = ["ball.obj", name].map(|name| folder.join(name));
    let [mesh, behind, frames] = [&mesh, behind, &out].map(|path| path.to_str().unwrap());
    let dance = ["dance", mesh, "sample:tune", "-k", "24", "--duration", "2", "--frames", frames];
    let look = ["--size", "96x64", "--draw", "cpu", "--material", "dark", "--picture", behind];
    assert_eq!(run(&[&dance[..], &look, more].concat()), 0);
    out
}

#[test]
fn red_that_keeps_its_luminance_never_flashes_more_than_three_times_a_second() {
    if !chladni_view::ffmpeg_is_there() {
        return println!("skipped: no ffmpeg");
    }
    let folder = tempfile::tempdir().unwrap();
    let [raw, film] = ["red.rgb", "red.mkv"].map(|name| folder.path().join(name));
    // Both have a relative luminance of 0.07, five times a second.
    let color = |frame: usize| if (frame / 3).is_multiple_of(2) { [156u8, 0, 0] } else { [0, 0, 255] };
    std::fs::write(&raw, (0..75).flat_map(|frame| color(frame).repeat(48 * 32)).collect::<Vec<u8>>())
        .unwrap();
    let made = std::process::Command::new("ffmpeg")
        .args(["-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", "48x32", "-r", "30", "-i"])
        .arg(&raw)
        .args(["-c:v", "png"])
        .arg(&film)
        .status();
    assert!(made.unwrap().success());
    let [free, limited] = [("free", &["--allow-flashes"][..]), ("limited", &[][..])]
        .map(|(name, more)| film_before(folder.path(), &film, name, more));
    let bright = luminances(&free);
    let range = [f32::min, f32::max].map(|pick| bright.iter().copied().reduce(pick).unwrap());
    assert!(range[1] - range[0] < 0.05, "not only red changes: {range:?}");
    let [free, limited] = [free, limited].map(|frames| flashes_in(FlashArea::Screen, &frames));
    assert!(free > MAX_FLASHES, "red does not strobe: {free}");
    assert!(limited <= MAX_FLASHES, "{limited} flashes a second, {free} without the limit");
}

#[test]
fn bars_behind_a_dance_are_darkened_within_half_a_second() {
    let folder = tempfile::tempdir().unwrap();
    let mut bars = chladni_view::Picture::filled(192, 128, [0, 0, 0, 255]);
    for (i, pixel) in bars.rgba.as_chunks_mut::<4>().0.iter_mut().enumerate() {
        if i % 8 < 4 {
            *pixel = [250, 240, 230, 255];
        }
    }
    let path = folder.path().join("bars.png");
    std::fs::write(&path, bars.to_png().unwrap()).unwrap();
    let [free, limited] = [("free", &["--allow-flashes"][..]), ("limited", &[][..])].map(|(name, more)| {
        let count = counted(FlashArea::Screen, &film_before(folder.path(), &path, name, more));
        (count.longest_stripes_secs(), count.most_per_second())
    });
    assert!(free.0 > 1.5, "no bars are seen: {free:?}");
    assert!(limited.0 < 0.5 && limited.1 <= MAX_FLASHES, "{limited:?}");
}
