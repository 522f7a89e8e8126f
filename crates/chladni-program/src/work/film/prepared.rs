//! A film whose body and songs are prepared, and the files made of it.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use chladni_harmonics::Body;
use chladni_mesh::TriMesh;
use chladni_mesh::surface::vec3::single;
use chladni_music::{Ensemble, Instrument, Switch};
use chladni_sound::{WavSample, write_wav};
use chladni_view::{Film as Reel, FilmFormat, FilmSettings};

use super::animation::{Animation, Approximation};
use super::beginning::{in_vain, swings_alike};
use super::output::Output;
use super::performance::{Done, Performance};
use super::report::Seconds;
use super::songs::Songs;
use super::titles::Titles;
use super::{Film, ONE_DANCE, preset_in, sound_beside, sound_in};
use crate::work::body::laplacian;
use crate::work::dancer::{Dancing, classes};
use crate::work::left_out::left_of_gltf;
use crate::work::outputs::{earlier_frames, odd_sides};
use crate::work::{
    Cast, Error, HARMONICS, Hearing, OwnLook, Scenery, Warning, Watcher, is_flat, look_under_sand,
    make_folder, texture_colors,
};

/// Said of a dance that becomes a GLB: as detail turns, the whole shape's displacements are no sums of targets.
const ONLY_THE_PROXY: &str = "the GLB of a dance has only the vertices that are worked on, with textures as their \
                              colors (a project made with --proxy 0 dances with all)";

/// All that is needed before the first frame.
pub(super) struct Prepared {
    mesh: Arc<TriMesh>,
    pub body: Body,
    pub box_diagonal: f32,
    pub songs: Songs,
    performance: Performance,
}

impl Prepared {
    /// Opens and prepares body and songs, and completes the wanted film.
    ///
    /// # Errors
    /// Cancelled; a body or a song that cannot be read, with its name; a show or a preset that does not fit the body.
    pub fn prepare(wanted: &mut Film, seconds: &mut Seconds, watcher: &impl Watcher) -> Result<Self, Error> {
        let reading = Instant::now();
        let cast = Cast::open(Path::new(&wanted.body), watcher)?;
        wanted.output.check_apart(&cast.files())?;
        wanted.output.check_textures(&cast)?;
        cast.check_templates(watcher)?;
        if wanted.output.animation.is_some() && cast.subject().proxy.is_some() {
            watcher.warn(Warning::of(&wanted.body, ONLY_THE_PROXY));
        }
        if let (Some(path), Some(file)) = (&wanted.output.animation, cast.shape_file()) {
            watcher.warn_each(left_of_gltf(file, path));
        }
        // The orientation decides which half hears the left channel, so it is needed even without pictures.
        let show = wanted.beginning.show.as_ref();
        let stands = cast.stands(wanted.stance, show.and_then(|show| show.stands), watcher)?;
        let range = (wanted.start_secs, wanted.duration_secs);
        let heard = std::mem::take(&mut wanted.heard);
        let mut songs = Songs::open(&wanted.songs, heard, wanted.show_secs, range, &wanted.clock, watcher)?;
        seconds.reading = reading.elapsed().as_secs_f64();
        let preparing = Instant::now();
        let subject = cast.subject().clone();
        // As the window does.
        let of_show = wanted.beginning.show.as_ref().and_then(|show| show.harmonics);
        let harmonics = wanted.harmonics.unwrap_or_else(|| cast.harmonics(of_show.unwrap_or(HARMONICS)));
        let (body, voices) = cast.prepare(harmonics, laplacian(wanted.paper), false, watcher)?;
        let symmetry = watcher.watch("finding the mirror", |task| classes(&body, wanted.paper, task))?;
        let Dancing { body, dancer, .. } = Dancing::new(&body, symmetry, &stands)?;
        seconds.preparing = preparing.elapsed().as_secs_f64();
        let listening = Instant::now();
        songs.track_beats(watcher)?;
        seconds.beats = listening.elapsed().as_secs_f64();

        let rest = single(&body.positions);
        let keeps_look = wanted.beginning.keeps_look;
        let (opens, on_sheet) = (!keeps_look && wanted.beginning.show.is_none(), is_flat(&rest));
        let held = wanted.beginning.changes.clone();
        let begun = std::mem::take(&mut wanted.beginning).begin(&dancer, on_sheet)?;
        let (instrument, script) = &begun;
        if opens && on_sheet && instrument.parameters().is_on(Switch::Sand) {
            wanted.look = look_under_sand(wanted.look);
        }
        let (pilots, has_voices) = (wanted.autopilot, !voices.is_empty());
        watcher.warn_each(in_vain(&held, instrument.parameters(), script, pilots, has_voices));
        watcher.warn_each(swings_alike(&held, dancer.sides.source));
        let box_diagonal = dancer.box_diagonal;
        let voices = voices.into_iter().map(|(_, term)| term).collect();
        let ensemble = Ensemble::new(dancer).with_voices(voices)?;
        let mut hearing = Hearing::from(wanted.start_secs);
        songs.tell(&mut hearing);
        hearing.know_clock(std::mem::take(&mut wanted.clock));
        let stretches = songs.stretches().to_vec();
        let (start_secs, rate) = (wanted.start_secs, wanted.output.rate);
        let mut performance =
            Performance::new((&body, stands), ensemble, hearing, begun, stretches, start_secs, rate)?;
        if wanted.look.own_colors {
            let own = OwnLook::of_subject(&wanted.body, &subject, &body, watcher);
            if own.is_none() {
                let message = "has no colors of its own: those of the look are shown";
                watcher.warn(Warning::of(&wanted.body, message));
            }
            performance.color(own);
        }
        performance.flashes_allowed = wanted.output.allow_flashes;
        performance.fields_judged = wanted.output.flash_fields;
        performance.shows_rest = wanted.output.shows_rest;
        if wanted.autopilot {
            // Each song has its own dances, in every film of it.
            performance.pilot(&wanted.look, keeps_look, held, songs.draw())?;
        }
        if wanted.output.titles {
            performance.titles = Titles::of(&wanted.songs, songs.stretches(), start_secs);
        }
        let mut mesh = subject.mesh.clone();
        if wanted.output.animation.is_some()
            && let Some(colors) = texture_colors(&wanted.body, &subject, watcher)
        {
            Arc::make_mut(&mut mesh).appearance.colors = Some(colors);
        }
        Ok(Self { mesh, body, box_diagonal, songs, performance })
    }

    /// Draws `range` into a file or a pipe.
    ///
    /// # Errors
    /// Cancelled; a sound, a dance or a picture that fails; a file that cannot be written.
    pub fn film(
        &mut self,
        wanted: &Film,
        range: Range<u64>,
        scenery: &Scenery,
        seconds: &mut Seconds,
        watcher: &impl Watcher,
    ) -> Result<Done, Error> {
        let output = &wanted.output;
        let film = output.film.as_deref();
        let format = film.map(|path| output.format_of(path)).transpose()?;
        let is_heard = format == Some(FilmFormat::Mp4) && output.piece.is_none();
        let sound = is_heard.then(|| sound_for(&self.songs, watcher)).transpose()?;
        let settings = FilmSettings {
            width: output.width,
            height: output.height,
            rate: output.rate,
            frames: range.end - range.start,
            first: range.start,
            audio: sound.as_ref().map(|file| file.path().to_owned()),
        };
        if let Some(folder) = output.folder().filter(|_| output.piece.is_none()) {
            watcher.warn_each(earlier_frames(folder, range.end));
        }
        if let Some(file) = film.filter(|_| !output.is_folder) {
            watcher.warn_each(odd_sides(file, [output.width, output.height]));
        }
        let film = match film.zip(format) {
            Some((path, format)) => Reel::create_as(format, path, settings)?,
            None => Reel::to_pipe(std::io::stdout(), output.pipe.unwrap_or_default(), settings)?,
        };
        let scene = (&wanted.look, &wanted.viewpoint, scenery);
        let recording = output.coefficients.is_some();
        watcher.watch("filming", |task| {
            self.performance.film(film, scene, output.means(), recording, seconds, task)
        })
    }

    /// Dances `range` without drawing it, into the `animation` and, where `recording` is wanted, the coefficients.
    ///
    /// # Errors
    /// Cancelled; a sound or a dance that fails; more than one dance where they go into an animation.
    pub fn rehearse(
        &mut self,
        range: Range<u64>,
        mut animation: Option<&mut Animation>,
        recording: bool,
        seconds: &mut Seconds,
        watcher: &impl Watcher,
    ) -> Result<Done, Error> {
        watcher.watch("dancing", |task| {
            self.performance.rehearse(range, recording, seconds, task, |form, items| {
                match (&mut animation, items) {
                    (Some(_), [_, _, ..]) => {
                        return Err(Error::input(ONE_DANCE));
                    }
                    (Some(animation), [item]) => animation.push(form, item),
                    _ => {}
                }
                Ok(())
            })
        })
    }

    /// Saves the other files that are wanted besides the film.
    ///
    /// # Errors
    /// The first file that cannot be written, with its name; cancelled.
    pub fn save_beside(
        &self,
        output: &Output,
        done: &Done,
        animation: Option<&Animation>,
        watcher: &impl Watcher,
    ) -> Result<Option<Approximation>, Error> {
        let animated = output.animation.as_deref().zip(animation);
        let write = |(path, animation): (&Path, &Animation)| {
            watcher.watch("writing the morph targets", |task| {
                animation.write(path, &self.mesh, &self.body, output.rate, output.targets, task)
            })
        };
        let approximation = animated.map(write).transpose()?;
        if let Some(path) = &output.coefficients {
            done.recording.write(path).map_err(|error| Error::unwritten(path, error))?;
        }
        if let Some(folder) = &output.presets {
            save_presets(folder, self.performance.instrument())?;
        }
        // Last: it is the largest, and where it does not fit on the disk, nothing else is missing.
        let beside = animated.map(|(path, _)| sound_beside(path));
        for path in beside.into_iter().chain(output.folder().map(sound_in)) {
            save_sound(&path, &self.songs)?;
        }
        Ok(approximation)
    }
}

/// Each item of the gallery as a preset.
fn save_presets(folder: &Path, instrument: &Instrument) -> Result<(), Error> {
    make_folder(folder)?;
    for (i, item) in instrument.gallery().items().iter().enumerate() {
        let preset = instrument.preset(item, instrument.tags(item.id));
        preset.save(&preset_in(folder, i)).map_err(Error::unsaved)?;
    }
    Ok(())
}

fn save_sound(path: &Path, songs: &Songs) -> Result<(), Error> {
    write_wav(path, &songs.sound()?, WavSample::Int16).map_err(|error| Error::unwritten(path, error))
}

/// The sound that an MP4 is given, as a temporary file.
fn sound_for(songs: &Songs, watcher: &impl Watcher) -> Result<tempfile::NamedTempFile, Error> {
    let file = tempfile::Builder::new().prefix("chladni-").suffix(".wav").tempfile().map_err(Error::other)?;
    let sound = songs.sound()?;
    watcher.watch("writing the sound", |_| write_wav(file.path(), &sound, WavSample::Int16))?;
    Ok(file)
}
