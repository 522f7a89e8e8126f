//! Many uniforms of one kind in one buffer.

use bytemuck::Pod;

use super::bindings;

/// Many values of one uniform, distinguished by their dynamic offset.
pub(super) struct Uniforms<T> {
    label: &'static str,
    pub(super) bytes: Vec<u8>,
    stride: usize,
    buffer: wgpu::Buffer,
    pub(super) group: wgpu::BindGroup,
    kind: std::marker::PhantomData<T>,
}

impl<T: Pod> Uniforms<T> {
    pub(super) fn new(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, label: &'static str) -> Self {
        let alignment = device.limits().min_uniform_buffer_offset_alignment as usize;
        let stride = size_of::<T>().next_multiple_of(alignment);
        let (buffer, group) = Self::room(device, layout, label, 16 * stride);
        Self { label, bytes: Vec::new(), stride, buffer, group, kind: std::marker::PhantomData }
    }

    fn room(
        device: &wgpu::Device,
        layout: &wgpu::BindGroupLayout,
        label: &str,
        bytes: usize,
    ) -> (wgpu::Buffer, wgpu::BindGroup) {
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let size = wgpu::BufferSize::new(size_of::<T>() as u64);
        let one = wgpu::BufferBinding { buffer: &buffer, offset: 0, size };
        let group = bindings::group(device, label, layout, &[wgpu::BindingResource::Buffer(one)]);
        (buffer, group)
    }

    pub(super) fn clear(&mut self) {
        self.bytes.clear();
    }

    pub(super) fn push(&mut self, value: &T) {
        let start = self.bytes.len();
        self.bytes.extend_from_slice(bytemuck::bytes_of(value));
        self.bytes.resize(start + self.stride, 0);
    }

    pub(super) fn offset(&self, index: usize) -> u32 {
        (index * self.stride) as u32
    }

    pub(super) fn upload(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        layout: &wgpu::BindGroupLayout,
    ) {
        if self.buffer.size() < self.bytes.len() as u64 {
            let bytes = self.bytes.len().next_power_of_two();
            (self.buffer, self.group) = Self::room(device, layout, self.label, bytes);
        }
        queue.write_buffer(&self.buffer, 0, &self.bytes);
    }
}
