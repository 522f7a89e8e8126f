//! All knobs and switches of the instrument, with names and ranges. Sliders, MIDI controllers and OSC
//! messages turn them.

use serde::{Deserialize, Serialize};

use crate::{MusicError, Timbre};

/// A number that a knob sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Parameter {
    /// w: the share of the spectrum that remains after 50 ms.
    Decay,
    /// The factor by which the side signal is multiplied.
    SideGain,
    /// #ω, the number of bands; rounded.
    Bands,
    /// Overall strength of the movement.
    Gain,
    /// Share of the bounding box by which a full-scale band moves the shape at gain 1.
    Calibration,
    /// Largest displacement of a vertex, as a share of the bounding box.
    Limit,
    /// φ_d, the gain of all detail above K.
    Detail,
    /// 0: exact normals; 1: halfway to the rest normals, the paper's "normal enhancement".
    NormalBlending,
    /// How many beats a change on stage takes.
    TransitionBeats,
    /// The number of beats between two favorites when the beat steps through them; rounded.
    BeatsPerStep,
    /// How far the beat turns the model, in radians.
    TurnRad,
    /// How far the beat moves the lights, in radians.
    LightSwingRad,
    /// How much brighter the lights become on the beat.
    LightPulse,
    /// μ of all dances while [`Switch::OwnMu`] is off.
    StereoMu,
    /// ζ of the resonators: the larger, the sooner they come to rest.
    Damping,
    /// The frequency of the slowest harmonic, in Hz.
    TuningHz,
    /// How much faster finer harmonics ring: frequencies are proportional to √λ to this power.
    Stretch,
    /// How strongly a rise of the sound strikes a harmonic.
    Strike,
    /// How far a steady sound displaces a harmonic.
    Hold,
    /// The number of grains of sand on the shape; rounded.
    Grains,
    /// Radius of a grain, as a share of the bounding box's diagonal.
    GrainSize,
}

impl Parameter {
    /// All parameters.
    pub const ALL: [Self; 21] = [
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
        Self::StereoMu,
        Self::Damping,
        Self::TuningHz,
        Self::Stretch,
        Self::Strike,
        Self::Hold,
        Self::Grains,
        Self::GrainSize,
    ];

    /// The parameters that change how one dance looks, on any stage.
    pub(crate) const OF_A_DANCE: [Self; 14] = [
        Self::Decay,
        Self::SideGain,
        Self::Bands,
        Self::Gain,
        Self::Calibration,
        Self::Limit,
        Self::Detail,
        Self::NormalBlending,
        Self::StereoMu,
        Self::Damping,
        Self::TuningHz,
        Self::Stretch,
        Self::Strike,
        Self::Hold,
    ];

    /// The name in show files, MIDI maps and OSC addresses.
    pub fn name(self) -> &'static str {
        self.row().0
    }

    /// In a sentence, for tooltips and for the page of controls.
    pub fn about(self) -> &'static str {
        match self {
            Self::Decay => "How long a sound lingers in the shape",
            Self::SideGain => "How much the difference of left and right counts",
            Self::Bands => "Number of sound bands",
            Self::Gain => "How strongly everything moves; 1 is calibrated to the shape",
            Self::Calibration => "How far a full-scale sound moves the shape at gain 1",
            Self::Limit => "The share of the shape's size that no part is to exceed",
            Self::Detail => "Gain of everything finer than the last harmonic",
            Self::NormalBlending => "0 is exact light, 1 the paper's softer look",
            Self::TransitionBeats => "Beats that a change on stage takes",
            Self::BeatsPerStep => "Beats between two dances that follow each other on stage",
            Self::TurnRad => "How far the beat turns the shape",
            Self::LightSwingRad => "How far the beat moves the lights",
            Self::LightPulse => "How much brighter the beat is",
            Self::StereoMu => "How much middle and sides mix, while no dance has a µ of its own",
            Self::Damping => "How soon the resonators come to rest; from 1 on they swing no more",
            Self::TuningHz => "How often a second the broadest movement swings",
            Self::Stretch => "How much faster finer movements are",
            Self::Strike => "How hard a sound that begins strikes",
            Self::Hold => "How far a sound that lasts holds the shape",
            Self::Grains => "How many grains lie on the shape that is on stage",
            Self::GrainSize => "Radius of a grain, as a share of the shape's size",
        }
    }

    /// The lowest and the highest value.
    pub fn range(self) -> (f32, f32) {
        (self.row().1, self.row().2)
    }

    /// The default value.
    pub fn initial(self) -> f32 {
        self.row().3
    }

    /// Checks that `value` lies in the range.
    pub(crate) fn check(self, value: f32) -> Result<(), MusicError> {
        let (low, high) = self.range();
        if (low..=high).contains(&value) {
            return Ok(());
        }
        let range = format!("[{low}, {high}]");
        Err(MusicError::OutOfRange { name: self.name(), value: value.into(), range })
    }

    /// The value at a share of the range in [0, 1]: in even steps, or in even factors if the range spans
    /// more than three powers of ten.
    pub fn at_share(self, share: f32) -> f32 {
        let (low, high) = self.range();
        let share = share.clamp(0.0, 1.0);
        let even_factors = low > 0.0 && high / low > 1000.0;
        let value = if even_factors { low * (high / low).powf(share) } else { low + share * (high - low) };
        value.clamp(low, high)
    }

    /// The share at which [`at_share`](Self::at_share) gives `value`.
    pub fn share(self, value: f32) -> f32 {
        let (low, high) = self.range();
        let even_factors = low > 0.0 && high / low > 1000.0;
        let share =
            if even_factors { (value / low).ln() / (high / low).ln() } else { (value - low) / (high - low) };
        share.clamp(0.0, 1.0)
    }

    fn row(self) -> (&'static str, f32, f32, f32) {
        match self {
            Self::Decay => ("decay", 0.0, 0.99, 0.2),
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
            Self::StereoMu => ("stereo-mu", 0.0, 1.0, 0.0),
            Self::Damping => ("damping", 0.01, 2.0, Timbre::NAMED[0].1.damping),
            Self::TuningHz => ("tuning-hz", 0.2, 6.0, Timbre::NAMED[0].1.tuning_hz),
            Self::Stretch => ("stretch", 0.0, 1.5, Timbre::NAMED[0].1.stretch),
            Self::Strike => ("strike", 0.0, 4.0, Timbre::NAMED[0].1.strike),
            Self::Hold => ("hold", 0.0, 1.0, Timbre::NAMED[0].1.hold),
            Self::Grains => ("grains", 100.0, 100_000.0, 20_000.0),
            Self::GrainSize => ("grain-size", 0.0005, 0.01, 0.0016),
        }
    }
}

/// Something that is on or off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Switch {
    /// The beat turns the model.
    BeatTurns,
    /// The beat moves the lights.
    BeatLights,
    /// The beat steps to the next dance on stage.
    BeatSteps,
    /// Left and right are swapped.
    FlipSides,
    /// At most three flashes a second (on unless switched off).
    FlashLimit,
    /// They are counted in any field of view of 10°, too.
    FlashFields,
    /// Sound bands have equal steps of pitch instead of frequency.
    LogBands,
    /// Each dance has its own μ; otherwise all have [`Parameter::StereoMu`].
    OwnMu,
    /// Harmonics ring as damped oscillators that the sound strikes; otherwise they follow its level.
    Resonate,
    /// Breeding shows children that look different from each other and similar to those chosen so far;
    /// otherwise the paper's breeding shows all of its children.
    Suggest,
    /// Sand lies on the shape that is on stage.
    Sand,
    /// The camera chooses its own shots on stage.
    Camera,
}

impl Switch {
    /// All switches.
    pub const ALL: [Self; 12] = [
        Self::BeatTurns,
        Self::BeatLights,
        Self::BeatSteps,
        Self::FlipSides,
        Self::FlashLimit,
        Self::FlashFields,
        Self::LogBands,
        Self::OwnMu,
        Self::Resonate,
        Self::Suggest,
        Self::Sand,
        Self::Camera,
    ];

    /// The switches that change how one dance looks, on any stage.
    pub(crate) const OF_A_DANCE: [Self; 4] = [Self::FlipSides, Self::LogBands, Self::OwnMu, Self::Resonate];

    /// The name in show files and OSC addresses.
    pub fn name(self) -> &'static str {
        match self {
            Self::BeatTurns => "beat-turns",
            Self::BeatLights => "beat-lights",
            Self::BeatSteps => "beat-steps",
            Self::FlipSides => "flip-sides",
            Self::FlashLimit => "flash-limit",
            Self::FlashFields => "flash-fields",
            Self::LogBands => "log-bands",
            Self::OwnMu => "own-mu",
            Self::Resonate => "resonate",
            Self::Suggest => "suggest",
            Self::Sand => "sand",
            Self::Camera => "camera",
        }
    }

    /// In a sentence, for tooltips and for the page of controls.
    pub fn about(self) -> &'static str {
        match self {
            Self::BeatTurns => "The beat turns the shape",
            Self::BeatLights => "The beat moves the lights",
            Self::BeatSteps => {
                "On stage the beat steps to the next favorite, or to the next dance of the gallery"
            }
            Self::FlipSides => "Left and right are exchanged",
            Self::FlashLimit => "At most three flashes a second, for people with photosensitive epilepsy",
            Self::FlashFields => {
                "Limit flashes in a quarter of any third of the picture, too, for people who sit close. Bodies that \
                 swing fast over a dark ground are darkened by it"
            }
            Self::LogBands => "Equal steps of pitch rather than of frequency",
            Self::OwnMu => "Each dance has a µ of its own; else all have the one among the knobs",
            Self::Resonate => "Sound strikes the shape; else the shape follows its level",
            Self::Suggest => {
                "Of two hundred children show those that differ most and are most like what you chose so far; else \
                 whatever the paper's breeding gives"
            }
            Self::Sand => {
                "Sand lies on the shape that is on stage and gathers where it does not move; form Modal and little \
                 gain are best"
            }
            Self::Camera => "On stage the camera chooses its shots, bar by bar",
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
            assert!(!p.about().is_empty(), "{}", p.name());
        }
        for (i, s) in Switch::ALL.into_iter().enumerate() {
            assert_eq!(s as usize, i);
            assert!(!s.about().is_empty(), "{}", s.name());
        }
        assert!((Parameter::Bands.at_share(0.5) - 90.5).abs() < 0.1);
        assert_eq!(Parameter::TurnRad.at_share(0.5), 1.6);
        for (p, share) in Parameter::ALL.into_iter().flat_map(|p| [0.0, 0.3, 1.0].map(|share| (p, share))) {
            assert!((p.share(p.at_share(share)) - share).abs() < 1e-4, "{}", p.name());
        }
    }
}
