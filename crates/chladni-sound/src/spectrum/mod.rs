//! The spectrum at one moment: amplitudes of the bands of mid and side.

mod analyser;
mod bands;
mod level;
mod song;

pub use analyser::{Spectrum, SpectrumAnalyser, SpectrumSettings};
pub use bands::FrontEnd;
pub use level::Level;
pub use song::{Hop, SongSpectrum};
