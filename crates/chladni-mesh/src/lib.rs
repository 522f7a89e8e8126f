//! Triangle meshes as files hold them.

mod frame;
mod mesh;

pub use frame::Frame;
pub use mesh::{Appearance, TriMesh};
