//! Thin plates that lie flat, y up: sheets of one side, whose border vibrates freely.

use std::f64::consts::TAU;

use super::surfaces::grid_square;
use crate::TriMesh;

/// Cells on a side of the square plate.
const CELLS: u32 = 100;
/// Rings of the round plate.
const RINGS: u32 = 57;

/// A square plate of side 2.
pub(crate) fn square_plate() -> TriMesh {
    let mut plate = grid_square(CELLS);
    plate.positions.iter_mut().for_each(|[x, y, z]| (*x, *y, *z) = (2.0 * *x - 1.0, 0.0, 1.0 - 2.0 * *y));
    plate
}

/// A round plate of radius 1: ring i has 6 i vertices, so that all triangles are about of one size.
pub(crate) fn round_plate() -> TriMesh {
    let first = |ring: u32| if ring == 0 { 0 } else { 1 + 3 * ring * (ring - 1) };
    let mut plate = TriMesh { positions: vec![[0.0; 3]], ..TriMesh::default() };
    for ring in 1..=RINGS {
        let radius = f64::from(ring) / f64::from(RINGS);
        plate.positions.extend((0..6 * ring).map(|i| {
            let (s, c) = (TAU * f64::from(i) / f64::from(6 * ring)).sin_cos();
            [radius * c, 0.0, -radius * s]
        }));
        // A sixth of the ring has one vertex more than that of the ring within.
        for sixth in 0..6 {
            let outer = |i: u32| first(ring) + (sixth * ring + i) % (6 * ring);
            let inner = |i: u32| match ring {
                1 => 0,
                _ => first(ring - 1) + (sixth * (ring - 1) + i) % (6 * (ring - 1)),
            };
            for i in 0..ring {
                plate.triangles.push([inner(i), outer(i), outer(i + 1)]);
                if i + 1 < ring {
                    plate.triangles.push([inner(i), outer(i + 1), inner(i + 1)]);
                }
            }
        }
    }
    plate
}
