//! Solves all slices in parallel, joins them, and repairs those whose counts do not agree.

use std::sync::{Mutex, PoisonError};

use chladni_task::{Stage, Task};
use rayon::prelude::*;

use super::found::Found;
use super::join::{Join, Known};
use super::plan::{inertia, plan};
use super::problem::{Problem, Profile};
use super::{Solved, Wanted, assemble};
use crate::platform::Instant;
use crate::{HarmonicsError, Pencil};

/// The largest number of extra runs before the solve is given up.
const REPAIRS: usize = 100;
/// How often the end of a group of equal eigenvalues is not reached before it is counted how large it is.
const PATIENCE: usize = 3;

/// Solves for the first pairs of `problem`, which belongs to `pencil`.
pub(super) fn solve(
    problem: &Problem,
    pencil: Pencil,
    wanted: Wanted,
    stage: &Stage,
    task: &Task,
) -> Result<Solved, HarmonicsError> {
    let harmonics = wanted.harmonics;
    let mut profile = Profile::default();
    let start = Instant::now();
    let slices = plan(problem, harmonics, wanted.frugal, &mut profile, task)?;
    profile.plan = start.elapsed().as_secs_f64();
    // Progress: an equal share for each slice, and the rest for assembling.
    let (share, count) = (harmonics / (slices.len() + 1), slices.len());
    // The lowest slice usually takes longest, and the top one comes next.
    let mut queue: Vec<_> = slices.into_iter().enumerate().collect();
    queue[1..].reverse();
    type Finished = Result<(Found, Profile), HarmonicsError>;
    let found: Mutex<Vec<(usize, Finished)>> = Mutex::default();
    let store = |place: usize, finished: Finished| {
        stage.advance(share as u64);
        found.lock().unwrap_or_else(PoisonError::into_inner).push((place, finished));
    };
    let store = &store;
    let queue = Mutex::new(queue.into_iter());
    let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
    rayon::scope(|scope| {
        let solve = |(place, (slice, factor))| {
            let mut profile = Profile::default();
            let begun = Found::begin(problem, slice, factor, harmonics, &mut profile, task);
            let finish = move || {
                if wanted.frugal {
                    problem.free_spare_blocks();
                }
                let found = begun
                    .and_then(|(found, tried)| found.finish(problem, tried, harmonics, &mut profile, task));
                let kept = found.map_err(HarmonicsError::from).and_then(|found| found.kept(wanted));
                store(place, kept.map(|found| (found, profile)));
            };
            // Polishing is left to the first thread that finds no slice left to begin, if there is memory
            // for what waits.
            if place == 0 && !wanted.frugal { scope.spawn(move |_| finish()) } else { finish() }
        };
        // Not as many as there are threads: where none can be started, there may be more than memory is for.
        let one_after_the_other = |_| std::iter::from_fn(next).for_each(solve);
        (0..wanted.at_once).into_par_iter().with_max_len(1).for_each(one_after_the_other);
    });
    let mut found = found.into_inner().unwrap_or_else(PoisonError::into_inner);
    found.sort_by_key(|(place, _)| *place);
    let mut slices = Vec::with_capacity(found.len());
    for (_, found) in found {
        let (found, part) = found?;
        profile.add(&part);
        slices.push(found);
    }
    let known = mend(problem, &mut slices, harmonics, wanted.most, &mut profile, task)?;
    problem.free_spare_blocks();
    let keep = wanted.kept(known.cluster_end);
    let cuts_cluster = keep < known.cluster_end || known.is_cut;
    let start = Instant::now();
    let basis =
        assemble::assemble(problem, pencil, slices, &known, Wanted { harmonics: keep, ..wanted }, task)?;
    profile.assemble = start.elapsed().as_secs_f64();
    stage.advance((harmonics - share * count) as u64);
    Ok(Solved { basis, cuts_cluster, fell_back_to_dense: false, short_of_memory: None, profile })
}

/// Joins the slices, and searches again wherever a count shows that a pair is missing. The group of the K-th
/// eigenvalue is found as a whole unless it reaches beyond `most` pairs.
fn mend(
    problem: &Problem,
    slices: &mut [Found],
    harmonics: usize,
    most: usize,
    profile: &mut Profile,
    task: &Task,
) -> Result<Known, HarmonicsError> {
    let mut top_count = slices.last().and_then(|top| top.top_count);
    let (mut lacking, mut is_cut) = (0, false);
    for repair in 0..REPAIRS {
        task.check()?;
        let join = if is_cut { Join::within_group } else { Join::of };
        match join(slices, problem.zeros, harmonics, top_count) {
            Join::Whole(known) => {
                // The group may end just at K.
                let is_cut = match known.entries.last().filter(|_| known.is_cut) {
                    Some(last) => inertia(problem, last.just_above(), profile)?.1 > known.cluster_end,
                    None => false,
                };
                return Ok(Known { is_cut, ..known });
            }
            Join::NeedsCount(at) => {
                top_count = Some(inertia(problem, at, profile)?);
            }
            Join::NeedsMore => {
                let last = slices.len() - 1;
                lacking += 1;
                if lacking == PATIENCE
                    && let Some(end) = Join::end(slices, problem.zeros)
                    && inertia(problem, end, profile)?.1 > most
                {
                    (is_cut, top_count) = (true, None);
                    continue;
                }
                slices[last].search(problem, 1, harmonics + 8 * (repair + 1), profile, task)?;
            }
            Join::Missing(below, above) => {
                // The two slices beside the place, alternately.
                let which = if repair % 2 == 0 { below } else { above };
                slices[which].search(problem, 1, harmonics + 1, profile, task)?;
                top_count = None;
            }
        }
    }
    Err(HarmonicsError::not_certified(format!(
        "after {REPAIRS} searches the counts of eigenvalues still disagree"
    )))
}

#[cfg(test)]
#[path = "slicing_tests.rs"]
mod tests;
