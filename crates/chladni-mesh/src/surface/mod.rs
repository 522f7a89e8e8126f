//! The geometry of triangles over shared vertices.
//!
//! Positions are `[f64; 3]` in any unit, triangles are corners < the number of positions. Where a triangle names
//! a vertex that is not there, these functions panic; readers never return such a mesh.

mod adjacency;
mod curvature;
#[cfg(feature = "simplify")]
mod detail;
mod flat;
mod normals;
mod point;
mod small_system;
mod spread;
mod stars;
mod subdivided;
mod tree;
mod triangulation;
pub mod vec3;
mod walk;
mod weld;
mod winding;
mod zero_lines;

pub(crate) use adjacency::{HalfEdge, Pieces, sorted_half_edges, vertex_faces};
pub use adjacency::{Rows, boundary_vertices, components, vertex_neighbors, vertex_triangles};
pub use curvature::{
    Principal, Tensor, averaged, averaged_curvature, averaging_passes, curvature_tensors, times,
    vertex_areas, vertex_gradients,
};
#[cfg(feature = "simplify")]
pub use detail::{Detail, details};
pub(crate) use flat::has_flat_triangle;
pub use flat::{flat_components, is_collapsed, leave_out_flat};
pub use normals::{
    STAND_IN_NORMAL, corners, doubled_area_normal, total_area, vertex_normals, vertex_normals_around,
};
pub use point::{SurfacePoint, closest_on_triangle, mixed};
pub use small_system::solve_small;
pub use spread::spread;
pub use stars::delaunay_stars;
pub use subdivided::subdivided;
pub use tree::{Bounds, BoxTree, Closest, TriangleTree};
pub(crate) use triangulation::{MOST_CORNERS, Triangulation, triangulation};
pub use walk::Ground;
pub use weld::{Weld, drawn_triangles, places, repeated_triangles, weld};
pub(crate) use weld::{of_triangles, repeated_faces, repeated_known, seamless_triangles, weld_known};
pub use winding::{facing_outward, inward_triangles};
pub use zero_lines::{EdgePoint, chained, zero_lines};
