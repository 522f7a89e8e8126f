//! Synthesis on the graphics device, and where its frames lie.

mod frame;

pub use frame::{DeviceFrame, DeviceFrameBuffers};
