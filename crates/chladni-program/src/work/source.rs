//! Shapes and songs by the names that users give them: a path, or `sample:NAME`.

use std::path::{Path, PathBuf};

use chladni_caricature::{Project, ShapeSource};
use chladni_mesh::{Loaded, TriMesh, load_mesh, samples};
use chladni_sound::{Song, SongOptions, SongReader, sample_tune};

use super::{Error, Warning, Watcher};

/// What the names of samples begin with.
const SAMPLE: &str = "sample:";
/// The name of the sample tune.
pub const TUNE: &str = "sample:tune";

/// The name of a sample, where `path` is one.
pub fn sample_name(path: &Path) -> Option<&str> {
    path.to_str()?.strip_prefix(SAMPLE)
}

/// What users call the sample shape `name`.
pub fn sample_path(name: &str) -> PathBuf {
    format!("{SAMPLE}{name}").into()
}

/// The shape that users call `path`.
pub fn shape_source(path: &Path) -> ShapeSource {
    match sample_name(path) {
        Some(name) => ShapeSource::Sample(name.to_owned()),
        None => ShapeSource::File(path.to_owned()),
    }
}

/// A file by a name that holds whatever folder a project comes to lie in; samples keep theirs.
pub fn from_anywhere(path: &Path) -> PathBuf {
    let absolute = if sample_name(path).is_some() { None } else { std::path::absolute(path).ok() };
    absolute.unwrap_or_else(|| path.to_owned())
}

/// Reads a mesh file, or makes a sample, with what was mended.
///
/// # Errors
/// [`Error::NoSample`], or [`Error::Mesh`] with the file's name.
pub fn loaded(source: &ShapeSource) -> Result<Loaded, Error> {
    match source {
        ShapeSource::File(path) => Ok(load_mesh(path)?),
        ShapeSource::Sample(name) => {
            let mesh = samples::sample(name).ok_or_else(|| Error::NoSample { name: name.clone() })?;
            Ok(Loaded { mesh, mended: Vec::new(), stored_positions: None })
        }
    }
}

/// The same mesh; warns of what was mended.
///
/// # Errors
/// As [`loaded`] does.
pub fn shape(source: &ShapeSource, watcher: &impl Watcher) -> Result<TriMesh, Error> {
    let loaded = watcher.watch("reading the mesh", |_| loaded(source))?;
    for mended in &loaded.mended {
        watcher.warn(Warning::of(source, mended));
    }
    Ok(loaded.mesh)
}

/// The mesh that users call `name`; warns of what was mended.
///
/// # Errors
/// As [`loaded`] does.
pub fn mesh(name: impl AsRef<Path>, watcher: &impl Watcher) -> Result<TriMesh, Error> {
    shape(&shape_source(name.as_ref()), watcher)
}

/// The project at `path`; warns where it was made by an older program.
///
/// # Errors
/// [`Error::Caricature`] with the file's name.
pub fn project(path: &Path, watcher: &impl Watcher) -> Result<Project, Error> {
    let project = Project::load(path)?;
    if let Some(told) = project.taken_over() {
        watcher.warn(Warning::of(path.display(), told));
    }
    Ok(project)
}

/// Reads a stretch of a song, or of `sample:tune`; warns of damage.
///
/// # Errors
/// [`Error::Sound`], and [`Error::Input`] for a stretch that is not there.
pub fn song(
    name: &str,
    start_secs: f64,
    duration_secs: Option<f64>,
    watcher: &impl Watcher,
) -> Result<Song, Error> {
    if !(start_secs.is_finite() && start_secs >= 0.0)
        || duration_secs.is_some_and(|d| !(d.is_finite() && d > 0.0))
    {
        return Err(Error::input("start must not be negative and the duration must be positive"));
    }
    if let Some(sample) = sample_name(Path::new(name)) {
        if name != TUNE {
            return Err(Error::Input(format!("there is no sample {sample}: tune is a song")));
        }
        return stretch(sample_tune(), start_secs, duration_secs);
    }
    let options = SongOptions { start_secs, duration_secs, ..SongOptions::default() };
    let mut reader = SongReader::open(Path::new(name))?;
    let song = watcher.watch("decoding the song", |task| Song::read(&mut reader, &options, task));
    if let Some(damage) = reader.damage() {
        watcher.warn(Warning::of(name, damage));
    }
    Ok(song?)
}

fn stretch(song: Song, start_secs: f64, duration_secs: Option<f64>) -> Result<Song, Error> {
    let frames = |secs: f64| (secs * f64::from(song.rate_hz)).round() as usize;
    let first = frames(start_secs).min(song.frames());
    let last = duration_secs.map_or(song.frames(), |d| (first + frames(d)).min(song.frames()));
    if first == last {
        return Err(Error::Input(format!("the song ends after {:.1} s", song.duration_secs())));
    }
    Ok(Song {
        rate_hz: song.rate_hz,
        left: song.left[first..last].to_vec(),
        right: song.right[first..last].to_vec(),
    })
}
