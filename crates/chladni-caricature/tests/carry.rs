//! A recipe on another shape: regions and landmarks go where they belong.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::sync::Arc;

use chladni_caricature::*;
use chladni_match::{Landmark, MatchSettings};
use chladni_mesh::{TriMesh, samples, weld};
use chladni_task::Task;

/// A lump without any symmetry, from a sphere of `subdivisions`.
fn lump(subdivisions: u32) -> TriMesh {
    let mut mesh = samples::icosphere(subdivisions);
    for p in &mut mesh.positions {
        let [x, y, z] = *p;
        let r = 1.0 + 0.3 * (2.0 * x + 0.5).sin() + 0.2 * y * z + 0.15 * (3.0 * z + y).cos();
        *p = [1.6 * r * x, r * y, 0.7 * r * z];
    }
    mesh
}

fn rescaled(mut mesh: TriMesh) -> TriMesh {
    for p in &mut mesh.positions {
        *p = [25.4 * p[1] + 3.0, -25.4 * p[0] - 7.0, 25.4 * p[2]];
    }
    mesh
}

/// The cap x > 0.5, painted on `mesh`.
fn painted(mesh: &TriMesh) -> Project {
    let cap = weld(mesh).positions.iter().map(|p| if p[0] > 0.5 { 1.0 } else { 0.0 }).collect();
    let region = Region { painted: Painted::Vertices(cap), ..Region::default() };
    let matching =
        MatchSettings { landmarks: vec![Landmark { shape: 5, template: 9 }], ..MatchSettings::default() };
    let mut project = Project::new(ShapeSource::Sample("lump".into()), 32);
    project.push(Layer { region, matching, ..Layer::new("cap", Template::Ellipsoid) }).unwrap();
    project
}

fn values(project: &Project) -> Arc<[f32]> {
    match &project.layers()[0].1.region.painted {
        Painted::Vertices(values) => values.clone(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_painted_cap_is_the_same_cap_on_a_finer_mesh_turned_and_in_other_units() {
    let (coarse, fine) = (lump(3), lump(4));
    let project = painted(&coarse);
    let carried = project.carried(&coarse, &rescaled(fine.clone()), &Task::new()).unwrap();
    assert!(carried.report.unwrap().coverage > 0.9);
    let values = values(&carried.project);
    assert_eq!(values.len(), fine.positions.len());
    // Edges of the coarse mesh are 0.2 long; beyond that from the border everything is clear.
    let mut wrong = 0;
    for (p, value) in fine.positions.iter().zip(values.iter()) {
        if (p[0] - 0.5).abs() > 0.2 {
            wrong += usize::from((*value > 0.5) != (p[0] > 0.5));
        }
    }
    assert_eq!(wrong, 0);
    // The vertices of the coarse sphere are the first of the fine one.
    let landmark = carried.project.layers()[0].1.matching.landmarks[0];
    let (old, new) = (coarse.positions[5], fine.positions[landmark.shape as usize]);
    let apart = (0..3).map(|i| (old[i] - new[i]).powi(2)).sum::<f64>().sqrt();
    assert!(apart < 0.15 && landmark.template == 9, "{apart}");
}

#[test]
fn the_same_triangles_carry_vertex_by_vertex_and_spheres_need_no_match() {
    let mesh = lump(2);
    let project = painted(&mesh);
    let carried = project.carried(&mesh, &rescaled(mesh.clone()), &Task::new()).unwrap();
    assert_eq!(values(&carried.project), values(&project));
    assert_eq!(carried.project.layers()[0].1.matching, project.layers()[0].1.matching);
    // In whatever order the file has the triangles.
    let mut reversed = mesh.clone();
    reversed.triangles.reverse();
    let carried = project.carried(&mesh, &reversed, &Task::new()).unwrap();
    assert_eq!(values(&carried.project), values(&project));

    let mut spheres = Project::new(ShapeSource::Sample("lump".into()), 32);
    let sphere = Sphere { center: [1.0, 0.5, -0.25], radius: 0.5 };
    let region = Region { painted: Painted::Spheres(vec![sphere]), ..Region::default() };
    assert!(!spheres.names_places());
    spheres.push(Layer { region, ..Layer::new("ball", Template::Sphere) }).unwrap();
    assert!(spheres.names_places() && !spheres.names_vertices());
    let given = GivenEllipsoid { center: [1.0, 0.5, -0.25], semi_axes: [0.5; 3], turn_deg: [0.0; 3] };
    spheres.push(Layer::new("given", Template::Given(given))).unwrap();
    let moved = |[x, y, z]: [f64; 3]| [3.0 * x + 10.0, 3.0 * y - 20.0, 3.0 * z + 5.0];
    let larger = TriMesh { positions: mesh.positions.iter().map(|p| moved(*p)).collect(), ..mesh.clone() };
    let is_there = |center: [f64; 3]| {
        center.iter().zip([13.0, -18.5, 4.25]).all(|(found, exact)| (found - exact).abs() < 1e-9)
    };
    let carried = spheres.carried(&mesh, &larger, &Task::new()).unwrap();
    assert!(carried.report.is_none());
    match &carried.project.layers()[0].1.region.painted {
        Painted::Spheres(moved) => {
            assert!((moved[0].radius - 1.5).abs() < 1e-9 && is_there(moved[0].center), "{moved:?}");
        }
        other => panic!("{other:?}"),
    }
    match carried.project.layers()[1].1.template {
        Template::Given(moved) => {
            assert!((moved.semi_axes[1] - 1.5).abs() < 1e-9 && is_there(moved.center), "{moved:?}");
        }
        ref other => panic!("{other:?}"),
    }
}

#[test]
fn a_region_of_another_mesh_is_refused_and_work_can_be_stopped() {
    let (small, large) = (lump(2), lump(3));
    let wrong = painted(&large).carried(&small, &large, &Task::new());
    assert!(matches!(wrong, Err(CaricatureError::PaintedElsewhere { .. })), "{wrong:?}");
    let task = Task::new();
    task.cancel();
    assert!(matches!(painted(&small).carried(&small, &large, &task), Err(CaricatureError::Cancelled(_))));
}
