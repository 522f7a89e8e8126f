//! Correspondences between a shape and a template.
//!
//! ```
//! use chladni_match::{Ellipsoid, onto_ellipsoid};
//! use chladni_mesh::TriMesh;
//!
//! let tetrahedron = TriMesh {
//!     positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
//!     triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
//!     ..TriMesh::default()
//! };
//! let ellipsoid = Ellipsoid::fitted(&tetrahedron)?;
//! let correspondence = onto_ellipsoid(&tetrahedron, &ellipsoid)?;
//! assert_eq!(correspondence.target.len(), 4);
//! # Ok::<(), chladni_match::MatchError>(())
//! ```

mod analytic;
mod bend;
mod bvh;
mod closed;
mod correspondence;
mod crossmap;
mod eigen;
mod error;
mod field;
mod flow;
mod graph;
mod icp;
mod landmarks;
mod laplacian;
mod matching;
mod prealign;
mod project;
mod quality;
mod samples;
mod settle;
mod similarity;
mod sphere;
mod surface;

pub use analytic::{Ellipsoid, onto_ellipsoid, self_low_passed, self_scaled};
pub use correspondence::{Correspondence, OnTemplate, same_connectivity};
pub use error::{MatchError, Side};
pub use landmarks::{Landmark, read_landmarks, write_landmarks};
pub use matching::{Match, Method, Settings, match_shapes};
pub use quality::Report;
pub use similarity::{Scaling, Similarity};
