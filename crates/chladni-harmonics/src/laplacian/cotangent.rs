//! The Laplacian of the papers, from the cotangents of the mesh's own triangles.

use chladni_mesh::surface::vec3::{cross, dot, length, sub};

use super::cover::{Edges, ends};
use super::intrinsic::mixed_voronoi_parts;
use crate::SymmetricSparse;

/// The cotangents of a triangle are meaningless if its height is below this share of its longest side.
const FLAT: f64 = 1e-10;

/// Why a mesh has no cotangent Laplacian. Vertices are those of the operator.
#[derive(Debug, PartialEq)]
pub(crate) enum Refusal {
    /// The formula covers edges with one triangle or two.
    CrowdedEdge { ends: [u32; 2], triangles: usize },
    /// Cotangents divide by the area of the triangle.
    FlatTriangle { corners: [u32; 3] },
}

/// S and the mixed Voronoi areas a of a welded surface. The off-diagonal value of S is -(cot β + cot β')/2
/// for an inner edge and -cot β / 2 for a boundary edge. Pairs of obtuse angles give positive off-diagonal
/// values. S is nevertheless positive semi-definite, because it is the energy of piecewise linear
/// functions.
pub(crate) fn cotangent_laplacian(
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
) -> Result<(SymmetricSparse, Vec<f64>), Refusal> {
    let crowded = Edges::of(positions.len(), triangles).iter().find(|sides| sides.len() > 2).map(|sides| {
        let (u, v) = ends(triangles, sides[0]);
        Refusal::CrowdedEdge { ends: [u, v], triangles: sides.len() }
    });
    crowded.map_or(Ok(()), Err)?;
    let mut sides = Vec::with_capacity(3 * triangles.len());
    let mut mass = vec![0.0; positions.len()];
    for &corners in triangles {
        let TriangleMeasures { square, area, cotangent } =
            TriangleMeasures::of(corners.map(|v| positions[v as usize]));
        if area <= 0.5 * FLAT * square.into_iter().fold(0.0, f64::max) {
            return Err(Refusal::FlatTriangle { corners });
        }
        let parts = mixed_voronoi_parts(square, area, cotangent);
        for i in 0..3 {
            sides.push((corners[i], corners[(i + 1) % 3], 0.5 * cotangent[i]));
            mass[corners[i] as usize] += parts[i];
        }
    }
    // The constructor adds the contributions of both sides of an edge.
    Ok((SymmetricSparse::laplacian(positions.len(), &sides), mass))
}

/// For each side of a triangle (side i runs from corner i to the next): its squared length and the
/// cotangent of the angle opposite to it.
struct TriangleMeasures {
    square: [f64; 3],
    area: f64,
    cotangent: [f64; 3],
}

impl TriangleMeasures {
    fn of(corner: [[f64; 3]; 3]) -> Self {
        let side = |i: usize| sub(corner[(i + 1) % 3], corner[i]);
        let side = [side(0), side(1), side(2)];
        let twice_area = length(cross(side[0], side[1]));
        // The angle opposite to side i lies between the other two sides, one of which ends there and the
        // other starts.
        let cotangent = std::array::from_fn(|i| -dot(side[(i + 1) % 3], side[(i + 2) % 3]) / twice_area);
        Self { square: side.map(|s| dot(s, s)), area: 0.5 * twice_area, cotangent }
    }
}
