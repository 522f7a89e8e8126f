//! Projects that keep triangles.

use super::*;

/// Limits every layer of `project`, the lowest first; how many there were.
fn settle(stack: &mut Stack, project: &Project) -> usize {
    let mut settled = 0;
    while let Some(request) = stack.unsettled(project) {
        let kept = request.run(&Task::new());
        stack.settle(request, kept);
        settled += 1;
    }
    settled
}

#[test]
fn a_project_that_keeps_triangles_neither_folds_nor_crosses_and_off_it_is_what_it_was() {
    let (_, mut stack) = stack();
    let surface = stack.surface().clone();
    let crossings = Crossings::of(surface.clone());
    for model in Model::ALL {
        let mut project = Project::new(ShapeSource::Sample("lump".into()), 64);
        let layer = Layer { model, mu: -14.0, ..Layer::new("much", Template::LowPass(6)) };
        let id = project.push(layer).unwrap();
        let before = stack.evaluate(&project);
        assert!(before.layers[0].folds(&surface) > 3, "{model}: nothing to do");
        assert!(stack.unsettled(&project).is_none());
        project.apply(&Action::KeepTriangles(true), None).unwrap();
        assert_eq!(settle(&mut stack, &project), 1);
        let after = stack.evaluate(&project);
        let kept = after.layers[0].kept.clone().unwrap();
        // 1280 triangles: less than one in a thousand of each.
        let crossing = crossings.triangles(&after.result.positions, &Task::new()).unwrap().len();
        let folds = after.layers[0].folds(&surface);
        assert_eq!((folds, crossing), (kept.folded, kept.crossing));
        assert!(folds <= 1 && crossing <= 1, "{model}: {folds}, {crossing}");
        assert!(kept.share > 0.3, "{model}: {}", kept.share);
        assert_eq!(after.layers[0].unlimited.as_deref(), before.layers[0].displacement.as_deref());
        // Until another μ is limited it goes no farther than the last one where that was held back.
        project.apply(&Action::Set { layer: id, to: Property::Mu(-20.0) }, None).unwrap();
        let dragged = stack.evaluate(&project).layers.remove(0);
        assert!(dragged.kept.is_none());
        let length = |d: &[f64; 3]| d.iter().map(|c| c * c).sum::<f64>().sqrt();
        let all = |d: &[[f64; 3]]| d.iter().map(length).sum::<f64>();
        assert!(all(&dragged.displacement.unwrap()) < all(&dragged.unlimited.unwrap()));
        project.apply(&Action::Set { layer: id, to: Property::Mu(-14.0) }, None).unwrap();
        project.apply(&Action::KeepTriangles(false), None).unwrap();
        assert_eq!(stack.evaluate(&project).result.positions, before.result.positions);
    }
}

#[test]
fn a_layer_that_could_not_be_limited_says_why_once() {
    let (_, mut stack) = stack();
    let mut project = Project::new(ShapeSource::Sample("lump".into()), 64);
    project.push(Layer { mu: -14.0, ..Layer::new("much", Template::LowPass(6)) }).unwrap();
    project.apply(&Action::KeepTriangles(true), None).unwrap();
    let request = stack.unsettled(&project).unwrap();
    let broke_off = CaricatureError::Elsewhere("it broke off".into());
    stack.settle(request, Err(broke_off));
    let said = LayerState::Failed("its triangles cannot be kept: it broke off".into());
    assert_eq!(stack.evaluate(&project).layers[0].state, said);
}

#[test]
fn what_needs_no_limit_keeps_all_of_its_movement_and_layers_settle_upward() {
    let (mesh, mut stack) = stack();
    let mut project = project();
    for (layer, mu) in project.layers().iter().map(|(id, _)| *id).zip([-0.2, -0.2, -0.1]).collect::<Vec<_>>()
    {
        project.apply(&Action::Set { layer, to: Property::Mu(mu) }, None).unwrap();
    }
    let plain = stack.evaluate(&project);
    project.apply(&Action::KeepTriangles(true), None).unwrap();
    assert_eq!(settle(&mut stack, &project), 3);
    let kept = stack.evaluate(&project);
    assert!(kept.layers.iter().all(|l| (l.kept.as_ref().unwrap().share - 1.0).abs() < 0.05));
    assert!(largest(&kept.result.positions, &plain.result.positions) < 0.05);
    for layer in project.layers().iter().map(|(id, _)| *id).collect::<Vec<_>>() {
        project.apply(&Action::Set { layer, to: Property::Mu(0.0) }, None).unwrap();
    }
    settle(&mut stack, &project);
    let still = stack.evaluate(&project).file_positions(stack.body(), &mesh.positions);
    assert_eq!(still, mesh.positions);
}

/// Two small balls inside a large one, of as many vertices each.
fn balls() -> (usize, chladni_mesh::TriMesh) {
    let ball = chladni_mesh::samples::icosphere(3);
    let placed = |size: f64, at: [f64; 3]| {
        ball.positions
            .iter()
            .map(move |p| std::array::from_fn(|i| size * p[i] + at[i]))
            .collect::<Vec<[f64; 3]>>()
    };
    let n = ball.positions.len();
    let parts = [placed(1.0, [0.0; 3]), placed(0.1, [0.8, 0.0, 0.0]), placed(0.1, [-0.8, 0.0, 0.0])];
    let mesh = chladni_mesh::TriMesh {
        positions: parts.concat(),
        triangles: (0..3)
            .flat_map(|i| ball.triangles.iter().map(move |t| t.map(|v| v + i * n as u32)))
            .collect(),
        ..Default::default()
    };
    (n, mesh)
}

/// The positions of `mesh` after a layer toward `template` with this region, triangles kept.
fn moved_toward(template: Vec<[f64; 3]>, mesh: &chladni_mesh::TriMesh, painted: Painted) -> Vec<[f64; 3]> {
    let template = chladni_mesh::TriMesh { positions: template, ..mesh.clone() };
    let body = Arc::new(Body::build(mesh, &BasisSettings::new(64), &Task::new()).unwrap());
    let mut stack = Stack::new(body.clone()).unwrap();
    let mut project = Project::new(ShapeSource::Sample("balls".into()), 64);
    project.keep_triangles = true;
    let matching = MatchSettings {
        method: Method::Same,
        scaling: chladni_match::Scaling::Rigid,
        ..MatchSettings::default()
    };
    let mut layer =
        Layer { matching, infill: 0.0, mu: 1.0, ..Layer::new("wide", Template::File("wide.ply".into())) };
    layer.region.painted = painted;
    project.push(layer).unwrap();
    let request = stack.missing(&project).remove(0);
    let matched = request.run(mesh, &body, Some(&template), &Task::new());
    stack.install(request, matched);
    settle(&mut stack, &project);
    stack.evaluate(&project).file_positions(&body, &mesh.positions)
}

#[test]
fn small_pieces_keep_their_form_and_go_with_what_is_around_them() {
    let (n, mesh) = balls();
    // The large one is stretched.
    let template = mesh.positions.iter().map(|[x, y, z]| [1.5 * x, *y, *z]).collect();
    let result = moved_toward(template, &mesh, Painted::Everywhere);
    let extent = |of: std::ops::Range<usize>, axis: usize| {
        let all = result[of].iter().map(|p| p[axis]);
        let (low, high) = all.fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
        (high - low, 0.5 * (high + low))
    };
    assert!(extent(0..n, 0).0 > 2.8, "the large one is stretched");
    for (piece, side) in [(1, 1.0), (2, -1.0)] {
        let (width, place) = extent(piece * n..(piece + 1) * n, 0);
        assert!((width - 0.2).abs() < 0.01, "{width}");
        assert!(side * place > 1.0, "{place}");
    }
}

#[test]
fn a_small_piece_that_is_painted_alone_moves() {
    let (n, mesh) = balls();
    let piece = n..2 * n;
    let mut template = mesh.positions.clone();
    template[piece.clone()].iter_mut().for_each(|p| p[1] += 0.1);
    let painted = (0..3 * n).map(|v| f32::from(u8::from(piece.contains(&v)))).collect();
    let result = moved_toward(template, &mesh, Painted::Vertices(painted));
    let height = result[piece].iter().map(|p| p[1]).sum::<f64>() / n as f64;
    assert!(height > 0.02, "{height}");
    assert!(largest(&result[2 * n..], &mesh.positions[2 * n..]) < 1e-9);
}
