//! Turns device errors into `Result`s.

use crate::SynthError;

/// Runs `make`. Returns the errors with which the device would otherwise panic.
pub(super) fn checked<T>(device: &wgpu::Device, make: impl FnOnce() -> T) -> Result<T, SynthError> {
    let memory = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let validation = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let made = make();
    let errors = [pollster::block_on(validation.pop()), pollster::block_on(memory.pop())];
    match errors.into_iter().flatten().next() {
        Some(error) => Err(SynthError::Device(error.to_string())),
        None => Ok(made),
    }
}
