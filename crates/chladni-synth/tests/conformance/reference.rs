//! The formula written naively in f64, with bounds on the error of a backend.

use chladni_synth::{Coefficients, Item, Residual, area_weighted_normals};

/// A shape as plain arrays.
pub struct Shape {
    pub positions: Vec<[f64; 3]>,
    pub triangles: Vec<[u32; 3]>,
    /// N×K, column-major.
    pub basis: Vec<f64>,
}

impl Shape {
    pub fn vertices(&self) -> usize {
        self.positions.len()
    }

    pub fn harmonics(&self) -> usize {
        self.basis.len() / self.vertices()
    }
}

/// x' and, for each coordinate, the largest error that is allowed in a picture.
pub fn positions(shape: &Shape, item: &Item) -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
    let n = shape.vertices();
    let normals = area_weighted_normals(&shape.positions, &shape.triangles).unwrap();
    let peaks: Vec<f64> =
        shape.basis.chunks(n).map(|h| h.iter().fold(0.0, |p: f64, h| p.max(h.abs()))).collect();
    let (mut out, mut bounds) = (Vec::new(), Vec::new());
    for v in 0..n {
        let mut x = shape.positions[v];
        // Half a step of 16 bits at the peak of each harmonic, and the rounding errors of f32 sums.
        let mut bound = x.map(|x| 1e-6 * (1.0 + x.abs()));
        for term in &item.terms {
            let mask = term.mask.as_ref().map_or(1.0, |m| f64::from(m[v]));
            let gain = f64::from(term.residual_gain);
            let weight = |k: usize, i: usize| match &term.coefficients {
                Coefficients::Vector(c) => f64::from(c[k][i]),
                Coefficients::Normal(c) => f64::from(c[k]),
            };
            let (len, axes) = match &term.coefficients {
                Coefficients::Vector(c) => (c.len(), 3),
                Coefficients::Normal(c) => (c.len(), 1),
            };
            let residual = |i: usize| match &term.residual {
                Some(Residual::Vector(r)) => f64::from(r[v][i]),
                Some(Residual::Normal(r)) => f64::from(r[v]),
                None => 0.0,
            };
            for i in 0..3 {
                let axis = if axes == 3 { i } else { 0 };
                let mut signal = residual(axis) * gain;
                let mut error = 1e-6 * signal.abs();
                for k in 0..len {
                    let c = weight(k, axis);
                    signal += shape.basis[k * n + v] * c;
                    error += c.abs() * peaks[k] * (0.51 / 32767.0 + 2e-6);
                }
                let n = if axes == 3 { 1.0 } else { normals[v][i] };
                x[i] += mask * signal * n;
                bound[i] += (mask * error).abs() * n.abs() + 1e-6 * (mask * signal).abs();
            }
        }
        out.push(x);
        bounds.push(bound);
    }
    (out, bounds)
}

/// Blended normals of given positions and, for each vertex, the largest error allowed in f32 sums.
pub fn normals(shape: &Shape, positions: &[[f32; 3]], blending: f64) -> (Vec<[f64; 3]>, Vec<f64>) {
    let x: Vec<[f64; 3]> = positions.iter().map(|p| p.map(f64::from)).collect();
    let exact = area_weighted_normals(&x, &shape.triangles).unwrap();
    let rest = area_weighted_normals(&shape.positions, &shape.triangles).unwrap();
    // The edge products may cancel: compare the length of the sum with the sum of lengths.
    let (mut sums, mut lengths) = (vec![[0.0; 3]; x.len()], vec![0.0; x.len()]);
    for t in &shape.triangles {
        let [a, b, c] = t.map(|v| x[v as usize]);
        let (u, w) = (sub(b, a), sub(c, a));
        let cross = [u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]];
        for &v in t {
            (0..3).for_each(|i| sums[v as usize][i] += cross[i]);
            lengths[v as usize] += norm(u) * norm(w) + norm(w) * norm(sub(c, b)) + norm(u) * norm(sub(c, b));
        }
    }
    let mut bounds = Vec::new();
    let blended = (0..x.len())
        .map(|v| {
            let mean: [f64; 3] =
                std::array::from_fn(|i| (1.0 - blending) * exact[v][i] + blending * rest[v][i]);
            let length = norm(mean);
            bounds.push(1e-5 * (1.0 + lengths[v] / norm(sums[v]).max(1e-12)) / length.max(1e-12));
            mean.map(|m| m / length)
        })
        .collect();
    (blended, bounds)
}

pub fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

pub fn norm(a: [f64; 3]) -> f64 {
    a[0].hypot(a[1]).hypot(a[2])
}
