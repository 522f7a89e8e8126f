//! The harmonic transform, for several channels in one pass over H.
//!
//! H is the only large operand (N×K·8 bytes), and reading it is the bottleneck in both directions. Channels
//! that are needed together are therefore processed together.

use rayon::prelude::*;

use crate::Basis;

/// Vertices per block: for C ≤ 4 channels, a block and the matching part of one harmonic fit in L1.
const BLOCK: usize = 512;
/// Blocks that are summed together. It is fixed because the order of summation must not depend on the
/// number of threads.
const PIECE: usize = 6;

impl Basis {
    /// The harmonic transform f̃_k = Σ_v a(v) H_k(v) f(v) of one scalar signal (N values).
    ///
    /// # Panics
    /// If `signal` does not have N values.
    pub fn transform(&self, signal: &[f64]) -> Vec<f64> {
        assert_eq!(signal.len(), self.vertices(), "one value per operator vertex");
        self.analyze(self.harmonics(), |v| [signal[v]]).as_flattened().to_vec()
    }

    /// The harmonic transform of a signal of three channels, such as positions.
    ///
    /// # Panics
    /// As for [`transform`](Self::transform).
    pub fn transform3(&self, signal: &[[f64; 3]]) -> Vec<[f64; 3]> {
        assert_eq!(signal.len(), self.vertices(), "one value per operator vertex");
        self.analyze(self.harmonics(), |v| signal[v])
    }

    /// Σ_k H_k(v) c_k over the first `coefficients.len()` ≤ K harmonics, N values.
    ///
    /// # Panics
    /// If there are more than K coefficients.
    pub fn synthesize(&self, coefficients: &[f64]) -> Vec<f64> {
        assert!(coefficients.len() <= self.harmonics(), "at most K coefficients");
        let mut signal = vec![0.0; self.vertices()];
        self.synthesize_each(coefficients.as_chunks::<1>().0, &mut signal, |_, [sum], out| *out = sum);
        signal
    }

    /// Σ_k H_k(v) C_k for three channels.
    ///
    /// # Panics
    /// As for [`synthesize`](Self::synthesize).
    pub fn synthesize3(&self, coefficients: &[[f64; 3]]) -> Vec<[f64; 3]> {
        assert!(coefficients.len() <= self.harmonics(), "at most K coefficients");
        let mut signal = vec![[0.0; 3]; self.vertices()];
        self.synthesize_each(coefficients, &mut signal, |_, sum, out| *out = sum);
        signal
    }

    /// f̃_k = Σ_v a(v) H_k(v) f(v) for k < `harmonics` ≤ K. `signal` returns the C channels of f at a
    /// vertex.
    pub fn analyze<const C: usize>(
        &self,
        harmonics: usize,
        signal: impl Fn(usize) -> [f64; C] + Sync,
    ) -> Vec<[f64; C]> {
        let n = self.vertices();
        let harmonics = harmonics.min(self.harmonics());
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
                        weighted[c][i] = self.mass[first + i] * f[c];
                    }
                }
                for (k, sum) in sums.iter_mut().enumerate() {
                    let h = &self.harmonic(k)[first..first + len];
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

    /// Computes Σ_k H_k(v) c_k for C channels and passes the result of each vertex to `emit`, with the
    /// vertex's own slot of `out`. Harmonics whose coefficients are all zero are not read,
    /// nor are coefficients beyond the first K.
    ///
    /// # Panics
    /// If `out` is longer than N.
    pub fn synthesize_each<const C: usize, T: Send>(
        &self,
        coefficients: &[[f64; C]],
        out: &mut [T],
        emit: impl Fn(usize, [f64; C], &mut T) + Sync,
    ) {
        let used: Vec<(usize, [f64; C])> = coefficients
            .iter()
            .copied()
            .enumerate()
            .take(self.harmonics())
            .filter(|(_, c)| c.iter().any(|c| *c != 0.0))
            .collect();
        out.par_chunks_mut(BLOCK).enumerate().for_each(|(block, out)| {
            let first = block * BLOCK;
            let len = out.len();
            let mut sums = [[0.0; BLOCK]; C];
            let (fours, rest) = used.as_chunks::<4>();
            for four in fours {
                let h: [&[f64]; 4] = four.map(|(k, _)| &self.harmonic(k)[first..first + len]);
                for (c, sum) in sums.iter_mut().enumerate() {
                    let w = four.map(|(_, coefficient)| coefficient[c]);
                    let columns = h[0].iter().zip(h[1]).zip(h[2].iter().zip(h[3]));
                    for (s, ((h0, h1), (h2, h3))) in sum.iter_mut().zip(columns) {
                        *s += (h0 * w[0] + h1 * w[1]) + (h2 * w[2] + h3 * w[3]);
                    }
                }
            }
            for &(k, w) in rest {
                let h = &self.harmonic(k)[first..first + len];
                for c in 0..C {
                    sums[c].iter_mut().zip(h).for_each(|(s, h)| *s += h * w[c]);
                }
            }
            for (i, slot) in out.iter_mut().enumerate() {
                emit(first + i, std::array::from_fn(|c| sums[c][i]), slot);
            }
        });
    }
}

/// Σ_i h[i] f_c[i] for every channel, in four partial sums that the compiler can vectorize.
fn dot<const C: usize>(h: &[f64], channels: &[[f64; BLOCK]; C]) -> [f64; C] {
    let mut lanes = [[0.0; 4]; C];
    let (quads, _) = h.as_chunks::<4>();
    for (q, h4) in quads.iter().enumerate() {
        for c in 0..C {
            let f4 = &channels[c].as_chunks::<4>().0[q];
            for l in 0..4 {
                lanes[c][l] += h4[l] * f4[l];
            }
        }
    }
    std::array::from_fn(|c| {
        let tail: f64 = (4 * quads.len()..h.len()).map(|i| h[i] * channels[c][i]).sum();
        lanes[c].iter().sum::<f64>() + tail
    })
}

#[cfg(test)]
mod tests {
    use chladni_mesh::samples;
    use chladni_task::Task;
    use proptest::prelude::*;

    use crate::{BasisSettings, Body};

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(8) })]
        #[test]
        fn it_is_the_sum_that_it_stands_for(
            harmonics in 1..50_usize, seed in 0.0..100.0_f64, kept in 0..50_usize,
        ) {
            // 642 vertices: more than a block, and not a multiple of four.
            let body = Body::build(&samples::icosphere(3), &BasisSettings::new(harmonics), &Task::new()).unwrap();
            let (basis, n) = (&body.basis, body.positions.len());
            let signal: Vec<[f64; 3]> = (0..n)
                .map(|v| std::array::from_fn(|c| (seed + 1.7 * v as f64 + c as f64).sin()))
                .collect();
            let found = basis.transform3(&signal);
            for (k, found) in found.iter().enumerate() {
                for c in 0..3 {
                    let h = basis.harmonic(k);
                    let sum: f64 = (0..n).map(|v| basis.mass[v] * h[v] * signal[v][c]).sum();
                    prop_assert!((found[c] - sum).abs() < 1e-12);
                }
            }
            let first: Vec<f64> = signal.iter().map(|f| f[0]).collect();
            prop_assert_eq!(basis.transform(&first), found.iter().map(|f| f[0]).collect::<Vec<_>>());
            let kept = &found[..kept.min(harmonics)];
            let back = basis.synthesize3(kept);
            let alone = basis.synthesize(&kept.iter().map(|f| f[2]).collect::<Vec<_>>());
            for v in 0..n {
                for c in 0..3 {
                    let sum: f64 = kept.iter().enumerate().map(|(k, f)| basis.harmonic(k)[v] * f[c]).sum();
                    prop_assert!((back[v][c] - sum).abs() < 1e-12);
                }
                prop_assert_eq!(alone[v], back[v][2]);
            }
        }
    }
}
