//! A shape together with its harmonics: what both instruments deform.

use std::sync::Arc;

use chladni_mesh::Frame;

use crate::Basis;

/// A welded shape in the working frame and its harmonic basis.
///
/// Everything that deforms works on the N operator vertices of a body. `operator_vertex`
/// leads back to the n vertices of the file: an export is the file's own coordinates plus a
/// displacement, never a round trip through the working frame.
#[derive(Clone, Debug)]
pub struct Body {
    /// The similarity between file and working frame.
    pub frame: Frame,
    /// x(v), N rest positions in the working frame.
    pub positions: Vec<[f64; 3]>,
    /// Triangles over operator vertices, in file order; those that welding collapsed are kept
    /// (they have repeated corners) so that triangle indices agree with the file's.
    pub triangles: Vec<[u32; 3]>,
    /// For each of the n file vertices its operator vertex; `None` where no triangle uses it.
    pub operator_vertex: Vec<Option<u32>>,
    /// The harmonics, solved in the working frame.
    pub basis: Arc<Basis>,
}

impl Body {
    /// Rest positions of the file plus `displacements` of the operator vertices (N, working
    /// frame), as n positions in file units. Where a displacement is zero the file's own
    /// coordinates come back bit for bit.
    pub fn displaced_file_positions(
        &self,
        file_positions: &[[f64; 3]],
        displacements: &[[f64; 3]],
    ) -> Vec<[f64; 3]> {
        file_positions
            .iter()
            .zip(&self.operator_vertex)
            .map(|(p, v)| match v {
                Some(v) => {
                    let d = self.frame.displacement_to_file(displacements[*v as usize]);
                    std::array::from_fn(|i| p[i] + d[i])
                }
                None => *p,
            })
            .collect()
    }
}
