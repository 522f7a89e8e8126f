//! Every knob and switch of the instrument, by name and range: what a slider, a MIDI
//! controller or an OSC message turns.

use serde::{Deserialize, Serialize};

use crate::{Choir, Error, Form, Playing};

/// A number that can be turned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Parameter {
    /// w: how much of the spectrum of 50 ms ago is left.
    Decay,
    /// What the side signal is multiplied by.
    SideGain,
    /// #ω, rounded.
    Bands,
    /// Overall strength of the movement.
    Gain,
    /// Share of the bounding box that a full-scale band moves the shape at gain 1.
    Calibration,
    /// Share of the bounding box that no vertex is to exceed.
    Limit,
    /// φ_d, the gain of all detail above K.
    Detail,
    /// 0: exact normals; 1: halfway to the rest normals, the paper's "normal enhancement".
    NormalBlending,
    /// Beats that a change on stage takes.
    TransitionBeats,
    /// Beats between two favourites when the beat steps through them, rounded.
    BeatsPerStep,
    /// How far the beat turns the model, in radians.
    TurnRad,
    /// How far the beat moves the lights, in radians.
    LightSwingRad,
    /// How much brighter the lights are on the beat.
    LightPulse,
}

impl Parameter {
    /// All of them.
    pub const ALL: [Self; 13] = [
        Self::Decay,
        Self::SideGain,
        Self::Bands,
        Self::Gain,
        Self::Calibration,
        Self::Limit,
        Self::Detail,
        Self::NormalBlending,
        Self::TransitionBeats,
        Self::BeatsPerStep,
        Self::TurnRad,
        Self::LightSwingRad,
        Self::LightPulse,
    ];

    /// Its name in session files, MIDI maps and OSC addresses.
    pub fn name(self) -> &'static str {
        self.row().0
    }

    /// Lowest and highest value.
    pub fn range(self) -> (f32, f32) {
        (self.row().1, self.row().2)
    }

    /// The value to begin with.
    pub fn initial(self) -> f32 {
        self.row().3
    }

    /// The value at a share of the way in [0, 1]: even steps, or even factors where the range
    /// spans more than three powers of ten.
    pub fn at_share(self, share: f32) -> f32 {
        let (low, high) = self.range();
        let share = share.clamp(0.0, 1.0);
        let even_factors = low > 0.0 && high / low > 1000.0;
        let value = if even_factors { low * (high / low).powf(share) } else { low + share * (high - low) };
        value.clamp(low, high)
    }

    fn row(self) -> (&'static str, f32, f32, f32) {
        match self {
            Self::Decay => ("decay", 0.0, 0.99, 0.5),
            Self::SideGain => ("side-gain", 0.0, 100.0, 10.0),
            Self::Bands => ("bands", 2.0, 4096.0, 128.0),
            Self::Gain => ("gain", 0.0, 20.0, 1.0),
            Self::Calibration => ("calibration", 0.001, 1.0, 0.08),
            Self::Limit => ("limit", 0.01, 1.0, 0.18),
            Self::Detail => ("detail", -10.0, 10.0, 1.0),
            Self::NormalBlending => ("normal-blending", 0.0, 1.0, 0.0),
            Self::TransitionBeats => ("transition-beats", 0.0, 64.0, 4.0),
            Self::BeatsPerStep => ("beats-per-step", 1.0, 256.0, 16.0),
            Self::TurnRad => ("turn-rad", 0.0, 3.2, 0.35),
            Self::LightSwingRad => ("light-swing-rad", 0.0, 3.2, 0.9),
            Self::LightPulse => ("light-pulse", 0.0, 1.0, 0.15),
        }
    }
}

/// Something that is on or off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Switch {
    /// The beat turns the model.
    BeatTurns,
    /// The beat moves the lights.
    BeatLights,
    /// The beat steps to the next favourite.
    BeatSteps,
    /// Left and right are exchanged.
    FlipSides,
    /// At most three flashes a second (on unless switched off).
    FlashLimit,
    /// Sound bands lie in equal steps of pitch rather than of frequency.
    LogBands,
}

impl Switch {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::BeatTurns,
        Self::BeatLights,
        Self::BeatSteps,
        Self::FlipSides,
        Self::FlashLimit,
        Self::LogBands,
    ];

    /// Its name in session files and OSC addresses.
    pub fn name(self) -> &'static str {
        match self {
            Self::BeatTurns => "beat-turns",
            Self::BeatLights => "beat-lights",
            Self::BeatSteps => "beat-steps",
            Self::FlipSides => "flip-sides",
            Self::FlashLimit => "flash-limit",
            Self::LogBands => "log-bands",
        }
    }
}

/// Where all knobs and switches stand.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters {
    values: [f32; Parameter::ALL.len()],
    on: [bool; Switch::ALL.len()],
    /// Filter, modal or half-mask.
    pub form: Form,
    /// Which harmonics may sound.
    pub choir: Choir,
    /// Harmonics in use; `None` is all.
    pub harmonics: Option<u32>,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            values: Parameter::ALL.map(Parameter::initial),
            on: [true, true, false, false, true, true],
            form: Form::default(),
            choir: Choir::default(),
            harmonics: None,
        }
    }
}

impl Parameters {
    /// Where a knob stands.
    pub fn get(&self, parameter: Parameter) -> f32 {
        self.values[parameter as usize]
    }

    /// Turns a knob; errors outside its range.
    pub fn set(&mut self, parameter: Parameter, value: f32) -> Result<(), Error> {
        let (low, high) = parameter.range();
        if !(low..=high).contains(&value) {
            let range = format!("[{low}, {high}]");
            return Err(Error::OutOfRange { name: parameter.name(), value: value.into(), range });
        }
        self.values[parameter as usize] = value;
        Ok(())
    }

    /// Whether a switch is on.
    pub fn is_on(&self, switch: Switch) -> bool {
        self.on[switch as usize]
    }

    /// Turns a switch on or off.
    pub fn switch(&mut self, switch: Switch, on: bool) {
        self.on[switch as usize] = on;
    }

    /// What the players need of them.
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
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_the_order_of_the_enum_and_within_ranges() {
        for (i, p) in Parameter::ALL.into_iter().enumerate() {
            assert_eq!(p as usize, i);
            let (low, high) = p.range();
            assert!((low..=high).contains(&p.initial()), "{}", p.name());
        }
        for (i, s) in Switch::ALL.into_iter().enumerate() {
            assert_eq!(s as usize, i);
        }
        assert!((Parameter::Bands.at_share(0.5) - 90.5).abs() < 0.1);
        assert_eq!(Parameter::TurnRad.at_share(0.5), 1.6);
        assert_eq!(Parameters::default().playing(), Playing::default());
        assert!(Parameters::default().is_on(Switch::FlashLimit));
        assert!(Parameters::default().set(Parameter::Gain, f32::NAN).is_err());
    }
}
