//! Texts and packets: what is read is written and read back as the same.

use chladni_caricature::Project;
use chladni_match::{read_landmarks, write_landmarks};
use chladni_music::{
    Bindings, ClockMessage, GalleryShape, OscMessage, Parameters, Preset, Show, Tempo, Touch,
};

use crate::{MIB, place, within};

/// The most memory that each byte of a text takes.
const EACH: usize = 128;

/// A caricature project, or the copy that autosave keeps of one.
pub fn project(text: &str) {
    // Painted values are packed; those of all layers are bounded together.
    let read = within(text.len(), EACH, 256 * MIB, || Project::from_text(text, place()));
    let Ok((project, from)) = read else { return };
    let written = project.to_text(place(), from).expect("what was read can be written");
    let (again, _) = Project::from_text(&written, place()).expect("what was written can be read");
    let rewritten = again.to_text(place(), None).expect("what was read can be written");
    let (last, _) = Project::from_text(&rewritten, place()).expect("what was written can be read");
    assert_eq!(rewritten, last.to_text(place(), None).expect("what was read can be written"));
}

/// A preset.
pub fn preset(text: &str) {
    let Ok(preset) = within(text.len(), EACH, MIB, || Preset::from_text(text)) else { return };
    let written = preset.to_text().expect("what was read can be written");
    let again = Preset::from_text(&written).expect("what was written can be read");
    assert_eq!(written, again.to_text().expect("what was read can be written"));
    preset.caution();
}

/// A show or a session, which is then replayed.
pub fn show(text: &str) {
    let Ok(show) = within(text.len(), EACH, MIB, || Show::from_text(text)) else { return };
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
    if within(text.len(), EACH, MIB, || bindings.import(text)).is_ok() {
        let written = bindings.to_text().expect("what was read can be written");
        let mut again = Bindings::default();
        again.import(&written).expect("what was written can be read");
        assert_eq!(bindings.list(), again.list());
    }
}

/// Pairs of vertices.
pub fn landmarks(text: &str) {
    if let Ok(landmarks) = within(text.len(), EACH, MIB, || read_landmarks(text)) {
        assert_eq!(read_landmarks(&write_landmarks(&landmarks)).as_ref(), Ok(&landmarks));
    }
}

/// MIDI messages and OSC packets, as they turn knobs and set the clock; each begins with its length.
pub fn messages(mut bytes: &[u8]) {
    let (mut bindings, mut parameters, mut tempo) =
        (Bindings::default(), Parameters::default(), Tempo::default());
    let mut secs = 0.0;
    let mut targets = chladni_music::Target::all().collect::<Vec<_>>().into_iter().cycle();
    while let Some((&length, rest)) = bytes.split_first() {
        let (message, rest) = rest.split_at(usize::from(length).min(rest.len()));
        bytes = rest;
        secs += f64::from(length) / 100.0;
        let packet = OscMessage::in_packet(message).unwrap_or_default();
        let clocks = packet.iter().filter_map(|m| ClockMessage::from_osc(&m.address, m.value));
        clocks.chain(ClockMessage::from_midi(message)).for_each(|clock| tempo.hear(clock, secs));
        let beat = tempo.at(secs);
        assert!(tempo.bpm().is_none_or(|bpm| bpm.is_finite() && bpm > 0.0), "{beat:?}");
        let Some(touch) = Touch::from_midi("", message) else { continue };
        bindings.learn(targets.next().map(|target| (target, None)));
        let now = parameters.clone();
        if let Some(chladni_music::Cue::Do(chladni_music::Action::Set { parameter, value })) =
            bindings.touch(&touch, &now, &|target, number| target.standing(number, &now))
        {
            parameters.set(parameter, value).expect("a knob gives what its parameter takes");
        }
    }
}
