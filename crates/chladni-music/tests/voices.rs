//! Deformations as instruments of the band: what drives them, how far they go, that they replay.
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::sync::{Arc, OnceLock};

use chladni_harmonics::{BasisSettings, Body};
use chladni_mesh::samples;
use chladni_music::{
    Action, Bands, Beat, Dancer, Driver, Ensemble, GalleryShape, Instrument, Mapping, Moment, MusicError,
    Parameter, Settings, Show, Symmetry, Voice, VoiceSettings, Voices,
};
use chladni_synth::{Coefficients, Item, Residual, Term, displacements_f64};
use chladni_task::Task;
use proptest::prelude::*;

const K: usize = 16;
const SILENCE: [f32; 8] = [0.0; 8];

fn ready() -> &'static (Body, Arc<Dancer>) {
    static READY: OnceLock<(Body, Arc<Dancer>)> = OnceLock::new();
    READY.get_or_init(|| {
        let mesh = samples::sample("octopus").unwrap();
        let body = Body::build(&mesh, &BasisSettings::new(K), &Task::new()).unwrap();
        let classes = Symmetry::of(&body, &Task::new()).unwrap().classes;
        let dancer = Arc::new(Dancer::new(&body, &classes, &chladni_mesh::Orientation::default()).unwrap());
        (body, dancer)
    })
}

/// Every vertex moves by `by`, as a caricature's layer would.
fn shift(by: [f32; 3]) -> Term {
    let everywhere: Arc<[[f32; 3]]> = vec![by; ready().0.positions.len()].into();
    Term {
        coefficients: Coefficients::Vector(Vec::new()),
        residual: Some(Residual::Vector(everywhere)),
        residual_gain: 1.0,
        mask: None,
    }
}

fn moved(item: &Item) -> [f64; 3] {
    displacements_f64(&ready().0, item).unwrap()[0]
}

fn mono(mid: &[f32]) -> Bands<'_> {
    Bands { left: mid, right: mid, mid, side: &SILENCE, side_gain: 1.0, ringing: None }
}

#[test]
fn each_driver_hears_what_it_is_meant_to() {
    let mid = [0.1, 0.2, 0.0, 0.0, 0.9, 0.0, 0.3, 0.4];
    let side = [3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let bands = Bands { left: &mid, right: &mid, mid: &mid, side: &side, side_gain: 1.0, ringing: None };
    let at = |driver: Driver, count, confidence| driver.strength(&bands, Beat { count, confidence });
    assert_eq!(at(Driver::Mid, 0.0, 0.0), 0.9);
    assert_eq!(at(Driver::Side, 0.0, 0.0), 1.0);
    assert_eq!(at(Driver::Band { from: 0.0, to: 0.5 }, 0.0, 0.0), 0.2);
    assert_eq!(at(Driver::Band { from: 1.0, to: 0.75 }, 0.0, 0.0), 0.4);
    // A band of no width is the one that it lies in, at the far end too.
    assert_eq!(at(Driver::Band { from: 0.5, to: 0.5 }, 0.0, 0.0), 0.9);
    assert_eq!(at(Driver::Band { from: 1.0, to: 1.0 }, 0.0, 0.0), 0.4);
    assert_eq!(at(Driver::Beat, 4.0, 1.0), 1.0);
    assert_eq!(at(Driver::Beat, 4.5, 1.0), 0.25);
    assert_eq!(at(Driver::Beat, 4.0, 0.0), 0.0);
    let none = Bands { left: &[], right: &[], mid: &[], side: &[], side_gain: 1.0, ringing: None };
    assert_eq!(Driver::Band { from: 0.0, to: 1.0 }.strength(&none, Beat::default()), 0.0);
}

#[test]
fn a_voice_moves_as_far_as_its_driver_says_and_they_add_up() {
    let dancer = &ready().1;
    let voice = |by, driver| Voice { term: shift(by), settings: VoiceSettings { driver, gain: 2.0 } };
    let voices = vec![
        voice([0.02, 0.0, 0.0], Driver::Mid),
        voice([0.0, 0.03, 0.0], Driver::Beat),
        voice([0.0, 0.0, 0.04], Driver::Side),
    ];
    let mut voices = Voices::new(voices, dancer, 1.0).unwrap();
    let mut item = voices.item();
    let beat = Beat { count: 7.0, confidence: 0.5 };
    for loudness in [1.0, 0.25, 0.0] {
        let mid = [loudness; 8];
        voices.play(&mono(&mid), beat, &mut item).unwrap();
        let d = moved(&item);
        assert!((d[0] - 0.04 * f64::from(loudness)).abs() < 1e-6, "{d:?}");
        assert!((d[1] - 0.03).abs() < 1e-6 && d[2] == 0.0, "{d:?}");
    }
    voices.tune(1, VoiceSettings { driver: Driver::Beat, gain: 0.0 }).unwrap();
    voices.play(&mono(&SILENCE), beat, &mut item).unwrap();
    assert_eq!(moved(&item), [0.0; 3]);
}

#[test]
fn what_cannot_be_played_is_refused() {
    let dancer = &ready().1;
    let settings = VoiceSettings { driver: Driver::Mid, gain: 1.0 };
    let voice = |term, settings| vec![Voice { term, settings }];
    let too_many = Term { coefficients: Coefficients::Normal(vec![0.0; K + 1]), ..shift([0.0; 3]) };
    assert!(matches!(Voices::new(voice(too_many, settings), dancer, 0.5), Err(MusicError::Size { .. })));
    for limit in [0.0, 1.5, f32::NAN] {
        assert!(Voices::new(voice(shift([0.0; 3]), settings), dancer, limit).is_err());
    }
    let mut voices = Voices::new(voice(shift([0.0; 3]), settings), dancer, 0.5).unwrap();
    assert!(voices.tune(1, settings).is_err());
    assert!(voices.tune(0, VoiceSettings { gain: f32::NAN, ..settings }).is_err());
    let band = Driver::Band { from: -1.0, to: 0.5 };
    assert!(voices.tune(0, VoiceSettings { driver: band, gain: 1.0 }).is_err());
    assert!(voices.play(&mono(&SILENCE), Beat::default(), &mut Item::default()).is_err());
}

#[test]
fn voices_move_every_item_of_an_ensemble_and_a_session_keeps_them() {
    let (_, dancer) = ready();
    let shape = GalleryShape { eigenvalues: dancer.eigenvalues.clone(), bands: 8 };
    let mut instrument = Instrument::new(3, 6, shape.clone()).unwrap();
    let now = Moment::default();
    let loud = VoiceSettings { driver: Driver::Mid, gain: 1.0 };
    instrument.apply(now, Action::SetVoice { voice: 0, settings: loud }).unwrap();
    instrument.apply(now, Action::Set { parameter: Parameter::Gain, value: 0.0 }).unwrap();
    let wrong = Action::SetVoice { voice: usize::MAX, settings: loud };
    assert!(instrument.apply(now, wrong).is_err());
    let mut ensemble = Ensemble::new(dancer.clone()).with_voices(vec![shift([0.1, 0.0, 0.0])]).unwrap();
    let mid = [0.5; 8];
    // Twice: the voices of one frame must not stay for the next.
    for _ in 0..2 {
        let items = ensemble.play(&instrument, &mono(&mid), Beat::default()).unwrap();
        assert_eq!(items.len(), 6);
        for item in items {
            assert!((moved(item)[0] - 0.05).abs() < 1e-6);
        }
    }
    let tried = ensemble
        .audition(&instrument, (&Mapping::rest(8, K), &Settings::default()), &mono(&mid), Beat::default())
        .unwrap();
    assert!((moved(&tried[0])[0] - 0.05).abs() < 1e-6);
    instrument.apply(now, Action::Perform { item: 2 }).unwrap();
    let staged = ensemble.play(&instrument, &mono(&mid), Beat::default()).unwrap();
    assert!(staged.len() == 1 && (moved(&staged[0])[0] - 0.05).abs() < 1e-6);
    let text = Show::of(&instrument).to_text().unwrap();
    assert_eq!(Show::from_text(&text).unwrap().replay(shape).unwrap(), instrument);
}

#[test]
fn voices_take_what_a_mapping_leaves_of_the_limit() {
    let (body, dancer) = ready();
    let shape = GalleryShape { eigenvalues: dancer.eigenvalues.clone(), bands: 8 };
    let mut instrument = Instrument::new(3, 6, shape).unwrap();
    let loud = VoiceSettings { driver: Driver::Mid, gain: 1.0 };
    instrument.apply(Moment::default(), Action::SetVoice { voice: 0, settings: loud }).unwrap();
    let length = |d: &[f64; 3]| d.iter().map(|x| x * x).sum::<f64>().sqrt();
    let farthest =
        |item: &Item| displacements_f64(body, item).unwrap().iter().map(length).fold(0.0, f64::max);
    let [low, high] = [f64::min, f64::max].map(|best: fn(f64, f64) -> f64| {
        let all = |axis: usize| body.positions.iter().map(|p| p[axis]).reduce(best).unwrap();
        [0, 1, 2].map(all)
    });
    let diagonal = length(&std::array::from_fn(|axis| high[axis] - low[axis]));
    let limit = f64::from(instrument.parameters().get(Parameter::Limit)) * diagonal;
    let mut ensemble = Ensemble::new(dancer.clone()).with_voices(vec![shift([10.0, 0.0, 0.0])]).unwrap();
    let mut most = 0.0_f64;
    for (gain, mid) in [(0.0, [1.0; 8]), (1.0, [0.5; 8]), (2.0, [1.0; 8])] {
        let action = Action::Set { parameter: Parameter::Gain, value: gain };
        instrument.apply(Moment::default(), action).unwrap();
        for item in ensemble.play(&instrument, &mono(&mid), Beat::default()).unwrap() {
            let own = Item { terms: item.terms[..item.terms.len() - 1].to_vec() };
            let (own, together) = (farthest(&own), farthest(item));
            assert!(together > 0.9 * limit && together < 1.1 * limit, "{own} {together} {limit}");
            most = most.max(own);
        }
    }
    // Both at their limit would go twice as far.
    assert!(most > 0.3 * limit, "{most} {limit}");
}

#[test]
fn voices_leave_out_what_a_slow_machine_does() {
    let (_, dancer) = ready();
    let shape = GalleryShape { eigenvalues: dancer.eigenvalues.clone(), bands: 8 };
    let mut instrument = Instrument::new(3, 6, shape).unwrap();
    let loud = VoiceSettings { driver: Driver::Mid, gain: 1.0 };
    instrument.apply(Moment::default(), Action::SetVoice { voice: 0, settings: loud }).unwrap();
    let layer = Term { coefficients: Coefficients::Vector(vec![[0.001; 3]; K]), ..shift([0.0; 3]) };
    let mut ensemble = Ensemble::new(dancer.clone()).with_voices(vec![layer]).unwrap();
    let mid = [0.5; 8];
    let mut loud_ones = |most: Option<u32>| {
        ensemble.use_at_most(most);
        let items = ensemble.play(&instrument, &mono(&mid), Beat::default()).unwrap();
        let Coefficients::Vector(c) = &items[0].terms.last().unwrap().coefficients else { panic!() };
        let loud = c.iter().rposition(|c| *c != [0.0; 3]).map_or(0, |last| last + 1);
        (loud, ensemble.harmonics_wanted())
    };
    assert_eq!(loud_ones(None), (K, K as u32));
    // All of a unison that the limit would part are left out.
    let mut reached = 0;
    for most in 1..K {
        let (loud, wanted) = loud_ones(Some(most as u32));
        assert!(loud <= most && wanted == K as u32, "{most}: {loud}, {wanted}");
        reached += usize::from(loud == most);
    }
    assert!(reached > 0);
    assert_eq!(loud_ones(None), (K, K as u32));
}

#[test]
fn only_harmonics_that_a_mapping_drives_are_wanted() {
    let (_, dancer) = ready();
    let shape = GalleryShape { eigenvalues: dancer.eigenvalues.clone(), bands: 8 };
    let mut instrument = Instrument::new(3, 6, shape).unwrap();
    let mut ensemble = Ensemble::new(dancer.clone());
    let low = Mapping { transfer: vec![0.4; 8], amplification: vec![1.0; K], ..Mapping::rest(8, K) };
    let mut wanted = |instrument: &Instrument, most: Option<u32>| {
        ensemble.use_at_most(most);
        let (mid, settings) = ([0.5; 8], Settings::default());
        ensemble.audition(instrument, (&low, &settings), &mono(&mid), Beat::default()).unwrap();
        ensemble.harmonics_wanted()
    };
    let of_low = wanted(&instrument, None);
    assert!((7..K as u32).contains(&of_low), "{of_low}");
    // The limit of the machine does not change what is wanted; that of the person does.
    assert_eq!(wanted(&instrument, Some(3)), of_low);
    instrument.apply(Moment::default(), Action::SetHarmonics { harmonics: 4 }).unwrap();
    assert_eq!(wanted(&instrument, None), 4);
}

proptest! {
    #[test]
    fn no_sound_pushes_voices_beyond_the_limit(
        mid in prop::collection::vec(0.0f32..50.0, 8), gain in -10.0f32..10.0, limit in 0.01f32..1.0)
    {
        let dancer = &ready().1;
        let settings = VoiceSettings { driver: Driver::Mid, gain };
        let mut voices =
            Voices::new(vec![Voice { term: shift([0.3, 0.1, 0.0]), settings }], dancer, limit).unwrap();
        let mut item = voices.item();
        voices.play(&mono(&mid), Beat::default(), &mut item).unwrap();
        let d = moved(&item);
        let length = d.iter().map(|c| c * c).sum::<f64>().sqrt();
        prop_assert!(length <= f64::from(limit * dancer.box_diagonal) * 1.000_01);
    }
}
