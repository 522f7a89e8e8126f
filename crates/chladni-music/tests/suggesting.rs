//! The gallery that helps: children that differ and are like what was chosen.
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::sync::{Arc, OnceLock};

use chladni_harmonics::{BasisSettings, Body};
use chladni_mesh::{Orientation, samples};
use chladni_music::{
    Action, Bands, BreedingError, CANDIDATES, Dancer, Describer, Descriptor, Gallery, GalleryShape,
    Instrument, Mapping, Moment, Moments, MusicError, Playing, Symmetry, suggest,
};
use chladni_task::Task;

const BANDS: usize = 24;

fn dancer() -> Arc<Dancer> {
    static READY: OnceLock<Arc<Dancer>> = OnceLock::new();
    let make = || {
        let mesh = samples::sample("octopus").unwrap();
        let body = Body::build(&mesh, &BasisSettings::new(32), &Task::new()).unwrap();
        let symmetry = Symmetry::of(&body, &Task::new()).unwrap();
        let body = symmetry.rotated(&body);
        Arc::new(Dancer::new(&body, &symmetry.classes, &Orientation::default()).unwrap())
    };
    READY.get_or_init(make).clone()
}

fn instrument(seed: u64) -> (Instrument, Describer) {
    let shape = GalleryShape { eigenvalues: dancer().eigenvalues.clone(), bands: BANDS };
    let describer = Describer::new(dancer(), Playing::default(), Moments::of_anything(BANDS)).unwrap();
    (Instrument::new(seed, 12, shape).unwrap(), describer)
}

fn choose(instrument: &mut Instrument, items: &[usize]) {
    for &item in items {
        instrument.apply(Moment::default(), Action::Choose { item, on: true }).unwrap();
    }
}

fn least_distance(gallery: &Gallery, describer: &Describer) -> f32 {
    let all: Vec<Descriptor> =
        gallery.items().iter().map(|item| describer.describe(&item.genome).unwrap()).collect();
    let pairs = (0..all.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    pairs.map(|(i, j)| all[i].distance(&all[j])).fold(f32::MAX, f32::min)
}

#[test]
fn suggested_galleries_differ_more_than_bred_ones_and_repeat_from_their_numbers() {
    for seed in 1..4 {
        let (mut instrument, describer) = instrument(seed);
        choose(&mut instrument, &[0, 1, 2, 3, 4, 5]);
        instrument.apply(Moment::default(), Action::Lock { item: 2, on: true }).unwrap();
        let mut bred = instrument.clone();
        bred.apply(Moment::default(), Action::Breed).unwrap();
        let kept = instrument.gallery().items()[2].genome.clone();
        let candidates = suggest(instrument.gallery(), &describer).unwrap();
        assert_eq!(candidates, suggest(instrument.gallery(), &describer).unwrap());
        instrument.apply(Moment::default(), Action::BreedFrom { candidates }).unwrap();
        let [ours, theirs] = [&instrument, &bred].map(|i| least_distance(i.gallery(), &describer));
        assert!(ours > 2.0 * theirs, "seed {seed}: {ours} against {theirs}");
        assert_eq!(instrument.gallery().items()[2].genome, kept);
        let again = instrument.with_beats(|_| 0.0).unwrap();
        assert_eq!(again.gallery().items(), instrument.gallery().items());
    }
}

#[test]
fn the_best_suggestion_is_shown_where_the_first_place_is_locked() {
    let (mut instrument, describer) = instrument(1);
    choose(&mut instrument, &[3, 4, 5]);
    let best = suggest(instrument.gallery(), &describer).unwrap()[0];
    instrument.apply(Moment::default(), Action::Lock { item: 0, on: true }).unwrap();
    assert_eq!(suggest(instrument.gallery(), &describer).unwrap()[1], best);
}

/// A person who always clicks the most similar ones chooses twins, and twins have twins, which a preference likes
/// best.
#[test]
fn one_who_knows_what_they_want_is_shown_no_twins() {
    let (mut instrument, describer) = instrument(3);
    let wanted = describer.describe(&instrument.gallery().items()[7].genome).unwrap();
    for generation in 0..8 {
        let items = instrument.gallery().items().iter();
        let far: Vec<f32> =
            items.map(|item| describer.describe(&item.genome).unwrap().distance(&wanted)).collect();
        let mut nearest: Vec<usize> = (0..12).collect();
        nearest.sort_by(|&i, &j| far[i].total_cmp(&far[j]));
        choose(&mut instrument, &nearest[..3]);
        let candidates = suggest(instrument.gallery(), &describer).unwrap();
        instrument.apply(Moment::default(), Action::BreedFrom { candidates }).unwrap();
        let least = least_distance(instrument.gallery(), &describer);
        assert!(least > 0.05, "generation {generation}: {least}");
    }
}

#[test]
fn suggestions_come_nearer_to_what_is_chosen_and_preferences_are_forgotten() {
    let (mut instrument, describer) = instrument(5);
    let liked = instrument.gallery().items()[7].genome.clone();
    let liked = describer.describe(&liked).unwrap();
    let away = |gallery: &Gallery| -> f32 {
        let far =
            |item: &chladni_music::GalleryItem| describer.describe(&item.genome).unwrap().distance(&liked);
        gallery.items().iter().map(far).sum::<f32>() / gallery.items().len() as f32
    };
    let before = away(instrument.gallery());
    choose(&mut instrument, &[7]);
    assert_eq!(instrument.gallery().opinions().count(), 1);
    let candidates = suggest(instrument.gallery(), &describer).unwrap();
    instrument.apply(Moment::default(), Action::BreedFrom { candidates }).unwrap();
    assert!(away(instrument.gallery()) < before, "{} {before}", away(instrument.gallery()));
    assert_eq!(instrument.gallery().opinions().count(), 1);
    instrument.apply(Moment::default(), Action::ForgetPreference).unwrap();
    assert_eq!(instrument.gallery().opinions().count(), 0);
}

#[test]
fn numbers_that_are_no_candidates_are_refused() {
    let (mut instrument, describer) = instrument(5);
    assert!(matches!(
        suggest(instrument.gallery(), &describer),
        Err(MusicError::Breeding(BreedingError::NotEnoughParents(0)))
    ));
    choose(&mut instrument, &[3]);
    let mut apply = |candidates| instrument.apply(Moment::default(), Action::BreedFrom { candidates });
    assert!(apply(vec![0; 11]).is_err());
    assert!(apply(vec![CANDIDATES as u16; 12]).is_err());
    assert!(apply((0..12).collect()).is_ok());
}

#[test]
fn a_describer_needs_moments_and_equal_movements_are_at_distance_zero() {
    assert!(Describer::new(dancer(), Playing::default(), Moments::default()).is_err());
    let mut uneven = Moments::of_anything(BANDS);
    uneven.bands[1][2].pop();
    assert!(Describer::new(dancer(), Playing::default(), uneven).is_err());
    let short = Moments { side_gains: Vec::new(), ..Moments::of_anything(BANDS) };
    assert!(Describer::new(dancer(), Playing::default(), short).is_err());
    let (instrument, describer) = instrument(1);
    let mapping = &instrument.gallery().items()[0].genome;
    let described = describer.describe(mapping).unwrap();
    assert_eq!(described.distance(&describer.describe(mapping).unwrap()), 0.0);
    let rest = Mapping { amplification: vec![0.0; 32], ..mapping.clone() };
    assert!(described.distance(&describer.describe(&rest).unwrap()) > 0.0);
}

#[test]
fn each_moment_keeps_the_gain_of_its_side() {
    let level = [0.3; BANDS];
    let mut moments = Moments::default();
    let mut remember = |count: usize, side_gain: f32| {
        let [left, right, mid, side] = [&level[..count]; 4];
        moments.remember(&Bands { left, right, mid, side, side_gain, ringing: None });
        moments.side_gains.clone()
    };
    for gain in 1..=12_u8 {
        remember(BANDS, f32::from(gain));
    }
    let kept = remember(BANDS, 13.0);
    assert_eq!(kept, (2..=13_u8).map(f32::from).collect::<Vec<f32>>());
    assert_eq!(remember(BANDS / 2, 4.0), [4.0]);
}
