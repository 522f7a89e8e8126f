//! What a match is: for each vertex of the shape a point of the template.

use chladni_mesh::TriMesh;
use chladni_mesh::surface::{SurfacePoint, corners, mixed};

use crate::{MatchError, Scaling, Side, Similarity};

/// For each of the n file vertices of the shape, the point x^r(v) of the template that it
/// corresponds to. Every number is finite.
///
/// A vertex that no triangle of the shape uses has confidence 0. Mesh templates give it the
/// closest point of the aligned template, analytic ones the point they would give any point
/// in space, and templates made from the shape itself its own position.
#[derive(Clone, Debug, PartialEq)]
pub struct Correspondence {
    /// Triangles of the template's file and barycentric weights ≥ 0, n; `None` where the template is not a mesh.
    pub on_template: Option<Vec<SurfacePoint>>,
    /// Points of the template, in the template file's coordinates.
    pub point: Vec<[f64; 3]>,
    /// x^r(v) in the shape file's coordinates: `similarity` applied to `point`.
    pub target: Vec<[f64; 3]>,
    /// How far to trust each point, in [0, 1].
    pub confidence: Vec<f64>,
    /// Template to shape, file coordinates.
    pub similarity: Similarity,
}

impl Correspondence {
    /// n, the number of file vertices of the shape.
    pub fn vertices(&self) -> usize {
        self.point.len()
    }

    /// Points given directly in the shape's coordinates, n, and how far to trust each, in [0, 1].
    pub fn direct(point: Vec<[f64; 3]>, confidence: Vec<f64>) -> Self {
        let target = point.clone();
        Self { on_template: None, point, target, confidence, similarity: Similarity::IDENTITY }
    }

    /// Points on a template mesh.
    pub(crate) fn on_mesh(
        template: &TriMesh,
        on_template: Vec<SurfacePoint>,
        confidence: Vec<f64>,
        similarity: Similarity,
    ) -> Self {
        let place = |on: &SurfacePoint| {
            mixed(corners(&template.positions, &template.triangles[on.triangle as usize]), on.weights)
        };
        let point: Vec<[f64; 3]> = on_template.iter().map(place).collect();
        let target = point.iter().map(|p| similarity.apply(*p)).collect();
        Self { on_template: Some(on_template), point, target, confidence, similarity }
    }
}

/// Vertex i of the shape ↔ vertex i of the template, after the similarity that brings the
/// template's vertices closest to the shape's (least squares over the vertices in use); rigid where `scaling`
/// says so.
///
/// # Errors
/// Different numbers of vertices, different triangles (in whatever order they and their corners are listed),
/// meshes without a surface, vertices in one line.
pub fn same_connectivity(
    shape: &TriMesh,
    template: &TriMesh,
    scaling: Scaling,
) -> Result<Correspondence, MatchError> {
    use crate::surface::UnitSurface;
    if shape.positions.len() != template.positions.len() {
        return Err(MatchError::VertexCountsDiffer {
            shape_vertices: shape.positions.len(),
            template_vertices: template.positions.len(),
        });
    }
    check_triangles(shape, template)?;
    let shape_surface = UnitSurface::new(shape, Side::Shape)?;
    let template_surface = UnitSurface::new(template, Side::Template)?;
    let weights: Vec<f64> =
        shape_surface.point_of_vertex.iter().map(|p| f64::from(u8::from(p.is_some()))).collect();
    let similarity = Similarity::fit(&template.positions, &shape.positions, Some(&weights), scaling)?;
    let mut corner: Vec<Option<(u32, usize)>> = vec![None; template.positions.len()];
    for (t, corners) in template.triangles.iter().enumerate() {
        for (i, &v) in corners.iter().enumerate() {
            corner[v as usize].get_or_insert((t as u32, i));
        }
    }
    let n = shape.positions.len();
    let mut on_template = Vec::with_capacity(n);
    let mut confidence = Vec::with_capacity(n);
    for (v, corner) in corner.iter().enumerate() {
        on_template.push(match corner {
            Some((triangle, corner)) => SurfacePoint::at_corner(*triangle, *corner),
            // No triangle of the template has this vertex: the closest point of its surface.
            None => {
                let at = template_surface
                    .closest(template_surface.in_frame(template.positions[v]), f64::INFINITY)
                    .ok_or(MatchError::NoSurface(Side::Template))?;
                template_surface.in_file(&at.on)
            }
        });
        let used = shape_surface.point_of_vertex[v].is_some() && corner.is_some();
        confidence.push(f64::from(u8::from(used)));
    }
    Ok(Correspondence::on_mesh(template, on_template, confidence, similarity))
}

/// Whether both have the same triangles: an equal number of vertices alone says nothing.
fn check_triangles(shape: &TriMesh, template: &TriMesh) -> Result<(), MatchError> {
    if shape.triangles == template.triangles {
        return Ok(());
    }
    // Each rotated so that the smallest corner comes first, orientation kept; then sorted.
    let sorted = |mesh: &TriMesh| {
        let mut triangles: Vec<[u32; 3]> = mesh
            .triangles
            .iter()
            .map(|&[a, b, c]| [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap_or([a, b, c]))
            .collect();
        triangles.sort_unstable();
        triangles
    };
    let (ours, theirs) = (sorted(shape), sorted(template));
    if ours == theirs {
        return Ok(());
    }
    let missing = ours.iter().filter(|t| theirs.binary_search(t).is_err()).count();
    Err(MatchError::TrianglesDiffer { missing, triangles: ours.len(), template_triangles: theirs.len() })
}
