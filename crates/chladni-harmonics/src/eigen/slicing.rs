//! All slices solved side by side, joined, and mended where their counts do not agree.

use std::sync::{Mutex, PoisonError};

use chladni_task::{Stage, Task};
use rayon::prelude::*;

use super::join::{Join, Known};
use super::lanczos::{self, Pairs, Reach, Stopped, Window, factor_near};
use super::plan::{Slice, inertia, plan};
use super::polish::polish;
use super::problem::{Pencil, Problem, Profile, ZEROS};
use super::tall::{BLOCK, residuals};
use super::{Solved, assemble};
use crate::ldlt::{Factor, Workspace};
use crate::{Certificate, HarmonicsError};

/// Runs beyond the first that a slice gets before the solve is given up.
const REPAIRS: usize = 100;

/// Shifts that are tried for one slice.
const ATTEMPTS: u32 = 4;
/// ‖S h − λ M h‖ / ‖S h‖ that a run must reach, or its shift is moved.
const GOOD_RESIDUAL: f64 = 0.5 * Certificate::RESIDUAL;

/// One slice's shift, its count, and the pairs found so far (one entry per run).
pub(super) struct Found {
    pub slice: Slice,
    pub below_shift: usize,
    pub runs: Vec<Pairs>,
    /// Of the top slice: a λ in the gap above all that is wanted, as far as it can tell, and
    /// the number of eigenvalues below.
    top_count: Option<(f64, usize)>,
    next_seed: u64,
}

/// Solves for the first `harmonics` pairs of `problem`, which is of `pencil`.
pub(super) fn solve(
    problem: &Problem,
    pencil: Pencil,
    harmonics: usize,
    whole_clusters: bool,
    stage: &Stage,
    task: &Task,
) -> Result<Solved, HarmonicsError> {
    let mut profile = Profile::default();
    let start = std::time::Instant::now();
    let slices = plan(problem, harmonics, &mut profile, task).map_err(told)?;
    profile.plan = start.elapsed().as_secs_f64();
    // Of the stage, so much for each slice and the rest for assembling.
    let (share, count) = (harmonics / (slices.len() + 1), slices.len());
    // The lowest slice has the most to do, as a rule, and the top one comes next.
    let mut queue: Vec<_> = slices.into_iter().enumerate().collect();
    queue[1..].reverse();
    type Finished = Result<(Found, Profile), Stopped>;
    let found: Mutex<Vec<(usize, Finished)>> = Mutex::default();
    let store = |place: usize, finished: Finished| {
        stage.advance(share as u64);
        found.lock().unwrap_or_else(PoisonError::into_inner).push((place, finished));
    };
    let store = &store;
    rayon::scope(|scope| {
        queue.into_iter().par_bridge().for_each(|(place, (slice, factor))| {
            let mut profile = Profile::default();
            let begun = Found::begin(problem, slice, factor, harmonics, &mut profile, task);
            let finish = move || {
                let found = begun
                    .and_then(|(found, tried)| found.finish(problem, tried, harmonics, &mut profile, task));
                store(place, found.map(|found| (found, profile)));
            };
            // Polishing is left to the first thread that finds no slice to begin.
            if place == 0 { scope.spawn(move |_| finish()) } else { finish() }
        });
    });
    let mut found = found.into_inner().unwrap_or_else(PoisonError::into_inner);
    found.sort_by_key(|(place, _)| *place);
    let mut slices = Vec::with_capacity(found.len());
    for (_, found) in found {
        let (found, part) = found.map_err(told)?;
        profile.add(&part);
        slices.push(found);
    }
    let known = mend(problem, &mut slices, harmonics, &mut profile, task)?;
    problem.free_spare_blocks();
    let keep = if whole_clusters { known.cluster_end } else { harmonics };
    let cuts_cluster = keep < known.cluster_end;
    let start = std::time::Instant::now();
    let basis = assemble::assemble(problem, pencil, slices, &known, keep, task)?;
    profile.assemble = start.elapsed().as_secs_f64();
    stage.advance((harmonics - share * count) as u64);
    Ok(Solved { basis, cuts_cluster, fell_back_to_dense: false, profile })
}

pub(super) fn told(stopped: Stopped) -> HarmonicsError {
    match stopped {
        Stopped::Cancelled => HarmonicsError::Cancelled(chladni_task::Cancelled),
        Stopped::BadShift => not_certified("no shift near the planned one could be factored"),
        Stopped::Exhausted => not_certified("the Krylov space was used up before all pairs had converged"),
    }
}

pub(super) fn not_certified(reason: impl Into<String>) -> HarmonicsError {
    HarmonicsError::NotCertified { reason: reason.into() }
}

/// A run around one shift, whose pairs are yet to be looked at.
struct Tried {
    attempt: u32,
    pairs: Pairs,
    /// Of the run's shift.
    factor: Factor,
    from_zero: bool,
}

impl Found {
    /// A slice with its first run made, if that came to something.
    fn begin(
        problem: &Problem,
        slice: Slice,
        factor: Option<Factor>,
        harmonics: usize,
        profile: &mut Profile,
        task: &Task,
    ) -> Result<(Self, Option<Tried>), Stopped> {
        let next_seed = slice.shift.to_bits();
        let mut found = Self { slice, below_shift: 0, runs: Vec::new(), top_count: None, next_seed };
        let tried = found.attempt(problem, factor, 1, harmonics + 1, profile, task)?;
        Ok((found, tried))
    }

    /// The slice with good pairs, after its first run.
    fn finish(
        mut self,
        problem: &Problem,
        tried: Option<Tried>,
        harmonics: usize,
        profile: &mut Profile,
        task: &Task,
    ) -> Result<Self, Stopped> {
        if !tried.is_some_and(|tried| self.accept(problem, tried, profile)) {
            self.search(problem, 2, harmonics + 1, profile, task)?;
        }
        if let Some(gap) = self.gap_above(harmonics) {
            self.top_count = Some(inertia(problem, gap, profile)?);
        }
        Ok(self)
    }

    /// Looks for pairs that no run has found yet, beginning with the attempt of number `first`.
    /// The top slice looks until it knows `count` eigenvalues of the whole problem.
    fn search(
        &mut self,
        problem: &Problem,
        first: u32,
        count: usize,
        profile: &mut Profile,
        task: &Task,
    ) -> Result<(), Stopped> {
        for attempt in first..=ATTEMPTS {
            if let Some(tried) = self.attempt(problem, None, attempt, count, profile, task)?
                && self.accept(problem, tried, profile)
            {
                return Ok(());
            }
        }
        Err(Stopped::BadShift)
    }

    /// One run; `None` where the shift was bad, and is moved. `made` is the factor at the slice's
    /// shift, if there is one.
    fn attempt(
        &mut self,
        problem: &Problem,
        made: Option<Factor>,
        attempt: u32,
        count: usize,
        profile: &mut Profile,
        task: &Task,
    ) -> Result<Option<Tried>, Stopped> {
        let width = self.slice.high - self.slice.low;
        let mut shift = self.slice.shift;
        let factor = if let Some(made) = made {
            made
        } else {
            let (mut factor, mut workspace) = (Factor::default(), Workspace::default());
            if !factor_near(problem, &mut shift, width * 1e-5, &mut factor, &mut workspace, profile) {
                return Err(Stopped::BadShift);
            }
            factor
        };
        if shift != self.slice.shift {
            // Pairs are told apart by their side of the shift: a moved shift starts anew.
            self.runs.clear();
        }
        self.slice.shift = shift;
        self.below_shift = factor.below_shift;
        let window = self.window(count);
        let locked: Vec<&Pairs> = self.runs.iter().collect();
        self.next_seed = self.next_seed.wrapping_add(1);
        let (seed, careful) = (self.next_seed, attempt > 1 || !locked.is_empty());
        match lanczos::run(problem, &factor, shift, &window, &locked, seed, careful, profile, task) {
            Ok(pairs) => Ok(Some(Tried { attempt, pairs, factor, from_zero: window.from_zero })),
            Err(Stopped::BadShift) => {
                // On or beside an eigenvalue: step aside and start anew.
                self.runs.clear();
                self.slice.shift += width * 0.003 * f64::from(attempt);
                Ok(None)
            }
            Err(other) => Err(other),
        }
    }

    /// Takes in the pairs of a run, polished where need be, if they are good enough or there is
    /// no attempt left; else moves the shift.
    fn accept(&mut self, problem: &Problem, tried: Tried, profile: &mut Profile) -> bool {
        let Tried { attempt, mut pairs, factor, from_zero } = tried;
        let mut residual = largest_residual(problem, &pairs);
        if from_zero && residual > GOOD_RESIDUAL {
            pairs = polish(problem, pairs, factor, profile);
            residual = largest_residual(problem, &pairs);
        }
        if residual <= GOOD_RESIDUAL || attempt == ATTEMPTS {
            self.runs.push(pairs);
            return true;
        }
        // A shift beside many eigenvalues, or a small pivot far from any, costs digits.
        self.runs.clear();
        let (shift, width) = (self.slice.shift, self.slice.high - self.slice.low);
        self.slice.shift = quiet_place(&pairs.values, shift, 0.25 * width, attempt as usize)
            .unwrap_or(shift + width * 0.011 * f64::from(attempt));
        false
    }

    fn window(&self, count: usize) -> Window {
        let slice = &self.slice;
        let known = |below: bool| {
            let values = self.runs.iter().flat_map(|r| &r.values);
            values.filter(|l| (**l < slice.shift) == below).count()
        };
        let from_zero = slice.low == 0.0;
        // Whoever looks for what another run has missed looks beyond the ends.
        let ends = slice.ends.filter(|_| self.runs.is_empty());
        let below = if from_zero {
            Reach::Count(self.below_shift.saturating_sub(ZEROS + known(true)))
        } else {
            ends.map_or(Reach::Beyond(slice.low), |(low, _)| {
                Reach::Count(self.below_shift.saturating_sub(low).max(1))
            })
        };
        let above = if slice.top {
            Reach::Count(count.saturating_sub(self.below_shift + known(false)))
        } else {
            ends.map_or(Reach::Beyond(slice.high), |(_, high)| {
                Reach::Count(high.saturating_sub(self.below_shift).max(1))
            })
        };
        let expected = if self.runs.is_empty() { slice.expected } else { slice.expected / 2 };
        Window { below, above, from_zero, width: slice.high - slice.low, expected }
    }
}

/// The place nearest to `shift` in the middle half of the widest gap between `values`, or, by its
/// `number` from 1, of another one in order of width. Gaps further than `reach`, and the one that
/// `shift` is in the middle of, do not count.
fn quiet_place(values: &[f64], shift: f64, reach: f64, number: usize) -> Option<f64> {
    let mut gaps: Vec<(f64, f64)> = values
        .windows(2)
        .map(|pair| {
            let width = pair[1] - pair[0];
            (width, shift.max(pair[0] + 0.25 * width).min(pair[1] - 0.25 * width))
        })
        .filter(|(_, place)| *place != shift && (place - shift).abs() <= reach)
        .collect();
    gaps.sort_by(|a, b| b.0.total_cmp(&a.0));
    gaps.get(number.checked_sub(1)?).map(|gap| gap.1)
}

/// Largest ‖S h − λ M h‖ / ‖S h‖, as measured rather than estimated.
fn largest_residual(problem: &Problem, pairs: &Pairs) -> f64 {
    let mut largest = 0.0_f64;
    for (block, values) in pairs.blocks.iter().zip(pairs.values.chunks(BLOCK)) {
        let mut row = [0.0; 8];
        row[..values.len()].copy_from_slice(values);
        let [_, weighted, image] = residuals(&problem.matrix, block, &row, &problem.mass);
        for ((error, size), _) in weighted.iter().zip(&image).zip(values) {
            let share = (error / size).sqrt();
            largest = if share.is_nan() { f64::INFINITY } else { largest.max(share) };
        }
    }
    largest
}

/// Joins the slices, searching again wherever a count says that a pair is missing.
fn mend(
    problem: &Problem,
    slices: &mut [Found],
    harmonics: usize,
    profile: &mut Profile,
    task: &Task,
) -> Result<Known, HarmonicsError> {
    let mut top_count = slices.last().and_then(|top| top.top_count);
    for repair in 0..REPAIRS {
        task.check()?;
        match Join::of(slices, harmonics, top_count) {
            Join::Whole(known) => return Ok(known),
            Join::NeedsCount(at) => {
                top_count = Some(inertia(problem, at, profile).map_err(told)?);
            }
            Join::NeedsMore => {
                let last = slices.len() - 1;
                slices[last].search(problem, 1, harmonics + 8 * (repair + 1), profile, task).map_err(told)?;
            }
            Join::Missing(below, above) => {
                // The two slices beside the place, in turn.
                let which = if repair % 2 == 0 { below } else { above };
                slices[which].search(problem, 1, harmonics + 1, profile, task).map_err(told)?;
                top_count = None;
            }
        }
    }
    Err(not_certified(format!("after {REPAIRS} searches the counts of eigenvalues still disagree")))
}

#[cfg(test)]
#[path = "slicing_tests.rs"]
mod tests;
