//! Exaggerates the difference between a shape and a template.
//!
//! A [`Project`] is a shape and a stack of layers; a [`Stack`] evaluates it on a
//! [`Body`](chladni_harmonics::Body), each layer's result being the shape of the next. All
//! changes are [`Action`]s; a [`History`] undoes them. The mathematics is in `docs/caricature.md`.
//!
//! ```
//! use std::sync::Arc;
//! use chladni_caricature::{Action, History, Layer, Project, Property, ShapeSource, Stack, Template};
//! use chladni_harmonics::{BasisSettings, Body};
//! use chladni_mesh::samples::torus;
//! use chladni_task::Task;
//!
//! let mesh = torus(0.4, 24, 12);
//! let body = Arc::new(Body::build(&mesh, &BasisSettings::new(32), &Task::new())?);
//!
//! let mut project = Project::new(ShapeSource::File("ring.obj".into()), 32);
//! let layer = project.push(Layer { mu: -0.4, ..Layer::new("plump", Template::Ellipsoid) })?;
//! let mut history = History::new(project);
//!
//! // Templates are matched once, away from the window.
//! let mut stack = Stack::new(body.clone())?;
//! for request in stack.missing(history.project()) {
//!     let matched = request.run(&mesh, &body, None, &Task::new());
//!     stack.install(request, matched);
//! }
//! let plump = stack.evaluate(history.project());
//! assert_ne!(plump.file_positions(&body, &mesh.positions), mesh.positions);
//!
//! history.apply(&Action::Set { layer, to: Property::Mu(0.0) }, None)?;
//! let at_rest = stack.evaluate(history.project());
//! assert_eq!(at_rest.file_positions(&body, &mesh.positions), mesh.positions);
//! assert_eq!(history.undo(), Some("μ"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Not guaranteed: that a result has no folds or self-intersections (the fold meter counts triangles that
//! turned over, [`furthest`] says where they begin, [`Crossings`] finds triangles that pass through others; where
//! a project keeps triangles, [`Kept`] says how many are left);
//! that a strong layer keeps volume; that a region carried to another mesh lies where its painter would have
//! put it ([`Carried::report`] says how well the meshes match).

#![warn(clippy::missing_errors_doc)]

mod brush;
mod carry;
mod crossing;
mod curved;
mod difference;
mod error;
mod evaluation;
mod exaggeration;
mod fold;
mod gallery;
mod geodesic;
mod head_parts;
mod history;
mod keeping;
mod layer;
mod layer_memo;
mod limbs;
mod low_pass;
mod matching;
mod memo;
mod migration;
mod paint;
mod painted_spectrum;
mod project;
mod project_file;
mod recovery;
mod region;
mod resolution;
mod runs;
mod scale_curve;
mod softening;
mod stack;
mod surface;
mod wavelength;

pub use brush::{Blocked, Brush, Reach, Seen, SeenAt};
pub use carry::Carried;
pub use crossing::Crossings;
pub use curved::{Bend, Curved};
pub use difference::{Amplitudes, Base, Difference, Model, Psi, Target};
pub use error::CaricatureError;
pub use evaluation::{EvaluatedLayer, Evaluation, LayerState};
pub use exaggeration::{Field, Signals};
pub use fold::{flipped_triangles, furthest};
pub use gallery::{
    GALLERY_SIZE, Group, MOST_FOLDS, Portrait, Sitter, SitterPart, Variant, VariantGallery, surprise,
};
pub use head_parts::HeadParts;
pub use history::History;
pub use keeping::{KeepRequest, Kept};
pub use layer::{GivenEllipsoid, Layer, LayerId, MAX_MU, Template};
pub use limbs::{Limb, Limbs};
pub use low_pass::self_low_passed;
pub use matching::{MatchRequest, Matched};
pub use migration::FORMAT_VERSION;
pub use paint::{Dab, PaintEdit};
pub use project::{Action, DEFAULT_HARMONICS, Project, Property};
pub use recovery::{Recovered, Recovery};
pub use region::{Painted, Region, RollOff, Smoothing, Sphere};
pub use resolution::{ProxyKey, Resolution};
pub use scale_curve::ScaleCurve;
pub use stack::Stack;
pub use surface::Surface;
pub use wavelength::{parse_wavelength, size, usual_wavelength, wavelengths};

pub use chladni_mesh::ShapeSource;
pub use chladni_mesh::samples::HEAD_PARTS;
pub use chladni_mesh::surface::SurfacePoint;

#[cfg(test)]
mod fixture;

/// The examples of README.md, compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
