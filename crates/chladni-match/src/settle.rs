//! The last step onto the template at full resolution: displacements smoothed by the shape's
//! cotangent Laplacian.

use std::collections::HashMap;

use chladni_task::Task;
use glam::DVec3;
use rayon::prelude::*;

use crate::bend::{pulls, vertex_normals};
use crate::surface::Surface;
use crate::{MatchError, Similarity};

/// S + W as neighbour lists, for products.
struct Laplacian {
    start: Vec<u32>,
    entries: Vec<(u32, f64)>,
    diagonal: Vec<f64>,
}

impl Laplacian {
    /// Cotangent weights ½(cot β + cot β′), kept at 0 or more so that the system stays definite.
    fn new(surface: &Surface) -> Self {
        let mut weights: HashMap<(u32, u32), f64> = HashMap::with_capacity(surface.triangles.len() * 3 / 2);
        for t in &surface.triangles {
            for i in 0..3 {
                let (apex, a, b) = (t[i], t[(i + 1) % 3], t[(i + 2) % 3]);
                let p = surface.points[apex as usize];
                let (u, v) = (surface.points[a as usize] - p, surface.points[b as usize] - p);
                let cot = u.dot(v) / u.cross(v).length().max(1e-12);
                *weights.entry((a.min(b), a.max(b))).or_default() += 0.5 * cot;
            }
        }
        let n = surface.points.len();
        let mut start = vec![0_u32; n + 1];
        let mut entries = Vec::with_capacity(2 * weights.len());
        let mut diagonal = vec![0.0; n];
        for v in 0..n {
            for &w in surface.neighbours(v) {
                let key = ((v as u32).min(w), (v as u32).max(w));
                let weight = weights.get(&key).copied().unwrap_or(0.0).clamp(1e-3, 1e3);
                entries.push((w, weight));
                diagonal[v] += weight;
            }
            start[v + 1] = entries.len() as u32;
        }
        Self { start, entries, diagonal }
    }

    /// (diag(w) + α S) x.
    fn times(&self, w: &[f64], alpha: f64, x: &[DVec3], out: &mut [DVec3]) {
        out.par_iter_mut().enumerate().with_min_len(1024).for_each(|(v, out)| {
            let row = &self.entries[self.start[v] as usize..self.start[v + 1] as usize];
            let around: DVec3 = row.iter().map(|(u, s)| x[*u as usize] * *s).sum();
            *out = x[v] * (w[v] + alpha * self.diagonal[v]) - around * alpha;
        });
    }

    /// Solves (diag(w) + α S) x = b by conjugate gradients with the diagonal as preconditioner,
    /// all three coordinates at once, to 1e-4 of the start.
    fn solve(&self, w: &[f64], alpha: f64, b: &[DVec3]) -> Vec<DVec3> {
        let n = b.len();
        let inverse: Vec<f64> = (0..n).map(|v| 1.0 / (w[v] + alpha * self.diagonal[v]).max(1e-300)).collect();
        let dot = |a: &[DVec3], b: &[DVec3]| -> DVec3 { a.iter().zip(b).map(|(a, b)| *a * *b).sum() };
        let ratio = |a: DVec3, b: DVec3| {
            DVec3::from_array(std::array::from_fn(|i| if b[i] > 0.0 { a[i] / b[i] } else { 0.0 }))
        };
        let mut x = vec![DVec3::ZERO; n];
        let mut r = b.to_vec();
        let mut z: Vec<DVec3> = r.iter().zip(&inverse).map(|(r, i)| *r * *i).collect();
        let mut p = z.clone();
        let mut q = vec![DVec3::ZERO; n];
        let mut rz = dot(&r, &z);
        let goal = rz * 1e-8;
        for _ in 0..300 {
            if rz.cmple(goal).all() {
                break;
            }
            self.times(w, alpha, &p, &mut q);
            let step = ratio(rz, dot(&p, &q));
            for v in 0..n {
                x[v] += p[v] * step;
                r[v] -= q[v] * step;
                z[v] = r[v] * inverse[v];
            }
            let next = dot(&r, &z);
            let turn = ratio(next, rz);
            rz = next;
            for v in 0..n {
                p[v] = z[v] + p[v] * turn;
            }
        }
        x
    }
}

/// Draws the bent shape onto the aligned template, smoothing over ever shorter lengths
/// (shares of the diagonal). What the template does not have stays where the bending put it.
pub(crate) fn settle(
    shape: &Surface,
    template: &Surface,
    pose: &Similarity,
    mut bent: Vec<DVec3>,
    task: &Task,
) -> Result<Vec<DVec3>, MatchError> {
    const LENGTHS: [f64; 3] = [0.02, 0.01, 0.006];
    let all: Vec<u32> = (0..bent.len() as u32).collect();
    let laplacian = Laplacian::new(shape);
    let stage = task.stage("settling", LENGTHS.len() as u64);
    for length in LENGTHS {
        task.check()?;
        let normals = vertex_normals(&bent, &shape.triangles);
        let mut w = vec![0.0; bent.len()];
        let mut b = vec![DVec3::ZERO; bent.len()];
        for pull in pulls(template, pose, &all, &bent, &normals, 0.03) {
            let v = pull.vertex as usize;
            w[v] = shape.areas[v] * pull.weight;
            b[v] = (pull.to - bent[v]) * w[v];
        }
        // A touch of weight everywhere keeps loose components in place.
        for v in 0..bent.len() {
            w[v] += 1e-3 * shape.areas[v];
        }
        let moved = laplacian.solve(&w, length * length, &b);
        for (y, d) in bent.iter_mut().zip(&moved) {
            if d.is_finite() {
                *y += *d;
            }
        }
        stage.advance(1);
    }
    Ok(bent)
}
