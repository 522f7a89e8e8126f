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
    let mut required_limits = wgpu::Limits::default();
    restrict(&mut required_limits);
    let wanted = wgpu::DeviceDescriptor { required_limits, ..Default::default() };
    Some(pollster::block_on(adapter(Default::default())?.request_device(&wanted)).unwrap())
}

fn adapter(memory_budget_thresholds: wgpu::MemoryBudgetThresholds) -> Option<wgpu::Adapter> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        memory_budget_thresholds,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()));
    if adapter.is_err() {
        eprintln!("skipped: no graphics device here");
    }
    adapter.ok()
}

/// A separate device that has no memory any more from a fiftieth of its budget on.
pub fn open_short_of_memory() -> Option<(wgpu::Device, wgpu::Queue)> {
    if cfg!(miri) {
        return None;
    }
    let short = wgpu::MemoryBudgetThresholds { for_resource_creation: Some(2), for_device_loss: None };
    let memory_hints = wgpu::MemoryHints::MemoryUsage;
    let wanted = wgpu::DeviceDescriptor { memory_hints, ..Default::default() };
    Some(pollster::block_on(adapter(short)?.request_device(&wanted)).unwrap())
}

/// Takes what memory such a device has, but for what is less than 64 KiB; `None` where its driver does not say how much
/// that is. None of it is written to.
pub fn fill(device: &wgpu::Device) -> Option<Vec<wgpu::Buffer>> {
    let (mut taken, mut size) = (Vec::new(), device.limits().max_buffer_size.min(1 << 28));
    while taken.len() < 400 {
        let scope = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size,
            usage: wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        });
        if pollster::block_on(scope.pop()).is_none() {
            taken.push(buffer);
            // A fiftieth of 100 GiB, if the driver counts at all.
            if size == 1 << 28 && taken.len() == 8 {
                break;
            }
        } else if size <= 1 << 16 {
            return Some(taken);
        } else {
            size /= 2;
        }
    }
    eprintln!("skipped: this driver does not say that its device has little memory");
    None
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
