//! The spectrum at one moment: amplitudes of the bands of mid and side.

mod analyzer;
mod bands;
mod level;
mod song;

pub use analyzer::{Spectrum, SpectrumAnalyzer, SpectrumSettings};
pub use bands::FrontEnd;
pub use level::Level;
pub use song::{Hop, SongSpectrum};
