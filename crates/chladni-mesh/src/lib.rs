//! Triangle meshes as files hold them.

mod adjacency;
mod appearance;
mod error;
mod format;
mod frame;
mod geometry;
mod health;
mod mesh;
mod read;
pub mod samples;
mod weld;
mod write;

pub use adjacency::{Rows, triangle_neighbors, vertex_neighbors, vertex_triangles};
pub use appearance::{Appearance, CornerUvs, Material, Texture};
pub use error::{MeshError, Place};
pub use format::Format;
pub use frame::Frame;
pub use geometry::{total_area, vertex_normals};
pub use health::{HealthReport, Topology, Welded};
pub use mesh::TriMesh;
pub use read::{Loaded, Mended, load_mesh, read_mesh};
pub use weld::{Weld, weld};
pub use write::{MorphTarget, save_mesh, write_glb, write_mesh};
