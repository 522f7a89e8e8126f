//! Shapes of many pieces.

use super::*;

/// So many copies of `mesh`, whose vertices go where `placed` says by the number of the copy.
fn copies(
    mesh: &chladni_mesh::TriMesh,
    count: u32,
    placed: impl Fn(u32, &[f64; 3]) -> [f64; 3] + Copy,
) -> chladni_mesh::TriMesh {
    let n = mesh.positions.len() as u32;
    chladni_mesh::TriMesh {
        positions: (0..count).flat_map(|i| mesh.positions.iter().map(move |p| placed(i, p))).collect(),
        triangles: (0..count)
            .flat_map(|i| mesh.triangles.iter().map(move |t| t.map(|v| v + i * n)))
            .collect(),
        ..Default::default()
    }
}

/// Six balls side by side. Of different sizes: harmonics of equal balls are mixtures over all of them.
fn balls(ball: &chladni_mesh::TriMesh) -> chladni_mesh::TriMesh {
    let placed = |i: u32, p: &[f64; 3]| {
        let size = 1.0 + 0.1 * f64::from(i);
        [size * p[0] + 4.0 * f64::from(i), size * p[1], size * p[2]]
    };
    copies(ball, 6, placed)
}

#[test]
fn of_many_pieces_each_stays_in_its_place_however_few_harmonics_a_template_keeps() {
    let mesh = balls(&chladni_mesh::samples::icosphere(2));
    let body = Arc::new(Body::build(&mesh, &BasisSettings::new(60), &Task::new()).unwrap());
    let mut stack = Stack::new(body.clone()).unwrap();
    let mut project = Project::new(ShapeSource::Sample("balls".into()), 60);
    // Of a ball the three softest harmonics are all there is: no detail to exaggerate.
    project.push(Layer { mu: -1.0, ..Layer::new("detail", Template::LowPass(1 + 6 * 3)) }).unwrap();
    let result = stack.evaluate(&project).file_positions(&body, &mesh.positions);
    assert!(largest(&result, &mesh.positions) < 0.05, "{}", largest(&result, &mesh.positions));
    let alone = self_low_passed(&body, &mesh.positions, 1 + 6 * 3).unwrap();
    assert!(largest(&alone.target, &mesh.positions) < 0.05);
}

#[test]
fn no_low_pass_tears_pieces_for_which_there_are_too_few_harmonics() {
    let mesh = balls(&chladni_mesh::samples::icosphere(0));
    let low_passed = |harmonics| {
        let body = Body::build(&mesh, &BasisSettings::new(harmonics), &Task::new()).unwrap();
        self_low_passed(&body, &mesh.positions, 1)
    };
    let refused = low_passed(4).unwrap_err().to_string();
    assert!(refused.contains("more harmonics"), "{refused}");
    assert!(low_passed(7).is_ok());
}

#[test]
fn of_many_pieces_each_keeps_its_own_region_however_soft() {
    let ball = chladni_mesh::samples::icosphere(2);
    let n = ball.positions.len();
    let mesh = balls(&ball);
    let body = Arc::new(Body::build(&mesh, &BasisSettings::new(60), &Task::new()).unwrap());
    // The fifth ball, and half of the last.
    let painted: Vec<f32> = (0..6 * n)
        .map(|v| if v / n == 4 || (v / n == 5 && ball.positions[v % n][2] > 0.0) { 1.0 } else { 0.0 })
        .collect();
    // Longer than all waves of a ball, and a little shorter than the longest.
    let waves = wavelengths(&body.basis);
    for (roll_off, wavelength, soft) in [
        (RollOff::Sharp, 10.0, true),
        (RollOff::Heat, 10.0, true),
        (RollOff::Sharp, waves[24], false),
        (RollOff::Heat, waves[24], false),
    ] {
        let smoothing = Smoothing { wavelength, roll_off, clamp: false };
        let chi = smoothing.apply(&body, &painted).unwrap();
        for (v, x) in chi.iter().enumerate().take(5 * n) {
            let expected = if v / n == 4 { 1.0 } else { 0.0 };
            assert!((x - expected).abs() < 1e-4, "{smoothing:?}: {x} on ball {}", v / n);
        }
        if soft {
            continue;
        }
        let half = |up: f64| {
            let there = (0..n).filter(|v| up * ball.positions[*v][2] > 0.5);
            there.map(|v| chi[5 * n + v]).collect::<Vec<f32>>()
        };
        let (painted, bare) =
            (half(1.0).into_iter().fold(1.0, f32::min), half(-1.0).into_iter().fold(0.0, f32::max));
        assert!(painted > 0.6 && bare < 0.4, "{smoothing:?}: {painted} and {bare}");
    }
}

/// One or two lumps whose triangles are small on one side and large on the other, so that the centroid of
/// the triangles and that of the operator's areas differ.
fn uneven(pieces: u32) -> chladni_mesh::TriMesh {
    let ball = chladni_mesh::samples::icosphere(3);
    let placed = |i: u32, p: &[f64; 3]| {
        let q = [p[0], p[1], p[2] + 0.75];
        let length = q.iter().map(|c| c * c).sum::<f64>().sqrt();
        let [x, y, z] = q.map(|c| c / length);
        let r = 1.0 + 0.25 * (3.0 * x).sin() * y + 0.15 * y * z;
        let size = 1.0 - 0.4 * f64::from(i);
        [size * r * x + 2.2 * f64::from(i), 0.8 * size * r * y, 1.2 * size * r * z]
    };
    copies(&ball, pieces, placed)
}

#[test]
fn the_distance_model_leaves_pieces_for_which_there_are_too_few_harmonics() {
    let mesh = balls(&chladni_mesh::samples::icosphere(1));
    let body = Arc::new(Body::build(&mesh, &BasisSettings::new(4), &Task::new()).unwrap());
    let mut stack = Stack::new(body.clone()).unwrap();
    let mut project = Project::new(ShapeSource::Sample("balls".into()), 4);
    project.push(Layer { model: Model::Distance, mu: -2.4, ..Layer::new("", Template::Ellipsoid) }).unwrap();
    for request in stack.missing(&project) {
        let matched = request.run(&mesh, &body, None, &Task::new());
        stack.install(request, matched);
    }
    let result = stack.evaluate(&project).file_positions(&body, &mesh.positions);
    assert!(largest(&result, &mesh.positions) < 1e-9, "{}", largest(&result, &mesh.positions));
}

/// A constant has a place and no shape: on triangles of unlike size, on a layer that starts from the result
/// of another, and of two pieces, the distance model moves no piece as a whole, and so tears no region out.
#[test]
fn the_distance_model_moves_no_piece_as_a_whole() {
    for pieces in [1_u32, 2] {
        let mesh = uneven(pieces);
        let body = Arc::new(Body::build(&mesh, &BasisSettings::new(48), &Task::new()).unwrap());
        let mut stack = Stack::new(body.clone()).unwrap();
        let mut project = Project::new(ShapeSource::Sample("uneven".into()), 48);
        let ball = Painted::Spheres(vec![Sphere { center: [0.8, 0.0, 0.3], radius: 0.7 }]);
        let region = Region { painted: ball, smoothing: Smoothing::default() };
        let lower = Layer { mu: -2.0, region: region.clone(), ..Layer::new("lower", Template::Ellipsoid) };
        project.push(lower).unwrap();
        let distance = Layer { model: Model::Distance, mu: -8.0, ..Layer::new("", Template::Sphere) };
        project.push(distance.clone()).unwrap();
        for request in stack.missing(&project) {
            let matched = request.run(&mesh, &body, None, &Task::new());
            stack.install(request, matched);
        }
        let zeros = body.basis.eigenvalues.iter().filter(|l| **l == 0.0).count();
        assert_eq!(zeros, pieces as usize);
        let norm = |c: &[f64; 3]| c.iter().map(|c| c * c).sum::<f64>().sqrt();
        let evaluation = stack.evaluate(&project);
        for (base, least) in [(stack.original(), 1e-6), (&evaluation.layers[1].base, 1e-3)] {
            let amplitudes: Vec<f64> = base.spectrum().iter().map(norm).collect();
            let largest = amplitudes.iter().copied().fold(0.0, f64::max);
            assert!(amplitudes[0] > least * largest, "{} of {largest} is no noise", amplitudes[0]);
        }
        let layer = &evaluation.layers[1];
        let psi = layer.difference.as_ref().unwrap().psi();
        assert!(psi.psi.iter().enumerate().all(|(k, psi)| (*psi == 0.0) == (k < zeros)));
        let moved = layer.displacement.as_ref().unwrap();
        let n = mesh.positions.len() / pieces as usize;
        for piece in 0..pieces as usize {
            let (mut sum, mut size) = ([0.0; 3], 0.0);
            for v in piece * n..(piece + 1) * n {
                let a = body.basis.mass[v];
                (0..3).for_each(|c| sum[c] += a * moved[v][c]);
                size += a * norm(&moved[v]);
            }
            assert!(size > 1e-3 && norm(&sum) < 1e-9 * size, "{sum:?} of {size} on piece {piece}");
        }
        // In a region, it moves what it moved without, as far as the region says.
        let mut masked = Project::new(ShapeSource::Sample("uneven".into()), 48);
        masked.push(project.layers()[0].1.as_ref().clone()).unwrap();
        masked.push(Layer { region, ..distance.clone() }).unwrap();
        let evaluation = stack.evaluate(&masked);
        let layer = &evaluation.layers[1];
        let (mask, inside) = (layer.mask.as_ref().unwrap(), layer.displacement.as_ref().unwrap());
        for ((d, all), chi) in inside.iter().zip(moved.iter()).zip(mask.iter()) {
            assert!((0..3).all(|c| (d[c] - f64::from(*chi) * all[c]).abs() < 1e-12));
        }
    }
}
