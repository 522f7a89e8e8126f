//! `chladni spectrum`: the bands that the shape will dance to, as numbers or as a picture.

use std::path::PathBuf;

use chladni_sound::{FrontEnd, Level, Song, SoundError, SpectrumAnalyzer, SpectrumSettings};
use chladni_task::Task;
use clap::Args;

use super::Terminal;
use crate::work::outputs::check_picture;
use crate::work::{Error, Watcher, source};

/// Show the middle and side spectra of a song over time.
#[derive(Args)]
#[command(group(clap::ArgGroup::new("form").required(true).args(["json", "render"])))]
pub struct Spectrum {
    /// A song (WAV, FLAC, MP3, Ogg Vorbis, Opus, M4A, AIFF, Matroska) or sample:tune.
    song: String,
    /// Print `rate_hz`, `bands_hz` and `frames` (`time_secs`, `mid`, `side`) as JSON.
    #[arg(long)]
    json: bool,
    /// Draw a spectrogram: the middle above, the side below, low notes at the bottom.
    #[arg(long, value_name = "P.png")]
    render: Option<PathBuf>,
    /// Frames per second [default: 20 for numbers, as many as the picture is wide].
    #[arg(long)]
    fps: Option<f64>,
    /// Number of bands.
    #[arg(long, default_value_t = 128)]
    bands: usize,
    /// Bands in equal steps in Hz instead of equal steps in pitch.
    #[arg(long)]
    linear: bool,
    /// How much of the spectrum of 50 ms ago is left, in [0, 1).
    #[arg(long, default_value_t = 0.0)]
    decay: f32,
    /// Factor on the side.
    #[arg(long, default_value_t = 10.0)]
    side_gain: f32,
    /// Amplitudes as they are in the file, instead of following its level.
    #[arg(long)]
    fixed_level: bool,
    /// Where to begin, in seconds.
    #[arg(long, default_value_t = 0.0)]
    start: f64,
    /// How much to show, in seconds [default: all].
    #[arg(long)]
    duration: Option<f64>,
}

/// One moment of the song; rounded, because the sixth digit of an amplitude is noise.
#[derive(serde::Serialize)]
struct Frame {
    time_secs: f64,
    mid: Vec<f64>,
    side: Vec<f64>,
}

const JSON_FPS: f64 = 20.0;
const PICTURE_COLUMNS: f64 = 1200.0;

impl Spectrum {
    /// Runs the command.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        self.render.as_deref().map_or(Ok(()), check_picture)?;
        let song = source::song(&self.song, self.start, self.duration, terminal)?;
        let settings = SpectrumSettings {
            bands: self.bands,
            front_end: if self.linear { FrontEnd::Linear } else { FrontEnd::LogBands },
            decay: self.decay,
            side_gain: self.side_gain,
            level: if self.fixed_level { Level::Fixed(1.0) } else { Level::Auto },
            // A fixed level does not ask.
            loud: if self.fixed_level { None } else { Some(song.loud_level()?) },
            ..SpectrumSettings::new(song.rate_hz)
        };
        let fps = match (self.fps, &self.render) {
            (Some(fps), _) if fps.is_finite() && (0.1..=1000.0).contains(&fps) => fps,
            (Some(_), _) => return Err(Error::input("--fps must lie between 0.1 and 1000")),
            (None, Some(_)) => (PICTURE_COLUMNS / song.duration_secs().max(0.1)).min(200.0),
            (None, None) => JSON_FPS,
        };
        let mut analyzer = SpectrumAnalyzer::new(settings)?;
        let frames =
            terminal.watch("spectrum", |task| analyze(&song, &mut analyzer, fps, self.start, task))?;
        match &self.render {
            Some(path) => {
                let picture = picture::spectrogram(&frames).map_err(Error::other)?;
                chladni_task::write_atomic(path, &picture).map_err(|error| Error::unwritten(path, error))?;
                terminal.wrote(path)
            }
            None => print_json(terminal, &song, &analyzer, &frames),
        }
    }
}

/// Frame i shows the window centered on i / fps.
fn analyze(
    song: &Song,
    analyzer: &mut SpectrumAnalyzer,
    fps: f64,
    start_secs: f64,
    task: &Task,
) -> Result<Vec<Frame>, SoundError> {
    let rate_hz = f64::from(song.rate_hz);
    let n = analyzer.window_frames();
    let count = (song.duration_secs() * fps).ceil() as u64;
    let stage = task.stage("spectrum", count);
    let (mut left, mut right) = (vec![0.0; n], vec![0.0; n]);
    let rounded = |bands: &[f32]| bands.iter().map(|&x| (f64::from(x) * 1e6).round() / 1e6).collect();
    let mut frames = Vec::new();
    for i in 0..count {
        task.check()?;
        let time_secs = i as f64 / fps;
        let center = (time_secs * rate_hz).round() as i64;
        song.window_ending_at(center + n as i64 / 2, &mut left, &mut right);
        let spectrum = analyzer.analyze(&left, &right, 1.0 / fps);
        frames.push(Frame {
            time_secs: start_secs + time_secs,
            mid: rounded(&spectrum.mid),
            side: rounded(&spectrum.side),
        });
        stage.advance(1);
    }
    Ok(frames)
}

/// One frame a line, so that hours of music need no second copy in memory.
fn print_json(
    terminal: &Terminal,
    song: &Song,
    analyzer: &SpectrumAnalyzer,
    frames: &[Frame],
) -> Result<(), Error> {
    let json = |value: &[f32]| serde_json::to_string(value).map_err(Error::other);
    terminal.result(format_args!(
        "{{\"rate_hz\": {}, \"bands_hz\": {}, \"frames\": [",
        song.rate_hz,
        json(analyzer.bands_hz())?
    ))?;
    for (i, frame) in frames.iter().enumerate() {
        let comma = if i + 1 < frames.len() { "," } else { "" };
        terminal.result(format_args!("{}{comma}", serde_json::to_string(frame).map_err(Error::other)?))?;
    }
    terminal.result("]}")
}

/// Amplitudes as colors.
mod picture {
    use super::Frame;

    /// Amplitudes this far below 1 are black.
    const RANGE_DB: f64 = 60.0;
    /// Height of each of the two spectrograms, at least.
    const LEAST_HEIGHT: usize = 360;
    const LEAST_WIDTH: usize = 600;
    /// Between the middle's and the side's spectrogram.
    const GAP: usize = 6;

    /// A PNG: time to the right, the middle above and the side below, low bands at the bottom.
    pub fn spectrogram(frames: &[Frame]) -> Result<Vec<u8>, png::EncodingError> {
        let bands = frames.first().map_or(1, |frame| frame.mid.len().max(1));
        let band_height = LEAST_HEIGHT.div_ceil(bands);
        let frame_width = LEAST_WIDTH.div_ceil(frames.len().max(1));
        let (width, half) = (frame_width * frames.len().max(1), band_height * bands);
        let height = 2 * half + GAP;
        let mut pixels = vec![24u8; 3 * width * height];
        for (x, column) in (0..width).map(|x| (x, frames.get(x / frame_width))) {
            let Some(frame) = column else { continue };
            for (top, values) in [(0, &frame.mid), (half + GAP, &frame.side)] {
                for y in 0..half {
                    let band = bands - 1 - y / band_height;
                    let db = 20.0 * values[band].max(1e-9).log10();
                    let at = 3 * ((top + y) * width + x);
                    pixels[at..at + 3].copy_from_slice(&inferno((db / RANGE_DB + 1.0).clamp(0.0, 1.0)));
                }
            }
        }
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width as u32, height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&pixels)?;
        writer.finish()?;
        Ok(bytes)
    }

    /// The perceptually even map "inferno" (S. van der Walt and N. Smith 2015) at nine places,
    /// straight lines between them.
    fn inferno(t: f64) -> [u8; 3] {
        const PLACES: [[f64; 3]; 9] = [
            [0.0, 0.0, 4.0],
            [31.0, 12.0, 72.0],
            [85.0, 15.0, 109.0],
            [136.0, 34.0, 106.0],
            [186.0, 54.0, 85.0],
            [227.0, 89.0, 51.0],
            [249.0, 140.0, 10.0],
            [249.0, 201.0, 50.0],
            [252.0, 255.0, 164.0],
        ];
        let at = t * (PLACES.len() - 1) as f64;
        let i = (at as usize).min(PLACES.len() - 2);
        let part = at - i as f64;
        std::array::from_fn(|c| ((1.0 - part) * PLACES[i][c] + part * PLACES[i + 1][c]).round() as u8)
    }
}
