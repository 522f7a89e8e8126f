//! Full memory on any driver, for tests: of a limit of our own, as many drivers do not say how much a device has.

use std::cell::Cell;

thread_local! {
    /// Bytes that buffers which this thread creates may still take.
    static LEFT: Cell<u64> = const { Cell::new(u64::MAX) };
}

/// From now on buffers that this thread creates find `bytes` and no more.
pub(crate) fn leave(bytes: u64) {
    LEFT.set(bytes);
}

/// Takes `bytes`; false where there are not as many.
pub(super) fn takes(bytes: u64) -> bool {
    LEFT.get().checked_sub(bytes).map(|left| LEFT.set(left)).is_some()
}

/// What a device makes of a buffer for which it has no memory: it reports that, and the buffer is of no use. The report is the
/// driver's own, for a picture of hundreds of gigabytes.
pub(super) fn refused(device: &wgpu::Device, label: &str, size: u64) -> wgpu::Buffer {
    let limits = device.limits();
    let (side, layers) = (limits.max_texture_dimension_2d, limits.max_texture_array_layers);
    let _ = device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: layers },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        // No device makes one for both.
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::VERTEX,
        mapped_at_creation: false,
    });
    assert!(pollster::block_on(scope.pop()).is_some(), "the device has made it");
    buffer
}
