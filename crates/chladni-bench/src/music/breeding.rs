//! Does it help to suggest children? A simulated person looks for a dance.

use chladni_music::{
    Action, Describer, Descriptor, Form, Gallery, GalleryShape, Instrument, Moment, Moments, Playing, suggest,
};
use rayon::prelude::*;
use serde::Serialize;

use super::gallery::ITEMS;
use super::ready::Ready;
use chladni_program::work::Error;

/// Bands of sound.
const BANDS: usize = 64;
/// How many items the person clicks in each generation.
const CLICKS: usize = 3;
/// A target counts as found once an item is nearer to it than this share of the distance that the nearest
/// item of the initial gallery has.
const FOUND: f32 = 0.6;
/// A person gives up after this many generations.
const PATIENCE: usize = 40;

/// The paper's breeding beside the suggestions.
#[derive(Serialize)]
pub struct Found {
    pub shape: String,
    pub targets: usize,
    /// The least distance between two of twelve children, median over targets and generations.
    pub least_distance: [f32; 2],
    /// Generations until the target was found, median over targets; those not found count as 40.
    pub generations: [f32; 2],
    /// How many targets were found.
    pub found: [usize; 2],
}

/// Lets a person look for `targets` dances that can be bred from the gallery, on the octopus.
pub fn measure(octopus: &Ready, targets: usize) -> Result<Found, Error> {
    let playing = Playing { form: Form::default(), ..Playing::default() };
    let describer = Describer::new(octopus.dancer.clone(), playing, Moments::of_anything(BANDS))?;
    let runs: Vec<[Run; 2]> = (0..targets as u64)
        .into_par_iter()
        .map(|target| {
            let hidden = hidden(octopus, &describer, target)?;
            Ok([
                look_for(octopus, &describer, &hidden, target, false)?,
                look_for(octopus, &describer, &hidden, target, true)?,
            ])
        })
        .collect::<Result<_, Error>>()?;
    let of = |way: usize| runs.iter().map(move |run| &run[way]);
    Ok(Found {
        shape: octopus.name.clone(),
        targets,
        least_distance: [0, 1].map(|way| median(of(way).flat_map(|run| run.least_distances.iter().copied()))),
        generations: [0, 1].map(|way| median(of(way).map(|run| run.generations as f32))),
        found: [0, 1].map(|way| of(way).filter(|run| run.generations < PATIENCE).count()),
    })
}

struct Run {
    generations: usize,
    least_distances: Vec<f32>,
}

fn instrument(ready: &Ready, seed: u64) -> Result<Instrument, Error> {
    let shape = GalleryShape { eigenvalues: ready.dancer.eigenvalues.clone(), bands: BANDS };
    Ok(Instrument::new(seed, ITEMS, shape)?)
}

fn choose(instrument: &mut Instrument, items: impl IntoIterator<Item = usize>) -> Result<(), Error> {
    for item in items {
        instrument.apply(Moment::default(), Action::Choose { item, on: true })?;
    }
    Ok(())
}

/// A dance of the fourth generation of the same gallery, bred from others each time and changed a little: it can
/// be reached.
fn hidden(ready: &Ready, describer: &Describer, target: u64) -> Result<Descriptor, Error> {
    let mut other = instrument(ready, target)?;
    for generation in 0..3 {
        let first = (5 * target as usize + 7 * generation) % ITEMS;
        choose(&mut other, (0..CLICKS).map(|i| (first + 5 * i) % ITEMS))?;
        other.apply(Moment::default(), Action::Breed)?;
    }
    other.apply(Moment::default(), Action::Mutate { item: 0, amount: 0.1 })?;
    Ok(describer.describe(&other.gallery().items()[0].genome)?)
}

fn describe(gallery: &Gallery, describer: &Describer) -> Result<Vec<Descriptor>, Error> {
    Ok(gallery.items().iter().map(|item| describer.describe(&item.genome)).collect::<Result<_, _>>()?)
}

/// Clicks what is nearest to the target, and breeds, until it is found.
fn look_for(
    ready: &Ready,
    describer: &Describer,
    target: &Descriptor,
    seed: u64,
    suggests: bool,
) -> Result<Run, Error> {
    let mut instrument = instrument(ready, seed)?;
    let mut near_enough = None;
    let mut run = Run { generations: PATIENCE, least_distances: Vec::new() };
    for generation in 0..PATIENCE {
        let shown = describe(instrument.gallery(), describer)?;
        if generation > 0 {
            run.least_distances.push(least_distance(&shown));
        }
        let distances: Vec<f32> = shown.iter().map(|item| item.distance(target)).collect();
        let mut order: Vec<usize> = (0..ITEMS).collect();
        order.sort_by(|&i, &j| distances[i].total_cmp(&distances[j]));
        let nearest = distances[order[0]];
        if nearest <= *near_enough.get_or_insert(FOUND * nearest) {
            run.generations = generation;
            break;
        }
        choose(&mut instrument, order.into_iter().take(CLICKS))?;
        let action = match suggests {
            true => Action::BreedFrom { candidates: suggest(instrument.gallery(), describer)? },
            false => Action::Breed,
        };
        instrument.apply(Moment::default(), action)?;
    }
    Ok(run)
}

fn least_distance(all: &[Descriptor]) -> f32 {
    let pairs = (0..all.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    pairs.map(|(i, j)| all[i].distance(&all[j])).fold(f32::MAX, f32::min)
}

fn median(values: impl Iterator<Item = f32>) -> f32 {
    let mut sorted: Vec<f32> = values.collect();
    sorted.sort_by(f32::total_cmp);
    let at = |i: usize| sorted.get(i).copied().unwrap_or(f32::NAN);
    0.5 * (at(sorted.len().saturating_sub(1) / 2) + at(sorted.len() / 2))
}
