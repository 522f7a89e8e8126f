//! The device that draws: a graphics device, or this machine's processor.

use std::str::FromStr;

use crate::{Gpu, Samples, ViewError};

/// The choice of the device that draws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Draw {
    /// A graphics card where there is one, else the processor.
    #[default]
    Auto,
    /// The processor; no graphics driver is asked.
    Cpu,
    /// A graphics device, even if it is a processor in disguise.
    Gpu,
}

impl Draw {
    const ALL: [Self; 3] = [Self::Auto, Self::Cpu, Self::Gpu];

    /// Its name, from which it is read.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Cpu => "cpu",
            Self::Gpu => "gpu",
        }
    }

    /// Whether a graphics device would draw. None is opened.
    pub fn means_graphics(self) -> bool {
        match self {
            Self::Auto => Gpu::has_card(),
            Self::Cpu => false,
            Self::Gpu => true,
        }
    }
}

impl FromStr for Draw {
    type Err = ViewError;

    fn from_str(text: &str) -> Result<Self, ViewError> {
        let named = Self::ALL.into_iter().find(|draw| draw.name() == text);
        named.ok_or(ViewError::Expected("auto, cpu or gpu"))
    }
}

/// The device that draws. All parts of a figure are made for one device and drawn by it.
#[derive(Clone, Debug)]
pub enum Device {
    /// The processor, on the threads of the rayon pool that it is called from.
    Processor,
    /// A graphics device.
    Graphics(Gpu),
}

impl Device {
    /// Longest side of a picture or an image that the processor draws, pixels.
    const LONGEST_SIDE: u32 = 16_384;

    /// The device that `draw` asks for. `Auto` takes the processor where there is no adapter, or where the only one
    /// is software, which draws the same picture several times slower.
    ///
    /// # Errors
    /// Those of [`Gpu::headless`] where a graphics device is asked for, and [`ViewError::NoDevice`] where
    /// there is a card that refuses.
    pub fn open(draw: Draw) -> Result<Self, ViewError> {
        match draw {
            Draw::Cpu => Ok(Self::Processor),
            Draw::Gpu => Gpu::headless().map(Self::Graphics),
            Draw::Auto => Ok(Gpu::card()?.map_or(Self::Processor, Self::Graphics)),
        }
    }

    /// The graphics device, if one draws.
    pub fn gpu(&self) -> Option<&Gpu> {
        match self {
            Self::Processor => None,
            Self::Graphics(gpu) => Some(gpu),
        }
    }

    /// Name and kind, for reports: `llvmpipe (…), Cpu, Vulkan`, or `processor (AVX-512)`.
    pub fn description(&self) -> String {
        match self {
            Self::Processor => format!("processor ({})", crate::cpu::Instructions::fastest()),
            Self::Graphics(gpu) => gpu.description(),
        }
    }

    /// Whether drawing runs on the processor, as itself or as a software adapter.
    pub fn is_software(&self) -> bool {
        self.gpu().is_none_or(Gpu::is_software)
    }

    /// Samples a pixel for moving pictures: see [`Gpu::live_samples`]; the processor always takes four.
    pub fn live_samples(&self) -> Samples {
        self.gpu().map_or(Samples::Four, Gpu::live_samples)
    }

    /// Longest side of a picture, pixels.
    pub fn longest_side(&self) -> u32 {
        self.gpu().map_or(Self::LONGEST_SIDE, Gpu::longest_side)
    }
}

impl From<&Gpu> for Device {
    fn from(gpu: &Gpu) -> Self {
        Self::Graphics(gpu.clone())
    }
}

impl From<&Self> for Device {
    fn from(device: &Self) -> Self {
        device.clone()
    }
}
