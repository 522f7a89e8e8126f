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
