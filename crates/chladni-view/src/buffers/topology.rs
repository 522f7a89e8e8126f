//! Triangles where they are drawn.

use std::sync::Arc;

use super::Held;
use crate::gpu::{self, Use};
use crate::{Device, Gpu, ViewError};

/// The triangles that S items share, where they are drawn.
#[derive(Clone, Debug)]
pub struct Topology {
    pub(crate) vertices: usize,
    pub(crate) triangles: usize,
    pub(crate) has_uvs: bool,
    pub(crate) held: Held<Arc<HostTriangles>, DeviceTriangles>,
}

#[derive(Debug)]
pub(crate) struct HostTriangles {
    pub(crate) corners: Vec<[u32; 3]>,
    /// One a corner, or none.
    pub(crate) uvs: Vec<[f32; 2]>,
}

#[derive(Clone, Debug)]
pub(crate) struct DeviceTriangles {
    /// Indices, three a triangle.
    pub(crate) indices: gpu::Buffer,
    /// The same where vertex stages look them up.
    pub(crate) corners: gpu::Buffer,
    /// Two floats a corner, or one pair where there are none.
    pub(crate) uvs: gpu::Buffer,
}

impl Topology {
    /// Takes `triangles` over `vertices` vertices to the device.
    ///
    /// # Errors
    /// [`ViewError::Shape`] for an index out of range.
    pub fn new(on: impl Into<Device>, vertices: usize, triangles: &[[u32; 3]]) -> Result<Self, ViewError> {
        Self::build(&on.into(), vertices, triangles, None)
    }

    /// As [`new`](Self::new), with one (u, v) per corner of each triangle; v points up, as in OBJ.
    ///
    /// # Errors
    /// [`ViewError::Shape`] for an index out of range or a count that differs.
    pub fn with_uvs(
        on: impl Into<Device>,
        vertices: usize,
        triangles: &[[u32; 3]],
        corner_uvs: &[[f32; 2]],
    ) -> Result<Self, ViewError> {
        Self::build(&on.into(), vertices, triangles, Some(corner_uvs))
    }

    fn build(
        device: &Device,
        vertices: usize,
        triangles: &[[u32; 3]],
        uvs: Option<&[[f32; 2]]>,
    ) -> Result<Self, ViewError> {
        if let Some(v) = triangles.iter().flatten().find(|v| **v as usize >= vertices) {
            return Err(ViewError::Shape(format!("a triangle names vertex {v} of {vertices}")));
        }
        if let Some(uvs) = uvs
            && uvs.len() != 3 * triangles.len()
        {
            let (found, wanted) = (uvs.len(), 3 * triangles.len());
            return Err(ViewError::Shape(format!("{found} corner UVs where {wanted} are needed")));
        }
        let held = match device {
            Device::Processor => Held::Cpu(Arc::new(HostTriangles {
                corners: triangles.to_vec(),
                uvs: uvs.unwrap_or_default().to_vec(),
            })),
            Device::Graphics(gpu) => Held::Gpu(DeviceTriangles::upload(gpu, triangles, uvs)),
        };
        Ok(Self { vertices, triangles: triangles.len(), has_uvs: uvs.is_some(), held })
    }
}

impl DeviceTriangles {
    fn upload(gpu: &Gpu, triangles: &[[u32; 3]], uvs: Option<&[[f32; 2]]>) -> Self {
        // A buffer of no bytes cannot be bound.
        let indices: &[u8] = if triangles.is_empty() { &[0; 12] } else { bytemuck::cast_slice(triangles) };
        let uvs: &[u8] = uvs.filter(|uvs| !uvs.is_empty()).map_or(&[0; 8], bytemuck::cast_slice);
        let triangles = gpu::filled(gpu, "triangles", indices, Use::Indices);
        Self {
            corners: gpu::looked_up(gpu, &triangles, indices),
            indices: triangles,
            uvs: gpu::filled(gpu, "corner UVs", uvs, Use::Vertices),
        }
    }
}
