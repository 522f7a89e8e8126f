//! The natural vibrations of a mesh.

mod basis;
mod body;

pub use basis::{Basis, Certificate};
pub use body::Body;
