//! Presets and shows in files.

use super::*;

#[test]
fn a_preset_brings_its_form_and_knobs_and_an_old_one_says_that_it_has_none() {
    let shape = GalleryShape { eigenvalues: octopus().dancer.eigenvalues.clone(), bands: BANDS };
    let mut made = Instrument::new(3, 6, shape.clone()).unwrap();
    let now = Moment::default();
    made.apply(now, Action::SetForm { form: Form::Modal }).unwrap();
    made.apply(now, Action::Set { parameter: chladni_music::Parameter::Decay, value: 0.9 }).unwrap();
    made.apply(now, Action::Set { parameter: chladni_music::Parameter::TurnRad, value: 2.0 }).unwrap();
    let preset = made.preset(&made.gallery().items()[2], vec![]);
    let preset = Preset::from_text(&preset.to_text().unwrap()).unwrap();
    assert_eq!(preset.caution(), None);
    let mut other = Instrument::new(4, 6, shape).unwrap();
    let turn = other.parameters().get(chladni_music::Parameter::TurnRad);
    other.apply(now, Action::Take { item: 5, preset: Box::new(preset.clone()) }).unwrap();
    assert_eq!(other.gallery().items()[5].genome, preset.mapping);
    assert_eq!(other.parameters().form, Form::Modal);
    assert_eq!(other.parameters().get(chladni_music::Parameter::Decay), 0.9);
    // The beat's turn is of the stage, not of the dance.
    assert_eq!(other.parameters().get(chladni_music::Parameter::TurnRad), turn);
    let old = "format_version = 1\nname = \"x\"\nseed = 1\n[mapping]\ntransfer = [0.5]\namplification = [0.5]\nstereo_mu = 0.0\ngain = 1.0\n";
    let old = Preset::from_text(old).unwrap();
    assert!(old.caution().unwrap().contains("version 1") && old.settings.knobs.is_empty());
    assert!(!old.settings.switches[&Switch::Resonate], "nothing resonated then");
    assert_eq!(old.mapping_on(other.shape()), old.mapping);
}

#[test]
fn what_was_kept_before_anything_resonated_does_not_resonate() {
    let show = Show::from_text("format_version = 2\nseed = 5\nsize = 6\n").unwrap();
    let shape = GalleryShape { eigenvalues: octopus().dancer.eigenvalues.clone(), bands: BANDS };
    assert!(!show.begin(shape.clone()).unwrap().parameters().is_on(Switch::Resonate));
    let made = Instrument::new(3, 6, shape).unwrap();
    assert!(made.parameters().is_on(Switch::Resonate));
    let text = made.preset(&made.gallery().items()[0], vec![]).to_text().unwrap();
    assert!(Preset::from_text(&text).unwrap().settings.switches[&Switch::Resonate]);
    let old = text.replace("resonate = true\n", "").replace("format_version = 4", "format_version = 2");
    assert!(!Preset::from_text(&old).unwrap().settings.switches[&Switch::Resonate]);
}

#[test]
fn a_show_that_breeds_says_that_dances_come_out_differently_with_other_harmonics() {
    let text = "format_version = 2\nharmonics = 64\nseed = 5\nsize = 6\n";
    for breeds in ["do = \"breed\"", "do = \"mutate\", item = 0, amount = 0.5"] {
        let actions = format!("actions = [{{ at_secs = 1.0, at_beat = 0.0, {breeds} }}]\n");
        let bred = Show::from_text(&format!("{text}{actions}")).unwrap();
        assert_eq!(bred.caution_on(64), None);
        assert!(bred.caution_on(96).unwrap().contains("64 harmonics; with 96"), "{breeds}");
    }
    assert_eq!(Show::from_text(text).unwrap().caution_on(96), None);
}

#[test]
fn a_session_of_version_1_opens_as_a_show_with_the_knobs_of_then() {
    let text = "format_version = 1\nsong = \"old.ogg\"\nseed = 5\nsize = 6\n[[actions]]\nat_secs = 0.5\n\
                at_beat = 1.0\ndo = \"set\"\nparameter = \"gain\"\nvalue = 2.5\n";
    let show = Show::from_text(text).unwrap();
    assert!(show.caution().is_some());
    assert_eq!(show.songs[0].path, "old.ogg");
    let shape = GalleryShape { eigenvalues: octopus().dancer.eigenvalues.clone(), bands: BANDS };
    let instrument = show.replay(shape.clone()).unwrap();
    assert_eq!(instrument.parameters().form, Form::Filter);
    assert_eq!(instrument.parameters().get(chladni_music::Parameter::Gain), 2.5);
    assert_eq!(instrument.parameters().get(chladni_music::Parameter::Limit), 0.18);
    // Saved again it is of this version, and the same.
    let again = Show::from_text(&Show::of(&instrument).to_text().unwrap()).unwrap();
    assert!(again.caution().is_none());
    assert_eq!(again.replay(shape).unwrap(), instrument);
    for (bad, why) in [
        ("heard = [{ at_secs = 2.0, song = 1, playing = true }]", "no song 1"),
        ("heard = [{ at_secs = 2.0, playing = true }, { at_secs = 1.0, playing = true }]", "in order"),
        ("duration_secs = nan", "times"),
        ("actions = [{ at_secs = inf, at_beat = 0.0, do = \"breed\" }]", "times"),
        ("actions = [{ at_secs = 1.0, at_beat = nan, do = \"breed\" }]", "times"),
        ("songs = [{ path = \"a.ogg\", reading = { octave = 4 } }]", "beats"),
        ("songs = [{ path = \"a.ogg\", reading = { octave = -2147483648 } }]", "beats"),
    ] {
        let text = format!("format_version = 2\nseed = 5\nsize = 6\n{bad}\n");
        assert!(Show::from_text(&text).unwrap_err().to_string().contains(why), "{bad}");
    }
    for beyond in ["distance = 0.0", "shift = [1200.0, 0.0]", "yaw_rad = nan"] {
        let text = format!("format_version = 2\nseed = 5\nsize = 6\nviewpoint = {{ {beyond} }}\n");
        assert_eq!(Show::from_text(&text).unwrap().viewpoint, chladni_music::Viewpoint::default());
    }
    // An installation that plays for a week.
    let text = "format_version = 2\nseed = 5\nsize = 6\nduration_secs = 604800.0\n";
    assert_eq!(Show::from_text(text).unwrap().ends_secs(), 604_800.0);
}

#[test]
fn a_fader_that_is_nowhere_is_refused() {
    let shape = GalleryShape { eigenvalues: octopus().dancer.eigenvalues.clone(), bands: BANDS };
    let mut instrument = Instrument::new(3, 6, shape).unwrap();
    let mut fade = |share: f32| {
        let faded = instrument.apply(Moment::default(), Action::Crossfade { share });
        (faded.is_ok(), instrument.fader())
    };
    assert_eq!(fade(0.25), (true, 0.25));
    for share in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert_eq!(fade(share), (false, 0.25));
    }
    assert_eq!((fade(7.0), fade(-7.0)), ((true, 1.0), (true, 0.0)));
}

#[test]
fn a_name_is_a_line_of_a_few_words_wherever_it_comes_from() {
    let shape = GalleryShape { eigenvalues: octopus().dancer.eigenvalues.clone(), bands: BANDS };
    let mut instrument = Instrument::new(3, 6, shape).unwrap();
    let (long, shown) = (format!("one\ntwo\u{1b}{}", "é".repeat(300)), format!("onetwo{}", "é".repeat(194)));
    let mapping = instrument.gallery().items()[0].genome.clone();
    let mut preset = instrument.preset(&instrument.gallery().items()[0], vec![]);
    preset.name = long.clone();
    assert_eq!(Preset::from_text(&preset.to_text().unwrap()).unwrap().name, shown);
    let actions = [
        Action::Rename { item: 0, name: long.clone() },
        Action::Load { item: 1, name: long.clone(), mapping },
        Action::Take { item: 2, preset: Box::new(preset) },
    ];
    for (item, action) in actions.into_iter().enumerate() {
        instrument.apply(Moment::default(), action).unwrap();
        let item = &instrument.gallery().items()[item];
        assert_eq!(item.name, shown);
        assert!(!matches!(&item.origin, chladni_music::Origin::Loaded { name } if *name != shown));
    }
}

fn coefficients_of(items: &[Item]) -> Vec<u32> {
    let mut bits = Vec::new();
    for term in items.iter().flat_map(|item| &item.terms) {
        match &term.coefficients {
            chladni_synth::Coefficients::Vector(c) => bits.extend(c.iter().flatten().map(|x| x.to_bits())),
            chladni_synth::Coefficients::Normal(c) => bits.extend(c.iter().map(|x| x.to_bits())),
        }
    }
    bits
}

#[test]
fn a_favorite_that_is_edited_is_one_dance() {
    let shape = GalleryShape { eigenvalues: octopus().dancer.eigenvalues.clone(), bands: BANDS };
    let mut instrument = Instrument::new(77, 6, shape).unwrap();
    let transfer =
        instrument.gallery().items()[3].genome.transfer.iter().map(|x| 0.5 * x).collect::<Vec<_>>();
    for action in [
        Action::Favorite { item: 2, on: true },
        Action::SetTransfer { item: 2, transfer: transfer.clone() },
        Action::SetTransfer { item: 3, transfer },
    ] {
        instrument.apply(Moment::default(), action).unwrap();
    }
    assert_eq!(instrument.favorites(), &instrument.gallery().items()[2..3]);
}

#[test]
fn shows_before_version_4_breed_as_they_did() {
    let shape = GalleryShape { eigenvalues: octopus().dancer.eigenvalues.clone(), bands: BANDS };
    let line = |what: &str| format!("{{ at_secs = 1.0, at_beat = 0.0, do = {what} }}");
    let actions = [
        r#""mutate", item = 2, amount = 0.2"#,
        r#""choose", item = 0, on = true"#,
        r#""breed-from", candidates = [0, 1, 2, 3, 4, 5]"#,
    ];
    let actions = actions.map(line).join(", ");
    let of_version = |version: u32| {
        let text = format!("format_version = {version}\nseed = 5\nsize = 6\nactions = [{actions}]\n");
        Show::from_text(&text).unwrap().replay(shape.clone()).unwrap()
    };
    let (old, new) = (of_version(3), of_version(4));
    let gain = |instrument: &Instrument, place: usize, generation: usize| {
        instrument.gallery().generations()[generation].items[place].genome.gain
    };
    assert_eq!(gain(&old, 2, 0), gain(&old, 2, 1), "the gain of a mutant was its parent's");
    assert_ne!(gain(&new, 2, 0), gain(&new, 2, 1));
    // The candidates are mutants of the only one that is chosen.
    assert!((0..6).all(|place| gain(&old, place, 2) == gain(&old, 0, 1)));
    assert!((0..6).any(|place| gain(&new, place, 2) != gain(&new, 0, 1)));
    // And still do when they are saved again.
    let again = Show::from_text(&Show::of(&old).to_text().unwrap()).unwrap();
    assert_eq!(again.replay(shape.clone()).unwrap().gallery().items(), old.gallery().items());
}

#[test]
fn a_session_replays_bit_for_bit_through_its_file() {
    let shape = GalleryShape { eigenvalues: octopus().dancer.eigenvalues.clone(), bands: BANDS };
    let mut live = Instrument::new(77, 6, shape.clone()).unwrap();
    let script = [
        Action::Choose { item: 0, on: true },
        Action::Choose { item: 4, on: true },
        Action::Breed,
        Action::Mutate { item: 2, amount: 0.15 },
        Action::Favorite { item: 2, on: true },
        Action::Rename { item: 2, name: "waves \"é\"".into() },
        Action::SetForm { form: Form::HalfMask },
        Action::Set { parameter: chladni_music::Parameter::Gain, value: 1.7 },
        Action::GoTo { generation: 1 },
        Action::Perform { item: 5 },
    ];
    for (i, action) in script.into_iter().enumerate() {
        let at_secs = 0.1 + 0.3 * i as f64;
        live.apply(Moment { at_secs, at_beat: 2.0 * at_secs }, action).unwrap();
    }
    assert!(live.apply(Moment::default(), Action::Lock { item: 9, on: true }).is_err());
    let text = Show::of(&live).to_text().unwrap();
    let replayed = Show::from_text(&text).unwrap().replay(shape.clone()).unwrap();
    assert_eq!(live, replayed);
    // Shows of before have the word in another spelling.
    let older = text.replace("favorite", "favourite");
    assert!(older != text && Show::from_text(&older).unwrap().replay(shape).unwrap() == live);

    let song = sample_tune();
    let dance = |instrument: &Instrument| {
        let mut analyzer = SpectrumAnalyzer::new(SpectrumSettings::new(song.rate_hz)).unwrap();
        let mut ensemble = Ensemble::new(octopus().dancer.clone());
        let window = analyzer.window_frames();
        let mut bits = Vec::new();
        for frame in 0..10 {
            let from = 40_000 + frame * 2000;
            let s =
                analyzer.analyze(&song.left[from..from + window], &song.right[from..from + window], 0.045);
            let bands = bands_of(s);
            let beat = Beat { count: 6.0 + frame as f64 * 0.1, confidence: 1.0 };
            bits.extend(coefficients_of(ensemble.play(instrument, &bands, beat).unwrap()));
        }
        bits
    };
    let bits = dance(&live);
    assert!(bits.iter().any(|b| *b != 0));
    assert_eq!(bits, dance(&replayed));
}

#[test]
fn what_stays_where_it_stands_is_no_action_of_a_show() {
    let shape = GalleryShape { eigenvalues: (0..32).map(f64::from).collect(), bands: 16 };
    let mut instrument = Instrument::new(1, 6, shape.clone()).unwrap();
    let sand = !instrument.parameters().is_on(Switch::Sand);
    for _ in 0..3 {
        let gain = Action::Set { parameter: chladni_music::Parameter::Gain, value: 1.7 };
        let actions = [
            gain,
            Action::Switch { switch: Switch::Sand, on: sand },
            Action::SetForm { form: Form::Modal },
            Action::SetChoir { choir: chladni_music::Choir::Symmetric },
            Action::SetHarmonics { harmonics: 8 },
            Action::Crossfade { share: 0.25 },
        ];
        for action in actions {
            instrument.apply(Moment::default(), action).unwrap();
        }
    }
    assert_eq!(instrument.log().len(), 6);
    assert_eq!(Show::of(&instrument).replay(shape).unwrap(), instrument);
}

#[test]
fn a_show_keeps_the_tempo_that_was_tapped_for_a_song() {
    let shape = GalleryShape { eigenvalues: (0..32).map(f64::from).collect(), bands: 16 };
    let tapped = Some(TappedBeats { per_found: 1.5, at_secs: 20.25 });
    let reading = BeatReading { octave: -1, shift_secs: 0.125, tapped };
    let song = SongRef { path: "sample:tune".into(), blake3: None, reading };
    let show = Show { songs: vec![song], ..Show::of(&Instrument::new(1, 6, shape).unwrap()) };
    let text = show.to_text().unwrap();
    assert_eq!(Show::from_text(&text).unwrap().songs, show.songs);
    for per_found in ["0.0", "1e9", "nan"] {
        let wrong = text.replace("per_found = 1.5", &format!("per_found = {per_found}"));
        assert!(wrong != text && Show::from_text(&wrong).is_err(), "{per_found}");
    }
}

#[test]
fn a_show_keeps_how_its_shape_stands_where_that_was_set() {
    let shape = GalleryShape { eigenvalues: (0..32).map(f64::from).collect(), bands: 16 };
    let plain = Show::of(&Instrument::new(1, 6, shape).unwrap());
    assert!(!plain.to_text().unwrap().contains("stands"));
    let text = Show { stands: Some(Orientation::Z_UP), ..plain }.to_text().unwrap();
    assert!(text.contains("stands = \"up z, front -y\""), "{text}");
    assert_eq!(Show::from_text(&text).unwrap().stands, Some(Orientation::Z_UP));
    let wrong = text.replace("front -y", "front z");
    assert!(Show::from_text(&wrong).unwrap_err().to_string().contains("up z, front z"));
}

#[test]
fn a_dance_stays_on_stage_when_another_gallery_begins() {
    let shape = GalleryShape { eigenvalues: octopus().dancer.eigenvalues.clone(), bands: BANDS };
    let at = |at_beat: f64| Moment { at_secs: 0.5 * at_beat, at_beat };
    let mut instrument = Instrument::new(3, 6, shape.clone()).unwrap();
    instrument.apply(at(0.0), Action::Perform { item: 2 }).unwrap();
    let another = Action::Set { parameter: chladni_music::Parameter::TransitionBeats, value: 4.0 };
    instrument.apply(at(0.0), another).unwrap();
    instrument.apply(at(8.0), Action::SetItemGain { item: 4, gain: 0.3 }).unwrap();
    instrument.apply(at(8.0), Action::Perform { item: 4 }).unwrap();
    instrument.apply(at(9.0), Action::CueUp { item: 5 }).unwrap();
    let [before, shown, next] = [2, 4, 5].map(|item| instrument.gallery().items()[item].clone());
    let loud = vec![0.5; BANDS];
    let bands = Bands { left: &loud, right: &loud, mid: &loud, side: &loud, side_gain: 1.0, ringing: None };
    let dance = |instrument: &Instrument, beat: f64| {
        let mut ensemble = Ensemble::new(octopus().dancer.clone());
        let beat = Beat { count: beat, confidence: 1.0 };
        coefficients_of(ensemble.play(instrument, &bands, beat).unwrap())
    };
    let moved = dance(&instrument, 10.0);
    for seed in [4, 5] {
        instrument.apply(at(10.0), Action::NewGallery { seed, size: 9 }).unwrap();
        assert_eq!(dance(&instrument, 10.0), moved);
    }
    for item in [&before, &shown, &next] {
        assert_eq!(instrument.item(item.id), Some(item));
    }
    // What has left the stage is forgotten.
    instrument.apply(at(20.0), Action::Go).unwrap();
    assert_eq!((instrument.item(before.id), instrument.item(next.id)), (None, Some(&next)));
    assert!(dance(&instrument, 20.0).iter().any(|bits| *bits != 0));
    let text = Show::of(&instrument).to_text().unwrap();
    assert_eq!(Show::from_text(&text).unwrap().replay(shape).unwrap(), instrument);
    instrument.apply(at(30.0), Action::LeaveStage).unwrap();
    assert_eq!((instrument.item(shown.id), instrument.item(next.id)), (None, None));
}

#[test]
fn all_that_is_random_follows_the_seed_of_the_gallery_from_then_on() {
    let shape = GalleryShape { eigenvalues: octopus().dancer.eigenvalues.clone(), bands: BANDS };
    let mut instrument = Instrument::new(3, 6, shape.clone()).unwrap();
    let turns = |instrument: &Instrument, from: u32| -> Vec<f32> {
        let beats = (0..200).map(|i| Beat { count: f64::from(from) + f64::from(i) / 10.0, confidence: 1.0 });
        let react = |beat| react(beat, |n| instrument.seed_of_beat(n), instrument.parameters());
        beats.map(|beat| react(beat).turn_rad).collect()
    };
    let before = turns(&instrument, 0);
    let moment = Moment { at_secs: 5.2, at_beat: 10.4 };
    instrument.apply(moment, Action::NewGallery { seed: 4, size: 6 }).unwrap();
    assert_eq!((instrument.seed(), instrument.first_seed()), (4, 3));
    assert_eq!([5.1, 5.2].map(|secs| instrument.seed_at(secs)), [3, 4]);
    // A turn that has begun is made, and the dances of that seed turn as in a show that began with it.
    assert_eq!(turns(&instrument, 0)[..110], before[..110]);
    let other = Instrument::new(4, 6, shape.clone()).unwrap();
    assert_eq!(turns(&instrument, 50), turns(&other, 50));
    assert_ne!(turns(&other, 0), before);
    let text = Show::of(&instrument).to_text().unwrap();
    assert_eq!(Show::from_text(&text).unwrap().replay(shape).unwrap(), instrument);
    assert_eq!(instrument.preset(&instrument.gallery().items()[0], Vec::new()).seed, 4);
}

#[test]
fn files_of_newer_versions_and_of_nonsense_are_refused() {
    assert!(Show::from_text("format_version = 99").unwrap_err().to_string().contains("99"));
    assert!(Preset::from_text("name = 3").is_err());
    let text = "format_version = 1\nname = \"x\"\nseed = 1\n[mapping]\ntransfer = [2.0]\namplification = [0.5]\nstereo_mu = 0.0\ngain = 1.0\n";
    assert!(Preset::from_text(text).unwrap_err().to_string().contains("transfer"));
}

#[test]
fn a_long_evening_is_read_again_and_what_never_ends_is_refused() {
    let path = std::env::temp_dir().join(format!("chladni-evening-{}.toml", std::process::id()));
    // More than 16 MiB: a knob that is turned 60 times a second for almost an hour.
    let turn = "[[actions]]\nat_secs = 0.0\nat_beat = 0.0\ndo = \"set\"\nparameter = \"gain\"\nvalue = 1.5\n";
    let text = format!("format_version = 1\nseed = 5\nsize = 6\n{}", turn.repeat((17 << 20) / turn.len()));
    std::fs::write(&path, &text).unwrap();
    assert!(Show::load(&path).unwrap().actions.len() > 190_000);
    std::fs::File::create(&path).unwrap().set_len(257 << 20).unwrap();
    assert!(Show::load(&path).unwrap_err().to_string().contains("larger than the 256 MiB"));
    std::fs::remove_file(&path).unwrap();
    if cfg!(target_os = "linux") {
        assert!(Preset::load(std::path::Path::new("/dev/zero")).is_err());
    }
}
