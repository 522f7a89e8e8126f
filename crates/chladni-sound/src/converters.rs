//! ALSA's plugins that convert or discard samples: they are listed among the devices but offer nothing beyond what they
//! convert for.

use cpal::traits::DeviceTrait;

/// Whether it is one of these, or the default under another name.
pub fn is_converter(device: &cpal::Device) -> bool {
    const CONVERTERS: [&str; 11] = [
        "null",
        "lavrate",
        "samplerate",
        "speexrate",
        "jack",
        "oss",
        "speex",
        "upmix",
        "vdownmix",
        "usbstream",
        "default",
    ];
    let id = device.id().map_or_else(|_| String::new(), |id| id.to_string());
    let name = id.strip_prefix("alsa:").map(|id| id.split(':').next().unwrap_or(id));
    name.is_some_and(|name| CONVERTERS.contains(&name))
}
