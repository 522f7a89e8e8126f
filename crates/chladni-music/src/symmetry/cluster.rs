//! Derives classes from a mirror: how it acts on each harmonic, and on groups of repeated ones.

use std::ops::Range;

use chladni_harmonics::{Basis, Body, canonical};
use chladni_mesh::{OnSurface, symmetric_eigen_of};
use chladni_task::Task;
use rayon::prelude::*;

use super::{Class, SymmetrySettings, first_waving};
use crate::MusicError;

/// How the harmonics of one repeated eigenvalue are mixed: `H'_j = Σ_i H_i mix[i][j]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Rotation {
    /// The first harmonic of the group.
    pub first: usize,
    /// An orthogonal matrix, one row per old and one column per new harmonic.
    pub mix: Vec<Vec<f64>>,
}

impl Rotation {
    /// Mixes the group in `basis`. Does nothing if the basis has too few harmonics.
    pub fn apply(&self, basis: &mut Basis) {
        let (n, size) = (basis.vertices(), self.mix.len());
        let Some(group) = basis.vectors.get_mut(self.first * n..(self.first + size) * n) else { return };
        let mut old = vec![0.0; size];
        for v in 0..n {
            for (i, old) in old.iter_mut().enumerate() {
                *old = group[i * n + v];
            }
            for j in 0..size {
                group[j * n + v] = (0..size).map(|i| old[i] * self.mix[i][j]).sum();
            }
        }
    }
}

/// The class of each harmonic, and its ⟨H_k, H_k∘T⟩ / (‖H_k‖ ‖H_k∘T‖).
type Classified = Vec<(Class, f64)>;

/// Classifies the harmonics, after each group of repeated eigenvalues has been
/// rotated such that the mirror acts on each of its harmonics as +1 or −1.
pub(super) fn mirrored(
    body: &Body,
    image: &[OnSurface],
    settings: &SymmetrySettings,
    task: &Task,
) -> Result<(Classified, Vec<Rotation>), MusicError> {
    let basis = &*body.basis;
    let groups = repeated(basis, settings.cluster_gap);
    let found: Vec<(Classified, Option<Rotation>)> = groups
        .into_par_iter()
        .map(|group| {
            task.check()?;
            let is_last = group.end == basis.harmonics();
            let settings = if is_last { settings.of_last() } else { *settings };
            let (scores, rotation) = classify(body, image, group, &settings);
            Ok((scores.into_iter().map(|score| (settings.class(score), score)).collect(), rotation))
        })
        .collect::<Result<_, MusicError>>()?;
    let mut classified = Vec::with_capacity(basis.harmonics());
    let mut rotations = Vec::new();
    for (of_group, rotation) in found {
        classified.extend(of_group);
        rotations.extend(rotation);
    }
    Ok((classified, rotations))
}

/// The rotation of each group of repeated eigenvalues without a mirror: it is determined by the geometry
/// alone.
pub(super) fn unmirrored(
    body: &Body,
    settings: &SymmetrySettings,
    task: &Task,
) -> Result<Vec<Rotation>, MusicError> {
    let first = first_waving(&body.basis.eigenvalues);
    repeated(&body.basis, settings.cluster_gap)
        .into_par_iter()
        .filter(|group| group.start >= first && group.len() > 1)
        .map(|group| {
            task.check()?;
            let size = group.len();
            let as_they_are =
                (0..size).map(|i| (0..size).map(|j| f64::from(u8::from(i == j))).collect()).collect();
            let mix = choose_within_classes(body, &group, &vec![1.0; size], as_they_are, settings);
            Ok(Rotation { first: group.start, mix })
        })
        .collect()
}

/// The most members of a group all of which agree within the gap: the tones of a ball have 2l + 1, here to l = 31.
const LARGEST: usize = 64;
/// The most members of a group that agree only from one to the next: longer runs are a crowded spectrum rather than
/// repeated eigenvalues.
const LONGEST_RUN: usize = 24;

/// Ranges of harmonics whose neighboring eigenvalues have a relative difference below `gap`. The constant
/// harmonics of a shape with several components form such a range. Ranges that are too long are divided.
pub(crate) fn repeated(basis: &Basis, gap: f64) -> Vec<Range<usize>> {
    let constant = first_waving(&basis.eigenvalues);
    let lambda = &basis.eigenvalues;
    let joins = |k: usize| k < constant || (k > constant && lambda[k] - lambda[k - 1] < gap * lambda[k]);
    let mut groups: Vec<Range<usize>> = Vec::new();
    let mut start = 0;
    for end in 1..=basis.harmonics() {
        if end == basis.harmonics() || !joins(end) {
            divide(start..end, lambda, gap, &mut groups);
            start = end;
        }
    }
    groups
}

/// Adds `run` to `groups`, in as many parts as it needs. It is cut where neighbors differ most, because harmonics of
/// exactly one eigenvalue are in no order that the shape determines.
fn divide(run: Range<usize>, lambda: &[f64], gap: f64, groups: &mut Vec<Range<usize>>) {
    let mut waiting = vec![run];
    while let Some(part) = waiting.pop() {
        let (least, greatest) = (lambda[part.start], lambda[part.end - 1]);
        // Constants, whose eigenvalues are all 0, agree, too.
        let most = if greatest - least <= gap * greatest { LARGEST } else { LONGEST_RUN };
        if part.len() <= most {
            groups.push(part);
            continue;
        }
        // Where all differ by as much, as constants do by nothing, the first part is as long as it may be.
        let usual = part.start + most;
        let step = |k: usize| (lambda[k] - lambda[k - 1]) / lambda[k].max(f64::MIN_POSITIVE);
        let nearer = |a: usize, b: usize| b.abs_diff(usual).cmp(&a.abs_diff(usual));
        let cut = (part.start + 1..part.end)
            .max_by(|&a, &b| step(a).total_cmp(&step(b)).then(nearer(a, b)))
            .unwrap_or(usual);
        waiting.extend([cut..part.end, part.start..cut]);
    }
}

fn classify(
    body: &Body,
    image: &[OnSurface],
    group: Range<usize>,
    settings: &SymmetrySettings,
) -> (Vec<f64>, Option<Rotation>) {
    let basis = &*body.basis;
    let size = group.len();
    let images: Vec<Vec<f64>> = group
        .clone()
        .map(|k| {
            let h = basis.harmonic(k);
            image.iter().map(|(v, w)| (0..3).map(|i| w[i] * h[v[i] as usize]).sum()).collect()
        })
        .collect();
    let inner =
        |f: &[f64], g: &[f64]| -> f64 { f.iter().zip(g).zip(&basis.mass).map(|((f, g), a)| a * f * g).sum() };
    // ‖H_k∘T‖ falls below 1 where the mirror image misses the shape. Dividing by it keeps that from
    // counting as asymmetry.
    let norms: Vec<f64> = images.iter().map(|h| inner(h, h).sqrt().max(f64::MIN_POSITIVE)).collect();
    let mut matrix = vec![vec![0.0; size]; size];
    for i in 0..size {
        for j in 0..size {
            matrix[i][j] = inner(basis.harmonic(group.start + i), &images[j]) / norms[j];
        }
    }
    if size == 1 {
        return (vec![matrix[0][0].clamp(-1.0, 1.0)], None);
    }
    let symmetric: Vec<Vec<f64>> =
        (0..size).map(|i| (0..size).map(|j| 0.5 * (matrix[i][j] + matrix[j][i])).collect()).collect();
    let (values, vectors) = symmetric_eigen_of(symmetric.clone());
    let mix = (0..size).map(|i| vectors.iter().map(|vector| vector[i]).collect()).collect();
    let mix = choose_within_classes(body, &group, &values, mix, settings);
    let score = |j: usize| -> f64 {
        let image = |i: usize| (0..size).map(|l| symmetric[i][l] * mix[l][j]).sum::<f64>();
        (0..size).map(|i| mix[i][j] * image(i)).sum()
    };
    let scores = (0..size).map(|j| score(j).clamp(-1.0, 1.0)).collect();
    (scores, Some(Rotation { first: group.start, mix }))
}

/// Within one class, the columns of `mix` are still an arbitrary basis; the geometry determines it, as for
/// the harmonics of one eigenvalue.
fn choose_within_classes(
    body: &Body,
    group: &Range<usize>,
    values: &[f64],
    mix: Vec<Vec<f64>>,
    settings: &SymmetrySettings,
) -> Vec<Vec<f64>> {
    let basis = &*body.basis;
    let mut chosen = mix.clone();
    let mut start = 0;
    for class in values.chunk_by(|a, b| settings.class(*a) == settings.class(*b)) {
        let columns = start..start + class.len();
        start = columns.end;
        let mixed = |j: usize| {
            let rows = mix.iter().zip(group.clone());
            let mut h = vec![0.0; basis.vertices()];
            for (row, k) in rows {
                h.iter_mut().zip(basis.harmonic(k)).for_each(|(h, old)| *h += row[j] * old);
            }
            h
        };
        if class.len() < 2 {
            continue;
        }
        let vectors: Vec<f64> = columns.clone().flat_map(mixed).collect();
        let Some(turn) = canonical::mix(&vectors, &basis.mass, &body.positions) else { continue };
        for (chosen, row) in chosen.iter_mut().zip(&mix) {
            for (to, j) in columns.clone().enumerate() {
                chosen[j] = columns.clone().enumerate().map(|(from, i)| row[i] * turn[(from, to)]).sum();
            }
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use chladni_harmonics::{Certificate, Laplacian, Values};

    use super::*;

    fn sizes(eigenvalues: Vec<f64>) -> Vec<usize> {
        let certificate = Certificate {
            laplacian: Laplacian::Delaunay,
            inertia_counts_match: Some(true),
            max_relative_residual: 0.0,
            max_orthogonality_error: 0.0,
        };
        let count = eigenvalues.len();
        let basis = Basis { eigenvalues, vectors: Values::default(), mass: Vec::new(), certificate };
        let groups = repeated(&basis, SymmetrySettings::default().cluster_gap);
        let ends = groups.iter().map(|group| group.end);
        assert!(groups.iter().map(|group| group.start).eq(std::iter::once(0).chain(ends).take(groups.len())));
        assert_eq!(groups.last().map_or(0, |group| group.end), count);
        groups.into_iter().map(|group| group.len()).collect()
    }

    /// Eigenvalues that grow from 100 by these shares, in thousandths.
    fn growing(steps: impl IntoIterator<Item = f64>) -> Vec<f64> {
        let grown = steps.into_iter().scan(100.0, |value, step| {
            *value *= 1.0 + 1e-3 * step;
            Some(*value)
        });
        [0.0, 100.0].into_iter().chain(grown).collect()
    }

    #[test]
    fn the_tones_of_a_ball_are_whole_groups() {
        // 2l + 1 harmonics of l (l + 1), a little apart as on any mesh.
        let tone = |l: usize| {
            let exact = (l * (l + 1)) as f64;
            (0..=2 * l).map(move |m| exact * (1.0 + 8e-4 * m as f64 / (2 * l + 1) as f64))
        };
        let ball: Vec<f64> = (0..=31).flat_map(tone).collect();
        assert_eq!(ball.len(), 1024);
        assert_eq!(sizes(ball), (0..=31).map(|l| 2 * l + 1).collect::<Vec<usize>>());
    }

    #[test]
    fn a_crowded_spectrum_is_cut_where_it_is_widest() {
        assert_eq!(sizes(growing([0.5; 23])), [1, 24]);
        let wider = |at: usize| (0..39).map(move |i| if i == at { 0.9 } else { 0.5 });
        assert_eq!(sizes(growing(wider(17))), [1, 18, 22]);
        // Equal ones stay together: 24 would cut the second ten.
        let tens = (1..40).map(|i| if i % 10 == 0 { 0.5 } else { 0.0 });
        assert!(sizes(growing(tens)).iter().skip(1).all(|size| size % 10 == 0));
        assert!(sizes(growing([0.5; 500])).into_iter().all(|size| size <= LONGEST_RUN));
    }

    #[test]
    fn constants_are_a_group_of_their_own() {
        let of = |zeros: usize| sizes([vec![0.0; zeros], vec![1.0, 1.0, 2.0]].concat());
        assert_eq!(of(3), [3, 2, 1]);
        assert_eq!(of(30), [30, 2, 1]);
        assert_eq!(of(70), [64, 6, 2, 1]);
        assert!(sizes(Vec::new()).is_empty());
    }
}
