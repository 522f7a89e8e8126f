//! The input of a synthesizer: items, each a sum of terms of the one formula.

use std::sync::Arc;

/// One deformed copy of the body: the rest shape plus the sum of its terms.
///
/// No term leaves the body at rest. Most items have one; half-masks and caricature layers
/// as voices have several.
#[derive(Clone, Debug, Default)]
pub struct Item {
    /// The terms whose displacements are added.
    pub terms: Vec<Term>,
}

/// χ(v) · ( Σ_k H_k(v) C_k + r(v) · g ), in vector form, or times the rest normal n(v), in
/// normal form (docs/synthesis.md). Working frame.
#[derive(Clone, Debug)]
pub struct Term {
    /// C_k or c_k for k < len ≤ K; missing ones are zero.
    pub coefficients: Coefficients,
    /// r: the part of the signal above K. Shared, never copied per frame.
    pub residual: Option<Residual>,
    /// g, the gain of the residual.
    pub residual_gain: f32,
    /// χ, N values; `None` is 1 everywhere. A backend uploads it once per `Arc`.
    pub mask: Option<Arc<[f32]>>,
}

/// The weights of the harmonics, in the form that decides how they displace.
#[derive(Clone, Debug)]
pub enum Coefficients {
    /// C_k: a displacement per harmonic, K×3.
    Vector(Vec<[f32; 3]>),
    /// c_k: an amplitude along the rest normal, K.
    Normal(Vec<f32>),
}

/// A signal on the N operator vertices, of the same form as the coefficients beside it.
#[derive(Clone, Debug)]
pub enum Residual {
    /// dx or dx^δ, N×3.
    Vector(Arc<[[f32; 3]]>),
    /// dξ, N.
    Normal(Arc<[f32]>),
}
