//! `chladni spectrum`: the bands that the shape will dance to, as numbers or as a picture.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::Arc;

use chladni_sound::{FrontEnd, Level, Song, SongSpectrum, SoundError, SpectrumSettings};
use chladni_task::Task;
use clap::Args;

use super::Terminal;
use super::number::seconds;
use crate::work::outputs::check_picture;
use crate::work::{Error, Warning, Watcher, source, write_file};

/// Show the middle and side spectra of a song over time.
#[derive(Args)]
#[command(group(clap::ArgGroup::new("form").required(true).args(["json", "render"])))]
pub struct Spectrum {
    /// A song (WAV, FLAC, MP3, Ogg Vorbis, Opus, M4A, AIFF, Matroska) or sample:tune.
    song: PathBuf,
    /// Print `rate_hz`, `bands_hz` and `frames` (`time_secs`, `mid`, `side`) as JSON.
    #[arg(long)]
    json: bool,
    /// Draw a spectrogram: the middle above, the side below, low notes at the bottom.
    #[arg(long, value_name = "P.png")]
    render: Option<PathBuf>,
    /// Frames per second [default: 20 for numbers, as many as the picture is wide].
    #[arg(long, allow_negative_numbers = true)]
    fps: Option<f64>,
    /// Number of bands.
    #[arg(long, default_value_t = 128)]
    bands: usize,
    /// Bands in equal steps in Hz instead of equal steps in pitch.
    #[arg(long)]
    linear: bool,
    /// How much of the spectrum of 50 ms ago is left, in [0, 1).
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    decay: f32,
    /// Factor on the side.
    #[arg(long, default_value_t = 10.0, allow_negative_numbers = true)]
    side_gain: f32,
    /// Amplitudes as they are in the file, instead of following the level of the whole song.
    #[arg(long)]
    fixed_level: bool,
    /// Where to begin, in seconds. The whole song is read for its level; not with --fixed-level.
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true, value_parser = seconds)]
    start: f64,
    /// How much to show, in seconds [default: all]. The whole song is read for its level; not with --fixed-level.
    #[arg(long, allow_negative_numbers = true, value_parser = seconds)]
    duration: Option<f64>,
}

/// One moment of the song; rounded, because the sixth digit of an amplitude is noise.
#[derive(serde::Serialize)]
struct Frame {
    time_secs: f64,
    mid: Vec<f64>,
    side: Vec<f64>,
}

/// Where a song is not read as a whole, it is read from this long before what is shown, so that levels settle, to this
/// long after.
const AROUND_SECS: f64 = 4.0;
const JSON_FPS: f64 = 20.0;
const PICTURE_COLUMNS: f64 = 1200.0;

impl Spectrum {
    /// Runs the command.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        self.render.as_deref().map_or(Ok(()), check_picture)?;
        let (song, from_secs) = self.read(terminal)?;
        let shown = source::frames_of(&song, self.start - from_secs, self.duration).ok_or_else(|| {
            let (name, ends_secs) = (self.song.display(), from_secs + song.duration_secs());
            Error::Input(format!("{name}: ends after {ends_secs:.1} s: there is nothing to show"))
        })?;
        let shown_secs = shown.len() as f64 / f64::from(song.rate_hz);
        let fps = self.frames_a_second(shown_secs)?;
        let moments = Moments { from_secs, fps, start_secs: self.start, shown_secs };
        if self.render.is_some() {
            picture::check(moments.count(), self.bands)?;
        }
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
        let mut ear = SongSpectrum::new(Arc::new(song), settings, 0.0)?;
        let Some(path) = &self.render else { return print_json(terminal, &moments, &mut ear) };
        let mut frames = Vec::new();
        let keep = |frame| {
            frames.push(frame);
            Ok(())
        };
        terminal.watch("spectrum", |task| moments.hear(&mut ear, task, keep))?;
        let picture = picture::spectrogram(&frames).map_err(Error::other)?;
        write_file(path, &picture)?;
        terminal.wrote(path)
    }

    /// What is needed of the song, and where it begins in its file: all of it, whose level is followed, unless it is too
    /// long or its level does not matter.
    fn read(&self, watcher: &impl Watcher) -> Result<(Song, f64), Error> {
        source::check_stretch(self.start, self.duration)?;
        // A whole second, from which the song is heard at the same times as from its beginning.
        let from_secs = (self.start - AROUND_SECS).max(0.0).floor();
        let heard_secs = self.duration.map(|secs| self.start - from_secs + secs + AROUND_SECS);
        let part = || source::song(&self.song, from_secs, heard_secs, watcher).map(|song| (song, from_secs));
        if self.fixed_level {
            return part();
        }
        match source::song(&self.song, 0.0, None, watcher) {
            Err(Error::Sound(SoundError::TooLong { .. })) if heard_secs.is_some() || from_secs > 0.0 => {
                let message = "is too long to be read as a whole: the level is that of the part";
                watcher.warn(Warning::of(self.song.display(), message));
                part()
            }
            Err(error @ Error::Sound(SoundError::TooLong { .. })) => {
                Err(Error::Input(format!("{error}; give --start and --duration")))
            }
            song => Ok((song?, 0.0)),
        }
    }

    /// Frames per second of a song that lasts `secs`.
    fn frames_a_second(&self, secs: f64) -> Result<f64, Error> {
        match (self.fps, &self.render) {
            (Some(fps), _) if (0.1..=1000.0).contains(&fps) => Ok(fps),
            (Some(_), _) => Err(Error::input("--fps must lie between 0.1 and 1000")),
            (None, Some(_)) => Ok((PICTURE_COLUMNS / secs.max(0.1)).min(200.0)),
            (None, None) => Ok(JSON_FPS),
        }
    }
}

/// Moments of a song; i is i / fps after the first.
struct Moments {
    /// Where the song that is heard begins in its file.
    from_secs: f64,
    fps: f64,
    /// When the first one is, in the file.
    start_secs: f64,
    /// Within which they lie.
    shown_secs: f64,
}

impl Moments {
    /// At least one, and none at the end, up to rounding.
    fn count(&self) -> u64 {
        (self.shown_secs * self.fps - 1e-6).ceil().max(1.0) as u64
    }

    /// Gives `take` the frame of each moment. What is read before the first is heard in steps as well: it may take long, and
    /// can be canceled.
    fn hear(
        &self,
        ear: &mut SongSpectrum,
        task: &Task,
        mut take: impl FnMut(Frame) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let before = ((self.start_secs - self.from_secs) * self.fps).floor() as i64;
        let stage = task.stage("spectrum", before.unsigned_abs() + self.count());
        let rounded = |bands: &[f32]| bands.iter().map(|&x| (f64::from(x) * 1e6).round() / 1e6).collect();
        for i in -before..self.count() as i64 {
            task.check()?;
            let time_secs = self.start_secs + i as f64 / self.fps;
            let spectrum = ear.at(time_secs - self.from_secs);
            if i >= 0 {
                take(Frame { time_secs, mid: rounded(&spectrum.mid), side: rounded(&spectrum.side) })?;
            }
            stage.advance(1);
        }
        Ok(())
    }
}

/// One frame a line, as soon as it is analyzed, so that hours of music need no memory.
fn print_json(terminal: &Terminal, moments: &Moments, ear: &mut SongSpectrum) -> Result<(), Error> {
    terminal.result(format_args!(
        "{{\"rate_hz\": {}, \"bands_hz\": {}, \"frames\": [",
        ear.settings().rate_hz,
        serde_json::to_string(ear.bands_hz()).map_err(Error::other)?
    ))?;
    let mut left = moments.count();
    let mut print = |task: &Task| {
        moments.hear(ear, task, |frame| {
            left = left.saturating_sub(1);
            let comma = if left > 0 { "," } else { "" };
            terminal.result(format_args!("{}{comma}", serde_json::to_string(&frame).map_err(Error::other)?))
        })
    };
    // At a terminal the numbers are the progress, between which a bar would be drawn.
    if std::io::stdout().is_terminal() { print(terminal.task()) } else { terminal.watch("spectrum", print) }?;
    terminal.result("]}")
}

/// Amplitudes as colors.
mod picture {
    use super::Frame;
    use crate::work::Error;

    /// Amplitudes this far below 1 are black.
    const RANGE_DB: f64 = 60.0;
    /// Height of each of the two spectrograms, at least.
    const LEAST_HEIGHT: usize = 360;
    const LEAST_WIDTH: usize = 600;
    /// Between the middle's and the side's spectrogram.
    const GAP: usize = 6;
    /// Some hundred megabytes while it is drawn.
    const MOST_PIXELS: usize = 64_000_000;

    /// How a number of frames and bands is drawn.
    struct Layout {
        frame_width: usize,
        band_height: usize,
        width: usize,
        /// Of one spectrogram.
        half: usize,
    }

    impl Layout {
        fn of(frames: usize, bands: usize) -> Self {
            let (frames, bands) = (frames.max(1), bands.max(1));
            let (frame_width, band_height) = (LEAST_WIDTH.div_ceil(frames), LEAST_HEIGHT.div_ceil(bands));
            let (width, half) = (frame_width.saturating_mul(frames), band_height.saturating_mul(bands));
            Self { frame_width, band_height, width, half }
        }

        fn height(&self) -> usize {
            self.half.saturating_mul(2).saturating_add(GAP)
        }
    }

    /// Checks, before any work, that the picture of so long a song is not too large.
    ///
    /// # Errors
    /// [`Error::Input`] with its size.
    pub fn check(frames: u64, bands: usize) -> Result<(), Error> {
        let layout = Layout::of(usize::try_from(frames).unwrap_or(usize::MAX), bands);
        let (width, height) = (layout.width, layout.height());
        if width.saturating_mul(height) > MOST_PIXELS {
            return Err(Error::Input(format!(
                "a picture of {width}×{height} pixels is too large: take a smaller --fps, fewer --bands or a shorter \
                 --duration"
            )));
        }
        Ok(())
    }

    /// A PNG: time to the right, the middle above and the side below, low bands at the bottom.
    pub fn spectrogram(frames: &[Frame]) -> Result<Vec<u8>, png::EncodingError> {
        let bands = frames.first().map_or(1, |frame| frame.mid.len().max(1));
        let layout = Layout::of(frames.len(), bands);
        let height = layout.height();
        let Layout { frame_width, band_height, width, half } = layout;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_end_before_the_end_whatever_its_product_with_their_rate_is_rounded_to() {
        let count =
            |shown_secs: f64, fps: f64| Moments { from_secs: 0.0, fps, start_secs: 0.0, shown_secs }.count();
        // The product is 7.000000000000001.
        assert_eq!((count(0.07, 100.0), count(0.071, 100.0), count(0.07, 0.1)), (7, 8, 1));
        assert_eq!(count(1.0 / 768_000.0, 0.1), 1);
    }

    #[test]
    fn a_picture_of_an_hour_at_a_thousand_frames_a_second_is_refused() {
        let hour = 3600;
        let why = picture::check(1000 * hour, 128).unwrap_err();
        assert!(why.is_of_input() && why.to_string().contains("--fps"), "{why}");
        assert!(picture::check(u64::MAX, usize::MAX).is_err());
        // The widest without --fps, and most bands.
        assert!(picture::check(1200, 4096).is_ok() && picture::check(20 * hour, 128).is_ok());
    }
}
