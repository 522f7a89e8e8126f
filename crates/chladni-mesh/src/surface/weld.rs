//! Coincident vertices merged, for the operator only.

use std::collections::{HashMap, HashSet};

use rayon::slice::ParallelSliceMut;

use super::leave_out_flat;
use crate::TriMesh;

/// The operator's view of a mesh: exactly equal positions are one vertex, and only vertices
/// that a triangle uses are there. The file's own vertices are reached through
/// [`operator_vertex`](Self::operator_vertex).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Weld {
    /// N positions, each different, in the order in which the file first names them.
    pub positions: Vec<[f64; 3]>,
    /// Triangles of indices < N with three different corners, in the order of the file. A
    /// triangle that names one position twice has neither area nor a normal and is left out, and so are those that
    /// [repeat](repeated_triangles) an earlier one, whose normals might cancel, and connected components without area.
    pub triangles: Vec<[u32; 3]>,
    /// For each of the mesh's n vertices its operator vertex, `None` where no triangle in
    /// [`triangles`](Self::triangles) uses its position.
    pub operator_vertex: Vec<Option<u32>>,
    /// The number of components that were left out, since they have no area; 0 where none has.
    pub without_area: usize,
}

/// Merges exactly equal positions of `mesh` (0 equals −0) and drops unused vertices.
///
/// A mesh without duplicate, unreferenced or collapsed parts comes back as it is, in its order.
pub fn weld(mesh: &TriMesh) -> Weld {
    let place = places(&mesh.positions);
    weld_known(mesh, &place, &repeated_triangles(mesh, &place))
}

/// As [`weld`], with what [`places`] and [`repeated_triangles`] say of `mesh`.
pub(crate) fn weld_known(mesh: &TriMesh, place: &[u32], repeated: &[bool]) -> Weld {
    let mut triangles = single_triangles(mesh, place, repeated);
    let without_area = leave_out_flat(&mesh.positions, &mut triangles);
    let mut used = vec![false; mesh.positions.len()];
    for &v in triangles.iter().flatten() {
        used[v as usize] = true;
    }
    // A position is identified by its first vertex, so one pass in file order numbers all of them.
    let mut row = vec![u32::MAX; mesh.positions.len()];
    let mut positions = Vec::new();
    for (v, &p) in mesh.positions.iter().enumerate() {
        if used[v] {
            row[v] = positions.len() as u32;
            positions.push(p);
        }
    }
    for v in triangles.iter_mut().flatten() {
        *v = row[*v as usize];
    }
    let operator_vertex = place.iter().map(|&v| used[v as usize].then(|| row[v as usize])).collect();
    Weld { positions, triangles, operator_vertex, without_area }
}

/// For each vertex the first vertex with exactly the same position (0 equals −0).
pub fn places(positions: &[[f64; 3]]) -> Vec<u32> {
    let mut first = HashMap::with_capacity(positions.len());
    // Adding 0.0 turns −0 into 0.
    let key = |p: &[f64; 3]| p.map(|x| (x + 0.0).to_bits());
    positions.iter().zip(0_u32..).map(|(p, v)| *first.entry(key(p)).or_insert(v)).collect()
}

/// The triangles of `mesh` over the first vertices of their places, which [`places`] gives: those with three different
/// corners, without those of repeated faces.
pub(crate) fn seamless_triangles(mesh: &TriMesh, place: &[u32]) -> Vec<[u32; 3]> {
    single_triangles(mesh, place, &repeated_triangles(mesh, place))
}

fn single_triangles(mesh: &TriMesh, place: &[u32], repeated: &[bool]) -> Vec<[u32; 3]> {
    let single = mesh.triangles.iter().zip(repeated).filter(|(_, repeated)| !**repeated);
    let placed = single.map(|(triangle, _)| triangle.map(|v| place[v as usize]));
    placed.filter(|[a, b, c]| a != b && b != c && c != a).collect()
}

/// The triangles of `mesh` for pictures, in its order: [repeated](repeated_triangles) ones collapse, since their normals
/// would cancel.
///
/// # Panics
/// If a face names a vertex that is not there.
pub fn drawn_triangles(mesh: &TriMesh) -> Vec<[u32; 3]> {
    let repeated = repeated_triangles(mesh, &places(&mesh.positions));
    let drawn = |(triangle, repeated): (&[u32; 3], bool)| if repeated { [triangle[0]; 3] } else { *triangle };
    mesh.triangles.iter().zip(repeated).map(drawn).collect()
}

/// For each triangle of `mesh` whether it, or its face, repeats an earlier one: it has the same corners in the same order,
/// forward or backward, by the `place` of each vertex: [`places`], or others that are equal where those are. Programs write
/// a two-sided face as such a pair, and polygons may share a triangle: divided, they have it twice.
///
/// # Panics
/// If a face names a vertex that is not there.
pub fn repeated_triangles(mesh: &TriMesh, place: &[u32]) -> Vec<bool> {
    repeated_known(mesh, place, &repeated_faces(mesh, place))
}

/// As [`repeated_triangles`], with what [`repeated_faces`] says of `mesh`.
pub(crate) fn repeated_known(mesh: &TriMesh, place: &[u32], of_faces: &[bool]) -> Vec<bool> {
    let mut repeated = of_triangles(mesh, of_faces);
    // Without polygons the faces are the triangles.
    if mesh.appearance.polygons.is_some() {
        // A polygon's triangles may collapse to one line, which nothing shares.
        let collapses = |t: usize| {
            let [a, b, c] = mesh.triangles[t].map(|v| place[v as usize]);
            a == b || b == c || c == a
        };
        mark_repeated(&mut repeated, |t| !collapses(t), |t| &mesh.triangles[t][..], place);
    }
    repeated
}

/// For each triangle of `mesh` what `of_faces` says of its face.
pub(crate) fn of_triangles(mesh: &TriMesh, of_faces: &[bool]) -> Vec<bool> {
    let mut of_triangles: Vec<bool> = mesh.triangle_corners().map(|(f, _)| of_faces[f]).collect();
    of_triangles.resize(mesh.triangles.len(), false);
    of_triangles
}

/// For each face of `mesh` whether it repeats an earlier one, however both are divided.
pub(crate) fn repeated_faces(mesh: &TriMesh, place: &[u32]) -> Vec<bool> {
    let mut repeated = vec![false; mesh.face_count()];
    mark_repeated(&mut repeated, |_| true, |f| mesh.face(f), place);
    repeated
}

/// Marks in `repeated`, of the faces that count and are not marked there, those that repeat an earlier one of them.
fn mark_repeated<'a>(
    repeated: &mut [bool],
    counts: impl Fn(usize) -> bool,
    face: impl Fn(usize) -> &'a [u32],
    place: &[u32],
) {
    let corners = |f: usize| face(f).iter().map(move |v| place[*v as usize]);
    // Few faces besides the same ones agree in the sum of their corners and in the least.
    let of_face =
        |f: usize| (corners(f).map(u64::from).sum::<u64>(), corners(f).min().unwrap_or(0), f as u32);
    let mut faces: Vec<(u64, u32, u32)> =
        (0..repeated.len()).filter(|f| !repeated[*f] && counts(*f)).map(of_face).collect();
    faces.par_sort_unstable();
    for alike in faces.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).filter(|alike| alike.len() > 1) {
        let mut known = HashSet::new();
        for &(_, _, f) in alike {
            repeated[f as usize] = !known.insert(cycle(corners(f as usize).collect()));
        }
    }
}

/// The corners of a face from the least one on, in the direction of the lesser neighbor.
fn cycle(mut corners: Vec<u32>) -> Vec<u32> {
    let least = (0..corners.len()).min_by_key(|i| corners[*i]).unwrap_or(0);
    corners.rotate_left(least);
    if corners.get(1) > corners.last() {
        corners[1..].reverse();
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seams_close_and_unused_vertices_go() {
        let mesh = TriMesh {
            positions: vec![
                [9.0; 3],
                [0.0, 0.0, 0.0],
                [1.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
                [1.0, -0.0, 0.0],
                [1.0, 1.0, 0.0],
            ],
            // The last triangle collapses: vertices 2 and 4 coincide.
            triangles: vec![[1, 2, 3], [3, 4, 5], [2, 4, 5]],
            ..TriMesh::default()
        };
        let welded = weld(&mesh);
        assert_eq!(welded.triangles, [[0, 1, 2], [2, 1, 3]]);
        assert_eq!(
            welded.positions,
            [mesh.positions[1], mesh.positions[2], mesh.positions[3], mesh.positions[5]]
        );
        assert_eq!(welded.operator_vertex, [None, Some(0), Some(1), Some(2), Some(1), Some(3)]);
    }

    #[test]
    fn two_sided_faces_count_once() {
        let ball = crate::samples::icosphere(1);
        let n = ball.positions.len() as u32;
        let mut both = ball.clone();
        both.positions.extend_from_within(..);
        both.triangles.extend(ball.triangles.iter().map(|[a, b, c]| [b + n, a + n, c + n]));
        let (single, welded) = (weld(&ball), weld(&both));
        assert_eq!((&welded.positions, &welded.triangles), (&single.positions, &single.triangles));
        assert_eq!(welded.operator_vertex[n as usize..], single.operator_vertex);
        let report = crate::HealthReport::of(&both);
        assert_eq!((report.duplicate_triangles, report.welded.topology.genus), (80, Some(0)));
        assert!(report.volume.is_some());
        let drawn = drawn_triangles(&both);
        let (front, back) = drawn.split_at(80);
        assert_eq!(front, ball.triangles);
        assert!(back.len() == 80 && back.iter().all(|[a, b, c]| a == b && b == c));
    }

    #[test]
    fn a_polygon_is_repeated_however_it_is_divided() {
        // A sloping square, the same from behind, which is divided along its other diagonal, and one that crosses itself.
        let obj = b"v 0 0 0\nv 1 0 1\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nf 4 3 2 1\nf 1 3 2 4\n";
        let mesh = crate::read_mesh(obj, crate::Format::Obj).unwrap().mesh;
        assert_eq!(repeated_faces(&mesh, &places(&mesh.positions)), [false, true, false]);
        // Of the one that crosses itself, one triangle is a half of the first square.
        assert_eq!(weld(&mesh).triangles.len(), 3);
    }

    #[test]
    fn a_triangle_that_two_polygons_share_counts_once_as_it_does_in_the_divided_mesh() {
        let obj = b"v 0 0 0\nv 1 -1 0\nv 2 0 0\nv 1 1 0\nv 1 1 1\nf 1 4 3 2\nf 1 2 3 5\n";
        let mesh = crate::read_mesh(obj, crate::Format::Obj).unwrap().mesh;
        assert_eq!(mesh.triangles, [[0, 3, 2], [0, 2, 1], [0, 1, 2], [0, 2, 4]]);
        let divided = TriMesh { appearance: crate::Appearance::default(), ..mesh.clone() };
        let single = weld(&mesh);
        assert_eq!(single, weld(&divided));
        assert_eq!(single.triangles, [[0, 3, 2], [0, 2, 1], [0, 2, 4]]);
        assert_eq!(drawn_triangles(&mesh), drawn_triangles(&divided));
        let counts = |mesh: &TriMesh| {
            let report = crate::HealthReport::of(mesh);
            (report.duplicate_triangles, report.welded.triangles)
        };
        assert_eq!([counts(&mesh), counts(&divided)], [(1, 3); 2]);
    }

    #[test]
    fn triangles_that_collapse_within_a_polygon_repeat_nothing() {
        // A cube; two corners of its front lie at a third.
        let corners =
            b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nv 1 0 1\nv 1 0 1\n";
        let faces = b"f 4 3 2 1\nf 5 6 9 10 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
        let mesh = crate::read_mesh(&[&corners[..], faces].concat(), crate::Format::Obj).unwrap().mesh;
        let report = crate::HealthReport::of(&mesh);
        assert_eq!(report.duplicate_triangles, 0);
        assert!(report.volume.is_some_and(|volume| (volume - 1.0).abs() < 1e-12));
    }

    #[test]
    fn polygons_that_share_a_triangle_enclose_no_volume() {
        // The polygons are closed, and without the shared triangle the surface is not.
        let obj = b"v 0 0 0\nv 1 -1 0\nv 2 0 0\nv 1 1 0\nv 1 1 1\nf 1 4 3 2\nf 1 2 3 5\nf 4 1 5\nf 3 4 5\n";
        let report = crate::HealthReport::of(&crate::read_mesh(obj, crate::Format::Obj).unwrap().mesh);
        assert_eq!((report.welded.topology.genus, report.welded.topology.boundary_loops), (Some(0), 0));
        assert_eq!(report.volume, None);
    }
}
