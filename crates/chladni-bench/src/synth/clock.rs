//! The device's own clock, which excludes the time to submit work.

use chladni_view::Gpu;
use eframe::wgpu;

use crate::easel::wait;
use chladni_program::work::Error;

/// Two time stamps, before and after some work.
pub struct DeviceClock {
    gpu: Gpu,
    stamps: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readable: wgpu::Buffer,
}

const BYTES: u64 = 16;

impl DeviceClock {
    /// `None` where the device has no clock that can be read.
    pub fn new(gpu: &Gpu) -> Option<Self> {
        if !gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS) {
            return None;
        }
        let buffer = |usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("time stamps"),
                size: BYTES,
                usage,
                mapped_at_creation: false,
            })
        };
        Some(Self {
            stamps: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("time stamps"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            }),
            resolved: buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
            readable: buffer(wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ),
            gpu: gpu.clone(),
        })
    }

    /// How long the device takes for what `work` submits, in seconds.
    pub fn secs(&self, work: impl FnOnce() -> Result<(), Error>) -> Result<f64, Error> {
        let Gpu { device, queue, .. } = &self.gpu;
        let encoder = || device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut before = encoder();
        before.write_timestamp(&self.stamps, 0);
        queue.submit([before.finish()]);
        work()?;
        let mut after = encoder();
        after.write_timestamp(&self.stamps, 1);
        after.resolve_query_set(&self.stamps, 0..2, &self.resolved, 0);
        after.copy_buffer_to_buffer(&self.resolved, 0, &self.readable, 0, BYTES);
        queue.submit([after.finish()]);
        // Called while waiting; on failure the range is not mapped.
        self.readable.map_async(wgpu::MapMode::Read, .., |_| {});
        wait(&self.gpu)?;
        let ticks = {
            let bytes = self.readable.get_mapped_range(..).map_err(Error::other)?;
            let stamp = |at: usize| {
                bytes.get(at..at + 8).and_then(|eight| eight.try_into().ok()).map_or(0, u64::from_le_bytes)
            };
            stamp(8).saturating_sub(stamp(0))
        };
        self.readable.unmap();
        Ok(ticks as f64 * f64::from(queue.get_timestamp_period()) * 1e-9)
    }
}
