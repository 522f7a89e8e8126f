//! Coefficients of harmonics in, deformed positions and exact normals out.

mod item;

pub use item::{Coefficients, Item, Residual, Term};
