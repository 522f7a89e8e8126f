//! The kernels on a shape that is small enough for an interpreter of undefined behavior (Miri):
//! `scripts/sanitize --miri`.
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::sync::Arc;

use chladni_synth::{
    Coefficients, CpuPath, CpuSynthesizer, FrameSettings, Item, Residual, SynthModel, Synthesizer, Term,
};

/// 36 vertices are one whole panel and a partial one; K = 4.
const COLUMNS: usize = 6;
const N: usize = 36;
const K: usize = 4;

fn model() -> (Vec<[f64; 3]>, Vec<f64>, SynthModel) {
    let place = |v: usize| [(v % COLUMNS) as f64, (v / COLUMNS) as f64, 0.0];
    let positions: Vec<[f64; 3]> = (0..N).map(place).collect();
    let corner = |i: usize, j: usize| (COLUMNS * j + i) as u32;
    let squares = (0..COLUMNS - 1).flat_map(|j| (0..COLUMNS - 1).map(move |i| (i, j)));
    let triangles: Vec<[u32; 3]> = squares
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1)];
            [[a, b, c], [c, b, d]]
        })
        .collect();
    let basis: Vec<f64> = (0..N * K).map(|i| ((i % N) as f64 * 0.3 * (1 + i / N) as f64).cos()).collect();
    let model = SynthModel::from_parts(&positions, &triangles, &basis).unwrap();
    (positions, basis, model)
}

#[test]
fn every_path_deforms_a_small_shape() {
    let (rest, basis, model) = model();
    let weights = [0.4_f32, 0.0, -0.3, 0.2];
    let mask: Arc<[f32]> = (0..N).map(|v| (v % 3) as f32 * 0.5).collect();
    let residual: Arc<[[f32; 3]]> = (0..N).map(|v| [0.0, 0.1 * v as f32, 0.0]).collect();
    let item = Item {
        terms: vec![
            Term {
                coefficients: Coefficients::Vector(weights.map(|w| [w, 0.0, -w]).to_vec()),
                residual: Some(Residual::Vector(residual)),
                residual_gain: 0.5,
                mask: Some(Arc::clone(&mask)),
            },
            Term {
                coefficients: Coefficients::Normal(weights.to_vec()),
                residual: None,
                residual_gain: 0.0,
                mask: None,
            },
        ],
    };
    // Two threads are enough for a data race.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    for path in CpuPath::available() {
        let mut synthesizer = CpuSynthesizer::with_path(model.clone(), *path).unwrap();
        let items = [item.clone(), Item::default(), item.clone()];
        pool.install(|| synthesizer.synthesize(&items, &FrameSettings { normal_blending: 0.5 })).unwrap();
        for v in 0..N {
            let sum: f64 = (0..K).map(|k| basis[k * N + v] * f64::from(weights[k])).sum();
            let m = f64::from(mask[v]);
            // The rest normal is +z.
            let wanted = [rest[v][0] + m * sum, rest[v][1] + m * 0.05 * v as f64, rest[v][2] - m * sum + sum];
            for s in [0, 2] {
                let found = synthesizer.positions(s)[v];
                for c in 0..3 {
                    assert!(
                        (f64::from(found[c]) - wanted[c]).abs() < 1e-4,
                        "{path} {v} {found:?} {wanted:?}"
                    );
                }
            }
            assert_eq!(synthesizer.positions(1)[v], rest[v].map(|x| x as f32));
            let length: f32 = synthesizer.normals(0)[v].iter().map(|c| c * c).sum();
            assert!((length - 1.0).abs() < 1e-4);
        }
    }
}
