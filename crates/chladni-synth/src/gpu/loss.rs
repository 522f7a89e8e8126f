//! Detects the loss of a device.

use std::sync::{Arc, OnceLock};

/// Whether a device was lost, and why. A device has only one callback for this: the code that opens the
/// device registers it once, with [`watch`](Self::watch), and passes on clones.
#[derive(Clone, Debug, Default)]
pub struct DeviceLoss(Arc<OnceLock<String>>);

impl DeviceLoss {
    /// Sets the lost-callback of the device, replacing any earlier one.
    pub fn watch(device: &wgpu::Device) -> Self {
        let loss = Self::default();
        let word = Arc::clone(&loss.0);
        device.set_device_lost_callback(move |reason, message| {
            let why = if message.is_empty() { format!("{reason:?}").to_lowercase() } else { message };
            // Only the first report counts.
            let _ = word.set(why);
        });
        loss
    }

    /// Why the device was lost; `None` while it works. The reason is known once the driver reports it.
    pub fn reason(&self) -> Option<&str> {
        self.0.get().map(String::as_str)
    }
}
