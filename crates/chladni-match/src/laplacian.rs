//! The cotangent Laplacian of a triangle mesh, and linear systems with it.

use glam::DVec3;
use rayon::prelude::*;

/// S as neighbor lists, for matrix products.
pub(crate) struct Laplacian {
    start: Vec<u32>,
    entries: Vec<(u32, f64)>,
    diagonal: Vec<f64>,
}

impl Laplacian {
    /// Cotangent weights ½(cot β + cot β′), kept above 0: each value of a harmonic function is then a mean
    /// of its neighbors' values.
    pub fn new(points: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        let mut halves: Vec<(u32, u32, f64)> = Vec::with_capacity(6 * triangles.len());
        for t in triangles {
            for i in 0..3 {
                let (apex, a, b) = (t[i], t[(i + 1) % 3], t[(i + 2) % 3]);
                let p = points[apex as usize];
                let (u, v) = (points[a as usize] - p, points[b as usize] - p);
                let cot = 0.5 * u.dot(v) / u.cross(v).length().max(1e-12);
                halves.extend([(a, b, cot), (b, a, cot)]);
            }
        }
        halves.par_sort_unstable_by_key(|h| (h.0, h.1));
        let n = points.len();
        let mut start = vec![0_u32; n + 1];
        let mut entries = Vec::with_capacity(halves.len() / 2);
        let mut diagonal = vec![0.0; n];
        for same in halves.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let (v, w, _) = same[0];
            let weight = same.iter().map(|h| h.2).sum::<f64>().clamp(1e-3, 1e3);
            entries.push((w, weight));
            diagonal[v as usize] += weight;
            start[v as usize + 1] += 1;
        }
        for v in 0..n {
            start[v + 1] += start[v];
        }
        Self { start, entries, diagonal }
    }

    /// The neighbors of `v` and their weights.
    pub fn row(&self, v: usize) -> &[(u32, f64)] {
        &self.entries[self.start[v] as usize..self.start[v + 1] as usize]
    }

    /// The rows and columns of the `kept` vertices (ascending). The diagonal still counts all neighbors.
    pub fn among(&self, kept: &[u32]) -> Self {
        let (mut start, mut entries) = (vec![0], Vec::new());
        for v in kept {
            let row = self.row(*v as usize).iter();
            entries.extend(row.filter_map(|(u, s)| Some((kept.binary_search(u).ok()? as u32, *s))));
            start.push(entries.len() as u32);
        }
        Self { start, entries, diagonal: kept.iter().map(|v| self.diagonal[*v as usize]).collect() }
    }

    /// Computes (diag(w) + α S) x.
    pub fn times(&self, w: &[f64], alpha: f64, x: &[DVec3], out: &mut [DVec3]) {
        out.par_iter_mut().enumerate().with_min_len(1024).for_each(|(v, out)| {
            let around: DVec3 = self.row(v).iter().map(|(u, s)| x[*u as usize] * *s).sum();
            *out = x[v] * (w[v] + alpha * self.diagonal[v]) - around * alpha;
        });
    }

    /// Solves (diag(w) + α S) x = b for all three coordinates at once, by conjugate gradients with the
    /// diagonal as preconditioner, starting from the guess `x`. `tolerance` is relative to the norm of b.
    pub fn solve(&self, w: &[f64], alpha: f64, b: &[DVec3], mut x: Vec<DVec3>, tolerance: f64) -> Vec<DVec3> {
        const MOST_STEPS: usize = 1000;
        let n = b.len();
        let inverse: Vec<f64> = (0..n).map(|v| 1.0 / (w[v] + alpha * self.diagonal[v]).max(1e-300)).collect();
        let ratio = |a: DVec3, b: DVec3| {
            DVec3::from_array(std::array::from_fn(|i| if b[i] > 0.0 { a[i] / b[i] } else { 0.0 }))
        };
        let mut q = vec![DVec3::ZERO; n];
        self.times(w, alpha, &x, &mut q);
        let mut r: Vec<DVec3> = b.iter().zip(&q).map(|(b, q)| *b - *q).collect();
        let goal = sum(n, |v| b[v] * b[v] * inverse[v]) * tolerance * tolerance;
        let mut p: Vec<DVec3> = r.iter().zip(&inverse).map(|(r, i)| *r * *i).collect();
        let mut rz = sum(n, |v| r[v] * p[v]);
        for _ in 0..MOST_STEPS {
            if rz.cmple(goal).all() {
                break;
            }
            self.times(w, alpha, &p, &mut q);
            let step = ratio(rz, sum(n, |v| p[v] * q[v]));
            let both = x.par_iter_mut().with_min_len(PIECE).zip(&mut r);
            both.zip(&p).zip(&q).for_each(|(((x, r), p), q)| {
                *x += *p * step;
                *r -= *q * step;
            });
            let next = sum(n, |v| r[v] * r[v] * inverse[v]);
            let turn = ratio(next, rz);
            rz = next;
            let preconditioned = r.par_iter().zip(&inverse);
            p.par_iter_mut().with_min_len(PIECE).zip(preconditioned).for_each(|(p, (r, i))| {
                *p = *r * *i + *p * turn;
            });
        }
        x
    }
}

/// The smallest number of entries that one thread works on.
const PIECE: usize = 4096;

/// The sum of `of` over 0..n, in parallel pieces that do not depend on the number of threads: the result is
/// the same on every machine.
fn sum(n: usize, of: impl Fn(usize) -> DVec3 + Sync) -> DVec3 {
    let piece = |i: usize| (i * PIECE..n.min((i + 1) * PIECE)).map(&of).sum::<DVec3>();
    let sums: Vec<DVec3> = (0..n.div_ceil(PIECE)).into_par_iter().map(piece).collect();
    sums.into_iter().sum()
}
