//! Shapes and songs by the names that users give them: a path, or `sample:NAME`.

use std::fmt::Display;
use std::ops::Range;
use std::path::{Path, PathBuf};

use chladni_caricature::Project;
use chladni_harmonics::available_memory;
use chladni_mesh::samples::{SAMPLES, portrait_sliders};
use chladni_mesh::{Format, Loaded, MeshError, ShapeSource, TriMesh, nothing_beside, read_named_mesh};
use chladni_sound::{Song, SongOptions, SongReader, SoundError, sample_tune};
use chladni_task::{folder_of, open_file, where_it_leads};

use super::formats::{TUNE, is_project};
use super::{Error, Warning, Watcher};

/// The most bytes that the samples of one [long song](long_song) may take: six hours at 48 kHz.
const MOST_BYTES: u64 = 8 << 30;

/// The users' name for the sample shape `name`.
pub fn sample_path(name: &str) -> PathBuf {
    ShapeSource::Sample(name.to_owned()).to_string().into()
}

/// An absolute path, valid in whatever folder a project is saved; samples keep their names.
pub fn from_anywhere(path: &Path) -> PathBuf {
    let absolute =
        if ShapeSource::sample_name(path).is_some() { None } else { std::path::absolute(path).ok() };
    absolute.unwrap_or_else(|| path.to_owned())
}

/// Reads a mesh file, or makes a sample; warns of repairs.
///
/// # Errors
/// [`Error::Mesh`], which names it, [`Error::Input`] for `sample:tune`, and [`Error::Cancelled`] once it is read.
pub fn shape(source: &ShapeSource, watcher: &impl Watcher) -> Result<TriMesh, Error> {
    Ok(loaded(source, watcher)?.mesh)
}

/// The same with the repairs.
///
/// # Errors
/// As [`shape`] does.
pub fn loaded(source: &ShapeSource, watcher: &impl Watcher) -> Result<Loaded, Error> {
    let loaded = watcher.watch("reading the mesh", |_| source.load(None));
    watcher.task().check()?;
    let loaded = loaded.map_err(|error| explained(source, error))?;
    warn_of_repairs(source, &loaded, watcher);
    Ok(loaded)
}

/// The error of reading `source`, with what may have been meant by its name.
fn explained(source: &ShapeSource, error: MeshError) -> Error {
    if source.to_string() == TUNE {
        return Error::Input(format!("{TUNE}: is a song, not a shape"));
    }
    let Some((file, name)) = source.file().and_then(|file| Some((file, file.to_str()?))) else {
        return error.into();
    };
    if SAMPLES.contains(&name) && !file.exists() {
        return Error::Input(format!("{error}; {} is a sample", sample_path(name).display()));
    }
    if is_project(file) && file.is_file() {
        return Error::Input(format!(
            "{name}: is a caricature project, not a mesh: chladni caricature --recipe {name} makes one of it"
        ));
    }
    error.into()
}

/// The mesh in the `bytes` of a file called `name`; warns of repairs. Files that it names are not there.
///
/// # Errors
/// [`Error::Mesh`] with the name.
pub fn shape_in(name: &str, bytes: &[u8], watcher: &impl Watcher) -> Result<TriMesh, Error> {
    let read = |_: &_| read_named_mesh(Path::new(name), bytes, &nothing_beside);
    let loaded = watcher.watch("reading the mesh", read).map_err(|error| Error::from(error).of(name))?;
    warn_of_repairs(name, &loaded, watcher);
    Ok(loaded.mesh)
}

fn warn_of_repairs(name: impl Display, loaded: &Loaded, watcher: &impl Watcher) {
    for mended in &loaded.mended {
        watcher.warn(Warning::of(&name, mended));
    }
}

/// The mesh that users call `name`; warns of repairs.
///
/// # Errors
/// As [`shape`] does.
pub fn mesh(name: impl AsRef<Path>, watcher: &impl Watcher) -> Result<TriMesh, Error> {
    shape(&ShapeSource::named(name.as_ref()), watcher)
}

/// Checks, before long work, that a mesh is there to be read.
///
/// # Errors
/// As [`shape`] does.
pub fn check_there(source: &ShapeSource, watcher: &impl Watcher) -> Result<(), Error> {
    // A sample is known by its name, without being modeled.
    let is_there = match source {
        ShapeSource::File(file) => open_file(file).is_ok(),
        ShapeSource::Sample(name) => {
            SAMPLES.contains(&name.as_str()) || portrait_sliders(name).is_some_and(|sliders| sliders.is_ok())
        }
    };
    if is_there {
        return Ok(());
    }
    // The error is that of reading it.
    shape(source, watcher).map(drop)
}

/// The project at `path`, of which something is made: warns where it was made by an older program, or reads files
/// [outside its folder](outside).
///
/// # Errors
/// As of [`project_alone`], and [`Error::Caricature`] for a file of another machine that the user does not know.
pub fn project(path: &Path, watcher: &impl Watcher) -> Result<Project, Error> {
    let project = project_alone(path, watcher)?;
    let known = |file: &Path| watcher.knows(path, file);
    project.check_near(path, known)?;
    watcher.warn_each(outside(path, &project, known));
    Ok(project)
}

/// The project at `path`, without a look at the files that it names; warns where it was made by an older program.
///
/// # Errors
/// [`Error::Caricature`] with the file's name, and [`Error::Input`] for a mesh.
pub fn project_alone(path: &Path, watcher: &impl Watcher) -> Result<Project, Error> {
    if Format::of_path(path).is_some() && path.is_file() {
        let path = path.display();
        return Err(Error::Input(format!(
            "{path}: is a mesh: chladni project new {path} -o NAME.chladni makes a project of it"
        )));
    }
    Ok(aged(path, Project::read(path)?, watcher))
}

/// A warning where the project that was saved at `path` names a file of another machine.
pub fn far(path: &Path, project: &Project) -> Option<Warning> {
    let file = *project.far_files(path).first()?;
    Some(Warning::of(
        path.display(),
        format_args!(
            "names {}, which is on another machine: where neither was opened of late, the project must be opened together \
             with that mesh",
            file.display()
        ),
    ))
}

/// A warning where the project at `path` reads a file outside its own folder that is not `known`: what is made of the project
/// holds what is in that file, and may be sent on.
pub fn outside(path: &Path, project: &Project, known: impl Fn(&Path) -> bool) -> Option<Warning> {
    // Beside the project as it is spelled, or beside the file that a link leads to.
    let leads_to = where_it_leads(path);
    let folders = [path, &leads_to].map(folder_of);
    let is_outside = |file: &Path| file.exists() && !folders.iter().any(|folder| lies_below(file, folder));
    let file = project.files().into_iter().find(|file| !known(file) && is_outside(file))?;
    Some(Warning::of(
        path.display(),
        format_args!("reads {}, which lies outside its own folder", file.display()),
    ))
}

/// Whether `file` lies in `folder` or below it, wherever links lead on the way to either.
pub fn lies_below(file: &Path, folder: &Path) -> bool {
    let (file, folder) = (file.canonicalize(), folder.canonicalize());
    file.is_ok_and(|file| folder.is_ok_and(|folder| file.starts_with(folder)))
}

/// The project in the `text` of a file called `name`; warns where it was made by an older program.
///
/// # Errors
/// [`Error::Caricature`] with the name.
pub fn project_in(name: &Path, text: &str, watcher: &impl Watcher) -> Result<Project, Error> {
    Ok(aged(name, Project::from_text(text, name)?.0, watcher))
}

fn aged(path: &Path, project: Project, watcher: &impl Watcher) -> Project {
    if let Some(message) = project.taken_over() {
        watcher.warn(Warning::of(path.display(), message));
    }
    project
}

/// Reads a stretch of a song, or of `sample:tune`; warns of damage.
///
/// # Errors
/// [`Error::Sound`], and [`Error::Input`] for a stretch that is not there.
pub fn song(
    name: impl AsRef<Path>,
    start_secs: f64,
    duration_secs: Option<f64>,
    watcher: &impl Watcher,
) -> Result<Song, Error> {
    read_song(name.as_ref(), &SongOptions { start_secs, duration_secs, ..SongOptions::default() }, watcher)
}

/// Reads all of a song, or of `sample:tune`, for work without a listener, which may take more memory; warns of damage.
///
/// # Errors
/// As [`song`] does, but [`Error::Input`] for a song that is too long.
pub fn long_song(name: impl AsRef<Path>, watcher: &impl Watcher) -> Result<Song, Error> {
    long_song_within(usize::MAX, name, watcher)
}

/// The same of a song of a film, whose samples may take no more than the bytes `left` by the other songs.
///
/// # Errors
/// As [`long_song`] does.
pub fn long_song_within(left: usize, name: impl AsRef<Path>, watcher: &impl Watcher) -> Result<Song, Error> {
    let most = most_bytes(available_memory());
    let options = SongOptions { max_bytes: most.min(left), ..SongOptions::default() };
    match read_song(name.as_ref(), &options, watcher) {
        Err(Error::Sound(SoundError::TooLong { .. })) if left < most => Err(Error::Input(format!(
            "{}: the songs of this film take more memory than is free; free some, or make films of parts of it \
             (--start, --duration)",
            name.as_ref().display()
        ))),
        Err(Error::Sound(error @ SoundError::TooLong { .. })) => {
            Err(Error::Input(format!("{error}; free some memory, or cut it into several files")))
        }
        read => read,
    }
}

/// How much the samples of all songs of a film may take where this much memory is `free`: they and the film's sound share
/// three quarters of it. Where the film's seconds are not known, its sound is as long as the songs.
pub fn most_bytes_of_all(free: Option<u64>, film_secs: Option<f64>) -> usize {
    const SOUND_BYTES_PER_SEC: f64 = 8.0 * 48_000.0;
    let Some(free) = free else { return usize::MAX };
    let both = free / 4 * 3;
    let songs = film_secs.map_or(both / 2, |secs| both.saturating_sub((secs * SOUND_BYTES_PER_SEC) as u64));
    SongOptions::default().max_bytes.max(usize::try_from(songs).unwrap_or(usize::MAX))
}

/// How much the samples of one long song may take where this much memory is `free`: a film has them twice, and needs more
/// beside them.
fn most_bytes(free: Option<u64>) -> usize {
    let most = free.map_or(0, |free| MOST_BYTES.min(free / 4));
    SongOptions::default().max_bytes.max(usize::try_from(most).unwrap_or(usize::MAX))
}

fn read_song(name: &Path, options: &SongOptions, watcher: &impl Watcher) -> Result<Song, Error> {
    let SongOptions { start_secs, duration_secs, .. } = *options;
    check_stretch(start_secs, duration_secs)?;
    if let Some(sample) = ShapeSource::sample_name(name) {
        if name.as_os_str() != TUNE {
            let is_shape = SAMPLES.contains(&sample) || portrait_sliders(sample).is_some();
            let why = if is_shape { "is a shape, not a song" } else { "there is no such song" };
            return Err(Error::Input(format!("sample:{sample}: {why}; {TUNE} is one")));
        }
        return stretch(sample_tune(), start_secs, duration_secs);
    }
    let mut reader = SongReader::open(name).map_err(|error| {
        let is_meant = name.to_str() == ShapeSource::sample_name(Path::new(TUNE)) && !name.exists();
        if is_meant { Error::Input(format!("{error}; {TUNE} is a sample")) } else { error.into() }
    })?;
    let song = watcher.watch("decoding the song", |task| Song::read(&mut reader, options, task));
    if let Some(damage) = reader.damage() {
        watcher.warn(Warning::of(name.display(), damage));
    }
    Ok(song?)
}

/// Checks that the start is finite and not negative, and that the duration, if given, is finite and positive.
///
/// # Errors
/// [`Error::Input`] otherwise.
pub fn check_stretch(start_secs: f64, duration_secs: Option<f64>) -> Result<(), Error> {
    if !(start_secs.is_finite() && start_secs >= 0.0)
        || duration_secs.is_some_and(|d| !(d.is_finite() && d > 0.0))
    {
        return Err(Error::input("start must not be negative and the duration must be positive"));
    }
    Ok(())
}

/// The frames of a stretch of `song`; `None` where there are none.
pub fn frames_of(song: &Song, start_secs: f64, duration_secs: Option<f64>) -> Option<Range<usize>> {
    let frames = |secs: f64| (secs * f64::from(song.rate_hz)).round() as usize;
    let first = frames(start_secs).min(song.frames());
    let last = duration_secs.map_or(song.frames(), |d| first.saturating_add(frames(d)).min(song.frames()));
    (first < last).then_some(first..last)
}

fn stretch(song: Song, start_secs: f64, duration_secs: Option<f64>) -> Result<Song, Error> {
    let ends = || Error::Input(format!("the song ends after {:.1} s", song.duration_secs()));
    let frames = frames_of(&song, start_secs, duration_secs).ok_or_else(ends)?;
    Ok(Song {
        rate_hz: song.rate_hz,
        left: song.left[frames.clone()].to_vec(),
        right: song.right[frames].to_vec(),
    })
}

#[cfg(test)]
mod tests {
    use chladni_task::Task;

    use super::super::Aside;
    use super::*;

    #[test]
    fn long_songs_take_a_quarter_of_the_memory_at_most() {
        let usual = SongOptions::default().max_bytes;
        assert_eq!([None, Some(1 << 30)].map(most_bytes), [usual; 2]);
        assert_eq!([12, 1000].map(|gib: u64| most_bytes(Some(gib << 30)) as u64), [3 << 30, MOST_BYTES]);
    }

    #[test]
    fn the_songs_of_a_film_share_the_memory_with_its_sound() {
        let gib =
            |free: u64, film_secs| most_bytes_of_all(Some(free << 30), film_secs) as f64 / (1 << 30) as f64;
        assert_eq!(most_bytes_of_all(None, None), usize::MAX);
        assert_eq!(
            [gib(16, None), gib(16, Some(0.0)), gib(16, Some(1e9)), gib(1, None)],
            [6.0, 12.0, 1.0, 1.0]
        );
        let hours = gib(16, Some(10_800.0));
        assert!(hours > 8.0 && hours < 8.3, "{hours}");

        let (folder, task) = (tempfile::tempdir().unwrap(), Task::new());
        let path = folder.path().join("a.wav");
        let song = Song { rate_hz: 8_000, left: vec![0.5; 8_000], right: vec![0.5; 8_000] };
        chladni_sound::write_wav(&path, &song, chladni_sound::WavSample::Float32).unwrap();
        assert_eq!(long_song_within(1 << 20, &path, &Aside::new(&task)).unwrap().frames(), 8_000);
        let refused = long_song_within(1 << 10, &path, &Aside::new(&task)).map(drop).unwrap_err().to_string();
        assert!(refused.contains("a.wav") && refused.contains("--start"), "{refused}");
    }

    #[test]
    fn a_mesh_that_is_not_there_is_known_before_it_is_read() {
        let (folder, task) = (tempfile::tempdir().unwrap(), Task::new());
        let [there, gone] = ["there.obj", "gone.obj"].map(|name| folder.path().join(name));
        std::fs::write(&there, "not read yet").unwrap();
        let check = |name: &Path| check_there(&ShapeSource::named(name), &Aside::new(&task));
        check(&there).unwrap();
        check(Path::new("sample:bell")).unwrap();
        assert!(check(&gone).unwrap_err().to_string().contains("gone.obj"));
        assert!(check(Path::new("sample:gone")).unwrap_err().to_string().contains("gone"));
    }

    #[test]
    fn what_may_have_been_meant_is_said() {
        let (folder, task) = (tempfile::tempdir().unwrap(), Task::new());
        let [taken, shape] = ["p.chladni", "shape.obj"].map(|name| folder.path().join(name));
        for path in [&taken, &shape] {
            std::fs::write(path, "format_version = 2\n").unwrap();
        }
        let aside = Aside::new(&task);
        let refused = |name: &Path| mesh(name, &aside).map(drop).unwrap_err().to_string();
        assert!(refused(Path::new("octopus")).ends_with("; sample:octopus is a sample"));
        assert!(!refused(Path::new("octopuses")).contains("sample:"));
        assert!(refused(&taken).contains("is a caricature project, not a mesh"));
        let why = project(&shape, &aside).map(drop).unwrap_err().to_string();
        assert!(why.contains("is a mesh: chladni project new"), "{why}");
        let why = song("tune", 0.0, None, &aside).map(drop).unwrap_err().to_string();
        assert!(why.ends_with("; sample:tune is a sample"), "{why}");
    }

    #[test]
    fn a_project_that_reads_files_outside_its_folder_says_so_once() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir_all(at("work/heads")).unwrap();
        for name in ["secret.obj", "work/heads/a.obj"] {
            std::fs::write(at(name), "not read yet").unwrap();
        }
        let warned = |shape: &str, known: &[PathBuf]| -> Vec<String> {
            let (path, task) = (at("work/p.chladni"), Task::new());
            let text = format!("format_version = 4\n[shape]\nsource = {shape:?}\n");
            std::fs::write(&path, text).unwrap();
            let knows =
                |document: &Path, file: &Path| known.iter().any(|path| path == document || path == file);
            let aside = Aside::new(&task).knowing(knows);
            project(&path, &aside).unwrap();
            aside.warnings().iter().map(ToString::to_string).filter(|said| said.contains("outside")).collect()
        };
        for inside in
            ["heads/a.obj", "heads/../heads/a.obj", "../work/heads/a.obj", "../gone.obj", "sample:head"]
        {
            assert_eq!(warned(inside, &[]), Vec::<String>::new(), "{inside}");
        }
        let absolute = at("secret.obj").to_str().unwrap().to_owned();
        for outside in ["../secret.obj", "heads/../../secret.obj", &absolute] {
            let said = warned(outside, &[]);
            assert!(said.len() == 1 && said[0].contains("secret.obj"), "{outside}: {said:?}");
        }
        for known in ["secret.obj", "work/p.chladni"] {
            assert_eq!(warned("../secret.obj", &[at(known)]), Vec::<String>::new(), "{known}");
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("../secret.obj", at("work/link.obj")).unwrap();
            assert_eq!(warned("link.obj", &[]).len(), 1);
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_file_lies_where_links_lead() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir_all(at("work/below")).unwrap();
        for name in ["secret.obj", "work/below/a.obj"] {
            std::fs::write(at(name), "").unwrap();
        }
        for (target, link) in [("../secret.obj", "work/link.obj"), ("..", "work/up"), ("work", "spelled")] {
            symlink(target, at(link)).unwrap();
        }
        for file in ["work/below/a.obj", "spelled/below/a.obj", "work/up/work/below/a.obj"] {
            assert!(lies_below(&at(file), &at("work")) && lies_below(&at(file), &at("spelled")), "{file}");
        }
        for file in ["secret.obj", "work/link.obj", "work/up/secret.obj", "work/below/gone.obj"] {
            assert!(!lies_below(&at(file), &at("work")), "{file}");
        }
    }

    #[test]
    fn a_project_that_names_a_file_of_another_machine_is_saved_with_a_warning() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.chladni");
        let named = |shape: &str| Project::new(ShapeSource::File(shape.into()), 8);
        let shared = named(r"\\server\share\head.obj");
        shared.save(&path).unwrap();
        assert!(far(&path, &shared).unwrap().to_string().contains(r"\\server\share\head.obj"));
        assert_eq!(far(&path, &named("head.obj")), None);
        let why = shared.check_near(&path, |_| false).unwrap_err().to_string();
        assert!(why.contains(r"\\server\share\head.obj") && why.contains("together"), "{why}");
        shared.check_near(&path, |file| file == Path::new(r"\\server\share\head.obj")).unwrap();
    }

    #[test]
    fn a_part_of_any_length_ends_with_the_song() {
        let whole = sample_tune();
        let rest = |secs: f64| stretch(sample_tune(), 1.0, Some(secs)).unwrap().frames();
        assert_eq!(rest(1e300), whole.frames() - whole.rate_hz as usize);
        assert_eq!(rest(0.5), whole.rate_hz as usize / 2);
        assert!(stretch(sample_tune(), 1e300, None).is_err());
    }
}
