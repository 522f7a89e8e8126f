use super::*;

#[test]
fn reactions_are_continuous_and_vanish_without_confidence() {
    let parameters = Parameters::default();
    let at = |count| react(Beat { count, confidence: 1.0 }, |_| 5, &parameters);
    let mut moved = [0.0f32; 2];
    for i in 0..3200 {
        let (a, b) = (at(f64::from(i) / 100.0), at(f64::from(i + 1) / 100.0));
        assert!((a.turn_rad - b.turn_rad).abs() < 0.05, "beat {i}");
        assert!((a.light_turn_rad - b.light_turn_rad).abs() < 0.12, "beat {i}");
        moved[0] = moved[0].max(a.turn_rad.abs());
        moved[1] = moved[1].max(a.light_turn_rad.abs());
    }
    assert!(moved[0] > 0.1 && moved[1] > 0.3, "{moved:?}");
    let unsure = react(Beat { count: 7.3, confidence: 0.0 }, |_| 5, &parameters);
    assert_eq!((unsure.turn_rad, unsure.light_turn_rad, unsure.light_gain), (0.0, 0.0, 1.0));
}

#[test]
fn any_beat_of_a_damaged_session_has_a_scene() {
    let item = |id| GalleryItem {
        id,
        name: String::new(),
        genome: crate::Mapping::rest(1, 1),
        origin: crate::Origin::Initial { seed: 0, place: 0 },
        edited: false,
        chosen: false,
        forgotten: false,
        locked: false,
    };
    let favorites = [item(3), item(4), item(5)];
    let mut parameters = Parameters::default();
    parameters.switch(Switch::BeatSteps, true);
    for since in [-1e300, 0.0, 1e300, f64::NAN, f64::INFINITY] {
        let mut stage = Stage::default();
        stage.show_favorites(2, since, &favorites, &parameters);
        for beat in [-1e300, 0.0, 7.5, 1e300, f64::NAN] {
            let scene = stage.scene(beat, &favorites, &parameters).unwrap();
            assert!([3, 4, 5].contains(&scene.to) && (0.0..=1.0).contains(&scene.weight));
            let (mut fewer, scene) = stage.in_turn(beat, &favorites, &parameters).unwrap();
            fewer.go_on_after(scene, beat, &favorites[..2], &parameters);
            assert!([3, 4].contains(&fewer.scene(beat, &favorites[..2], &parameters).unwrap().to));
            react(Beat { count: beat, confidence: 1.0 }, |_| 5, &parameters);
        }
    }
}

#[test]
fn a_fader_brings_the_next_one_and_goes_back_for_the_one_after() {
    let (mut stage, parameters) = (Stage::default(), Parameters::default());
    stage.show_item(3, 0.0, &[], &parameters);
    let scene = |stage: &Stage| stage.scene(20.0, &[], &parameters).unwrap();
    stage.fade(0.4, 0.0);
    assert_eq!(scene(&stage).to, 3);
    stage.fade(0.0, 0.0);
    for (way, before, id) in [([0.0, 0.25, 0.5, 0.9], 3, 7), ([1.0, 0.75, 0.5, 0.1], 7, 9)] {
        stage.cue_up(id);
        let mut last = 0.0;
        for fader in way {
            stage.fade(fader, 0.0);
            let now = scene(&stage);
            let weight = if now.to == id { now.weight } else { 0.0 };
            assert!(weight >= last && weight < 1.0 && (now.from == before), "{now:?}");
            last = weight;
        }
        assert!(last > 0.9);
        stage.fade(if way[0] == 0.0 { 1.0 } else { 0.0 }, 0.0);
        assert_eq!(scene(&stage), Scene { from: id, to: id, weight: 1.0 });
        assert_eq!(stage.next(), None);
    }
    // Without a stage nothing is shown, and who is next stays next.
    stage.clear();
    stage.cue_up(4);
    stage.fade(1.0, 0.0);
    assert!(stage.scene(1.0, &[], &parameters).is_none() && stage.next().is_some());
    stage.fade(0.0, 0.0);
    stage.show_item(4, 2.0, &[], &parameters);
    assert_eq!((stage.next(), scene(&stage).to), (None, 4));
}

#[test]
fn the_light_is_brightest_on_the_beat_as_far_as_it_is_sure_and_fades_until_the_next() {
    let mut parameters = Parameters::default();
    parameters.set(Parameter::LightPulse, 0.5).unwrap();
    let gain = |count, confidence| react(Beat { count, confidence }, |_| 5, &parameters).light_gain;
    for (count, confidence, exact) in [(4.0, 1.0, 1.5), (4.5, 1.0, 1.125), (4.0, 0.5, 1.25)] {
        assert!((gain(count, confidence) - exact).abs() < 1e-6, "beat {count}");
    }
    assert!(gain(4.99, 1.0) < 1.001);
}

#[test]
fn switched_off_reactions_do_nothing() {
    let mut parameters = Parameters::default();
    parameters.switch(Switch::BeatTurns, false);
    parameters.switch(Switch::BeatLights, false);
    let still = react(Beat { count: 4.0, confidence: 1.0 }, |_| 5, &parameters);
    assert_eq!(still, Reaction { turn_rad: 0.0, light_turn_rad: 0.0, light_gain: 1.0 });
}
