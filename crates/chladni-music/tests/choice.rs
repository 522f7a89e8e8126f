//! Equally good harmonics play alike, whichever of them a solver returns: neither their signs nor a rotation among
//! those of one eigenvalue matters.
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::sync::Arc;

use chladni_harmonics::{BasisSettings, Body};
use chladni_mesh::{TriMesh, samples};
use chladni_music::{Bands, Dancer, Form, Mapping, Player, Playing, Symmetry};
use chladni_synth::displacements_f64;
use chladni_task::Task;
use proptest::prelude::*;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

const BANDS: usize = 40;

/// Rotates the harmonics of each eigenvalue at random, and turns all at random.
fn disturbed(body: &Body, seed: u64) -> Body {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut basis = (*body.basis).clone();
    let (n, lambda) = (basis.vertices(), basis.eigenvalues.clone());
    let mut start = 0;
    for k in 1..=lambda.len() {
        if k < lambda.len() && lambda[k] - lambda[k - 1] < 1e-7 * lambda[k] {
            continue;
        }
        let turn = orthogonal(k - start, &mut rng);
        let old = basis.vectors[start * n..k * n].to_vec();
        for (j, row) in turn.iter().enumerate() {
            for v in 0..n {
                basis.vectors[(start + j) * n + v] =
                    row.iter().enumerate().map(|(i, c)| c * old[i * n + v]).sum();
            }
        }
        start = k;
    }
    Body { basis: Arc::new(basis), ..body.clone() }
}

fn orthogonal(size: usize, rng: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
    let mut rows: Vec<Vec<f64>> = Vec::new();
    while rows.len() < size {
        let mut row: Vec<f64> = (0..size).map(|_| rng.random::<f64>() - 0.5).collect();
        for _ in 0..2 {
            for known in &rows {
                let along: f64 = row.iter().zip(known).map(|(a, b)| a * b).sum();
                row.iter_mut().zip(known).for_each(|(a, b)| *a -= along * b);
            }
        }
        let length = row.iter().map(|c| c * c).sum::<f64>().sqrt();
        if length > 1e-3 {
            rows.push(row.into_iter().map(|c| c / length).collect());
        }
    }
    rows
}

/// A song's moment: every band sounds, each a little differently and elsewhere in the stereo picture.
fn played(body: &Body, form: Form, stereo_mu: f32) -> Vec<[f64; 3]> {
    let symmetry = Symmetry::of(body, &Task::new()).unwrap();
    let body = symmetry.rotated(body);
    let dancer =
        Arc::new(Dancer::new(&body, &symmetry.classes, &chladni_mesh::Orientation::default()).unwrap());
    let wave = |step: f32| (0..BANDS).map(|b| 0.3 + 0.25 * (b as f32 * step).sin()).collect::<Vec<f32>>();
    let (left, right) = (wave(0.7), wave(1.9));
    let mean = |sign: f32| left.iter().zip(&right).map(move |(l, r)| 0.5 * (l + sign * r));
    let mid: Vec<f32> = mean(1.0).collect();
    let side: Vec<f32> = mean(-1.0).map(|u| 4.0 * u.abs()).collect();
    let bands = Bands { left: &left, right: &right, mid: &mid, side: &side, side_gain: 4.0, ringing: None };
    let transfer = (0..BANDS).map(|b| b as f32 / (BANDS - 1) as f32).collect();
    let mapping = Mapping { transfer, amplification: vec![1.0, 0.6, 0.8], stereo_mu, gain: 1.0 };
    // Well below the limit, which is taken at probes.
    let playing = Playing { form, gain: 0.02, ..Playing::default() };
    let mut player = Player::new(&mapping, &dancer, BANDS, playing).unwrap();
    let mut item = player.item();
    player.play(&bands, &mut item).unwrap();
    displacements_f64(&body, &item).unwrap()
}

fn same(mesh: &TriMesh, harmonics: usize, seed: u64) -> Result<(), TestCaseError> {
    let body = Body::build(mesh, &BasisSettings::new(harmonics), &Task::new()).unwrap();
    let other = disturbed(&body, seed);
    for form in [Form::Filter, Form::Modal, Form::HalfMask] {
        let (here, there) = (played(&body, form, 0.4), played(&other, form, 0.4));
        let farthest = here.iter().flatten().fold(0.0f64, |m, c| m.max(c.abs()));
        let off =
            here.iter().flatten().zip(there.iter().flatten()).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
        prop_assert!(farthest > 1e-4, "{:?} stands still", form);
        prop_assert!(off < 1e-4 * farthest, "{form:?} of {} vertices: {off:e} of {farthest:e}", here.len());
    }
    Ok(())
}

/// A ring with three twisted ridges: turned by a third it is the same, mirrored it is not.
fn propeller() -> TriMesh {
    const AROUND: u32 = 18;
    const ALONG: u32 = 9;
    let angle = |i: u32, of: u32| std::f64::consts::TAU * f64::from(i) / f64::from(of);
    let places = (0..AROUND).flat_map(|i| (0..ALONG).map(move |j| (i, j)));
    let positions = places.clone().map(|(i, j)| {
        let (theta, phi) = (angle(i, AROUND), angle(j, ALONG));
        let thick = 0.7 * (1.0 + 0.6 * (3.0 * theta + phi).cos());
        let out = 2.0 + thick * phi.cos();
        [out * theta.cos(), out * theta.sin(), thick * phi.sin()]
    });
    let at = |i: u32, j: u32| (i % AROUND) * ALONG + j % ALONG;
    let triangles = places.flat_map(|(i, j)| {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    TriMesh { positions: positions.collect(), triangles: triangles.collect(), ..TriMesh::default() }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    #[test]
    fn a_ball_dances_the_same_whatever_harmonics_it_is_given(seed in any::<u64>()) {
        // The three, the five and the three and four of the lowest tones of a ball are all there.
        same(&samples::icosphere(2), 16, seed)?;
    }

    #[test]
    fn so_does_what_repeats_itself_and_has_no_mirror(seed in any::<u64>()) {
        let body = Body::build(&propeller(), &BasisSettings::new(12), &Task::new()).unwrap();
        let lambda = &body.basis.eigenvalues;
        prop_assert!(lambda.windows(2).any(|pair| pair[1] - pair[0] < 1e-7 * pair[1]), "{lambda:?}");
        let symmetry = Symmetry::of(&body, &Task::new()).unwrap();
        prop_assert_eq!(symmetry.method, chladni_music::SymmetryMethod::Vote);
        same(&propeller(), 12, seed)?;
    }

    #[test]
    fn so_does_a_pillar_and_what_has_no_symmetry_at_all(seed in any::<u64>()) {
        let of = |shape: fn([f64; 3]) -> [f64; 3]| {
            let mut mesh = samples::icosphere(2);
            mesh.positions.iter_mut().for_each(|p| *p = shape(*p));
            mesh
        };
        same(&of(|[x, y, z]| [x, 1.6 * y, z]), 14, seed)?;
        let crooked = |[x, y, z]: [f64; 3]| [x + 0.5 * y * z, 1.7 * y + 0.3 * x * x * z, 0.6 * z + 0.2 * x * y];
        same(&of(crooked), 14, seed)?;
    }
}
