//! `chladni dance MESH SONG`: a film of a shape that dances, frame-exact, with its sound. The window makes its
//! films here, too.

mod arguments;
mod cast;
mod film;
mod guard;
mod record;
mod sound;
mod theatre;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use chladni_mesh::Orientation;
use chladni_music::{
    BeatReading, Dancer, Ensemble, GalleryShape, Instrument, LoggedAction, Parameter, Preset, Show, Stretch,
    Symmetry, SymmetrySettings, Viewpoint,
};
use chladni_sound::{WavSample, write_wav};
use chladni_synth::Backend;
use chladni_view::{Film, FilmFormat, FilmSettings, FrameRate, Samples, ffmpeg_is_there};
use serde::Serialize;

use super::inputs::laplacian;
use super::outputs::check_file;
use super::stance::Stance;
use super::{Failure, Terminal};
use crate::dance::{HARMONICS, Hearing, Look, look_named};
pub use arguments::{Dance, Fps, Size};
use cast::Cast;
use film::{Means, Performance};
use sound::Songs;

/// The instrument as it begins on a body, and what will be done to it.
pub type Begin = Box<dyn FnOnce(&Dancer) -> Result<(Instrument, Vec<LoggedAction>), Failure> + Send>;

/// A film that is wanted.
pub struct Request {
    /// A mesh, a sample or a caricature, as the command line calls it.
    pub body: String,
    /// Songs or samples, by the numbers that `heard` has for them.
    pub songs: Vec<(String, BeatReading)>,
    /// How the body stands.
    pub stance: Stance,
    /// K.
    pub harmonics: usize,
    /// Harmonics and classes as in the paper.
    pub paper: bool,
    /// Which song is heard when; the first one from its beginning where this is empty.
    pub heard: Vec<Stretch>,
    /// How long the show is; as long as the first song where that is not said.
    pub show_secs: Option<f64>,
    /// How it begins and what is done.
    pub begin: Begin,
    /// Of shapes, lights and background.
    pub look: Look,
    /// Where the viewer stands.
    pub viewpoint: Viewpoint,
    /// Where in the show the film begins.
    pub start_secs: f64,
    /// How much of it is filmed; all unless said.
    pub duration_secs: Option<f64>,
    /// What becomes of it.
    pub output: Output,
}

/// What is written, and how it is drawn.
#[derive(Clone, Debug)]
pub struct Output {
    /// The film's file or folder; none is drawn without.
    pub film: Option<PathBuf>,
    /// It is a folder of pictures, with the sound beside them.
    pub is_folder: bool,
    /// Where the coefficients of every frame go.
    pub coefficients: Option<PathBuf>,
    /// Where the mapping of each item of the gallery goes, as presets.
    pub presets: Option<PathBuf>,
    /// The shape at rest is shown, too, as dots.
    pub shows_rest: bool,
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Frames a second.
    pub rate: FrameRate,
    /// Of each pixel; what suits the device unless said.
    pub samples: Option<Samples>,
    /// Who deforms.
    pub synthesis: Backend,
    /// More than three a second.
    pub allow_flashes: bool,
}

impl Request {
    /// The film of a show, whose body and songs were found.
    pub fn of_show(show: Show, body: String, songs: Vec<(String, BeatReading)>, output: Output) -> Self {
        let looks = show.looks.clone().unwrap_or_else(crate::studio::first_looks);
        let heard = show.heard.clone();
        Self {
            body,
            songs,
            stance: Stance::default(),
            paper: false,
            harmonics: show.harmonics.unwrap_or(HARMONICS),
            heard,
            show_secs: show.duration_secs,
            look: look_named(&looks).0,
            viewpoint: show.viewpoint,
            start_secs: 0.0,
            duration_secs: None,
            output,
            begin: Box::new(move |dancer| {
                let bands = Parameter::Bands.initial() as usize;
                let shape = GalleryShape { eigenvalues: dancer.eigenvalues.clone(), bands };
                let instrument = show.begin(shape).map_err(failure)?;
                Ok((instrument, show.actions))
            }),
        }
    }
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
pub struct Report {
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

/// Makes a film.
pub fn make(request: Request, terminal: &Terminal) -> Result<Report, Failure> {
    let begin = Instant::now();
    let output = request.output;
    output.check()?;
    request.stance.check()?;
    let times = [Some(request.start_secs), request.duration_secs.map(|d| d.max(-1.0))];
    if times.iter().flatten().any(|secs| !(secs.is_finite() && *secs >= 0.0))
        || request.duration_secs == Some(0.0)
    {
        return Err(Failure::BadInput("start must not be negative and the duration must be positive".into()));
    }
    let cast = Cast::open(&request.body, terminal)?;
    // Only pictures ask how it stands.
    let stands = match output.film {
        Some(_) => cast.stands(request.stance, terminal)?,
        None => Orientation::Y_UP,
    };
    let range = (request.start_secs, request.duration_secs);
    let mut songs = Songs::open(&request.songs, request.heard, request.show_secs, range, terminal)?;
    let mut seconds = Seconds { reading: begin.elapsed().as_secs_f64(), ..Seconds::default() };
    let preparing = Instant::now();
    let (body, voices) = cast.prepare(request.harmonics, laplacian(request.paper), terminal)?;
    let classes = SymmetrySettings { by_vote: request.paper, ..SymmetrySettings::default() };
    let symmetry = terminal
        .watch("finding the mirror", |task| Symmetry::with(&body, &classes, task))
        .map_err(failure)?;
    let body = symmetry.rotated(&body);
    let dancer = Arc::new(Dancer::new(&body, &symmetry.classes).map_err(failure)?);
    seconds.preparing = preparing.elapsed().as_secs_f64();
    let listening = Instant::now();
    songs.track_beats(terminal)?;
    seconds.beats = listening.elapsed().as_secs_f64();

    let (instrument, script) = (request.begin)(&dancer)?;
    let frames = output.rate.frames_in(songs.film_secs());
    let film_secs = output.rate.start_secs(frames);
    let (tempo_bpm, beat_confidence) = songs.tempo();
    let ensemble = Ensemble::new(dancer).with_voices(voices).map_err(failure)?;
    let mut hearing = Hearing::from(request.start_secs);
    songs.tell(&mut hearing);
    let mut performance = Performance::new(
        (&body, stands),
        ensemble,
        hearing,
        (instrument, script),
        songs.stretches().to_vec(),
        request.start_secs,
        output.rate,
    )?;
    if output.allow_flashes {
        performance.allow_flashes();
    }
    if output.shows_rest {
        performance.show_rest();
    }
    // Only now: a mesh or song that cannot be read leaves no empty folder behind.
    let folder = output.film.as_deref().filter(|_| output.is_folder);
    if let Some(folder) = folder {
        std::fs::create_dir_all(folder).map_err(|error| Failure::writing(folder, error))?;
    }
    let recording = output.coefficients.is_some();
    let done = match &output.film {
        Some(path) => {
            let sound = sound_for(path, &songs, terminal)?;
            let settings = FilmSettings {
                width: output.width,
                height: output.height,
                rate: output.rate,
                frames,
                audio: sound.as_ref().map(|file| file.path().to_owned()),
            };
            let film = Film::create(path, settings).map_err(view_failure)?;
            let means = Means { draw: terminal.draw(), samples: output.samples, synthesis: output.synthesis };
            let scene = (&request.look, &request.viewpoint);
            terminal.watch("filming", |task| {
                performance.film(film, scene, means, recording, &mut seconds, task)
            })?
        }
        None => terminal.watch("dancing", |task| performance.rehearse(frames, &mut seconds, task))?,
    };
    if let Some(folder) = folder {
        let path = folder.join("sound.wav");
        write_wav(&path, &songs.sound()?, WavSample::Int16)
            .map_err(|error| Failure::writing(&path, error))?;
    }
    if let Some(path) = &output.coefficients {
        done.recording.write(path).map_err(|error| Failure::writing(path, error))?;
    }
    if let Some(folder) = &output.presets {
        save_presets(folder, performance.instrument())?;
        terminal.wrote(folder)?;
    }
    done.warnings.iter().for_each(|warning| terminal.warn(warning));
    if let Some(drawn) = done.drawn.as_ref().filter(|drawn| drawn.software && output.samples.is_none()) {
        terminal.note(format_args!(
            "no graphics card: drawn by {} with {} (--samples 4 is slower and finer)",
            drawn.device, drawn.samples
        ));
    }
    seconds.total = begin.elapsed().as_secs_f64();
    Ok(Report {
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
    })
}

impl Report {
    fn tell(&self, terminal: &Terminal) {
        let s = &self.seconds;
        terminal.note(format_args!(
            "{} frames in {:.1} s: reading {:.1}, harmonics {:.1}, beats {:.1}, spectra {:.1}, mapping {:.2}, \
             synthesis {:.1}, normals {:.1}, drawing {:.1}, flash guard {:.1}, waiting for the encoder {:.1}",
            self.frames, s.total, s.reading, s.preparing, s.beats, s.analysis, s.mapping, s.synthesis, s.normals,
            s.drawing, s.guarding, s.encoding
        ));
    }
}

impl Output {
    /// Before any work: can it be written at all?
    fn check(&self) -> Result<(), Failure> {
        if let Some(path) = self.film.as_deref().filter(|_| !self.is_folder) {
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
    songs: &Songs,
    terminal: &Terminal,
) -> Result<Option<tempfile::NamedTempFile>, Failure> {
    if FilmFormat::of(film).map_err(Failure::input)? != FilmFormat::Mp4 {
        return Ok(None);
    }
    let file =
        tempfile::Builder::new().prefix("chladni-").suffix(".wav").tempfile().map_err(Failure::other)?;
    let sound = songs.sound()?;
    terminal
        .watch("writing the sound", |_| write_wav(file.path(), &sound, WavSample::Int16))
        .map_err(Failure::other)?;
    Ok(Some(file))
}

fn failure(error: chladni_music::Error) -> Failure {
    match error {
        chladni_music::Error::Cancelled(_) => Failure::Cancelled,
        error => Failure::input(error),
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
