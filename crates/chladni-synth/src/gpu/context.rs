//! What all synthesizers of one device share: the pipelines, and whether the device was lost.

use std::sync::{Arc, OnceLock};

use super::DeviceLoss;
use super::checked::checked;
use super::pipelines::Pipelines;
use crate::SynthError;

/// The largest number of storage buffers in any shader.
const STORAGE_BUFFERS: u32 = 7;

/// Threads of a workgroup, in every shader.
pub(super) const WORKGROUP: u32 = 64;

/// A device prepared for synthesis. Cloning is cheap; make one per device.
#[derive(Clone, Debug)]
pub struct GpuContext {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pipelines: Arc<OnceLock<Pipelines>>,
    loss: DeviceLoss,
}

impl GpuContext {
    /// A context. `loss` is the device's own, from the code that opened it. Whether the device can compute is
    /// checked when a [`GpuSynthesizer`](crate::GpuSynthesizer) is made.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, loss: &DeviceLoss) -> Self {
        let pipelines = Arc::default();
        Self { device: device.clone(), queue: queue.clone(), pipelines, loss: loss.clone() }
    }

    /// The pipelines; the first call compiles them, so that the CPU backend never waits for it.
    ///
    /// Fails if the device has no compute shaders of the size needed, or refuses ours.
    pub(super) fn pipelines(&self) -> Result<&Pipelines, SynthError> {
        if let Some(pipelines) = self.pipelines.get() {
            return Ok(pipelines);
        }
        let limits = self.device.limits();
        if limits.max_compute_invocations_per_workgroup < WORKGROUP
            || limits.max_storage_buffers_per_shader_stage < STORAGE_BUFFERS
        {
            return Err(SynthError::Device("it has no compute shaders of the size needed".into()));
        }
        let made = checked(&self.device, || Pipelines::new(&self.device))?;
        Ok(self.pipelines.get_or_init(|| made))
    }

    /// Why the device was lost; `None` while it works.
    pub fn lost(&self) -> Option<&str> {
        self.loss.reason()
    }

    /// "NVIDIA GeForce RTX 4070 (Vulkan)", say.
    pub fn device_name(&self) -> String {
        let info = self.device.adapter_info();
        format!("{} ({})", info.name, info.backend)
    }

    /// Whether the device is a software device, on which the CPU backend is faster.
    pub fn is_software(&self) -> bool {
        self.device.adapter_info().device_type == wgpu::DeviceType::Cpu
    }

    pub(super) fn check_present(&self) -> Result<(), SynthError> {
        self.lost().map_or(Ok(()), |why| Err(SynthError::Device(format!("it was lost ({why})"))))
    }
}
