//! What the program reads besides shapes and songs: pictures, masks, preferences, its arguments, and what it has put aside.

use std::path::Path;
use std::sync::LazyLock;

use chladni_harmonics::{BasisCache, BasisSettings, Body, BuildReport};
use chladni_mesh::{TriMesh, samples};
use chladni_program::cli;
use chladni_program::studio::Settings;
use chladni_program::work::{Subject, mask};
use chladni_task::Task;
use chladni_view::{Panorama, Picture};
use tempfile::TempDir;

use crate::{MIB, within};

/// The most memory that each byte of a picture or mask takes.
const EACH: usize = 64;
/// What the pixels of a picture take at most: as they are in the file, and as they are drawn.
const OF_PICTURES: usize = 768 * MIB;

/// A picture that stands behind a shape.
pub fn picture(bytes: &[u8]) {
    let read = within(bytes.len(), EACH, OF_PICTURES, || Picture::decode(bytes));
    let Ok(picture) = read else { return };
    assert_eq!(picture.rgba.len(), 4 * picture.width as usize * picture.height as usize);
    if picture.rgba.len() < 1 << 20 {
        let written = picture.to_png().expect("what was read can be written");
        assert_eq!(Picture::decode(&written).expect("and read").rgba, picture.rgba);
    }
}

/// A picture of all that is around.
pub fn panorama(bytes: &[u8]) {
    let _ = within(bytes.len(), EACH, OF_PICTURES, || Panorama::decode(bytes));
}

/// A mask, as an attribute or the colors of a PLY mesh of twelve vertices; what is read is written and read back as the same.
pub fn mask_mesh(bytes: &[u8]) {
    static SHAPE: LazyLock<Subject> = LazyLock::new(|| samples::icosphere(0).into());
    let read = |bytes: &[u8]| mask::read_in(Path::new("mask.ply"), bytes, None, &SHAPE);
    let Ok(painted) = within(bytes.len(), EACH, MIB, || read(bytes)) else { return };
    let (written, masked) = mask::to_bytes("ply", &painted, &SHAPE).expect("what was read can be written");
    assert!(masked.inside <= masked.vertices);
    assert_eq!(read(&written).expect("what was written can be read"), painted);
}

/// A file of preferences.
pub fn settings(text: &str) {
    let Ok(settings) = within(text.len(), 128, MIB, || Settings::from_text(text)) else { return };
    assert!((0.5..=3.0).contains(&settings.zoom) && settings.harmonics >= 2);
    let written = settings.to_text().expect("what was read can be written");
    assert_eq!(Settings::from_text(&written).expect("what was written can be read"), settings);
}

/// A command line, an argument a line.
pub fn arguments(text: &str) {
    let arguments = std::iter::once("chladni").chain(text.lines());
    if let Err(error) = cli::understand(arguments) {
        let line = error.to_string();
        assert!(!line.is_empty() && error.is_of_input());
    }
}

/// A cache with one entry.
struct Shelf {
    _folder: TempDir,
    cache: BasisCache,
    entry: std::path::PathBuf,
    mesh: TriMesh,
    solved: Body,
}

impl Shelf {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let cache = BasisCache::new(folder.path());
        let mesh = samples::icosphere(0);
        let (solved, _) = look_up(&mesh, &cache);
        let entry = std::fs::read_dir(folder.path()).expect("it is there").flatten().next();
        let entry = entry.expect("an entry was made").path();
        Self { _folder: folder, cache, entry, mesh, solved }
    }
}

fn look_up(mesh: &TriMesh, cache: &BasisCache) -> (Body, BuildReport) {
    let settings = BasisSettings { threads: Some(1), ..BasisSettings::new(3) };
    Body::load_or_build(mesh, &settings, Some(cache), &Task::new()).expect("a sphere has harmonics")
}

/// An entry of the cache, as it is and with a checksum that is right.
pub fn cache(bytes: &[u8]) {
    thread_local! {
        static SHELF: Shelf = Shelf::new();
    }
    let whole = [bytes, blake3::hash(bytes).as_bytes()].concat();
    SHELF.with(|Shelf { cache, entry, mesh, solved, .. }| {
        for content in [bytes, &whole] {
            std::fs::write(entry, content).expect("room for an entry");
            let (body, report) = look_up(mesh, cache);
            assert_eq!(body.basis.vectors.len(), body.basis.harmonics() * body.basis.vertices());
            assert_eq!(body.basis.vertices(), solved.basis.vertices());
            if !report.cached {
                assert!(report.cache_warning.is_some() && body.basis == solved.basis);
            }
        }
    });
}
