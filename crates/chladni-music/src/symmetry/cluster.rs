//! Derives classes from a mirror: how it acts on each harmonic, and on groups of repeated ones.

use std::ops::Range;

use chladni_harmonics::{Basis, Body, canonical};
use chladni_mesh::{OnSurface, symmetric_eigen_of};
use chladni_task::Task;
use rayon::prelude::*;

use super::{SymmetrySettings, first_waving};
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

/// ⟨H_k, H_k∘T⟩ / (‖H_k‖ ‖H_k∘T‖) for each harmonic, after each group of repeated eigenvalues has been
/// rotated such that the mirror acts on each of its harmonics as +1 or −1.
pub(super) fn mirrored(
    body: &Body,
    image: &[OnSurface],
    settings: &SymmetrySettings,
    task: &Task,
) -> Result<(Vec<f64>, Vec<Rotation>), MusicError> {
    let basis = &*body.basis;
    let groups = repeated(basis, settings.cluster_gap);
    let found: Vec<(Vec<f64>, Option<Rotation>)> = groups
        .into_par_iter()
        .map(|group| {
            task.check()?;
            Ok(classify(body, image, group, settings))
        })
        .collect::<Result<_, MusicError>>()?;
    let mut scores = Vec::with_capacity(basis.harmonics());
    let mut rotations = Vec::new();
    for (group_scores, rotation) in found {
        scores.extend(group_scores);
        rotations.extend(rotation);
    }
    Ok((scores, rotations))
}

/// The rotation of each group of repeated eigenvalues without a mirror: it is determined by the geometry
/// alone.
pub(super) fn unmirrored(
    body: &Body,
    settings: &SymmetrySettings,
    task: &Task,
) -> Result<Vec<Rotation>, MusicError> {
    let first = first_waving(&body.basis);
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

/// Ranges of harmonics whose neighboring eigenvalues have a relative difference below `gap`. The constant
/// harmonics of a shape with several components form such a range.
pub(crate) fn repeated(basis: &Basis, gap: f64) -> Vec<Range<usize>> {
    /// Larger groups are a crowded spectrum rather than repeated eigenvalues.
    const LARGEST: usize = 24;
    let constant = first_waving(basis);
    let lambda = &basis.eigenvalues;
    let mut groups: Vec<Range<usize>> = Vec::new();
    for k in 0..basis.harmonics() {
        let joins = k > 0 && (k < constant || (k > constant && lambda[k] - lambda[k - 1] < gap * lambda[k]));
        match groups.last_mut() {
            Some(last) if joins && last.len() < LARGEST => last.end = k + 1,
            _ => groups.push(k..k + 1),
        }
    }
    groups
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
