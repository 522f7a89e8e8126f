//! Detects that a device is lost, or of no use.

use std::sync::{Arc, OnceLock};

use super::checked::why;

/// Whether a device was lost or refused a command, and why. A device has only one callback for either: the code that opens
/// the device registers them once, with [`watch`](Self::watch), and passes on clones.
#[derive(Clone, Debug, Default)]
pub struct DeviceLoss(Arc<OnceLock<String>>);

impl DeviceLoss {
    /// Sets the callbacks of the device for its loss and for errors that nobody else asks for, replacing any earlier ones.
    /// Without them such an error, as of a card whose memory is full, is a panic.
    pub fn watch(device: &wgpu::Device) -> Self {
        let loss = Self::default();
        // Only the first report counts.
        let word = Arc::clone(&loss.0);
        device.set_device_lost_callback(move |reason, message| {
            let why = if message.is_empty() { format!("{reason:?}").to_lowercase() } else { message };
            let _ = word.set(why);
        });
        let word = Arc::clone(&loss.0);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let _ = word.set(why(&error));
        }));
        loss
    }

    /// Why the device is of no use; `None` while it works. A loss is known once the driver reports it.
    pub fn reason(&self) -> Option<&str> {
        self.0.get().map(String::as_str)
    }
}
