//! A correspondence: for each vertex of the shape, a point of the template.

use std::collections::HashSet;

use chladni_mesh::TriMesh;
use chladni_mesh::surface::{SurfacePoint, corners, mixed};

use crate::{MatchError, Scaling, Side, Similarity};

/// For each of the n file vertices of the shape, the corresponding point x^r(v) of the template. All
/// numbers are finite.
///
/// A vertex that no triangle of the shape uses has confidence 0. Its point is the closest point of the
/// aligned template if the template is a mesh, the point that belongs to its position if the template is
/// analytic, and its own position if the template was made from the shape itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Correspondence {
    /// Triangle indices of the template's file and barycentric weights ≥ 0, n entries; `None` if the
    /// template is not a mesh.
    pub on_template: Option<Vec<SurfacePoint>>,
    /// Points of the template in the coordinates of the template's file, n entries.
    pub point: Vec<[f64; 3]>,
    /// x^r(v) in the coordinates of the shape's file: `similarity` applied to `point`, n entries.
    pub target: Vec<[f64; 3]>,
    /// Confidence in each point, in [0, 1], n entries.
    pub confidence: Vec<f64>,
    /// Maps the template to the shape, both in file coordinates.
    pub similarity: Similarity,
}

impl Correspondence {
    /// n, the number of file vertices of the shape.
    pub fn vertices(&self) -> usize {
        self.point.len()
    }

    /// A correspondence whose n points are given in the coordinates of the shape, each with a confidence in
    /// [0, 1].
    pub fn direct(point: Vec<[f64; 3]>, confidence: Vec<f64>) -> Self {
        let target = point.clone();
        Self { on_template: None, point, target, confidence, similarity: Similarity::IDENTITY }
    }

    /// A correspondence to points on a template mesh.
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

/// Pairs vertex i of the shape with vertex i of the template, after the least-squares similarity that
/// brings the template's vertices closest to the shape's (over the vertices in use); a rigid motion if
/// `scaling` says so.
///
/// # Errors
/// Different numbers of vertices; different triangles (in whatever order), unless both have the same polygons or differ
/// only in the diagonals of quads; a mesh without a surface; vertices that all lie on one line.
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
    let mut corner: Vec<Option<(u32, usize)>> = vec![None; template.positions.len()];
    for (t, corners) in template.triangles.iter().enumerate() {
        for (i, &v) in corners.iter().enumerate() {
            corner[v as usize].get_or_insert((t as u32, i));
        }
    }
    // A copy that no triangle uses need not lie in the same place in both.
    let used = shape_surface.point_of_vertex.iter().zip(&corner).map(|(p, c)| p.is_some() && c.is_some());
    let weights: Vec<f64> = used.map(|used| f64::from(u8::from(used))).collect();
    let similarity = Similarity::fit(&template.positions, &shape.positions, Some(&weights), scaling)?;
    // A copy of a vertex that no triangle uses goes with the one in its place.
    let mut corner_of_point = vec![None; shape_surface.points.len()];
    for (point, corner) in shape_surface.point_of_vertex.iter().zip(&corner) {
        if let (Some(point), Some(corner)) = (point, corner) {
            corner_of_point[*point as usize].get_or_insert(*corner);
        }
    }
    for (point, corner) in shape_surface.point_of_vertex.iter().zip(&mut corner) {
        *corner = corner.or_else(|| corner_of_point[(*point)? as usize]);
    }
    let n = shape.positions.len();
    let mut on_template = Vec::with_capacity(n);
    let mut confidence = Vec::with_capacity(n);
    for (v, corner) in corner.iter().enumerate() {
        on_template.push(match corner {
            Some((triangle, corner)) => SurfacePoint::at_corner(*triangle, *corner),
            // No triangle of the template uses this vertex: take the closest point of its surface.
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

/// Whether the vertices of two meshes belong together one by one, as the method `same` takes them: as many
/// vertices, and the same polygons in the same order or the same triangles in any order, but for diagonals of quads.
pub fn has_same_vertices(shape: &TriMesh, template: &TriMesh) -> bool {
    shape.positions.len() == template.positions.len() && check_triangles(shape, template).is_ok()
}

/// Checks that both meshes have the same polygons or triangles: an equal number of vertices alone proves nothing.
fn check_triangles(shape: &TriMesh, template: &TriMesh) -> Result<(), MatchError> {
    // Into which triangles a polygon is divided depends on its shape.
    let polygons = &shape.appearance.polygons;
    let has_same_polygons = polygons.is_some() && *polygons == template.appearance.polygons;
    if shape.triangles == template.triangles || has_same_polygons {
        return Ok(());
    }
    // Each triangle is rotated to begin with its smallest corner, which keeps its orientation; then all are
    // sorted.
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
    let absent_in = |others: &[[u32; 3]], own: &[[u32; 3]]| -> Vec<[u32; 3]> {
        own.iter().filter(|t| others.binary_search(t).is_err()).copied().collect()
    };
    let (missing, extra) = (absent_in(&theirs, &ours), absent_in(&ours, &theirs));
    if ours.len() == theirs.len() && are_halves_of_same_quads(&missing, &extra) {
        return Ok(());
    }
    Err(MatchError::TrianglesDiffer {
        missing: missing.len(),
        extra: extra.len(),
        triangles: ours.len(),
        template_triangles: theirs.len(),
    })
}

/// Whether two sets of triangles divide the same quads along other diagonals: two sides of each triangle are then also
/// sides in the other set, and the third is the diagonal. Meshes without polygons, such as arrays, may come from files
/// with them.
fn are_halves_of_same_quads(ours: &[[u32; 3]], theirs: &[[u32; 3]]) -> bool {
    let sides = |t: &[u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    let halve = |own: &[[u32; 3]], others: &[[u32; 3]]| {
        let others: HashSet<[u32; 2]> = others.iter().flat_map(sides).collect();
        own.iter().all(|t| sides(t).iter().filter(|side| others.contains(*side)).count() == 2)
    };
    halve(ours, theirs) && halve(theirs, ours)
}
