//! The buffers that hold a frame on the device, for drawing.

use super::buffer::GrowingBuffer;
use crate::{CpuSynthesizer, SynthError, Synthesizer};

/// Bytes of a position or a normal: three f32.
const VERTEX_BYTES: u64 = 12;

/// One frame on the device, which can be drawn without a copy.
#[derive(Clone, Copy, Debug)]
pub struct DeviceFrame<'a> {
    /// S·N positions, tightly packed f32 xyz; item s starts at vertex s·N.
    pub positions: &'a wgpu::Buffer,
    /// S·N unit normals, laid out like the positions.
    pub normals: &'a wgpu::Buffer,
    /// N.
    pub vertices: u32,
    /// S.
    pub items: u32,
}

/// The buffers of a [`DeviceFrame`], usable as vertex and storage buffers and as source and target of
/// copies. They grow when a frame needs it.
#[derive(Debug)]
pub struct DeviceFrameBuffers {
    positions: GrowingBuffer,
    normals: GrowingBuffer,
    vertices: u32,
    items: u32,
}

impl DeviceFrameBuffers {
    /// Buffers without a frame.
    pub fn new(device: &wgpu::Device) -> Self {
        let usage = wgpu::BufferUsages::STORAGE
            | wgpu::BufferUsages::VERTEX
            | wgpu::BufferUsages::COPY_SRC
            | wgpu::BufferUsages::COPY_DST;
        let buffer = |label| GrowingBuffer::new(device, label, usage);
        Self {
            positions: buffer("frame's positions"),
            normals: buffer("frame's normals"),
            vertices: 0,
            items: 0,
        }
    }

    /// The frame that the buffers hold.
    pub fn frame(&self) -> DeviceFrame<'_> {
        DeviceFrame {
            positions: self.positions.buffer(),
            normals: self.normals.buffer(),
            vertices: self.vertices,
            items: self.items,
        }
    }

    /// Makes room for a frame. Returns whether a buffer was replaced.
    pub(super) fn resize(&mut self, items: usize, vertices: usize) -> Result<bool, SynthError> {
        let too_large = || SynthError::TooLarge { items, vertices };
        let narrow = |n: usize| u32::try_from(n).map_err(|_| too_large());
        (self.items, self.vertices) = (narrow(items)?, narrow(vertices)?);
        let bytes = u64::from(self.items).checked_mul(u64::from(self.vertices) * VERTEX_BYTES);
        let bytes = bytes.ok_or_else(too_large)?;
        // `|` instead of `||`: both must grow, even if the first is new.
        Ok(self.positions.reserve(bytes)? | self.normals.reserve(bytes)?)
    }
}

impl CpuSynthesizer {
    /// Copies the last frame to the device, where it can be drawn like a frame that was computed there.
    ///
    /// # Errors
    /// The frame is larger than a buffer of the device may be.
    pub fn upload(&self, queue: &wgpu::Queue, buffers: &mut DeviceFrameBuffers) -> Result<(), SynthError> {
        buffers.resize(self.items(), self.model().vertices())?;
        queue.write_buffer(buffers.positions.buffer(), 0, bytemuck::cast_slice(self.all_positions()));
        queue.write_buffer(buffers.normals.buffer(), 0, bytemuck::cast_slice(self.all_normals()));
        Ok(())
    }
}
