//! Grains on their way to the device.

use crate::scene::Grain;
use crate::{Cell, Gpu};

/// Bytes of one grain.
pub(crate) const GRAIN_BYTES: u64 = size_of::<Grain>() as u64;

/// The grains of a picture, figure after figure.
pub(crate) struct GrainBuffer {
    buffer: Option<wgpu::Buffer>,
}

impl GrainBuffer {
    pub(crate) fn new() -> Self {
        Self { buffer: None }
    }

    /// Queues the grains of all cells.
    pub(crate) fn upload(&mut self, Gpu { device, queue, .. }: &Gpu, cells: &[Cell<'_>]) {
        let grains = || cells.iter().flat_map(|cell| cell.figures).filter_map(|figure| figure.grains);
        let bytes: u64 = grains().map(|of| size_of_val(of.grains) as u64).sum();
        if bytes == 0 {
            return;
        }
        if self.buffer.as_ref().is_none_or(|buffer| buffer.size() < bytes) {
            self.buffer = Some(device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("grains"),
                size: bytes.next_power_of_two(),
                usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }));
        }
        let Some(buffer) = &self.buffer else { return };
        let mut start = 0;
        for of in grains().filter(|of| !of.grains.is_empty()) {
            queue.write_buffer(buffer, start, bytemuck::cast_slice(of.grains));
            start += size_of_val(of.grains) as u64;
        }
    }

    /// The `count` grains after the first `before` of the picture.
    pub(crate) fn slice(&self, before: u64, count: u64) -> Option<wgpu::BufferSlice<'_>> {
        let bytes = before * GRAIN_BYTES..(before + count) * GRAIN_BYTES;
        self.buffer
            .as_ref()
            .filter(|buffer| count > 0 && bytes.end <= buffer.size())
            .map(|buffer| buffer.slice(bytes))
    }
}
