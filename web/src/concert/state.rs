//! The state of a concert that the page shows beside its picture.

use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hasher};

use serde::Serialize;
use wasm_bindgen::prelude::*;

use chladni_music::{FormControl, Looks, Mapping, Settings, Switch, Viewpoint};
use chladni_program::work::{look_named, look_on_stage};
use chladni_view::Effect;

use super::Concert;
use super::knobs::{idle_knobs, timbre};

/// One dance of the gallery.
#[derive(Serialize)]
struct Dance<'a> {
    name: &'a str,
    chosen: bool,
    favorite: bool,
    locked: bool,
    /// Its own strength and μ.
    gain: f32,
    stereo_mu: f32,
    /// Another number where t or a is another one.
    curves: u32,
}

fn hash_of_curves(mapping: &Mapping) -> u32 {
    let mut hasher = DefaultHasher::new();
    for value in mapping.transfer.iter().chain(&mapping.amplification) {
        hasher.write_u32(value.to_bits());
    }
    hasher.finish() as u32
}

#[derive(Serialize)]
struct State<'a> {
    body: &'a str,
    /// The axis that was set to point up; empty where none was.
    up: String,
    dances: Vec<Dance<'a>>,
    /// The generation shown, counted from 0, and how many there are.
    generation: usize,
    generations: usize,
    /// The neighbors of the generation shown, where it has them.
    back: Option<usize>,
    forth: Option<usize>,
    /// How many dances are favorites.
    favorites: usize,
    /// The seed of all that is random, as text: the page's numbers hold only those up to 2⁵³.
    seed: String,
    /// One dance has the whole picture.
    on_stage: bool,
    sand: bool,
    piloted: bool,
    /// A saved show is played.
    played: bool,
    looks: &'a Looks,
    /// The effects of the look that is seen, with those that are left out of it.
    effects: Vec<&'static str>,
    /// The shape brings colors.
    has_own_colors: bool,
    viewpoint: Viewpoint,
    /// Knobs and switches, by their names in show files.
    settings: Settings,
    /// The body's harmonics.
    harmonics: usize,
    timbre: Option<&'static str>,
    /// Why the μ of a dance has no effect now.
    without_mu: Option<&'static str>,
    /// Why knobs have no effect now, by their names.
    idle: BTreeMap<&'static str, &'static str>,
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
        let beat = self.beat_at(self.clock.at_secs());
        let state = State {
            body: &self.name,
            up: self.up(),
            dances: gallery
                .items()
                .iter()
                .map(|item| Dance {
                    name: &item.name,
                    chosen: item.chosen,
                    favorite: instrument.is_favorite(item.id),
                    locked: item.locked,
                    gain: item.genome.gain,
                    stereo_mu: item.genome.stereo_mu,
                    curves: hash_of_curves(&item.genome),
                })
                .collect(),
            generation: gallery.current(),
            generations: gallery.generations().len(),
            back: gallery.back(),
            forth: gallery.forth(),
            favorites: instrument.favorites().len(),
            seed: gallery.seed().to_string(),
            on_stage: instrument.scene(beat).is_some(),
            sand: instrument.parameters().is_on(Switch::Sand),
            piloted: self.programme.is_some(),
            played: self.script.is_some(),
            looks: &self.looks,
            effects: self.own_effects(),
            has_own_colors: self.staging.has_own_colors(),
            viewpoint: self.viewpoint,
            settings: instrument.parameters().settings(),
            harmonics: instrument.shape().eigenvalues.len(),
            timbre: timbre(instrument.parameters()),
            without_mu: instrument.parameters().form.ignores(FormControl::StereoMu),
            idle: idle_knobs(instrument.parameters()),
        };
        Ok(serde_json::to_string(&state)?)
    }
}

impl Concert {
    fn own_effects(&self) -> Vec<&'static str> {
        let whole = Looks { without: Vec::new(), ..self.looks.clone() };
        let finish = look_on_stage(&self.instrument, look_named(&whole).0).finish;
        let own = Effect::NAMED.into_iter().filter(|(_, effect)| finish.has(*effect));
        own.map(|(name, _)| name).collect()
    }
}
