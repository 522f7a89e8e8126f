//! Measures the time for the product of a basis with the columns of S items, positions included, against
//! the `gemm` crate on the same numbers, alternating in one process. Prints a JSON line per case.
//!
//! Usage: `product_peers [THREADS]`; `bench/synth/run` compares it with NumPy.
#![allow(clippy::print_stdout, reason = "a program")]

use std::time::Instant;

use chladni_synth::{Coefficients, CpuSynthesizer, Item, SynthModel, Synthesizer, Term};

/// n, K and S.
const CASES: [(usize, usize, usize); 6] = [
    (50_000, 512, 1),
    (50_000, 512, 6),
    (50_000, 512, 12),
    (50_000, 1008, 12),
    (34_834, 1070, 12),
    (97_803, 256, 12),
];

const ROUNDS: usize = 15;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let threads = std::env::args().nth(1).map_or(Ok(0), |n| n.parse())?;
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global()?;
    for (n, harmonics, items) in CASES {
        let basis: Vec<f64> = (0..n * harmonics).map(|i| ((i % 9973) as f64 * 0.37).sin()).collect();
        let model = SynthModel::from_parts(&vec![[0.0; 3]; n], &[], &basis)?;
        let frame: Vec<Item> = (0..items).map(|s| item(harmonics, s)).collect();
        let mut synthesizer = CpuSynthesizer::new(model);

        let narrow: Vec<f32> = basis.iter().map(|&h| h as f32).collect();
        let columns = 3 * items;
        let weights: Vec<f32> = (0..columns * harmonics)
            .map(|i| weight(i % harmonics, i / harmonics / 3, i / harmonics % 3))
            .collect();
        let mut product = vec![0.0_f32; n * columns];

        let (mut ours, mut gemms) = (Vec::new(), Vec::new());
        for _ in 0..ROUNDS {
            let start = Instant::now();
            synthesizer.synthesize_positions(&frame)?;
            ours.push(1e3 * start.elapsed().as_secs_f64());
            let start = Instant::now();
            multiply(&narrow, &weights, &mut product, n, harmonics, columns);
            gemms.push(1e3 * start.elapsed().as_secs_f64());
        }
        let difference =
            (0..n).map(|v| (synthesizer.positions(0)[v][0] - product[v]).abs()).fold(0.0, f32::max);
        assert!(difference < 1e-2, "both compute the same: {difference}");
        println!(
            r#"{{"vertices": {n}, "harmonics": {harmonics}, "columns": {columns}, "threads": {}, "chladni_ms": {:.3}, "gemm_ms": {:.3}}}"#,
            rayon::current_num_threads(),
            median(ours),
            median(gemms)
        );
    }
    Ok(())
}

fn weight(k: usize, s: usize, axis: usize) -> f32 {
    ((k + 7 * s + 3 * axis) as f32).sin() / (1.0 + k as f32)
}

fn item(harmonics: usize, s: usize) -> Item {
    let coefficients =
        Coefficients::Vector((0..harmonics).map(|k| [0, 1, 2].map(|axis| weight(k, s, axis))).collect());
    Item { terms: vec![Term { coefficients, residual: None, residual_gain: 0.0, mask: None }] }
}

/// product = basis (n×K) × weights (K×columns), all column-major.
#[allow(unsafe_code, reason = "the crate measured against takes pointers")]
fn multiply(basis: &[f32], weights: &[f32], product: &mut [f32], n: usize, harmonics: usize, columns: usize) {
    assert!(
        basis.len() == n * harmonics && weights.len() == harmonics * columns && product.len() == n * columns
    );
    // SAFETY: shapes and strides are those just checked.
    unsafe {
        gemm::gemm(
            n,
            columns,
            harmonics,
            product.as_mut_ptr(),
            n as isize,
            1,
            false,
            basis.as_ptr(),
            n as isize,
            1,
            weights.as_ptr(),
            harmonics as isize,
            1,
            0.0,
            1.0,
            false,
            false,
            false,
            gemm::Parallelism::Rayon(0),
        );
    }
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
