//! Plans the slices from the counting function N(λ), sampled by inertia.

use chladni_task::Task;
use rayon::prelude::*;

use super::problem::{Problem, Profile};
use super::window::Stopped;
use crate::ldlt::{Factor, Workspace};

/// The number of eigenpairs per slice that is aimed at.
const PER_SLICE: usize = 84;
/// Up to this many slices, the factors of the first counts are kept for them.
pub(crate) const KEPT: usize = 8;
/// How far counts may differ from equal shares if slices are to start where the counts were taken.
const UNEVEN: f64 = 0.12;
/// How far a count may be from the line between its neighbors, in slices, before the eigenvalues are
/// assumed to come in clumps (0.02 to 0.09 on ordinary shapes, 0.28 to 0.43 on spheres).
const CLUMPED: f64 = 0.2;
/// A part of the spectrum that is narrower than this share of its place is a single multiple eigenvalue.
const NARROW: f64 = 1e-4;
/// Number of counts taken in parallel in each round. It is not the number of threads, because the plan must
/// not depend on that.
const PROBES: usize = 4;

/// A shift, and what to find around it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slice {
    pub shift: f64,
    /// The slice's own part of the spectrum. 0 is the lower end of the first slice.
    pub low: f64,
    pub high: f64,
    /// The expected number of eigenvalues in it.
    pub expected: usize,
    /// The number of eigenvalues below each end, if counted.
    pub ends: Option<(usize, usize)>,
    /// Whether this is the last slice, which continues until it knows λ_K and a gap above it.
    pub top: bool,
}

/// Slices that cover the `harmonics` smallest eigenvalues, with the factors at their shifts if planning
/// computed them and memory is not short (`frugal`).
pub(super) fn plan(
    problem: &Problem,
    harmonics: usize,
    frugal: bool,
    profile: &mut Profile,
    task: &Task,
) -> Result<Vec<(Slice, Option<Factor>)>, Stopped> {
    let zeros = problem.zeros;
    // Two more than requested, which gives the top slice pairs on both sides of λ_K.
    let wanted = (harmonics.max(zeros) + 2) as f64;
    let slices = slices(harmonics.saturating_sub(zeros));
    let step = (wanted - zeros as f64) / slices as f64;
    let mut counting = Counting(vec![(0.0, zeros as f64)]);
    if slices <= KEPT {
        // Weyl's law is often so accurate that slices can start where it says.
        let shifts: Vec<f64> = (0..slices).map(|i| weyl(problem, step * (i as f64 + 0.5))).collect();
        let factors = sample(problem, &shifts, !frugal, &mut counting, profile)?;
        if let Some(slices) = counting.slices_between(wanted, step) {
            return Ok(slices.into_iter().zip(factors).collect());
        }
    }
    count(problem, &mut counting, wanted, profile, task)?;
    let at = |count: f64| counting.inverse(count);
    let mut bounds: Vec<f64> = (0..=slices).map(|i| at(zeros as f64 + step * i as f64)).collect();
    bounds[0] = 0.0;
    let mut below = vec![None; slices + 1];
    if counting.roughness() > CLUMPED * step {
        // To find a pair beyond each end, a run would have to resolve whole clumps there, at twice the
        // cost. It gets the counts instead.
        let mut counted = Counting(vec![(0.0, zeros as f64)]);
        sample(problem, &bounds[1..slices], false, &mut counted, profile)?;
        counted.0.push((bounds[slices], wanted));
        below = counted.0.iter().map(|&(_, count)| Some(count as usize)).collect();
    }
    let planned = (0..slices).map(|i| {
        let shift = at(zeros as f64 + step * (i as f64 + 0.5));
        let (low, high, ends) = (bounds[i], bounds[i + 1], below[i].zip(below[i + 1]));
        let expected = ends.map_or(step.ceil() as usize, |(low, high)| high.saturating_sub(low));
        Slice { shift, low, high, expected, ends, top: i + 1 == slices }
    });
    Ok(at_a_jump(planned.collect()).into_iter().map(|slice| (slice, None)).collect())
}

/// The `slices` without those that a multiple eigenvalue reaches through: the slice below takes all of it, from a
/// shift well below it.
fn at_a_jump(mut slices: Vec<Slice>) -> Vec<Slice> {
    let is_narrow = |slice: &Slice, from: f64| slice.high - from < NARROW * slice.high;
    let whole: usize = slices.iter().map(|slice| slice.expected).sum();
    let first = (1..slices.len()).find(|&i| is_narrow(&slices[i], slices[i].low)).unwrap_or(slices.len());
    let reaches_through = first < slices.len();
    let high = slices.last().map_or(0.0, |slice| slice.high);
    slices.truncate(first);
    let below: usize = slices.iter().rev().skip(1).map(|slice| slice.expected).sum();
    if let Some(top) = slices.last_mut()
        && (reaches_through || is_narrow(top, top.shift))
    {
        let shift = top.low + 0.9 * (top.high - top.low);
        *top = Slice { shift, high, expected: whole - below, ends: None, top: true, ..*top };
    }
    slices
}

/// The number of slices for this number of pairs.
pub(super) fn slices(pairs: usize) -> usize {
    let slices = pairs.div_ceil(PER_SLICE).max(1);
    if slices > 2 { slices.next_multiple_of(4) } else { slices }
}

/// Samples (λ, N(λ)), ascending in both, beginning with (0, number of zeros).
struct Counting(Vec<(f64, f64)>);

impl Counting {
    /// The λ where N reaches `count`: linear between the samples and beyond the last one.
    fn inverse(&self, count: f64) -> f64 {
        let samples = &self.0;
        let next = samples.partition_point(|s| s.1 < count).clamp(1, samples.len() - 1);
        let (a, b) = (samples[next - 1], samples[next]);
        if b.1 > a.1 { a.0 + (b.0 - a.0) * (count - a.1) / (b.1 - a.1) } else { b.0 }
    }

    /// N(λ): linear between the samples and beyond the last one.
    fn at(&self, lambda: f64) -> f64 {
        let samples = &self.0;
        let next = samples.partition_point(|s| s.0 < lambda).clamp(1, samples.len() - 1);
        let (a, b) = (samples[next - 1], samples[next]);
        if b.0 > a.0 { a.1 + (b.1 - a.1) * (lambda - a.0) / (b.0 - a.0) } else { b.1 }
    }

    /// The largest distance of a sample from the line between its neighbors.
    fn roughness(&self) -> f64 {
        let off = |w: &[(f64, f64)]| {
            (w[1].1 - w[0].1 - (w[2].1 - w[0].1) * (w[1].0 - w[0].0) / (w[2].0 - w[0].0)).abs()
        };
        self.0.windows(3).map(off).fold(0.0, f64::max)
    }

    /// One slice around each sample after the first, if not many more than `step` eigenvalues lie between
    /// samples and half as many below the first and above the last.
    fn slices_between(&self, wanted: f64, step: f64) -> Option<Vec<Slice>> {
        let (&(zero, zeros), samples) = self.0.split_first()?;
        let last = samples.last()?;
        let few = |count: f64, share: f64| count > 0.1 * step && count - share <= UNEVEN * step;
        let even = samples.windows(2).all(|w| few(w[1].1 - w[0].1, step));
        if !even || !few(samples[0].1 - zeros, 0.5 * step) || !few(wanted - last.1, 0.5 * step) {
            return None;
        }
        let bound = |i: usize| match i {
            0 => zero,
            _ if i == samples.len() => self.inverse(wanted),
            _ => 0.5 * (samples[i - 1].0 + samples[i].0),
        };
        let slice = |i: usize| {
            let top = i + 1 == samples.len();
            let (low, high) = (bound(i), bound(i + 1));
            let expected = (self.at(high.max(low)) - self.at(low)).ceil() as usize;
            Slice { shift: samples[i].0, low, high, expected, ends: None, top }
        };
        Some((0..samples.len()).map(slice).collect())
    }
}

/// The λ below which Weyl's law puts `count` eigenvalues: N(λ) ≈ λ area / 4π.
fn weyl(problem: &Problem, count: f64) -> f64 {
    4.0 * std::f64::consts::PI * count / problem.area
}

/// Samples N(λ) until it is known beyond `wanted` and densely enough to interpolate.
fn count(
    problem: &Problem,
    counting: &mut Counting,
    wanted: f64,
    profile: &mut Profile,
    task: &Task,
) -> Result<(), Stopped> {
    let n = problem.matrix.size() as f64;
    let mut top = match counting.0[..] {
        // Extrapolates through the last sample, and a little beyond.
        [.., (lambda, count)] if lambda > 0.0 => lambda * (1.05 * wanted / count.max(1.0)).clamp(1.02, 4.0),
        _ => weyl(problem, wanted),
    };
    for _ in 0..60 {
        task.check()?;
        let known = counting.0.last().map_or(0.0, |s| s.1);
        if known >= wanted {
            break;
        }
        let from = counting.0.last().map_or(0.0, |s| s.0);
        let probes: Vec<f64> =
            (1..=PROBES).map(|i| from + (top - from) * (i as f64 / PROBES as f64).powf(0.8)).collect();
        sample(problem, &probes, false, counting, profile)?;
        let (last, reached) = counting.0.last().copied().unwrap_or((top, n));
        // In proportion to the missing pairs, within bounds.
        let grow = ((wanted + 2.0) / reached.max(1.0)).clamp(1.02, 4.0);
        top = last * (1.0 + 1.3 * (grow - 1.0));
    }
    // If a quarter of all wanted pairs lies between two samples, N is not known well enough there to place
    // cuts.
    for _ in 0..8 {
        task.check()?;
        let coarse = (wanted * 0.3).max(PER_SLICE as f64);
        let mut gaps: Vec<(f64, f64)> = counting
            .0
            .windows(2)
            .filter(|w| w[0].1 < wanted && w[1].1 - w[0].1 > coarse && w[1].0 > w[0].0 * (1.0 + 1e-6))
            .map(|w| (w[1].1 - w[0].1, 0.5 * (w[0].0 + w[1].0)))
            .collect();
        if gaps.is_empty() {
            break;
        }
        gaps.sort_by(|a, b| b.0.total_cmp(&a.0));
        let probes: Vec<f64> = gaps.iter().take(PROBES).map(|g| g.1).collect();
        sample(problem, &probes, false, counting, profile)?;
    }
    Ok(())
}

/// The counts at each of `probes`, or just beside it, and the factors there if they are to be kept,
/// ascending in λ.
fn sample(
    problem: &Problem,
    probes: &[f64],
    keep: bool,
    counting: &mut Counting,
    profile: &mut Profile,
) -> Result<Vec<Option<Factor>>, Stopped> {
    type Sample = (f64, usize, Option<Factor>, Profile);
    let found: Vec<Result<Sample, Stopped>> = probes
        .par_iter()
        .with_max_len(1)
        .map(|&probe| {
            let mut profile = Profile::default();
            let (lambda, factor) = factor_beside(problem, probe, &mut profile)?;
            Ok((lambda, factor.below_shift, keep.then_some(factor), profile))
        })
        .collect();
    let mut found = found.into_iter().collect::<Result<Vec<Sample>, Stopped>>()?;
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut factors = Vec::with_capacity(found.len());
    for (lambda, below, factor, part) in found {
        profile.add(&part);
        counting.0.push((lambda, below as f64));
        factors.push(factor);
    }
    counting.0.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(factors)
}

/// The number of eigenvalues below `lambda`, or slightly beside it if `lambda` is an eigenvalue.
pub(super) fn inertia(
    problem: &Problem,
    lambda: f64,
    profile: &mut Profile,
) -> Result<(f64, usize), Stopped> {
    factor_beside(problem, lambda, profile).map(|(at, factor)| (at, factor.below_shift))
}

fn factor_beside(problem: &Problem, lambda: f64, profile: &mut Profile) -> Result<(f64, Factor), Stopped> {
    let (mut factor, mut workspace) = (Factor::default(), Workspace::default());
    let mut at = lambda;
    if super::lanczos::factor_near(problem, &mut at, lambda * 1e-9, &mut factor, &mut workspace, profile) {
        Ok((at, factor))
    } else {
        Err(Stopped::BadShift)
    }
}
