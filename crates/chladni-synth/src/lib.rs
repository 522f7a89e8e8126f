//! Computes deformed positions and exact normals from coefficients of harmonics.
//!
//! Every deformation in Chladni has the same formula, x'(v) = x(v) + Σ_terms χ(v) ( Σ_k H_k(v) C_k + r(v) g
//! ) [· n(v)]. This crate evaluates it for all items of a frame in one pass over the basis H.
//!
//! ```
//! use chladni_synth::{Coefficients, CpuSynthesizer, FrameSettings, Item, SynthModel, Synthesizer, Term};
//!
//! // A triangle with two harmonics; real ones come from `SynthModel::new(&body)`.
//! let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
//! let basis = [1.0, 1.0, 1.0, /* H_1 */ -1.0, 0.5, 0.5];
//! let model = SynthModel::from_parts(&positions, &[[0, 1, 2]], &basis)?;
//!
//! let lift = Term {
//!     coefficients: Coefficients::Normal(vec![0.0, 0.2]),
//!     residual: None,
//!     residual_gain: 0.0,
//!     mask: None,
//! };
//! let mut synthesizer = CpuSynthesizer::new(model);
//! synthesizer.synthesize(&[Item::default(), Item { terms: vec![lift] }], &FrameSettings::default())?;
//! assert_eq!(synthesizer.positions(0)[1], [1.0, 0.0, 0.0]);
//! assert!((synthesizer.positions(1)[1][2] - 0.1).abs() < 1e-5);
//! # Ok::<(), chladni_synth::SynthError>(())
//! ```
//!
//! Not guaranteed: bitwise equality of two backends. For pictures they use a basis of 16-bit integers and
//! sums in f32, and agree to rounding; docs/synthesis.md states the bound. [`displacements_f64`], for
//! exports, has neither limitation.

#![warn(clippy::missing_errors_doc)]

#[cfg(feature = "gpu")]
mod auto;
mod cpu;
mod error;
mod exact;
#[cfg(feature = "gpu")]
mod gpu;
mod item;
mod model;
mod morph;
mod normals;
mod packed_basis;
mod plan;
mod synthesizer;

#[cfg(feature = "gpu")]
pub use auto::{AutoSynthesizer, Backend, Fallback};
pub use cpu::{CpuPath, CpuSynthesizer};
pub use error::SynthError;
#[cfg(feature = "gpu")]
pub use gpu::{DeviceFrame, DeviceFrameBuffers, DeviceLoss, GpuContext, GpuSynthesizer, Tiles};
pub use item::{Coefficients, Item, Residual, Term};
pub use model::{SynthModel, displacements_f64};
pub use morph::{Morph, Morphs, Movement};
pub use normals::area_weighted_normals;
pub use synthesizer::{FrameSettings, Synthesizer};

/// The examples of README.md, compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
