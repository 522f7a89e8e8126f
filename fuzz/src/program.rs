//! What the program reads besides shapes and songs: pictures, masks, preferences, its arguments, and what it has put aside.

use std::path::Path;
use std::sync::LazyLock;

use chladni_harmonics::npz::StoredBasis;
use chladni_harmonics::{BasisCache, BasisSettings, Body, BuildReport};
use chladni_mesh::{TriMesh, samples};
use chladni_program::cli;
use chladni_program::studio::Settings;
use chladni_program::work::{Subject, mask};
use chladni_task::Task;
use chladni_view::{Panorama, Picture};
use tempfile::TempDir;

use crate::{MIB, divided, within};

/// The most memory that each byte of a picture or mask takes.
const EACH: usize = 64;
/// What the pixels of a picture take at most: as they are in the file, and as they are drawn.
const OF_PICTURES: usize = 768 * MIB;
/// As floating-point numbers, a panorama takes twelve bytes a pixel.
const OF_PANORAMAS: usize = 1024 * MIB;

/// A picture that stands behind a shape.
pub fn picture(bytes: &[u8]) {
    let read = within(bytes.len(), EACH, OF_PICTURES, || Picture::decode(bytes));
    let Ok(picture) = read else { return };
    assert_eq!(picture.rgba.len(), 4 * picture.width as usize * picture.height as usize);
    let upright = within(bytes.len(), EACH, OF_PICTURES, || Picture::decode_upright(bytes));
    assert_eq!(upright.expect("the same pixels").rgba.len(), picture.rgba.len());
    if picture.rgba.len() < 1 << 20 {
        let written = picture.to_png().expect("what was read can be written");
        assert_eq!(Picture::decode(&written).expect("and read").rgba, picture.rgba);
    }
}

/// A picture of all that is around.
pub fn panorama(bytes: &[u8]) {
    let _ = within(bytes.len(), EACH, OF_PANORAMAS, || Panorama::decode(bytes));
}

/// A mask, as an attribute or the colors of a PLY mesh of twelve vertices; what is read is written and read back as the same.
pub fn mask_mesh(bytes: &[u8]) {
    static SHAPE: LazyLock<Subject> = LazyLock::new(|| samples::icosphere(0).into());
    let read = |bytes: &[u8]| mask::read_in(Path::new("mask.ply"), bytes, &SHAPE);
    let Ok(painted) = within(bytes.len(), EACH, MIB, || read(bytes)) else { return };
    let (written, masked) = mask::to_bytes("ply", &painted, &SHAPE).expect("what was read can be written");
    assert!(masked.inside <= masked.vertices);
    assert_eq!(read(&written).expect("what was written can be read"), painted);
}

/// A file of preferences.
pub fn settings(text: &str) {
    // Where a value is not understood, all become tables of their own.
    let Ok(settings) = within(text.len(), 1024, MIB, || Settings::from_text(text)) else { return };
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

/// The arrays of a basis in a folder, in the order in which they lie in one input, with lines of `----` between them.
pub const STORED: [&str; 4] = ["eigenvectors", "eigenvalues", "mass", "operator_vertex"];

/// A basis in a folder; what can be opened can be used.
pub fn stored(bytes: &[u8]) {
    thread_local! {
        static FOLDER: TempDir = tempfile::tempdir().expect("a folder");
    }
    FOLDER.with(|folder| {
        let mut rest = bytes;
        for name in STORED {
            let (own, others) = divided(rest);
            std::fs::write(folder.path().join(format!("{name}.npy")), own).expect("room for an array");
            rest = others;
        }
        let read = within(bytes.len(), EACH, MIB, || StoredBasis::open(folder.path()));
        let Ok(basis) = read else { return };
        assert!(basis.mass().iter().all(|area| area.is_finite() && *area > 0.0));
        assert!(basis.operator_vertex().iter().flatten().all(|row| (*row as usize) < basis.mass().len()));
        let signal = vec![1.0; basis.operator_vertex().len()];
        let coefficients = basis.analyze(&[&signal], &Task::new()).expect("what was opened can be read");
        assert_eq!(coefficients[0].len(), basis.eigenvalues().len());
        let back = basis.synthesize(&[&coefficients[0]], &Task::new()).expect("what was opened can be read");
        assert_eq!(back[0].len(), signal.len());
    });
}
