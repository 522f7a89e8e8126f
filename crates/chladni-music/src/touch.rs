//! The controls of a controller, such as knobs and keys.

use serde::{Deserialize, Serialize};

/// Something on a controller that can be touched.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind", deny_unknown_fields)]
pub enum Control {
    /// A MIDI controller (knob, fader), channel 0 to 15, number 0 to 127.
    Controller {
        /// Channel.
        channel: u8,
        /// Number.
        number: u8,
    },
    /// A MIDI note (pad, key).
    Note {
        /// Channel.
        channel: u8,
        /// Number.
        number: u8,
    },
    /// A MIDI pitch wheel.
    PitchBend {
        /// Channel.
        channel: u8,
    },
    /// An OSC address.
    Osc {
        /// Such as `/1/fader3`.
        address: String,
    },
}

impl std::fmt::Display for Control {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Controller { channel, number } => write!(f, "CC {number} ch {}", channel + 1),
            Self::Note { channel, number } => write!(f, "note {number} ch {}", channel + 1),
            Self::PitchBend { channel } => write!(f, "pitch bend ch {}", channel + 1),
            Self::Osc { address } => f.write_str(address),
        }
    }
}

impl Control {
    /// The message that shows `share` in [0, 1] on the device; OSC has none.
    pub(crate) fn message(&self, share: f32) -> Option<[u8; 3]> {
        let share = share.clamp(0.0, 1.0);
        let seven = (127.0 * share).round() as u8;
        match *self {
            Self::Controller { channel, number } => Some([0xb0 | channel & 0x0f, number & 0x7f, seven]),
            Self::Note { channel, number } => Some([0x90 | channel & 0x0f, number & 0x7f, seven]),
            Self::PitchBend { channel } => {
                let wheel = (16_383.0 * share).round() as u16;
                Some([0xe0 | channel & 0x0f, (wheel & 0x7f) as u8, (wheel >> 7) as u8])
            }
            Self::Osc { .. } => None,
        }
    }
}

/// A control was moved to `value` in [0, 1]; pads and buttons give 0 when they are released.
#[derive(Clone, Debug, PartialEq)]
pub struct Touch {
    /// On which device, by its name; empty over OSC.
    pub device: String,
    /// Which.
    pub control: Control,
    /// Where it stands now.
    pub value: f32,
}

impl Touch {
    /// Reads one MIDI message of `device`: controllers, notes and pitch bend. Anything else, and messages that are cut
    /// short or out of range, is `None`.
    pub fn from_midi(device: &str, bytes: &[u8]) -> Option<Self> {
        let &[status, number, value, ..] = bytes else { return None };
        if number > 127 || value > 127 {
            return None;
        }
        let (channel, share) = (status & 0x0f, f32::from(value) / 127.0);
        let (control, value) = match status & 0xf0 {
            0x80 => (Control::Note { channel, number }, 0.0),
            0x90 => (Control::Note { channel, number }, share),
            0xb0 => (Control::Controller { channel, number }, share),
            0xe0 => {
                let wheel = u16::from(number) | u16::from(value) << 7;
                (Control::PitchBend { channel }, f32::from(wheel) / 16_383.0)
            }
            _ => return None,
        };
        Some(Self { device: device.to_owned(), control, value })
    }
}
