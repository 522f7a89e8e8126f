//! Triangle meshes as files hold them: reading, writing, examining, welding, and shapes of our own.
//!
//! ```
//! use chladni_mesh::{Format, HealthReport, read_mesh, samples, weld, write_mesh};
//!
//! // A seam: the second and third vertex of both triangles coincide.
//! let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 4 5 6\n";
//! let loaded = read_mesh(obj, Format::Obj)?;
//! assert!(loaded.mended.is_empty());
//!
//! let report = HealthReport::of(&loaded.mesh);
//! assert_eq!((report.topology.components, report.duplicate_vertices), (2, 2));
//! assert_eq!(report.welded.topology.components, 1);
//!
//! // The operator sees one surface; the file's six vertices stay as they are.
//! let welded = weld(&loaded.mesh);
//! assert_eq!(welded.positions.len(), 4);
//! assert_eq!(welded.operator_vertex[5], Some(2));
//! let back = read_mesh(&write_mesh(&loaded.mesh, Format::Ply)?, Format::Ply)?;
//! assert_eq!(back.mesh, loaded.mesh);
//!
//! assert!(samples::sample("octopus").is_some());
//! # Ok::<(), chladni_mesh::MeshError>(())
//! ```
//!
//! Formats, what each of them keeps, and what a health report counts are written down in
//! `docs/meshes.md`.
//!
//! Not guaranteed: the triangles of a polygon that crosses itself, or is not convex and has more than 1024 corners, may
//! overlap, which the reader reports. Only exactly equal positions weld. Files' normals, groups, skins,
//! animations and morph targets are not kept in the mesh; [`add_morph_targets`] keeps them in the file. Functions that take bare positions and triangles
//! panic where a triangle names a vertex that is not there; what the readers return never does.

#![warn(clippy::missing_errors_doc)]

mod appearance;
mod channel;
mod eigen;
mod error;
mod format;
mod frame;
mod health;
mod mesh;
mod mirror;
mod orientation;
mod proxy;
mod read;
pub mod samples;
mod shape_source;
pub mod surface;
mod write;

pub use appearance::{
    AlphaMode, Appearance, Attribute, CornerUvs, Material, Texture, linear_from_srgb, srgb_from_linear,
};
pub use channel::COLOR_CHANNELS;
pub use eigen::{symmetric_eigen, symmetric_eigen_of};
pub use error::{MeshError, Place};
pub use format::Format;
pub use frame::Frame;
pub use health::{HealthReport, Topology, Welded};
pub use mesh::TriMesh;
pub use mirror::{MirrorPlane, MirrorSearch, OnSurface};
pub use orientation::{Axis, Estimate, Evidence, Known, Orientation};
pub use proxy::Proxy;
pub use read::{
    Loaded, Mended, load_mesh, name_within, nothing_beside, picture_name, pictures_beside, read_mesh,
    read_mesh_beside, read_named_mesh,
};
pub use shape_source::ShapeSource;
pub use surface::{Rows, Weld, total_area, vertex_neighbors, vertex_triangles, weld};
pub use write::{
    MorphAnimation, MorphTarget, add_morph_targets, add_morph_targets_in, check_glb, far_center, save_mesh,
    write_animated_glb, write_glb, write_mesh,
};

/// The examples of README.md, compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
