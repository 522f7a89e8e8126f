//! The input of a synthesizer: items, each of which is a sum of terms.

use std::sync::Arc;

/// One deformed copy of the body: the rest shape plus the sum of its terms.
///
/// An item without terms is the body at rest. Most items have one term; half-masks, and caricature layers
/// as voices, have several.
#[derive(Clone, Debug, Default)]
pub struct Item {
    /// The terms whose displacements are added.
    pub terms: Vec<Term>,
}

/// χ(v) · ( Σ_k H_k(v) C_k + r(v) · g ), either in vector form, or in normal form: times the rest normal
/// n(v) (docs/synthesis.md). In the working frame.
#[derive(Clone, Debug)]
pub struct Term {
    /// C_k or c_k for k < len ≤ K; missing ones are zero.
    pub coefficients: Coefficients,
    /// r: the part of the signal above K. It is shared and never copied per frame.
    pub residual: Option<Residual>,
    /// g, the gain of the residual.
    pub residual_gain: f32,
    /// χ, N values; `None` is 1 everywhere. A backend uploads it once per `Arc`.
    pub mask: Option<Arc<[f32]>>,
}

/// The weights of the harmonics, in one of the two forms of a term.
#[derive(Clone, Debug)]
pub enum Coefficients {
    /// C_k: a displacement per harmonic, K×3.
    Vector(Vec<[f32; 3]>),
    /// c_k: an amplitude along the rest normal, K.
    Normal(Vec<f32>),
}

/// A signal on the N operator vertices, in the same form as the coefficients of its term.
#[derive(Clone, Debug)]
pub enum Residual {
    /// dx or dx^δ, N×3.
    Vector(Arc<[[f32; 3]]>),
    /// dξ, N.
    Normal(Arc<[f32]>),
}
