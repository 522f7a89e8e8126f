//! How a player starts.

/// How a player starts.
#[derive(Clone, Debug, PartialEq)]
pub struct PlayerSettings {
    /// The id of a device; `None` for the system's default.
    pub device: Option<String>,
    /// Amplitude, in [0, 1].
    pub volume: f32,
    /// If false, no device is opened, and time passes in silence (for tests and machines without sound).
    pub audible: bool,
}

impl Default for PlayerSettings {
    fn default() -> Self {
        Self { device: None, volume: 1.0, audible: true }
    }
}
