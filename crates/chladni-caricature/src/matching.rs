//! From a layer's template to the points x^r.

use std::sync::Arc;

use chladni_harmonics::Body;
use chladni_match::{Ellipsoid, MatchError, Report, Settings, match_shapes, onto_ellipsoid};
use chladni_mesh::TriMesh;
use chladni_task::Task;

use crate::{Base, Error, Layer, Target, Template};

/// A template that has to be matched with the shape, once, however many layers use it.
#[derive(Clone, Debug, PartialEq)]
pub struct MatchRequest {
    /// The template.
    pub template: Template,
    /// How to match it; the default for templates that are not meshes.
    pub matching: Settings,
}

/// A matched template.
#[derive(Clone, Debug)]
pub struct Matched {
    /// x^r on the operator vertices.
    pub target: Arc<Target>,
    /// How good the match is; none where the template is not a mesh.
    pub report: Option<Report>,
    /// How far to trust each of the n file vertices, in [0, 1].
    pub confidence: Vec<f64>,
}

impl MatchRequest {
    /// What `layer` needs; `None` where its template is its own shape.
    pub fn of(layer: &Layer) -> Option<Self> {
        let template = layer.template.clone();
        match template {
            Template::File(_) | Template::Sample(_) => {
                Some(Self { template, matching: layer.matching.clone() })
            }
            Template::Ellipsoid | Template::Sphere => Some(Self { template, matching: Settings::default() }),
            Template::Scaled(_) | Template::LowPass(_) | Template::Original => None,
        }
    }

    /// Matches. `shape` is the mesh that `body` was built from; `mesh` is the template's, needed
    /// where [`Template::is_mesh`]. May take seconds; check the report of a mesh.
    pub fn run(
        &self,
        shape: &TriMesh,
        body: &Body,
        mesh: Option<&TriMesh>,
        task: &Task,
    ) -> Result<Matched, Error> {
        let failed = |e: MatchError| self.failure(e.to_string());
        let (found, report) = match self.template {
            Template::Ellipsoid => {
                let ellipsoid = Ellipsoid::fitted(shape).map_err(failed)?;
                (onto_ellipsoid(shape, &ellipsoid).map_err(failed)?, None)
            }
            Template::Sphere => {
                let sphere = Ellipsoid::fitted_sphere(shape).map_err(failed)?;
                (onto_ellipsoid(shape, &sphere).map_err(failed)?, None)
            }
            _ => {
                let mesh = mesh.ok_or_else(|| self.failure("its mesh is not loaded".to_owned()))?;
                let matched = match_shapes(shape, mesh, &self.matching, task);
                task.check()?;
                let matched = matched.map_err(failed)?;
                (matched.correspondence, Some(matched.report))
            }
        };
        let target = Arc::new(Target::from_file_points(body, &found.target)?);
        Ok(Matched { target, report, confidence: found.confidence })
    }

    fn failure(&self, why: String) -> Error {
        Error::Template { template: self.template.to_string(), why }
    }
}

/// The target of a template that is made from the layer's own `base` or the `original` shape.
pub(crate) fn own_target(template: &Template, base: &Arc<Base>, original: &Arc<Base>) -> Option<Target> {
    match template {
        Template::Scaled(factor) => Some(Target::scaled(base.clone(), *factor)),
        Template::LowPass(k0) => Some(Target::low_passed(base.clone(), *k0)),
        Template::Original => Some(Target::scaled(original.clone(), 1.0)),
        _ => None,
    }
}
