//! The knobs and switches of the instrument, from which the page makes its controls.

use std::collections::BTreeMap;

use chladni_music::{Action, Choir, Form, Parameter, Parameters, Switch, Timbre};
use chladni_program::work::knobs::{
    CHOIRS, Choice, FORMS, KNOBS, Knob, SWITCHES, Shown, by_factors, idle, shown,
};
use serde::Serialize;
use wasm_bindgen::prelude::*;

use super::Concert;

#[derive(Serialize)]
struct Table {
    forms: [(Form, &'static str, &'static str); 3],
    choirs: [(Choir, &'static str); 3],
    timbres: Vec<&'static str>,
    knobs: Vec<(&'static str, Vec<Range>)>,
    switches: Vec<(&'static str, Vec<Check>)>,
}

/// A switch, its name and what it does.
type Check = (Switch, &'static str, &'static str);

/// A knob: its value goes from `low` to `high`, and is shown times `factor`.
#[derive(Serialize)]
struct Range {
    parameter: Parameter,
    name: &'static str,
    tip: &'static str,
    low: f32,
    high: f32,
    by_factors: bool,
    factor: f64,
    decimals: usize,
    unit: &'static str,
}

impl Range {
    fn of(&(parameter, name): &Knob) -> Self {
        let tip = parameter.about();
        let ((low, high), Shown { factor, decimals, unit }) = (parameter.range(), shown(parameter));
        Self { parameter, name, tip, low, high, by_factors: by_factors(parameter), factor, decimals, unit }
    }
}

/// All knobs and switches in their groups, forms and timbres, as JSON.
///
/// # Errors
/// Bugs only.
#[wasm_bindgen]
pub fn knobs() -> Result<String, JsError> {
    let check = |&(switch, name): &Choice| (switch, name, switch.about());
    let table = Table {
        forms: FORMS,
        choirs: CHOIRS,
        timbres: Timbre::NAMED.map(|(name, _)| name).to_vec(),
        knobs: KNOBS.iter().map(|(name, rows)| (*name, rows.iter().map(Range::of).collect())).collect(),
        switches: SWITCHES.iter().map(|(name, rows)| (*name, rows.iter().map(check).collect())).collect(),
    };
    Ok(serde_json::to_string(&table)?)
}

#[wasm_bindgen]
impl Concert {
    /// Has the harmonics ring as a timbre of that name; with an empty one they follow the level of the sound.
    ///
    /// # Errors
    /// A name that no timbre has.
    pub fn set_timbre(&mut self, name: &str) -> Result<(), JsError> {
        if name.is_empty() {
            return Ok(self.act(Action::Switch { switch: Switch::Resonate, on: false })?);
        }
        let timbre = Timbre::named(name).ok_or_else(|| JsError::new("there is no such timbre"))?;
        for action in Action::for_timbre(&timbre) {
            self.act(action)?;
        }
        Ok(())
    }
}

/// The name of the timbre that the knobs make: `""` where nothing resonates, none where no timbre has these knobs.
pub(super) fn timbre(parameters: &Parameters) -> Option<&'static str> {
    let Some(now) = parameters.timbre() else { return Some("") };
    Timbre::NAMED.into_iter().find(|(_, timbre)| *timbre == now).map(|(name, _)| name)
}

/// Why knobs have no effect now, by their names.
pub(super) fn idle_knobs(parameters: &Parameters) -> BTreeMap<&'static str, &'static str> {
    let why = |knob: Parameter| Some((knob.name(), idle(parameters, knob, false)?));
    Parameter::ALL.into_iter().filter_map(why).collect()
}
