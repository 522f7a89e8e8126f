//! State that all synthesizers on one device share: the pipelines, and whether the device was lost.

use std::sync::{Arc, OnceLock};

use super::DeviceLoss;
use super::checked::checked;
use super::pipelines::Pipelines;
use crate::SynthError;

/// The largest number of storage buffers in any of the shaders.
const STORAGE_BUFFERS: u32 = 7;

/// Threads of a workgroup, in every shader.
pub(super) const WORKGROUP: u32 = 64;

/// A device prepared for synthesis. Cloning is cheap, and clones share the pipelines; make one per device.
#[derive(Clone, Debug)]
pub struct GpuContext {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pipelines: Arc<OnceLock<Pipelines>>,
    loss: DeviceLoss,
}

impl GpuContext {
    /// A context for `device`. `loss` must come from the code that opened the device. Whether the device
    /// can compute is checked when a [`GpuSynthesizer`](crate::GpuSynthesizer) is created.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, loss: &DeviceLoss) -> Self {
        let pipelines = Arc::default();
        Self { device: device.clone(), queue: queue.clone(), pipelines, loss: loss.clone() }
    }

    /// The pipelines. The first call compiles them: the CPU backend never has to wait for that.
    ///
    /// Fails if the device has no compute shaders of the size needed, or rejects these.
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

    /// The name of the device, for example "NVIDIA GeForce RTX 4070 (Vulkan)".
    pub fn device_name(&self) -> String {
        let info = self.device.adapter_info();
        format!("{} ({})", info.name, info.backend)
    }

    /// Whether the device is implemented in software; the CPU backend is then faster.
    pub fn is_software(&self) -> bool {
        self.device.adapter_info().device_type == wgpu::DeviceType::Cpu
    }

    pub(super) fn check_present(&self) -> Result<(), SynthError> {
        self.lost().map_or(Ok(()), |why| Err(SynthError::Device(format!("it was lost ({why})"))))
    }
}
