//! Texts: what is read is written and read back as the same.

use chladni_caricature::Project;
use chladni_match::{read_landmarks, write_landmarks};
use chladni_music::{Bindings, GalleryShape, Preset, Show};

use crate::{MIB, place, within};

/// The most memory that each byte of a TOML text takes: two bytes can make a table within a table, which takes a kilobyte
/// while it is read. Preferences that are not understood as a whole come closest, as they are kept twice.
pub(crate) const OF_TOML: usize = 1024;
/// The same of lines of numbers.
const OF_LINES: usize = 128;

/// A caricature project, or the copy that autosave keeps of one.
pub fn project(text: &str) {
    // Painted values are packed; those of all layers are bounded together.
    let read = within(text.len(), OF_TOML, 256 * MIB, || Project::from_text(text, place()));
    let Ok((project, from)) = read else { return };
    let written = project.to_text(place(), from).expect("what was read can be written");
    let (again, _) = Project::from_text(&written, place()).expect("what was written can be read");
    let rewritten = again.to_text(place(), None).expect("what was read can be written");
    let (last, _) = Project::from_text(&rewritten, place()).expect("what was written can be read");
    assert_eq!(rewritten, last.to_text(place(), None).expect("what was read can be written"));
}

/// A preset.
pub fn preset(text: &str) {
    let Ok(preset) = within(text.len(), OF_TOML, MIB, || Preset::from_text(text)) else { return };
    let written = preset.to_text().expect("what was read can be written");
    let again = Preset::from_text(&written).expect("what was written can be read");
    assert_eq!(written, again.to_text().expect("what was read can be written"));
    preset.caution();
}

/// A show or a session, which is then replayed.
pub fn show(text: &str) {
    let Ok(show) = within(text.len(), OF_TOML, MIB, || Show::from_text(text)) else { return };
    let written = show.to_text().expect("what was read can be written");
    let again = Show::from_text(&written).expect("what was written can be read");
    assert_eq!(written, again.to_text().expect("what was read can be written"));
    if show.actions.len() < 64 {
        let _ = show.replay(GalleryShape { eigenvalues: (0..16).map(f64::from).collect(), bands: 8 });
    }
}

/// Bindings of controllers.
pub fn bindings(text: &str) {
    let mut bindings = Bindings::default();
    if within(text.len(), OF_TOML, MIB, || bindings.import(text)).is_ok() {
        let written = bindings.to_text().expect("what was read can be written");
        let mut again = Bindings::default();
        again.import(&written).expect("what was written can be read");
        assert_eq!(bindings.list(), again.list());
    }
}

/// Pairs of vertices.
pub fn landmarks(text: &str) {
    if let Ok(landmarks) = within(text.len(), OF_LINES, MIB, || read_landmarks(text)) {
        assert_eq!(read_landmarks(&write_landmarks(&landmarks)).as_ref(), Ok(&landmarks));
    }
}
