//! Harmonic exaggeration.

mod difference;
mod error;
mod exaggeration;
mod region;
mod runs;
mod scale_curve;
mod surface;
mod transform;
mod vector;

pub use difference::{Base, Difference, Model, Psi, Target};
pub use error::Error;
pub use exaggeration::{Field, Signals};
pub use region::{Painted, Region, RollOff, Smoothing, Sphere};
pub use scale_curve::{ScaleCurve, normalised_frequency};
pub use surface::Surface;

#[cfg(test)]
mod fixture;
