//! The device that draws, with or without a window.

use std::sync::{Arc, Mutex, PoisonError};

use crate::ViewError;

/// A graphics device and its queue. Clones share them.
///
/// A window hands its own in with [`Gpu::shared`]; everything else opens one with
/// [`Gpu::headless`].
#[derive(Clone, Debug)]
pub struct Gpu {
    /// Makes pipelines, buffers and textures.
    pub device: wgpu::Device,
    /// Takes commands.
    pub queue: wgpu::Queue,
    failure: Arc<Mutex<Option<String>>>,
}

impl Gpu {
    /// Opens the fastest adapter of this machine without a window; a software adapter is accepted
    /// where there is no card. `WGPU_BACKEND` and `WGPU_ADAPTER_NAME` choose by hand.
    ///
    /// # Errors
    /// [`ViewError::NoAdapter`] where no driver is installed, [`ViewError::NoDevice`] where it
    /// refuses.
    pub fn headless() -> Result<Self, ViewError> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
        // GL drivers lack what the corner pipelines need and are no faster than lavapipe.
        descriptor.backends &= wgpu::Backends::PRIMARY;
        let instance = wgpu::Instance::new(descriptor);
        let adapter = pollster::block_on(Self::adapter(&instance))?;
        let adapter_name = adapter.get_info().name;
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("chladni"),
            // What the card allows: synthesis binds large buffers.
            required_limits: adapter.limits(),
            ..Default::default()
        }))
        .map_err(|error| ViewError::NoDevice { adapter: adapter_name, reason: error.to_string() })?;
        let gpu = Self::shared(device, queue);
        let lost = gpu.failure.clone();
        gpu.device.set_device_lost_callback(move |_, message| remember(&lost, message));
        let refused = gpu.failure.clone();
        gpu.device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            remember(&refused, error.to_string());
        }));
        Ok(gpu)
    }

    async fn adapter(instance: &wgpu::Instance) -> Result<wgpu::Adapter, ViewError> {
        if let Ok(wanted) = std::env::var("WGPU_ADAPTER_NAME") {
            let wanted = wanted.to_lowercase();
            let adapters = instance.enumerate_adapters(wgpu::Backends::PRIMARY).await;
            return adapters
                .into_iter()
                .find(|adapter| adapter.get_info().name.to_lowercase().contains(&wanted))
                .ok_or_else(|| ViewError::NoAdapter(format!("none is named {wanted}")));
        }
        let mut options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..Default::default()
        };
        if let Ok(adapter) = instance.request_adapter(&options).await {
            return Ok(adapter);
        }
        options.force_fallback_adapter = true;
        instance.request_adapter(&options).await.map_err(|error| ViewError::NoAdapter(error.to_string()))
    }

    /// A device that belongs to somebody else, such as a window. Its error handlers are left
    /// alone, so that [`check`](Self::check) reports nothing here.
    pub fn shared(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        Self { device, queue, failure: Arc::default() }
    }

    /// Name and kind of the adapter, for reports: `llvmpipe (…), Cpu, Vulkan`.
    pub fn description(&self) -> String {
        let info = self.device.adapter_info();
        format!("{}, {:?}, {:?}", info.name, info.device_type, info.backend)
    }

    /// Whether drawing runs on the processor, so that sizes are better kept small.
    pub fn is_software(&self) -> bool {
        self.device.adapter_info().device_type == wgpu::DeviceType::Cpu
    }

    /// The first error the device reported since it was opened, as an error.
    ///
    /// # Errors
    /// [`ViewError::Device`] once the device was lost or refused a command.
    pub fn check(&self) -> Result<(), ViewError> {
        match &*self.failure.lock().unwrap_or_else(PoisonError::into_inner) {
            Some(message) => Err(ViewError::Device(message.clone())),
            None => Ok(()),
        }
    }

    /// Waits until `submission` is done.
    pub(crate) fn wait(&self, submission: wgpu::SubmissionIndex) -> Result<(), ViewError> {
        self.device
            .poll(wgpu::PollType::Wait { submission_index: Some(submission), timeout: None })
            .map_err(|error| ViewError::Device(error.to_string()))?;
        self.check()
    }
}

fn remember(failure: &Mutex<Option<String>>, message: String) {
    failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(message);
}
