//! Harmonic exaggeration.

mod brush;
mod difference;
mod error;
mod exaggeration;
mod fold;
mod geodesic;
mod history;
mod layer;
mod matching;
mod memo;
mod migration;
mod project;
mod project_file;
mod recovery;
mod region;
mod runs;
mod scale_curve;
mod shape_source;
mod stack;
mod surface;
mod transform;
mod vector;

pub use brush::{Dab, Mirror, PaintEdit};
pub use difference::{Base, Difference, Model, Psi, Target};
pub use error::Error;
pub use exaggeration::{Field, Signals};
pub use fold::{flipped_triangles, furthest};
pub use geodesic::SurfacePoint;
pub use history::History;
pub use layer::{Layer, LayerId, MAX_MU, Template};
pub use matching::{MatchRequest, Matched};
pub use migration::FORMAT_VERSION;
pub use project::{Action, Project, Property};
pub use project_file::DEFAULT_HARMONICS;
pub use recovery::{Recovered, Recovery};
pub use region::{Painted, Region, RollOff, Smoothing, Sphere};
pub use scale_curve::{ScaleCurve, normalised_frequency};
pub use shape_source::ShapeSource;
pub use stack::{EvaluatedLayer, Evaluation, LayerState, Stack};
pub use surface::Surface;

#[cfg(test)]
mod fixture;
