//! Meshes and songs that commands take: files, or samples by name.

use chladni_harmonics::{BasisSettings, Body, BuildReport, HarmonicsError, Laplacian};
use chladni_mesh::TriMesh;
use chladni_sound::{Song, SongOptions, SongReader, sample_tune};

use super::beats::sound_failure;
use super::{Failure, Terminal, basis_cache};
use crate::source;

/// Reads a mesh file, or makes `sample:NAME`; tells what had to be mended.
pub fn open_mesh(name: &str, terminal: &Terminal) -> Result<TriMesh, Failure> {
    let path = std::path::Path::new(name);
    let loaded = terminal.watch("reading the mesh", |_| source::named(path)).map_err(Failure::BadInput)?;
    for line in &loaded.mended {
        terminal.warn(format_args!("{name}: {line}"));
    }
    Ok(loaded.mesh)
}

/// Reads a stretch of a song, or of `sample:tune`.
pub fn open_song(
    name: &str,
    start_secs: f64,
    duration_secs: Option<f64>,
    terminal: &Terminal,
) -> Result<Song, Failure> {
    if !(start_secs.is_finite() && start_secs >= 0.0)
        || duration_secs.is_some_and(|d| !(d.is_finite() && d > 0.0))
    {
        return Err(Failure::BadInput("start must not be negative and the duration must be positive".into()));
    }
    if let Some(sample) = name.strip_prefix("sample:") {
        if sample != "tune" {
            return Err(Failure::BadInput(format!("there is no sample {sample}: tune is a song")));
        }
        return stretch(sample_tune(), start_secs, duration_secs);
    }
    let options = SongOptions { start_secs, duration_secs, ..SongOptions::default() };
    let mut reader = SongReader::open(std::path::Path::new(name)).map_err(Failure::input)?;
    let song = terminal.watch("decoding the song", |task| Song::read(&mut reader, &options, task));
    if let Some(damage) = reader.damage() {
        terminal.warn(format_args!("{name}: {damage}"));
    }
    song.map_err(sound_failure)
}

fn stretch(song: Song, start_secs: f64, duration_secs: Option<f64>) -> Result<Song, Failure> {
    let frames = |secs: f64| (secs * f64::from(song.rate_hz)).round() as usize;
    let first = frames(start_secs).min(song.frames());
    let last = duration_secs.map_or(song.frames(), |d| (first + frames(d)).min(song.frames()));
    if first == last {
        return Err(Failure::BadInput(format!("the song ends after {:.1} s", song.duration_secs())));
    }
    Ok(Song {
        rate_hz: song.rate_hz,
        left: song.left[first..last].to_vec(),
        right: song.right[first..last].to_vec(),
    })
}

/// The operator of paper mode, or the usual one.
pub fn laplacian(paper: bool) -> Laplacian {
    if paper { Laplacian::Cotangent } else { Laplacian::Delaunay }
}

/// As many harmonics of a mesh as asked for, or all there are where it has fewer vertices; from the
/// user's cache where they are there.
pub fn build_body(
    name: &str,
    mesh: &TriMesh,
    harmonics: usize,
    laplacian: Laplacian,
    terminal: &Terminal,
) -> Result<(Body, BuildReport), Failure> {
    let cache = basis_cache();
    let settings = BasisSettings { laplacian, ..BasisSettings::new(harmonics) };
    let (body, report) = terminal
        .watch("solving for harmonics", |task| Body::load_or_build(mesh, &settings, cache.as_ref(), task))
        .map_err(|error| match error {
            HarmonicsError::Cancelled(_) => Failure::Cancelled,
            error => Failure::BadInput(format!("{name}: {error}")),
        })?;
    for warning in report.warnings(&body.basis.certificate) {
        terminal.warn(format_args!("{name}: {warning}"));
    }
    Ok((body, report))
}
