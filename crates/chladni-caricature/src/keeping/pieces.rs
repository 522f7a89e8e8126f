//! Small separate pieces, such as eyes and teeth, that keep their form.

use chladni_match::{Scaling, Similarity};
use chladni_mesh::surface::vec3::{Vec3, add, distance, dot, scaled, sub};
use chladni_mesh::surface::{SurfacePoint, TriangleTree, components, corners, doubled_area_normal};
use rayon::prelude::*;

use crate::Surface;

/// A piece is small below this share of the whole area.
const SMALL: f64 = 0.05;
/// A region is meant for a small piece if it acts there this many times as much as on what is around it.
const MEANT: f64 = 2.0;

/// The small pieces of a surface and, for each of their vertices, the place of the large pieces that is nearest.
#[derive(Debug, Default)]
pub(super) struct SmallPieces {
    pieces: Vec<Vec<(u32, SurfacePoint)>>,
}

impl SmallPieces {
    /// None where no piece is large.
    pub(super) fn of(surface: &Surface) -> Self {
        let piece = components(surface.vertices(), &surface.triangles);
        let mut areas = vec![0.0; piece.iter().max().map_or(0, |last| *last as usize + 1)];
        for t in &surface.triangles {
            let n = doubled_area_normal(corners(&surface.positions, t));
            areas[piece[t[0] as usize] as usize] += distance(n, [0.0; 3]);
        }
        let whole: f64 = areas.iter().sum();
        let is_small = |v: u32| {
            let area = areas[piece[v as usize] as usize];
            area > 0.0 && area < SMALL * whole
        };
        let large: Vec<u32> = (0..surface.triangles.len() as u32)
            .filter(|t| !is_small(surface.triangles[*t as usize][0]))
            .collect();
        let corners: Vec<[u32; 3]> = large.iter().map(|t| surface.triangles[*t as usize]).collect();
        if large.is_empty() || large.len() == surface.triangles.len() {
            return Self::default();
        }
        let tree = TriangleTree::new(&surface.positions, &corners);
        let nearest = |v: u32| {
            let on = tree.closest(surface.positions[v as usize], f64::INFINITY)?.on;
            Some((v, SurfacePoint { triangle: *large.get(on.triangle as usize)?, ..on }))
        };
        let found: Vec<(u32, SurfacePoint)> = (0..surface.vertices() as u32)
            .into_par_iter()
            .filter(|v| is_small(*v))
            .filter_map(nearest)
            .collect();
        let mut pieces: Vec<Vec<(u32, SurfacePoint)>> = vec![Vec::new(); areas.len()];
        found.into_iter().for_each(|at| pieces[piece[at.0 as usize] as usize].push(at));
        pieces.retain(|piece| !piece.is_empty());
        Self { pieces }
    }

    /// Moves each small piece of the shape at `base` as a whole: as the places around it move. One that the region χ,
    /// `mask`, is meant for moves by itself.
    pub(super) fn carry(
        &self,
        surface: &Surface,
        base: &[Vec3],
        mask: Option<&[f32]>,
        displacement: &mut [Vec3],
    ) {
        let goes_along =
            |piece: &&Vec<(u32, SurfacePoint)>| mask.is_none_or(|mask| !is_meant(piece, surface, mask));
        let rigid = |piece: &Vec<(u32, SurfacePoint)>| {
            let at = |on: &SurfacePoint, f: &[Vec3]| {
                on.position(&surface.triangles, |v| f[v as usize]).unwrap_or([0.0; 3])
            };
            let from: Vec<Vec3> = piece.iter().map(|(_, on)| at(on, base)).collect();
            let by: Vec<Vec3> = piece.iter().map(|(_, on)| at(on, displacement)).collect();
            let to: Vec<Vec3> = from.iter().zip(&by).map(|(x, d)| add(*x, *d)).collect();
            let mean = scaled(by.iter().fold([0.0; 3], |s, d| add(s, *d)), 1.0 / by.len() as f64);
            // Places in one line turn about it in no particular way.
            let fit = Similarity::fit(&from, &to, None, Scaling::Rigid).ok();
            let moved = |v: u32| {
                let x = base[v as usize];
                fit.as_ref().map_or(mean, |fit| sub(fit.apply(x), x))
            };
            piece.iter().map(|(v, _)| (*v, moved(*v))).collect::<Vec<_>>()
        };
        let moved: Vec<Vec<(u32, Vec3)>> = self.pieces.par_iter().filter(goes_along).map(rigid).collect();
        for (v, d) in moved.into_iter().flatten() {
            displacement[v as usize] = d;
        }
    }

    /// The region `mask` without the pieces that it is meant for.
    pub(super) fn without_meant(&self, surface: &Surface, mask: &[f32]) -> Vec<f32> {
        let mut left = mask.to_vec();
        for piece in self.pieces.iter().filter(|piece| is_meant(piece, surface, mask)) {
            piece.iter().for_each(|(v, _)| left[*v as usize] = 0.0);
        }
        left
    }
}

/// Whether the region `mask` acts on the piece rather than on what is around it.
fn is_meant(piece: &[(u32, SurfacePoint)], surface: &Surface, mask: &[f32]) -> bool {
    let (mut own, mut around) = (0.0, 0.0);
    for (v, on) in piece {
        own += f64::from(mask[*v as usize]);
        let corners = surface.triangles[on.triangle as usize].map(|v| f64::from(mask[v as usize]));
        around += dot(corners, on.weights);
    }
    own > MEANT * around
}
