//! Films of a shape that dances: frame-exact, with their sound. The window and the command make theirs here.

mod animation;
mod beginning;
mod output;
mod performance;
mod prepared;
mod record;
mod report;
mod songs;
mod titles;

use std::path::{Path, PathBuf};
use std::time::Instant;

use chladni_music::{BeatReading, ClockTrack, Show, Stretch, Viewpoint};
use chladni_view::Look;

use super::outputs::is_same_file;
use super::source::check_stretch;
use super::{
    Error, Scenery, Stance, Warning, Watcher, first_looks, look_named, make_folder, opening_looks,
    opening_view,
};
use animation::Animation;
pub use animation::Approximation;
pub use beginning::Beginning;
pub use output::{Output, TARGETS};
use performance::Done;
use prepared::Prepared;
pub use report::{Report, Seconds};

/// Why a gallery cannot be written as an animation.
const ONE_DANCE: &str = "a GLB holds one dance, not a gallery of them";

/// A film that is wanted.
pub struct Film {
    /// A mesh, a sample or a caricature, as the command line calls it.
    pub body: String,
    /// Songs or samples, by the numbers that `heard` has for them.
    pub songs: Vec<(String, BeatReading)>,
    /// How the body stands.
    pub stance: Stance,
    /// K; the show's own or the usual number unless given, or that of a project that has fewer.
    pub harmonics: Option<usize>,
    /// Harmonics and classes as in the paper.
    pub paper: bool,
    /// Which song is heard when; the first one from its beginning where this is empty.
    pub heard: Vec<Stretch>,
    /// The clock that was followed in place of the songs' beats.
    pub clock: ClockTrack,
    /// How long the show is; as long as the first song where that is not said.
    pub show_secs: Option<f64>,
    /// How it begins, and the actions in it.
    pub beginning: Beginning,
    /// The preset or the show that says so, where it was read from a file.
    pub read_from: Option<PathBuf>,
    /// The look of shapes, lights and background.
    pub look: Look,
    /// The file of a picture that stands behind them, or none.
    pub picture: String,
    /// The file of a panorama that shines on them.
    pub panorama: String,
    /// Where the viewer stands.
    pub viewpoint: Viewpoint,
    /// Dances, looks and strength change with the music, whatever is on stage in the beginning.
    pub autopilot: bool,
    /// Where in the show the film begins.
    pub start_secs: f64,
    /// How much of it is filmed; all unless said.
    pub duration_secs: Option<f64>,
    /// The files to write.
    pub output: Output,
}

impl Film {
    /// `body` dances to all of `song` as `beginning` says, with its opening look.
    pub fn new(body: String, song: String, beginning: Beginning, output: Output) -> Self {
        Self::of(body, vec![(song, BeatReading::default())], beginning, output)
    }

    /// The same to `songs`.
    fn of(body: String, songs: Vec<(String, BeatReading)>, beginning: Beginning, output: Output) -> Self {
        Self {
            look: look_named(&opening_looks(&body)).0,
            viewpoint: opening_view(&body),
            picture: String::new(),
            panorama: String::new(),
            body,
            songs,
            stance: Stance::default(),
            harmonics: None,
            paper: false,
            heard: Vec::new(),
            clock: ClockTrack::default(),
            show_secs: None,
            beginning,
            read_from: None,
            autopilot: false,
            start_secs: 0.0,
            duration_secs: None,
            output,
        }
    }

    /// The film of a show, whose body and songs were found.
    pub fn of_show(show: Show, body: String, songs: Vec<(String, BeatReading)>, output: Output) -> Self {
        let looks = show.looks.clone().unwrap_or_else(first_looks);
        Self {
            heard: show.heard.clone(),
            clock: show.clock.clone(),
            show_secs: show.duration_secs,
            look: look_named(&looks).0,
            picture: looks.picture,
            panorama: looks.panorama,
            viewpoint: show.viewpoint,
            ..Self::of(body, songs, Beginning { show: Some(Box::new(show)), ..Beginning::default() }, output)
        }
    }
}

/// Makes a film.
///
/// # Errors
/// Whatever is wrong with its body, its songs or its files. No unfinished film is left.
pub fn make(mut wanted: Film, watcher: &impl Watcher) -> Result<Report, Error> {
    let (began, mut seconds) = (Instant::now(), Seconds::default());
    wanted.check()?;
    let scenery = Scenery::open(&wanted.picture, &wanted.panorama)?;
    let mut prepared = Prepared::prepare(&mut wanted, &mut seconds, watcher)?;
    let (rate, output) = (wanted.output.rate, &wanted.output);
    let frames = rate.frames_in(prepared.songs.film_secs());
    let range = output.range(frames)?;
    // Only now: a mesh or song that cannot be read leaves no empty folder behind.
    if let Some(folder) = output.folder() {
        make_folder(folder)?;
    }
    let mut animation = output
        .animation
        .as_ref()
        .filter(|_| !range.is_empty())
        .map(|_| Animation::new(frames, prepared.box_diagonal));
    let done = if range.is_empty() {
        Done::default()
    } else if output.film.is_some() || output.pipe.is_some() {
        prepared.film(&wanted, range.clone(), &scenery, &mut seconds, watcher)?
    } else {
        let recording = output.coefficients.is_some();
        prepared.rehearse(range.clone(), animation.as_mut(), recording, &mut seconds, watcher)?
    };
    let approximation = prepared.save_beside(output, &done, animation.as_ref(), watcher)?;
    for message in &done.warnings {
        watcher.warn(Warning::Plain(message.clone()));
    }
    seconds.total = began.elapsed().as_secs_f64();
    let (tempo_bpm, beat_confidence) = prepared.songs.tempo();
    let frames = range.end - range.start;
    let film_secs = rate.start_secs(frames);
    Ok(Report {
        vertices: prepared.body.positions.len(),
        harmonics: prepared.body.basis.harmonics(),
        frames,
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
    /// Checks, before any work, that it can be made. Files that a caricature names are known once it is open.
    ///
    /// # Errors
    /// The first thing that stands in its way, as the input's fault.
    pub fn check(&self) -> Result<(), Error> {
        self.output.check()?;
        self.stance.check()?;
        self.beginning.check()?;
        if self.output.animation.is_some() && self.beginning.is_gallery() {
            return Err(Error::input(ONE_DANCE));
        }
        if let Some(sound) = self.output.animation.as_deref().map(sound_beside)
            && self.songs.iter().any(|(song, _)| is_same_file(&sound, Path::new(song)))
        {
            let sound = sound.display();
            return Err(Error::Input(format!(
                "the sound beside the GLB would replace the song {sound}: give the GLB another name"
            )));
        }
        let songs = self.songs.iter().map(|(song, _)| song);
        let named = songs.chain([&self.body, &self.picture, &self.panorama]).map(Path::new);
        let inputs: Vec<&Path> = named.chain(self.read_from.as_deref()).collect();
        self.output.check_apart(&inputs)?;
        check_stretch(self.start_secs, self.duration_secs)
    }
}

/// Where the sound of a folder of pictures goes.
pub fn sound_in(folder: &Path) -> PathBuf {
    folder.join("sound.wav")
}

/// Where the preset of this item of the gallery goes, counted from 0: `item-01.toml` and so on.
fn preset_in(folder: &Path, item: usize) -> PathBuf {
    folder.join(format!("item-{:02}.toml", item + 1))
}

/// Where the sound of an animation goes.
pub fn sound_beside(animation: &Path) -> PathBuf {
    animation.with_extension("wav")
}
