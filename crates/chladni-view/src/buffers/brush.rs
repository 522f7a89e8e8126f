//! The ring of a brush, where it is drawn.

use super::{Held, VertexPaint};
use crate::gpu::{self, Use};
use crate::{Device, ViewError};

/// Where a brush would paint: a ring on part of a surface, and a faint tint inside.
#[derive(Clone, Debug)]
pub struct BrushRing {
    /// The distance of each vertex from the brush's center, where it is near enough to matter.
    pub(crate) reach: VertexPaint,
    values: Vec<f32>,
    /// The triangles that it lies on.
    pub(crate) triangles: Held<Vec<[u32; 3]>, gpu::Buffer>,
    pub(crate) corners: u32,
    pub(crate) radius: f32,
    pub(crate) color: [u8; 3],
}

impl BrushRing {
    /// A ring of color `color` (sRGB) for shapes of `vertices` vertices, not placed yet.
    pub fn new(on: impl Into<Device>, vertices: usize, color: [u8; 3]) -> Self {
        let device = on.into();
        let triangles = match &device {
            Device::Processor => Held::Cpu(Vec::new()),
            Device::Graphics(gpu) => Held::Gpu(gpu::room(gpu, "brush", 12, Use::Indices)),
        };
        let (reach, values) = (VertexPaint::new(&device, vertices), vec![0.0; vertices]);
        Self { reach, values, triangles, corners: 0, radius: 0.0, color }
    }

    /// Lays the ring where the distance is `radius`, on `triangles` whose corners have a `reach`, their
    /// distance from the brush's center.
    ///
    /// # Errors
    /// [`ViewError::Shape`] for a vertex out of range, or where another device holds the ring.
    pub fn lay(
        &mut self,
        on: impl Into<Device>,
        radius: f32,
        reach: impl Iterator<Item = (u32, f32)>,
        triangles: &[[u32; 3]],
    ) -> Result<(), ViewError> {
        let vertices = self.values.len();
        let out_of_range = |v: u32| ViewError::Shape(format!("a brush names vertex {v} of {vertices}"));
        for (v, distance) in reach {
            *self.values.get_mut(v as usize).ok_or_else(|| out_of_range(v))? = distance;
        }
        if let Some(v) = triangles.iter().flatten().find(|v| **v as usize >= vertices) {
            return Err(out_of_range(*v));
        }
        let device = on.into();
        match (&mut self.triangles, &device) {
            (Held::Cpu(held), _) => {
                held.clear();
                held.extend_from_slice(triangles);
            }
            (Held::Gpu(buffer), Device::Graphics(gpu)) => {
                let bytes: &[u8] = bytemuck::cast_slice(triangles);
                if gpu::size(buffer) < bytes.len() as u64 {
                    let room = 12 * triangles.len().next_power_of_two();
                    *buffer = gpu::room(gpu, "brush", room, Use::Indices);
                }
                gpu::write(gpu, buffer, 0, bytes);
            }
            (held @ Held::Gpu(_), Device::Processor) => {
                held.cpu()?;
            }
        }
        (self.radius, self.corners) = (radius, 3 * triangles.len() as u32);
        self.reach.write_values(&device, &self.values)
    }

    /// Takes the ring off.
    pub fn lift(&mut self) {
        self.corners = 0;
    }
}
