//! Changes that hold throughout, whatever the dances that come after them say.

use chladni_music::{Action, Settings};

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
