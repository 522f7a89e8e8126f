//! A real mesh with 50,000 vertices, on which one of the planned shifts loses digits.

use chladni_harmonics::{BasisSettings, Body};
use chladni_task::Task;

#[test]
#[ignore = "takes seconds on all cores: cargo test --release -- --ignored"]
fn the_koala_is_certified() {
    let Some(path) = chladni_testdata::shared("meshes/animals/koala.obj") else { return };
    let mesh = chladni_mesh::load_mesh(&path).unwrap().mesh;
    let body = Body::build(&mesh, &BasisSettings::new(512), &Task::new()).unwrap();
    let c = body.basis.certificate;
    assert!(c.max_relative_residual < 1e-9 && c.max_orthogonality_error < 1e-8, "{c:?}");
}
