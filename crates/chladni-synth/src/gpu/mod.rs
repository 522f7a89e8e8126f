//! Synthesis on the graphics device, and the buffers of its frames.

mod buffer;
mod checked;
mod context;
mod frame;
#[cfg(test)]
pub(crate) mod full_memory;
mod loss;
mod pipelines;
mod product;
mod shape;
mod signals;
mod synthesizer;

pub use context::GpuContext;
pub use frame::{DeviceFrame, DeviceFrameBuffers};
pub use loss::DeviceLoss;
pub use product::Tiles;
pub use synthesizer::GpuSynthesizer;
