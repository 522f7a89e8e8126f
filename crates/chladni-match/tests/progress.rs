//! Progress as a person sees it.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::sync::Mutex;

use chladni_match::{MatchSettings, match_shapes};
use chladni_mesh::TriMesh;
use chladni_mesh::samples::icosphere;
use chladni_task::Task;

/// A ball with a hump on one side, whose height is `hump`.
fn lump(hump: f64) -> TriMesh {
    let mut mesh = icosphere(3);
    for [x, y, z] in &mut mesh.positions {
        let r = 1.0 + hump * (2.0 * (*x - 1.0)).exp();
        (*x, *y, *z) = (r * *x, 1.3 * r * *y, 0.8 * r * *z);
    }
    mesh
}

#[test]
fn the_bar_of_a_stage_does_not_go_back() {
    static HEARD: Mutex<Vec<(String, u64)>> = Mutex::new(Vec::new());
    let task = Task::new();
    task.heard_by(|now| HEARD.lock().unwrap().push((now.stage.clone(), now.done)));
    match_shapes(&lump(0.8), &lump(0.0), &MatchSettings::default(), &task).unwrap();
    let heard = HEARD.lock().unwrap();
    let bending = |name: &String| name.starts_with("bending");
    let names: std::collections::BTreeSet<&String> =
        heard.iter().map(|(name, _)| name).filter(|n| bending(n)).collect();
    assert!(names.len() > 1, "another round was needed: {names:?}");
    for name in names {
        let steps = heard.iter().filter(|(stage, _)| stage == name).map(|(_, done)| *done);
        assert!(steps.is_sorted(), "{name}");
    }
}
