//! From a small mesh to an exported caricature, whatever its geometry.

use std::sync::Arc;

use arbitrary::Arbitrary;
use chladni_caricature::{Layer, Model, Project, ScaleCurve, ShapeSource, Stack, Template};
use chladni_harmonics::{BasisSettings, Body};
use chladni_mesh::{Format, HealthReport, TriMesh, read_mesh, write_mesh};
use chladni_task::Task;

/// A mesh that is valid except perhaps for its shape, and the settings that it is processed with.
#[derive(Arbitrary, Debug)]
pub struct Shape {
    /// Steps of a coarse grid, so that vertices meet and triangles lie flat.
    points: Vec<[i8; 3]>,
    /// One axis is stretched by 2 to this power.
    stretch: i8,
    triangles: Vec<[u8; 3]>,
    harmonics: u8,
    model: u8,
    template: u8,
    mu: i8,
}

/// Reports on, solves, exaggerates and writes `shape`.
pub fn pipeline(shape: Shape) {
    let n = shape.points.len().min(64);
    if n == 0 {
        return;
    }
    let factor = f64::from(shape.stretch).exp2();
    let positions = shape.points[..n].iter().map(|p| {
        let [x, y, z] = p.map(f64::from);
        [x * factor, y, z]
    });
    let triangles = shape.triangles.iter().take(200).map(|t| t.map(|v| u32::from(v) % n as u32));
    let mesh =
        TriMesh { positions: positions.collect(), triangles: triangles.collect(), ..TriMesh::default() };
    assert!(HealthReport::of(&mesh).area.is_finite());
    let settings =
        BasisSettings { threads: Some(1), ..BasisSettings::new(usize::from(shape.harmonics).max(1)) };
    let Ok(body) = Body::build(&mesh, &settings, &Task::new()) else { return };
    assert!(body.basis.vectors.iter().chain(&body.basis.eigenvalues).all(|x| x.is_finite()));
    let body = Arc::new(body);
    let Ok(mut stack) = Stack::new(body.clone()) else { return };
    let template = match shape.template % 4 {
        0 => Template::Ellipsoid,
        1 => Template::Sphere,
        2 => Template::LowPass(usize::from(shape.template)),
        _ => Template::Scaled(f64::from(shape.template) / 100.0),
    };
    let model = [Model::Coordinate, Model::Normal, Model::Distance][usize::from(shape.model) % 3];
    let layer = Layer {
        model,
        mu: f64::from(shape.mu) / 16.0,
        curve: if shape.mu % 2 == 0 { ScaleCurve::mid() } else { ScaleCurve::flat(1.0) },
        ..Layer::new("fuzz", template)
    };
    let mut project = Project::new(ShapeSource::Sample("fuzz".into()), settings.harmonics);
    if project.push(layer).is_err() {
        return;
    }
    for request in stack.missing(&project) {
        let matched = request.run(&mesh, &body, None, &Task::new());
        stack.install(request, matched);
    }
    let result = stack.evaluate(&project).result;
    let positions = result.positions.clone();
    assert_eq!(positions.len(), body.positions.len());
    assert!(positions.iter().flatten().all(|x| x.is_finite()), "a caricature has coordinates");
    let exported = TriMesh { positions, triangles: body.triangles.clone(), ..TriMesh::default() };
    let bytes = write_mesh(&exported, Format::Ply).expect("what was made can be written");
    assert_eq!(
        read_mesh(&bytes, Format::Ply).expect("and read").mesh.positions.len(),
        exported.positions.len()
    );
}
