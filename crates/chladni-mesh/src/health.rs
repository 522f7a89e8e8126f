//! The health report: which defects a mesh has.

use serde::Serialize;

use crate::TriMesh;
use crate::surface::vec3::{cross, dot, length, sub};
use crate::surface::{
    Bounds, HalfEdge, Pieces, Rows, corners, doubled_area_normal, inward_triangles, of_triangles, places,
    repeated_faces, repeated_known, sorted_half_edges, vertex_faces, weld_known,
};

/// Counts and measures of a mesh as its file stores it, and of what welding would change.
///
/// Serialized with the names of the fields.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HealthReport {
    /// Vertices in the file, used or not.
    pub vertices: usize,
    /// Triangles, after polygons were divided.
    pub triangles: usize,
    /// Faces in the file, whatever their number of corners.
    pub polygons: usize,
    /// How the faces are connected, as stored.
    #[serde(flatten)]
    pub topology: Topology,
    /// Triangles of no area at all, those of divided polygons and those with repeated corners included.
    pub degenerate_triangles: usize,
    /// Vertices whose position an earlier vertex has too.
    pub duplicate_vertices: usize,
    /// Vertices that no triangle uses.
    pub unreferenced_vertices: usize,
    /// Triangles that repeat an earlier one between the same places, from either side, or whose face does; harmonics,
    /// matches and normals of exports take such a triangle or face once.
    pub duplicate_triangles: usize,
    /// Triangles of the welded mesh that face inward, or against most of those around them, as
    /// [`inward_triangles`] finds them: matches and drawings, among others, turn them round.
    pub inward_triangles: usize,
    /// Least corner of the bounding box of all used vertices, in file units.
    pub bounds_min: [f64; 3],
    /// Greatest corner of the bounding box of all used vertices, in file units.
    pub bounds_max: [f64; 3],
    /// Length of the bounding box's diagonal, in file units.
    pub diagonal: f64,
    /// Sum of the triangles' areas, duplicate ones included, in squared file units.
    pub area: f64,
    /// Enclosed volume, in cubed file units, positive where triangles face outward; `None`
    /// unless the welded mesh is closed and evenly oriented, without polygons that share a triangle.
    pub volume: Option<f64>,
    /// The mesh with coincident vertices merged, as the operator sees it.
    pub welded: Welded,
}

/// How faces are connected: polygons as stored, not their triangles, whose diagonals may fall on other edges.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Topology {
    /// Pieces that share no vertex.
    pub components: usize,
    /// Connected pieces of the boundary, the edges of exactly one face.
    pub boundary_loops: usize,
    /// Edges of more than two faces.
    pub nonmanifold_edges: usize,
    /// Vertices whose faces fall into several fans that share no edge.
    pub nonmanifold_vertices: usize,
    /// Edges whose two faces run through them in the same direction.
    pub misoriented_edges: usize,
    /// Handles, summed over components; `None` unless manifold and evenly oriented.
    pub genus: Option<usize>,
}

/// A mesh after welding.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Welded {
    /// Operator vertices.
    pub vertices: usize,
    /// Triangles with three different corners, less repeated ones and those of pieces without area.
    pub triangles: usize,
    /// How faces are connected, those of pieces without area included.
    #[serde(flatten)]
    pub topology: Topology,
}

impl HealthReport {
    /// Examines `mesh`.
    pub fn of(mesh: &TriMesh) -> Self {
        let place = places(&mesh.positions);
        let repeated_faces = repeated_faces(mesh, &place);
        let repeated = repeated_known(mesh, &place, &repeated_faces);
        let welded = weld_known(mesh, &place, &repeated);
        let mut used = vec![false; mesh.positions.len()];
        for &v in mesh.triangles.iter().flatten() {
            used[v as usize] = true;
        }
        let used_positions = mesh.positions.iter().zip(&used).filter(|(_, used)| **used);
        let mut bounds = Bounds::of(used_positions.map(|(p, _)| *p));
        if !bounds.low[0].is_finite() {
            bounds = Bounds { low: [0.0; 3], high: [0.0; 3] };
        }
        let areas =
            mesh.triangles.iter().map(|t| 0.5 * length(doubled_area_normal(corners(&mesh.positions, t))));
        let (mut area, mut degenerate_triangles) = (0.0, 0);
        for a in areas {
            area += a;
            degenerate_triangles += usize::from(a == 0.0);
        }
        let faces = (0..mesh.face_count()).map(|f| mesh.face(f));
        let welded_faces = welded_faces(mesh, &place, &repeated_faces);
        let welded_topology =
            Topology::of(mesh.positions.len(), (0..welded_faces.len()).map(|f| welded_faces.row(f)));
        // The welded triangles leave a gap where polygons share one.
        let is_of_faces = repeated == of_triangles(mesh, &repeated_faces);
        let closed = is_of_faces && welded_topology.genus.is_some() && welded_topology.boundary_loops == 0;
        Self {
            vertices: mesh.positions.len(),
            triangles: mesh.triangles.len(),
            polygons: mesh.face_count(),
            topology: Topology::of(mesh.positions.len(), faces),
            degenerate_triangles,
            duplicate_vertices: duplicate_count(&place),
            unreferenced_vertices: used.iter().filter(|used| !**used).count(),
            duplicate_triangles: repeated.iter().filter(|repeated| **repeated).count(),
            inward_triangles: inward_triangles(&welded.positions, &welded.triangles)
                .into_iter()
                .filter(|inward| *inward)
                .count(),
            bounds_min: bounds.low,
            bounds_max: bounds.high,
            diagonal: bounds.diagonal(),
            area,
            volume: closed.then(|| volume(&welded.positions, &welded.triangles)),
            welded: Welded {
                vertices: welded.positions.len(),
                triangles: welded.triangles.len(),
                topology: welded_topology,
            },
        }
    }

    /// Examines `mesh`, which the nodes of a glTF file may have placed: duplicate vertices are counted at the `stored`
    /// positions, those before that, where there are any (see [`Loaded`](crate::Loaded)).
    pub fn of_placed(mesh: &TriMesh, stored: Option<&[[f64; 3]]>) -> Self {
        let mut report = Self::of(mesh);
        if let Some(stored) = stored {
            report.duplicate_vertices = duplicate_count(&places(stored));
        }
        report
    }
}

/// Vertices whose position an earlier vertex has too.
fn duplicate_count(place: &[u32]) -> usize {
    place.iter().zip(0_u32..).filter(|&(&first, v)| first != v).count()
}

/// The faces over each position's first vertex, those that are not `repeated`, without repeated corners; those left with
/// less than three are gone.
fn welded_faces(mesh: &TriMesh, place: &[u32], repeated: &[bool]) -> Rows {
    let mut rows = Rows { starts: vec![0], items: Vec::new() };
    for f in (0..mesh.face_count()).filter(|f| !repeated[*f]) {
        let start = rows.items.len();
        for &v in mesh.face(f) {
            let v = place[v as usize];
            if rows.items[start..].last() != Some(&v) {
                rows.items.push(v);
            }
        }
        while rows.items.len() > start + 1 && rows.items.last() == Some(&rows.items[start]) {
            rows.items.pop();
        }
        if rows.items.len() < start + 3 {
            rows.items.truncate(start);
        } else {
            rows.starts.push(rows.items.len() as u32);
        }
    }
    rows
}

/// Signed volume of a closed surface, summed about its first vertex for accuracy.
fn volume(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> f64 {
    let origin = positions.first().copied().unwrap_or_default();
    let cone = |t: &[u32; 3]| {
        let [a, b, c] = corners(positions, t).map(|p| sub(p, origin));
        dot(a, cross(b, c)) / 6.0
    };
    triangles.iter().map(cone).sum()
}

impl Topology {
    /// Examines `faces`, given by their corners, over vertices less than `vertex_count`.
    ///
    /// # Panics
    /// If a face names a vertex that is not there.
    pub fn of<'a>(vertex_count: usize, faces: impl Iterator<Item = &'a [u32]> + Clone) -> Self {
        let sides = sorted_half_edges(faces.clone());
        let mut pieces = Pieces::new(vertex_count);
        let mut boundary = Pieces::new(vertex_count);
        let (mut edges, mut nonmanifold_edges, mut misoriented_edges) = (0, 0, 0);
        let mut used = vec![false; vertex_count];
        let mut on_boundary = vec![false; vertex_count];
        let mut face_count = 0;
        for face in faces.clone() {
            face_count += 1;
            for &v in face {
                used[v as usize] = true;
                pieces.join(face[0], v);
            }
        }
        for edge in sides.chunk_by(|a, b| a.ends == b.ends) {
            edges += 1;
            match edge {
                [only] => {
                    let [a, b] = only.ends;
                    boundary.join(a, b);
                    on_boundary[a as usize] = true;
                    on_boundary[b as usize] = true;
                }
                [a, b] => misoriented_edges += usize::from(a.forward == b.forward),
                _ => nonmanifold_edges += 1,
            }
        }
        let count = |pieces: &mut Pieces, members: &[bool]| {
            (0..vertex_count as u32).filter(|&v| members[v as usize] && pieces.root(v) == v).count()
        };
        let components = count(&mut pieces, &used);
        let boundary_loops = count(&mut boundary, &on_boundary);
        let nonmanifold_vertices = split_vertices(vertex_count, faces, &sides);
        let vertices = used.iter().filter(|used| **used).count();
        let sound = nonmanifold_edges == 0 && nonmanifold_vertices == 0 && misoriented_edges == 0;
        // Euler's formula, summed over components: V − E + F = 2c − 2g − b.
        let twice = 2 * components as i64 - boundary_loops as i64 - vertices as i64 + edges - face_count;
        let genus = (sound && twice >= 0 && twice % 2 == 0).then_some((twice / 2) as usize);
        Self { components, boundary_loops, nonmanifold_edges, nonmanifold_vertices, misoriented_edges, genus }
    }
}

/// Vertices whose faces are not all connected through edges at that vertex.
fn split_vertices<'a>(
    vertex_count: usize,
    faces: impl Iterator<Item = &'a [u32]> + Clone,
    sides: &[HalfEdge],
) -> usize {
    let around = vertex_faces(vertex_count, faces);
    // One set element per (vertex, face) pair: its place in `around`.
    let place = |v: u32, face: u32| {
        let row = around.row(v as usize);
        around.starts[v as usize] + row.partition_point(|&f| f < face) as u32
    };
    let mut fans = Pieces::new(around.items.len());
    for edge in sides.chunk_by(|a, b| a.ends == b.ends) {
        for other in &edge[1..] {
            for v in edge[0].ends {
                fans.join(place(v, edge[0].face), place(v, other.face));
            }
        }
    }
    let is_split = |v: &usize| {
        let mut members = around.starts[*v]..around.starts[v + 1];
        let first = members.next().map(|first| fans.root(first));
        members.any(|member| Some(fans.root(member)) != first)
    };
    (0..vertex_count).filter(is_split).count()
}
