//! A few well-chosen vertices that tell, before synthesis, how far an item will go.

use std::collections::HashMap;

use chladni_harmonics::Body;
use chladni_synth::{Coefficients, Item, Residual};

/// Vertices at the extremes of the harmonics that move the shape most, and far from each other.
#[derive(Clone, Debug)]
pub(crate) struct Probes {
    vertices: Vec<u32>,
    /// H at the probes: K rows of `vertices.len()`.
    harmonics: Vec<f32>,
    normals: Vec<[f32; 3]>,
}

const COUNT: usize = 64;

impl Probes {
    /// `unit[k]`: how far harmonic k moves the shape; its extremes are probed in this order.
    pub(crate) fn new(body: &Body, unit: &[f32]) -> Self {
        let n = body.positions.len();
        let mut order: Vec<usize> = (0..unit.len()).collect();
        order.sort_by(|&i, &j| unit[j].total_cmp(&unit[i]).then(i.cmp(&j)));
        let mut vertices: Vec<u32> = Vec::with_capacity(COUNT);
        for k in order {
            if vertices.len() >= COUNT * 3 / 4 {
                break;
            }
            let h = body.basis.harmonic(k);
            let by = |i: &usize, j: &usize| h[*i].total_cmp(&h[*j]);
            for v in [(0..n).max_by(by), (0..n).min_by(by)].into_iter().flatten() {
                if !vertices.contains(&(v as u32)) {
                    vertices.push(v as u32);
                }
            }
        }
        spread(&body.positions, &mut vertices, COUNT.min(n));
        let harmonics = (0..body.basis.harmonics())
            .flat_map(|k| {
                let h = body.basis.harmonic(k);
                vertices.iter().map(|&v| h[v as usize] as f32).collect::<Vec<_>>()
            })
            .collect();
        let normals = rest_normals(body, &vertices);
        Self { vertices, harmonics, normals }
    }

    pub(crate) fn count(&self) -> usize {
        self.vertices.len()
    }

    /// The largest displacement of a probe under `item`. `scratch` keeps its memory between
    /// calls; nothing else is allocated.
    pub(crate) fn displacement(&self, item: &Item, scratch: &mut Vec<[f32; 3]>) -> f32 {
        let p = self.vertices.len();
        scratch.clear();
        scratch.resize(2 * p, [0.0; 3]);
        let (total, term_sum) = scratch.split_at_mut(p);
        for term in &item.terms {
            term_sum.fill([0.0; 3]);
            match &term.coefficients {
                Coefficients::Vector(c) => {
                    for (c, row) in
                        c.iter().zip(self.harmonics.chunks_exact(p)).filter(|(c, _)| **c != [0.0; 3])
                    {
                        for (d, h) in term_sum.iter_mut().zip(row) {
                            for i in 0..3 {
                                d[i] += h * c[i];
                            }
                        }
                    }
                }
                Coefficients::Normal(c) => {
                    for (c, row) in c.iter().zip(self.harmonics.chunks_exact(p)).filter(|(c, _)| **c != 0.0) {
                        for (d, h) in term_sum.iter_mut().zip(row) {
                            d[0] += h * c;
                        }
                    }
                }
            }
            let along_normal = matches!(term.coefficients, Coefficients::Normal(_));
            for (i, &v) in self.vertices.iter().enumerate() {
                let v = v as usize;
                let g = term.residual_gain;
                let mut d = term_sum[i];
                match &term.residual {
                    Some(Residual::Vector(r)) if g != 0.0 => {
                        if let Some(r) = r.get(v) {
                            d = std::array::from_fn(|c| d[c] + g * r[c]);
                        }
                    }
                    Some(Residual::Normal(r)) if g != 0.0 => d[0] += g * r.get(v).copied().unwrap_or(0.0),
                    _ => {}
                }
                if along_normal {
                    d = self.normals[i].map(|n| n * d[0]);
                }
                let mask = term.mask.as_ref().map_or(1.0, |m| m.get(v).copied().unwrap_or(1.0));
                total[i] = std::array::from_fn(|c| total[i][c] + mask * d[c]);
            }
        }
        total.iter().map(|d| d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).fold(0.0, f32::max).sqrt()
    }
}

/// Adds the vertex farthest from all chosen ones until there are `count`.
fn spread(positions: &[[f64; 3]], chosen: &mut Vec<u32>, count: usize) {
    let squared = |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>();
    let mut nearest: Vec<f64> = positions
        .iter()
        .map(|p| chosen.iter().map(|&c| squared(*p, positions[c as usize])).fold(f64::MAX, f64::min))
        .collect();
    while chosen.len() < count {
        let Some(next) = (0..positions.len()).max_by(|&i, &j| nearest[i].total_cmp(&nearest[j])) else {
            return;
        };
        chosen.push(next as u32);
        for (d, p) in nearest.iter_mut().zip(positions) {
            *d = d.min(squared(*p, positions[next]));
        }
    }
}

/// Area-weighted rest normals of some vertices.
fn rest_normals(body: &Body, vertices: &[u32]) -> Vec<[f32; 3]> {
    let slot: HashMap<u32, usize> = vertices.iter().enumerate().map(|(i, &v)| (v, i)).collect();
    let mut normals = vec![[0.0f64; 3]; vertices.len()];
    for t in &body.triangles {
        let [a, b, c] = t.map(|v| body.positions[v as usize]);
        let u: [f64; 3] = std::array::from_fn(|i| b[i] - a[i]);
        let v: [f64; 3] = std::array::from_fn(|i| c[i] - a[i]);
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        for i in t.iter().filter_map(|v| slot.get(v)) {
            normals[*i] = std::array::from_fn(|c| normals[*i][c] + n[c]);
        }
    }
    normals
        .into_iter()
        .map(|n| {
            let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
            if length > 0.0 { n.map(|c| (c / length) as f32) } else { [0.0; 3] }
        })
        .collect()
}
