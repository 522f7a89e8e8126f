//! How a dance begins, and the actions that follow.

use chladni_music::{
    Action, BreedingError, Dancer, Form, GALLERY_SIZES, GalleryShape, Instrument, LoggedAction, Mapping,
    Moment, MusicError, PAPER_MODE, Parameter, Parameters, Preset, SAND_MODE, Show, SideSource, Switch,
    experiment,
};

use crate::work::held::{holds_form, leave_out};
use crate::work::knobs::{ignored_by, needed_by};
use crate::work::{Error, Warning};

/// A show that is repeated, or else a preset, a gallery or one dance of it.
#[derive(Clone, Debug, Default)]
pub struct Beginning {
    /// The show to repeat; the next three are then ignored.
    pub show: Option<Box<Show>>,
    /// The dance that is on stage; where the beat steps, others of a gallery follow.
    pub preset: Option<Preset>,
    /// Seed of all that is random. Without preset and gallery a dance is bred from its gallery, and without a
    /// seed, too, the direct mapping is on stage.
    pub seed: Option<u64>,
    /// All of a gallery of this many items is shown.
    pub gallery: Option<usize>,
    /// Whether sand lies on the shape; if no show, preset, seed or gallery says what dances, the figures of
    /// Chladni's experiment do. `None` means: only on a flat sheet for which neither a show nor a preset says
    /// how it moves, since other forms show little there. What sand needs holds throughout a show.
    pub sand: Option<bool>,
    /// Whether the looks that came on stage in a show are left out, and the film's own is used throughout.
    pub keeps_look: bool,
    /// Done before anything else; whatever would change the same in a show, or in the autopilot's dances, is left out.
    pub changes: Vec<Action>,
}

impl Beginning {
    /// Checks, before any work, that there can be such a gallery.
    pub(super) fn check(&self) -> Result<(), Error> {
        match self.gallery.filter(|size| !GALLERY_SIZES.contains(size)) {
            Some(size) => Err(MusicError::from(BreedingError::GallerySize(size)).into()),
            None => Ok(()),
        }
    }

    /// Whether all of a gallery is shown.
    pub(super) fn is_gallery(&self) -> bool {
        self.gallery.is_some() && self.preset.is_none() && self.show.is_none()
    }

    /// The instrument on `dancer`, which may be a flat sheet, and what will be done to it.
    pub(super) fn begin(
        self,
        dancer: &Dancer,
        on_sheet: bool,
    ) -> Result<(Instrument, Vec<LoggedAction>), Error> {
        let bands = Parameter::Bands.initial() as usize;
        let shape = GalleryShape { eigenvalues: dancer.eigenvalues.clone(), bands };
        let is_chosen =
            self.show.is_some() || self.preset.is_some() || self.seed.is_some() || self.gallery.is_some();
        let sand = self.sand.unwrap_or(on_sheet && self.show.is_none() && self.preset.is_none());
        let draws_figures = sand && !is_chosen;
        let (mut instrument, script) = match self.show {
            Some(mut show) => {
                if self.keeps_look {
                    show.actions.retain(|line| !matches!(line.action, Action::SetLook { .. }));
                }
                let held = SAND_MODE.iter().filter(|_| sand).chain(&self.changes);
                held.for_each(|change| hold(change, &mut show.actions));
                (show.begin(shape)?, show.actions)
            }
            None => {
                let mut instrument =
                    Instrument::new(self.seed.unwrap_or(1), self.gallery.unwrap_or(6), shape)?;
                // Figures that came after another dance would fade in.
                if !draws_figures {
                    let dance = put_on_stage(dancer, bands, self.preset, self.seed, self.gallery);
                    apply(&mut instrument, dance)?;
                }
                (instrument, Vec::new())
            }
        };
        if sand {
            let dance = if draws_figures {
                experiment(&dancer.eigenvalues, &dancer.classes, bands)
            } else {
                SAND_MODE.to_vec()
            };
            apply(&mut instrument, dance)?;
        }
        apply(&mut instrument, self.changes)?;
        Ok((instrument, script))
    }
}

/// Warnings of the knobs that changes turn in vain, which are `held` throughout: those that the form ignores, and those
/// whose switch stands the other way; none where the `script`, or the autopilot if it `pilots`, may choose another form or
/// turn the switch. `begun` is where all stand in the beginning. `voices` may listen to the side in any form.
pub(super) fn in_vain(
    held: &[Action],
    begun: &Parameters,
    script: &[LoggedAction],
    pilots: bool,
    voices: bool,
) -> Vec<Warning> {
    // Paper mode turns knobs that another form, asked for beside it, may ignore.
    let asked = held.strip_prefix(&PAPER_MODE).unwrap_or(held);
    let chooses_form = |line: &LoggedAction| match &line.action {
        Action::SetForm { .. } => true,
        Action::Take { preset, .. } => preset.settings.form.is_some(),
        _ => false,
    };
    let keeps_form = (!pilots || holds_form(held)) && !script.iter().any(chooses_form);
    let stays = |switch: Switch| {
        let turns = |line: &LoggedAction| match &line.action {
            Action::Switch { switch: turned, .. } => *turned == switch,
            Action::Take { preset, .. } => preset.settings.switches.contains_key(&switch),
            _ => false,
        };
        let holds =
            |change: &Action| matches!(change, Action::Switch { switch: kept, .. } if *kept == switch);
        held.iter().any(holds) || !(pilots || script.iter().any(turns))
    };
    let is_turned = |knob: &Parameter| {
        asked.iter().any(|change| matches!(change, Action::Set { parameter, .. } if parameter == knob))
    };
    let by_switch = |knob: Parameter| {
        let (switch, on) = needed_by(knob)?;
        let is_idle = begun.is_on(switch) != on && stays(switch);
        is_idle
            .then(|| format!("Without effect while {} is {}.", switch.name(), if on { "off" } else { "on" }))
    };
    let by_form = |knob: Parameter| ignored_by(begun.form, knob, voices).filter(|_| keeps_form);
    let ignored = |knob: Parameter| {
        let why = by_form(knob).map(str::to_owned).or_else(|| by_switch(knob))?;
        Some(Warning::of(knob.name(), why))
    };
    Parameter::ALL.into_iter().filter(is_turned).filter_map(ignored).collect()
}

/// A warning of the modal form, where changes ask for it, on a shape in which it does not part left and right.
pub(super) fn swings_alike(held: &[Action], sides: SideSource) -> Option<Warning> {
    let form = held.iter().rev().find_map(|change| match change {
        Action::SetForm { form } => Some(*form),
        _ => None,
    });
    let is_alike = form == Some(Form::Modal) && sides == SideSource::Coordinate;
    is_alike.then(|| {
        let why = "Left and right move the same places: as the shape stands, its harmonics do not part them. \
                   Half-mask does.";
        Warning::of("modal", why)
    })
}

/// Leaves out of a script all that changes what `change` sets, so that it holds throughout.
fn hold(change: &Action, script: &mut Vec<LoggedAction>) {
    script.retain(|line| match (change, &line.action) {
        (Action::SetForm { .. }, Action::SetForm { .. })
        | (Action::SetChoir { .. }, Action::SetChoir { .. })
        | (Action::SetHarmonics { .. }, Action::SetHarmonics { .. }) => false,
        (Action::Set { parameter: held, .. }, Action::Set { parameter, .. }) => held != parameter,
        (Action::Switch { switch: held, .. }, Action::Switch { switch, .. }) => held != switch,
        _ => true,
    });
    for line in script {
        if let Action::Take { preset, .. } = &mut line.action {
            leave_out(change, &mut preset.settings);
        }
    }
}

/// Actions that put the one dance on stage; none where a gallery is shown.
fn put_on_stage(
    dancer: &Dancer,
    bands: usize,
    preset: Option<Preset>,
    seed: Option<u64>,
    gallery: Option<usize>,
) -> Vec<Action> {
    let perform = Action::PerformGallery { first: 0 };
    match (preset, gallery, seed) {
        (Some(preset), ..) => vec![Action::Take { item: 0, preset: Box::new(preset) }, perform],
        (None, Some(_), _) => Vec::new(),
        (None, None, Some(_)) => {
            let choose = |item| Action::Choose { item, on: true };
            (0..6).map(choose).chain([Action::Breed, perform]).collect()
        }
        (None, None, None) => {
            let mapping = Mapping::direct(&dancer.eigenvalues, bands);
            vec![Action::Load { item: 0, name: "direct".into(), mapping }, perform]
        }
    }
}

fn apply(instrument: &mut Instrument, actions: Vec<Action>) -> Result<(), Error> {
    for action in actions {
        instrument.apply(Moment::default(), action)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use chladni_harmonics::{BasisSettings, Body};
    use chladni_mesh::{Orientation, samples};
    use chladni_music::Symmetry;
    use chladni_task::Task;

    use super::*;

    fn plate() -> Dancer {
        let mesh = samples::sample("plate").unwrap();
        let body = Body::build(&mesh, &BasisSettings::new(24), &Task::new()).unwrap();
        let symmetry = Symmetry::of(&body, &Task::new()).unwrap();
        let body = symmetry.rotated(&body);
        Dancer::new(&body, &symmetry.classes, &Orientation::Y_UP).unwrap()
    }

    #[test]
    fn knobs_that_the_form_ignores_are_warned_of_unless_another_form_may_come() {
        let dancer = plate();
        let mu = Action::Set { parameter: Parameter::StereoMu, value: 1.0 };
        let one_for_all = Action::Switch { switch: Switch::OwnMu, on: false };
        let side = Action::Set { parameter: Parameter::SideGain, value: 3.0 };
        let detail = Action::Set { parameter: Parameter::Detail, value: 5.0 };
        let [filter, modal] = [Form::Filter, Form::Modal].map(|form| Action::SetForm { form });
        let warned = |changes: &[&Action], script: &[LoggedAction], voices: bool| {
            let changes: Vec<Action> = changes.iter().copied().cloned().collect();
            let beginning = Beginning { changes: changes.clone(), ..Beginning::default() };
            let (instrument, _) = beginning.begin(&dancer, false).unwrap();
            let warnings = in_vain(&changes, instrument.parameters(), script, false, voices);
            warnings.iter().map(ToString::to_string).collect::<Vec<_>>()
        };
        let said = warned(&[&mu, &mu], &[], false);
        assert!(said.len() == 1 && said[0].contains("Without effect in halves"), "{said:?}");
        assert_eq!(warned(&[&mu, &side, &detail], &[], false).len(), 2);
        assert_eq!(warned(&[&mu, &side], &[], true).len(), 1);
        assert_eq!(warned(&[&filter, &one_for_all, &mu, &side, &detail], &[], false).len(), 0);
        assert_eq!(warned(&[&modal, &one_for_all, &mu, &side, &detail], &[], false).len(), 1);
        let later = LoggedAction { moment: Moment::default(), action: modal };
        assert_eq!(warned(&[&one_for_all, &mu], &[later], false).len(), 0);
    }

    #[test]
    fn the_modal_form_is_warned_of_where_left_and_right_look_alike() {
        let [modal, halves] = [Form::Modal, Form::HalfMask].map(|form| Action::SetForm { form });
        let warns = |held: &[&Action], sides| {
            let held: Vec<Action> = held.iter().copied().cloned().collect();
            swings_alike(&held, sides).is_some()
        };
        assert!(warns(&[&halves, &modal], SideSource::Coordinate));
        assert!(!warns(&[&modal, &halves], SideSource::Coordinate));
        assert!(!warns(&[], SideSource::Coordinate));
        assert!(!warns(&[&modal], SideSource::Harmonic(1)));
    }

    #[test]
    fn knobs_whose_switch_is_off_are_warned_of_unless_it_may_be_turned() {
        let dancer = plate();
        let set = |parameter: Parameter| Action::Set { parameter, value: parameter.initial() };
        let [damping, grains] = [Parameter::Damping, Parameter::Grains].map(set);
        let turn = |switch, on| Action::Switch { switch, on };
        let warned = |changes: &[Action], later: Option<Action>, pilots: bool| {
            let changes = changes.to_vec();
            let beginning = Beginning { changes: changes.clone(), ..Beginning::default() };
            let (instrument, _) = beginning.begin(&dancer, false).unwrap();
            let script = later.map(|action| LoggedAction { moment: Moment::default(), action });
            let warnings = in_vain(&changes, instrument.parameters(), script.as_slice(), pilots, false);
            warnings.iter().map(ToString::to_string).collect::<Vec<_>>()
        };
        let dry = [turn(Switch::Resonate, false), damping.clone()];
        let said = warned(&dry, None, false);
        assert!(said.len() == 1 && said[0].contains("Without effect while resonate is off"), "{said:?}");
        // Such a change holds in the dances of the autopilot, too.
        assert_eq!(warned(&dry, None, true).len(), 1);
        assert!(warned(&[damping], None, false).is_empty());
        let pulse = set(Parameter::LightPulse);
        let said = warned(&[turn(Switch::BeatLights, false), pulse.clone()], None, false);
        assert!(said.len() == 1 && said[0].contains("Without effect while beat-lights is off"), "{said:?}");
        assert!(warned(&[pulse], None, false).is_empty());
        let grains = [grains];
        assert_eq!(warned(&grains, None, false).len(), 1);
        assert!(warned(&grains, Some(turn(Switch::Sand, true)), false).is_empty());
        assert!(warned(&grains, None, true).is_empty());
    }

    #[test]
    fn figures_of_sand_are_alone_on_stage_from_the_first_moment_on() {
        let dancer = plate();
        let on_stage = |beginning: Beginning| {
            let (instrument, _) = beginning.begin(&dancer, true).unwrap();
            let scene = instrument.scene(0.0).unwrap();
            assert_eq!(scene.from, scene.to);
            instrument.item(scene.to).unwrap().name.clone()
        };
        assert_eq!(on_stage(Beginning::default()), "figures");
        assert_eq!(on_stage(Beginning { sand: Some(false), ..Beginning::default() }), "direct");
        assert_ne!(on_stage(Beginning { seed: Some(3), ..Beginning::default() }), "figures");
    }
}
