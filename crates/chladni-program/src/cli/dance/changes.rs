//! Changes that arguments make to an instrument before it is heard: form, ringing, choir, and any knob or switch by
//! name.

use chladni_music::{
    Action, MAX_GENES, PAPER_MODE, Parameter, Parameters, Switch, Target, Timbre, preceding, setting,
};

use super::Dance;
use crate::work::Error;

impl Dance {
    /// The actions that the arguments ask for, before anything else is done.
    pub(super) fn changes(&self) -> Result<Vec<Action>, Error> {
        let mut changes = Vec::new();
        changes.extend(self.paper.then_some(PAPER_MODE).into_iter().flatten());
        changes.extend(self.form.map(|form| Action::SetForm { form }));
        match self.timbre {
            Some(Ring::As(timbre)) => changes.extend(Action::for_timbre(&timbre)),
            Some(Ring::Not) => changes.push(Action::Switch { switch: Switch::Resonate, on: false }),
            None => {}
        }
        changes.extend(self.choir.map(|choir| Action::SetChoir { choir }));
        if let Some(value) = self.gain {
            changes.push(turned("--gain", Parameter::Gain, value)?);
        }
        if let Some(value) = self.mu {
            changes.push(Action::Switch { switch: Switch::OwnMu, on: false });
            changes.push(turned("--mu", Parameter::StereoMu, value)?);
        }
        changes.extend(self.sets()?);
        Ok(changes)
    }

    /// The actions that `--set` asks for. The µ of the knob takes the place of those of the dances, as over OSC, unless
    /// it is said which of them is heard.
    fn sets(&self) -> Result<Vec<Action>, Error> {
        let read = |text: &String| set(text).map_err(|why| Error::Input(format!("--set {text}: {why}")));
        let sets: Vec<Action> = self.set.iter().map(read).collect::<Result<_, _>>()?;
        let is_said = sets.iter().any(|set| matches!(set, Action::Switch { switch: Switch::OwnMu, .. }));
        let first = Parameters::default();
        let before = |action: &Action| preceding(action, &first).filter(|_| !is_said);
        Ok(sets.into_iter().flat_map(|set| before(&set).into_iter().chain([set])).collect())
    }
}

/// The action that an option asks for, which is called `option` and is followed by `value`.
fn turned(option: &str, parameter: Parameter, value: f32) -> Result<Action, Error> {
    Parameters::default().set(parameter, value).map_err(|why| Error::from(why).of(option))?;
    Ok(Action::Set { parameter, value })
}

/// The action that NAME=VALUE asks for, or why there is none.
fn set(text: &str) -> Result<Action, String> {
    let (name, value) = text.split_once('=').ok_or("expected NAME=VALUE, such as decay=0.7 or form=modal")?;
    let (name, value) = (name.trim(), value.trim());
    if let Some(knob) = Parameter::ALL.into_iter().find(|knob| knob.name() == name) {
        let (low, high) = knob.range();
        if !value.parse::<f32>().is_ok_and(|value| (low..=high).contains(&value)) {
            return Err(format!("{name} is a number from {low} to {high}"));
        }
    }
    // Fewer than none would be all of them.
    let is_count = |number: f32| (0.0..=MAX_GENES as f32).contains(&number);
    if name == "harmonics" && !value.parse().is_ok_and(is_count) {
        return Err(format!("harmonics is a number from 0 (all) to {MAX_GENES}"));
    }
    setting(name, value).ok_or_else(|| {
        // Whatever has a value takes 0.
        if setting(name, "0").is_some() {
            format!("{name} has no value called {value}")
        } else {
            no_setting(name)
        }
    })
}

/// Why `--set` does not take `name`, and what does.
fn no_setting(name: &str) -> String {
    match Target::named(name) {
        None => format!("no knob or switch is called {name}; docs/controls.md lists them"),
        Some(
            Target::Look
            | Target::Palette
            | Target::Material
            | Target::Lights
            | Target::Background
            | Target::Blur
            | Target::Preset
            | Target::Autopilot,
        ) => format!("{name} has an option of its own: --{name}"),
        Some(_) => {
            format!("{name} belongs to the window and its remote controls; a dance has no such setting")
        }
    }
}

/// How harmonics may ring, by name.
pub(super) fn rings() -> impl Iterator<Item = (&'static str, Ring)> {
    let timbres = Timbre::NAMED.into_iter().map(|(name, timbre)| (name, Ring::As(timbre)));
    std::iter::once(("none", Ring::Not)).chain(timbres)
}

/// Whether harmonics ring.
#[derive(Clone, Copy, Debug)]
pub(super) enum Ring {
    Not,
    As(Timbre),
}
