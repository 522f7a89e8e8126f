//! The instrument as in Chladni's experiment.

use crate::{Action, Form, Parameter, Switch};

/// Actions that set an instrument up for sand: it lies on the shape, which moves along its normals, as a plate
/// does, so little that the sand is what is seen; the coarser harmonics sound, whose figures have lines that can
/// be told apart; and nothing turns on the beat.
pub const SAND_MODE: [Action; 6] = [
    Action::Switch { switch: Switch::Sand, on: true },
    Action::SetForm { form: Form::Modal },
    Action::Set { parameter: Parameter::Gain, value: 0.12 },
    Action::SetHarmonics { harmonics: 64 },
    Action::Switch { switch: Switch::BeatTurns, on: false },
    Action::Switch { switch: Switch::BeatLights, on: false },
];
