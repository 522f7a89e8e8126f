//! Takes folds out of a projection: where triangles turned over, their vertices are spread
//! between their neighbours on the template.

use chladni_task::Task;
use glam::DVec3;
use rayon::prelude::*;

use crate::MatchError;
use crate::bvh::SurfacePoint;
use crate::partners::Partners;
use crate::surface::Surface;

/// Rounds at most.
const ROUNDS: usize = 12;
/// Sweeps over the vertices of a round.
const SWEEPS: usize = 4;
/// Rings of vertices around a fold that move with it, at first and at last.
const RINGS: (usize, usize) = (1, 5);

/// Whether the image `points` of a triangle, all on a template with these normals, is turned over.
pub(crate) fn turned_over([x, y, z]: [DVec3; 3], normals: [DVec3; 3]) -> bool {
    (y - x).cross(z - x).dot(normals.into_iter().sum()) < 0.0
}

/// Moves the points of vertices at folds, and ever more around those that stay, to the closest
/// point of the mean of their neighbours' points. `normals` are the ways that vertices look in
/// the template's coordinates; vertices in `fixed` stay. What does not lessen the folds is
/// undone.
pub(crate) fn unfold(
    shape: &Surface,
    partners: &Partners,
    at: &mut Vec<SurfacePoint>,
    normals: &[DVec3],
    fixed: &[u32],
    task: &Task,
) -> Result<(), MatchError> {
    let template = partners.template;
    let stage = task.stage("unfolding", ROUNDS as u64);
    let mut trial = at.clone();
    let mut folds = folded(shape, template, at);
    let mut least = folds.len();
    for round in 0..ROUNDS {
        task.check()?;
        if folds.is_empty() {
            break;
        }
        let rings = RINGS.0 + round * (RINGS.1 - RINGS.0) / (ROUNDS - 1);
        let mut active = around(shape, &folds, rings);
        active.retain(|v| !fixed.contains(v));
        for _ in 0..SWEEPS {
            let moved: Vec<(u32, SurfacePoint)> = active
                .par_iter()
                .filter_map(|&v| {
                    let near = shape.neighbours(v as usize);
                    let mean = near.iter().map(|w| trial[*w as usize].point).sum::<DVec3>() / near.len() as f64;
                    let found = partners.nearest(shape.component[v as usize], mean, normals[v as usize])?;
                    found.point.is_finite().then_some((v, found))
                })
                .collect();
            moved.into_iter().for_each(|(v, point)| trial[v as usize] = point);
        }
        folds = folded(shape, template, &trial);
        if folds.len() < least {
            least = folds.len();
            at.clone_from(&trial);
        }
        stage.advance(1);
    }
    Ok(())
}

/// The triangles that are turned over.
fn folded(shape: &Surface, template: &Surface, at: &[SurfacePoint]) -> Vec<u32> {
    let turned = |t: &u32| {
        let points = shape.triangles[*t as usize].map(|v| at[v as usize]);
        turned_over(points.map(|p| p.point), points.map(|p| template.triangle_normals[p.triangle as usize]))
    };
    (0..shape.triangles.len() as u32).into_par_iter().filter(turned).collect()
}

/// The vertices of `triangles` and those within `rings` edges of them, in order.
fn around(shape: &Surface, triangles: &[u32], rings: usize) -> Vec<u32> {
    let mut inside = vec![false; shape.points.len()];
    let mut front: Vec<u32> = Vec::new();
    let mut enter = |v: u32, front: &mut Vec<u32>| {
        if !std::mem::replace(&mut inside[v as usize], true) {
            front.push(v);
        }
    };
    for t in triangles {
        shape.triangles[*t as usize].into_iter().for_each(|v| enter(v, &mut front));
    }
    let mut begin = 0;
    for _ in 0..rings {
        let end = front.len();
        for i in begin..end {
            let v = front[i];
            shape.neighbours(v as usize).iter().for_each(|w| enter(*w, &mut front));
        }
        begin = end;
    }
    front.sort_unstable();
    front
}
