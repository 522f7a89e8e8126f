//! The natural vibrations of a mesh: its Laplacian, its first K harmonics with a certificate, and the
//! transform to and from them.
//!
//! ```
//! use chladni_harmonics::{BasisSettings, Body};
//! use chladni_mesh::TriMesh;
//! use chladni_task::Task;
//!
//! // A regular tetrahedron; its place and size do not matter.
//! let mesh = TriMesh {
//!     positions: vec![[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]],
//!     triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]],
//!     ..TriMesh::default()
//! };
//! let body = Body::build(&mesh, &BasisSettings::new(4), &Task::new())?;
//! let basis = &body.basis;
//! assert_eq!(basis.harmonics(), 4);
//! assert_eq!(basis.certificate.inertia_counts_match, Some(true));
//! // A signal equals the sum of all its harmonics.
//! let back = basis.synthesize3(&basis.transform3(&body.positions));
//! assert!((back[2][1] - body.positions[2][1]).abs() < 1e-12);
//! # Ok::<(), chladni_harmonics::HarmonicsError>(())
//! ```
//!
//! The signs of harmonics, and the choice among those of equal eigenvalues, are determined by the geometry
//! (see [`canonical`]): the same mesh gives the same harmonics on every machine, up to rounding.
//!
//! Not guaranteed: harmonics whose eigenvalues differ by little more than rounding (a share of 10⁻⁹) may
//! mix slightly differently on different processors.

#![warn(clippy::missing_errors_doc)]

mod basis;
mod body;
mod build;
mod cache;
pub mod canonical;
mod eigen;
mod error;
mod functional_map;
mod geodesic;
mod heat;
mod held;
mod laplacian;
mod ldlt;
mod least_squares;
mod memory;
mod nearest;
#[cfg(feature = "npz")]
pub mod npz;
mod operator;
mod pages;
mod pencil;
mod platform;
#[cfg(not(target_family = "wasm"))]
mod ranks;
mod report;
mod settings;
mod simd;
mod sparse;
mod symmetric_eigen;
mod threads;
mod transform;
mod values;

pub use basis::{Basis, Certificate};
pub use body::Body;
pub use cache::BasisCache;
pub use error::HarmonicsError;
pub use functional_map::{Eigenvectors, FunctionalMap};
pub use geodesic::HeatGeodesics;
pub use heat::{HeatFlow, HeatStep};
pub use memory::available as available_memory;
pub use operator::{Operator, mesh_laplacian, point_cloud_laplacian};
pub use pencil::{ConsistentPencil, Eigenpairs, Pencil};
#[cfg(not(target_family = "wasm"))]
pub use ranks::{InnerSolver, Ranks, RanksReport, RanksSeconds};
pub use report::{BasisWarning, BuildReport, BuildSeconds, CoverReport, ShortOfMemory, SolveProfile};
pub use settings::{BasisSettings, Laplacian};
pub use sparse::SymmetricSparse;
pub use threads::MOST_THREADS;
pub use values::Values;

/// The examples of README.md, compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
