//! A dance is one wherever it is kept, and the favorite that is shown in turn stays while others come and go.

use super::*;

use chladni_music::{GalleryItem, ItemId, Parameter, Scene};

const STEP: f64 = 16.0;

fn instrument() -> Instrument {
    let shape = GalleryShape { eigenvalues: (0..32).map(f64::from).collect(), bands: 16 };
    Instrument::new(77, 6, shape).unwrap()
}

fn apply(instrument: &mut Instrument, at_beat: f64, action: Action) {
    instrument.apply(Moment { at_secs: at_beat, at_beat }, action).unwrap();
}

#[test]
fn a_dance_that_is_drawn_or_renamed_is_the_same_in_all_generations() {
    let mut instrument = instrument();
    let transfer: Vec<f32> =
        instrument.gallery().items()[3].genome.transfer.iter().map(|x| 0.5 * x).collect();
    let [marked, staged] = [2, 4].map(|item: usize| instrument.gallery().items()[item].id);
    for action in [
        Action::Favorite { item: 2, on: true },
        Action::Choose { item: 2, on: true },
        Action::Perform { item: 4 },
        Action::Mutate { item: 0, amount: 0.2 },
        Action::Choose { item: 2, on: false },
        Action::SetTransfer { item: 2, transfer: transfer.clone() },
        Action::SetStereoMu { item: 4, stereo_mu: 0.125 },
        Action::Rename { item: 2, name: "tide".into() },
    ] {
        apply(&mut instrument, 0.0, action);
    }
    for generation in [1, 0] {
        apply(&mut instrument, 0.0, Action::GoTo { generation });
        let drawn = instrument.item(marked).unwrap();
        assert_eq!((&drawn.genome.transfer, drawn.name.as_str(), drawn.edited), (&transfer, "tide", true));
        assert_eq!(drawn, &instrument.gallery().items()[2]);
        assert_eq!(
            (&instrument.favorites()[0].genome, instrument.favorites()[0].name.as_str()),
            (&drawn.genome, "tide")
        );
        assert_eq!(instrument.item(staged).unwrap().genome.stereo_mu, 0.125);
        // What a generation has chosen is its own.
        assert_eq!(drawn.chosen, generation == 0);
    }
    let wrong = Action::SetTransfer { item: 2, transfer: vec![7.0; 16] };
    let before = instrument.clone();
    assert!(instrument.apply(Moment::default(), wrong).is_err() && instrument == before);
}

#[test]
fn a_dance_that_is_brought_comes_in_the_shows_own_look_by_key_and_by_fader() {
    for bring in [Action::Go, Action::Crossfade { share: 1.0 }] {
        let mut instrument = instrument();
        apply(&mut instrument, 0.0, Action::Perform { item: 0 });
        apply(&mut instrument, 0.0, Action::SetLook { look: "Ember".into() });
        apply(&mut instrument, 1.0, Action::CueUp { item: 3 });
        apply(&mut instrument, 2.0, Action::Crossfade { share: 0.5 });
        assert_eq!(instrument.look(), Some("Ember"));
        apply(&mut instrument, 8.0, bring.clone());
        assert_eq!(instrument.look(), None, "{bring:?}");
    }
}

/// Three favorites in turn.
fn three() -> (Instrument, [ItemId; 4]) {
    let mut instrument = instrument();
    for action in [
        Action::Favorite { item: 0, on: true },
        Action::Favorite { item: 1, on: true },
        Action::Favorite { item: 2, on: true },
        Action::Set { parameter: Parameter::BeatsPerStep, value: STEP as f32 },
        Action::Set { parameter: Parameter::TransitionBeats, value: 4.0 },
        Action::Switch { switch: Switch::BeatSteps, on: true },
        Action::PerformFavorites { first: 0 },
    ] {
        apply(&mut instrument, 0.0, action);
    }
    let ids = [0, 1, 2, 3].map(|item: usize| instrument.gallery().items()[item].id);
    (instrument, ids)
}

#[test]
fn the_favorite_that_is_shown_stays_when_their_list_or_their_steps_change() {
    let (three, [_, second, third, _]) = three();
    let steps = |on| Action::Switch { switch: Switch::BeatSteps, on };
    let each = |value| Action::Set { parameter: Parameter::BeatsPerStep, value };
    let changes = [
        // When the next one comes, after each.
        (Action::Favorite { item: 3, on: true }, Some(8.0)),
        (Action::Favorite { item: 0, on: false }, Some(8.0)),
        (steps(false), None),
        (each(5.0), Some(5.0)),
        (each(32.0), Some(24.0)),
    ];
    let beat = 7.0 * STEP + 8.0;
    for (action, next) in changes {
        let mut instrument = three.clone();
        assert_eq!(instrument.scene(beat).unwrap().to, second);
        apply(&mut instrument, beat, action.clone());
        let shown = |after: f64| {
            let scene = instrument.scene(beat + after).unwrap();
            (scene.to, scene.weight)
        };
        assert_eq!(shown(0.0), (second, 1.0), "{action:?}");
        assert_eq!(shown(next.unwrap_or(1000.0) - 0.5), (second, 1.0), "{action:?}");
        assert!(next.is_none_or(|next| shown(next + 0.5).0 == third), "{action:?}");
        assert_eq!(instrument.with_beats(|moment| moment.at_secs).unwrap(), instrument);
    }
    // A change during a transition is not seen either.
    let mut instrument = three.clone();
    let amid = instrument.scene(7.0 * STEP + 1.0).unwrap();
    assert!(amid.from != amid.to && amid.weight > 0.0 && amid.weight < 1.0);
    apply(&mut instrument, 7.0 * STEP + 1.0, Action::Favorite { item: 3, on: true });
    assert_eq!(instrument.scene(7.0 * STEP + 1.0), Some(amid));
    // Nor where a transition takes longer than a step.
    let mut instrument = three.clone();
    let longer = Action::Set { parameter: Parameter::TransitionBeats, value: 2.0 * STEP as f32 };
    apply(&mut instrument, 7.0 * STEP, longer);
    let amid = instrument.scene(7.0 * STEP + 1.0).unwrap();
    assert!(amid.from != amid.to && amid.weight > 0.0 && amid.weight < 1.0);
    apply(&mut instrument, 7.0 * STEP + 1.0, Action::Favorite { item: 3, on: true });
    assert_eq!(instrument.scene(7.0 * STEP + 1.0), Some(amid));
    // Stepping begins again with the one that is shown.
    let mut instrument = three;
    apply(&mut instrument, beat, steps(false));
    apply(&mut instrument, beat + 1000.0, steps(true));
    assert_eq!(instrument.scene(beat + 1000.0).unwrap().to, second);
    assert_eq!(instrument.scene(beat + 1000.5 + STEP).unwrap().to, third);
    let before = instrument.clone();
    assert!(instrument.apply(Moment::default(), each(f32::NAN)).is_err() && instrument == before);
}

#[test]
fn a_favorite_that_is_one_no_longer_leaves_the_stage() {
    let (mut instrument, [first, second, third, _]) = three();
    let beat = 7.0 * STEP + 8.0;
    apply(&mut instrument, beat, Action::SetLook { look: "Ember".into() });
    apply(&mut instrument, beat, Action::Favorite { item: 1, on: false });
    assert_eq!(instrument.scene(beat), Some(Scene { from: second, to: third, weight: 0.0 }));
    assert_eq!(instrument.scene(beat + 4.0).map(|scene| (scene.to, scene.weight)), Some((third, 1.0)));
    assert_eq!(instrument.scene(beat + STEP + 4.0).map(|scene| scene.to), Some(first));
    assert!(instrument.item(second).is_some() && instrument.look().is_some());
    for item in [0, 2] {
        apply(&mut instrument, beat + 5.0, Action::Favorite { item, on: false });
    }
    assert!(instrument.scene(beat + 5.0).is_none() && instrument.look().is_none());
    // The stage does not open by itself where there is a favorite again.
    apply(&mut instrument, beat + 6.0, Action::Favorite { item: 4, on: true });
    assert_eq!(instrument.scene(beat + 6.0), None);
    assert_eq!(instrument.with_beats(|moment| moment.at_secs).unwrap(), instrument);
}

#[test]
fn the_gallery_steps_on_the_beat_from_the_dance_that_was_put_on_stage() {
    let mut instrument = instrument();
    let ids: Vec<ItemId> = instrument.gallery().items().iter().map(|item| item.id).collect();
    let steps = |on| Action::Switch { switch: Switch::BeatSteps, on };
    let shown = |instrument: &Instrument, beat: f64| instrument.scene(beat).map(|scene| scene.to).unwrap();
    apply(&mut instrument, 0.0, Action::Set { parameter: Parameter::BeatsPerStep, value: STEP as f32 });
    apply(&mut instrument, 0.0, Action::PerformGallery { first: 4 });
    assert_eq!(shown(&instrument, 10.0 * STEP), ids[4]);
    assert!(!instrument.steps_through_gallery());
    apply(&mut instrument, 0.0, steps(true));
    assert!(instrument.steps_through_gallery());
    for (step, place) in [4, 5, 0, 1].into_iter().enumerate() {
        assert_eq!(shown(&instrument, (step as f64 + 0.9) * STEP), ids[place], "step {step}");
    }
    // Another gallery changes nothing on stage, and what is turned off stays with the dance of now.
    apply(&mut instrument, STEP, Action::NewGallery { seed: 78, size: 9 });
    assert_eq!(shown(&instrument, 2.9 * STEP), ids[0]);
    assert!(ids.iter().all(|id| instrument.item(*id).is_some()));
    apply(&mut instrument, 2.9 * STEP, steps(false));
    assert_eq!(shown(&instrument, 9.9 * STEP), ids[0]);
    assert_eq!(instrument.with_beats(|moment| moment.at_secs).unwrap(), instrument);
    // Alone is alone.
    apply(&mut instrument, 10.0 * STEP, steps(true));
    apply(&mut instrument, 10.0 * STEP, Action::Perform { item: 0 });
    assert_eq!(shown(&instrument, 15.0 * STEP), instrument.gallery().items()[0].id);
    assert!(!instrument.steps_through_gallery());
    assert_eq!(instrument.item(ids[1]), None);
    let before = instrument.clone();
    let nowhere = Action::PerformGallery { first: 9 };
    assert!(instrument.apply(Moment::default(), nowhere).is_err() && instrument == before);
}

#[test]
fn the_gallery_goes_on_from_the_one_that_is_brought_by_hand() {
    for by_fader in [false, true] {
        let mut instrument = instrument();
        let ids: Vec<ItemId> = instrument.gallery().items().iter().map(|item| item.id).collect();
        apply(&mut instrument, 0.0, Action::Switch { switch: Switch::BeatSteps, on: true });
        apply(&mut instrument, 0.0, Action::Set { parameter: Parameter::BeatsPerStep, value: STEP as f32 });
        apply(&mut instrument, 0.0, Action::PerformGallery { first: 0 });
        apply(&mut instrument, 4.0, Action::CueUp { item: 3 });
        apply(&mut instrument, 8.0, if by_fader { Action::Crossfade { share: 1.0 } } else { Action::Go });
        let shown = |beat: f64| instrument.scene(beat).map(|scene| scene.to);
        assert_eq!([8.0, 7.0 + STEP, 9.0 + STEP].map(shown), [3, 3, 4].map(|place: usize| Some(ids[place])));
        assert_eq!(instrument.next_on_stage(), None);
    }
}

#[test]
fn a_transition_that_has_begun_goes_on_as_it_began() {
    let takes = |value| Action::Set { parameter: Parameter::TransitionBeats, value };
    // One dance after another, amid the transition and long after it.
    let mut alone = instrument();
    apply(&mut alone, 0.0, Action::Perform { item: 0 });
    apply(&mut alone, 8.0, Action::Perform { item: 3 });
    // Dances in turn likewise, and in a transition that a step cuts short.
    let (in_turn, _) = three();
    let mut cut_short = in_turn.clone();
    apply(&mut cut_short, 0.0, takes(64.0));
    let steps_off = Action::Switch { switch: Switch::BeatSteps, on: false };
    for (before, beat, action) in [
        (&alone, 10.0, takes(64.0)),
        (&alone, 28.0, takes(64.0)),
        (&alone, 28.0, takes(0.0)),
        (&in_turn, 7.0 * STEP + 1.0, takes(64.0)),
        (&in_turn, 7.0 * STEP + 8.0, takes(64.0)),
        (&cut_short, 7.0 * STEP + 8.0, steps_off),
    ] {
        let (mut after, scene) = (before.clone(), before.scene(beat).unwrap());
        apply(&mut after, beat, action.clone());
        let now = after.scene(beat).unwrap();
        assert_eq!((now.to, now.weight), (scene.to, scene.weight), "{action:?} at {beat}");
        assert_eq!(after.scene(beat + 7.5).map(|scene| scene.weight > 0.99), Some(true), "{action:?}");
        assert_eq!(after.with_beats(|moment| moment.at_secs).unwrap(), after);
    }
    // The next one takes what the knob says.
    apply(&mut alone, 28.0, takes(64.0));
    apply(&mut alone, 30.0, Action::Perform { item: 1 });
    assert_eq!(alone.scene(62.0).map(|scene| scene.weight), Some(0.5));
    let unchanged = alone.clone();
    assert!(alone.apply(Moment::default(), takes(1e3)).is_err() && alone == unchanged);
}

#[test]
fn a_preset_keeps_seed_tags_and_lineage_through_other_galleries() {
    let mut made = instrument();
    for item in [0, 1, 2] {
        apply(&mut made, 0.0, Action::Choose { item, on: true });
    }
    apply(&mut made, 0.0, Action::Breed);
    apply(&mut made, 0.0, Action::Favorite { item: 3, on: true });
    let first = made.preset(&made.favorites()[0], vec!["calm".into()]);
    assert!(first.seed == 77 && first.lineage.len() > 2);
    // A favorite outlives the gallery that it was bred in.
    apply(&mut made, 0.0, Action::NewGallery { seed: 78, size: 6 });
    assert_eq!(made.preset(&made.favorites()[0], first.tags.clone()), first);
    assert_eq!(made.preset(&made.gallery().items()[0], Vec::new()).seed, 78);

    let mut other = Instrument::new(9, 6, made.shape().clone()).unwrap();
    apply(&mut other, 0.0, Action::Take { item: 2, preset: Box::new(first.clone()) });
    let past = |item: &GalleryItem, instrument: &Instrument| {
        let preset = instrument.preset(item, instrument.tags(item.id));
        (preset.seed, preset.tags, preset.lineage)
    };
    let [taken, beside] = [2, 3].map(|item: usize| past(&other.gallery().items()[item], &other));
    assert_eq!(taken, (77, first.tags.clone(), first.lineage.clone()));
    assert_eq!((beside.0, beside.1.len(), beside.2.len()), (9, 0, 1));
    // Marked and changed by hand, it is in no gallery in the end.
    apply(&mut other, 0.0, Action::Favorite { item: 2, on: true });
    apply(&mut other, 0.0, Action::SetItemGain { item: 2, gain: 0.5 });
    for seed in [10, 11] {
        apply(&mut other, 0.0, Action::NewGallery { seed, size: 6 });
    }
    let (seed, tags, lineage) = past(&other.favorites()[0], &other);
    assert_eq!((seed, tags, &lineage[1..]), (77, first.tags, &first.lineage[1..]));
    assert!(lineage[0].edited);
    let text = Show::of(&other).to_text().unwrap();
    assert_eq!(Show::from_text(&text).unwrap().replay(other.shape().clone()).unwrap(), other);
}
