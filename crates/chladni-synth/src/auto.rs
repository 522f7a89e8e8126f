//! A synthesizer that chooses its backend and falls back to the CPU when the device fails.

use crate::{
    CpuSynthesizer, DeviceFrame, DeviceFrameBuffers, FrameSettings, GpuContext, GpuSynthesizer, Item,
    SynthError, SynthModel, Synthesizer,
};

/// The backend that a user asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Backend {
    /// The GPU if there is a hardware one, otherwise the CPU.
    #[default]
    Auto,
    /// The CPU.
    Cpu,
    /// The GPU, even if it is a software device.
    Gpu,
}

/// Reports that the CPU has taken over, and why. Show it to the user once.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("synthesizing on the CPU: {reason}")]
pub struct Fallback {
    /// Why the GPU cannot be used.
    pub reason: SynthError,
}

/// A synthesizer for drawing: its frames are on the device, whichever backend computed them.
///
/// If the device is out of memory or fails, the CPU computes the same frame again and all further ones;
/// [`AutoSynthesizer::take_fallback`] reports this once. A lost device cannot draw anything; frames are
/// then only in [`AutoSynthesizer::cpu`].
#[derive(Debug)]
pub struct AutoSynthesizer {
    context: GpuContext,
    engine: Engine,
    fallback: Option<Fallback>,
}

#[derive(Debug)]
enum Engine {
    Cpu { synthesizer: Box<CpuSynthesizer>, frame: DeviceFrameBuffers },
    Gpu(Box<GpuSynthesizer>),
}

impl AutoSynthesizer {
    /// Chooses a backend for `model`. If that is the GPU and it cannot hold the model, the CPU is used, and
    /// there is a [`Fallback`] to take.
    pub fn new(context: &GpuContext, model: SynthModel, backend: Backend) -> Self {
        let gpu = match backend {
            Backend::Auto => !context.is_software(),
            Backend::Cpu => false,
            Backend::Gpu => true,
        };
        let mut fallback = None;
        let mut engine = None;
        if gpu {
            match GpuSynthesizer::new(context, model.clone()) {
                Ok(synthesizer) => engine = Some(Engine::Gpu(Box::new(synthesizer))),
                Err(reason) => fallback = Some(Fallback { reason }),
            }
        }
        let engine = engine.unwrap_or_else(|| Engine::cpu(context, model));
        Self { context: context.clone(), engine, fallback }
    }

    /// The last frame on the device.
    pub fn frame(&self) -> DeviceFrame<'_> {
        match &self.engine {
            Engine::Cpu { frame, .. } => frame.frame(),
            Engine::Gpu(synthesizer) => synthesizer.frame(),
        }
    }

    /// The CPU backend, if it is in use.
    pub fn cpu(&self) -> Option<&CpuSynthesizer> {
        match &self.engine {
            Engine::Cpu { synthesizer, .. } => Some(synthesizer),
            Engine::Gpu(_) => None,
        }
    }

    /// The name of the device that computes: for example "AVX-512", or the name of the GPU.
    pub fn device_name(&self) -> String {
        match &self.engine {
            Engine::Cpu { synthesizer, .. } => synthesizer.path().to_string(),
            Engine::Gpu(synthesizer) => synthesizer.context().device_name(),
        }
    }

    /// Why the CPU has taken over; `Some` only once per event.
    pub fn take_fallback(&mut self) -> Option<Fallback> {
        self.fallback.take()
    }

    /// Continues on the CPU with `model`.
    fn fall_back(&mut self, reason: SynthError, model: SynthModel) {
        self.fallback = Some(Fallback { reason });
        self.engine = Engine::cpu(&self.context, model);
    }

    /// Copies a frame of the CPU to the device, unless it is lost.
    fn show(&mut self) -> Result<(), SynthError> {
        match &mut self.engine {
            Engine::Cpu { synthesizer, frame } if self.context.lost().is_none() => {
                synthesizer.upload(&self.context.queue, frame)
            }
            _ => Ok(()),
        }
    }
}

impl Engine {
    fn cpu(context: &GpuContext, model: SynthModel) -> Self {
        let frame = DeviceFrameBuffers::new(&context.device);
        Self::Cpu { synthesizer: Box::new(CpuSynthesizer::new(model)), frame }
    }

    fn synthesizer(&mut self) -> &mut dyn Synthesizer {
        match self {
            Self::Cpu { synthesizer, .. } => &mut **synthesizer,
            Self::Gpu(synthesizer) => &mut **synthesizer,
        }
    }
}

impl Synthesizer for AutoSynthesizer {
    fn model(&self) -> &SynthModel {
        match &self.engine {
            Engine::Cpu { synthesizer, .. } => synthesizer.model(),
            Engine::Gpu(synthesizer) => synthesizer.model(),
        }
    }

    fn replace_model(&mut self, model: SynthModel) -> Result<(), SynthError> {
        match self.engine.synthesizer().replace_model(model.clone()) {
            Err(reason) if reason.is_of_device() => self.fall_back(reason, model),
            done => done?,
        }
        Ok(())
    }

    fn items(&self) -> usize {
        match &self.engine {
            Engine::Cpu { synthesizer, .. } => synthesizer.items(),
            Engine::Gpu(synthesizer) => synthesizer.items(),
        }
    }

    fn synthesize_positions(&mut self, items: &[Item]) -> Result<(), SynthError> {
        match self.engine.synthesizer().synthesize_positions(items) {
            Err(reason) if reason.is_of_device() => {
                let model = self.model().clone();
                self.fall_back(reason, model);
                self.engine.synthesizer().synthesize_positions(items)
            }
            done => done,
        }
    }

    /// Falls back only between frames: if the device fails here, the positions are lost with it, and the
    /// call returns an error.
    fn synthesize_normals(&mut self, settings: &FrameSettings) -> Result<(), SynthError> {
        self.engine.synthesizer().synthesize_normals(settings)?;
        self.show()
    }

    fn synthesize(&mut self, items: &[Item], settings: &FrameSettings) -> Result<(), SynthError> {
        settings.check()?;
        self.synthesize_positions(items)?;
        match self.synthesize_normals(settings) {
            Err(reason) if reason.is_of_device() && self.cpu().is_none() => {
                let model = self.model().clone();
                self.fall_back(reason, model);
                self.synthesize_positions(items)?;
                self.synthesize_normals(settings)
            }
            done => done,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::full_memory::leave;
    use crate::{Coefficients, DeviceLoss, Term};

    const HARMONICS: usize = 30;

    /// A device of this test's own, whose memory is not full yet; `None` where there is none.
    fn context() -> Option<GpuContext> {
        if cfg!(miri) {
            // Miri cannot call drivers.
            return None;
        }
        leave(u64::MAX);
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()));
        let Ok(adapter) = adapter else {
            println!("skipped: no graphics device here");
            return None;
        };
        let opened = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor::default()));
        let (device, queue) = opened.unwrap();
        Some(GpuContext::new(&device, &queue, &DeviceLoss::watch(&device)))
    }

    /// 642 vertices: an item takes 7,704 bytes for positions, and as many for normals.
    fn model() -> SynthModel {
        let ball = chladni_mesh::samples::icosphere(3);
        let basis: Vec<f64> =
            (0..ball.positions.len() * HARMONICS).map(|i| (0.37 * i as f64).sin()).collect();
        SynthModel::from_parts(&ball.positions, &ball.triangles, &basis).unwrap()
    }

    fn items(count: u8) -> Vec<Item> {
        let term = |i: u8| Term {
            coefficients: Coefficients::Vector(vec![[0.01 * f32::from(i), 0.02, -0.01]; HARMONICS]),
            residual: None,
            residual_gain: 0.0,
            mask: None,
        };
        (0..count).map(|i| Item { terms: vec![term(i)] }).collect()
    }

    /// Makes a frame of `items`, which must be the one that the CPU makes.
    fn synthesizes_on_the_cpu(auto: &mut AutoSynthesizer, items: &[Item]) {
        let settings = FrameSettings::default();
        auto.synthesize(items, &settings).unwrap();
        let mut alone = CpuSynthesizer::new(model());
        alone.synthesize(items, &settings).unwrap();
        let cpu = auto.cpu().expect("the CPU took over");
        assert_eq!(cpu.all_positions(), alone.all_positions());
        assert_eq!(cpu.all_normals(), alone.all_normals());
    }

    const FULL: &str = "synthesizing on the CPU: the graphics device cannot be used: its memory is full";

    #[test]
    fn a_shape_that_finds_no_room_on_the_device_is_deformed_by_the_cpu() {
        let Some(context) = context() else { return };
        leave(1 << 10);
        let mut auto = AutoSynthesizer::new(&context, model(), Backend::Gpu);
        assert_eq!(auto.take_fallback().expect("it says so").to_string(), FULL);
        // There is room for its frames again, and the device draws them.
        leave(u64::MAX);
        synthesizes_on_the_cpu(&mut auto, &items(9));
        assert_eq!((auto.frame().items, auto.frame().vertices), (9, 642));
        assert_eq!((context.lost(), auto.take_fallback()), (None, None));
    }

    #[test]
    fn another_shape_that_finds_no_room_is_deformed_by_the_cpu() {
        let Some(context) = context() else { return };
        let mut auto = AutoSynthesizer::new(&context, model(), Backend::Gpu);
        auto.synthesize(&items(2), &FrameSettings::default()).unwrap();
        assert!(auto.cpu().is_none());
        leave(1 << 10);
        auto.replace_model(model()).unwrap();
        assert_eq!(auto.take_fallback().expect("it says so").to_string(), FULL);
        leave(u64::MAX);
        synthesizes_on_the_cpu(&mut auto, &items(2));
        assert_eq!(context.lost(), None);
    }

    #[test]
    fn a_frame_that_outgrows_the_memory_is_made_by_the_cpu_and_the_window_hears_of_it() {
        let Some(context) = context() else { return };
        let mut auto = AutoSynthesizer::new(&context, model(), Backend::Gpu);
        auto.synthesize(&items(1), &FrameSettings::default()).unwrap();
        assert!(auto.cpu().is_none() && auto.take_fallback().is_none());
        leave(1 << 14);
        synthesizes_on_the_cpu(&mut auto, &items(9));
        assert_eq!(auto.take_fallback().expect("it says so").to_string(), FULL);
        // Nor is there room to draw it: the window opens again elsewhere.
        assert_eq!(context.lost(), Some("its memory is full"));
        synthesizes_on_the_cpu(&mut auto, &items(3));
        assert_eq!(auto.take_fallback(), None, "reported once");
    }
}
