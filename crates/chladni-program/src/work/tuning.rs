//! The knobs of the ear.

use chladni_music::{Parameter, Parameters, Switch, Timbre};
use chladni_sound::{FrontEnd, SpectrumSettings};

/// The knobs that the ear has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tuning {
    pub bands: usize,
    pub decay: f32,
    pub side_gain: f32,
    pub front_end: FrontEnd,
    /// The timbre of the resonators; none where they are off.
    pub timbre: Option<Timbre>,
}

impl Tuning {
    pub fn of(parameters: &Parameters) -> Self {
        Self {
            bands: parameters.get(Parameter::Bands).round() as usize,
            decay: parameters.get(Parameter::Decay),
            side_gain: parameters.get(Parameter::SideGain),
            front_end: if parameters.is_on(Switch::LogBands) { FrontEnd::LogBands } else { FrontEnd::Linear },
            // Tuning and stretch choose among the oscillators; they do not change them.
            timbre: parameters.timbre().map(|timbre| Timbre { tuning_hz: 1.0, stretch: 0.0, ..timbre }),
        }
    }

    pub fn settings(self, rate_hz: u32) -> SpectrumSettings {
        let Self { bands, decay, side_gain, front_end, .. } = self;
        SpectrumSettings { bands, decay, side_gain, front_end, ..SpectrumSettings::new(rate_hz) }
    }
}

/// The settings of an analyzer of sound at `rate_hz`.
pub(super) fn spectrum_settings(rate_hz: u32, parameters: &Parameters) -> SpectrumSettings {
    Tuning::of(parameters).settings(rate_hz)
}
