//! In place of Syphon, which is for macOS and the feature `syphon`.

/// Whether this program can be a server of Syphon.
pub const HAS_SYPHON: bool = false;

/// There is none.
pub(super) enum Server {}

impl Server {
    pub(super) fn open(_width: u32, _height: u32) -> Result<Self, String> {
        Err("Syphon is for macOS, in a program that is built with the feature syphon".into())
    }

    pub(super) fn send(&mut self, _rgba: &[u8]) -> Result<(), String> {
        match *self {}
    }
}
