//! How long a cut is, where parts meet rather in a crease than across a bulge.

use chladni_harmonics::Body;
use chladni_mesh::surface::vec3::{Vec3, dot, sub};
use chladni_mesh::surface::{facing_outward, vertex_normals};

/// The lengths of cuts through the edges of a body. Along a crease they count as shorter: there people see parts meet
/// (D. Hoffman & W. Richards, "Parts of recognition", 1984).
pub(super) struct Creases<'a> {
    pub mass: &'a [f64],
    positions: &'a [Vec3],
    normals: Vec<Vec3>,
    /// √(A / π).
    size: f64,
}

impl<'a> Creases<'a> {
    pub fn of(body: &'a Body) -> Self {
        let (mass, positions) = (&body.basis.mass, &body.positions);
        let size = (mass.iter().sum::<f64>() / std::f64::consts::PI).sqrt();
        let normals = vertex_normals(positions, &facing_outward(positions, &body.triangles));
        Self { mass, positions, normals, size }
    }

    /// About half the length that a line across the edge from `v` to `w` needs to come to the next, and half of that
    /// where it runs along a crease with the radius √(A / π); the sharper, the shorter.
    pub fn length_across(&self, v: usize, w: usize) -> f64 {
        let along = sub(self.positions[w], self.positions[v]);
        let turned = dot(sub(self.normals[w], self.normals[v]), along);
        let curvature = turned / dot(along, along).max(f64::MIN_POSITIVE);
        (self.mass[v].sqrt() + self.mass[w].sqrt()) / (1.0 + self.size * (-curvature).max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_harmonics::BasisSettings;
    use chladni_mesh::samples::icosphere;
    use chladni_mesh::surface::vec3::length;
    use chladni_task::Task;

    #[test]
    fn a_cut_along_a_waist_is_short_and_one_across_a_bulge_is_not() {
        // A ball with a waist at the equator.
        let mut mesh = icosphere(4);
        for p in &mut mesh.positions {
            let waist = 1.0 - 0.5 * (-(p[2] / 0.25).powi(2)).exp();
            *p = [p[0] * waist, p[1] * waist, p[2]];
        }
        let body = Body::build(&mesh, &BasisSettings::new(8), &Task::new()).unwrap();
        let creases = Creases::of(&body);
        let mut inside_out = body.clone();
        inside_out.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        let of_inside_out = Creases::of(&inside_out);
        let (mut waist, mut bulge) = (Vec::new(), Vec::new());
        for [v, w] in mesh.triangles.iter().flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]) {
            let (v, w) = (v as usize, w as usize);
            assert_eq!(of_inside_out.length_across(v, w), creases.length_across(v, w));
            let along = sub(mesh.positions[w], mesh.positions[v]);
            if along[2].abs() < 0.6 * length(along) {
                continue;
            }
            let ratio = creases.length_across(v, w) / (creases.mass[v].sqrt() + creases.mass[w].sqrt());
            match mesh.positions[v][2].abs() {
                z if z < 0.1 => waist.push(ratio),
                z if z > 0.55 => bulge.push(ratio),
                _ => {}
            }
        }
        assert!(waist.len() > 20 && waist.iter().all(|ratio| *ratio < 0.5), "{waist:?}");
        assert!(bulge.len() > 20 && bulge.iter().all(|ratio| *ratio > 0.9), "{bulge:?}");
    }
}
