//! Buffers in the memory of whoever draws: triangles, positions and normals, paint, images, brush rings.

use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard};

use chladni_synth::{CpuSynthesizer, Synthesizer};

use crate::cpu::Pyramid;
use crate::gpu::{self, Use};
use crate::{Device, Gpu, ViewError};

/// A thing in this machine's memory, for the processor, or on a graphics device.
#[derive(Clone, Debug)]
pub(crate) enum Held<C, G> {
    Cpu(C),
    Gpu(G),
}

impl<C, G> Held<C, G> {
    /// # Errors
    /// [`ViewError::Shape`] where a graphics device holds it.
    pub(crate) fn cpu(&self) -> Result<&C, ViewError> {
        match self {
            Self::Cpu(held) => Ok(held),
            Self::Gpu(_) => {
                Err(ViewError::Shape("the processor is to draw what a graphics device holds".into()))
            }
        }
    }

    /// # Errors
    /// [`ViewError::Shape`] where the processor holds it.
    pub(crate) fn gpu(&self) -> Result<&G, ViewError> {
        match self {
            Self::Gpu(held) => Ok(held),
            Self::Cpu(_) => {
                Err(ViewError::Shape("a graphics device is to draw what the processor holds".into()))
            }
        }
    }
}

/// Numbers in this machine's memory, shared by clones of a buffer. No code that can panic holds the lock.
pub(crate) type Shared<T> = Arc<RwLock<T>>;

pub(crate) fn read<T>(shared: &RwLock<T>) -> RwLockReadGuard<'_, T> {
    shared.read().unwrap_or_else(PoisonError::into_inner)
}

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
    /// Indices, three a triangle; readable by the corner pipeline as storage.
    pub(crate) indices: gpu::Buffer,
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
        Self {
            indices: gpu::filled(gpu, "triangles", indices, Use::Indices),
            uvs: gpu::filled(gpu, "corner UVs", uvs, Use::Vertices),
        }
    }
}

/// Positions and normals of S items of N vertices: item s at vertex offset s·N, three packed
/// f32 a vertex.
#[derive(Clone, Debug)]
pub struct ItemBuffers {
    pub(crate) vertices: usize,
    pub(crate) items: usize,
    pub(crate) held: Held<Shared<HostItems>, DeviceItems>,
}

#[derive(Debug)]
pub(crate) struct HostItems {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) normals: Vec<[f32; 3]>,
}

#[derive(Clone, Debug)]
pub(crate) struct DeviceItems {
    pub(crate) positions: gpu::Buffer,
    pub(crate) normals: gpu::Buffer,
}

impl ItemBuffers {
    /// Space for `items` items of `vertices` vertices, to be filled with [`write`](Self::write).
    pub fn new(on: impl Into<Device>, vertices: usize, items: usize) -> Self {
        let held = match on.into() {
            Device::Processor => {
                let room = vec![[0.0; 3]; vertices * items];
                Held::Cpu(Arc::new(RwLock::new(HostItems { positions: room.clone(), normals: room })))
            }
            Device::Graphics(gpu) => {
                let bytes = (vertices * items * 12).max(12);
                let room = |label| gpu::room(&gpu, label, bytes, Use::Vertices);
                Held::Gpu(DeviceItems { positions: room("positions"), normals: room("normals") })
            }
        };
        Self { vertices, items, held }
    }

    /// Number of items.
    pub fn items(&self) -> usize {
        self.items
    }

    /// Number of vertices of each item.
    pub fn vertices(&self) -> usize {
        self.vertices
    }

    /// Writes positions and normals of the items from `item` on; each slice holds a multiple of N. A
    /// graphics device queues them.
    ///
    /// # Errors
    /// [`ViewError::Shape`] where they do not fit, or another device holds the buffers.
    pub fn write(
        &self,
        on: impl Into<Device>,
        item: usize,
        positions: &[[f32; 3]],
        normals: &[[f32; 3]],
    ) -> Result<(), ViewError> {
        let room = self.items.saturating_sub(item) * self.vertices;
        if positions.len() != normals.len() || positions.len() > room {
            let (p, n) = (positions.len(), normals.len());
            return Err(ViewError::Shape(format!("{p} positions and {n} normals where {room} have room")));
        }
        let first = item * self.vertices;
        match on.into() {
            Device::Processor => {
                let mut items = self.held.cpu()?.write().unwrap_or_else(PoisonError::into_inner);
                items.positions[first..first + positions.len()].copy_from_slice(positions);
                items.normals[first..first + normals.len()].copy_from_slice(normals);
            }
            Device::Graphics(gpu) => {
                let (items, offset) = (self.held.gpu()?, first as u64 * 12);
                gpu::write(&gpu, &items.positions, offset, bytemuck::cast_slice(positions));
                gpu::write(&gpu, &items.normals, offset, bytemuck::cast_slice(normals));
            }
        }
        Ok(())
    }
}

impl ItemBuffers {
    /// Takes the frame that the processor has made, and as many items as it has.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub fn take_frame(&mut self, on: impl Into<Device>, frame: &CpuSynthesizer) -> Result<(), ViewError> {
        let device = on.into();
        if self.items != frame.items() {
            *self = Self::new(&device, self.vertices, frame.items());
        }
        self.write(&device, 0, frame.all_positions(), frame.all_normals())
    }
}

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

    /// Writes one linear-light RGBA color a vertex, eight bits a channel, for
    /// [`Paint::Colors`](crate::Paint::Colors).
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

/// An image to wrap around a shape.
#[derive(Clone, Debug)]
pub struct Skin {
    pub(crate) held: Held<Arc<Pyramid>, gpu::Image>,
}

impl Skin {
    /// Takes `width` × `height` sRGB pixels, the first row at the top (v = 1), and makes its mipmaps.
    ///
    /// # Errors
    /// [`ViewError::Size`] where a side is 0 or too long for the device, [`ViewError::Shape`]
    /// where the bytes are not 4 · width · height.
    pub fn new(on: impl Into<Device>, width: u32, height: u32, rgba: &[u8]) -> Result<Self, ViewError> {
        let device = on.into();
        let limit = device.longest_side();
        if width == 0 || height == 0 || width > limit || height > limit {
            return Err(ViewError::Size { width, height, limit });
        }
        let picture = image::RgbaImage::from_raw(width, height, rgba.to_vec()).ok_or_else(|| {
            ViewError::Shape(format!("{} bytes for an image of {width}×{height}", rgba.len()))
        })?;
        let levels = u32::BITS - width.max(height).leading_zeros();
        // Each is made from the one before; made from the whole picture, every level would cost as much as
        // the first.
        let half = |level: &image::RgbaImage| {
            let [w, h] = [level.width(), level.height()].map(|side| (side / 2).max(1));
            Some(image::imageops::thumbnail(level, w, h))
        };
        let levels = std::iter::successors(Some(picture), half).take(levels as usize).collect();
        Self::of_levels(&device, levels)
    }

    /// Of levels each of which has half the size of the one before.
    pub(crate) fn of_levels(device: &Device, levels: Vec<image::RgbaImage>) -> Result<Self, ViewError> {
        let Some((width, height)) = levels.first().map(image::RgbaImage::dimensions) else {
            return Err(ViewError::Shape("an image without levels".into()));
        };
        let held = match device {
            Device::Processor => Held::Cpu(Arc::new(Pyramid::new(levels.into_iter()))),
            Device::Graphics(gpu) => {
                let size = [width, height, levels.len() as u32];
                let pyramid: Vec<u8> = levels.into_iter().flat_map(image::RgbaImage::into_raw).collect();
                Held::Gpu(gpu::image(gpu, "skin", size, &pyramid))
            }
        };
        Ok(Self { held })
    }
}

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
