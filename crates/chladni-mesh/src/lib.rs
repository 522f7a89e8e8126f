//! Triangle meshes as files hold them.

mod adjacency;
mod frame;
mod geometry;
mod mesh;
mod weld;

pub use adjacency::{Rows, triangle_neighbors, vertex_neighbors, vertex_triangles};
pub use frame::Frame;
pub use geometry::{total_area, vertex_normals};
pub use mesh::{Appearance, TriMesh};
pub use weld::{Weld, weld};
