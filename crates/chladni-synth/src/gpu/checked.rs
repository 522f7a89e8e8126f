//! Device errors as `Result`s instead of panics.

use crate::SynthError;

/// Runs `make` and returns the errors that the device would otherwise panic with.
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
