//! A clone of a stack evaluates on another thread, and what it remembers comes back.

use super::*;

fn bits(evaluation: &Evaluation) -> Vec<[u64; 3]> {
    evaluation.result.positions.iter().map(|p| p.map(f64::to_bits)).collect()
}

#[test]
fn a_clone_elsewhere_gives_the_same_bits_and_nothing_is_evaluated_again() {
    let (_, mut stack) = stack();
    let mut project = project();
    let here = stack.clone().evaluate(&project);
    let (clone, there) = std::thread::spawn({
        let (mut clone, project) = (stack.clone(), project.clone());
        move || {
            let evaluation = clone.evaluate(&project);
            (clone, evaluation)
        }
    })
    .join()
    .unwrap();
    assert_eq!(bits(&here), bits(&there));
    stack.remember(clone);
    let again = stack.clone().evaluate(&project);
    assert!(Arc::ptr_eq(&again.result, &there.result), "it was remembered");
    // From the changed layer up only.
    let top = project.layers()[2].0;
    project.apply(&Action::Set { layer: top, to: Property::Mu(-0.1) }, None).unwrap();
    let mut clone = stack.clone();
    let changed = clone.evaluate(&project);
    assert!(Arc::ptr_eq(&changed.layers[2].base, &there.layers[2].base));
    assert!(!Arc::ptr_eq(&changed.result, &there.result));
}

#[test]
fn nothing_is_evaluated_again_where_models_are_seen_side_by_side_and_no_more() {
    let (_, mut stack) = stack();
    let mut project = project();
    let id = project.layers()[1].0;
    let before = stack.evaluate(&project).result;
    stack.prepare_models_of(Some(id));
    assert!(Arc::ptr_eq(&stack.evaluate(&project).result, &before));
    let curve = |to| Action::Set { layer: id, to: Property::Curve(to) };
    project.apply(&curve(ScaleCurve::default()), None).unwrap();
    let beside = stack.evaluate(&project).result;
    stack.prepare_models_of(None);
    assert!(Arc::ptr_eq(&stack.evaluate(&project).result, &beside));
    // Another curve and back, before they are seen again.
    for to in [ScaleCurve::mid(), ScaleCurve::default()] {
        project.apply(&curve(to), None).unwrap();
        stack.evaluate(&project);
    }
    let back = stack.evaluate(&project).result;
    stack.prepare_models_of(Some(id));
    assert!(Arc::ptr_eq(&stack.evaluate(&project).result, &back));
}

#[test]
fn matches_and_limits_that_arrive_while_a_clone_evaluates_stay() {
    let mesh = bodies::lump();
    let body = Arc::new(Body::build(&mesh, &BasisSettings::new(64), &Task::new()).unwrap());
    let mut stack = Stack::new(body.clone()).unwrap();
    let mut project = Project::new(ShapeSource::Sample("lump".into()), 64);
    let low = project.push(Layer { mu: -14.0, ..Layer::new("much", Template::LowPass(6)) }).unwrap();
    project.push(Layer { mu: -0.5, ..Layer::new("round", Template::Ellipsoid) }).unwrap();
    project.apply(&Action::KeepTriangles(true), None).unwrap();
    let mut clone = stack.clone();
    let evaluation = clone.evaluate(&project);
    stack.remember(clone);
    // The next evaluation is on its way while a match and a limit arrive.
    let mut clone = stack.clone();
    let request = stack.missing(&project).remove(0);
    let matched = request.run(&mesh, &body, None, &Task::new());
    stack.install(request, matched);
    let limit = stack.unsettled_in(&evaluation).unwrap();
    let kept = limit.run(&Task::new());
    stack.settle(limit, kept);
    clone.evaluate(&project);
    stack.remember(clone);
    assert!(stack.missing(&project).is_empty());
    let evaluation = stack.evaluate(&project);
    assert_eq!(evaluation.layers[1].state, LayerState::Acts);
    assert!(evaluation.layers[0].kept.is_some());
    assert!(stack.unsettled_in(&evaluation).is_some(), "the layer above is next");
    // The limit of a layer goes with it.
    project.apply(&Action::Remove(low), None).unwrap();
    stack.forget_unused(&project);
    assert!(stack.evaluate(&project).layers[0].kept.is_none());
}

#[test]
fn what_a_clone_on_other_harmonics_remembers_is_not_taken_over() {
    let (mesh, mut stack) = stack();
    let mut old = stack.clone();
    old.evaluate(&project());
    let finer = Body::build(&mesh, &BasisSettings::new(80), &Task::new()).unwrap();
    stack = stack.with_harmonics_of(Arc::new(finer)).unwrap();
    let (mut fresh, project) = (stack.clone(), project());
    stack.remember(old);
    assert_eq!(bits(&stack.evaluate(&project)), bits(&fresh.evaluate(&project)));
}
