//! Sand on plates: Chladni's figures, and what must hold of grains on any surface.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a panic is how a test fails, and docs quote its figures"
)]

use std::f64::consts::PI;
use std::sync::{Arc, OnceLock};

use chladni_harmonics::{BasisSettings, Body};
use chladni_mesh::samples;
use chladni_music::{SAND_STEP_SECS, Sand, Tray};
use chladni_synth::{Coefficients, Item, Term};
use chladni_task::Task;

const GRAINS: usize = 10_000;
/// How far a full movement goes.
const FULL: f32 = 0.1;

fn body(name: &str) -> (Body, Arc<Tray>) {
    let mesh = samples::sample(name).unwrap();
    let body = Body::build(&mesh, &BasisSettings::new(40), &Task::new()).unwrap();
    let tray = Arc::new(Tray::new(&body));
    (body, tray)
}

fn plate() -> &'static (Body, Arc<Tray>) {
    static PLATE: OnceLock<(Body, Arc<Tray>)> = OnceLock::new();
    PLATE.get_or_init(|| body("plate"))
}

/// Harmonics that sound along the normals, by number and amplitude.
fn sounding(harmonics: &[(usize, f32)]) -> Item {
    let mut c = vec![0.0; 40];
    harmonics.iter().for_each(|&(k, amplitude)| c[k] = amplitude);
    let coefficients = Coefficients::Normal(c);
    Item { terms: vec![Term { coefficients, residual: None, residual_gain: 0.0, mask: None }] }
}

fn steps(secs: f64) -> usize {
    (secs / SAND_STEP_SECS).round() as usize
}

/// The grains in the square [0, 1]² of the plate.
fn places(body: &Body, sand: &Sand) -> Vec<[f64; 2]> {
    let scale = body.positions.iter().map(|p| p[0].abs()).fold(0.0, f64::max);
    let place = |at: &chladni_mesh::surface::SurfacePoint| {
        let p = at.position(&body.triangles, |v| body.positions[v as usize]).unwrap();
        [0.5 + 0.5 * p[0] / scale, 0.5 + 0.5 * p[2] / scale]
    };
    sand.places().iter().map(place).collect()
}

/// The harmonic of eigenvalue π² (m² + n²) on the unit square.
fn harmonic(body: &Body, m: usize, n: usize) -> usize {
    let scale = body.positions.iter().map(|p| p[0].abs()).fold(0.0, f64::max);
    let wanted = PI * PI * (m * m + n * n) as f64 / (4.0 * scale * scale);
    let off = |k: &usize| (body.basis.eigenvalues[*k] - wanted).abs();
    (0..40).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap()
}

/// The share of the grains that lie within `reach` of a place where `field` changes its sign.
fn share_near(places: &[[f64; 2]], field: impl Fn(f64, f64) -> f64, reach: f64) -> f64 {
    let near = |&[x, y]: &[f64; 2]| {
        let here = field(x, y);
        (0..48).any(|i| {
            let (s, c) = (PI * f64::from(i) / 24.0).sin_cos();
            let there = field((x + reach * c).clamp(0.0, 1.0), (y + reach * s).clamp(0.0, 1.0));
            here * there <= 0.0
        })
    };
    places.iter().filter(|at| near(at)).count() as f64 / places.len() as f64
}

#[test]
fn on_a_square_plate_sand_draws_the_nodal_lines_of_one_harmonic() {
    let (body, tray) = plate();
    // Of simple eigenvalues: no other m² + n² is the same.
    for m in [1, 2, 3] {
        let k = harmonic(body, m, m);
        for amplitude in [0.2 * FULL, FULL] {
            let mut sand = Sand::pour(Arc::clone(tray), GRAINS, 7);
            let item = sounding(&[(k, amplitude)]);
            (0..steps(3.0)).for_each(|_| sand.step(&item, FULL));
            let wave = |x: f64| (m as f64 * PI * x).cos();
            let share = share_near(&places(body, &sand), |x, y| wave(x) * wave(y), 0.03);
            println!("({m}, {m}) at {amplitude}: {share:.3}");
            assert!(share >= 0.8, "({m}, {m}) at {amplitude}: {share}");
        }
    }
}

#[test]
fn on_a_square_plate_sand_draws_the_nodal_lines_of_a_mixture_of_equals() {
    let (body, tray) = plate();
    let first = harmonic(body, 1, 3).min(harmonic(body, 3, 1));
    let pair = [first, first + 1];
    assert!((body.basis.eigenvalues[pair[1]] / body.basis.eigenvalues[pair[0]] - 1.0).abs() < 1e-3);
    let amplitudes = [0.7 * FULL, 0.4 * FULL];
    let mut sand = Sand::pour(Arc::clone(tray), GRAINS, 1);
    let item = sounding(&[(pair[0], amplitudes[0]), (pair[1], amplitudes[1])]);
    (0..steps(3.0)).for_each(|_| sand.step(&item, FULL));
    // The weights of the drivers go with their energy. What part of cos πx cos 3πy and of its twin is in it?
    let scale = body.positions.iter().map(|p| p[0].abs()).fold(0.0, f64::max);
    let weights = [1.0, (amplitudes[1] / amplitudes[0]).powi(2)];
    let wave = |m: f64, x: f64| (m * PI * x).cos();
    let mut parts = [0.0; 2];
    for (v, p) in body.positions.iter().enumerate() {
        let (x, y) = (0.5 + 0.5 * p[0] / scale, 0.5 + 0.5 * p[2] / scale);
        let u: f64 = (0..2)
            .map(|i| {
                f64::from(weights[i] * amplitudes[i]) * body.basis.harmonic(pair[i])[v] * body.basis.mass[v]
            })
            .sum();
        parts[0] += u * wave(1.0, x) * wave(3.0, y);
        parts[1] += u * wave(3.0, x) * wave(1.0, y);
    }
    let field =
        |x: f64, y: f64| parts[0] * wave(1.0, x) * wave(3.0, y) + parts[1] * wave(3.0, x) * wave(1.0, y);
    let share = share_near(&places(body, &sand), field, 0.03);
    println!("{share:.3}");
    assert!(share >= 0.8, "{share}");
}

#[test]
fn no_grain_is_lost_in_quiet_all_rest_and_a_change_of_what_sounds_is_followed() {
    for name in ["ring", "bell"] {
        let (body, tray) = body(name);
        let mut sand = Sand::pour(tray, 3000, 3);
        let energy = |sand: &Sand, k: usize| -> f64 {
            let h = body.basis.harmonic(k);
            let at = |p: &chladni_mesh::surface::SurfacePoint| -> f64 {
                let corners = body.triangles[p.triangle as usize];
                (0..3).map(|c| p.weights[c] * h[corners[c] as usize]).sum::<f64>().powi(2)
            };
            sand.places().iter().map(at).sum::<f64>() / sand.count() as f64
        };
        let still = sand.places().to_vec();
        (0..steps(2.0)).for_each(|_| sand.step(&sounding(&[]), FULL));
        assert_eq!(sand.places(), still, "{name}: sand moves in silence");
        for k in [9, 30] {
            let before = energy(&sand, k);
            (0..steps(1.0)).for_each(|_| sand.step(&sounding(&[(k, FULL)]), FULL));
            let after = energy(&sand, k);
            assert!(after < 0.4 * before, "{name}, harmonic {k}: {before} to {after}");
            assert_eq!(sand.count(), 3000);
            for at in sand.places() {
                assert!((at.triangle as usize) < body.triangles.len());
                assert!(at.weights.iter().all(|w| (0.0..=1.0).contains(w)));
            }
        }
        // It dies away: the grains come to rest.
        (0..steps(5.0)).for_each(|_| sand.step(&sounding(&[]), FULL));
        let still = sand.places().to_vec();
        sand.step(&sounding(&[]), FULL);
        assert_eq!(sand.places(), still);
    }
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let (body, tray) = plate();
    let k = harmonic(body, 2, 2);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut sand = Sand::pour(Arc::clone(tray), 5000, 11);
            (0..90).for_each(|_| sand.step(&sounding(&[(k, FULL), (7, 0.3 * FULL)]), FULL));
            sand.places().to_vec()
        })
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn a_higher_tone_draws_a_finer_figure_that_the_middle_can_sound() {
    use chladni_music::{Class, Mapping};
    let classes: Vec<Class> =
        (0..300).map(|k| [Class::Symmetric, Class::Antisymmetric, Class::Undecided][k % 3]).collect();
    let eigenvalues: Vec<f64> = (0..300).map(f64::from).collect();
    let mapping = Mapping::figures(&eigenvalues, &classes, 128);
    mapping.validate().unwrap();
    let targets = mapping.targets(128, 300);
    assert!(targets.is_sorted() && targets[0] > 3 && targets[127] > 85 && targets[127] < 96, "{targets:?}");
    assert!(targets.iter().all(|k| classes[*k as usize] != Class::Antisymmetric));
    // Shapes of few harmonics have a mapping, too.
    (0..6).for_each(|k| Mapping::figures(&eigenvalues[..k], &classes[..k], 128).validate().unwrap());
}
