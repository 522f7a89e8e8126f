//! Numbers or colors of vertices, where they are drawn.

use std::sync::{Arc, PoisonError, RwLock};

use super::{Held, Shared};
use crate::gpu::{self, Use};
use crate::{Device, ViewError};

/// N numbers or colors, one a vertex.
#[derive(Clone, Debug)]
pub struct VertexPaint {
    pub(crate) vertices: usize,
    pub(crate) held: Held<Shared<Vec<[u8; 4]>>, gpu::Buffer>,
}

impl VertexPaint {
    /// Room for `vertices` values or colors; zero until written.
    pub fn new(on: impl Into<Device>, vertices: usize) -> Self {
        let held = match on.into() {
            Device::Processor => Held::Cpu(Arc::new(RwLock::new(vec![[0; 4]; vertices]))),
            Device::Graphics(gpu) => {
                Held::Gpu(gpu::room(&gpu, "vertex paint", (vertices * 4).max(4), Use::Vertices))
            }
        };
        Self { vertices, held }
    }

    /// Writes one number a vertex, for [`Paint::Values`](crate::Paint::Values).
    ///
    /// # Errors
    /// [`ViewError::Shape`] where the count differs, or another device holds the paint.
    pub fn write_values(&self, on: impl Into<Device>, values: &[f32]) -> Result<(), ViewError> {
        self.write(&on.into(), bytemuck::cast_slice(values))
    }

    /// Writes one sRGB color a vertex, eight bits a channel, for [`Paint::Colors`](crate::Paint::Colors): those of
    /// [`srgb_bytes`](crate::srgb_bytes). Between vertices their light is mixed.
    ///
    /// # Errors
    /// [`ViewError::Shape`] where the count differs, or another device holds the paint.
    pub fn write_colors(&self, on: impl Into<Device>, colors: &[[u8; 4]]) -> Result<(), ViewError> {
        self.write(&on.into(), colors)
    }

    fn write(&self, on: &Device, paint: &[[u8; 4]]) -> Result<(), ViewError> {
        if paint.len() != self.vertices {
            let (found, wanted) = (paint.len(), self.vertices);
            return Err(ViewError::Shape(format!("{found} values for {wanted} vertices")));
        }
        match on {
            Device::Processor => {
                self.held.cpu()?.write().unwrap_or_else(PoisonError::into_inner).copy_from_slice(paint);
            }
            Device::Graphics(gpu) => {
                gpu::write(gpu, self.held.gpu()?, 0, bytemuck::cast_slice(paint));
            }
        }
        Ok(())
    }
}
