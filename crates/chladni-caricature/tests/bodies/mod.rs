//! A small lumpy shape.

use chladni_mesh::{TriMesh, samples::icosphere};

/// A lumpy ball of 642 vertices, away from the origin.
pub fn lump() -> TriMesh {
    let mut mesh = icosphere(3);
    for p in &mut mesh.positions {
        let [x, y, z] = *p;
        let r = 30.0 + 6.0 * (3.0 * x).sin() + 4.0 * y * z + 2.0 * (7.0 * z).cos() * x;
        *p = [100.0 + r * x, r * y, 0.7 * r * z - 5.0];
    }
    mesh
}
