//! The instrument as in Chladni's experiment.

use crate::{Action, Class, Form, Mapping, Parameter, Parameters, Switch};

/// Actions that set an instrument up for sand: sand lies on the shape, which moves along its normals, as a plate
/// does, but so little that only the sand seems to move; and nothing turns on the beat.
pub const SAND_MODE: [Action; 5] = [
    Action::Switch { switch: Switch::Sand, on: true },
    Action::SetForm { form: Form::Modal },
    Action::Set { parameter: Parameter::Gain, value: 0.06 },
    Action::Switch { switch: Switch::BeatTurns, on: false },
    Action::Switch { switch: Switch::BeatLights, on: false },
];

/// Actions that undo [`SAND_MODE`]: they return knobs and switches to where they stood `before`.
pub fn without_sand(before: &Parameters) -> Vec<Action> {
    let back = SAND_MODE.into_iter().map(|action| match action {
        Action::SetForm { .. } => Action::SetForm { form: before.form },
        Action::Set { parameter, .. } => Action::Set { parameter, value: before.get(parameter) },
        Action::Switch { switch, .. } => Action::Switch { switch, on: before.is_on(switch) },
        other => other,
    });
    back.collect()
}

/// [`SAND_MODE`], and a dance on stage in which a higher tone draws a finer figure, for a shape whose harmonics
/// have these eigenvalues, ascending, and classes. It takes the place of the gallery's first item.
pub fn experiment(eigenvalues: &[f64], classes: &[Class], bands: usize) -> Vec<Action> {
    let mapping = Mapping::figures(eigenvalues, classes, bands);
    let dance = [Action::Load { item: 0, name: "figures".into(), mapping }, Action::Perform { item: 0 }];
    SAND_MODE.into_iter().chain(dance).collect()
}
