//! The paper's fast test (section 5b): extrema, pairs with the nearest signatures, and the vote.

use std::borrow::Cow;
use std::ops::Range;

use chladni_harmonics::{Basis, Body};
use chladni_mesh::vertex_neighbors;

use super::{SymmetrySettings, first_waving, repeated};

/// The smallest number of extrema that must remain.
const LEAST_KEPT: usize = 8;
/// H_i ≈ ±H_j if |H_i ∓ H_j| is at most this share of |H_i| + |H_j|.
const ALIKE: f64 = 0.2;

/// The vertices that are extrema of many harmonics, and the pairs among them that look alike.
pub(super) struct Extrema {
    /// For each vertex, of how many of the first n_k harmonics it is an extremum.
    pub counts: Vec<u8>,
    pub vertices: Vec<u32>,
    pub pairs: Vec<[u32; 2]>,
}

impl Extrema {
    pub(super) fn of(body: &Body, settings: &SymmetrySettings) -> Self {
        let basis = &*body.basis;
        let n = basis.vertices();
        let tones = tones(basis, settings);
        let neighbors = vertex_neighbors(n, &body.triangles);
        let mut counts = vec![0u8; n];
        for tone in &tones {
            for (v, count) in counts.iter_mut().enumerate() {
                if tone.is_extremum(v, neighbors.row(v)) {
                    *count = count.saturating_add(tone.harmonics.len() as u8);
                }
            }
        }
        let least = (1..=settings.least_extrema.clamp(1, 255))
            .rev()
            .find(|&c| counts.iter().filter(|&&x| usize::from(x) >= c).count() >= LEAST_KEPT)
            .unwrap_or(1);
        let vertices: Vec<u32> =
            (0..n).filter(|&v| usize::from(counts[v]) >= least).map(|v| v as u32).collect();
        let pairs = pairs(&vertices, &tones);
        Self { counts, vertices, pairs }
    }

    /// For each harmonic, (pairs with H_i ≈ H_j minus pairs with H_i ≈ −H_j) / pairs. The harmonics of a
    /// repeated eigenvalue vote together, where H_i is the row of their values at i.
    pub(super) fn vote(&self, basis: &Basis, settings: &SymmetrySettings) -> Vec<f64> {
        let first = first_waving(&basis.eigenvalues);
        let mut scores = vec![1.0; first];
        for group in repeated(basis, settings.cluster_gap).into_iter().filter(|group| group.start >= first) {
            let norm = |f: &dyn Fn(&[f64]) -> f64| {
                group.clone().map(|k| f(basis.harmonic(k)).powi(2)).sum::<f64>().sqrt()
            };
            let votes: i64 = self
                .pairs
                .iter()
                .map(|p| {
                    let [a, b] = p.map(|v| v as usize);
                    let alike = ALIKE * (norm(&|h| h[a]) + norm(&|h| h[b]));
                    i64::from(norm(&|h| h[a] - h[b]) <= alike) - i64::from(norm(&|h| h[a] + h[b]) <= alike)
                })
                .sum();
            scores.extend(group.map(|_| votes as f64 / self.pairs.len().max(1) as f64));
        }
        scores
    }
}

/// The harmonics of one eigenvalue as a single function: one harmonic is used as it is; of several, the
/// norm of their values at a vertex, which does not depend on the choice of basis.
struct Tone<'a> {
    harmonics: Range<usize>,
    values: Cow<'a, [f64]>,
    eigenvalue: f64,
}

impl Tone<'_> {
    fn is_extremum(&self, v: usize, ring: &[u32]) -> bool {
        let h = &self.values;
        let least = ring.iter().all(|&w| h[w as usize] > h[v]);
        let most = ring.iter().all(|&w| h[w as usize] < h[v]);
        // The norm of several harmonics has no meaningful minimum.
        !ring.is_empty() && (most || (least && self.harmonics.len() == 1))
    }
}

/// The first n_k non-constant harmonics, and further ones that repeat the eigenvalue of the last.
fn tones<'a>(basis: &'a Basis, settings: &SymmetrySettings) -> Vec<Tone<'a>> {
    let first = first_waving(&basis.eigenvalues);
    let last = first + settings.signature_harmonics.min(255);
    repeated(basis, settings.cluster_gap)
        .into_iter()
        .filter(|group| (first..last).contains(&group.start))
        .map(|group| {
            let values = match group.len() {
                1 => Cow::Borrowed(basis.harmonic(group.start)),
                _ => (0..basis.vertices())
                    .map(|v| group.clone().map(|k| basis.harmonic(k)[v].powi(2)).sum::<f64>().sqrt())
                    .collect(),
            };
            Tone { eigenvalue: basis.eigenvalues[group.start], harmonics: group, values }
        })
        .collect()
}

/// Pairs of `vertices` whose absolute GPS signatures |H_k(i)| / √λ_k are mutually nearest.
fn pairs(vertices: &[u32], tones: &[Tone<'_>]) -> Vec<[u32; 2]> {
    let signatures: Vec<Vec<f64>> = vertices
        .iter()
        .map(|&v| tones.iter().map(|tone| tone.values[v as usize].abs() / tone.eigenvalue.sqrt()).collect())
        .collect();
    let distance = |i: usize, j: usize| -> f64 {
        signatures[i].iter().zip(&signatures[j]).map(|(a, b)| (a - b).powi(2)).sum()
    };
    let nearest: Vec<Option<usize>> = (0..vertices.len())
        .map(|i| {
            (0..vertices.len()).filter(|&j| j != i).min_by(|&a, &b| distance(i, a).total_cmp(&distance(i, b)))
        })
        .collect();
    let mut pairs: Vec<[u32; 2]> = Vec::new();
    for (i, &j) in nearest.iter().enumerate() {
        // Mutually nearest: the paper asks only for "closest", which lets one odd vertex pair with anything.
        if let Some(j) = j
            && i < j
            && nearest[j] == Some(i)
        {
            pairs.push([vertices[i], vertices[j]]);
        }
    }
    pairs
}
