//! The state of a concert that the page shows beside its picture.

use serde::Serialize;
use wasm_bindgen::prelude::*;

use chladni_music::{Settings, Switch, Viewpoint};

use super::Concert;

/// One dance of the gallery.
#[derive(Serialize)]
struct Dance<'a> {
    name: &'a str,
    chosen: bool,
    favorite: bool,
    locked: bool,
}

#[derive(Serialize)]
struct State<'a> {
    body: &'a str,
    dances: Vec<Dance<'a>>,
    /// The generation shown, counted from 0, and how many there are.
    generation: usize,
    generations: usize,
    /// One dance has the whole picture.
    on_stage: bool,
    sand: bool,
    piloted: bool,
    /// A saved show is played.
    played: bool,
    look: &'a str,
    viewpoint: Viewpoint,
    /// Knobs and switches, by their names in show files.
    settings: Settings,
}

#[wasm_bindgen]
impl Concert {
    /// All that controls show, as JSON.
    ///
    /// # Errors
    /// Bugs only.
    pub fn state(&self) -> Result<String, JsError> {
        let instrument = &self.instrument;
        let gallery = instrument.gallery();
        let is_favorite = |id| instrument.favorites().iter().any(|known| known.id == id);
        let beat = self.hearing.beat_at(self.clock.at_secs());
        let state = State {
            body: &self.name,
            dances: gallery
                .items()
                .iter()
                .map(|item| Dance {
                    name: &item.name,
                    chosen: item.chosen,
                    favorite: is_favorite(item.id),
                    locked: item.locked,
                })
                .collect(),
            generation: gallery.current(),
            generations: gallery.generations().len(),
            on_stage: instrument.scene(beat.count).is_some(),
            sand: instrument.parameters().is_on(Switch::Sand),
            piloted: self.programme.is_some(),
            played: self.script.is_some(),
            look: &self.looks.look,
            viewpoint: self.viewpoint,
            settings: instrument.parameters().settings(),
        };
        Ok(serde_json::to_string(&state)?)
    }
}
