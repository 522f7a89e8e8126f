//! From one small mesh, or two, to an exported caricature, whatever their geometry.

use std::sync::Arc;

use arbitrary::Arbitrary;
use chladni_caricature::{Layer, Model, Project, ScaleCurve, ShapeSource, Stack, Template};
use chladni_harmonics::{BasisSettings, Body};
use chladni_match::{Landmark, Match, MatchSettings, Method, Scaling, match_shapes};
use chladni_mesh::{HealthReport, TriMesh};
use chladni_task::Task;

use crate::export::exported;
use crate::random::Random;
use crate::{MIB, within};

/// A mesh that is valid except perhaps for its shape.
#[derive(Arbitrary, Debug)]
pub struct Geometry {
    /// Steps of a coarse grid, so that vertices meet and triangles lie flat.
    points: Vec<[i8; 3]>,
    /// One axis is stretched by 2 to this power.
    stretch: i8,
    triangles: Vec<[u8; 3]>,
}

impl Geometry {
    /// One at random, half of them not stretched.
    pub(crate) fn random(random: &mut Random) -> Self {
        let reach = [1, 2, 8, 127][random.below(4)];
        let point = |random: &mut Random| {
            std::array::from_fn(|_| (random.below(2 * reach + 1) as i64 - reach as i64) as i8)
        };
        let points = (0..3 + random.below(60)).map(|_| point(random)).collect();
        let triangles = (0..1 + random.below(150)).map(|_| std::array::from_fn(|_| random.byte())).collect();
        let stretch = if random.below(2) == 0 { 0 } else { random.byte() as i8 };
        Self { points, stretch, triangles }
    }

    pub(crate) fn mesh(&self) -> Option<TriMesh> {
        let n = self.points.len().min(64);
        if n == 0 {
            return None;
        }
        let factor = f64::from(self.stretch).exp2();
        let positions = self.points[..n].iter().map(|p| {
            let [x, y, z] = p.map(f64::from);
            [x * factor, y, z]
        });
        let triangles = self.triangles.iter().take(200).map(|t| t.map(|v| u32::from(v) % n as u32));
        Some(TriMesh { positions: positions.collect(), triangles: triangles.collect(), ..TriMesh::default() })
    }
}

pub(crate) fn body_of(mesh: &TriMesh, harmonics: u8) -> Option<Arc<Body>> {
    let settings = BasisSettings { threads: Some(1), ..BasisSettings::new(usize::from(harmonics).max(1)) };
    let body = Body::build(mesh, &settings, &Task::new()).ok()?;
    assert!(body.basis.vectors.iter().chain(&body.basis.eigenvalues).all(|x| x.is_finite()));
    Some(Arc::new(body))
}

/// A small mesh, and how it is exaggerated.
#[derive(Arbitrary, Debug)]
pub struct Shape {
    geometry: Geometry,
    harmonics: u8,
    model: u8,
    template: u8,
    mu: i8,
}

/// Reports on, solves, exaggerates and writes `shape`.
pub fn pipeline(shape: Shape) {
    let Some(mesh) = shape.geometry.mesh() else { return };
    // 16 KiB for each vertex and triangle: a row of 64 harmonics takes half a kibibyte, and the solver holds some such rows,
    // as do the layer and the four formats that are written. The rest is for the pool of threads and what is made once.
    within(mesh.positions.len() + mesh.triangles.len(), 16 << 10, 32 * MIB, || caricature(&shape, &mesh));
}

fn caricature(shape: &Shape, mesh: &TriMesh) {
    assert!(HealthReport::of(mesh).area.is_finite());
    let Some(body) = body_of(mesh, shape.harmonics) else { return };
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
    let mut project = Project::new(ShapeSource::Sample("fuzz".into()), body.basis.harmonics());
    if project.push(layer).is_err() {
        return;
    }
    exaggerate(&mut stack, &project, mesh, None);
}

/// Matches what `project` needs, evaluates it, and writes and reads the result in each format.
fn exaggerate(stack: &mut Stack, project: &Project, mesh: &TriMesh, template: Option<&TriMesh>) {
    let body = stack.body().clone();
    for request in stack.missing(project) {
        let matched = request.run(mesh, &body, template, &Task::new());
        stack.install(request, matched);
    }
    let evaluation = stack.evaluate(project);
    let positions = &evaluation.result.positions;
    assert_eq!(positions.len(), body.positions.len());
    assert!(positions.iter().flatten().all(|x| x.is_finite()), "a caricature has coordinates");
    let positions = evaluation.file_positions(&body, &mesh.positions);
    exported(&TriMesh { positions, ..mesh.clone() });
}

/// Two small meshes, and how they are matched.
#[derive(Debug)]
pub struct Pair {
    shape: Geometry,
    template: Geometry,
    method: u8,
    is_rigid: bool,
    landmarks: Vec<[u8; 2]>,
    seed: u8,
    harmonics: u8,
    mu: i8,
}

impl Pair {
    /// One at random; in each second case the template is of the same triangles.
    pub fn random(random: &mut Random) -> Self {
        let shape = Geometry::random(random);
        let mut template = Geometry::random(random);
        if random.below(2) == 0 {
            template.points.resize(shape.points.len(), [1, 2, 3]);
            template.triangles.clone_from(&shape.triangles);
        }
        let landmarks = (0..random.below(6)).map(|_| [random.byte() % 16, random.byte() % 16]).collect();
        Self {
            shape,
            template,
            method: random.byte(),
            is_rigid: random.below(4) == 0,
            landmarks,
            seed: random.byte(),
            harmonics: random.byte() % 40,
            mu: random.byte() as i8,
        }
    }
}

/// Matches two shapes, and exaggerates their difference.
pub fn pair(pair: Pair) {
    let (Some(mesh), Some(template)) = (pair.shape.mesh(), pair.template.mesh()) else { return };
    let landmarks = pair.landmarks.iter().map(|pair| {
        let [shape, template] = pair.map(u32::from);
        Landmark { shape, template }
    });
    let matching = MatchSettings {
        method: [Method::Same, Method::Icp, Method::Fit, Method::Map][usize::from(pair.method) % 4],
        landmarks: landmarks.collect(),
        seed: pair.seed.into(),
        scaling: if pair.is_rigid { Scaling::Rigid } else { Scaling::default() },
    };
    contrast(&mesh, &template, matching, pair.harmonics, f64::from(pair.mu) / 16.0);
}

/// Matches a shape with another, checks what the match promises, and exaggerates the difference.
pub(crate) fn contrast(mesh: &TriMesh, template: &TriMesh, matching: MatchSettings, harmonics: u8, mu: f64) {
    let Ok(found) = match_shapes(mesh, template, &matching, &Task::new()) else { return };
    kept_promises(&found, mesh, template);
    let Some(body) = body_of(mesh, harmonics) else { return };
    let Ok(mut stack) = Stack::new(body.clone()) else { return };
    let mut project = Project::new(ShapeSource::Sample("fuzz".into()), body.basis.harmonics());
    let layer = Layer::new("fuzz", Template::Sample("template".into()));
    if project.push(Layer { mu, matching, ..layer }).is_ok() {
        exaggerate(&mut stack, &project, mesh, Some(template));
    }
}

fn kept_promises(found: &Match, mesh: &TriMesh, template: &TriMesh) {
    let (report, found) = (&found.report, &found.correspondence);
    assert!(found.point.iter().chain(&found.target).flatten().all(|x| x.is_finite()));
    assert!(found.confidence.iter().all(|trust| (0.0..=1.0).contains(trust)));
    assert_eq!((found.point.len(), found.target.len()), (mesh.positions.len(), mesh.positions.len()));
    for on in found.on_template.iter().flatten() {
        assert!((on.triangle as usize) < template.triangles.len());
        assert!(on.weights.iter().all(|weight| *weight >= 0.0));
        assert!((on.weights.iter().sum::<f64>() - 1.0).abs() < 1e-9);
    }
    let measures = [report.median_distance, report.p95_distance, report.coverage, report.mean_confidence];
    assert!(measures.iter().all(|measure| measure.is_finite() && *measure >= 0.0), "{report:?}");
    assert!(!report.stretch.is_nan());
}
