//! The device that draws, with or without a window.

mod bindings;
mod canvas;
mod corners;
mod drawing;
mod finishing;
mod focus;
mod grains;
mod images;
mod lookup;
mod memory;
mod pipelines;
mod renderer;
mod screen;
mod uniforms;

use std::sync::{Arc, OnceLock};

use chladni_synth::{DeviceLoss, GpuContext};

pub(crate) use canvas::{Canvas, Readback};
pub(crate) use memory::{Buffer, Image, Use, filled, image, looked_up, room, size, write};
pub(crate) use renderer::Renderer;

use self::drawing::Drawing;
use self::lookup::Lookup;
use crate::{Samples, ViewError};

/// A graphics device, its queue, and the pipelines for drawing and synthesis. Clones share all of them.
///
/// A window hands its own in with [`Gpu::shared`], once; everything else opens one with
/// [`Gpu::headless`].
#[derive(Clone, Debug)]
pub struct Gpu {
    /// Makes pipelines, buffers and textures.
    pub device: wgpu::Device,
    /// Takes commands.
    pub queue: wgpu::Queue,
    made: Arc<Made>,
}

/// The parts that are made once on a device.
#[derive(Debug)]
struct Made {
    synthesis: GpuContext,
    /// Empty until something is drawn.
    drawing: OnceLock<Drawing>,
}

impl Gpu {
    /// Opens the fastest adapter of this machine without a window; a software adapter is accepted
    /// where there is no card. `WGPU_BACKEND` and `WGPU_ADAPTER_NAME` choose by hand.
    ///
    /// # Errors
    /// [`ViewError::NoAdapter`] where no driver is installed, [`ViewError::NoDevice`] where it
    /// refuses.
    pub fn headless() -> Result<Self, ViewError> {
        let instance = Self::instance();
        let adapter = pollster::block_on(Self::adapter(&instance))?;
        Self::open(&adapter)
    }

    /// As [`headless`](Self::headless), with no more than these limits: a device without storage buffers draws as WebGL2
    /// does.
    ///
    /// # Errors
    /// As [`headless`](Self::headless).
    pub fn headless_within(limits: wgpu::Limits) -> Result<Self, ViewError> {
        let adapter = pollster::block_on(Self::adapter(&Self::instance()))?;
        pollster::block_on(Self::within(&adapter, limits))
    }

    /// Whether the fastest adapter is hardware.
    pub(crate) fn has_card() -> bool {
        pollster::block_on(Self::adapter(&Self::instance())).is_ok_and(|adapter| is_card(&adapter))
    }

    /// As [`headless`](Self::headless), where the fastest adapter is hardware; `None` where it is software, or
    /// where there is none.
    pub(crate) fn card() -> Result<Option<Self>, ViewError> {
        let Ok(adapter) = pollster::block_on(Self::adapter(&Self::instance())) else { return Ok(None) };
        if is_card(&adapter) { Self::open(&adapter).map(Some) } else { Ok(None) }
    }

    fn instance() -> wgpu::Instance {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
        // GL drivers of the desktop lack what synthesis needs and are no faster than lavapipe.
        descriptor.backends &= wgpu::Backends::PRIMARY;
        wgpu::Instance::new(descriptor)
    }

    fn open(adapter: &wgpu::Adapter) -> Result<Self, ViewError> {
        pollster::block_on(Self::on_adapter(adapter))
    }

    /// Opens an adapter that was chosen elsewhere, without blocking, as a browser requires.
    ///
    /// # Errors
    /// [`ViewError::NoDevice`] where it refuses.
    pub async fn on_adapter(adapter: &wgpu::Adapter) -> Result<Self, ViewError> {
        // All that the card allows: synthesis binds large buffers.
        Self::within(adapter, adapter.limits()).await
    }

    async fn within(adapter: &wgpu::Adapter, required_limits: wgpu::Limits) -> Result<Self, ViewError> {
        let wanted = wgpu::DeviceDescriptor {
            label: Some("chladni"),
            required_limits,
            // Benchmarks ask the device's own clock.
            required_features: adapter.features()
                & (wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS),
            ..Default::default()
        };
        let refused = |reason: String| ViewError::NoDevice { adapter: adapter.get_info().name, reason };
        // Every device but some of WebGL's.
        let draws = |format| {
            let usages = adapter.get_texture_format_features(format).allowed_usages;
            usages.contains(wgpu::TextureUsages::RENDER_ATTACHMENT)
        };
        if !draws(focus::LIGHT) || !draws(focus::NUMBER) {
            return Err(refused("it draws no pictures of half floats".into()));
        }
        let opened = adapter.request_device(&wanted).await;
        let (device, queue) = opened.map_err(|error| refused(error.to_string()))?;
        let loss = DeviceLoss::watch(&device);
        Ok(Self::with_loss(device, queue, &loss))
    }

    fn with_loss(device: wgpu::Device, queue: wgpu::Queue, loss: &DeviceLoss) -> Self {
        let synthesis = GpuContext::new(&device, &queue, loss);
        Self { device, queue, made: Arc::new(Made { synthesis, drawing: OnceLock::new() }) }
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

    /// A device that somebody else opened, such as a window. What handles its errors and its loss is
    /// left alone, so that [`check`](Self::check) reports nothing here. Call it once for each device: only clones
    /// share pipelines.
    pub fn shared(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        Self::with_loss(device, queue, &DeviceLoss::default())
    }

    /// The device for synthesizers, which compile their pipelines once for all of them. It knows of the device's loss
    /// as [`check`](Self::check) does.
    pub fn synthesis(&self) -> &GpuContext {
        &self.made.synthesis
    }

    /// The parts that all renderers of the device share; made by the first call.
    fn drawing(&self) -> &Drawing {
        self.made.drawing.get_or_init(|| Drawing::new(self))
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

    /// Samples a pixel for moving pictures: four where there is a graphics card, one where the processor
    /// draws, which takes a third of the time. Still pictures can wait and have four everywhere.
    pub fn live_samples(&self) -> Samples {
        if self.is_software() { Samples::One } else { Samples::Four }
    }

    /// Where vertex stages look up numbers.
    pub(crate) fn lookup(&self) -> Lookup {
        Lookup::within(&self.device.limits())
    }

    /// Longest side of a picture, pixels.
    pub(crate) fn longest_side(&self) -> u32 {
        self.device.limits().max_texture_dimension_2d
    }

    /// The first error the device reported since it was opened, as an error.
    ///
    /// # Errors
    /// [`ViewError::Device`] once the device was lost or refused a command.
    pub fn check(&self) -> Result<(), ViewError> {
        match self.made.synthesis.lost() {
            Some(message) => Err(ViewError::Device(message.to_owned())),
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

fn is_card(adapter: &wgpu::Adapter) -> bool {
    adapter.get_info().device_type != wgpu::DeviceType::Cpu
}
