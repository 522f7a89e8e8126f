//! The graphics device of this machine, if it has one, and reading its buffers.

use std::sync::OnceLock;

use chladni_synth::{DeviceFrame, DeviceLoss, GpuContext};

struct Device {
    device: wgpu::Device,
    queue: wgpu::Queue,
    context: GpuContext,
}

/// One device for all tests. Prints a line if there is none.
fn shared() -> Option<&'static Device> {
    static DEVICE: OnceLock<Option<Device>> = OnceLock::new();
    DEVICE
        .get_or_init(|| {
            let (device, queue) = open(|_| ())?;
            let context = GpuContext::new(&device, &queue, &DeviceLoss::watch(&device));
            Some(Device { device, queue, context })
        })
        .as_ref()
}

pub fn context() -> Option<&'static GpuContext> {
    shared().map(|device| &device.context)
}

/// A separate device, whose limits are changed by `restrict`.
pub fn open(restrict: impl FnOnce(&mut wgpu::Limits)) -> Option<(wgpu::Device, wgpu::Queue)> {
    if cfg!(miri) {
        // Miri cannot call drivers.
        return None;
    }
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()));
    let Ok(adapter) = adapter else {
        eprintln!("skipped: no graphics device here");
        return None;
    };
    let mut required_limits = wgpu::Limits::default();
    restrict(&mut required_limits);
    let descriptor = wgpu::DeviceDescriptor { required_limits, ..Default::default() };
    Some(pollster::block_on(adapter.request_device(&descriptor)).unwrap())
}

/// Positions and normals of a frame on the shared device.
pub fn read(frame: DeviceFrame<'_>) -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
    let Device { device, queue, .. } = shared().unwrap();
    (read_buffer(device, queue, frame.positions, &frame), read_buffer(device, queue, frame.normals, &frame))
}

/// The vertices of one buffer of a frame.
pub fn read_buffer(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
    frame: &DeviceFrame<'_>,
) -> Vec<[f32; 3]> {
    let size = 12 * u64::from(frame.items) * u64::from(frame.vertices);
    if size == 0 {
        return Vec::new();
    }
    let staging = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, size);
    queue.submit([encoder.finish()]);
    staging.slice(..).map_async(wgpu::MapMode::Read, Result::unwrap);
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    bytemuck::cast_slice(&staging.slice(..).get_mapped_range().unwrap()).to_vec()
}
