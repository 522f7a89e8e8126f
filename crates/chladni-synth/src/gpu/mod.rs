//! Synthesis on the graphics device, and where its frames lie.

mod buffer;
mod context;
mod frame;
mod shape;
mod signals;
mod synthesizer;

pub use context::GpuContext;
pub use frame::{DeviceFrame, DeviceFrameBuffers};
pub use synthesizer::GpuSynthesizer;
