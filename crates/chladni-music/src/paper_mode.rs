//! The instrument as the music paper describes it.

use crate::{Action, Form, Parameter, Switch};

/// Actions that set an instrument to the paper's choices where ours differ: filtered coordinates, linear bins
/// of the Fourier transform, the side signal ten times as loud (section 5c), and normals half way to those of
/// the rest shape (section 6b).
pub const PAPER_MODE: [Action; 6] = [
    Action::SetForm { form: Form::Filter },
    Action::Switch { switch: Switch::LogBands, on: false },
    Action::Switch { switch: Switch::Resonate, on: false },
    Action::Set { parameter: Parameter::Decay, value: 0.5 },
    Action::Set { parameter: Parameter::SideGain, value: 10.0 },
    Action::Set { parameter: Parameter::NormalBlending, value: 1.0 },
];
