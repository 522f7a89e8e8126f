//! Correspondences between a shape and a template: for each vertex of the shape, a point of the template
//! and a confidence.
//!
//! ```
//! use chladni_match::{Ellipsoid, Method, MatchSettings, match_shapes, onto_ellipsoid};
//! use chladni_mesh::samples;
//! use chladni_task::Task;
//!
//! // A template mesh: here the shape itself, in other units and turned by 90°.
//! let shape = samples::torus(0.4, 24, 12);
//! let mut template = shape.clone();
//! for p in &mut template.positions {
//!     *p = [25.4 * p[1], -25.4 * p[0], 25.4 * p[2]];
//! }
//! let settings = MatchSettings { method: Method::Icp, ..MatchSettings::default() };
//! let found = match_shapes(&shape, &template, &settings, &Task::new())?;
//! assert!((found.correspondence.similarity.scale - 1.0 / 25.4).abs() < 1e-6);
//! assert!(found.report.coverage > 0.99);
//!
//! // An analytic template, which needs no mesh.
//! let ellipsoid = Ellipsoid::fitted(&shape)?;
//! assert_eq!(onto_ellipsoid(&shape, &ellipsoid)?.target.len(), shape.positions.len());
//! # Ok::<(), chladni_match::MatchError>(())
//! ```
//!
//! Not guaranteed: that a pose found without landmarks is the one that a person would choose (see
//! [`MatchReport::near_tie`]); that [`Method::Fit`] is one to one; that [`Method::Map`] is one to one on
//! the template's surface where its holes were filled, or after rounding. Guaranteed: all numbers are
//! finite, barycentric coordinates lie in their triangles, and the same input and seed give the same result
//! on the same machine.

#![warn(clippy::missing_errors_doc)]
#![allow(
    clippy::neg_cmp_op_on_partial_ord,
    reason = "`!(x > limit)` also refuses NaN, which `x <= limit` lets through"
)]

mod analytic;
mod bend;
mod closed;
mod correspondence;
mod crossmap;
mod error;
mod field;
mod flow;
mod graph;
mod icp;
mod infill;
mod landmarks;
mod laplacian;
mod matching;
mod mean;
mod partners;
mod prealign;
mod project;
mod quality;
mod relief;
mod samples;
mod settle;
mod similarity;
mod sphere;
mod surface;
mod transfer;
mod unfold;

pub use analytic::{Ellipsoid, onto_ellipsoid, self_scaled};
pub use correspondence::{Correspondence, has_same_vertices, same_connectivity};
pub use error::{MatchError, Side};
pub use infill::{Infill, infilled};
pub use landmarks::{Landmark, load_landmarks, read_landmarks, write_landmarks};
pub use matching::{Match, MatchSettings, Method, match_shapes};
pub use mean::MeanShape;
pub use quality::{MatchReport, NEAR_TIE};
pub use similarity::{Scaling, Similarity};
pub use transfer::{Transfer, transfer};

/// The examples of README.md, compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
