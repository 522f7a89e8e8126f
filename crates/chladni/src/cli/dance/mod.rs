//! `chladni dance MESH SONG`: a film of a shape that dances, frame-exact, with its sound.

mod cast;
mod guard;
mod hearing;
mod record;
mod show;

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;
use std::time::Instant;

use chladni_music::{
    Action, Dancer, Ensemble, Form, GalleryShape, Instrument, LoggedAction, Mapping, Moment, PAPER_MODE,
    Parameter, Preset, Session, Symmetry, SymmetrySettings,
};
use chladni_sound::{Song, WavSample, track_beats, write_wav};
use chladni_synth::Backend;
use chladni_view::{
    Background, Film, FilmFormat, FilmSettings, FrameRate, Lights, Material, Samples, ffmpeg_is_there,
};
use serde::Serialize;

use super::inputs::{laplacian, open_song};
use super::outputs::check_file;
use super::{Failure, Terminal};
use cast::Cast;
use hearing::Hearing;
use show::{Look, Means, Show};

/// Film a shape that dances to a song.
#[derive(clap::Args)]
#[command(group(clap::ArgGroup::new("result").required(true).multiple(true).args(["output", "frames", "coefficients"])))]
pub struct Dance {
    /// A mesh file or sample:NAME; or a caricature (.chladni), whose layers become
    /// voices that the song drives: the bass, the beat, the side and the treble in turn, unless a
    /// session says otherwise.
    mesh: String,
    /// A song (WAV, FLAC, MP3, Ogg Vorbis, Opus, M4A, AIFF) or sample:tune.
    song: String,
    /// The film: .mp4 with sound (needs ffmpeg), .gif or .png (animated, silent).
    #[arg(short, long, value_name = "FILM")]
    output: Option<PathBuf>,
    /// Write PNG frames and sound.wav into this folder; needs no other program.
    #[arg(long, value_name = "DIR", conflicts_with = "output")]
    frames: Option<PathBuf>,
    /// Width and height in pixels.
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1280x720")]
    size: Size,
    /// Frames per second: a number, or a fraction such as 30000/1001.
    #[arg(long, default_value = "30")]
    fps: Fps,
    /// Where in the song to begin, in seconds.
    #[arg(long, default_value_t = 0.0)]
    start: f64,
    /// How much of the song, in seconds; all of it unless given.
    #[arg(long)]
    duration: Option<f64>,
    /// Seed of all that is random: the reactions to the beat and, without preset and session,
    /// a mapping bred from the gallery of this seed instead of the direct one.
    #[arg(long)]
    seed: Option<u64>,
    /// Dance as this preset says.
    #[arg(long, value_name = "P.toml", conflicts_with = "session")]
    preset: Option<PathBuf>,
    /// Replay this session.
    #[arg(long, value_name = "R.toml")]
    session: Option<PathBuf>,
    /// Show the whole gallery of this many items (6, 9, 12 or 16) instead of one.
    #[arg(long, value_name = "S", conflicts_with_all = ["preset", "session"])]
    gallery: Option<usize>,
    /// half-mask: each half dances to its own channel; modal: along the normals, as a sounding plate;
    /// filter: the paper's, which shows left and right alike. A session's own form unless given, else half-mask.
    #[arg(long, value_parser = parse_form)]
    form: Option<Form>,
    /// How strongly it moves, 0 to 20.
    #[arg(long)]
    gain: Option<f32>,
    /// K, the number of harmonics.
    #[arg(short = 'k', long, value_name = "K", default_value_t = 256)]
    harmonics: usize,
    /// Paper mode: harmonics of the plain cotangent Laplacian, which not every mesh can have, their
    /// classes by the vote of the extrema, the filter form, linear bands and blended normals.
    #[arg(long)]
    paper: bool,
    /// Write times_secs and coefficients (frames×K×3, or frames×K for the modal form) here.
    #[arg(long, value_name = "C.npz")]
    coefficients: Option<PathBuf>,
    /// Write the mapping of each item of the gallery into this folder, as presets.
    #[arg(long, value_name = "DIR")]
    presets: Option<PathBuf>,
    /// Show the shape at rest, too, as dots.
    #[arg(long)]
    rest: bool,
    /// Lights: studio, soft, dramatic, stage.
    #[arg(long, default_value = "stage", value_parser = named(Lights::named, names(&Lights::PRESETS)))]
    lights: Lights,
    /// Material: clay, porcelain, bronze, pearl, dark.
    #[arg(long, default_value = "pearl", value_parser = named(Material::named, names(&Material::PRESETS)))]
    material: Material,
    /// Background: paper, slate, night, white, transparent.
    #[arg(long, default_value = "night", value_parser = named(Background::named, names(&Background::PRESETS)))]
    background: Background,
    /// Turn of the shape in degrees, to begin with.
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    yaw: f32,
    /// Samples a pixel: 4, or 1 with edges smoothed afterwards. Unless given, 4 on a graphics card and
    /// 1 where the processor draws.
    #[arg(long, value_name = "1|4")]
    samples: Option<Samples>,
    /// Where shapes are deformed: cpu, gpu, or auto, which is the graphics card where there is one.
    #[arg(long, value_name = "WHERE", default_value = "auto", value_parser = parse_backend)]
    synthesis: Backend,
    /// Do not limit flashes to three a second.
    #[arg(long)]
    allow_flashes: bool,
    /// Print a report as JSON: what was made, and where the time went.
    #[arg(long)]
    json: bool,
}

/// Where the time went, in seconds.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Seconds {
    /// Reading mesh and song.
    pub reading: f64,
    /// Harmonics, symmetry and all that is prepared once.
    pub preparing: f64,
    /// Beats of the whole song.
    pub beats: f64,
    /// Spectra.
    pub analysis: f64,
    /// From spectrum to coefficients.
    pub mapping: f64,
    /// Deformed positions.
    pub synthesis: f64,
    /// Normals.
    pub normals: f64,
    /// Drawing and fetching the pictures.
    pub drawing: f64,
    /// The flash guard's look at the frames.
    pub guarding: f64,
    /// Waiting for the encoder, which runs beside all this.
    pub encoding: f64,
    /// All.
    pub total: f64,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Report {
    vertices: usize,
    harmonics: usize,
    frames: u64,
    film_secs: f64,
    times_real_time: f64,
    tempo_bpm: f64,
    beat_confidence: f64,
    /// The farthest any vertex went, as a share of the bounding box's diagonal; unknown (null) where
    /// the shapes are deformed on a graphics card.
    largest_displacement: Option<f32>,
    /// The adapter that drew, samples a pixel, and who deformed the shapes; null where nothing is drawn.
    device: Option<String>,
    samples: Option<u32>,
    synthesis: Option<String>,
    flashes_in_worst_second: usize,
    frames_damped: usize,
    seconds: Seconds,
}

impl Dance {
    /// Makes the film.
    pub fn run(self, terminal: &Terminal) -> Result<(), Failure> {
        let begin = Instant::now();
        self.check_output()?;
        let cast = Cast::open(&self.mesh, terminal)?;
        let song = open_song(&self.song, self.start, self.duration, terminal)?;
        let mut seconds = Seconds { reading: begin.elapsed().as_secs_f64(), ..Seconds::default() };
        let preparing = Instant::now();
        let (body, voices) = cast.prepare(self.harmonics, laplacian(self.paper), terminal)?;
        let settings = SymmetrySettings { by_vote: self.paper, ..SymmetrySettings::default() };
        let symmetry = terminal
            .watch("finding the mirror", |task| Symmetry::with(&body, &settings, task))
            .map_err(failure)?;
        let body = symmetry.rotated(&body);
        let dancer = Arc::new(Dancer::new(&body, &symmetry.classes).map_err(failure)?);
        seconds.preparing = preparing.elapsed().as_secs_f64();
        let listening = Instant::now();
        let beats =
            terminal.watch("tracking the beat", |task| track_beats(&song, task)).map_err(Failure::input)?;
        seconds.beats = listening.elapsed().as_secs_f64();

        let (instrument, script) = self.instrument(&dancer)?;
        let frames = self.fps.0.frames_in(song.duration_secs());
        let film_secs = self.fps.0.start_secs(frames);
        let (tempo_bpm, beat_confidence) = (beats.tempo_bpm, beats.confidence);
        let hearing = Hearing::new(song, beats, instrument.parameters())?;
        let look = Look {
            lights: self.lights,
            material: self.material,
            background: self.background,
            yaw_rad: self.yaw.to_radians(),
            rest: self.rest,
        };
        let ensemble = Ensemble::new(dancer).with_voices(voices).map_err(failure)?;
        let mut show = Show::new(&body, ensemble, hearing, instrument, script, self.start, self.fps.0)?;
        if self.allow_flashes {
            show.allow_flashes();
        }
        // Only now: a mesh or song that cannot be read leaves no empty folder behind.
        if let Some(folder) = &self.frames {
            std::fs::create_dir_all(folder).map_err(|error| Failure::writing(folder, error))?;
        }
        let film = self.film_path();
        let recording = self.coefficients.is_some();
        let done = match &film {
            Some(path) => {
                let sound = sound_for(path, show.song(), terminal)?;
                let settings = FilmSettings {
                    width: self.size.width,
                    height: self.size.height,
                    rate: self.fps.0,
                    frames,
                    audio: sound.as_ref().map(|file| file.path().to_owned()),
                };
                let film = Film::create(path, settings).map_err(view_failure)?;
                let means = Means { samples: self.samples, synthesis: self.synthesis };
                terminal
                    .watch("filming", |task| show.film(film, &look, means, recording, &mut seconds, task))?
            }
            None => terminal.watch("dancing", |task| show.rehearse(frames, &mut seconds, task))?,
        };
        if let Some(folder) = &self.frames {
            let path = folder.join("sound.wav");
            write_wav(&path, show.song(), WavSample::Int16)
                .map_err(|error| Failure::writing(&path, error))?;
        }
        if let Some(path) = &self.coefficients {
            done.recording.write(path).map_err(|error| Failure::writing(path, error))?;
        }
        if let Some(folder) = &self.presets {
            save_presets(folder, show.instrument())?;
            terminal.wrote(folder)?;
        }
        done.warnings.iter().for_each(|warning| terminal.warn(warning));
        if let Some(drawn) = done.drawn.as_ref().filter(|drawn| drawn.software && self.samples.is_none()) {
            terminal.note(format_args!(
                "no graphics card: drawn by {} with {} (--samples 4 is slower and finer)",
                drawn.device, drawn.samples
            ));
        }
        seconds.total = begin.elapsed().as_secs_f64();
        let report = Report {
            vertices: body.positions.len(),
            harmonics: body.basis.harmonics(),
            frames,
            film_secs,
            times_real_time: film_secs / seconds.total,
            tempo_bpm,
            beat_confidence,
            largest_displacement: done.largest_displacement,
            device: done.drawn.as_ref().map(|drawn| drawn.device.clone()),
            samples: done.drawn.as_ref().map(|drawn| drawn.samples.count()),
            synthesis: done.drawn.map(|drawn| drawn.synthesis),
            flashes_in_worst_second: done.most_flashes,
            frames_damped: done.damped_frames,
            seconds,
        };
        self.tell(&report, film.as_deref(), terminal)
    }

    fn tell(&self, report: &Report, film: Option<&Path>, terminal: &Terminal) -> Result<(), Failure> {
        if self.json {
            return terminal.json(report);
        }
        for path in [film, self.coefficients.as_deref()].into_iter().flatten() {
            terminal.wrote(path)?;
        }
        let s = &report.seconds;
        terminal.note(format_args!(
            "{} frames in {:.1} s: reading {:.1}, harmonics {:.1}, beats {:.1}, spectra {:.1}, mapping {:.2}, \
             synthesis {:.1}, normals {:.1}, drawing {:.1}, flash guard {:.1}, waiting for the encoder {:.1}",
            report.frames, s.total, s.reading, s.preparing, s.beats, s.analysis, s.mapping, s.synthesis, s.normals,
            s.drawing, s.guarding, s.encoding
        ));
        Ok(())
    }

    fn film_path(&self) -> Option<PathBuf> {
        self.output.clone().or_else(|| self.frames.clone())
    }

    /// Before any work: can the film be written at all?
    fn check_output(&self) -> Result<(), Failure> {
        if let Some(path) = &self.output {
            let format = FilmFormat::of(path).map_err(Failure::input)?;
            if format == FilmFormat::Frames {
                let path = path.display();
                return Err(Failure::BadInput(format!(
                    "{path}: a film ends in .mp4, .gif or .png; for a folder use --frames"
                )));
            }
            if format == FilmFormat::Mp4 && !ffmpeg_is_there() {
                return Err(Failure::BadInput(
                    "an MP4 needs ffmpeg, which is not on the PATH: install it, write a .gif or .png, or use \
                     --frames DIR for PNG frames and a WAV"
                        .into(),
                ));
            }
            check_file(path)?;
        }
        self.coefficients.as_deref().map_or(Ok(()), check_file)
    }

    /// The instrument as the film begins, and what will be done to it.
    fn instrument(&self, dancer: &Dancer) -> Result<(Instrument, Vec<LoggedAction>), Failure> {
        let shape = |bands: usize| GalleryShape { eigenvalues: dancer.eigenvalues.clone(), bands };
        let bands = Parameter::Bands.initial() as usize;
        if let Some(path) = &self.session {
            let session = Session::load(path).map_err(|error| in_file(path, error))?;
            let mut instrument = session.begin(shape(bands)).map_err(|error| in_file(path, error))?;
            self.adjust(&mut instrument)?;
            return Ok((instrument, session.actions));
        }
        let seed = self.seed.unwrap_or(1);
        let size = self.gallery.unwrap_or(6);
        let mut instrument = Instrument::new(seed, size, shape(bands)).map_err(failure)?;
        self.adjust(&mut instrument)?;
        let mut act = |action| instrument.apply(Moment::default(), action).map_err(failure);
        if let Some(path) = &self.preset {
            let preset = Preset::load(path).map_err(|error| in_file(path, error))?;
            act(Action::Load { item: 0, name: preset.name, mapping: preset.mapping })?;
            act(Action::Perform { item: 0 })?;
        } else if self.gallery.is_none() {
            if self.seed.is_some() {
                (0..size).try_for_each(|item| act(Action::Choose { item, on: true }))?;
                act(Action::Breed)?;
            } else {
                let mapping = Mapping::direct(&dancer.eigenvalues, bands);
                act(Action::Load { item: 0, name: "direct".into(), mapping })?;
            }
            act(Action::Perform { item: 0 })?;
        }
        Ok((instrument, Vec::new()))
    }

    fn adjust(&self, instrument: &mut Instrument) -> Result<(), Failure> {
        let mut act = |action| instrument.apply(Moment::default(), action).map_err(failure);
        if self.paper {
            PAPER_MODE.into_iter().try_for_each(&mut act)?;
        }
        if let Some(form) = self.form {
            act(Action::SetForm { form })?;
        }
        if let Some(value) = self.gain {
            act(Action::Set { parameter: Parameter::Gain, value })?;
        }
        Ok(())
    }
}

/// Each item of the gallery as a preset, `item-01.toml` and so on.
fn save_presets(folder: &Path, instrument: &Instrument) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|error| Failure::writing(folder, error))?;
    for (i, item) in instrument.gallery().items().iter().enumerate() {
        let path = folder.join(format!("item-{:02}.toml", i + 1));
        Preset::of(instrument, item, Vec::new()).save(&path).map_err(Failure::other)?;
    }
    Ok(())
}

/// The sound that an MP4 is given, as a temporary file.
fn sound_for(
    film: &Path,
    song: &Song,
    terminal: &Terminal,
) -> Result<Option<tempfile::NamedTempFile>, Failure> {
    if FilmFormat::of(film).map_err(Failure::input)? != FilmFormat::Mp4 {
        return Ok(None);
    }
    let file =
        tempfile::Builder::new().prefix("chladni-").suffix(".wav").tempfile().map_err(Failure::other)?;
    terminal
        .watch("writing the sound", |_| write_wav(file.path(), song, WavSample::Int16))
        .map_err(Failure::other)?;
    Ok(Some(file))
}

/// Width and height.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Size {
    width: u32,
    height: u32,
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |t: &str| t.parse::<u32>().ok().filter(|n| (1..=16_384).contains(n));
        let (width, height) = text.split_once(['x', 'X']).ok_or("expected WIDTHxHEIGHT, such as 1280x720")?;
        match (number(width), number(height)) {
            (Some(width), Some(height)) => Ok(Self { width, height }),
            _ => Err("width and height are whole numbers from 1 to 16384".into()),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Fps(FrameRate);

impl FromStr for Fps {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "expected frames per second from 1 to 240, such as 30, 29.97 or 30000/1001".to_owned();
        let rate = |numerator: u32, denominator: u32| FrameRate { numerator, denominator };
        let rate = if let Some((n, d)) = text.split_once('/') {
            rate(n.parse().map_err(|_| wrong())?, d.parse().map_err(|_| wrong())?)
        } else if let Ok(whole) = text.parse::<u32>() {
            rate(whole, 1)
        } else {
            let fps: f64 = text.parse().map_err(|_| wrong())?;
            let ntsc = (fps.ceil() - fps / 0.999_000_999).abs() < 0.01;
            if ntsc {
                rate(1000 * fps.ceil() as u32, 1001)
            } else {
                rate((fps * 1000.0).round() as u32, 1000)
            }
        };
        let fps = f64::from(rate.numerator) / f64::from(rate.denominator.max(1));
        if rate.denominator > 0 && (1.0..=240.0).contains(&fps) { Ok(Self(rate)) } else { Err(wrong()) }
    }
}

fn parse_backend(text: &str) -> Result<Backend, String> {
    match text {
        "auto" => Ok(Backend::Auto),
        "cpu" => Ok(Backend::Cpu),
        "gpu" => Ok(Backend::Gpu),
        _ => Err("expected auto, cpu or gpu".into()),
    }
}

fn parse_form(text: &str) -> Result<Form, String> {
    match text {
        "filter" => Ok(Form::Filter),
        "modal" => Ok(Form::Modal),
        "half-mask" => Ok(Form::HalfMask),
        _ => Err("expected filter, modal or half-mask".into()),
    }
}

fn named<T: Send + Sync + Clone + 'static>(
    find: fn(&str) -> Option<T>,
    known: String,
) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |name| find(name).ok_or_else(|| format!("expected one of {known}"))
}

fn names<T>(presets: &[(&str, T)]) -> String {
    presets.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
}

fn failure(error: chladni_music::Error) -> Failure {
    match error {
        chladni_music::Error::Cancelled(_) => Failure::Cancelled,
        error => Failure::input(error),
    }
}

fn in_file(path: &Path, error: chladni_music::Error) -> Failure {
    match error {
        chladni_music::Error::File { .. } => Failure::input(error),
        error => Failure::BadInput(format!("{}: {error}", path.display())),
    }
}

impl From<chladni_view::ViewError> for Failure {
    fn from(error: chladni_view::ViewError) -> Self {
        view_failure(error)
    }
}

fn view_failure(error: chladni_view::ViewError) -> Failure {
    match error {
        chladni_view::ViewError::Cancelled(_) => Failure::Cancelled,
        error => Failure::other(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_and_sizes() {
        let fps = |t: &str| t.parse::<Fps>().map(|f| (f.0.numerator, f.0.denominator));
        assert_eq!(fps("30"), Ok((30, 1)));
        assert_eq!(fps("29.97"), Ok((30000, 1001)));
        assert_eq!(fps("23.976"), Ok((24000, 1001)));
        assert_eq!(fps("12.5"), Ok((12500, 1000)));
        assert!(fps("0").is_err() && fps("1/0").is_err() && fps("-3").is_err() && fps("nan").is_err());
        assert_eq!("640x360".parse(), Ok(Size { width: 640, height: 360 }));
        assert!("640".parse::<Size>().is_err() && "0x5".parse::<Size>().is_err());
    }
}
