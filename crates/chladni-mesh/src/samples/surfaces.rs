//! Surfaces with a formula: for tests, and as templates.

use std::f64::consts::TAU;

use crate::TriMesh;
use crate::surface::subdivided;
use crate::surface::vec3::unit;

fn mesh(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> TriMesh {
    TriMesh { positions, triangles, ..TriMesh::default() }
}

/// The two triangles of a quadrilateral, counter-clockwise.
fn quad([a, b, c, d]: [u32; 4]) -> [[u32; 3]; 2] {
    [[a, b, c], [a, c, d]]
}

/// The unit sphere as an icosahedron whose triangles were cut in four `subdivisions` times:
/// 10·4^subdivisions + 2 vertices. At most 8 subdivisions are made.
pub fn icosphere(subdivisions: u32) -> TriMesh {
    let g = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut positions: Vec<[f64; 3]> = Vec::new();
    for (one, golden) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
        positions.extend([[0.0, one, golden], [one, golden, 0.0], [golden, 0.0, one]].map(unit));
    }
    // Neighbors are a golden edge apart; of the two orders the outward one is a face.
    let edge = 2.0 / (g * 5.0_f64.sqrt()).sqrt();
    let near = |a: usize, b: usize| {
        let d: f64 = (0..3).map(|i| (positions[a][i] - positions[b][i]).powi(2)).sum();
        (d.sqrt() - edge).abs() < 1e-9
    };
    let mut triangles = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(c, a) {
                    let [p, q, r] = [a, b, c].map(|v| positions[v]);
                    let n = crate::surface::doubled_area_normal([p, q, r]);
                    let outward = crate::surface::vec3::dot(n, p) > 0.0;
                    triangles.push(if outward { [a, b, c] } else { [a, c, b] }.map(|v| v as u32));
                }
            }
        }
    }
    for _ in 0..subdivisions.min(8) {
        triangles = subdivided(&mut positions, &triangles);
        for p in &mut positions {
            *p = unit(*p);
        }
    }
    mesh(positions, triangles)
}

/// The unit sphere by latitude and longitude: `rings` − 1 circles of `segments` vertices and the
/// two poles. At least 2 rings and 3 segments are made.
pub fn uv_sphere(rings: u32, segments: u32) -> TriMesh {
    let (rings, segments) = (rings.max(2), segments.max(3));
    let mut positions = vec![[0.0, 0.0, 1.0]];
    for ring in 1..rings {
        let (s, c) = (TAU / 2.0 * f64::from(ring) / f64::from(rings)).sin_cos();
        positions.extend((0..segments).map(|segment| {
            let (y, x) = (TAU * f64::from(segment) / f64::from(segments)).sin_cos();
            [s * x, s * y, c]
        }));
    }
    let south = positions.len() as u32;
    positions.push([0.0, 0.0, -1.0]);
    let at = |ring: u32, segment: u32| 1 + (ring - 1) * segments + segment % segments;
    let mut triangles = Vec::new();
    for s in 0..segments {
        triangles.push([0, at(1, s), at(1, s + 1)]);
        for ring in 1..rings - 1 {
            triangles.extend(quad([at(ring, s), at(ring + 1, s), at(ring + 1, s + 1), at(ring, s + 1)]));
        }
        triangles.push([at(rings - 1, s), south, at(rings - 1, s + 1)]);
    }
    mesh(positions, triangles)
}

/// The unit square [0, 1]² at z = 0 in `n`×`n` cells (at least 1), whose diagonals alternate so
/// that no direction is favored.
pub fn grid_square(n: u32) -> TriMesh {
    let n = n.max(1);
    let at = |i: u32, j: u32| j * (n + 1) + i;
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for j in 0..=n {
        for i in 0..=n {
            positions.push([f64::from(i) / f64::from(n), f64::from(j) / f64::from(n), 0.0]);
            if i < n && j < n {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                triangles.extend(if (i + j).is_multiple_of(2) {
                    quad([a, b, c, d])
                } else {
                    quad([b, c, d, a])
                });
            }
        }
    }
    mesh(positions, triangles)
}

/// A torus about the z axis of tube radius `r` (the other radius is 1) in `major`×`minor`
/// cells, at least 3 each.
pub fn torus(r: f64, major: u32, minor: u32) -> TriMesh {
    let (major, minor) = (major.max(3), minor.max(3));
    let at = |i: u32, j: u32| (i % major) * minor + j % minor;
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..major {
        let (y, x) = (TAU * f64::from(i) / f64::from(major)).sin_cos();
        for j in 0..minor {
            let (s, c) = (TAU * f64::from(j) / f64::from(minor)).sin_cos();
            positions.push([(1.0 + r * c) * x, (1.0 + r * c) * y, r * s]);
            triangles.extend(quad([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]));
        }
    }
    mesh(positions, triangles)
}

/// A Möbius strip of middle radius 1 and the given `width` in `around`×`across` cells (at least
/// 3 and 1): one side, one boundary, no orientation.
pub fn moebius(width: f64, around: u32, across: u32) -> TriMesh {
    let (around, across) = (around.max(3), across.max(1));
    // Past one turn the strip comes back upside down.
    let at = |i: u32, j: u32| if i < around { i * (across + 1) + j } else { across - j };
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..around {
        let turn = TAU * f64::from(i) / f64::from(around);
        for j in 0..=across {
            let w = width * (f64::from(j) / f64::from(across) - 0.5);
            let r = 1.0 + w * (0.5 * turn).cos();
            positions.push([r * turn.cos(), r * turn.sin(), w * (0.5 * turn).sin()]);
            if j < across {
                triangles.extend(quad([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]));
            }
        }
    }
    mesh(positions, triangles)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::HealthReport;

    fn sound(mesh: &TriMesh, genus: Option<usize>, loops: usize) -> HealthReport {
        let report = HealthReport::of(mesh);
        assert_eq!(report.topology.genus, genus);
        assert_eq!(report.topology.boundary_loops, loops);
        assert_eq!(report.topology.components, 1);
        assert_eq!(report.degenerate_triangles + report.duplicate_vertices + report.unreferenced_vertices, 0);
        report
    }

    #[test]
    fn they_are_what_they_are_called() {
        let sphere = sound(&icosphere(4), Some(0), 0);
        assert_eq!(sphere.vertices, 2562);
        let volume = 4.0 / 3.0 * PI;
        assert!((sphere.volume.unwrap() / volume - 1.0).abs() < 5e-3);
        let sphere = sound(&uv_sphere(32, 64), Some(0), 0);
        assert!((sphere.volume.unwrap() / volume - 1.0).abs() < 1e-2);
        assert!((sound(&grid_square(8), Some(0), 1).area - 1.0).abs() < 1e-12);
        let torus = sound(&torus(0.3, 96, 48), Some(1), 0);
        assert!((torus.volume.unwrap() / (2.0 * PI * PI * 0.09) - 1.0).abs() < 1e-2);
        sound(&moebius(0.4, 48, 6), None, 1);
    }
}
