//! Where a shape's vertices rest, and one number along it for each: what palettes measure movement from.

use std::sync::Arc;

use crate::buffers::Held;
use crate::gpu::{self, Use};
use crate::{Device, ViewError};

/// The rest of N vertices, for [`Paint::Answer`](crate::Paint::Answer).
#[derive(Clone, Debug)]
pub struct RestShape {
    pub(crate) vertices: usize,
    /// Position, and the number along the shape.
    pub(crate) held: Held<Arc<[[f32; 4]]>, gpu::Buffer>,
}

impl RestShape {
    /// Takes `positions` in the coordinates of the items that will be drawn, and a number `along` the shape for
    /// each, best in [0, 1].
    ///
    /// # Errors
    /// [`ViewError::Shape`] where the counts differ.
    pub fn new(on: impl Into<Device>, positions: &[[f32; 3]], along: &[f32]) -> Result<Self, ViewError> {
        if positions.len() != along.len() {
            let (p, a) = (positions.len(), along.len());
            return Err(ViewError::Shape(format!("{a} numbers along a shape of {p} vertices")));
        }
        let all: Vec<[f32; 4]> =
            positions.iter().zip(along).map(|([x, y, z], along)| [*x, *y, *z, *along]).collect();
        let held = match on.into() {
            Device::Processor => Held::Cpu(all.into()),
            Device::Graphics(gpu) => {
                let bytes: &[u8] = if all.is_empty() { &[0; 16] } else { bytemuck::cast_slice(&all) };
                Held::Gpu(gpu::filled(&gpu, "rest", bytes, Use::Vertices))
            }
        };
        Ok(Self { vertices: positions.len(), held })
    }
}
