//! Changes that hold throughout, whatever the dances that come after them say.

use chladni_music::{Action, Settings};

/// Whether one of the changes that are `held` says the form.
pub fn holds_form(held: &[Action]) -> bool {
    held.iter().any(|change| matches!(change, Action::SetForm { .. }))
}

/// Leaves out of settings what `change` sets.
pub fn leave_out(change: &Action, settings: &mut Settings) {
    match change {
        Action::SetForm { .. } => settings.form = None,
        Action::SetChoir { .. } => settings.choir = None,
        Action::SetHarmonics { .. } => settings.harmonics = None,
        Action::Set { parameter, .. } => settings.knobs.retain(|knob, _| knob != parameter),
        Action::Switch { switch, .. } => settings.switches.retain(|known, _| known != switch),
        _ => {}
    }
}
