//! A shape together with its harmonics, which both instruments deform.

use std::sync::Arc;

use chladni_mesh::Frame;

use crate::Basis;

/// A welded shape in the working frame and its harmonic basis.
///
/// Everything that deforms a body works on its N operator vertices. `operator_vertex` maps the n vertices
/// of the file to them. An export is the file's own coordinates plus a displacement, never a round trip
/// through the working frame.
#[derive(Clone, Debug)]
pub struct Body {
    /// The similarity between file and working frame.
    pub frame: Frame,
    /// x(v), N rest positions in the working frame.
    pub positions: Vec<[f64; 3]>,
    /// Triangles over operator vertices, in file order. Triangles that welding has collapsed are kept (they
    /// have repeated corners), and so, collapsed, are those of faces that repeat an earlier one, which keeps triangle
    /// indices equal to those of the file.
    pub triangles: Vec<[u32; 3]>,
    /// For each of the n file vertices its operator vertex; `None` if no triangle uses it.
    pub operator_vertex: Vec<Option<u32>>,
    /// The harmonics, solved in the working frame.
    pub basis: Arc<Basis>,
}

impl Body {
    /// Converts an eigenvalue λ of the basis to the file's units: λ s², where s is the scale of the frame.
    pub fn eigenvalue_in_file(&self, eigenvalue: f64) -> f64 {
        eigenvalue * self.frame.scale * self.frame.scale
    }

    /// Converts an area a to the file's units: a / s².
    pub fn area_in_file(&self, area: f64) -> f64 {
        area / (self.frame.scale * self.frame.scale)
    }

    /// Converts a value H of a harmonic to the file's units: H s, because harmonics are orthonormal with
    /// respect to area.
    pub fn harmonic_in_file(&self, value: f64) -> f64 {
        value * self.frame.scale
    }

    /// A copy of the basis in the file's units.
    pub fn basis_in_file(&self) -> Basis {
        let basis = &*self.basis;
        Basis {
            eigenvalues: basis.eigenvalues.iter().map(|l| self.eigenvalue_in_file(*l)).collect(),
            vectors: basis.vectors.iter().map(|h| self.harmonic_in_file(*h)).collect(),
            mass: basis.mass.iter().map(|a| self.area_in_file(*a)).collect(),
            certificate: basis.certificate,
        }
    }

    /// The same without a copy, if nothing else holds the basis.
    pub fn into_basis_in_file(self) -> Basis {
        let scale = self.frame.scale;
        let mut basis = Arc::unwrap_or_clone(self.basis);
        basis.eigenvalues.iter_mut().for_each(|l| *l = *l * scale * scale);
        basis.vectors.iter_mut().for_each(|h| *h *= scale);
        basis.mass.iter_mut().for_each(|a| *a /= scale * scale);
        basis
    }

    /// Converts `displacements` of the operator vertices (N, working frame) to displacements of the n file
    /// vertices in file units; zero for vertices that no triangle uses.
    pub fn displacements_in_file(&self, displacements: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let of = |v: &Option<u32>| {
            let moved = v.and_then(|v| displacements.get(v as usize));
            moved.map_or([0.0; 3], |d| self.frame.displacement_to_file(*d))
        };
        self.operator_vertex.iter().map(of).collect()
    }

    /// Values of the file's vertices on the operator vertices: of welded ones the last, `none` where there is none.
    pub fn on_operator_vertices<T: Clone>(&self, of_file: impl IntoIterator<Item = T>, none: T) -> Vec<T> {
        let mut own = vec![none; self.positions.len()];
        for (value, vertex) in of_file.into_iter().zip(&self.operator_vertex) {
            if let Some(own) = vertex.and_then(|v| own.get_mut(v as usize)) {
                *own = value;
            }
        }
        own
    }

    /// The rest positions of the file plus `displacements` of the operator vertices (N, working frame), as
    /// n positions in file units. Where a displacement is zero, the result equals the file's coordinates bit for bit.
    ///
    /// # Panics
    /// If there are fewer displacements than N.
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
                    // −0 + 0 would be 0.
                    std::array::from_fn(|i| if d[i] == 0.0 { p[i] } else { p[i] + d[i] })
                }
                None => *p,
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use chladni_mesh::{samples, total_area};
    use chladni_task::Task;

    use super::*;
    use crate::BasisSettings;

    #[test]
    fn what_does_not_move_keeps_its_bits() {
        let mut mesh = samples::icosphere(1);
        mesh.positions.iter_mut().flatten().filter(|x| **x == 0.0).for_each(|x| *x = -0.0);
        let body = Body::unsolved(&mesh).unwrap();
        let still = vec![[0.0; 3]; body.positions.len()];
        let moved = body.displaced_file_positions(&mesh.positions, &still);
        let bits =
            |positions: &[[f64; 3]]| positions.as_flattened().iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        let (before, after) = (bits(&mesh.positions), bits(&moved));
        assert!(before.contains(&(-0.0_f64).to_bits()) && before == after);
    }

    #[test]
    fn a_ball_of_radius_25_has_its_spectrum_in_the_units_of_its_file() {
        let mut ball = samples::icosphere(4);
        ball.positions.iter_mut().for_each(|p| *p = [25.0 * p[0] + 3.0, 25.0 * p[1], 25.0 * p[2] - 7.0]);
        let body = Body::build(&ball, &BasisSettings::new(9), &Task::new()).unwrap();
        let basis = body.basis_in_file();
        // l (l + 1) / R², up to the discretization.
        for (k, l) in [(1, 1.0), (3, 1.0), (4, 2.0), (8, 2.0_f64)] {
            let exact = l * (l + 1.0) / 625.0;
            assert!((basis.eigenvalues[k] / exact - 1.0).abs() < 0.01, "{k}: {}", basis.eigenvalues[k]);
        }
        let area = total_area(&ball.positions, &ball.triangles);
        assert!((basis.mass.iter().sum::<f64>() / area - 1.0).abs() < 1e-12);
        let length: f64 = basis.harmonic(5).iter().zip(&basis.mass).map(|(h, a)| h * h * a).sum();
        assert!((length - 1.0).abs() < 1e-10);
    }
}
