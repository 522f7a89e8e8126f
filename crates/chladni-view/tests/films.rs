//! Films, decoded again.
#![allow(
    clippy::unwrap_used,
    clippy::print_stderr,
    reason = "a panic is how a test fails, and a skipped one says so"
)]

mod shapes;

use std::path::{Path, PathBuf};
use std::process::Command;

use chladni_task::Task;
use chladni_view::film::{ffmpeg_is_there, shoot};
use chladni_view::{
    Background, Camera, Canvas, Cell, Film, FilmFormat, FilmSettings, FrameRate, Lights, Picture,
    PictureRequest, PictureShape, Rect, Renderer, Style, View, ViewError, film_turntable,
};
use tempfile::TempDir;

const SIZE: (u32, u32) = (64, 48);

fn settings(frames: u64, fps: u32) -> FilmSettings {
    let (width, height) = SIZE;
    FilmSettings { width, height, rate: FrameRate::per_second(fps), frames, first: 0, audio: None }
}

/// A bar that moves two pixels a frame over a still gradient.
fn frame(index: u32) -> Picture {
    let mut picture = Picture::filled(SIZE.0, SIZE.1, [0, 0, 0, 255]);
    for (i, pixel) in picture.rgba.chunks_mut(4).enumerate() {
        let (x, y) = (i as u32 % SIZE.0, i as u32 / SIZE.0);
        let bar = (2 * index..2 * index + 6).contains(&x);
        let color = if bar { [250, 120, 20, 255] } else { [40, (x * 2) as u8, (y * 4) as u8, 255] };
        pixel.copy_from_slice(&color);
    }
    picture
}

fn write(path: &Path, settings: FilmSettings) -> Result<(), ViewError> {
    let mut film = Film::create(path, settings.clone())?;
    for i in 0..settings.frames {
        film.push(&frame(i as u32))?;
    }
    film.finish()
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_gif_plays_every_frame_for_as_long_as_it_should_and_looks_like_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("clip.gif");
    write(&path, settings(20, 15)).unwrap();
    assert_eq!(names(folder.path()), ["clip.gif"]);
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(std::fs::File::open(&path).unwrap()).unwrap();
    assert_eq!(decoder.repeat(), gif::Repeat::Infinite);
    let mut screen = Picture::filled(SIZE.0, SIZE.1, [0; 4]);
    let (mut frames, mut centiseconds) = (0, 0);
    while let Some(part) = decoder.read_next_frame().unwrap() {
        centiseconds += u32::from(part.delay);
        let (x, y) = (part.left.into(), part.top.into());
        let (width, height) = (part.width.into(), part.height.into());
        screen.paste(&Picture { width, height, rgba: part.buffer.to_vec() }, x, y);
        let wanted = frame(frames);
        let error: u32 = screen.rgba.iter().zip(&wanted.rgba).map(|(a, b)| u32::from(a.abs_diff(*b))).sum();
        let mean = f64::from(error) / screen.rgba.len() as f64;
        assert!(mean < 4.0, "frame {frames} is off by {mean} on average");
        frames += 1;
    }
    assert_eq!((frames, centiseconds), (20, 133));
}

#[test]
fn a_gif_may_have_holes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("clip.gif");
    let mut film = Film::create(&path, settings(2, 10)).unwrap();
    for i in 0..2 {
        let mut picture = frame(i);
        picture.rgba[..4 * 64].fill(0);
        film.push(&picture).unwrap();
    }
    film.finish().unwrap();
    let first = image_of(&path);
    assert_eq!((first.pixel(5, 0).unwrap()[3], first.pixel(5, 1).unwrap()[3]), (0, 255));
}

fn image_of(gif: &Path) -> Picture {
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(std::fs::File::open(gif).unwrap()).unwrap();
    let part = decoder.read_next_frame().unwrap().unwrap();
    Picture { width: part.width.into(), height: part.height.into(), rgba: part.buffer.to_vec() }
}

#[test]
fn an_animated_png_holds_every_pixel() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("clip.png");
    write(&path, settings(5, 24)).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    assert_eq!(reader.info().animation_control().unwrap().num_frames, 5);
    for i in 0..5 {
        let mut rgba = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut rgba).unwrap();
        assert_eq!(rgba, frame(i).rgba);
    }
    let control = reader.info().frame_control.unwrap();
    assert_eq!((control.delay_num, control.delay_den), (1, 24));
}

#[test]
fn a_folder_holds_one_picture_a_frame() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("frames");
    write(&path, settings(3, 24)).unwrap();
    assert_eq!(names(&path), ["frame-00000.png", "frame-00001.png", "frame-00002.png"]);
    let bytes = std::fs::read(path.join("frame-00002.png")).unwrap();
    assert_eq!(Picture::decode(&bytes).unwrap(), frame(2));
}

/// 0.3 s of silence: 16-bit mono PCM.
fn wav() -> Vec<u8> {
    let samples = 14_400_u32;
    let mut bytes = Vec::new();
    bytes.extend(b"RIFF");
    bytes.extend((36 + 2 * samples).to_le_bytes());
    bytes.extend(b"WAVEfmt ");
    bytes.extend(16_u32.to_le_bytes());
    bytes.extend([1_u16, 1].into_iter().flat_map(u16::to_le_bytes));
    bytes.extend([48_000_u32, 96_000].into_iter().flat_map(u32::to_le_bytes));
    bytes.extend([2_u16, 16].into_iter().flat_map(u16::to_le_bytes));
    bytes.extend(b"data");
    bytes.extend((2 * samples).to_le_bytes());
    bytes.resize(bytes.len() + 2 * samples as usize, 0);
    bytes
}

/// A folder, the path of an MP4 in it, and a sound for that; without ffmpeg it says so.
fn folder_with_sound() -> Option<(TempDir, PathBuf, PathBuf)> {
    if !ffmpeg_is_there() {
        eprintln!("skipped: no ffmpeg");
        return None;
    }
    let folder = tempfile::tempdir().unwrap();
    let (path, audio) = (folder.path().join("clip.mp4"), folder.path().join("sound.wav"));
    std::fs::write(&audio, wav()).unwrap();
    Some((folder, path, audio))
}

#[test]
fn an_mp4_has_its_frames_its_rate_and_its_sound() {
    let Some((folder, path, audio)) = folder_with_sound() else { return };
    write(&path, FilmSettings { audio: Some(audio), ..settings(25, 30) }).unwrap();
    assert_eq!(names(folder.path()), ["clip.mp4", "sound.wav"]);
    let output = Command::new("ffprobe")
        .args(["-v", "error", "-count_frames", "-of", "default=noprint_wrappers=1", "-show_entries"])
        .arg(
            "stream=codec_name,width,height,r_frame_rate,nb_read_frames,pix_fmt,duration,\
             color_space,color_range",
        )
        .arg(&path)
        .output();
    let Ok(output) = output else {
        eprintln!("skipped: no ffprobe");
        return;
    };
    let text = String::from_utf8(output.stdout).unwrap();
    for line in [
        "codec_name=h264",
        "codec_name=aac",
        "width=64",
        "height=48",
        "r_frame_rate=30/1",
        "nb_read_frames=25",
        "pix_fmt=yuv420p",
        "color_space=bt709",
        "color_range=tv",
        "duration=0.833333",
    ] {
        assert!(text.lines().any(|found| found == line), "{line} in\n{text}");
    }
    let decoded = Command::new("ffmpeg")
        .args(["-v", "error", "-i"])
        .arg(&path)
        .args(["-vf", "scale=in_color_matrix=bt709", "-pix_fmt", "rgba", "-f", "rawvideo", "-"])
        .output()
        .unwrap();
    let frames: Vec<&[u8]> = decoded.stdout.chunks(4 * (SIZE.0 * SIZE.1) as usize).collect();
    assert_eq!(frames.len(), 25);
    for (i, found) in frames.into_iter().enumerate() {
        let wanted = frame(i as u32).rgba;
        assert_eq!(found.len(), wanted.len());
        let error: u32 = found.iter().zip(&wanted).map(|(a, b)| u32::from(a.abs_diff(*b))).sum();
        let mean = f64::from(error) / wanted.len() as f64;
        // The frame before is off by 6, and another range of the colors by 7.
        assert!(mean < 5.0, "frame {i} is off by {mean} on average");
    }
    // The file starts with its index, so that it plays while it loads.
    let bytes = std::fs::read(&path).unwrap();
    let at = |name: &[u8]| bytes.windows(4).position(|w| w == name).unwrap();
    assert!(at(b"moov") < at(b"mdat"));
}

#[test]
fn the_sound_of_an_mp4_ends_with_its_pictures() {
    let Some((_folder, path, audio)) = folder_with_sound() else { return };
    for (fps, frames) in [(240.0, 24), (12.5, 10)] {
        let rate = FrameRate::decimal(fps);
        write(&path, FilmSettings { audio: Some(audio.clone()), rate, ..settings(frames, 1) }).unwrap();
        let output = Command::new("ffprobe")
            .args(["-v", "error", "-of", "csv=p=0", "-show_entries", "stream=duration"])
            .arg(&path)
            .output();
        let Ok(output) = output else {
            eprintln!("skipped: no ffprobe");
            return;
        };
        let text = String::from_utf8(output.stdout).unwrap();
        let lengths: Vec<f64> = text.split_whitespace().map(|secs| secs.parse().unwrap()).collect();
        assert_eq!(lengths.len(), 2, "{text}");
        for length in lengths {
            assert!((length - frames as f64 / fps).abs() < 1e-3, "{fps} pictures a second: {text}");
        }
    }
}

#[test]
fn what_ffmpeg_cannot_do_is_an_error_with_its_words_and_leaves_nothing() {
    if !ffmpeg_is_there() {
        eprintln!("skipped: no ffmpeg");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("missing.wav");
    let failed =
        write(&folder.path().join("clip.mp4"), FilmSettings { audio: Some(missing), ..settings(40, 30) });
    let Err(ViewError::Ffmpeg(words)) = failed else { panic!("{failed:?}") };
    assert!(words.contains("missing.wav"), "{words}");
    assert!(names(folder.path()).is_empty());
}

#[test]
fn a_film_that_is_given_up_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["clip.mp4", "clip.gif", "clip.png"] {
        let Ok(mut film) = Film::create(&folder.path().join(name), settings(10, 10)) else { continue };
        film.push(&frame(0)).unwrap();
        drop(film);
        let mut film = Film::create(&folder.path().join(name), settings(10, 10)).unwrap();
        film.push(&frame(0)).unwrap();
        assert!(matches!(film.finish(), Err(ViewError::Film(_))), "nine frames are missing");
    }
    assert!(names(folder.path()).is_empty(), "{:?}", names(folder.path()));
}

#[test]
fn wrong_sizes_rates_and_endings_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let mut film = Film::create(&at("a.png"), settings(1, 10)).unwrap();
    assert!(matches!(film.push(&Picture::filled(3, 3, [0; 4])), Err(ViewError::Film(_))));
    film.push(&frame(0)).unwrap();
    assert!(matches!(film.push(&frame(1)), Err(ViewError::Film(_))));
    for (name, settings) in
        [("a.avi", settings(1, 10)), ("a.gif", settings(1, 60)), ("a.gif", settings(0, 10))]
    {
        assert!(matches!(Film::create(&at(name), settings), Err(ViewError::Film(_))), "{name}");
    }
    // Animated PNGs hold short numbers: fractions are reduced, and others refused before any work.
    let at_rate = |numerator, denominator| FilmSettings {
        rate: FrameRate { numerator, denominator },
        ..settings(1, 1)
    };
    write(&at("a.png"), at_rate(100_000, 1000)).unwrap();
    assert!(at_rate(30_000, 1001).check_for(FilmFormat::Apng).is_ok());
    let uneven = at_rate(239_761, 1000).check_for(FilmFormat::Apng);
    assert!(matches!(uneven, Err(ViewError::Film(_))), "{uneven:?}");
    let nowhere = Film::create(&at("no/such/folder/a.gif"), settings(1, 10));
    assert!(matches!(nowhere, Err(ViewError::File { .. })));
}

#[test]
fn frames_are_shot_in_order_and_cancelling_leaves_nothing() {
    shapes::on_each_device(|device| {
        let mut renderer = Renderer::new(device);
        let canvas = Canvas::new(device, SIZE.0, SIZE.1).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("clip.png");
        let shade = |frame: u64| Background::plain([20 * frame as u8; 3]);
        let mut run = |task: &Task, stop_at: u64| {
            let film = Film::create(&path, settings(8, 10)).unwrap();
            shoot(&mut renderer, &canvas, film, task, |renderer, canvas, frame| {
                if frame == stop_at {
                    task.cancel();
                }
                let cell = Cell {
                    viewport: Rect::of_size(SIZE.0, SIZE.1),
                    camera: Default::default(),
                    lights: Lights::STUDIO,
                    background: shade(frame),
                    figures: &[],
                    markers: &[],
                };
                renderer.draw(canvas, &[cell])?;
                Ok::<(), ViewError>(())
            })
        };
        assert!(matches!(run(&Task::new(), 5), Err(ViewError::Cancelled(_))));
        assert!(names(folder.path()).is_empty());
        let task = Task::new();
        run(&task, u64::MAX).unwrap();
        assert_eq!(task.progress().done, 8);
        let bytes = std::fs::read(&path).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        for frame in 0..8 {
            let mut rgba = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut rgba).unwrap();
            assert!(rgba[0].abs_diff(20 * frame) <= 1, "{} in frame {frame}", rgba[0]);
        }
    });
}

#[test]
fn a_turntable_turns_once_and_ends_where_it_began() {
    shapes::on_each_device(|device| {
        let (mut positions, triangles) = shapes::sphere(8);
        for p in &mut positions {
            p[0] *= 0.4;
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("turn");
        let request = PictureRequest {
            shapes: &[PictureShape { positions: &positions, triangles: &triangles, ..Default::default() }],
            width: SIZE.0,
            height: SIZE.1,
            from: Camera::looking(View::ThreeQuarter),
            style: Style { background: Background::TRANSPARENT, ..Style::default() },
        };
        let film = Film::create(&path, settings(8, 8)).unwrap();
        film_turntable(&mut Renderer::new(device), &request, film, &Task::new()).unwrap();
        let widths: Vec<usize> = names(&path)
            .iter()
            .map(|name| Picture::decode(&std::fs::read(path.join(name)).unwrap()).unwrap())
            .map(|picture| (0..SIZE.0).filter(|x| picture.pixel(*x, SIZE.1 / 2).unwrap()[3] > 127).count())
            .collect();
        assert_eq!(widths.len(), 8);
        // A flat body looks the same half a turn later, and not a quarter.
        for i in 0..4 {
            assert!(widths[i].abs_diff(widths[i + 4]) <= 1, "{widths:?}");
        }
        assert!(widths.iter().max().unwrap() - widths.iter().min().unwrap() > 8, "{widths:?}");
    });
}
