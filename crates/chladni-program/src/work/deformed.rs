//! Deforms the shapes of a window or a film, on the processor or on the drawing device.

use std::time::Instant;

use chladni_synth::{
    AutoSynthesizer, Backend, CpuSynthesizer, Fallback, FrameSettings, Item, SynthModel, Synthesizer,
};
use chladni_view::{Device, ItemBuffers, Topology, ViewError};

use super::Error;

/// The shapes of a frame, and who deforms them.
pub struct Deformed {
    by: Deformer,
    /// The triangles that all of them share.
    pub topology: Topology,
}

enum Deformer {
    /// Beside a graphics device, which gets the frames.
    Beside(Box<AutoSynthesizer>),
    /// Where the processor draws, too.
    Processor { synthesizer: Box<CpuSynthesizer>, buffers: ItemBuffers },
}

impl Deformed {
    /// The shapes of `model` for `device`, deformed by `synthesis` where a graphics device draws, else by the
    /// processor, with their triangles there.
    pub fn new(device: &Device, model: &SynthModel, topology: Topology, synthesis: Backend) -> Self {
        let by = match device {
            Device::Graphics(gpu) => {
                Deformer::Beside(Box::new(AutoSynthesizer::new(gpu.synthesis(), model.clone(), synthesis)))
            }
            Device::Processor => Deformer::Processor {
                synthesizer: Box::new(CpuSynthesizer::new(model.clone())),
                buffers: ItemBuffers::new(device, model.vertices(), 0),
            },
        };
        Self { by, topology }
    }

    /// The same shapes on another device, not deformed yet.
    pub fn on(&self, device: &Device, topology: Topology, synthesis: Backend) -> Self {
        let model = match &self.by {
            Deformer::Beside(synthesizer) => synthesizer.model(),
            Deformer::Processor { synthesizer, .. } => synthesizer.model(),
        };
        Self::new(device, model, topology, synthesis)
    }

    /// Makes the frame of `items` and says how long positions and normals took, in seconds.
    ///
    /// # Errors
    /// Items that do not fit the model, and a device that fails while no processor can take over.
    pub fn synthesize(&mut self, items: &[Item], settings: &FrameSettings) -> Result<[f64; 2], Error> {
        let synthesizer: &mut dyn Synthesizer = match &mut self.by {
            Deformer::Beside(synthesizer) => &mut **synthesizer,
            Deformer::Processor { synthesizer, .. } => &mut **synthesizer,
        };
        let began = Instant::now();
        synthesizer.synthesize_positions(items)?;
        let positioned = Instant::now();
        synthesizer.synthesize_normals(settings)?;
        let took_secs = [positioned - began, positioned.elapsed()].map(|time| time.as_secs_f64());
        if let Deformer::Processor { synthesizer, buffers } = &mut self.by {
            buffers.take_frame(Device::Processor, synthesizer)?;
        }
        Ok(took_secs)
    }

    /// The last frame, where it is drawn.
    ///
    /// # Errors
    /// Where the graphics device was lost with the frame that is asked for.
    pub fn buffers(&self) -> Result<ItemBuffers, ViewError> {
        match &self.by {
            Deformer::Beside(synthesizer) => ItemBuffers::of_frame(&synthesizer.frame()),
            Deformer::Processor { buffers, .. } => Ok(buffers.clone()),
        }
    }

    /// The report that the processor has taken over: `Some` once after it has.
    pub fn take_fallback(&mut self) -> Option<Fallback> {
        match &mut self.by {
            Deformer::Beside(synthesizer) => synthesizer.take_fallback(),
            Deformer::Processor { .. } => None,
        }
    }

    /// The processor's instructions, or the device's name.
    pub fn device_name(&self) -> String {
        match &self.by {
            Deformer::Beside(synthesizer) => synthesizer.device_name(),
            Deformer::Processor { synthesizer, .. } => synthesizer.path().to_string(),
        }
    }

    /// The farthest any vertex of the first item went; `None` where the positions are on the device.
    pub fn largest_displacement(&self) -> Option<f32> {
        let cpu = match &self.by {
            Deformer::Beside(synthesizer) => synthesizer.cpu()?,
            Deformer::Processor { synthesizer, .. } => synthesizer,
        };
        let squared = |a: &[f32; 3], b: &[f32; 3]| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f32>();
        let pairs = cpu.positions(0).iter().zip(cpu.model().rest_positions());
        Some(pairs.map(|(a, b)| squared(a, b)).fold(0.0, f32::max).sqrt())
    }
}
