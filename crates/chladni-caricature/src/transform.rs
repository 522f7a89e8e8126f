//! The harmonic transform of several channels in one pass over H.
//!
//! H is the only large operand (N×K·8 bytes); both directions are bound by reading it, so
//! channels that are needed together travel together.

use chladni_harmonics::Basis;
use rayon::prelude::*;

/// Vertices per block: C ≤ 4 channels of a block and a stretch of one harmonic fit in L1.
const BLOCK: usize = 512;
/// Blocks that are summed together; what is added in which order must not depend on threads.
const PIECE: usize = 6;

/// f̃_k = Σ_v a(v) H_k(v) f(v) for k < `harmonics` ≤ K, for the C channels that `signal` gives
/// at a vertex.
pub(crate) fn analyse<const C: usize>(
    basis: &Basis,
    harmonics: usize,
    signal: impl Fn(usize) -> [f64; C] + Sync,
) -> Vec<[f64; C]> {
    let n = basis.vertices();
    let harmonics = harmonics.min(basis.harmonics());
    let blocks = n.div_ceil(BLOCK);
    let piece = |piece: usize| {
        let mut sums = vec![[0.0; C]; harmonics];
        for block in piece * PIECE..blocks.min((piece + 1) * PIECE) {
            let first = block * BLOCK;
            let len = BLOCK.min(n - first);
            let mut weighted = [[0.0; BLOCK]; C];
            for i in 0..len {
                let f = signal(first + i);
                for c in 0..C {
                    weighted[c][i] = basis.mass[first + i] * f[c];
                }
            }
            for (k, sum) in sums.iter_mut().enumerate() {
                let h = &basis.harmonic(k)[first..first + len];
                for (c, s) in dot(h, &weighted).into_iter().enumerate() {
                    sum[c] += s;
                }
            }
        }
        sums
    };
    let pieces: Vec<Vec<[f64; C]>> = (0..blocks.div_ceil(PIECE)).into_par_iter().map(piece).collect();
    let mut sums = vec![[0.0; C]; harmonics];
    for part in &pieces {
        for (sum, part) in sums.iter_mut().zip(part) {
            (0..C).for_each(|c| sum[c] += part[c]);
        }
    }
    sums
}

/// Σ_i h[i] f_c[i] for every channel, in four lanes that the compiler can vectorise.
fn dot<const C: usize>(h: &[f64], channels: &[[f64; BLOCK]; C]) -> [f64; C] {
    let mut lanes = [[0.0; 4]; C];
    let quads = h.len() / 4;
    for q in 0..quads {
        let h4: &[f64; 4] = h[4 * q..4 * q + 4].try_into().expect("four values");
        for c in 0..C {
            let f4: &[f64; 4] = channels[c][4 * q..4 * q + 4].try_into().expect("four values");
            for l in 0..4 {
                lanes[c][l] += h4[l] * f4[l];
            }
        }
    }
    std::array::from_fn(|c| {
        let tail: f64 = (4 * quads..h.len()).map(|i| h[i] * channels[c][i]).sum();
        lanes[c].iter().sum::<f64>() + tail
    })
}

/// Σ_k H_k(v) c_k of C channels, given to `emit` vertex by vertex with the vertex's own slot of
/// `out`. Harmonics whose coefficients are all zero are not read.
pub(crate) fn synthesise<const C: usize, T: Send>(
    basis: &Basis,
    coefficients: &[[f64; C]],
    out: &mut [T],
    emit: impl Fn(usize, [f64; C], &mut T) + Sync,
) {
    let used: Vec<(usize, [f64; C])> = coefficients
        .iter()
        .copied()
        .enumerate()
        .take(basis.harmonics())
        .filter(|(_, c)| c.iter().any(|c| *c != 0.0))
        .collect();
    out.par_chunks_mut(BLOCK).enumerate().for_each(|(block, out)| {
        let first = block * BLOCK;
        let len = out.len();
        let mut sums = [[0.0; BLOCK]; C];
        let (fours, rest) = used.as_chunks::<4>();
        for four in fours {
            let h: [&[f64]; 4] = four.map(|(k, _)| &basis.harmonic(k)[first..first + len]);
            for (c, sum) in sums.iter_mut().enumerate() {
                let w = four.map(|(_, coefficient)| coefficient[c]);
                let columns = h[0].iter().zip(h[1]).zip(h[2].iter().zip(h[3]));
                for (s, ((h0, h1), (h2, h3))) in sum.iter_mut().zip(columns) {
                    *s += (h0 * w[0] + h1 * w[1]) + (h2 * w[2] + h3 * w[3]);
                }
            }
        }
        for &(k, w) in rest {
            let h = &basis.harmonic(k)[first..first + len];
            for c in 0..C {
                sums[c].iter_mut().zip(h).for_each(|(s, h)| *s += h * w[c]);
            }
        }
        for (i, slot) in out.iter_mut().enumerate() {
            emit(first + i, std::array::from_fn(|c| sums[c][i]), slot);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::base_and_target;

    #[test]
    fn agrees_with_the_transform_of_the_basis() {
        let (body, _, base, _) = base_and_target();
        let expected = body.basis.transform3(&base.positions);
        let here = analyse(&body.basis, usize::MAX, |v| base.positions[v]);
        assert_eq!(here.len(), expected.len());
        for (a, b) in here.iter().zip(&expected) {
            (0..3).for_each(|c| assert!((a[c] - b[c]).abs() < 1e-12));
        }
        // 43 coefficients: ten fours and a rest.
        let mut there = vec![[0.0; 3]; base.positions.len()];
        synthesise(&body.basis, &expected[..43], &mut there, |_, f, out| *out = f);
        for (a, b) in there.iter().zip(body.basis.synthesize3(&expected[..43])) {
            (0..3).for_each(|c| assert!((a[c] - b[c]).abs() < 1e-12));
        }
    }
}
