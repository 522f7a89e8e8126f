//! The layer stack on a small body: results, caching, terms, morph targets.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

#[path = "../bodies/mod.rs"]
mod bodies;
mod clones;
mod keeping;
mod pieces;

use std::sync::Arc;

use chladni_caricature::*;
use chladni_harmonics::{BasisSettings, Body};
use chladni_match::{MatchSettings, Method};
use chladni_synth::displacements_f64;
use chladni_task::Task;

fn sphere_region() -> Region {
    let painted = Painted::Spheres(vec![Sphere { center: [130.0, 0.0, -5.0], radius: 20.0 }]);
    Region { painted, smoothing: Smoothing { wavelength: usual_wavelength(20.0), ..Smoothing::default() } }
}

/// An ellipsoid layer, a low-pass layer in a region, the shape scaled down.
fn project() -> Project {
    let mut project = Project::new(ShapeSource::Sample("lump".into()), 64);
    let first = Layer { model: Model::Distance, mu: -1.5, ..Layer::new("whole", Template::Ellipsoid) };
    let second = Layer {
        model: Model::Normal,
        mu: -2.0,
        strength: 0.5,
        region: sphere_region(),
        curve: ScaleCurve::mid(),
        ..Layer::new("detail", Template::LowPass(16))
    };
    let third = Layer { mu: -0.4, ..Layer::new("magnify", Template::Scaled(0.9)) };
    for layer in [first, second, third] {
        project.push(layer).unwrap();
    }
    project
}

fn stack() -> (chladni_mesh::TriMesh, Stack) {
    let mesh = bodies::lump();
    let body = Arc::new(Body::build(&mesh, &BasisSettings::new(64), &Task::new()).unwrap());
    let mut stack = Stack::new(body.clone()).unwrap();
    for request in stack.missing(&project()) {
        let matched = request.run(&mesh, &body, None, &Task::new());
        stack.install(request, matched);
    }
    (mesh, stack)
}

fn largest(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let each = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs());
    each.fold(0.0, f64::max)
}

#[test]
fn layers_add_up_and_morph_targets_give_the_result() {
    let (mesh, mut stack) = stack();
    let project = project();
    assert!(stack.missing(&project).is_empty());
    let evaluation = stack.evaluate(&project);
    assert!(evaluation.layers.iter().all(|l| l.state == LayerState::Acts));
    let body = stack.body().clone();
    let result = evaluation.file_positions(&body, &mesh.positions);
    let mut sum = mesh.positions.clone();
    let targets = evaluation.morph_targets(&body);
    assert_eq!(targets.iter().map(|t| &t.0[..]).collect::<Vec<_>>(), ["whole", "detail", "magnify"]);
    for (_, target) in &targets {
        sum.iter_mut().flatten().zip(target.iter().flatten()).for_each(|(s, d)| *s += d);
    }
    assert!(largest(&sum, &result) < 1e-10);
    let in_file: Vec<[f64; 3]> = evaluation.result.positions.iter().map(|p| body.frame.to_file(*p)).collect();
    assert!(largest(&in_file, &result) < 1e-10);
    assert!(largest(&result, &mesh.positions) > 1.0, "the layers do something");
    let terms = evaluation.voices().into_iter().map(|(_, term)| term).collect();
    let together = displacements_f64(&body, &chladni_synth::Item { terms }).unwrap();
    assert!(largest(&together, &evaluation.displacement()) < 1e-6);
    // The third layer magnifies what is below it: x + μ (0.9 x − x) = 1.04 x.
    let base = &evaluation.layers[2].base.positions;
    let grown: Vec<[f64; 3]> = base.iter().map(|p| p.map(|c| 1.04 * c)).collect();
    assert!(largest(&grown, &evaluation.result.positions) < 1e-12);
}

/// x3 = x2 + μ (x1 − x2), with x1 the shape after the first layer and x2 after the second; and it follows when the first
/// layer changes.
#[test]
fn a_layer_is_compared_with_the_result_of_one_below() {
    let (_, mut stack) = stack();
    let mut project = project();
    let [first, second, third] = [0, 1, 2].map(|i| project.layers()[i].0);
    let set = |project: &mut Project, layer, to| project.apply(&Action::Set { layer, to }, None).unwrap();
    set(&mut project, third, Property::Template(Template::Layer(first)));
    for (first_mu, mu) in [(-1.5, -0.4), (-1.5, 1.0), (-0.6, -2.0), (-0.6, 0.0)] {
        set(&mut project, first, Property::Mu(first_mu));
        set(&mut project, third, Property::Mu(mu));
        let evaluation = stack.evaluate(&project);
        let (x1, x2) = (&evaluation.layers[1].base.positions, &evaluation.layers[2].base.positions);
        assert!(largest(x1, x2) > 1e-3, "the second layer does something");
        let expected: Vec<[f64; 3]> =
            x1.iter().zip(x2).map(|(a, b)| [0, 1, 2].map(|i| b[i] + mu * (a[i] - b[i]))).collect();
        let error = largest(&expected, &evaluation.result.positions);
        assert!(error < 1e-12, "μ = {mu}: {error}");
        assert_eq!(evaluation.result.positions, self::stack().1.evaluate(&project).result.positions);
    }
    // With μ = 1 and the layer between switched off, or the layer below, there is nothing to do.
    set(&mut project, third, Property::Mu(1.0));
    set(&mut project, second, Property::Enabled(false));
    let evaluation = stack.evaluate(&project);
    assert!(largest(&evaluation.layers[2].base.positions, &evaluation.result.positions) < 1e-15);
    set(&mut project, second, Property::Enabled(true));
    set(&mut project, first, Property::Enabled(false));
    // The result of a layer that is off is the shape below it.
    assert!(largest(&stack.evaluate(&project).result.positions, &stack.original().positions) < 1e-12);
    assert!(stack.missing(&project).is_empty(), "it needs no match");
}

#[test]
fn a_change_recomputes_only_from_its_layer_up() {
    let (_, mut stack) = stack();
    let mut project = project();
    let before = stack.evaluate(&project);
    let same = stack.evaluate(&project);
    assert!(Arc::ptr_eq(&before.result, &same.result));
    let middle = project.layers()[1].0;
    project.apply(&Action::Set { layer: middle, to: Property::Mu(1.0) }, None).unwrap();
    let after = stack.evaluate(&project);
    let shared = |i: usize| {
        let d = |e: &Evaluation| e.layers[i].displacement.clone().unwrap();
        Arc::ptr_eq(&d(&before), &d(&after))
    };
    assert!(shared(0) && !shared(1) && !shared(2));
    assert!(Arc::ptr_eq(&before.layers[1].base, &after.layers[1].base));
    // The memo gives the same as a fresh stack.
    let fresh = self::stack().1.evaluate(&project);
    assert_eq!(fresh.result.positions, after.result.positions);
}

#[test]
fn off_solo_waiting_and_failed_layers_leave_the_shape_alone() {
    let (mesh, mut stack) = stack();
    let mut project = project();
    let ids: Vec<LayerId> = project.layers().iter().map(|(id, _)| *id).collect();
    let set = |project: &mut Project, layer, to| project.apply(&Action::Set { layer, to }, None).unwrap();
    set(&mut project, ids[2], Property::Solo(true));
    let states = |e: &Evaluation| e.layers.iter().map(|l| l.state.clone()).collect::<Vec<_>>();
    assert_eq!(states(&stack.evaluate(&project)), [LayerState::Off, LayerState::Off, LayerState::Acts]);
    set(&mut project, ids[2], Property::Enabled(false));
    let evaluation = stack.evaluate(&project);
    assert!(Arc::ptr_eq(&evaluation.result, stack.original()));
    let bits = |p: &[[f64; 3]]| p.iter().flatten().map(|c| c.to_bits()).collect::<Vec<_>>();
    let exported = evaluation.file_positions(stack.body(), &mesh.positions);
    assert_eq!(bits(&exported), bits(&mesh.positions));
    set(&mut project, ids[2], Property::Solo(false));
    set(&mut project, ids[0], Property::Template(Template::File("absent.obj".into())));
    assert_eq!(states(&stack.evaluate(&project))[0], LayerState::Waiting);
    let request = stack.missing(&project).remove(0);
    let failed = request.run(&mesh, &stack.body().clone(), None, &Task::new());
    stack.install(request, failed);
    assert!(stack.missing(&project).is_empty());
    assert!(
        matches!(&states(&stack.evaluate(&project))[0], LayerState::Failed(why) if why.contains("absent.obj"))
    );
}

#[test]
fn a_match_made_elsewhere_takes_the_place_of_one_that_failed() {
    let (mesh, mut stack) = stack();
    let body = stack.body().clone();
    let matching = MatchSettings { method: Method::Same, ..MatchSettings::default() };
    let mut project = Project::new(ShapeSource::Sample("lump".into()), 64);
    project.push(Layer { matching, ..Layer::new("same", Template::File("absent.obj".into())) }).unwrap();
    let request = stack.missing(&project).remove(0);
    let template = request.template.clone();
    let (mut other, mut third) = (stack.clone(), stack.clone());
    stack.install(request.clone(), request.run(&mesh, &body, None, &Task::new()));
    assert!(!stack.is_matched_with(&template));
    assert!(matches!(stack.evaluate(&project).layers[0].state, LayerState::Failed(_)));
    third.learn(&stack);
    assert_eq!(third.missing(&project).len(), 1, "a failure is not learned");
    let matched = request.run(&mesh, &body, Some(&mesh), &Task::new());
    other.install(request, matched);
    stack.learn(&other);
    assert!(stack.is_matched_with(&template));
    assert_eq!(stack.evaluate(&project).layers[0].state, LayerState::Acts);
}

#[test]
fn a_layer_acts_with_its_last_match_until_the_new_one_is_there() {
    let (mesh, mut stack) = stack();
    let body = stack.body().clone();
    let template = chladni_mesh::TriMesh {
        positions: mesh.positions.iter().map(|[x, y, z]| [*x, 1.2 * y, *z]).collect(),
        ..mesh.clone()
    };
    let mut project = Project::new(ShapeSource::Sample("lump".into()), 64);
    let layer = project.push(Layer::new("wide", Template::File("wide.obj".into()))).unwrap();
    let matching = |seed| MatchSettings { method: Method::Same, seed, ..MatchSettings::default() };
    for seed in 0..40 {
        let set = Action::Set { layer, to: Property::Matching(matching(seed)) };
        project.apply(&set, None).unwrap();
        let before = stack.evaluate(&project).layers.remove(0);
        let expected = if seed == 0 { LayerState::Waiting } else { LayerState::Outdated };
        assert_eq!((before.state, before.displacement.is_some()), (expected, seed > 0));
        let request = stack.missing(&project).remove(0);
        let matched = request.run(&mesh, &body, Some(&template), &Task::new());
        stack.install(request, matched);
        assert_eq!(stack.evaluate(&project).layers[0].state, LayerState::Acts);
    }
    // An old match that nobody asks for is dropped at last; asked for again, it is made again.
    project.apply(&Action::Set { layer, to: Property::Matching(matching(1)) }, None).unwrap();
    assert_eq!(stack.missing(&project).len(), 1);
}

#[test]
fn a_change_of_the_model_takes_no_more_mu_along_than_is_usual() {
    let mut project = project();
    let id = project.layers()[0].0;
    let set = |project: &mut Project, to| {
        project.apply(&Action::Set { layer: id, to }, None).unwrap();
        let layer = project.layer(id).unwrap();
        (layer.model, layer.mu)
    };
    set(&mut project, Property::Mu(-8.0));
    assert_eq!(set(&mut project, Property::Model(Model::Distance)), (Model::Distance, -8.0));
    assert_eq!(set(&mut project, Property::Model(Model::Normal)), (Model::Normal, -2.4));
    assert_eq!(set(&mut project, Property::Model(Model::Coordinate)), (Model::Coordinate, -2.4));
    assert_eq!(set(&mut project, Property::Mu(-8.0)), (Model::Coordinate, -8.0));
    assert_eq!(set(&mut project, Property::Model(Model::Coordinate)), (Model::Coordinate, -8.0));
    assert_eq!(set(&mut project, Property::Mu(0.5)), (Model::Coordinate, 0.5));
    assert_eq!(set(&mut project, Property::Model(Model::Distance)), (Model::Distance, 0.5));
}

/// The template lacks the end of the lump: the distance to the template's edge is not a feature.
#[test]
fn what_a_match_is_not_trusted_at_is_filled_in_as_far_as_asked_and_no_longer_exaggerated() {
    let mesh = bodies::lump();
    let middle: f64 = mesh.positions.iter().map(|p| p[0]).sum::<f64>() / mesh.positions.len() as f64;
    let (low, high) =
        mesh.positions.iter().fold((f64::MAX, f64::MIN), |(l, h), p| (l.min(p[0]), h.max(p[0])));
    let cut = middle + 0.45 * (high - middle);
    let mut template = mesh.clone();
    template.triangles.retain(|t| t.iter().all(|v| mesh.positions[*v as usize][0] < cut));
    template.positions.iter_mut().for_each(|p| p[1] += 0.02 * (p[0] - low));
    let body = Arc::new(Body::build(&mesh, &BasisSettings::new(32), &Task::new()).unwrap());
    let mut stack = Stack::new(body.clone()).unwrap();
    let mut project = Project::new(ShapeSource::Sample("lump".into()), 32);
    let layer = Layer { mu: -1.0, ..Layer::new("cut", Template::File("cut.ply".into())) };
    assert_eq!(layer.infill, 1.0, "it is on without being asked for");
    let layer = project.push(layer).unwrap();
    let request = stack.missing(&project).remove(0);
    let matched = request.run(&mesh, &body, Some(&template), &Task::new()).unwrap();
    let share = matched.infill.as_ref().unwrap().1;
    assert!((0.01..0.5).contains(&share), "{share}");
    stack.install(request, Ok(matched));
    let end: Vec<usize> = (0..body.positions.len())
        .filter(|v| body.frame.to_file(body.positions[*v])[0] > cut + 0.5 * (high - cut))
        .collect();
    assert!(!end.is_empty());
    let mut moved = |infill: f64| {
        let set = Action::Set { layer, to: Property::Infill(infill) };
        project.apply(&set, None).unwrap();
        let displacement = stack.evaluate(&project).displacement();
        let length = |v: &usize| displacement[*v].iter().map(|c| c * c).sum::<f64>().sqrt();
        end.iter().map(length).sum::<f64>() / end.len() as f64
    };
    let (raw, half, filled) = (moved(0.0), moved(0.5), moved(1.0));
    assert!(filled < 0.4 * raw && filled < half && half < raw, "{raw}, {half}, {filled}");
    assert!(project.apply(&Action::Set { layer, to: Property::Infill(1.1) }, None).is_err());
}

/// A sample stands with y up, though the surface of a lump does not say so.
#[test]
fn a_shape_stands_as_a_template_whose_orientation_is_known() {
    let mesh = bodies::lump();
    let body = Body::build(&mesh, &BasisSettings::new(8), &Task::new()).unwrap();
    let matching = MatchSettings { method: Method::Same, ..MatchSettings::default() };
    let request = MatchRequest { template: Template::Sample("lump".into()), matching };
    let stands = request.run(&mesh, &body, Some(&mesh), &Task::new()).unwrap().stands.unwrap();
    assert!(stands.angle_to(&chladni_mesh::Orientation::Y_UP) < 1e-3, "{stands}");
}

#[test]
fn harmonics_do_not_outlive_another_number_of_them() {
    let mesh = chladni_mesh::samples::icosphere(2);
    let body =
        |harmonics| Arc::new(Body::build(&mesh, &BasisSettings::new(harmonics), &Task::new()).unwrap());
    let first = Stack::new(body(20)).unwrap();
    let (before, basis) = (Arc::downgrade(first.body()), Arc::downgrade(&first.body().basis));
    first.brush_preparation()();
    let stack = first.with_harmonics_of(body(9)).unwrap();
    drop(first);
    assert!(before.upgrade().is_none() && basis.upgrade().is_none());
    assert_eq!(stack.body().basis.harmonics(), 9);
}

#[test]
fn matches_outlive_another_number_of_harmonics() {
    let (mesh, stack) = stack();
    let body = Arc::new(Body::build(&mesh, &BasisSettings::new(32), &Task::new()).unwrap());
    let mut fewer = stack.with_harmonics_of(body.clone()).unwrap();
    assert!(fewer.missing(&project()).is_empty());
    let evaluation = fewer.evaluate(&project());
    assert!(evaluation.layers.iter().all(|l| l.state == LayerState::Acts));
    assert_eq!(evaluation.layers[0].difference.as_ref().unwrap().target.spectrum().len(), 32);
    let mut fresh = Stack::new(body.clone()).unwrap();
    for request in fresh.missing(&project()) {
        let matched = request.run(&mesh, &body, None, &Task::new());
        fresh.install(request, matched);
    }
    assert_eq!(fresh.evaluate(&project()).result.positions, evaluation.result.positions);
    let other = chladni_mesh::samples::icosphere(2);
    let other = Body::build(&other, &BasisSettings::new(9), &Task::new()).unwrap();
    assert!(stack.with_harmonics_of(Arc::new(other)).is_err());
}

#[test]
fn a_given_ellipsoid_is_the_fitted_one_by_its_numbers() {
    let mesh = bodies::lump();
    let (_, mut stack) = stack();
    let body = stack.body().clone();
    let fitted = chladni_match::Ellipsoid::fitted(&mesh).unwrap();
    let given = GivenEllipsoid::from(fitted);
    let mut targets = Vec::new();
    for template in [Template::Ellipsoid, Template::Given(given)] {
        assert_eq!(template.to_string().parse::<Template>().unwrap(), template);
        let mut project = Project::new(ShapeSource::Sample("lump".into()), 64);
        project.push(Layer::new("round", template)).unwrap();
        for request in stack.missing(&project) {
            let matched = request.run(&mesh, &body, None, &Task::new());
            stack.install(request, matched);
        }
        targets.push(stack.evaluate(&project).layers[0].difference.as_ref().unwrap().target.points.clone());
    }
    assert!(largest(&targets[0], &targets[1]) < 1e-9);
    for bad in
        ["sphere:", "sphere:0,0,0", "sphere:0,0,0,-1", "ellipsoid:0,0,0,1,1", "ellipsoid:0,0,0,1,1,inf"]
    {
        assert!(bad.parse::<Template>().is_err(), "{bad}");
    }
}

#[test]
fn mu_zero_exports_the_file_and_mu_one_is_the_template() {
    let (mesh, mut stack) = stack();
    let body = stack.body().clone();
    for model in Model::ALL {
        let mut project = Project::new(ShapeSource::Sample("lump".into()), 64);
        let layer =
            Layer { model, mu: 0.0, region: sphere_region(), ..Layer::new("none", Template::Ellipsoid) };
        project.push(layer).unwrap();
        let exported = stack.evaluate(&project).file_positions(&body, &mesh.positions);
        let bits = |p: &[[f64; 3]]| p.iter().flatten().map(|c| c.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&exported), bits(&mesh.positions), "{model}");
    }
    let mut project = Project::new(ShapeSource::Sample("lump".into()), 64);
    project.push(Layer { mu: 1.0, ..Layer::new("all", Template::Ellipsoid) }).unwrap();
    let evaluation = stack.evaluate(&project);
    let target = &evaluation.layers[0].difference.as_ref().unwrap().target.points;
    assert!(largest(target, &evaluation.result.positions) < 4.0 * f64::EPSILON);
}

#[test]
fn half_the_strength_of_a_layer_is_half_its_mu() {
    let (_, mut stack) = stack();
    let mut at = |mu, strength| {
        let mut project = Project::new(ShapeSource::Sample("lump".into()), 64);
        let layer = Layer { mu, strength, ..Layer::new("magnify", Template::Scaled(0.9)) };
        project.push(layer).unwrap();
        stack.evaluate(&project).result.positions.clone()
    };
    assert!(largest(&at(-2.0, 0.5), &at(-1.0, 1.0)) < 1e-12);
    assert!(largest(&at(-2.0, 0.5), &at(-2.0, 1.0)) > 1e-3);
    assert_eq!(at(-2.0, 0.0), at(0.0, 1.0));
}

#[test]
fn terms_and_side_by_side_models_agree_with_the_evaluation() {
    let (_, mut stack) = stack();
    let mut project = project();
    let id = project.layers()[1].0;
    for (m, model) in Model::ALL.into_iter().enumerate() {
        project.apply(&Action::Set { layer: id, to: Property::Model(model) }, None).unwrap();
        let layer = stack.evaluate(&project).layers.remove(1);
        let displacement = layer.displacement.unwrap();
        let moved: Vec<[f64; 3]> = layer
            .base
            .positions
            .iter()
            .zip(displacement.iter())
            .map(|(x, d)| std::array::from_fn(|i| x[i] + d[i]))
            .collect();
        assert!(largest(&stack.three_models(&project, id).unwrap()[m], &moved) < 1e-12);
        let term = stack.terms(&project, id).unwrap()[m].clone();
        let body = Body { positions: layer.base.positions.clone(), ..(**stack.body()).clone() };
        let item = chladni_synth::Item { terms: vec![term] };
        assert!(largest(&displacements_f64(&body, &item).unwrap(), &displacement) < 1e-5, "{model}");
    }
}
