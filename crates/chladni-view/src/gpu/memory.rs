//! The device's memory: buffers and images.

use wgpu::BufferUsages;
use wgpu::util::DeviceExt;

use super::lookup::Lookup;
use crate::Gpu;

pub(crate) type Buffer = wgpu::Buffer;
pub(crate) type Image = wgpu::TextureView;

/// How draw calls read a buffer. Shaders can look up both kinds, except indices where look-ups go through textures.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Use {
    Vertices,
    Indices,
}

impl Use {
    fn usages(self, gpu: &Gpu) -> BufferUsages {
        let read = match (self, gpu.lookup()) {
            (Self::Vertices, Lookup::Storage) => BufferUsages::VERTEX | BufferUsages::STORAGE,
            (Self::Vertices, Lookup::Textures) => BufferUsages::VERTEX | BufferUsages::COPY_SRC,
            (Self::Indices, Lookup::Storage) => BufferUsages::INDEX | BufferUsages::STORAGE,
            // WebGL has buffers of triangles for nothing else.
            (Self::Indices, Lookup::Textures) => BufferUsages::INDEX,
        };
        read | BufferUsages::COPY_DST
    }
}

/// A buffer of these bytes, at least one.
pub(crate) fn filled(gpu: &Gpu, label: &str, contents: &[u8], used: Use) -> Buffer {
    initialized(&gpu.device, label, contents, used.usages(gpu))
}

/// The same for any use. wgpu's own way to this panics where there is no memory, or no device any more.
pub(super) fn initialized(
    device: &wgpu::Device,
    label: &str,
    contents: &[u8],
    usage: BufferUsages,
) -> Buffer {
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: (contents.len() as u64).max(1).next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT),
        usage,
        mapped_at_creation: true,
    });
    // Else the device's callbacks hear of it.
    if let Ok(mut mapped) = buffer.get_mapped_range_mut(..) {
        mapped.slice(..contents.len()).copy_from_slice(contents);
        drop(mapped);
        buffer.unmap();
    }
    buffer
}

/// These triangles, the bytes of `contents`, where vertex stages look them up.
pub(crate) fn looked_up(gpu: &Gpu, triangles: &Buffer, contents: &[u8]) -> Buffer {
    match gpu.lookup() {
        Lookup::Storage => triangles.clone(),
        Lookup::Textures => filled(gpu, "corners", contents, Use::Vertices),
    }
}

/// A buffer with room for this many bytes, at least one.
pub(crate) fn room(gpu: &Gpu, label: &str, bytes: usize, used: Use) -> Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: bytes as u64,
        usage: used.usages(gpu),
        mapped_at_creation: false,
    })
}

/// Queues bytes for a buffer, from a byte of it on.
pub(crate) fn write(gpu: &Gpu, buffer: &Buffer, offset: u64, bytes: &[u8]) {
    gpu.queue.write_buffer(buffer, offset, bytes);
}

/// Its bytes.
pub(crate) fn size(buffer: &Buffer) -> u64 {
    buffer.size()
}

/// An sRGB image of this width, height and number of levels: itself and its mipmaps, one after the other.
pub(crate) fn image(gpu: &Gpu, label: &str, [width, height, levels]: [u32; 3], pyramid: &[u8]) -> Image {
    let texture = gpu.device.create_texture_with_data(
        &gpu.queue,
        &wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: levels,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8UnormSrgb,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        },
        wgpu::util::TextureDataOrder::LayerMajor,
        pyramid,
    );
    super::screen::view(&texture)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_that_is_gone_fills_no_buffer_and_does_not_end_the_program() {
        let Ok(gpu) = Gpu::headless() else { return };
        // Bytes that are no whole words, too.
        let _ = filled(&gpu, "test", &[1, 2, 3], Use::Vertices);
        assert!(gpu.check().is_ok());
        gpu.device.destroy();
        let _ = gpu.device.poll(wgpu::PollType::wait_indefinitely());
        let _ = filled(&gpu, "test", &[1, 2, 3, 4], Use::Vertices);
        assert!(gpu.check().is_err());
    }
}
