//! `chladni-bench breeding`: does it help to suggest children? A simulated person looks for a dance.

use chladni_music::{
    Action, Describer, Descriptor, Form, Gallery, GalleryShape, Instrument, Moment, Moments, Playing, suggest,
};
use chladni_program::cli::Terminal;
use chladni_program::work::Error;
use clap::Args;
use rayon::prelude::*;
use serde::Serialize;

use crate::music::gallery::ITEMS;
use crate::music::ready::Ready;

/// Bands of sound.
const BANDS: usize = 64;
/// How many items the person clicks in each generation.
const CLICKS: usize = 3;
/// Shares of the distance of the nearest one in the first gallery, within which a dance is to come.
const NEARER: [f32; 3] = [0.9, 0.8, 0.7];
/// A person gives up after this many generations.
const PATIENCE: usize = 40;
/// Generations after which it is reported how near the nearest dance so far is.
const REPORTED: [usize; 8] = [1, 2, 3, 5, 8, 12, 20, 40];

/// Let a simulated person look for hidden dances of the octopus by clicking, in each generation, the three that are
/// nearest: with the paper's breeding, and with suggested children.
#[derive(Args)]
pub struct BenchBreeding {
    /// Hidden dances that are looked for.
    #[arg(long, default_value_t = 50)]
    targets: usize,
    /// Print JSON instead of lines.
    #[arg(long)]
    json: bool,
}

/// The paper's breeding beside the suggestions.
#[derive(Serialize)]
struct Found {
    shape: String,
    targets: usize,
    /// The least distance between two of twelve children, median over targets and generations.
    least_distance: [f32; 2],
    /// After how many generations …
    after: [usize; REPORTED.len()],
    /// … the nearest dance so far is how far from the target, as a share of the distance of the nearest one in the
    /// first gallery; median over targets.
    distance: [[f32; 2]; REPORTED.len()],
    /// Of these shares …
    nearer: [f32; NEARER.len()],
    /// … how many generations it takes to reach each, median over targets; those not reached count as 40.
    generations: [[f32; 2]; NEARER.len()],
    /// How many targets reached it.
    found: [[usize; 2]; NEARER.len()],
}

impl BenchBreeding {
    /// Measures and reports.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        let found = measure(&Ready::sample("octopus", terminal)?, self.targets)?;
        if self.json {
            return terminal.json(&found);
        }
        let [paper, suggested] = found.least_distance;
        terminal.result(format_args!(
            "{} targets on the {}: least distance of twelve {paper:.3} by the paper, {suggested:.3} suggested",
            found.targets, found.shape
        ))?;
        for (after, [paper, suggested]) in found.after.iter().zip(found.distance) {
            terminal
                .result(format_args!("after {after} generations {paper:.2} and {suggested:.2} as far"))?;
        }
        for (nearer, [paper, suggested]) in found.nearer.iter().zip(found.generations) {
            terminal.result(format_args!("{nearer} as far after {paper} and {suggested} generations"))?;
        }
        Ok(())
    }
}

fn measure(octopus: &Ready, targets: usize) -> Result<Found, Error> {
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
    let each = |of: &dyn Fn(&Run) -> f32| [0, 1].map(|way| median(runs.iter().map(|run| of(&run[way]))));
    let of = |way: usize| runs.iter().map(move |run| &run[way]);
    Ok(Found {
        shape: octopus.name.clone(),
        targets,
        least_distance: [0, 1].map(|way| median(of(way).flat_map(|run| run.least_distances.iter().copied()))),
        after: REPORTED,
        distance: REPORTED.map(|after| each(&|run| run.nearest_after(after))),
        nearer: NEARER,
        generations: NEARER.map(|share| each(&|run| run.generations_to(share) as f32)),
        found: NEARER.map(|share| {
            [0, 1].map(|way| of(way).filter(|run| run.generations_to(share) < PATIENCE).count())
        }),
    })
}

struct Run {
    /// How far the nearest dance of each generation is from the target.
    nearest: Vec<f32>,
    least_distances: Vec<f32>,
}

impl Run {
    /// The nearest of all so far, as a share of the nearest in the beginning.
    fn nearest_after(&self, generations: usize) -> f32 {
        self.nearest.iter().take(generations + 1).copied().fold(f32::MAX, f32::min) / self.nearest[0]
    }

    fn generations_to(&self, share: f32) -> usize {
        self.nearest.iter().position(|at| *at <= share * self.nearest[0]).unwrap_or(PATIENCE)
    }
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

/// Clicks what is nearest to the target, and breeds.
fn look_for(
    ready: &Ready,
    describer: &Describer,
    target: &Descriptor,
    seed: u64,
    suggests: bool,
) -> Result<Run, Error> {
    let mut instrument = instrument(ready, seed)?;
    let mut run = Run { nearest: Vec::new(), least_distances: Vec::new() };
    for generation in 0..=PATIENCE {
        let shown = describe(instrument.gallery(), describer)?;
        if generation > 0 {
            run.least_distances.push(least_distance(&shown));
        }
        let distances: Vec<f32> = shown.iter().map(|item| item.distance(target)).collect();
        let mut order: Vec<usize> = (0..ITEMS).collect();
        order.sort_by(|&i, &j| distances[i].total_cmp(&distances[j]));
        run.nearest.push(distances[order[0]]);
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
