//! Exaggerates the differences of a head from the ellipsoid that fits it best; writes caricature.obj.

use std::sync::Arc;

use chladni::caricature::{Layer, Project, ShapeSource, Stack, Template};
use chladni::harmonics::{BasisSettings, Body};
use chladni::mesh::{TriMesh, save_mesh};
use chladni::task::Task;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let source = ShapeSource::named("sample:head");
    let mesh = source.load(None)?.mesh;
    let body = Arc::new(Body::build(&mesh, &BasisSettings::default(), &Task::new())?);

    let mut project = Project::new(source, body.basis.harmonics());
    project.push(Layer { mu: -1.2, ..Layer::new("against an ellipsoid", Template::Ellipsoid) })?;
    let mut stack = Stack::new(body.clone())?;
    for request in stack.missing(&project) {
        let matched = request.run(&mesh, &body, None, &Task::new());
        stack.install(request, matched);
    }
    let positions = stack.evaluate(&project).file_positions(&body, &mesh.positions);
    save_mesh(&TriMesh { positions, ..mesh }, "caricature.obj".as_ref())?;
    Ok(())
}
