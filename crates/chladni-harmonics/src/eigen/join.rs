//! Joins the pairs of all slices to one ascending list in which inertia proves each position.

use super::CLUSTER;
use super::found::{Entry, Found};

/// The pairs with the numbers 1 … `cluster_end` − 1 of the whole problem.
#[derive(Debug)]
pub(super) struct Known {
    pub entries: Vec<Entry>,
    /// The first position at or after K where neighboring eigenvalues differ.
    pub cluster_end: usize,
    /// Whether it ends there only because the group is too large, as far as is known.
    pub is_cut: bool,
}

/// The outcome of joining.
pub(super) enum Join {
    /// All counts agree.
    Whole(Known),
    /// The number of eigenvalues below this λ must be determined.
    NeedsCount(f64),
    /// The top slice must find more pairs.
    NeedsMore,
    /// A pair is missing or doubled between these two slices (or within one of them, if they are equal).
    Missing(usize, usize),
}

impl Join {
    /// Joins the `slices` of a problem with `zeros` eigenvalues that are known beforehand. `top` is a λ
    /// above all wanted eigenvalues and the number of eigenvalues below it, once known.
    pub(super) fn of(slices: &[Found], zeros: usize, harmonics: usize, top: Option<(f64, usize)>) -> Self {
        let mut entries = match joined(slices, zeros) {
            Ok(entries) => entries,
            Err(fault) => return fault,
        };
        let value = |index: usize| value(&entries, zeros, index);
        let known = zeros + entries.len();
        let Some(cluster_end) = (harmonics..known).find(|&e| value(e) - value(e - 1) > CLUSTER * value(e))
        else {
            return Self::NeedsMore;
        };
        let (below, above) = (value(cluster_end - 1), value(cluster_end));
        match top {
            Some((lambda, count)) if lambda > below && lambda < above => {
                if count != cluster_end {
                    return Self::Missing(slices.len() - 1, slices.len() - 1);
                }
                entries.truncate(cluster_end - zeros);
                Self::Whole(Known { entries, cluster_end, is_cut: false })
            }
            _ => Self::NeedsCount(0.5 * (below + above)),
        }
    }

    /// Like [`of`](Self::of), for a group of equal eigenvalues around the K-th that is too large to be found whole.
    /// `bottom` is a λ just below the group and the number of eigenvalues below it, once known: of those none is
    /// missing, and any pairs of the group itself will do.
    pub(super) fn within_group(
        slices: &[Found],
        zeros: usize,
        harmonics: usize,
        bottom: Option<(f64, usize)>,
    ) -> Self {
        let mut entries = match joined(slices, zeros) {
            Ok(entries) => entries,
            Err(fault) => return fault,
        };
        if zeros + entries.len() < harmonics || harmonics <= zeros {
            return Self::NeedsMore;
        }
        let value = |index: usize| value(&entries, zeros, index);
        let is_gap = |e: usize| e == zeros || value(e) - value(e - 1) > CLUSTER * value(e);
        let start = (zeros..harmonics).rev().find(|e| is_gap(*e)).unwrap_or(zeros);
        let (first, last) = (value(start), value(harmonics - 1));
        if last - first > CLUSTER * last {
            // No group, but many eigenvalues in a row.
            return Self::NeedsMore;
        }
        let below = start.checked_sub(1).map_or(0.0, value);
        match bottom {
            Some((lambda, count)) if lambda > below && lambda < first => {
                if count != start {
                    return Self::Missing(slices.len() - 1, slices.len() - 1);
                }
                entries.truncate(harmonics - zeros);
                Self::Whole(Known { entries, cluster_end: harmonics, is_cut: true })
            }
            _ => Self::NeedsCount(first - (0.5 * (first - below)).min(10.0 * CLUSTER * first)),
        }
    }

    /// A λ just above all pairs that are known.
    pub(super) fn end(slices: &[Found], zeros: usize) -> Option<f64> {
        joined(slices, zeros).ok()?.last().map(Entry::just_above)
    }
}

/// λ number `index`, from 0.
fn value(entries: &[Entry], zeros: usize, index: usize) -> f64 {
    index.checked_sub(zeros).map_or(0.0, |i| entries[i].value)
}

/// The pairs above 0 that the counts at all shifts agree on, or the fault in them.
fn joined(slices: &[Found], zeros: usize) -> Result<Vec<Entry>, Join> {
    let sides: Vec<(Vec<Entry>, Vec<Entry>)> =
        slices.iter().enumerate().map(|(s, found)| found.sides(s)).collect();
    let (Some(first), Some(last)) = (sides.first(), sides.last()) else { return Err(Join::NeedsMore) };
    if zeros + first.0.len() != slices[0].below_shift {
        return Err(Join::Missing(0, 0));
    }
    let mut entries = first.0.clone();
    for s in 1..slices.len() {
        let Some(between) = slices[s].below_shift.checked_sub(slices[s - 1].below_shift) else {
            return Err(Join::Missing(s - 1, s));
        };
        match cut(&sides[s - 1].1, &sides[s].0, between) {
            Some(taken) => {
                entries.extend(&sides[s - 1].1[..taken]);
                entries.extend(&sides[s].0[sides[s].0.len() - (between - taken)..]);
            }
            None => return Err(Join::Missing(s - 1, s)),
        }
    }
    entries.extend(&last.1);
    Ok(entries)
}

/// How many of the `between` pairs between two shifts to take from the lower slice; the rest is taken from
/// the upper one. The cut falls into the widest gap between eigenvalues. `None` if no cut gives an
/// ascending list: then one of the slices lacks a pair, and lists that should overlap do not.
fn cut(lower: &[Entry], upper: &[Entry], between: usize) -> Option<usize> {
    let mut best: Option<(f64, usize)> = None;
    for taken in between.saturating_sub(upper.len())..=lower.len().min(between) {
        let below = taken.checked_sub(1).map(|i| lower[i].value);
        let above = upper.get(upper.len() - (between - taken)).map(|e| e.value);
        let gap = match (below, above) {
            (Some(below), Some(above)) if taken < between => above - below,
            // All pairs come from one side: then the first pair of the other side beyond the range must not
            // be one of them.
            (Some(below), _) if taken == between => {
                lower.get(taken).map_or(f64::MAX, |next| next.value) - below
            }
            (None, Some(above)) => {
                let before = upper.len() - between;
                above - before.checked_sub(1).map_or(f64::MIN, |i| upper[i].value)
            }
            _ => f64::MAX,
        };
        let width = above.or(below).unwrap_or(0.0).abs();
        if gap > 1e-9 * width && best.is_none_or(|(widest, _)| gap > widest) {
            best = Some((gap, taken));
        }
    }
    best.map(|(_, taken)| taken)
}
