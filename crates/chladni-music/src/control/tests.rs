use super::*;
use crate::{Action, Parameter, Switch};
use proptest::prelude::*;

fn knob(number: u8, value: u8) -> Touch {
    Touch::from_midi("desk", &[0xb2, number, value]).unwrap()
}

fn binding(control: Control, target: Target) -> Binding {
    Binding { device: String::new(), control, target, number: None, relative: false }
}

/// Handles a touch when only the positions of knobs are known.
fn touch(bindings: &mut Bindings, touch: &Touch, parameters: &Parameters) -> Option<Cue> {
    bindings.touch(touch, parameters, &|target, number| target.standing(number, parameters))
}

#[test]
fn midi_messages_are_read() {
    let touch = |bytes: &[u8]| Touch::from_midi("", bytes).map(|t| (t.control, t.value));
    let note = Control::Note { channel: 9, number: 36 };
    assert_eq!(touch(&[0xb2, 7, 127]), Some((Control::Controller { channel: 2, number: 7 }, 1.0)));
    assert_eq!(touch(&[0x99, 36, 0]), Some((note.clone(), 0.0)));
    assert_eq!(touch(&[0x89, 36, 64]), Some((note, 0.0)));
    assert_eq!(touch(&[0xe0, 127, 127]), Some((Control::PitchBend { channel: 0 }, 1.0)));
    for nothing in [&[][..], &[0xb0], &[0xb0, 7], &[0xb0, 200, 3], &[0xf8, 0, 0], &[0xc0, 1, 0]] {
        assert_eq!(touch(nothing), None, "{nothing:?}");
    }
}

#[test]
fn a_knob_is_learned_turned_and_forgotten() {
    let (mut bindings, mut parameters) = (Bindings::default(), Parameters::default());
    assert_eq!(touch(&mut bindings, &knob(7, 64), &parameters), None);
    bindings.learn(Some((Target::Parameter(Parameter::Limit), None)));
    let set = |value| Some(Cue::Do(Action::Set { parameter: Parameter::Limit, value }));
    assert_eq!(touch(&mut bindings, &knob(7, 127), &parameters), set(1.0));
    parameters.set(Parameter::Limit, 1.0).unwrap();
    assert_eq!(bindings.learning(), None);
    assert_eq!(touch(&mut bindings, &knob(7, 0), &parameters), set(0.01));
    assert_eq!(touch(&mut bindings, &knob(8, 127), &parameters), None);
    let text = bindings.to_text().unwrap();
    let mut read = Bindings::default();
    assert_eq!(read.import(&text).unwrap(), 1);
    assert_eq!(read.list(), bindings.list());
    assert_eq!(read.list()[0].device, "desk");
    assert!(read.import("format_version = 4\nbinding = 7").is_err());
    bindings.forget(0);
    bindings.forget(0);
    assert_eq!(touch(&mut bindings, &knob(7, 127), &parameters), None);
}

#[test]
fn bindings_of_earlier_builds_are_read_and_those_of_newer_ones_named() {
    let text = |target: &str| {
        let control = "control = { kind = \"note\", channel = 0, number = 1 }";
        format!("format_version = 4\n[[binding]]\n{control}\ntarget = \"{target}\"\n")
    };
    for (name, target) in [
        ("favourite", Target::Favorite),
        ("next-favourite", Target::NextFavorite),
        ("previous-favourite", Target::PreviousFavorite),
    ] {
        let mut bindings = Bindings::default();
        assert_eq!(bindings.import(&text(name)).unwrap(), 1);
        assert_eq!(bindings.list()[0].target, target);
    }
    let refused = Bindings::default().import(&text("strobe")).unwrap_err().to_string();
    assert!(refused.ends_with("unknown variant `strobe`; a newer Chladni may have written it"), "{refused}");
}

#[test]
fn a_knob_takes_over_where_it_passes_its_target() {
    let target = Target::Parameter(Parameter::StereoMu);
    let mut bindings = Bindings::new(vec![binding(knob(1, 0).control, target)]);
    let mut parameters = Parameters::default();
    parameters.set(Parameter::StereoMu, 0.5).unwrap();
    let turn = |bindings: &mut Bindings, parameters: &mut Parameters, value: u8| {
        let cue = touch(bindings, &knob(1, value), parameters);
        if let Some(Cue::Do(Action::Set { parameter, value })) = cue {
            parameters.set(parameter, value).unwrap();
            return true;
        }
        false
    };
    let turned = [10, 30, 50, 70, 90, 20].map(|value| turn(&mut bindings, &mut parameters, value));
    assert_eq!(turned, [false, false, false, true, true, true]);
    // Something else turns the parameter: the knob must pass its position again to take over.
    parameters.set(Parameter::StereoMu, 0.9).unwrap();
    let turned = [25, 60, 113, 100].map(|value| turn(&mut bindings, &mut parameters, value));
    assert_eq!(turned, [false, false, true, true]);
}

#[test]
fn a_motor_fader_that_feels_the_hand_is_learned_and_not_its_touch_sensor() {
    let parameters = Parameters::default();
    let sensor = |value| Touch::from_midi("desk", &[0x90, 104, value]).unwrap();
    let fader = Touch::from_midi("desk", &[0xe0, 0, 64]).unwrap();
    let mut bindings = Bindings::default();
    let mut learn = |touches: &[&Touch]| {
        bindings.learn(Some((Target::Volume, None)));
        let cues: Vec<_> = touches.iter().map(|moved| touch(&mut bindings, moved, &parameters)).collect();
        let bound: Vec<Control> = bindings.list().iter().map(|binding| binding.control.clone()).collect();
        assert_eq!(bindings.learning(), None);
        bindings.forget(0);
        (cues, bound)
    };
    let level = |touch: &Touch| Some(Cue::Ask(Target::Volume, Which::Level(touch.value)));
    let (held, released) = (sensor(127), sensor(0));
    let other = Touch { device: "other".into(), ..fader.clone() };
    let expected = (vec![None, None, level(&fader), None], vec![fader.control.clone()]);
    assert_eq!(learn(&[&held, &other, &fader, &released]), expected);
    // A pad that is struck was meant.
    let (cues, bound) = learn(&[&held, &released, &fader, &held]);
    assert_eq!((cues, bound), (vec![None, None, None, level(&held)], vec![held.control.clone()]));
    // One that is forgotten while it is held is not bound again.
    bindings.learn(Some((Target::Volume, None)));
    assert_eq!(touch(&mut bindings, &held, &parameters), None);
    bindings.forget(0);
    assert_eq!(touch(&mut bindings, &fader, &parameters), None);
    assert!(bindings.list().is_empty());
}

#[test]
fn a_pad_that_stays_on_takes_no_bound_knob_from_its_target() {
    let parameters = Parameters::default();
    let pad = Touch::from_midi("desk", &[0x90, 36, 127]).unwrap();
    let target = Target::Parameter(Parameter::StereoMu);
    let mut bindings = Bindings::new(vec![binding(knob(1, 0).control, target)]);
    bindings.learn(Some((Target::Volume, None)));
    assert_eq!(touch(&mut bindings, &pad, &parameters), None);
    let learned = bindings.list().to_vec();
    assert_eq!(learned.len(), 2);
    touch(&mut bindings, &knob(1, 64), &parameters);
    assert_eq!(bindings.list(), learned);
    // Its release may be lost while nobody listens.
    bindings.forget_hands();
    assert_eq!(touch(&mut bindings, &knob(2, 64), &parameters), None);
    assert_eq!(bindings.list(), learned);
}

#[test]
fn an_endless_knob_stays_endless_where_it_is_learned_for_another_level() {
    let target = Target::Parameter(Parameter::StereoMu);
    let mut bindings = Bindings::new(vec![binding(knob(1, 0).control, target)]);
    bindings.set_relative(0, true);
    let mut parameters = Parameters::default();
    parameters.set(Parameter::Limit, 1.0).unwrap();
    bindings.learn(Some((Target::Parameter(Parameter::Limit), None)));
    let cue = touch(&mut bindings, &knob(1, 127), &parameters);
    let Some(Cue::Do(Action::Set { parameter: Parameter::Limit, value })) = cue else { panic!("{cue:?}") };
    assert!(value < 1.0 && value > 0.9, "{value}");
    assert!(bindings.list()[0].relative);
    // What else it is learned for takes no steps.
    bindings.learn(Some((Target::Go, None)));
    touch(&mut bindings, &knob(1, 127), &parameters);
    assert!(!bindings.list()[0].relative);
}

#[test]
fn the_ring_of_an_endless_knob_follows_its_own_turns() {
    let target = Target::Parameter(Parameter::StereoMu);
    let device = Binding { device: "desk".into(), ..binding(knob(1, 0).control, target) };
    let mut bindings = Bindings::new(vec![device]);
    bindings.set_relative(0, true);
    let mut parameters = Parameters::default();
    parameters.set(Parameter::StereoMu, 0.0).unwrap();
    let sent = |bindings: &mut Bindings, parameters: &Parameters| {
        bindings.feedback(&|target, number| target.standing(number, parameters), &|_| true)
    };
    let desk = |value| vec![("desk".to_owned(), [0xb2, 1, value])];
    assert_eq!(sent(&mut bindings, &parameters), desk(0));
    let cue = touch(&mut bindings, &knob(1, 3), &parameters);
    // The frame in which it turns: its target follows after this.
    assert!(sent(&mut bindings, &parameters).is_empty());
    let Some(Cue::Do(Action::Set { parameter, value })) = cue else { panic!("{cue:?}") };
    parameters.set(parameter, value).unwrap();
    assert_eq!(sent(&mut bindings, &parameters), desk(3));
    assert!(sent(&mut bindings, &parameters).is_empty());
}

#[test]
fn an_endless_knob_goes_on_from_where_its_target_stands() {
    let target = Target::Parameter(Parameter::StereoMu);
    let mut bindings = Bindings::new(vec![binding(knob(1, 0).control, target)]);
    let before = bindings.to_text().unwrap();
    assert!(!before.contains("relative"), "older programs read it, too");
    bindings.set_relative(0, true);
    let mut read = Bindings::default();
    read.import(&bindings.to_text().unwrap()).unwrap();
    assert_eq!(read.list(), bindings.list());
    let mut parameters = Parameters::default();
    parameters.set(Parameter::StereoMu, 0.5).unwrap();
    let mut turn = |parameters: &Parameters, sent: u8| match touch(&mut bindings, &knob(1, sent), parameters)
    {
        Some(Cue::Do(Action::Set { parameter: Parameter::StereoMu, value })) => value,
        cue => panic!("{cue:?}"),
    };
    let is_at = |value: f32, steps: f32| (value - 0.5 - steps / 127.0).abs() < 1e-5;
    // Within one frame, too.
    assert!(is_at(turn(&parameters, 1), 1.0) && is_at(turn(&parameters, 2), 3.0));
    assert!(is_at(turn(&parameters, 127), 2.0));
    parameters.set(Parameter::StereoMu, 1.0).unwrap();
    assert_eq!(turn(&parameters, 5), 1.0);
    // Only a controller of a level can be one.
    let pad = binding(Control::Note { channel: 0, number: 1 }, target);
    let mut bindings = Bindings::new(vec![pad.clone()]);
    bindings.set_relative(0, true);
    assert_eq!(bindings.list(), [pad]);
}

#[test]
fn devices_show_where_things_stand_and_are_told_once() {
    let note = Control::Note { channel: 0, number: 40 };
    let fader = Control::PitchBend { channel: 3 };
    let of = |device: &str, control: &Control, target, number| Binding {
        device: device.into(),
        control: control.clone(),
        target,
        number,
        relative: false,
    };
    let mut bindings = Bindings::new(vec![
        of("pads", &note, Target::Switch(Switch::Sand), None),
        of("pads", &Control::Note { channel: 0, number: 41 }, Target::Form, Some(2)),
        of("desk", &fader, Target::Parameter(Parameter::StereoMu), None),
        of("", &Control::Controller { channel: 0, number: 1 }, Target::Harmonics, None),
        of("pads", &Control::Note { channel: 0, number: 42 }, Target::Blackout, None),
    ]);
    let mut parameters = Parameters::default();
    parameters.form = crate::Form::Modal;
    let sent = |bindings: &mut Bindings, parameters: &Parameters| {
        bindings.feedback(&|target, number| target.standing(number, parameters), &|_| true)
    };
    let first = sent(&mut bindings, &parameters);
    let pads = "pads".to_owned();
    let expected =
        [(pads.clone(), [0x90, 40, 0]), (pads.clone(), [0x90, 41, 127]), ("desk".into(), [0xe3, 0, 0])];
    assert_eq!(first, expected);
    assert!(sent(&mut bindings, &parameters).is_empty());
    parameters.switch(Switch::Sand, true);
    parameters.set(Parameter::StereoMu, 1.0).unwrap();
    let again = sent(&mut bindings, &parameters);
    assert_eq!(again, [(pads, [0x90, 40, 127]), ("desk".into(), [0xe3, 127, 127])]);
    // A fader that a hand moves shows the position already.
    let moved = Touch::from_midi("desk", &[0xe3, 127, 127]).unwrap();
    assert!(touch(&mut bindings, &moved, &parameters).is_some());
    let moved = Touch::from_midi("desk", &[0xe3, 0, 64]).unwrap();
    let Some(Cue::Do(Action::Set { parameter, value })) = touch(&mut bindings, &moved, &parameters) else {
        panic!("it does not turn");
    };
    parameters.set(parameter, value).unwrap();
    assert!(sent(&mut bindings, &parameters).is_empty());
    assert!(bindings.feedback(&|_, _| Some(0.0), &|_| false).is_empty());
    assert_eq!(sent(&mut bindings, &parameters).len(), 2);
}

#[test]
fn the_same_control_of_two_devices_is_two() {
    let mut bindings = Bindings::default();
    let pad = |device: &str| Touch::from_midi(device, &[0x90, 1, 100]).unwrap();
    let release = |device: &str| Touch::from_midi(device, &[0x80, 1, 0]).unwrap();
    let parameters = Parameters::default();
    for (device, number) in [("left", 1), ("right", 2)] {
        bindings.learn(Some((Target::Choose, Some(number))));
        let cue = touch(&mut bindings, &pad(device), &parameters);
        assert_eq!(cue, Some(Cue::Ask(Target::Choose, Which::Number(number))));
        touch(&mut bindings, &release(device), &parameters);
    }
    assert_eq!(bindings.list().len(), 2);
    let cue = touch(&mut bindings, &pad("left"), &parameters);
    assert_eq!(cue, Some(Cue::Ask(Target::Choose, Which::Number(1))));
    assert_eq!(touch(&mut bindings, &pad("middle"), &parameters), None);
}

#[test]
fn pads_press_once_and_switches_turn_over() {
    let control = Control::Note { channel: 0, number: 1 };
    let pad = |value| Touch { device: "any".into(), control: control.clone(), value };
    let mut bindings = Bindings::new(vec![
        binding(control.clone(), Target::Tap),
        binding(control.clone(), Target::Switch(Switch::BeatTurns)),
    ]);
    let mut parameters = Parameters::default();
    assert_eq!(bindings.list().len(), 1);
    let turn = |on| Some(Cue::Do(Action::Switch { switch: Switch::BeatTurns, on }));
    assert_eq!(touch(&mut bindings, &pad(0.1), &parameters), turn(false));
    parameters.switch(Switch::BeatTurns, false);
    assert_eq!(touch(&mut bindings, &pad(0.9), &parameters), None);
    assert_eq!(touch(&mut bindings, &pad(0.0), &parameters), None);
    assert_eq!(touch(&mut bindings, &pad(0.9), &parameters), turn(true));
    assert_eq!(touch(&mut bindings, &pad(f32::NAN), &parameters), None);
}

#[test]
fn what_turns_nothing_does_not_make_a_held_pad_press_again() {
    let pad = Touch { device: "a".into(), control: Control::Note { channel: 0, number: 7 }, value: 1.0 };
    let target = Target::Switch(Switch::BeatTurns);
    let mut bindings = Bindings::new(vec![binding(pad.control.clone(), target)]);
    let parameters = Parameters::default();
    for strange in 0..2 * MOST_BINDINGS {
        let control = Control::Osc { address: format!("/{strange}") };
        let strange = Touch { device: String::new(), control, value: 1.0 };
        assert_eq!(touch(&mut bindings, &strange, &parameters), None);
    }
    assert!(touch(&mut bindings, &pad, &parameters).is_some());
    assert_eq!(touch(&mut bindings, &pad, &parameters), None);
}

proptest! {
    #[test]
    fn any_bytes_turn_only_what_the_instrument_takes(
        messages in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..5), 0..40))
    {
        let mut parameters = Parameters::default();
        let mut bindings = Bindings::default();
        for (i, message) in messages.iter().enumerate() {
            let parameter = Parameter::ALL[i % Parameter::ALL.len()];
            bindings.learn(Some((Target::Parameter(parameter), None)));
            let Some(moved) = Touch::from_midi("", message) else { continue };
            if let Some(Cue::Do(Action::Set { parameter, value })) = touch(&mut bindings, &moved, &parameters) {
                prop_assert!(parameters.set(parameter, value).is_ok());
            }
        }
    }
}

#[test]
fn a_motor_fader_follows_its_target_back_to_where_a_hand_had_put_it() {
    let target = Target::Parameter(Parameter::StereoMu);
    let device = Binding { device: "desk".into(), ..binding(knob(1, 0).control, target) };
    let mut bindings = Bindings::new(vec![device]);
    let mut parameters = Parameters::default();
    let sent = |bindings: &mut Bindings, parameters: &mut Parameters, value: f32| {
        parameters.set(Parameter::StereoMu, value).unwrap();
        bindings.feedback(&|target, number| target.standing(number, parameters), &|_| true)
    };
    parameters.set(Parameter::StereoMu, 0.0).unwrap();
    assert!(touch(&mut bindings, &knob(1, 0), &parameters).is_some());
    assert!(touch(&mut bindings, &knob(1, 64), &parameters).is_some());
    let put = 64.0 / 127.0;
    assert!(sent(&mut bindings, &mut parameters, put).is_empty());
    assert!(sent(&mut bindings, &mut parameters, put).is_empty());
    let desk = |value| vec![("desk".to_owned(), [0xb2, 1, value])];
    assert_eq!(sent(&mut bindings, &mut parameters, 1.0), desk(127));
    assert_eq!(sent(&mut bindings, &mut parameters, put), desk(64));
    // A hand that has moved unseen takes over softly.
    bindings.forget_hands();
    assert!(touch(&mut bindings, &knob(1, 115), &parameters).is_none());
    assert!(touch(&mut bindings, &knob(1, 60), &parameters).is_some());
}

#[test]
fn a_fader_that_is_moved_fast_keeps_its_target_and_is_not_driven_against_the_hand() {
    let target = Target::Parameter(Parameter::StereoMu);
    let device = Binding { device: "desk".into(), ..binding(knob(1, 0).control, target) };
    let mut bindings = Bindings::new(vec![device]);
    let mut parameters = Parameters::default();
    parameters.set(Parameter::StereoMu, 0.0).unwrap();
    let mut sent = Vec::new();
    let mut value = 0;
    for _frame in 0..8 {
        // All messages of a frame come before the target moves.
        let before = parameters.clone();
        let mut last = None;
        for _ in 0..15 {
            last = touch(&mut bindings, &knob(1, value), &before);
            assert!(last.is_some(), "the fader lost its target at {value}");
            value += 1;
        }
        let standing = |target: Target, number| target.standing(number, &before);
        sent.extend(bindings.feedback(&standing, &|_| true));
        let Some(Cue::Do(Action::Set { parameter, value })) = last else { panic!("{last:?}") };
        parameters.set(parameter, value).unwrap();
    }
    let standing = |target: Target, number| target.standing(number, &parameters);
    sent.extend(bindings.feedback(&standing, &|_| true));
    assert_eq!(sent, [], "the fader shows its position already");
    // Another change of the target is shown, and takes it from the hand.
    let mut parameters = parameters.clone();
    parameters.set(Parameter::StereoMu, 0.1).unwrap();
    let standing = |target: Target, number| target.standing(number, &parameters);
    assert_eq!(bindings.feedback(&standing, &|_| true).len(), 1);
    assert_eq!(touch(&mut bindings, &knob(1, 118), &parameters), None);
}

#[test]
fn bindings_that_find_no_room_are_said() {
    let control = |n: usize| Control::Note { channel: (n / 128) as u8, number: (n % 128) as u8 };
    let target = Target::Parameter(Parameter::Limit);
    let list: Vec<Binding> = (0..MOST_BINDINGS).map(|n| binding(control(n), target)).collect();
    let full = Bindings::new(list);
    let text = |n: usize| Bindings::new(vec![binding(control(n), target)]).to_text().unwrap();
    let mut bindings = full.clone();
    let why = bindings.import(&text(MOST_BINDINGS)).unwrap_err().to_string();
    assert!(why.contains("512") && bindings == full, "{why}");
    assert_eq!(bindings.import(&text(0)).unwrap(), 1, "one that takes the place of another");
    // A target goes on waiting until there is room for its control.
    let parameters = Parameters::default();
    bindings.learn(Some((target, None)));
    assert_eq!(touch(&mut bindings, &knob(7, 127), &parameters), None);
    assert_eq!((bindings.learning(), bindings.list().len()), (Some((target, None)), MOST_BINDINGS));
    assert!(bindings.is_full());
    bindings.forget(0);
    assert!(!bindings.is_full());
    assert!(touch(&mut bindings, &knob(7, 127), &parameters).is_some());
    assert_eq!((bindings.learning(), bindings.list().len()), (None, MOST_BINDINGS));
}

#[test]
fn an_osc_message_without_a_value_presses_each_time() {
    let mut bindings = Bindings::default();
    let parameters = Parameters::default();
    let hear = |bindings: &mut Bindings, address: &str, value| {
        bindings.touch_osc(address, value, &parameters, &|_, _| None)
    };
    bindings.learn(Some((Target::Go, None)));
    let press = Some(Cue::Ask(Target::Go, Which::Press));
    for _ in 0..3 {
        assert_eq!(hear(&mut bindings, "/go", None), press);
    }
    // With a value, it is held until it is released.
    let held = [1.0, 1.0, 0.0, 1.0].map(|value| hear(&mut bindings, "/go", Some(value)));
    assert_eq!(held, [press.clone(), None, None, press]);
    // A level is not put back.
    bindings.learn(Some((Target::Volume, None)));
    let full = Some(Cue::Ask(Target::Volume, Which::Level(1.0)));
    assert_eq!([None, None].map(|value| hear(&mut bindings, "/full", value)), [full.clone(), full]);
}
