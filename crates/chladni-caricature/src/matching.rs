//! From a layer's template to the points x^r.

use std::sync::Arc;

use chladni_harmonics::{Basis, Body};
use chladni_match::{
    Correspondence, Ellipsoid, Match, MatchError, MatchReport, MatchSettings, infilled, match_shapes,
    onto_ellipsoid,
};
use chladni_mesh::{Estimate, Known, Orientation, TriMesh};
use chladni_task::Task;
use serde::{Deserialize, Serialize};

use crate::{Base, CaricatureError, Layer, Target, Template};
use chladni_mesh::surface::SurfacePoint;
use chladni_mesh::surface::vec3::{Vec3, add, scaled};

/// A template that has to be matched with the shape, once, however many layers use it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MatchRequest {
    /// The template.
    pub template: Template,
    /// How to match it; the default for templates that are not meshes.
    pub matching: MatchSettings,
}

/// A matched template. It does not depend on the harmonics, so it survives a change of their number.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Matched {
    /// x^r on the N operator vertices, working frame.
    pub points: Vec<Vec3>,
    /// The same with untrusted points filled in from their surroundings, and their share of the shape; `None`
    /// if all points are trusted.
    pub infill: Option<(Vec<Vec3>, f64)>,
    /// How good the match is; `None` if the template is not a mesh.
    pub report: Option<MatchReport>,
    /// How far to trust each of the n file vertices, in [0, 1].
    pub confidence: Vec<f64>,
    /// Where each of the n file vertices lies on the template's mesh; `None` if the template is not a mesh.
    pub on_template: Option<Vec<SurfacePoint>>,
    /// The shape's orientation if it stands as its template does; `None` if that is in doubt, too.
    pub stands: Option<Orientation>,
}

impl Matched {
    /// x^r on `basis`, interpolated by `infill` (0 to 1) from the points as found to those filled in.
    pub(crate) fn target(&self, basis: &Arc<Basis>, infill: f64) -> Result<Target, CaricatureError> {
        let points = match &self.infill {
            Some((filled, _)) if infill > 0.0 => {
                let both = self.points.iter().zip(filled);
                both.map(|(found, filled)| add(scaled(*found, 1.0 - infill), scaled(*filled, infill)))
                    .collect()
            }
            _ => self.points.clone(),
        };
        Target::new(basis.clone(), points)
    }
}

/// Points given for the n vertices of the shape's file, in the file's coordinates, on the operator vertices.
/// Vertices that were welded take the mean.
fn on_operator_vertices(body: &Body, points: &[Vec3]) -> Result<Vec<Vec3>, CaricatureError> {
    let expected = body.operator_vertex.len();
    if points.len() != expected {
        return Err(CaricatureError::VertexCount {
            what: "the template's points",
            found: points.len(),
            expected,
        });
    }
    let mut sums = vec![[0.0; 3]; body.positions.len()];
    let mut counts = vec![0.0; body.positions.len()];
    for (point, v) in points.iter().zip(&body.operator_vertex) {
        if let Some(v) = v.map(|v| v as usize).filter(|v| *v < sums.len()) {
            sums[v] = add(sums[v], body.frame.to_working(*point));
            counts[v] += 1.0;
        }
    }
    let mean: Vec<Vec3> = sums.iter().zip(&counts).map(|(s, n)| scaled(*s, 1.0 / n)).collect();
    match mean.iter().flatten().find(|c| !c.is_finite()) {
        Some(bad) => {
            Err(CaricatureError::Range { what: "a point of the template", value: *bad, range: "finite" })
        }
        None => Ok(mean),
    }
}

impl MatchRequest {
    /// The match that `layer` needs; `None` where its template is made from its own shape.
    pub fn of(layer: &Layer) -> Option<Self> {
        Self::with(layer.template.clone(), layer.matching.clone())
    }

    /// The match with `template` that a layer with these settings needs, as in [`of`](Self::of).
    pub fn with(template: Template, matching: MatchSettings) -> Option<Self> {
        match template {
            Template::File(_) | Template::Sample(_) => Some(Self { template, matching }),
            Template::Ellipsoid | Template::Sphere | Template::Given(_) => {
                Some(Self { template, matching: MatchSettings::default() })
            }
            Template::Scaled(_) | Template::LowPass(_) | Template::Original | Template::Layer(_) => None,
        }
    }

    /// Matches. `shape` is the mesh that `body` was built from; `mesh` is the template's, needed
    /// where [`Template::is_mesh`]. May take seconds; check the report of a mesh.
    ///
    /// # Errors
    /// A template whose mesh is missing or does not match, or [`CaricatureError::Cancelled`].
    pub fn run(
        &self,
        shape: &TriMesh,
        body: &Body,
        mesh: Option<&TriMesh>,
        task: &Task,
    ) -> Result<Matched, CaricatureError> {
        let failed = |e: MatchError| self.failure(e.to_string());
        let found = match self.template {
            Template::Ellipsoid => {
                let ellipsoid = Ellipsoid::fitted(shape).map_err(failed)?;
                onto_ellipsoid(shape, &ellipsoid).map_err(failed)?
            }
            Template::Sphere => {
                let sphere = Ellipsoid::fitted_sphere(shape).map_err(failed)?;
                onto_ellipsoid(shape, &sphere).map_err(failed)?
            }
            Template::Given(given) => {
                onto_ellipsoid(shape, &given.ellipsoid().map_err(failed)?).map_err(failed)?
            }
            _ => {
                let mesh = mesh.ok_or_else(|| self.failure("its mesh is not loaded".to_owned()))?;
                let matched = match_shapes(shape, mesh, &self.matching, task);
                task.check()?;
                return self.of_match(matched.map_err(failed)?, shape, body, mesh, task);
            }
        };
        let points = on_operator_vertices(body, &found.target)?;
        let Correspondence { confidence, on_template, .. } = found;
        Ok(Matched { points, infill: None, report: None, confidence, on_template, stands: None })
    }

    /// The same where `shape` is matched with the template's `mesh` already, as `found` says.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn of_match(
        &self,
        found: Match,
        shape: &TriMesh,
        body: &Body,
        mesh: &TriMesh,
        task: &Task,
    ) -> Result<Matched, CaricatureError> {
        let stands = like_template(mesh, self.template.known(), &found, task)?;
        let Match { correspondence, report } = found;
        let filled = infilled(shape, &correspondence).map_err(|error| self.failure(error.to_string()))?;
        let infill = match filled {
            Some(filled) => Some((on_operator_vertices(body, &filled.target)?, filled.share)),
            None => None,
        };
        let points = on_operator_vertices(body, &correspondence.target)?;
        let Correspondence { confidence, on_template, .. } = correspondence;
        Ok(Matched { points, infill, report: Some(report), confidence, on_template, stands })
    }

    fn failure(&self, why: String) -> CaricatureError {
        CaricatureError::Template { template: self.template.to_string(), why }
    }
}

/// The orientation of a shape that was matched with `template`, of whose own orientation `known` is known.
fn like_template(
    template: &TriMesh,
    known: Known,
    matched: &Match,
    task: &Task,
) -> Result<Option<Orientation>, CaricatureError> {
    let Ok(found) = Estimate::of(template, known, task) else {
        task.check()?;
        return Ok(None);
    };
    if found.in_doubt || matched.report.near_tie {
        return Ok(None);
    }
    let rows = matched.correspondence.similarity.rotation;
    Ok(found.orientation.turned(std::array::from_fn(|j| std::array::from_fn(|i| rows[i][j]))))
}

/// The target of a template that is made from a shape of the stack itself: the layer's own, the original, or the result
/// of a layer further down; `None` of other templates.
///
/// # Errors
/// A low-pass that keeps more harmonics than there are.
pub(crate) fn own_target(template: &Template, shape: &Arc<Base>) -> Result<Option<Target>, CaricatureError> {
    Ok(match template {
        Template::Scaled(factor) => Some(Target::scaled(shape.clone(), *factor)),
        Template::LowPass(k0) => Some(Target::low_passed(shape.clone(), *k0)?),
        Template::Original | Template::Layer(_) => Some(Target::scaled(shape.clone(), 1.0)),
        _ => None,
    })
}
