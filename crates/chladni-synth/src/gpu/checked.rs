//! Turns device errors into `Result`s.

use crate::SynthError;

/// Runs `make`. Returns the errors with which the device would otherwise panic.
pub(super) fn checked<T>(device: &wgpu::Device, make: impl FnOnce() -> T) -> Result<T, SynthError> {
    let memory = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let validation = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let made = make();
    let validation = pollster::block_on(validation.pop());
    // A buffer without memory is not valid either: the cause comes first.
    match pollster::block_on(memory.pop()).or(validation) {
        Some(error) => Err(SynthError::Device(why(&error))),
        None => Ok(made),
    }
}

/// An error of the device in words.
pub(super) fn why(error: &wgpu::Error) -> String {
    match error {
        wgpu::Error::OutOfMemory { .. } => "its memory is full".to_owned(),
        other => other.to_string(),
    }
}
