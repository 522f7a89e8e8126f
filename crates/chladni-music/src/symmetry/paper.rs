//! The paper's fast test (section 5b): extrema, pairs of nearest signature, and the vote.

use chladni_harmonics::{Basis, Body};
use chladni_mesh::vertex_neighbors;

use super::{SymmetrySettings, first_waving};

/// At least this many extrema must remain.
const LEAST_KEPT: usize = 8;
/// H_i ≈ ±H_j where |H_i ∓ H_j| is at most this share of |H_i| + |H_j|.
const ALIKE: f64 = 0.2;

/// The extrema that many harmonics share, and which of them look alike.
pub(super) struct Extrema {
    /// For how many of the first n_k harmonics each vertex is an extremum.
    pub counts: Vec<u8>,
    pub vertices: Vec<u32>,
    pub pairs: Vec<[u32; 2]>,
}

impl Extrema {
    pub(super) fn of(body: &Body, settings: &SymmetrySettings) -> Self {
        let basis = &*body.basis;
        let n = basis.vertices();
        let first = first_waving(basis);
        let last = (first + settings.signature_harmonics.min(255)).min(basis.harmonics());
        let neighbors = vertex_neighbors(n, &body.triangles);
        let mut counts = vec![0u8; n];
        for k in first..last {
            let h = basis.harmonic(k);
            for (v, count) in counts.iter_mut().enumerate() {
                let ring = neighbors.row(v);
                let is_extremum = !ring.is_empty()
                    && (ring.iter().all(|&w| h[w as usize] < h[v])
                        || ring.iter().all(|&w| h[w as usize] > h[v]));
                *count += u8::from(is_extremum);
            }
        }
        let least = (1..=settings.least_extrema.clamp(1, 255))
            .rev()
            .find(|&c| counts.iter().filter(|&&x| usize::from(x) >= c).count() >= LEAST_KEPT)
            .unwrap_or(1);
        let vertices: Vec<u32> =
            (0..n).filter(|&v| usize::from(counts[v]) >= least).map(|v| v as u32).collect();
        let pairs = pairs(body, &vertices, first, last);
        Self { counts, vertices, pairs }
    }

    /// For each harmonic (pairs with H_i ≈ H_j minus pairs with H_i ≈ −H_j) / pairs.
    pub(super) fn vote(&self, basis: &Basis) -> Vec<f64> {
        let first = first_waving(basis);
        (0..basis.harmonics())
            .map(|k| {
                if k < first {
                    return 1.0;
                }
                let h = basis.harmonic(k);
                let votes: i64 = self
                    .pairs
                    .iter()
                    .map(|p| {
                        let [a, b] = p.map(|v| h[v as usize]);
                        let alike = ALIKE * (a.abs() + b.abs());
                        i64::from((a - b).abs() <= alike) - i64::from((a + b).abs() <= alike)
                    })
                    .sum();
                votes as f64 / self.pairs.len().max(1) as f64
            })
            .collect()
    }
}

/// Mutually nearest absolute GPS signatures |H_k(i)| / √λ_k among `vertices`.
fn pairs(body: &Body, vertices: &[u32], first: usize, last: usize) -> Vec<[u32; 2]> {
    let basis = &*body.basis;
    let signatures: Vec<Vec<f64>> = vertices
        .iter()
        .map(|&v| {
            (first..last).map(|k| basis.harmonic(k)[v as usize].abs() / basis.eigenvalues[k].sqrt()).collect()
        })
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
        // Nearest of each other: the paper asks only for "closest", which lets one odd vertex
        // pair with anything.
        if let Some(j) = j
            && i < j
            && nearest[j] == Some(i)
        {
            pairs.push([vertices[i], vertices[j]]);
        }
    }
    pairs
}
