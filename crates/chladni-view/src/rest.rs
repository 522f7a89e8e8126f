//! Where a shape's vertices rest, how far along the shape each lies, and how the surface bends there: what palettes
//! start from.

use std::sync::Arc;

use chladni_mesh::surface::{
    averaged, curvature_tensors, vertex_areas, vertex_neighbors, vertex_normals, vertex_triangles,
};

use crate::buffers::Held;
use crate::gpu::{self, Use};
use crate::{Device, ViewError};

/// How a surface is bent at each vertex: -1 in the sharpest hollows, 0 where it is flat or a saddle, 1 on the sharpest ridges.
/// The mean curvature, smoothed over a few edges; a tenth of the surface is bent as sharply as it gets.
///
/// # Panics
/// If a triangle names a vertex that is not there.
pub fn bends(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<f32> {
    let at: Vec<[f64; 3]> = positions.iter().map(|p| p.map(f64::from)).collect();
    let around = vertex_triangles(at.len(), triangles);
    let normals = vertex_normals(&at, triangles);
    let tensors = curvature_tensors(&at, triangles, &normals, &around);
    // Half the trace, which turning the axes does not change.
    let means = tensors.iter().map(|[xx, _, _, yy, _, zz]| [0.5 * (xx + yy + zz)]).collect();
    let (neighbors, areas) = (vertex_neighbors(at.len(), triangles), vertex_areas(&at, triangles));
    let means = averaged(means, &neighbors, &areas, SMOOTHED);
    let mut sizes: Vec<f64> = means.iter().map(|[mean]| mean.abs()).filter(|size| size.is_finite()).collect();
    sizes.sort_by(f64::total_cmp);
    let most = sizes.get(sizes.len() * 9 / 10).copied().unwrap_or(0.0);
    let share = |[mean]: [f64; 1]| if most > 0.0 && mean.is_finite() { mean / most } else { 0.0 };
    means.into_iter().map(|mean| share(mean).clamp(-1.0, 1.0) as f32).collect()
}

/// Passes of smoothing, which keep the noise of a scan from counting as folds.
const SMOOTHED: usize = 4;

/// The rest of N vertices, for [`Paint::Answer`](crate::Paint::Answer).
#[derive(Clone, Debug)]
pub struct RestShape {
    pub(crate) vertices: usize,
    /// Position, the number along the shape, and the bend.
    pub(crate) held: Held<Arc<[[f32; 5]]>, gpu::Buffer>,
}

impl RestShape {
    /// Takes `positions` in the coordinates of the items that will be drawn, and a number `along` the shape for
    /// each, best in [0, 1]. `bends` is from -1, in the sharpest hollow, to 1, on the sharpest ridge.
    ///
    /// # Errors
    /// [`ViewError::Shape`] where the counts differ.
    pub fn new(
        on: impl Into<Device>,
        positions: &[[f32; 3]],
        along: &[f32],
        bends: &[f32],
    ) -> Result<Self, ViewError> {
        let (p, a, b) = (positions.len(), along.len(), bends.len());
        if a != p || b != p {
            return Err(ViewError::Shape(format!(
                "{a} numbers along a shape of {p} vertices, and {b} bends"
            )));
        }
        let vertices = positions.iter().zip(along).zip(bends);
        let all: Vec<[f32; 5]> =
            vertices.map(|(([x, y, z], along), bend)| [*x, *y, *z, *along, *bend]).collect();
        let held = match on.into() {
            Device::Processor => Held::Cpu(all.into()),
            Device::Graphics(gpu) => {
                let bytes: &[u8] = if all.is_empty() { &[0; 20] } else { bytemuck::cast_slice(&all) };
                Held::Gpu(gpu::filled(&gpu, "rest", bytes, Use::Vertices))
            }
        };
        Ok(Self { vertices: positions.len(), held })
    }
}
