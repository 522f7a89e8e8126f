//! What the program reads besides shapes and songs: pictures, masks, preferences, its arguments, and what it has put aside.

use std::ffi::OsString;
use std::path::Path;
use std::sync::LazyLock;

use chladni_harmonics::npz::StoredBasis;
use chladni_harmonics::{BasisCache, BasisSettings, Body, BuildReport};
use chladni_mesh::{Format, TriMesh, samples};
use chladni_program::cli;
use chladni_program::studio::Settings;
use chladni_program::work::{Subject, mask};
use chladni_task::Task;
use chladni_view::{Panorama, Picture};
use tempfile::TempDir;

use crate::documents::OF_TOML;
use crate::{MIB, divided, memory, within};

/// The most memory that each byte of a picture or mask takes.
const EACH: usize = 64;
/// What the pixels of a picture take at most: as they are in the file, and as they are drawn.
const OF_PICTURES: usize = 768 * MIB;
/// As floating-point numbers, a panorama takes twelve bytes a pixel.
const OF_PANORAMAS: usize = 1024 * MIB;

/// A picture that stands behind a shape. The textures of meshes are decoded by the same functions.
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

/// A mask for a shape of twelve vertices, in a file whose ending the first byte chooses; what is read is written and read
/// back, as the same where the file holds the numbers themselves.
pub fn mask_mesh(bytes: &[u8]) {
    static SHAPE: LazyLock<Subject> = LazyLock::new(|| samples::icosphere(0).into());
    let Some((first, bytes)) = bytes.split_first() else { return };
    let endings = mask::READ.iter().chain(&["gltf", "stl", "mesh"]).collect::<Vec<_>>();
    let ending = endings[usize::from(*first) % endings.len()];
    let read =
        |ending: &str, bytes: &[u8]| mask::read_in(Path::new(&format!("mask.{ending}")), bytes, &SHAPE);
    let (each, more) = Format::from_extension(ending).map_or((EACH, MIB), memory);
    let Ok(painted) = within(bytes.len(), each, more, || read(ending, bytes)) else { return };
    for ending in mask::WRITTEN {
        let (written, masked) =
            mask::to_bytes(ending, &painted, &SHAPE).expect("what was read can be written");
        assert!(masked.inside <= masked.vertices);
        let again = read(ending, &written).expect("what was written can be read");
        // Colors have eight bits.
        assert!(again == painted || matches!(ending, "obj" | "glb"));
    }
}

/// A file of preferences.
pub fn settings(text: &str) {
    let Ok(settings) = within(text.len(), OF_TOML, MIB, || Settings::from_text(text)) else { return };
    assert!((0.5..=3.0).contains(&settings.zoom) && settings.harmonics >= 2);
    let written = settings.to_text().expect("what was read can be written");
    assert_eq!(Settings::from_text(&written).expect("what was written can be read"), settings);
}

/// A command line, an argument a line; on Unix, arguments need not be text.
pub fn arguments(bytes: &[u8]) {
    let lines = bytes.split(|byte| *byte == b'\n');
    let arguments = std::iter::once(OsString::from("chladni")).chain(lines.map(argument));
    // The commands and their options take some MiB, whatever is asked.
    let understood = within(bytes.len(), 1024, 16 * MIB, || cli::understand(arguments));
    if let Err(error) = understood {
        assert!(!error.to_string().is_empty() && error.is_of_input());
    }
}

fn argument(bytes: &[u8]) -> OsString {
    #[cfg(unix)]
    let argument = <std::ffi::OsStr as std::os::unix::ffi::OsStrExt>::from_bytes(bytes).to_owned();
    #[cfg(not(unix))]
    let argument = String::from_utf8_lossy(bytes).into_owned().into();
    argument
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
            let (body, report) = within(bytes.len(), 4, 2 * MIB, || look_up(mesh, cache));
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
