//! Two Laplacians: the intrinsic Delaunay Laplacian of any triangle mesh, and the papers' plain cotangent
//! Laplacian (docs/laplacian.md).

mod cotangent;
mod cover;
mod flips;
mod intrinsic;

use crate::HarmonicsError;
use crate::sparse::SymmetricSparse;
pub(crate) use cotangent::{Refusal, cotangent_laplacian};
pub(crate) use cover::Cover;
pub(crate) use intrinsic::hat_slopes;

/// Lengths are mollified so that every triangle keeps this share of the mean edge length
/// between the sum of two sides and the third (Sharp & Crane 2020, §4.5).
pub(crate) const MOLLIFY: f64 = 1e-5;

/// S and a of a welded surface. S has no positive value off the diagonal, and all areas are positive.
pub(crate) fn delaunay_laplacian(
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
    mollify: f64,
) -> Result<(SymmetricSparse, Vec<f64>), HarmonicsError> {
    let cover = delaunay_cover(positions, triangles, mollify)?;
    Ok(cover_laplacian(&cover, positions.len()))
}

/// S and a of a Delaunay cover.
pub(crate) fn cover_laplacian(cover: &Cover, vertices: usize) -> (SymmetricSparse, Vec<f64>) {
    // Each sheet of the cover carries the whole surface.
    let share = 1.0 / cover.sheets as f64;
    let edges = intrinsic::cotangent_weights(cover, share);
    let mass = intrinsic::mixed_voronoi_areas(cover, vertices, share);
    (SymmetricSparse::laplacian(vertices, &edges), mass)
}

/// An intrinsic Delaunay triangulation of the surface.
pub(crate) fn delaunay_cover(
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
    mollify: f64,
) -> Result<Cover, HarmonicsError> {
    let mut cover = Cover::of(positions, triangles);
    cover.mollify(mollify);
    flips::flip_to_delaunay(&mut cover)?;
    Ok(cover)
}

#[cfg(test)]
mod tests;
