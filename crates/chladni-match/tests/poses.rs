//! Which pose is found, and when another one is reported to fit as well.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use chladni_match::{Match, MatchSettings, Method, Similarity, match_shapes};
use chladni_mesh::{TriMesh, load_mesh, samples};
use chladni_task::Task;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn icp(shape: &TriMesh, template: &TriMesh) -> Match {
    let settings = MatchSettings { method: Method::Icp, ..MatchSettings::default() };
    match_shapes(shape, template, &settings, &Task::new()).unwrap()
}

fn moved(mesh: &TriMesh, map: impl Fn([f64; 3]) -> [f64; 3]) -> TriMesh {
    let mut moved = mesh.clone();
    moved.positions.iter_mut().for_each(|p| *p = map(*p));
    moved
}

/// Any rotation, a size between a hundredth and a hundred times, any place.
fn random_similarity(rng: &mut ChaCha8Rng) -> Similarity {
    let mut draw = || -> [f64; 3] { std::array::from_fn(|_| rng.random_range(-1.0..1.0)) };
    // The best rotation between random points is a random rotation.
    let (from, to) = ([draw(), draw(), draw()], [draw(), draw(), draw()]);
    let turn = Similarity::fit(&from, &to, None, chladni_match::Scaling::Rigid).unwrap();
    let ([size, _, _], place) = (draw(), draw());
    let scale = 100_f64.powf(size);
    Similarity { scale, translation: place.map(|x| 1000.0 * scale * x), ..turn }
}

#[test]
fn heads_and_animals_find_themselves_however_they_are_moved() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for name in ["animals/goathead.obj", "animals/spot.obj", "heads/target.obj"] {
        let Some(path) = chladni_testdata::shared(&format!("meshes/{name}")) else { return };
        let shape = load_mesh(&path).unwrap().mesh;
        let pose = random_similarity(&mut rng);
        let found = icp(&shape, &moved(&shape, |p| pose.apply(p)));
        let (low, high) =
            shape.positions.iter().flatten().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
        for (x, p) in found.correspondence.target.iter().flatten().zip(shape.positions.iter().flatten()) {
            assert!((x - p).abs() < 1e-5 * (high - low), "{name}: {x} {p}");
        }
        assert!(!found.report.near_tie && found.report.coverage > 0.95, "{name}: {:?}", found.report);
    }
}

#[test]
fn shapes_that_can_be_turned_onto_themselves_are_near_ties() {
    let sphere = samples::icosphere(3);
    let ellipsoid = moved(&sphere, |[x, y, z]| [x, 0.8 * y, 0.6 * z]);
    for shape in [&sphere, &ellipsoid, &samples::torus(0.4, 32, 16)] {
        let found = icp(shape, shape);
        assert!(found.report.near_tie && !found.report.warnings.is_empty(), "{:?}", found.report);
    }
}

/// An egg with a nose and, lower on one side, an ear.
fn egg(nose: f64, ear: f64, width: f64) -> TriMesh {
    let bump = |p: [f64; 3], at: [f64; 3]| {
        let d2: f64 = (0..3).map(|i| (p[i] - at[i]).powi(2)).sum();
        (-d2 / 0.04).exp()
    };
    moved(&samples::icosphere(4), |p| {
        let out = 1.0 + nose * bump(p, [1.0, 0.0, 0.0]) + ear * bump(p, [0.0, 0.9, -0.436]);
        [out * p[0], width * out * p[1], 1.2 * out * p[2]]
    })
}

#[test]
fn a_nose_and_an_ear_settle_what_the_egg_leaves_open() {
    // Two different people: neither is a similar copy of the other.
    let found = icp(&egg(0.3, 0.25, 0.85), &egg(0.22, 0.3, 0.9));
    assert!(!found.report.near_tie, "{:?}", found.report);
    let turn = found.correspondence.similarity.rotation;
    let trace: f64 = (0..3).map(|i| turn[i][i]).sum();
    assert!(trace > 2.9, "not turned: {turn:?}");
    // Without nose and ear, three half-turns fit equally well.
    assert!(icp(&egg(0.0, 0.0, 0.85), &egg(0.0, 0.0, 0.9)).report.near_tie);
}

#[test]
fn heads_of_different_people_are_no_near_ties() {
    let Some(max) = chladni_testdata::shared("meshes/heads/decimated-max.obj") else { return };
    let Some(igea) = chladni_testdata::shared("meshes/heads/igea.ply") else { return };
    let found = icp(&load_mesh(&max).unwrap().mesh, &load_mesh(&igea).unwrap().mesh);
    assert!(!found.report.near_tie, "{:?}", found.report);
}
