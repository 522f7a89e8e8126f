//! Shows and presets, as the texts that the desktop reads and writes, too.

use chladni_music::{Action, FileRef, Preset, Show};
use chladni_program::work::{Hearing, ShowClock, cautions, is_like_a_show};
use serde::Serialize;
use wasm_bindgen::prelude::*;

use super::Concert;
use super::beat::ShowSong;

/// A preset, or a show with the files that the page has to find by itself.
#[derive(Serialize)]
struct Needs {
    /// It is a preset, which needs none.
    preset: bool,
    body: Option<String>,
    songs: Vec<String>,
    caution: Option<String>,
}

impl Needs {
    fn of_preset(preset: &Preset) -> Self {
        Self { preset: true, body: None, songs: Vec::new(), caution: preset.caution() }
    }

    fn of_show(show: Show) -> Self {
        Self {
            preset: false,
            caution: cautions(&show).reduce(|a, b| format!("{a} {b}")),
            body: show.body.map(|body| body.path),
            songs: show.songs.into_iter().map(|song| song.path).collect(),
        }
    }
}

/// Whether a text is a preset or a show, the body and songs that a show names, and what is to be said of either, as JSON.
///
/// # Errors
/// Text that is neither: the error is that of what it was probably meant as.
#[wasm_bindgen]
pub fn needs_of_text(text: &str) -> Result<String, JsError> {
    let needs = match Preset::from_text(text) {
        Ok(preset) => Needs::of_preset(&preset),
        Err(not_preset) => match Show::from_text(text) {
            Ok(show) => Needs::of_show(show),
            Err(not_show) => {
                let why = if is_like_a_show(text) { not_show } else { not_preset };
                return Err(why.into());
            }
        },
    };
    Ok(serde_json::to_string(&needs)?)
}

#[wasm_bindgen]
impl Concert {
    /// The show so far, as the text of a show file. Files that a show names which was opened keep their folders.
    ///
    /// # Errors
    /// Bugs only.
    pub fn save_show(&self) -> Result<String, JsError> {
        let body =
            self.shows_body.clone().unwrap_or_else(|| FileRef { path: self.name.clone(), blake3: None });
        let show = Show {
            stands: self.given,
            body: Some(body),
            looks: Some(self.looks.clone()),
            viewpoint: self.viewpoint,
            songs: self.songs.iter().map(ShowSong::reference).collect(),
            heard: self.hearing.stretches().collect(),
            clock: self.clock_track(),
            duration_secs: Some(self.clock.at_secs()),
            ..Show::of(&self.instrument)
        };
        Ok(show.to_text()?)
    }

    /// Goes on where a show ended: its gallery, its knobs, its look if it names one, its time and what was heard until
    /// then. What it was danced on, and what is heard from now on, is up to the page ([`needs_of_text`]), which numbers
    /// songs as the show does. Gives a warning where its dances are others with the harmonics here.
    ///
    /// # Errors
    /// Text that is not a show, and a show that cannot be danced here.
    pub fn open_show(&mut self, text: &str) -> Result<Option<String>, JsError> {
        let show = Show::from_text(text)?;
        let caution = show.caution_on(self.harmonics());
        self.instrument = show.replay(self.instrument.shape().clone())?;
        self.set_as_in(&show);
        let at_secs = show.ends_secs();
        (self.programme, self.script, self.before_sand, self.live) = (None, None, None, None);
        self.hearing = Hearing::continued(&show.heard, show.clock, at_secs);
        self.clock = ShowClock::from(at_secs);
        self.hearing.tune(at_secs, self.instrument.parameters());
        self.songs = show.songs.into_iter().map(ShowSong::from).collect();
        // Its songs are not known yet, and the count begins without their beats.
        self.count_beats()?;
        Ok(caution)
    }

    /// A dance as the text of a preset file.
    ///
    /// # Errors
    /// A dance that is not there.
    pub fn save_preset(&self, item: usize) -> Result<String, JsError> {
        let items = self.instrument.gallery().items();
        let found = items.get(item).ok_or_else(|| JsError::new("there is no such dance"))?;
        Ok(self.instrument.preset(found, self.instrument.tags(found.id)).to_text()?)
    }

    /// Puts a preset in the place of a dance.
    ///
    /// # Errors
    /// Text that is not a preset.
    pub fn open_preset(&mut self, item: usize, text: &str) -> Result<(), JsError> {
        let preset = Box::new(Preset::from_text(text)?);
        Ok(self.act(Action::Take { item, preset })?)
    }
}
