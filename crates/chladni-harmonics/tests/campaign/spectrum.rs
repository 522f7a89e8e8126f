//! All eigenvalues of a small pencil with a diagonal M, computed independently of the solver and its library.

use chladni_harmonics::SymmetricSparse;

/// Up to this many vertices Jacobi rotations are used, which are accurate for small eigenvalues, too; beyond it, a
/// tridiagonal matrix, which is accurate beside the largest one.
pub const JACOBI: usize = 80;

/// The eigenvalues of M^-½ S M^-½, ascending.
pub fn spectrum(stiffness: &SymmetricSparse, mass: &[f64]) -> Vec<f64> {
    let mut place = vec![0; mass.len()];
    let mut values = Vec::new();
    for part in parts(stiffness) {
        let n = part.len();
        part.iter().enumerate().for_each(|(at, v)| place[*v] = at);
        let mut a = vec![0.0; n * n];
        for (j, &v) in part.iter().enumerate() {
            for (i, value) in stiffness.column(v) {
                a[j * n + place[i]] = value / (mass[i].sqrt() * mass[v].sqrt());
            }
        }
        values.extend(if n <= JACOBI { jacobi(a, n) } else { of_tridiagonal(tridiagonal(a, n)) });
    }
    values.sort_by(f64::total_cmp);
    values
}

/// The rows of each part to which nothing joins the others.
fn parts(stiffness: &SymmetricSparse) -> Vec<Vec<usize>> {
    let mut reached = vec![false; stiffness.size()];
    let mut parts = Vec::new();
    for first in 0..stiffness.size() {
        let (mut part, mut waiting) = (Vec::new(), vec![first]);
        while let Some(v) = waiting.pop() {
            if !std::mem::replace(&mut reached[v], true) {
                part.push(v);
                waiting.extend(stiffness.column(v).map(|(i, _)| i));
            }
        }
        parts.push(part);
    }
    parts.retain(|part| !part.is_empty());
    parts
}

/// Cyclic Jacobi (Golub & Van Loan, 8.5) on the n×n matrix `a`.
fn jacobi(mut a: Vec<f64>, n: usize) -> Vec<f64> {
    for _ in 0..40 {
        let mut turned = false;
        for p in 0..n {
            for q in p + 1..n {
                let (app, aqq, apq) = (a[p * n + p], a[q * n + q], a[p * n + q]);
                if apq.abs() <= f64::EPSILON * 0.1 * (app.abs() * aqq.abs()).sqrt() {
                    continue;
                }
                turned = true;
                let tau = (aqq - app) / (2.0 * apq);
                let t = tau.signum() / (tau.abs() + tau.hypot(1.0));
                let c = t.hypot(1.0).recip();
                let s = t * c;
                for k in 0..n {
                    let (x, y) = (a[k * n + p], a[k * n + q]);
                    (a[k * n + p], a[k * n + q]) = (c * x - s * y, s * x + c * y);
                }
                for k in 0..n {
                    let (x, y) = (a[p * n + k], a[q * n + k]);
                    (a[p * n + k], a[q * n + k]) = (c * x - s * y, s * x + c * y);
                }
            }
        }
        if !turned {
            break;
        }
    }
    (0..n).map(|i| a[i * n + i]).collect()
}

/// Householder's reduction (Golub & Van Loan, 8.3.1) of the n×n matrix `a`, of which it reads the upper triangle: a diagonal, and
/// the values beside it.
fn tridiagonal(mut a: Vec<f64>, n: usize) -> (Vec<f64>, Vec<f64>) {
    let mut beside = vec![0.0; n];
    for k in 0..n.saturating_sub(1) {
        let mut v = a[k * n + k + 1..(k + 1) * n].to_vec();
        let length = dot(&v, &v).sqrt();
        beside[k] = if v[0] > 0.0 { -length } else { length };
        if v[1..].iter().all(|x| *x == 0.0) {
            beside[k] = v[0];
            continue;
        }
        v[0] -= beside[k];
        let beta = 2.0 / dot(&v, &v);
        // The part that is left, row by row.
        let left = &mut a[(k + 1) * n..];
        let mut w = vec![0.0; v.len()];
        for (i, row) in left.chunks_exact(n).enumerate() {
            let row = &row[k + 1 + i..];
            w[i] += dot(&row[1..], &v[i + 1..]);
            w[i..].iter_mut().zip(row).for_each(|(w, a)| *w += v[i] * a);
        }
        let half = 0.5 * beta * beta * dot(&w, &v);
        w.iter_mut().zip(&v).for_each(|(w, v)| *w = beta * *w - half * v);
        for (i, row) in left.chunks_exact_mut(n).enumerate() {
            let (x, y) = (v[i], w[i]);
            let others = v[i..].iter().zip(&w[i..]);
            row[k + 1 + i..].iter_mut().zip(others).for_each(|(a, (v, w))| *a -= x * w + y * v);
        }
    }
    ((0..n).map(|i| a[i * n + i]).collect(), beside)
}

/// Σ x y, in eight sums that vector instructions can add at once.
fn dot(x: &[f64], y: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (pairs, rest) = (x.chunks_exact(8).zip(y.chunks_exact(8)), x.len() / 8 * 8);
    for (x, y) in pairs {
        (0..8).for_each(|i| sums[i] += x[i] * y[i]);
    }
    sums.iter().sum::<f64>() + x[rest..].iter().zip(&y[rest..]).map(|(x, y)| x * y).sum::<f64>()
}

/// The eigenvalues of a tridiagonal matrix by QL steps with implicit shifts (EISPACK's `imtql1`); `e[k]` is between rows
/// k and k + 1 of the diagonal `d`, and its last value is 0.
fn of_tridiagonal((mut d, mut e): (Vec<f64>, Vec<f64>)) -> Vec<f64> {
    let n = d.len();
    for l in 0..n {
        for _ in 0..100 {
            let is_apart = |m: &usize| e[*m].abs() <= f64::EPSILON * (d[*m].abs() + d[m + 1].abs());
            let m = (l..n - 1).find(is_apart).unwrap_or(n - 1);
            if m == l {
                break;
            }
            let (mut s, mut c, mut p) = (1.0, 1.0, 0.0);
            let g = (d[l + 1] - d[l]) / (2.0 * e[l]);
            let mut g = d[m] - d[l] + e[l] / (g + g.hypot(1.0).copysign(g));
            for i in (l..m).rev() {
                let (f, b) = (s * e[i], c * e[i]);
                e[i + 1] = f.hypot(g);
                if e[i + 1] == 0.0 {
                    // The matrix has come apart here: the next step begins anew.
                    (d[i + 1], e[m]) = (d[i + 1] - p, 0.0);
                    (p, g) = (0.0, e[l]);
                    break;
                }
                (s, c) = (f / e[i + 1], g / e[i + 1]);
                g = d[i + 1] - p;
                let r = (d[i] - g) * s + 2.0 * c * b;
                p = s * r;
                d[i + 1] = g + p;
                g = c * r - b;
            }
            (d[l], e[l], e[m]) = (d[l] - p, g, 0.0);
        }
    }
    d
}

#[test]
fn both_ways_find_the_same_spectrum() {
    // A membrane of 8 by 8 beads, whose spectrum is known, with double eigenvalues.
    let (wide, high) = (8, 8);
    let at = |x: usize, y: usize| x + wide * y;
    let places = (0..high).flat_map(|y| (0..wide).map(move |x| (x, y)));
    let entries = places.clone().flat_map(|(x, y)| {
        let right = (x + 1 < wide).then(|| (at(x, y), at(x + 1, y), -1.0));
        let up = (y + 1 < high).then(|| (at(x, y), at(x, y + 1), -1.0));
        [(at(x, y), at(x, y), 4.0)].into_iter().chain(right).chain(up)
    });
    let stiffness = SymmetricSparse::from_entries(wide * high, entries).unwrap();
    let wave =
        |i: usize, n: usize| 2.0 - 2.0 * (std::f64::consts::PI * (i + 1) as f64 / (n + 1) as f64).cos();
    let mut exact: Vec<f64> = places.map(|(x, y)| wave(x, wide) + wave(y, high)).collect();
    exact.sort_by(f64::total_cmp);
    let n = wide * high;
    let mut a = vec![0.0; n * n];
    (0..n).for_each(|j| stiffness.column(j).for_each(|(i, value)| a[j * n + i] = value));
    let mut tall = of_tridiagonal(tridiagonal(a, n));
    tall.sort_by(f64::total_cmp);
    for values in [tall, spectrum(&stiffness, &vec![1.0; n])] {
        assert!(values.iter().zip(&exact).all(|(value, exact)| (value - exact).abs() < 1e-13), "{values:?}");
    }
}
