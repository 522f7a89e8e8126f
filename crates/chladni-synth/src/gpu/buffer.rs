//! Device buffers that grow and never shrink.

use crate::SynthError;

/// The smallest size of a buffer, in bytes: a buffer smaller than the shader's type cannot be bound.
const SMALLEST: u64 = 64;

/// A buffer that is replaced by a larger one if a frame needs it.
#[derive(Debug)]
pub(super) struct GrowingBuffer {
    device: wgpu::Device,
    label: &'static str,
    buffer: wgpu::Buffer,
}

impl GrowingBuffer {
    pub fn new(device: &wgpu::Device, label: &'static str, usage: wgpu::BufferUsages) -> Self {
        Self { device: device.clone(), label, buffer: create(device, label, usage, SMALLEST) }
    }

    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    /// Makes room for `bytes`. Returns whether the buffer was replaced; a new one contains zeros.
    pub fn reserve(&mut self, bytes: u64) -> Result<bool, SynthError> {
        check_size(&self.device, self.label, bytes)?;
        let grow = bytes > self.buffer.size();
        if grow {
            self.buffer = create(&self.device, self.label, self.buffer.usage(), bytes);
        }
        Ok(grow)
    }

    /// Replaces the content from the start. Returns whether the buffer was replaced.
    pub fn write(&mut self, queue: &wgpu::Queue, content: &[u8]) -> Result<bool, SynthError> {
        let grown = self.reserve(content.len() as u64)?;
        queue.write_buffer(&self.buffer, 0, content);
        Ok(grown)
    }
}

/// Creates a buffer with fixed content.
pub(super) fn filled(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    label: &'static str,
    usage: wgpu::BufferUsages,
    content: &[u8],
) -> Result<wgpu::Buffer, SynthError> {
    check_size(device, label, content.len() as u64)?;
    let usage = usage | wgpu::BufferUsages::COPY_DST;
    let buffer = create(device, label, usage, (content.len() as u64).max(SMALLEST));
    queue.write_buffer(&buffer, 0, content);
    Ok(buffer)
}

fn check_size(device: &wgpu::Device, what: &'static str, needed: u64) -> Result<(), SynthError> {
    let limits = device.limits();
    let limit = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
    if needed > limit { Err(SynthError::DeviceLimit { what, needed, limit }) } else { Ok(()) }
}

fn create(device: &wgpu::Device, label: &str, usage: wgpu::BufferUsages, size: u64) -> wgpu::Buffer {
    let size = size.next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT);
    #[cfg(test)]
    if !super::full_memory::takes(size) {
        return super::full_memory::refused(device, label, size);
    }
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage,
        mapped_at_creation: false,
    })
}
