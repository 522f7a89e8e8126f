//! Where a frame lies on the device, for whoever draws it.

use crate::{CpuSynthesizer, SynthError, Synthesizer};

/// Bytes of a position or a normal: three f32.
pub(crate) const VERTEX_BYTES: u64 = 12;

/// One frame on the device, ready to be drawn from without a copy.
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

/// The buffers of a [`DeviceFrame`]: usable as vertex and storage buffers and as source and
/// target of copies. They grow when a frame needs it and are kept otherwise.
#[derive(Debug)]
pub struct DeviceFrameBuffers {
    device: wgpu::Device,
    positions: wgpu::Buffer,
    normals: wgpu::Buffer,
    vertices: u32,
    items: u32,
}

impl DeviceFrameBuffers {
    /// Buffers without a frame.
    pub fn new(device: &wgpu::Device) -> Self {
        let (positions, normals) = buffers(device, VERTEX_BYTES);
        Self { device: device.clone(), positions, normals, vertices: 0, items: 0 }
    }

    /// The frame they hold.
    pub fn frame(&self) -> DeviceFrame<'_> {
        let Self { positions, normals, vertices, items, .. } = self;
        DeviceFrame { positions, normals, vertices: *vertices, items: *items }
    }

    /// Makes room for a frame and says whether the buffers are new ones.
    pub(crate) fn resize(&mut self, items: usize, vertices: usize) -> Result<bool, SynthError> {
        let too_large = || SynthError::TooLarge { items, vertices };
        let narrow = |n: usize| u32::try_from(n).map_err(|_| too_large());
        let (s, n) = (narrow(items)?, narrow(vertices)?);
        let bytes = u64::from(s).checked_mul(u64::from(n) * VERTEX_BYTES).ok_or_else(too_large)?;
        let bytes = bytes.max(VERTEX_BYTES);
        let limits = self.device.limits();
        let limit = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
        if bytes > limit {
            return Err(SynthError::DeviceLimit { what: "frame", needed: bytes, limit });
        }
        let grow = bytes > self.positions.size();
        if grow {
            (self.positions, self.normals) = buffers(&self.device, bytes);
        }
        (self.items, self.vertices) = (s, n);
        Ok(grow)
    }
}

fn buffers(device: &wgpu::Device, size: u64) -> (wgpu::Buffer, wgpu::Buffer) {
    let usage = wgpu::BufferUsages::STORAGE
        | wgpu::BufferUsages::VERTEX
        | wgpu::BufferUsages::COPY_SRC
        | wgpu::BufferUsages::COPY_DST;
    let buffer = |label| {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage,
            mapped_at_creation: false,
        })
    };
    (buffer("synth positions"), buffer("synth normals"))
}

impl CpuSynthesizer {
    /// Copies the last frame to the device, where it is drawn like one that was made there.
    ///
    /// Fails if the frame is larger than the device's buffers may be.
    pub fn upload(&self, queue: &wgpu::Queue, buffers: &mut DeviceFrameBuffers) -> Result<(), SynthError> {
        buffers.resize(self.items(), self.model().vertices())?;
        queue.write_buffer(&buffers.positions, 0, bytemuck::cast_slice(self.all_positions()));
        queue.write_buffer(&buffers.normals, 0, bytemuck::cast_slice(self.all_normals()));
        Ok(())
    }
}
