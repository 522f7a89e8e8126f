//! Films of a shape that dances: frame-exact, with their sound. The window and the command make theirs here.

mod animation;
mod beginning;
mod output;
mod performance;
mod record;
mod report;
mod songs;
mod titles;

use std::path::{Path, PathBuf};
use std::time::Instant;

use chladni_music::{BeatReading, ClockTrack, Ensemble, Instrument, Preset, Show, Stretch, Viewpoint};
use chladni_sound::{WavSample, write_wav};
use chladni_view::{Film as Reel, FilmFormat, FilmSettings, Look};

use super::body::laplacian;
use super::dancer::{Dancing, classes};
use super::{
    Cast, Error, HARMONICS, Hearing, Scenery, Stance, Warning, Watcher, first_looks, is_flat, look_named,
    opening_looks, opening_view,
};
use animation::Animation;
pub use animation::Approximation;
pub use beginning::Beginning;
pub use output::{Output, TARGETS};
use performance::{Done, Means, Performance};
pub use report::{Report, Seconds};
use songs::Songs;
use titles::Titles;

/// A film that is wanted.
pub struct Film {
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
    /// The clock that was followed in place of the songs' beats.
    pub clock: ClockTrack,
    /// How long the show is; as long as the first song where that is not said.
    pub show_secs: Option<f64>,
    /// How it begins and what is done.
    pub beginning: Beginning,
    /// Of shapes, lights and background.
    pub look: Look,
    /// The file of a picture that stands behind them, or none.
    pub picture: String,
    /// That of a panorama that shines on them.
    pub panorama: String,
    /// Where the viewer stands.
    pub viewpoint: Viewpoint,
    /// Dances, looks and strength change with the music, whatever is on stage in the beginning.
    pub autopilot: bool,
    /// Where in the show the film begins.
    pub start_secs: f64,
    /// How much of it is filmed; all unless said.
    pub duration_secs: Option<f64>,
    /// What is written of it.
    pub output: Output,
}

impl Film {
    /// `body` dances to all of `song` as `beginning` says, with its opening look.
    pub fn new(body: String, song: String, beginning: Beginning, output: Output) -> Self {
        Self {
            look: look_named(&opening_looks(&body)).0,
            viewpoint: opening_view(&body),
            picture: String::new(),
            panorama: String::new(),
            body,
            songs: vec![(song, BeatReading::default())],
            stance: Stance::default(),
            harmonics: HARMONICS,
            paper: false,
            heard: Vec::new(),
            clock: ClockTrack::default(),
            show_secs: None,
            beginning,
            autopilot: false,
            start_secs: 0.0,
            duration_secs: None,
            output,
        }
    }

    /// The film of a show, whose body and songs were found.
    pub fn of_show(show: Show, body: String, songs: Vec<(String, BeatReading)>, output: Output) -> Self {
        let looks = show.looks.clone().unwrap_or_else(first_looks);
        let (heard, clock) = (show.heard.clone(), show.clock.clone());
        Self {
            body,
            songs,
            stance: Stance::default(),
            paper: false,
            harmonics: show.harmonics.unwrap_or(HARMONICS),
            heard,
            clock,
            show_secs: show.duration_secs,
            look: look_named(&looks).0,
            picture: looks.picture,
            panorama: looks.panorama,
            viewpoint: show.viewpoint,
            autopilot: false,
            start_secs: 0.0,
            duration_secs: None,
            output,
            beginning: Beginning { show: Some(Box::new(show)), ..Beginning::default() },
        }
    }
}

/// Makes a film.
///
/// # Errors
/// Whatever is wrong with its body, its songs or its files. No unfinished film is left.
pub fn make(wanted: Film, watcher: &impl Watcher) -> Result<Report, Error> {
    let began = Instant::now();
    wanted.check()?;
    let scenery = Scenery::open(&wanted.picture, &wanted.panorama)?;
    let output = wanted.output;
    let cast = Cast::open(Path::new(&wanted.body), watcher)?;
    // The orientation decides which half hears the left channel, so it is needed even without pictures.
    let stands = cast.stands(wanted.stance, watcher)?;
    let range = (wanted.start_secs, wanted.duration_secs);
    let mut songs = Songs::open(&wanted.songs, wanted.heard, wanted.show_secs, range, watcher)?;
    let mut seconds = Seconds { reading: began.elapsed().as_secs_f64(), ..Seconds::default() };
    let preparing = Instant::now();
    let mesh = cast.mesh().clone();
    let (body, voices) = cast.prepare(wanted.harmonics, laplacian(wanted.paper), false, watcher)?;
    let symmetry = watcher.watch("finding the mirror", |task| classes(&body, wanted.paper, task))?;
    let Dancing { body, dancer, .. } = Dancing::new(&body, symmetry, &stands)?;
    seconds.preparing = preparing.elapsed().as_secs_f64();
    let listening = Instant::now();
    songs.track_beats(watcher)?;
    seconds.beats = listening.elapsed().as_secs_f64();

    let rest: Vec<[f32; 3]> = body.positions.iter().map(|p| p.map(|c| c as f32)).collect();
    let (instrument, script) = wanted.beginning.begin(&dancer, is_flat(&rest))?;
    let frames = output.rate.frames_in(songs.film_secs());
    let range = output.range(frames)?;
    let film_secs = output.rate.start_secs(frames);
    let (tempo_bpm, beat_confidence) = songs.tempo();
    let box_diagonal = dancer.box_diagonal;
    let ensemble = Ensemble::new(dancer).with_voices(voices.into_iter().map(|(_, term)| term).collect())?;
    let mut hearing = Hearing::from(wanted.start_secs);
    songs.tell(&mut hearing);
    hearing.know_clock(wanted.clock);
    let mut performance = Performance::new(
        (&body, stands),
        ensemble,
        hearing,
        (instrument, script),
        songs.stretches().to_vec(),
        wanted.start_secs,
        output.rate,
    )?;
    if output.allow_flashes {
        performance.allow_flashes();
    }
    if output.flash_fields {
        performance.judge_fields();
    }
    if wanted.autopilot {
        performance.pilot()?;
    }
    if output.titles {
        performance.name_songs(Titles::of(&wanted.songs, songs.stretches(), wanted.start_secs));
    }
    if output.shows_rest {
        performance.show_rest();
    }
    // Only now: a mesh or song that cannot be read leaves no empty folder behind.
    let folder = output.film.as_deref().filter(|_| output.is_folder);
    if let Some(folder) = folder {
        std::fs::create_dir_all(folder).map_err(|error| Error::unwritten(folder, error))?;
    }
    let recording = output.coefficients.is_some();
    let mut animation = output.animation.as_ref().map(|_| Animation::new(frames, box_diagonal));
    let done = match (&output.film, output.pipe) {
        _ if range.is_empty() => Done::default(),
        (path, pipe) if path.is_some() || pipe.is_some() => {
            let sound = path.as_deref().filter(|_| output.piece.is_none());
            let sound = sound.map(|path| sound_for(path, &songs, watcher)).transpose()?.flatten();
            let settings = FilmSettings {
                width: output.width,
                height: output.height,
                rate: output.rate,
                frames: range.end - range.start,
                first: range.start,
                audio: sound.as_ref().map(|file| file.path().to_owned()),
            };
            let film = match (path, pipe) {
                (Some(path), _) => Reel::create(path, settings)?,
                (None, pipe) => Reel::to_pipe(std::io::stdout(), pipe.unwrap_or_default(), settings)?,
            };
            let means = Means { draw: output.draw, samples: output.samples, synthesis: output.synthesis };
            let scene = (&wanted.look, &wanted.viewpoint, &scenery);
            watcher.watch("filming", |task| {
                performance.film(film, scene, means, recording, &mut seconds, task)
            })?
        }
        _ => watcher.watch("dancing", |task| {
            performance.rehearse(range.clone(), &mut seconds, task, |form, items| {
                match (&mut animation, items) {
                    (Some(_), [_, _, ..]) => {
                        Err(Error::input("a GLB holds one dance, not a gallery of them"))
                    }
                    (Some(animation), [item]) => {
                        animation.push(form, item);
                        Ok(())
                    }
                    _ => Ok(()),
                }
            })
        })?,
    };
    let approximation = match (&output.animation, &animation) {
        (Some(path), Some(animation)) => {
            let approximation = watcher.watch("writing the morph targets", |_| {
                animation.write(path, &mesh, &body, output.rate, output.targets)
            })?;
            save_sound(&sound_beside(path), &songs)?;
            Some(approximation)
        }
        _ => None,
    };
    if let Some(folder) = folder {
        save_sound(&folder.join("sound.wav"), &songs)?;
    }
    if let Some(path) = &output.coefficients {
        done.recording.write(path).map_err(|error| Error::unwritten(path, error))?;
    }
    if let Some(folder) = &output.presets {
        save_presets(folder, performance.instrument())?;
    }
    for message in &done.warnings {
        watcher.warn(Warning::Plain(message.clone()));
    }
    seconds.total = began.elapsed().as_secs_f64();
    Ok(Report {
        vertices: body.positions.len(),
        harmonics: body.basis.harmonics(),
        frames: range.end - range.start,
        film_secs,
        times_real_time: film_secs / seconds.total,
        tempo_bpm,
        beat_confidence,
        largest_displacement: done.largest_displacement,
        by_processor: done.drawn.as_ref().filter(|drawn| drawn.software).map(|drawn| drawn.samples),
        device: done.drawn.as_ref().map(|drawn| drawn.device.clone()),
        samples: done.drawn.as_ref().map(|drawn| drawn.samples.count()),
        synthesis: done.drawn.map(|drawn| drawn.synthesis),
        flashes_in_worst_second: done.most_flashes,
        longest_stripes_secs: done.longest_stripes_secs,
        frames_damped: done.damped_frames,
        approximation,
        seconds,
    })
}

impl Film {
    /// Checks, before any work, that it can be made.
    fn check(&self) -> Result<(), Error> {
        self.output.check()?;
        self.stance.check()?;
        if let Some(sound) = self.output.animation.as_deref().map(sound_beside) {
            let place = sound.canonicalize().ok();
            let is_heard = |(song, _): &(String, BeatReading)| {
                place.is_some() && Path::new(song).canonicalize().ok() == place
            };
            if self.songs.iter().any(is_heard) {
                let sound = sound.display();
                return Err(Error::Input(format!(
                    "the sound beside the GLB would replace the song {sound}: give the GLB another name"
                )));
            }
        }
        let times = [Some(self.start_secs), self.duration_secs.map(|d| d.max(-1.0))];
        if times.iter().flatten().any(|secs| !(secs.is_finite() && *secs >= 0.0))
            || self.duration_secs == Some(0.0)
        {
            return Err(Error::input("start must not be negative and the duration must be positive"));
        }
        Ok(())
    }
}

/// Each item of the gallery as a preset, `item-01.toml` and so on.
fn save_presets(folder: &Path, instrument: &Instrument) -> Result<(), Error> {
    std::fs::create_dir_all(folder).map_err(|error| Error::unwritten(folder, error))?;
    for (i, item) in instrument.gallery().items().iter().enumerate() {
        let path = folder.join(format!("item-{:02}.toml", i + 1));
        Preset::of(instrument, item, Vec::new()).save(&path).map_err(Error::unsaved)?;
    }
    Ok(())
}

/// Where the sound of an animation goes.
pub fn sound_beside(animation: &Path) -> PathBuf {
    animation.with_extension("wav")
}

fn save_sound(path: &Path, songs: &Songs) -> Result<(), Error> {
    write_wav(path, &songs.sound()?, WavSample::Int16).map_err(|error| Error::unwritten(path, error))
}

/// The sound that an MP4 is given, as a temporary file.
fn sound_for(
    film: &Path,
    songs: &Songs,
    watcher: &impl Watcher,
) -> Result<Option<tempfile::NamedTempFile>, Error> {
    if FilmFormat::of(film).map_err(Error::input)? != FilmFormat::Mp4 {
        return Ok(None);
    }
    let file = tempfile::Builder::new().prefix("chladni-").suffix(".wav").tempfile().map_err(Error::other)?;
    let sound = songs.sound()?;
    watcher.watch("writing the sound", |_| write_wav(file.path(), &sound, WavSample::Int16))?;
    Ok(Some(file))
}
