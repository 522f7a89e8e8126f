//! Each format that is written, and what it holds.

use chladni_mesh::{Appearance, Format, TriMesh, far_center, read_mesh, write_mesh};

/// The greatest coordinate that is read and written.
pub(crate) const GREATEST: f64 = 1e75;
/// The least extent that is written with 32 bits.
const LEAST_EXTENT: f64 = 1e-30;

/// Writes `mesh` in each format that is written, and reads it back as far as the format holds it. What is refused must be.
pub(crate) fn exported(mesh: &TriMesh) {
    for format in [Format::Obj, Format::Ply, Format::Stl, Format::Glb] {
        let bytes = match write_mesh(mesh, format) {
            Ok(bytes) => bytes,
            Err(error) => {
                assert!(may_refuse(mesh, format), "{error}");
                continue;
            }
        };
        let back = read_mesh(&bytes, format).expect("what was written can be read").mesh;
        assert_eq!(back.triangles.len(), mesh.triangles.len(), "{format}");
        if format == Format::Stl {
            let single = mesh.positions.iter().map(|p| p.map(|x| f64::from(x as f32))).collect();
            let single =
                TriMesh { positions: single, triangles: mesh.triangles.clone(), ..TriMesh::default() };
            same_corners(&back, &single);
            continue;
        }
        assert_eq!(back.positions, held(mesh, format), "{format}");
        // Materials sort the triangles of a GLB, and a polygon may be divided otherwise.
        if mesh.appearance == Appearance::default() {
            assert_eq!(back.triangles, mesh.triangles, "{format}");
        }
    }
}

/// The positions as `format` holds them.
fn held(mesh: &TriMesh, format: Format) -> Vec<[f64; 3]> {
    if format != Format::Glb {
        return mesh.positions.clone();
    }
    let center = far_center(&mesh.positions).unwrap_or_default();
    let of_axis = |p: &[f64; 3], i: usize| f64::from((p[i] - center[i]) as f32) + center[i];
    mesh.positions.iter().map(|p| std::array::from_fn(|i| of_axis(p, i))).collect()
}

/// Whether a coordinate is beyond what is read, or the shape is too large or too small for a format of 32 bits.
fn may_refuse(mesh: &TriMesh, format: Format) -> bool {
    let (mut greatest, mut is_number) = (0.0_f64, true);
    for x in mesh.positions.as_flattened() {
        greatest = greatest.max(x.abs());
        is_number &= !x.is_nan();
    }
    let used = || mesh.triangles.as_flattened().iter().map(|v| mesh.positions[*v as usize]);
    let extent = |axis: usize| {
        let (low, high) = used()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p[axis]), high.max(p[axis])));
        high - low
    };
    let is_single = matches!(format, Format::Stl | Format::Glb);
    let single = || greatest >= f64::from(f32::MAX) || (0..3).all(|axis| extent(axis) < LEAST_EXTENT);
    !is_number || greatest > GREATEST || (is_single && single())
}

/// STL has no vertices of its own: the triangles have the same corners.
pub(crate) fn same_corners(a: &TriMesh, b: &TriMesh) {
    let corners = |mesh: &TriMesh| {
        let at = |v: u32| mesh.positions[v as usize];
        mesh.triangles.iter().map(|triangle| triangle.map(at)).collect::<Vec<_>>()
    };
    assert_eq!(corners(a), corners(b), "STL");
}
