//! A mesh as a surface: welded, without degenerate triangles, at unit size.

use chladni_mesh::TriMesh;
use chladni_mesh::surface::{
    Closest, Rows, SurfacePoint, TriangleTree, boundary_vertices, components, inward_triangles, places,
    repeated_triangles, vertex_neighbors, vertex_normals,
};
use glam::DVec3;

use crate::{MatchError, Side};

/// The surface that all methods work on. Coordinates are centered at the area-weighted centroid and divided
/// by the diagonal of the bounding box: lengths are shares of the diagonal.
#[derive(Clone, Debug)]
pub(crate) struct UnitSurface {
    /// Area-weighted centroid, file units.
    pub center: DVec3,
    /// Diagonal of the bounding box of the vertices in use, file units; positive.
    pub diagonal: f64,
    /// N welded vertices in use.
    pub points: Vec<DVec3>,
    /// Triangles of positive area over `points`.
    pub triangles: Vec<[u32; 3]>,
    /// For each of `triangles`, its index in the file.
    pub file_triangle: Vec<u32>,
    /// For each of `triangles`, whether its last two corners have changed places since the file.
    pub turned: Vec<bool>,
    /// For each of the n file vertices, its welded vertex; `None` if no triangle with area uses its position.
    pub point_of_vertex: Vec<Option<u32>>,
    /// Unit normals of `triangles`.
    pub triangle_normals: Vec<DVec3>,
    /// Areas of `triangles`.
    pub triangle_areas: Vec<f64>,
    /// Area-weighted unit normals of `points` (zero where the triangles cancel).
    pub normals: Vec<DVec3>,
    /// A third of the area around each of `points`.
    pub areas: Vec<f64>,
    /// For each of `points`, whether it lies on an edge of only one triangle.
    pub boundary: Vec<bool>,
    /// The component of each of `points`; components are numbered from 0 in the order of their first
    /// vertex.
    pub component: Vec<u32>,
    tree: TriangleTree,
    neighbors: Rows,
}

impl UnitSurface {
    /// The surface with the winding of the file.
    pub fn new(mesh: &TriMesh, side: Side) -> Result<Self, MatchError> {
        Self::wound(mesh, side, false)
    }

    /// The surface with triangles that face inward turned round: normals of two surfaces say something about each other
    /// only if both face outward.
    pub fn facing_outward(mesh: &TriMesh, side: Side) -> Result<Self, MatchError> {
        Self::wound(mesh, side, true)
    }

    fn wound(mesh: &TriMesh, side: Side, outward: bool) -> Result<Self, MatchError> {
        check(mesh, side)?;
        let welded = weld(mesh);
        let (center, diagonal) = extent(mesh, &welded.kept).ok_or(MatchError::NoSurface(side))?;
        let points: Vec<DVec3> =
            welded.file_vertex.iter().map(|&v| (file_point(mesh, v) - center) / diagonal).collect();
        let (mut triangles, mut file_triangle) = (Vec::new(), Vec::new());
        let (mut triangle_normals, mut triangle_areas) = (Vec::new(), Vec::new());
        let mut areas = vec![0.0; points.len()];
        for &t in &welded.kept {
            // `kept` lists only triangles whose corners all have a welded vertex.
            let corners = mesh.triangles[t as usize].map(|v| welded.point_of_vertex[v as usize].unwrap_or(0));
            let [a, b, c] = corners.map(|v| points[v as usize]);
            let twice = (b - a).cross(c - a);
            let area = 0.5 * twice.length();
            let Some(normal) = twice.try_normalize() else { continue };
            for v in corners {
                areas[v as usize] += area / 3.0;
            }
            triangles.push(corners);
            file_triangle.push(t);
            triangle_normals.push(normal);
            triangle_areas.push(area);
        }
        if triangles.is_empty() {
            return Err(MatchError::NoSurface(side));
        }
        let turned = if outward {
            inward_triangles(&arrays(&points), &triangles)
        } else {
            vec![false; triangles.len()]
        };
        for (t, _) in turned.iter().enumerate().filter(|(_, turned)| **turned) {
            triangles[t].swap(1, 2);
            triangle_normals[t] = -triangle_normals[t];
        }
        Ok(Self {
            center,
            diagonal,
            tree: triangle_tree(&points, &triangles),
            normals: normals(&points, &triangles),
            boundary: boundary_vertices(points.len(), &triangles),
            component: components(points.len(), &triangles),
            neighbors: vertex_neighbors(points.len(), &triangles),
            points,
            triangles,
            file_triangle,
            turned,
            point_of_vertex: welded.point_of_vertex,
            triangle_normals,
            triangle_areas,
            areas,
        })
    }

    /// Converts a point of the file to this surface's coordinates.
    pub fn in_frame(&self, point: [f64; 3]) -> DVec3 {
        (DVec3::from_array(point) - self.center) / self.diagonal
    }

    /// Converts a point of this surface to the file's coordinates.
    pub fn to_file(&self, point: DVec3) -> DVec3 {
        point * self.diagonal + self.center
    }

    /// The closest point of the surface, if it is nearer than `reach`.
    pub fn closest(&self, query: DVec3, reach: f64) -> Option<Closest> {
        self.tree.closest(query.to_array(), reach)
    }

    /// Area-weighted unit normals for vertices that lie at `points` (zero where the triangles cancel).
    pub fn normals_at(&self, points: &[DVec3]) -> Vec<DVec3> {
        normals(points, &self.triangles)
    }

    /// The number of components.
    pub fn components(&self) -> usize {
        self.component.iter().max().map_or(0, |c| *c as usize + 1)
    }

    /// The component of a triangle.
    pub fn component_of(&self, triangle: u32) -> u32 {
        self.component[self.triangles[triangle as usize][0] as usize]
    }

    /// The vertices that share an edge with `v`.
    pub fn neighbors(&self, v: usize) -> &[u32] {
        self.neighbors.row(v)
    }

    /// Converts a point of this surface to a point of the file's mesh.
    pub fn in_file(&self, at: &SurfacePoint) -> SurfacePoint {
        let triangle = self.file_triangle[at.triangle as usize];
        SurfacePoint { triangle, ..self.of_file(at.triangle, at.weights) }
    }

    /// The point of this surface's `triangle` that has these `weights` in the file.
    pub fn of_file(&self, triangle: u32, mut weights: [f64; 3]) -> SurfacePoint {
        if self.turned[triangle as usize] {
            weights.swap(1, 2);
        }
        SurfacePoint { triangle, weights }
    }

    /// Whether a surface point lies on an open edge.
    pub fn on_boundary(&self, at: &SurfacePoint) -> bool {
        let corners = self.triangles[at.triangle as usize];
        (0..3).any(|i| {
            at.weights[i] < 1e-9
                && self.boundary[corners[(i + 1) % 3] as usize]
                && self.boundary[corners[(i + 2) % 3] as usize]
        })
    }

    /// Interpolated vertex normal of a surface point.
    pub fn smooth_normal(&self, at: &SurfacePoint) -> DVec3 {
        let corners = self.triangles[at.triangle as usize];
        let n: DVec3 = (0..3).map(|i| self.normals[corners[i] as usize] * at.weights[i]).sum();
        n.try_normalize().unwrap_or(self.triangle_normals[at.triangle as usize])
    }

    /// Whether a triangle faces away from the sum of the smooth normals at its corners: it is folded over in the file.
    pub fn is_turned_over(&self, triangle: usize) -> bool {
        let up: DVec3 = self.triangles[triangle].iter().map(|v| self.normals[*v as usize]).sum();
        self.triangle_normals[triangle].dot(up) < 0.0
    }

    /// Total area, in squared diagonals.
    pub fn area(&self) -> f64 {
        self.triangle_areas.iter().sum()
    }

    /// Area-weighted second moments about the center.
    pub fn second_moments(&self) -> [[f64; 3]; 3] {
        let mut m = [[0.0; 3]; 3];
        for (t, area) in self.triangles.iter().zip(&self.triangle_areas) {
            let [a, b, c] = t.map(|v| self.points[v as usize]);
            let s = a + b + c;
            // ∫ x xᵀ over a triangle = area/12 (Σ p pᵀ + s sᵀ).
            for p in [a, b, c, s] {
                for i in 0..3 {
                    for j in 0..3 {
                        m[i][j] += area / 12.0 * p[i] * p[j];
                    }
                }
            }
        }
        m
    }
}

fn file_point(mesh: &TriMesh, v: u32) -> DVec3 {
    DVec3::from_array(mesh.positions[v as usize])
}

fn check(mesh: &TriMesh, side: Side) -> Result<(), MatchError> {
    if mesh.positions.len() >= u32::MAX as usize || mesh.triangles.len() >= u32::MAX as usize {
        return Err(MatchError::TooLarge(side));
    }
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|v| **v as usize >= mesh.positions.len()) {
            let vertices = mesh.positions.len();
            return Err(MatchError::IndexOutOfRange { side, triangle, vertex, vertices });
        }
    }
    match mesh.positions.iter().position(|p| !p.iter().all(|x| x.is_finite() && x.abs() < 1e150)) {
        Some(vertex) => Err(MatchError::NotFinite { side, vertex }),
        None => Ok(()),
    }
}

struct Welded {
    point_of_vertex: Vec<Option<u32>>,
    /// For each welded vertex, one of its file vertices.
    file_vertex: Vec<u32>,
    /// Triangles with three distinct corners and some area, none that repeats an earlier one.
    kept: Vec<u32>,
}

/// Merges vertices at equal positions and keeps the triangles that have area.
fn weld(mesh: &TriMesh) -> Welded {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for &v in mesh.triangles.iter().flatten() {
        low = low.min(file_point(mesh, v));
        high = high.max(file_point(mesh, v));
    }
    let size = (high - low).length();
    let place = places(&mesh.positions);
    let repeated = repeated_triangles(mesh, &place);
    let kept: Vec<u32> = (0..mesh.triangles.len() as u32)
        .filter(|&t| !repeated[t as usize])
        .filter(|&t| {
            let [a, b, c] = mesh.triangles[t as usize].map(|v| file_point(mesh, v) / size);
            (b - a).cross(c - a).length() > 1e-16
        })
        .collect();
    let mut point_of_place = vec![None; mesh.positions.len()];
    let mut file_vertex = Vec::new();
    for &t in &kept {
        for v in mesh.triangles[t as usize] {
            point_of_place[place[v as usize] as usize].get_or_insert_with(|| {
                file_vertex.push(v);
                file_vertex.len() as u32 - 1
            });
        }
    }
    // A vertex that only triangles without area use follows another one in its place, as in the operator.
    let point_of_vertex = place.iter().map(|place| point_of_place[*place as usize]).collect();
    Welded { point_of_vertex, file_vertex, kept }
}

/// Area-weighted centroid and bounding-box diagonal of the kept triangles.
fn extent(mesh: &TriMesh, kept: &[u32]) -> Option<(DVec3, f64)> {
    let origin = file_point(mesh, mesh.triangles[*kept.first()? as usize][0]);
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for &v in kept.iter().flat_map(|t| &mesh.triangles[*t as usize]) {
        low = low.min(file_point(mesh, v));
        high = high.max(file_point(mesh, v));
    }
    let diagonal = (high - low).length();
    let (mut area, mut moment) = (0.0, DVec3::ZERO);
    for &t in kept {
        let [a, b, c] = mesh.triangles[t as usize].map(|v| (file_point(mesh, v) - origin) / diagonal);
        let weight = (b - a).cross(c - a).length();
        area += weight;
        moment += (a + b + c) / 3.0 * weight;
    }
    let center = origin + moment / area * diagonal;
    (diagonal > 0.0 && diagonal.is_finite() && center.is_finite()).then_some((center, diagonal))
}

fn normals(points: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    vertex_normals(&arrays(points), triangles).into_iter().map(DVec3::from_array).collect()
}

/// The tree of `triangles` over `points`.
pub(crate) fn triangle_tree(points: &[DVec3], triangles: &[[u32; 3]]) -> TriangleTree {
    TriangleTree::new(&arrays(points), triangles)
}

fn arrays(points: &[DVec3]) -> Vec<[f64; 3]> {
    points.iter().map(|p| p.to_array()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> TriMesh {
        TriMesh { positions: positions.to_vec(), triangles: triangles.to_vec(), ..Default::default() }
    }

    #[test]
    fn seams_are_welded_and_slivers_dropped() {
        let m = mesh(
            &[
                [0.0; 3],
                [1.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
                [1.0, 0.0, 0.0],
                [1.0, 1.0, 0.0],
                [-0.0, 1.0, 0.0],
                [9.0; 3],
            ],
            &[[0, 1, 2], [3, 4, 5], [0, 1, 3], [0, 0, 1]],
        );
        let s = UnitSurface::new(&m, Side::Shape).unwrap();
        assert_eq!((s.points.len(), s.triangles.len()), (4, 2));
        assert_eq!(s.point_of_vertex[1], s.point_of_vertex[3]);
        assert_eq!(s.point_of_vertex[6], None);
        assert!(s.boundary.iter().all(|b| *b) && s.component.iter().all(|c| *c == 0));
        assert!((s.diagonal - 2.0_f64.sqrt()).abs() < 1e-15 && (s.area() - 0.5).abs() < 1e-15);
    }

    #[test]
    fn a_vertex_without_triangles_of_area_follows_another_one_in_its_place() {
        // Vertices 4 and 5 lie in the places of 0 and 3; a sliver uses the first, and no triangle the second.
        let corners =
            [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [-0.0; 3], [1.0, 1.0, 0.0]];
        let m = mesh(&corners, &[[0, 1, 2], [2, 1, 3], [4, 1, 1]]);
        let s = UnitSurface::new(&m, Side::Shape).unwrap();
        assert_eq!(s.points.len(), 4);
        assert_eq!(s.point_of_vertex[4], s.point_of_vertex[0]);
        assert_eq!(s.point_of_vertex[5], s.point_of_vertex[3]);
        let in_operator = chladni_mesh::surface::weld(&m).operator_vertex;
        for (v, point) in s.point_of_vertex.iter().enumerate() {
            assert_eq!(point.is_some(), in_operator[v].is_some());
        }
    }

    #[test]
    fn two_sided_faces_count_once() {
        let mut both = chladni_mesh::samples::icosphere(1);
        both.triangles.extend_from_within(..);
        both.triangles[80..].iter_mut().for_each(|t| t.swap(0, 1));
        let s = UnitSurface::facing_outward(&both, Side::Shape).unwrap();
        assert_eq!(s.file_triangle, (0..80).collect::<Vec<u32>>());
        assert!(s.normals.iter().zip(&s.points).all(|(n, p)| n.dot(p.normalize()) > 0.9));
    }

    #[test]
    fn a_point_of_a_turned_triangle_is_the_same_point_in_the_file() {
        let mut m = chladni_mesh::samples::icosphere(2);
        m.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        let query = DVec3::new(0.3, -0.5, 0.9);
        let s = UnitSurface::facing_outward(&m, Side::Shape).unwrap();
        assert!(s.turned.iter().all(|turned| *turned));
        let at = s.closest(query, f64::INFINITY).unwrap();
        assert!(s.smooth_normal(&at.on).dot(query) > 0.0);
        let on = s.in_file(&at.on);
        assert_eq!(s.of_file(at.on.triangle, on.weights), at.on);
        let in_file = on.position(&m.triangles, |v| m.positions[v as usize]).unwrap();
        assert!(s.in_frame(in_file).distance(DVec3::from_array(at.point)) < 1e-12);
        assert!(UnitSurface::new(&m, Side::Shape).unwrap().smooth_normal(&at.on).dot(query) < 0.0);
    }

    #[test]
    fn what_is_no_surface_is_an_error() {
        let flat = [[0.0; 3], [1.0; 3], [2.0; 3]];
        for (m, error) in [
            (mesh(&[], &[]), MatchError::NoSurface(Side::Shape)),
            (mesh(&flat, &[[0, 1, 2]]), MatchError::NoSurface(Side::Shape)),
            (mesh(&[[5.0; 3]; 3], &[[0, 1, 2]]), MatchError::NoSurface(Side::Shape)),
            (mesh(&[[f64::NAN; 3]], &[]), MatchError::NotFinite { side: Side::Shape, vertex: 0 }),
            (
                mesh(&flat, &[[0, 1, 7]]),
                MatchError::IndexOutOfRange { side: Side::Shape, triangle: 0, vertex: 7, vertices: 3 },
            ),
        ] {
            assert_eq!(UnitSurface::new(&m, Side::Shape).unwrap_err(), error);
        }
    }
}
