//! Knobs and switches, as presets and shows store them.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{Choir, Form, MusicError, Parameter, Switch};

/// Values for some or all of the knobs and switches, as presets and shows store them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Filter, modal or half-mask.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub form: Option<Form>,
    /// Which harmonics may sound.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub choir: Option<Choir>,
    /// Harmonics in use; 0 is all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub harmonics: Option<u32>,
    /// By their names.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub knobs: BTreeMap<Parameter, f32>,
    /// By their names.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub switches: BTreeMap<Switch, bool>,
}

impl Settings {
    /// Whether nothing is named.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The initial settings of sessions and presets of version 1.
    pub(crate) fn of_version_1() -> Self {
        use Parameter as P;
        let knobs = [
            (P::Decay, 0.5),
            (P::SideGain, 10.0),
            (P::Bands, 128.0),
            (P::Gain, 1.0),
            (P::Calibration, 0.08),
            (P::Limit, 0.18),
            (P::Detail, 1.0),
            (P::NormalBlending, 0.0),
            (P::TransitionBeats, 4.0),
            (P::BeatsPerStep, 16.0),
            (P::TurnRad, 0.35),
            (P::LightSwingRad, 0.9),
            (P::LightPulse, 0.15),
        ];
        let on = [Switch::BeatTurns, Switch::BeatLights, Switch::FlashLimit, Switch::LogBands, Switch::OwnMu];
        Self {
            form: Some(Form::Filter),
            choir: Some(Choir::All),
            harmonics: None,
            knobs: knobs.into(),
            switches: Switch::ALL.into_iter().map(|switch| (switch, on.contains(&switch))).collect(),
        }
    }

    /// A show that does not say so has a camera that stands still.
    pub(crate) fn of_a_show(mut self) -> Self {
        self.switches.entry(Switch::Camera).or_insert(false);
        self
    }

    /// Before version 3 nothing resonated.
    pub(crate) fn of_version_2(mut self) -> Self {
        self.switches.entry(Switch::Resonate).or_insert(false);
        self
    }

    pub(crate) fn validate(&self) -> Result<(), MusicError> {
        self.knobs.iter().try_for_each(|(knob, &value)| knob.check(value))
    }
}
