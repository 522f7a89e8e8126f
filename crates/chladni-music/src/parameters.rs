//! Where all knobs and switches stand.

use chladni_synth::FrameSettings;

use crate::{Choir, FlashArea, Form, MusicError, Parameter, Playing, Settings, Switch, Timbre};

/// The positions of all knobs and switches.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters {
    values: [f32; Parameter::ALL.len()],
    on: [bool; Switch::ALL.len()],
    /// Filter, modal or half-mask.
    pub form: Form,
    /// Which harmonics may move.
    pub choir: Choir,
    /// The number of harmonics in use; `None` for all.
    pub harmonics: Option<u32>,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            values: Parameter::ALL.map(Parameter::initial),
            on: [true, true, false, false, true, false, true, true, true, false, false, true],
            form: Form::default(),
            choir: Choir::default(),
            harmonics: None,
        }
    }
}

impl Parameters {
    /// The settings for synthesizing shapes from the items that these parameters play.
    pub fn frame_settings(&self) -> FrameSettings {
        // Blending at full strength is the paper's: the mean of the exact and the rest normal.
        FrameSettings { normal_blending: 0.5 * self.get(Parameter::NormalBlending) }
    }

    /// The value of a knob.
    pub fn get(&self, parameter: Parameter) -> f32 {
        self.values[parameter as usize]
    }

    /// Sets a knob.
    ///
    /// # Errors
    /// A value out of the knob's [range](Parameter::range).
    pub fn set(&mut self, parameter: Parameter, value: f32) -> Result<(), MusicError> {
        parameter.check(value)?;
        self.values[parameter as usize] = value;
        Ok(())
    }

    /// Whether a switch is on.
    pub fn is_on(&self, switch: Switch) -> bool {
        self.on[switch as usize]
    }

    /// Where no more than a quarter may flash more than three times a second; `None` where nothing is limited.
    pub fn flash_area(&self) -> Option<FlashArea> {
        let area = if self.is_on(Switch::FlashFields) { FlashArea::Field } else { FlashArea::Screen };
        self.is_on(Switch::FlashLimit).then_some(area)
    }

    /// Turns a switch on or off.
    pub fn switch(&mut self, switch: Switch, on: bool) {
        self.on[switch as usize] = on;
    }

    /// The parameters that players need.
    pub fn playing(&self) -> Playing {
        Playing {
            form: self.form,
            choir: self.choir,
            gain: self.get(Parameter::Gain),
            flip_sides: self.is_on(Switch::FlipSides),
            calibration: self.get(Parameter::Calibration),
            limit: self.get(Parameter::Limit),
            detail: self.get(Parameter::Detail),
            harmonics: self.harmonics,
            stereo_mu: (!self.is_on(Switch::OwnMu)).then(|| self.get(Parameter::StereoMu)),
            timbre: self.timbre(),
        }
    }

    /// The timbre that the knobs describe; `None` while the resonators are off.
    pub fn timbre(&self) -> Option<Timbre> {
        self.is_on(Switch::Resonate).then(|| Timbre {
            damping: self.get(Parameter::Damping),
            tuning_hz: self.get(Parameter::TuningHz),
            stretch: self.get(Parameter::Stretch),
            strike: self.get(Parameter::Strike),
            hold: self.get(Parameter::Hold),
        })
    }

    /// All settings.
    pub fn settings(&self) -> Settings {
        self.some(&Parameter::ALL, &Switch::ALL)
    }

    /// The settings that affect how one dance looks: those that a preset stores.
    pub fn of_a_dance(&self) -> Settings {
        self.some(&Parameter::OF_A_DANCE, &Switch::OF_A_DANCE)
    }

    fn some(&self, knobs: &[Parameter], switches: &[Switch]) -> Settings {
        Settings {
            form: Some(self.form),
            choir: Some(self.choir),
            harmonics: Some(self.harmonics.unwrap_or(0)),
            knobs: knobs.iter().map(|&knob| (knob, self.get(knob))).collect(),
            switches: switches.iter().map(|&switch| (switch, self.is_on(switch))).collect(),
        }
    }

    /// Applies `settings`. Settings that they do not name stay. After an error nothing has changed.
    ///
    /// # Errors
    /// A setting outside its range.
    pub fn apply(&mut self, settings: &Settings) -> Result<(), MusicError> {
        settings.validate()?;
        self.form = settings.form.unwrap_or(self.form);
        self.choir = settings.choir.unwrap_or(self.choir);
        let harmonics = settings.harmonics.or(self.harmonics);
        self.harmonics = harmonics.filter(|&harmonics| harmonics > 0);
        settings.knobs.iter().try_for_each(|(&knob, &value)| self.set(knob, value))?;
        settings.switches.iter().for_each(|(&switch, &on)| self.switch(switch, on));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_begin_as_players_do_and_keep_to_their_ranges() {
        assert_eq!(Parameters::default().playing(), Playing::default());
        assert!(Parameters::default().is_on(Switch::FlashLimit));
        assert!(Parameters::default().set(Parameter::Gain, f32::NAN).is_err());
    }
}
