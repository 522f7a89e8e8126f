//! Shapes of our own.

mod surfaces;

pub use surfaces::{grid_square, icosphere, moebius, torus, uv_sphere};
