//! What is drawn: items on the device, what they are painted with, and the cells they stand in.

use wgpu::util::DeviceExt;

use crate::{Background, Camera, Gpu, Lights, Material, Rect, Scale, ViewError};

/// The triangles that S items share, on the device.
#[derive(Clone, Debug)]
pub struct Topology {
    pub(crate) vertices: usize,
    pub(crate) triangles: usize,
    /// Indices, three a triangle; readable by the corner pipeline as storage.
    pub(crate) indices: wgpu::Buffer,
    /// Two floats a corner, or one pair where there are none.
    pub(crate) uvs: wgpu::Buffer,
    pub(crate) has_uvs: bool,
}

impl Topology {
    /// Uploads `triangles` over `vertices` vertices.
    ///
    /// # Errors
    /// [`ViewError::Shape`] for an index out of range.
    pub fn new(gpu: &Gpu, vertices: usize, triangles: &[[u32; 3]]) -> Result<Self, ViewError> {
        Self::build(gpu, vertices, triangles, None)
    }

    /// As [`new`](Self::new), with one (u, v) per corner of each triangle; v points up, as in OBJ.
    ///
    /// # Errors
    /// [`ViewError::Shape`] for an index out of range or a count that differs.
    pub fn with_uvs(
        gpu: &Gpu,
        vertices: usize,
        triangles: &[[u32; 3]],
        corner_uvs: &[[f32; 2]],
    ) -> Result<Self, ViewError> {
        Self::build(gpu, vertices, triangles, Some(corner_uvs))
    }

    fn build(
        gpu: &Gpu,
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
        // A buffer of no bytes cannot be bound.
        let indices: &[u8] = if triangles.is_empty() { &[0; 12] } else { bytemuck::cast_slice(triangles) };
        let upload = |label, contents, usage| {
            gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some(label),
                contents,
                usage,
            })
        };
        Ok(Self {
            vertices,
            triangles: triangles.len(),
            indices: upload("triangles", indices, wgpu::BufferUsages::INDEX | wgpu::BufferUsages::STORAGE),
            uvs: upload(
                "corner UVs",
                uvs.filter(|uvs| !uvs.is_empty()).map_or(&[0; 8], bytemuck::cast_slice),
                wgpu::BufferUsages::STORAGE,
            ),
            has_uvs: uvs.is_some(),
        })
    }
}

/// Positions and normals of S items of N vertices: item s at vertex offset s·N, three packed
/// f32 a vertex.
#[derive(Clone, Debug)]
pub struct ItemBuffers {
    pub(crate) vertices: usize,
    pub(crate) items: usize,
    pub(crate) positions: wgpu::Buffer,
    pub(crate) normals: wgpu::Buffer,
}

impl ItemBuffers {
    /// Room for `items` items of `vertices` vertices, to be filled with [`write`](Self::write).
    pub fn new(gpu: &Gpu, vertices: usize, items: usize) -> Self {
        let room = |label| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: (vertices * items * 12).max(12) as u64,
                usage: wgpu::BufferUsages::VERTEX
                    | wgpu::BufferUsages::STORAGE
                    | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        Self { vertices, items, positions: room("positions"), normals: room("normals") }
    }

    /// Draws from buffers that somebody else fills, such as a synthesizer on the same device;
    /// nothing is copied. Both need the usages `VERTEX` and `STORAGE`.
    ///
    /// # Errors
    /// [`ViewError::Shape`] where a buffer is too small or lacks a usage.
    pub fn borrowed(
        positions: wgpu::Buffer,
        normals: wgpu::Buffer,
        vertices: usize,
        items: usize,
    ) -> Result<Self, ViewError> {
        let bytes = (vertices * items * 12) as u64;
        let usage = wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::STORAGE;
        for buffer in [&positions, &normals] {
            if buffer.size() < bytes || !buffer.usage().contains(usage) {
                let (size, has) = (buffer.size(), buffer.usage());
                return Err(ViewError::Shape(format!(
                    "a buffer of {size} bytes, {has:?}, where {bytes} bytes, {usage:?} are needed"
                )));
            }
        }
        Ok(Self { vertices, items, positions, normals })
    }

    /// Draws what a synthesizer has left on the device; nothing is copied. The synthesizer's next
    /// frame shows in the same buffers as long as they need not grow: take its frame anew each time.
    ///
    /// # Errors
    /// [`ViewError::Shape`] where the frame's buffers cannot be drawn from.
    pub fn of_frame(frame: &chladni_synth::DeviceFrame<'_>) -> Result<Self, ViewError> {
        let (vertices, items) = (frame.vertices as usize, frame.items as usize);
        Self::borrowed(frame.positions.clone(), frame.normals.clone(), vertices, items)
    }

    /// Number of items.
    pub fn items(&self) -> usize {
        self.items
    }

    /// Number of vertices of each item.
    pub fn vertices(&self) -> usize {
        self.vertices
    }

    /// Queues positions and normals of the items from `item` on; each slice holds a multiple of N.
    ///
    /// # Errors
    /// [`ViewError::Shape`] where they do not fit.
    pub fn write(
        &self,
        gpu: &Gpu,
        item: usize,
        positions: &[[f32; 3]],
        normals: &[[f32; 3]],
    ) -> Result<(), ViewError> {
        let room = self.items.saturating_sub(item) * self.vertices;
        if positions.len() != normals.len() || positions.len() > room {
            let (p, n) = (positions.len(), normals.len());
            return Err(ViewError::Shape(format!("{p} positions and {n} normals where {room} have room")));
        }
        let offset = (item * self.vertices * 12) as u64;
        gpu.queue.write_buffer(&self.positions, offset, bytemuck::cast_slice(positions));
        gpu.queue.write_buffer(&self.normals, offset, bytemuck::cast_slice(normals));
        Ok(())
    }
}

/// N numbers or colours, one a vertex, on the device.
#[derive(Clone, Debug)]
pub struct VertexPaint {
    pub(crate) vertices: usize,
    pub(crate) buffer: wgpu::Buffer,
}

impl VertexPaint {
    /// Room for `vertices` values or colours; zero until written.
    pub fn new(gpu: &Gpu, vertices: usize) -> Self {
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("vertex paint"),
            size: (vertices * 4).max(4) as u64,
            usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self { vertices, buffer }
    }

    /// Queues one number a vertex, for [`Paint::Values`].
    ///
    /// # Errors
    /// [`ViewError::Shape`] where the count differs.
    pub fn write_values(&self, gpu: &Gpu, values: &[f32]) -> Result<(), ViewError> {
        self.write(gpu, values.len(), bytemuck::cast_slice(values))
    }

    /// Queues one linear-light RGBA colour a vertex, eight bits a channel, for [`Paint::Colors`].
    ///
    /// # Errors
    /// [`ViewError::Shape`] where the count differs.
    pub fn write_colors(&self, gpu: &Gpu, colors: &[[u8; 4]]) -> Result<(), ViewError> {
        self.write(gpu, colors.len(), bytemuck::cast_slice(colors))
    }

    fn write(&self, gpu: &Gpu, count: usize, bytes: &[u8]) -> Result<(), ViewError> {
        if count != self.vertices {
            return Err(ViewError::Shape(format!("{count} values for {} vertices", self.vertices)));
        }
        gpu.queue.write_buffer(&self.buffer, 0, bytes);
        Ok(())
    }
}

/// An image to wrap around a shape.
#[derive(Clone, Debug)]
pub struct Skin {
    pub(crate) view: wgpu::TextureView,
}

impl Skin {
    /// Uploads `width` × `height` sRGB pixels, the first row at the top (v = 1), with mipmaps.
    ///
    /// # Errors
    /// [`ViewError::Size`] where a side is 0 or too long for the device, [`ViewError::Shape`]
    /// where the bytes are not 4 · width · height.
    pub fn new(gpu: &Gpu, width: u32, height: u32, rgba: &[u8]) -> Result<Self, ViewError> {
        let limit = gpu.device.limits().max_texture_dimension_2d;
        if width == 0 || height == 0 || width > limit || height > limit {
            return Err(ViewError::Size { width, height, limit });
        }
        let levels = u32::BITS - width.max(height).leading_zeros();
        let picture = image::RgbaImage::from_raw(width, height, rgba.to_vec()).ok_or_else(|| {
            ViewError::Shape(format!("{} bytes for an image of {width}×{height}", rgba.len()))
        })?;
        let mut pyramid = picture.clone().into_raw();
        for level in 1..levels {
            let (w, h) = ((width >> level).max(1), (height >> level).max(1));
            pyramid.extend(image::imageops::thumbnail(&picture, w, h).into_raw());
        }
        let texture = gpu.device.create_texture_with_data(
            &gpu.queue,
            &wgpu::TextureDescriptor {
                label: Some("skin"),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: levels,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba8UnormSrgb,
                usage: wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            },
            wgpu::util::TextureDataOrder::LayerMajor,
            &pyramid,
        );
        Ok(Self { view: texture.create_view(&wgpu::TextureViewDescriptor::default()) })
    }
}

/// What gives a surface its colour.
#[derive(Clone, Copy, Debug, Default)]
pub enum Paint<'a> {
    /// The material's own.
    #[default]
    Material,
    /// A heat map: one number a vertex through a colour map.
    Values(&'a VertexPaint, Scale),
    /// One colour a vertex.
    Colors(&'a VertexPaint),
    /// An image by the topology's corner UVs.
    Skin(&'a Skin),
}

/// Edges drawn over a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wire {
    /// sRGB.
    pub color: [u8; 3],
    /// In [0, 1].
    pub opacity: f32,
    /// Pixels on either side of the edge.
    pub width_px: f32,
}

impl Default for Wire {
    fn default() -> Self {
        Self { color: [20, 22, 28], opacity: 0.45, width_px: 0.7 }
    }
}

/// Where a brush would paint: a ring on part of a surface, and a breath of its colour inside.
#[derive(Clone, Debug)]
pub struct BrushRing {
    /// How far each vertex is from the brush's centre, as far as that matters.
    pub(crate) reach: VertexPaint,
    values: Vec<f32>,
    /// The triangles that it lies on.
    pub(crate) triangles: wgpu::Buffer,
    pub(crate) corners: u32,
    pub(crate) radius: f32,
    pub(crate) color: [u8; 3],
}

impl BrushRing {
    /// A ring of colour `color` (sRGB) for shapes of `vertices` vertices, which lies nowhere yet.
    pub fn new(gpu: &Gpu, vertices: usize, color: [u8; 3]) -> Self {
        let triangles = index_buffer(gpu, 1);
        let (reach, values) = (VertexPaint::new(gpu, vertices), vec![0.0; vertices]);
        Self { reach, values, triangles, corners: 0, radius: 0.0, color }
    }

    /// Lays the ring where the distance is `radius`, on `triangles` whose corners have a `reach`, their
    /// distance from the brush's centre.
    ///
    /// # Errors
    /// [`ViewError::Shape`] for a vertex out of range.
    pub fn lay(
        &mut self,
        gpu: &Gpu,
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
        let bytes: &[u8] = bytemuck::cast_slice(triangles);
        if self.triangles.size() < bytes.len() as u64 {
            self.triangles = index_buffer(gpu, triangles.len().next_power_of_two());
        }
        gpu.queue.write_buffer(&self.triangles, 0, bytes);
        (self.radius, self.corners) = (radius, 3 * triangles.len() as u32);
        self.reach.write_values(gpu, &self.values)
    }

    /// Takes the ring off.
    pub fn lift(&mut self) {
        self.corners = 0;
    }
}

fn index_buffer(gpu: &Gpu, triangles: usize) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("brush"),
        size: (12 * triangles) as u64,
        usage: wgpu::BufferUsages::INDEX | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// One item in a cell.
#[derive(Clone, Copy, Debug)]
pub struct Figure<'a> {
    /// Triangles.
    pub topology: &'a Topology,
    /// Positions and normals.
    pub buffers: &'a ItemBuffers,
    /// Which item of the buffers.
    pub item: usize,
    /// From the item's coordinates to the scene's: a similarity, column-major.
    pub model: [[f32; 4]; 4],
    /// How it answers to light.
    pub material: Material,
    /// What gives it its colour.
    pub paint: Paint<'a>,
    /// 1 is opaque. Translucent figures are to be listed last.
    pub opacity: f32,
    /// Edges, where they are to be seen.
    pub wire: Option<Wire>,
    /// Brush ring, where there is one.
    pub brush: Option<&'a BrushRing>,
}

/// A similarity that changes nothing.
pub const IDENTITY: [[f32; 4]; 4] =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

impl<'a> Figure<'a> {
    /// Item `item` in the default material, where its coordinates say.
    pub fn new(topology: &'a Topology, buffers: &'a ItemBuffers, item: usize) -> Self {
        Self {
            topology,
            buffers,
            item,
            model: IDENTITY,
            material: Material::CLAY,
            paint: Paint::Material,
            opacity: 1.0,
            wire: None,
            brush: None,
        }
    }
}

/// A disc that faces the viewer: a landmark. Behind the surface it shows through faintly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Marker {
    /// In the scene.
    pub position: [f32; 3],
    /// Pixels.
    pub radius_px: f32,
    /// sRGB and opacity.
    pub color: [u8; 4],
}

/// One picture within the canvas.
#[derive(Clone, Copy, Debug)]
pub struct Cell<'a> {
    /// Where on the canvas, pixels.
    pub viewport: Rect,
    /// Who looks.
    pub camera: Camera,
    /// What shines.
    pub lights: Lights,
    /// What is behind.
    pub background: Background,
    /// What stands there.
    pub figures: &'a [Figure<'a>],
    /// Landmarks.
    pub markers: &'a [Marker],
}

impl<'a> Cell<'a> {
    /// Each of `figures` in its own viewport, before one `background` over `area`, so that no
    /// seams show; the background's cell comes first. No markers.
    pub fn gallery(
        area: Rect,
        background: Background,
        camera: Camera,
        lights: Lights,
        figures: impl IntoIterator<Item = (Rect, &'a Figure<'a>)>,
    ) -> Vec<Self> {
        let cell = |viewport, background, figures| Self {
            viewport,
            camera,
            lights,
            background,
            figures,
            markers: &[],
        };
        let mut cells = vec![cell(area, background, &[])];
        cells.extend(
            figures.into_iter().map(|(viewport, figure)| {
                cell(viewport, Background::TRANSPARENT, std::slice::from_ref(figure))
            }),
        );
        cells
    }
}
