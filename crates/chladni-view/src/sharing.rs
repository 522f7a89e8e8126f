//! Textures and buffers shared with a window or a synthesizer on the same device, without a copy.

use crate::buffers::{DeviceItems, Held};
use crate::{Canvas, Gpu, ItemBuffers, Renderer, Samples, ViewError, gpu};

impl Canvas {
    /// The format of pictures and of what egui shows: sRGB-encoded numbers, premultiplied alpha.
    pub const FORMAT: wgpu::TextureFormat = gpu::Canvas::FORMAT;

    /// A canvas of a graphics device in another eight-bit format, `…Unorm` or `…UnormSrgb`; the
    /// renderer that draws on it must have been made for the same.
    ///
    /// # Errors
    /// [`ViewError::Size`] where a side is 0 or too long for the device.
    pub fn with_format(
        gpu: &Gpu,
        width: u32,
        height: u32,
        format: wgpu::TextureFormat,
        samples: Samples,
    ) -> Result<Self, ViewError> {
        Ok(Self { held: Held::Gpu(gpu::Canvas::new(gpu, width, height, format, samples)?) })
    }

    /// The finished picture, to show in a window: `Renderer::register_native_texture` of
    /// egui-wgpu takes it as it is.
    ///
    /// # Errors
    /// [`ViewError::Shape`] where the processor draws: its pictures are no textures.
    pub fn view(&self) -> Result<&wgpu::TextureView, ViewError> {
        Ok(&self.held.gpu()?.finished_view)
    }
}

impl Renderer {
    /// A renderer of a graphics device for canvases of another eight-bit format.
    pub fn with_format(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        Self { device: gpu.into(), held: Held::Gpu(Box::new(gpu::Renderer::new(gpu, format))), seen: None }
    }
}

impl ItemBuffers {
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
        Ok(Self { vertices, items, held: Held::Gpu(DeviceItems { positions, normals }) })
    }

    /// Draws the frame that a synthesizer has left on the device; nothing is copied. The synthesizer's next
    /// frame shows in the same buffers as long as they need not grow: take its frame anew each time.
    ///
    /// # Errors
    /// [`ViewError::Shape`] where the frame's buffers cannot be drawn from.
    pub fn of_frame(frame: &chladni_synth::DeviceFrame<'_>) -> Result<Self, ViewError> {
        let (vertices, items) = (frame.vertices as usize, frame.items as usize);
        Self::borrowed(frame.positions.clone(), frame.normals.clone(), vertices, items)
    }
}
