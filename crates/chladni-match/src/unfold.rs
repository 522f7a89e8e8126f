//! Removes folds from a projection: the vertices of triangles that are turned over are spread between their
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

/// Whether a triangle faces away from `up`, the sum of the template's normals at its corners.
pub(crate) fn turned_over([x, y, z]: [DVec3; 3], up: DVec3) -> bool {
    (y - x).cross(z - x).dot(up) < 0.0
}

/// Moves the points of vertices at folds to the mean of their neighbors' points, on the template and facing
/// as the neighbors' points do; around folds that stay, more and more vertices are moved. Vertices in
/// `fixed` do not move. Each component of the shape keeps the state in which it had the fewest folds.
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
        let count = per_component(shape, &folds);
        for (v, c) in shape.component.iter().enumerate() {
            if count[*c as usize] < least[*c as usize] {
                at[v] = trial[v];
            }
        }
        least.iter_mut().zip(count).for_each(|(least, count)| *least = count.min(*least));
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

/// The triangles that are turned over.
fn folded(shape: &UnitSurface, template: &UnitSurface, at: &[Closest]) -> Vec<u32> {
    let turned = |t: &u32| {
        let points = shape.triangles[*t as usize].map(|v| at[v as usize]);
        let up = points.iter().map(|p| template.triangle_normals[p.on.triangle as usize]).sum();
        turned_over(points.map(|p| DVec3::from_array(p.point)), up)
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
    use chladni_mesh::samples;

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
}
