//! The same recipe on another shape: everything that names vertices or places of the old one is carried over.

use std::collections::HashSet;
use std::sync::Arc;

use chladni_match::{
    Landmark, MatchError, MatchReport, MatchSettings, Method, has_same_vertices, match_shapes,
};
use chladni_mesh::{Frame, TriMesh, weld};
use chladni_task::Task;

use crate::region::check_painted;
use crate::{
    CaricatureError, GivenEllipsoid, Layer, Painted, Project, Region, Sphere, SurfacePoint, Template,
};
use chladni_mesh::surface::TriangleTree;
use chladni_mesh::surface::vec3::Vec3;

/// A project on another shape.
#[derive(Clone, Debug)]
pub struct Carried {
    /// The project; its `shape` is still the old one's name.
    pub project: Project,
    /// How well the two shapes were matched, if they had to be.
    pub report: Option<MatchReport>,
}

impl Project {
    /// The same layers for another shape. `from` is the mesh that the project was made on, `to`
    /// the other one.
    ///
    /// Spheres, and given ellipsoids, go to the same place relative to the shape. Painted regions and the shape's ends of
    /// landmarks follow a match of the two meshes: vertex by vertex where their triangles are the
    /// same, else by [`Method::Fit`], which may take seconds. A project without any of these is
    /// carried at once.
    ///
    /// # Errors
    /// A region that does not belong to `from`, a match that fails, a cancelled task.
    pub fn carried(&self, from: &TriMesh, to: &TriMesh, task: &Task) -> Result<Carried, CaricatureError> {
        let (old_frame, new_frame) = (Frame::of(from), Frame::of(to));
        let way = match self.names_vertices() {
            true => Some(Way::between(from, to, task)?),
            false => None,
        };
        let mut project = self.map_layers(|layer| {
            let painted = match (&layer.region.painted, &way) {
                (Painted::Vertices(values), Some(way)) => Painted::Vertices(way.carry(values)?),
                (Painted::Spheres(spheres), _) => {
                    Painted::Spheres(spheres.iter().map(|s| moved(s, &old_frame, &new_frame)).collect())
                }
                (as_it_is, _) => as_it_is.clone(),
            };
            let template = match &layer.template {
                Template::Given(given) => Template::Given(GivenEllipsoid {
                    center: new_frame.to_file(old_frame.to_working(given.center)),
                    semi_axes: given.semi_axes.map(|a| a * old_frame.scale / new_frame.scale),
                    ..*given
                }),
                other => other.clone(),
            };
            let mut matching = layer.matching.clone();
            if let Some(way) = &way {
                matching.landmarks = way.landmarks(from, &matching.landmarks);
            }
            let region = Region { painted, ..layer.region.clone() };
            Ok(Layer { template, region, matching, ..layer.clone() })
        })?;
        // This shape's orientation says nothing about another's.
        project.stands = None;
        Ok(Carried { project, report: way.map(|way| way.report) })
    }
}

fn moved(sphere: &Sphere, from: &Frame, to: &Frame) -> Sphere {
    Sphere {
        center: to.to_file(from.to_working(sphere.center)),
        radius: sphere.radius * from.scale / to.scale,
    }
}

/// For each vertex of the new mesh, its place on the old one.
struct Way {
    on_old: Vec<SurfacePoint>,
    /// The points of `on_old`, in the old file's coordinates.
    points: Vec<Vec3>,
    old_triangles: Vec<[u32; 3]>,
    old_operator_vertex: Vec<Option<u32>>,
    old_operator_vertices: usize,
    new_operator_vertex: Vec<Option<u32>>,
    new_operator_vertices: usize,
    report: MatchReport,
}

impl Way {
    fn between(from: &TriMesh, to: &TriMesh, task: &Task) -> Result<Self, CaricatureError> {
        let method = if has_same_vertices(from, to) { Method::Same } else { Method::Fit };
        let found = match_shapes(to, from, &MatchSettings { method, ..MatchSettings::default() }, task);
        task.check()?;
        let failed = |why: MatchError| CaricatureError::Carry(why.to_string());
        let found = found.map_err(failed)?;
        let on_old = found.correspondence.on_template;
        let on_old = on_old.ok_or_else(|| CaricatureError::Carry("the match has no triangles".into()))?;
        let (old, new) = (weld(from), weld(to));
        Ok(Self {
            on_old,
            points: found.correspondence.point,
            old_triangles: from.triangles.clone(),
            old_operator_vertices: old.positions.len(),
            old_operator_vertex: old.operator_vertex,
            new_operator_vertices: new.positions.len(),
            new_operator_vertex: new.operator_vertex,
            report: found.report,
        })
    }

    /// χ01 on the operator vertices of the new mesh from `values` on those of the old.
    fn carry(&self, values: &[f32]) -> Result<Arc<[f32]>, CaricatureError> {
        check_painted(values.len(), self.old_operator_vertices)?;
        let old = |v: u32| {
            let vertex = self.old_operator_vertex.get(v as usize).copied().flatten();
            vertex.and_then(|vertex| values.get(vertex as usize)).copied().unwrap_or(0.0)
        };
        let mut carried = vec![0.0_f32; self.new_operator_vertices];
        for (on, vertex) in self.on_old.iter().zip(&self.new_operator_vertex) {
            let (Some(corners), Some(vertex)) = (self.old_triangles.get(on.triangle as usize), vertex) else {
                continue;
            };
            let mixed: f64 = corners.iter().zip(on.weights).map(|(v, w)| f64::from(old(*v)) * w).sum();
            if let Some(place) = carried.get_mut(*vertex as usize) {
                *place = mixed.clamp(0.0, 1.0) as f32;
            }
        }
        Ok(carried.into())
    }

    /// Landmarks whose end on the old mesh moves to the new vertex that lies nearest to it. If two move to
    /// the same vertex, the first is kept.
    fn landmarks(&self, from: &TriMesh, landmarks: &[Landmark]) -> Vec<Landmark> {
        if landmarks.is_empty() {
            return Vec::new();
        }
        // Of each place the first vertex, as a triangle of one point.
        let mut is_taken = vec![false; self.new_operator_vertices];
        let first = |(v, vertex): (u32, &Option<u32>)| {
            let taken = is_taken.get_mut((*vertex)? as usize)?;
            (!std::mem::replace(taken, true)).then_some([v; 3])
        };
        let places: Vec<[u32; 3]> = (0..).zip(&self.new_operator_vertex).filter_map(first).collect();
        let tree = TriangleTree::new(&self.points, &places);
        let (mut carried, mut known) = (Vec::with_capacity(landmarks.len()), HashSet::new());
        for landmark in landmarks {
            let Some(old) = from.positions.get(landmark.shape as usize) else { continue };
            let Some(near) = tree.closest(*old, f64::INFINITY) else { continue };
            let [shape, ..] = places[near.on.triangle as usize];
            if known.insert(shape) {
                carried.push(Landmark { shape, ..*landmark });
            }
        }
        carried
    }
}
