//! Removes folds from a projection: the vertices of triangles that it turns over are spread between their
//! neighbors on the template.

use chladni_mesh::surface::Closest;
use chladni_task::Task;
use glam::DVec3;
use rayon::prelude::*;

use crate::MatchError;
use crate::partners::Partners;
use crate::surface::UnitSurface;

/// The largest number of rounds.
const ROUNDS: usize = 40;
/// Sweeps over the vertices in each round.
const SWEEPS: usize = 4;
/// After each such number of rounds, one more ring of vertices around a fold moves with it.
const ROUNDS_PER_RING: usize = 6;
/// An image that shrinks below this share of its area is no better for having fewer folds: a point has none.
const SHRUNK: f64 = 0.1;

/// Whether a triangle faces away from `up`, the sum of the template's smooth normals at its corners. (The normals of
/// single faces would not do: a point on an edge lies in any of those that meet there.)
pub(crate) fn turned_over([x, y, z]: [DVec3; 3], up: DVec3) -> bool {
    (y - x).cross(z - x).dot(up) < 0.0
}

/// Moves the points of vertices at folds to the mean of their neighbors' points, on the template and facing
/// as the neighbors' points do; around folds that stay, more and more vertices are moved. Vertices in
/// `fixed` do not move. Each component of the shape keeps the state in which it had the fewest folds, of those in which
/// it did not collapse.
pub(crate) fn unfold(
    shape: &UnitSurface,
    partners: &Partners,
    at: &mut [Closest],
    fixed: &[u32],
    task: &Task,
) -> Result<(), MatchError> {
    let template = partners.template;
    let mut stays = vec![false; shape.points.len()];
    fixed.iter().for_each(|v| stays[*v as usize] = true);
    let mut trial = at.to_vec();
    let mut folds = folded(shape, template, at);
    let mut least = per_component(shape, &folds);
    let whole = image_areas(shape, at);
    let stage = task.stage("unfolding", ROUNDS as u64);
    for round in 0..ROUNDS {
        task.check()?;
        if folds.is_empty() {
            break;
        }
        let mut active = around(shape, &folds, 1 + round / ROUNDS_PER_RING);
        active.retain(|v| !stays[*v as usize]);
        for _ in 0..SWEEPS {
            let moved: Vec<(u32, Closest)> = active
                .par_iter()
                .filter_map(|&v| Some((v, between_neighbors(shape, partners, &trial, v)?)))
                .collect();
            moved.into_iter().for_each(|(v, point)| trial[v as usize] = point);
        }
        folds = folded(shape, template, &trial);
        let (count, area) = (per_component(shape, &folds), image_areas(shape, &trial));
        let better: Vec<bool> =
            (0..least.len()).map(|c| count[c] < least[c] && area[c] > SHRUNK * whole[c]).collect();
        for (v, c) in shape.component.iter().enumerate() {
            if better[*c as usize] {
                at[v] = trial[v];
                least[*c as usize] = count[*c as usize];
            }
        }
        stage.advance(1);
    }
    Ok(())
}

/// The point of the template closest to the mean of the points of a vertex's neighbors.
fn between_neighbors(shape: &UnitSurface, partners: &Partners, at: &[Closest], v: u32) -> Option<Closest> {
    let (mut sum, mut looking) = (DVec3::ZERO, DVec3::ZERO);
    let neighbors = shape.neighbors(v as usize);
    for w in neighbors {
        let point = &at[*w as usize];
        sum += DVec3::from_array(point.point);
        looking += partners.template.smooth_normal(&point.on);
    }
    let mean = sum / neighbors.len() as f64;
    let found = partners.nearest(shape.component[v as usize], mean, looking.normalize_or_zero())?;
    found.point.iter().all(|x| x.is_finite()).then_some(found)
}

/// The triangles that are turned over here, but not already in the shape itself: its own folds belong where they are.
fn folded(shape: &UnitSurface, template: &UnitSurface, at: &[Closest]) -> Vec<u32> {
    let turned = |t: &u32| {
        let points = shape.triangles[*t as usize].map(|v| at[v as usize]);
        let up = points.iter().map(|p| template.smooth_normal(&p.on)).sum();
        turned_over(points.map(|p| DVec3::from_array(p.point)), up) && !shape.is_turned_over(*t as usize)
    };
    (0..shape.triangles.len() as u32).into_par_iter().filter(turned).collect()
}

/// The number of `triangles` in each component.
fn per_component(shape: &UnitSurface, triangles: &[u32]) -> Vec<usize> {
    let mut count = vec![0; shape.components()];
    for t in triangles {
        count[shape.component_of(*t) as usize] += 1;
    }
    count
}

/// The area of each component's image on the template.
fn image_areas(shape: &UnitSurface, at: &[Closest]) -> Vec<f64> {
    let mut areas = vec![0.0; shape.components()];
    for corners in &shape.triangles {
        let [x, y, z] = corners.map(|v| DVec3::from_array(at[v as usize].point));
        areas[shape.component[corners[0] as usize] as usize] += 0.5 * (y - x).cross(z - x).length();
    }
    areas
}

/// The vertices of `triangles` and those within `rings` edges of them, ascending.
fn around(shape: &UnitSurface, triangles: &[u32], rings: usize) -> Vec<u32> {
    let mut inside = vec![false; shape.points.len()];
    let mut reached: Vec<u32> = Vec::new();
    let mut reach = |v: u32, reached: &mut Vec<u32>| {
        if !std::mem::replace(&mut inside[v as usize], true) {
            reached.push(v);
        }
    };
    for t in triangles {
        shape.triangles[*t as usize].into_iter().for_each(|v| reach(v, &mut reached));
    }
    let mut begin = 0;
    for _ in 0..rings {
        let end = reached.len();
        for i in begin..end {
            let v = reached[i];
            shape.neighbors(v as usize).iter().for_each(|w| reach(*w, &mut reached));
        }
        begin = end;
    }
    reached.sort_unstable();
    reached
}

#[cfg(test)]
mod tests {
    use chladni_mesh::surface::SurfacePoint;
    use chladni_mesh::{TriMesh, samples};

    use super::*;
    use crate::Side;

    #[test]
    fn a_crumpled_patch_is_smoothed_out_and_the_rest_left_alone() {
        let sphere = UnitSurface::new(&samples::icosphere(4), Side::Shape).unwrap();
        let closest = |p: &DVec3| sphere.closest(*p, f64::INFINITY).unwrap();
        let straight: Vec<Closest> = sphere.points.iter().map(closest).collect();
        let crumple = |p: &DVec3| {
            let wave = DVec3::new((97.0 * p.y).sin(), (83.0 * p.z).sin(), (71.0 * p.x).sin());
            closest(&(*p + if p.x > 0.2 { wave * 0.05 } else { DVec3::ZERO }))
        };
        let mut at: Vec<Closest> = sphere.points.iter().map(crumple).collect();
        assert!(folded(&sphere, &sphere, &at).len() > 200);
        unfold(&sphere, &Partners::none(&sphere), &mut at, &[], &Task::new()).unwrap();
        assert_eq!(folded(&sphere, &sphere, &at).len(), 0);
        for (now, before) in at.iter().zip(&straight).filter(|(_, p)| p.point[0] < 0.0) {
            assert_eq!(now.point, before.point);
        }
    }

    fn tetrahedron() -> UnitSurface {
        let positions = [[1.0; 3], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]].to_vec();
        let triangles = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]].to_vec();
        let mesh = TriMesh { positions, triangles, ..TriMesh::default() };
        UnitSurface::new(&mesh, Side::Shape).unwrap()
    }

    /// The corner `v`, as a point of the `nth` of the faces around it.
    fn at_corner(surface: &UnitSurface, v: u32, nth: usize) -> Closest {
        let corner = |(t, corners): (usize, &[u32; 3])| {
            Some(SurfacePoint::at_corner(t as u32, corners.iter().position(|w| *w == v)?))
        };
        let on = surface.triangles.iter().enumerate().filter_map(corner).nth(nth).unwrap();
        Closest { point: surface.points[v as usize].to_array(), on, distance_squared: 0.0 }
    }

    #[test]
    fn a_corner_may_lie_in_any_of_the_faces_that_meet_there() {
        let solid = tetrahedron();
        for way in 0..81 {
            let nth = [way % 3, way / 3 % 3, way / 9 % 3, way / 27];
            let at: Vec<Closest> = (0..4).map(|v| at_corner(&solid, v, nth[v as usize])).collect();
            assert!(folded(&solid, &solid, &at).is_empty(), "{nth:?}");
        }
    }

    #[test]
    fn what_the_shape_itself_folds_over_stays() {
        let mut mesh = samples::icosphere(2);
        let [v, w, _] = mesh.triangles[0].map(|v| v as usize);
        // A corner is drawn over its neighbor, and some triangles around it with it.
        mesh.positions[v] = std::array::from_fn(|i| 1.6 * mesh.positions[w][i] - 0.6 * mesh.positions[v][i]);
        let shape = UnitSurface::new(&mesh, Side::Shape).unwrap();
        assert!((0..shape.triangles.len()).any(|t| shape.is_turned_over(t)));
        let mut at: Vec<Closest> = (0..shape.points.len() as u32).map(|v| at_corner(&shape, v, 0)).collect();
        unfold(&shape, &Partners::none(&shape), &mut at, &[], &Task::new()).unwrap();
        for (now, own) in at.iter().zip(&shape.points) {
            assert_eq!(now.point, own.to_array());
        }
    }

    #[test]
    fn a_shape_inside_out_does_not_collapse() {
        let solid = tetrahedron();
        let mut at: Vec<Closest> = [0, 1, 3, 2].map(|v| at_corner(&solid, v, 0)).to_vec();
        assert_eq!(folded(&solid, &solid, &at).len(), 4);
        let whole = image_areas(&solid, &at)[0];
        unfold(&solid, &Partners::none(&solid), &mut at, &[], &Task::new()).unwrap();
        assert!(image_areas(&solid, &at)[0] > SHRUNK * whole);
    }
}
