//! One slice: the runs around its shift, and the pairs that they found.

use chladni_task::Task;

use super::lanczos::{self, factor_near};
use super::plan::{Slice, inertia};
use super::polish::polish;
use super::problem::{Problem, Profile};
use super::tall::BLOCK;
use super::window::{Pairs, Reach, Stopped, Window};
use super::{CLUSTER, Wanted};
use crate::ldlt::{Factor, Workspace};
use crate::{Certificate, HarmonicsError};

/// The largest number of shifts that are tried for one slice.
const ATTEMPTS: u32 = 4;
/// ‖S h − λ M h‖ / ‖S h‖ that a run must reach; otherwise its shift is moved.
const GOOD_RESIDUAL: f64 = 0.5 * Certificate::RESIDUAL;

/// One slice: its shift, its count, and the pairs found so far (one entry per run).
pub(super) struct Found {
    pub slice: Slice,
    pub below_shift: usize,
    pub runs: Vec<Pairs>,
    /// Only for the top slice: a λ in the gap above all wanted eigenvalues, once known, and the number of
    /// eigenvalues below it.
    pub top_count: Option<(f64, usize)>,
    next_seed: u64,
}

/// A pair of one slice.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub value: f64,
    pub slice: usize,
    pub run: usize,
    pub column: usize,
}

impl Entry {
    /// A λ just above its group of equal eigenvalues.
    pub fn just_above(&self) -> f64 {
        self.value * (1.0 + 3.0 * CLUSTER)
    }
}

/// A run around one shift, whose pairs have not been checked yet.
pub(super) struct Tried {
    attempt: u32,
    pairs: Pairs,
    /// The factor at the run's shift.
    factor: Factor,
    from_zero: bool,
}

impl Found {
    /// A slice with its first run done, if that succeeded.
    pub fn begin(
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

    /// Returns the slice with accepted pairs, after its first run.
    pub fn finish(
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

    /// The slice with its vectors where they are `wanted`.
    pub fn kept(mut self, wanted: Wanted) -> Result<Self, HarmonicsError> {
        for pairs in &mut self.runs {
            pairs.blocks.move_to(wanted.keep).map_err(|e| wanted.keep.refused(&e))?;
        }
        Ok(self)
    }

    /// Searches for pairs that no run has found yet, starting with attempt number `first`. The top slice
    /// searches until it knows `count` eigenvalues of the whole problem.
    pub fn search(
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

    /// One run. `None` if the shift was bad and has been moved. `made` is the factor at the slice's shift,
    /// if it exists already.
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
            // Pairs are identified by their side of the shift: a moved shift starts over.
            self.runs.clear();
        }
        self.slice.shift = shift;
        self.below_shift = factor.below_shift;
        let window = self.window(problem.zeros, count);
        let locked: Vec<&Pairs> = self.runs.iter().collect();
        self.next_seed = self.next_seed.wrapping_add(1);
        let (seed, careful) = (self.next_seed, attempt > 1 || !locked.is_empty());
        match lanczos::run(problem, &factor, shift, &window, &locked, seed, careful, profile, task) {
            Ok(pairs) => Ok(Some(Tried { attempt, pairs, factor, from_zero: window.from_zero })),
            Err(Stopped::BadShift) => {
                // Too close to an eigenvalue: move the shift and start over.
                self.runs.clear();
                self.slice.shift += width * 0.003 * f64::from(attempt);
                Ok(None)
            }
            Err(other) => Err(other),
        }
    }

    /// Accepts the pairs of a run, polished if needed, if they are good enough or no attempt is left;
    /// otherwise moves the shift.
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
        // A shift close to many eigenvalues, or a small pivot far from any, costs digits.
        self.runs.clear();
        let (shift, width) = (self.slice.shift, self.slice.high - self.slice.low);
        self.slice.shift = quiet_place(&pairs.values, shift, 0.25 * width, attempt as usize)
            .unwrap_or(shift + width * 0.011 * f64::from(attempt));
        if self.slice.shift > self.slice.high {
            // Far more eigenvalues than are wanted may lie below such a place.
            self.slice.shift = shift - 0.05 * width;
        }
        false
    }

    /// For the top slice: the middle of the first gap at or above K, at which joining will request a count.
    pub fn gap_above(&self, harmonics: usize) -> Option<f64> {
        if !self.slice.top {
            return None;
        }
        let (_, above) = self.sides(0);
        let from = harmonics.checked_sub(self.below_shift)?.max(1);
        (from..above.len())
            .map(|i| (above[i - 1].value, above[i].value))
            .find(|(below, above)| above - below > CLUSTER * above)
            .map(|(below, above)| 0.5 * (below + above))
    }

    /// The pairs below and above the shift, each ascending.
    pub fn sides(&self, slice: usize) -> (Vec<Entry>, Vec<Entry>) {
        let mut all: Vec<Entry> = Vec::new();
        for (run, pairs) in self.runs.iter().enumerate() {
            all.extend(pairs.values.iter().enumerate().map(|(column, &value)| Entry {
                value,
                slice,
                run,
                column,
            }));
        }
        all.sort_by(|a, b| a.value.total_cmp(&b.value));
        let split = all.partition_point(|e| e.value < self.slice.shift);
        let above = all.split_off(split);
        (all, above)
    }

    fn window(&self, zeros: usize, count: usize) -> Window {
        let slice = &self.slice;
        let known = |below: bool| {
            let values = self.runs.iter().flat_map(|r| &r.values);
            values.filter(|l| (**l < slice.shift) == below).count()
        };
        let from_zero = slice.low == 0.0;
        // A search for missing pairs also looks beyond the ends.
        let ends = slice.ends.filter(|_| self.runs.is_empty());
        let below = if from_zero {
            Reach::Count(self.below_shift.saturating_sub(zeros + known(true)))
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

/// A place near `shift` to which it can be moved: the nearest point to `shift` in the middle half of a gap
/// between `values`. `number` selects the gap by width, from 1 for the widest. Gaps farther away than
/// `reach`, and the gap in whose middle `shift` already is, are skipped.
pub(super) fn quiet_place(values: &[f64], shift: f64, reach: f64, number: usize) -> Option<f64> {
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

/// The largest ‖S h − λ M h‖ / ‖S h‖, measured rather than estimated.
pub(super) fn largest_residual(problem: &Problem, pairs: &Pairs) -> f64 {
    let mut largest = 0.0_f64;
    for (block, values) in pairs.blocks.iter().zip(pairs.values.chunks(BLOCK)) {
        let mut row = [0.0; 8];
        row[..values.len()].copy_from_slice(values);
        let [_, weighted, image] = problem.residuals(block, &row);
        for ((error, size), _) in weighted.iter().zip(&image).zip(values) {
            let share = (error / size).sqrt();
            largest = if share.is_nan() { f64::INFINITY } else { largest.max(share) };
        }
    }
    largest
}
