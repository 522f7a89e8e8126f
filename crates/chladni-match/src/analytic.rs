//! Templates that need no second mesh: an ellipsoid, a sphere, the shape itself.

use chladni_mesh::{TriMesh, symmetric_eigen};
use glam::{DMat3, DVec3, EulerRot};

use crate::surface::UnitSurface;
use crate::{Correspondence, MatchError, Side};
use chladni_mesh::surface::solve_small;

/// An ellipsoid in the shape file's coordinates.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Ellipsoid {
    /// Its center.
    pub center: [f64; 3],
    /// Orthonormal directions of its axes.
    pub axes: [[f64; 3]; 3],
    /// Half the length of each axis; positive.
    pub semi_axes: [f64; 3],
}

impl Ellipsoid {
    /// The ellipsoid nearest to a surface. Its axes are the principal axes of the area; its center, within the shape's box,
    /// and its semi-axes, at most the diagonal, minimize Σ a(v) ‖x − q(x)‖², where q(x) is the point of the ellipsoid on the
    /// ray from the center through x; found from the moments. For a mesh of an ellipsoid the result is that ellipsoid, up
    /// to the discretization.
    ///
    /// # Errors
    /// A mesh without a surface.
    pub fn fitted(shape: &TriMesh) -> Result<Self, MatchError> {
        let surface = UnitSurface::new(shape, Side::Shape)?;
        let area = surface.area();
        let (moments, axes) = symmetric_eigen(surface.second_moments());
        let axes = axes.map(DVec3::from_array);
        // A flat shape still gets some thickness: no semi-axis is below a hundredth of the diagonal.
        let start = moments.map(|m| (3.0 * m.max(0.0) / area).sqrt().max(0.01));
        let local: Vec<(DVec3, f64)> = surface
            .points
            .iter()
            .zip(&surface.areas)
            .map(|(p, a)| (DVec3::from_array(axes.map(|e| e.dot(*p))), a / area))
            .collect();
        let (center, semi_axes) = refine(&local, start);
        let center = axes[0] * center.x + axes[1] * center.y + axes[2] * center.z;
        Ok(Self {
            center: surface.to_file(center).to_array(),
            axes: axes.map(|e| e.to_array()),
            semi_axes: semi_axes.map(|s| s * surface.diagonal),
        })
    }

    /// The sphere around the area-weighted centroid whose radius is the mean distance from it.
    ///
    /// # Errors
    /// A mesh without a surface.
    pub fn fitted_sphere(shape: &TriMesh) -> Result<Self, MatchError> {
        let surface = UnitSurface::new(shape, Side::Shape)?;
        let sum: f64 = surface.points.iter().zip(&surface.areas).map(|(p, a)| a * p.length()).sum();
        Self::sphere(surface.center.to_array(), surface.diagonal * sum / surface.area())
    }

    /// A given sphere.
    ///
    /// # Errors
    /// A radius that is not positive and finite, or a center that is not finite.
    pub fn sphere(center: [f64; 3], radius: f64) -> Result<Self, MatchError> {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let ellipsoid = Self { center, axes, semi_axes: [radius; 3] };
        ellipsoid.check()?;
        Ok(ellipsoid)
    }

    /// A given ellipsoid: its center, its semi-axes, and its rotation in degrees about x, then y, then z.
    ///
    /// # Errors
    /// A semi-axis that is not positive and finite, or another number that is not finite.
    pub fn given(center: [f64; 3], semi_axes: [f64; 3], turn_deg: [f64; 3]) -> Result<Self, MatchError> {
        let [x, y, z] = turn_deg.map(f64::to_radians);
        let turn = DMat3::from_rotation_z(z) * DMat3::from_rotation_y(y) * DMat3::from_rotation_x(x);
        let ellipsoid = Self { center, axes: turn.to_cols_array_2d(), semi_axes };
        ellipsoid.check()?;
        Ok(ellipsoid)
    }

    /// The angles, in degrees, for which [`given`](Self::given) returns these axes.
    pub fn turn_deg(&self) -> [f64; 3] {
        let mut axes = DMat3::from_cols_array_2d(&self.axes);
        // An axis and its opposite are the same axis, but only a right-handed frame is a rotation.
        if axes.determinant() < 0.0 {
            axes.z_axis = -axes.z_axis;
        }
        let (z, y, x) = axes.to_euler(EulerRot::ZYX);
        [x, y, z].map(f64::to_degrees)
    }

    fn check(&self) -> Result<(), MatchError> {
        for value in self.semi_axes {
            if !(value > 0.0 && value.is_finite()) {
                return Err(MatchError::Parameter {
                    name: "a semi-axis",
                    range: "positive and finite",
                    value,
                });
            }
        }
        for &value in self.center.iter().chain(self.axes.iter().flatten()) {
            if !value.is_finite() {
                return Err(MatchError::Parameter { name: "an ellipsoid", range: "finite", value });
            }
        }
        Ok(())
    }

    /// The point where the ray from the center through `p` leaves the ellipsoid; `None` at the center.
    fn project(&self, p: DVec3) -> Option<DVec3> {
        let d = p - DVec3::from_array(self.center);
        let level: f64 =
            (0..3).map(|i| (DVec3::from_array(self.axes[i]).dot(d) / self.semi_axes[i]).powi(2)).sum();
        let point = DVec3::from_array(self.center) + d / level.sqrt();
        (level > 0.0 && point.is_finite()).then_some(point)
    }
}

/// Levenberg–Marquardt for center and semi-axes in the principal frame. The center stays in the shape's box, and no
/// semi-axis is longer than its diagonal: a plane is nearer to some shapes than any ellipsoid of their size.
fn refine(points: &[(DVec3, f64)], start: [f64; 3]) -> (DVec3, [f64; 3]) {
    const SEMI_AXES: [f64; 2] = [1e-3, 1.0];
    let low = points.iter().fold(DVec3::INFINITY, |low, (p, _)| low.min(*p));
    let high = points.iter().fold(DVec3::NEG_INFINITY, |high, (p, _)| high.max(*p));
    let cost = |c: DVec3, s: [f64; 3]| -> f64 {
        points.iter().map(|(p, w)| w * Ray::of(*p - c, s).map_or(0.0, |ray| ray.residual()).powi(2)).sum()
    };
    let (mut center, mut semi) = (DVec3::ZERO.clamp(low, high), start.map(|s| s.min(SEMI_AXES[1])));
    let (mut best, mut damping) = (cost(center, semi), 1e-3);
    for _ in 0..60 {
        let mut normal = [[0.0; 6]; 6];
        let mut right = [0.0; 6];
        for (p, w) in points {
            let Some(ray) = Ray::of(*p - center, semi) else { continue };
            let row = ray.gradient(semi);
            for i in 0..6 {
                right[i] -= w * row[i] * ray.residual();
                for j in 0..6 {
                    normal[i][j] += w * row[i] * row[j];
                }
            }
        }
        let improved = (0..8).find_map(|_| {
            let mut damped = normal;
            for i in 0..6 {
                damped[i][i] += damping * (normal[i][i] + 1e-12);
            }
            damping *= 5.0;
            let step = solve_small(damped, right)?;
            let c = (center + DVec3::new(step[0], step[1], step[2])).clamp(low, high);
            let s = std::array::from_fn(|i| {
                (semi[i] * step[3 + i].clamp(-1.0, 1.0).exp()).clamp(SEMI_AXES[0], SEMI_AXES[1])
            });
            let value = cost(c, s);
            (value < best).then_some((c, s, value))
        });
        let Some((c, s, value)) = improved else { break };
        damping = (0.04 * damping).max(1e-9);
        let gain = best - value;
        (center, semi, best) = (c, s, value);
        if gain < 1e-14 {
            break;
        }
    }
    (center, semi)
}

/// The ray from an ellipsoid's center through a point at `d` from it.
struct Ray {
    d: DVec3,
    /// The same with the ellipsoid scaled to the unit sphere, and its length.
    u: DVec3,
    level: f64,
}

impl Ray {
    /// `None` of a point so near the center that its ray says little.
    fn of(d: DVec3, semi: [f64; 3]) -> Option<Self> {
        let u = d / DVec3::from_array(semi);
        let level = u.length();
        (level > 1e-3).then_some(Self { d, u, level })
    }

    /// How far the point is outside the ellipsoid, along the ray: ‖d‖ (1 − 1/‖u‖).
    fn residual(&self) -> f64 {
        self.d.length() * (1.0 - 1.0 / self.level)
    }

    /// Its derivatives by the center and by the logarithms of the semi-axes.
    fn gradient(&self, semi: [f64; 3]) -> [f64; 6] {
        let Self { d, u, level } = self;
        let length = d.length();
        let by_level = length / level.powi(3);
        std::array::from_fn(|i| {
            let k = i % 3;
            if i < 3 {
                -d[k] / length * (1.0 - 1.0 / level) - by_level * u[k] / semi[k]
            } else {
                -by_level * u[k] * u[k]
            }
        })
    }
}

/// Pairs each vertex with the point of the ellipsoid on its ray from the center.
///
/// The map is continuous everywhere but at the center, and one to one on shapes that are star-shaped about
/// it. A vertex at the center is paired with the end of the first axis, with confidence 0.
///
/// # Errors
/// A mesh without a surface, or an ellipsoid with a semi-axis that is not positive and finite.
pub fn onto_ellipsoid(shape: &TriMesh, ellipsoid: &Ellipsoid) -> Result<Correspondence, MatchError> {
    let surface = UnitSurface::new(shape, Side::Shape)?;
    ellipsoid.check()?;
    let pole =
        DVec3::from_array(ellipsoid.center) + DVec3::from_array(ellipsoid.axes[0]) * ellipsoid.semi_axes[0];
    let (point, confidence) = shape
        .positions
        .iter()
        .zip(&surface.point_of_vertex)
        .map(|(p, used)| match ellipsoid.project(DVec3::from_array(*p)) {
            Some(q) => (q.to_array(), f64::from(u8::from(used.is_some()))),
            None => (pole.to_array(), 0.0),
        })
        .unzip();
    Ok(Correspondence::direct(point, confidence))
}

/// Pairs each vertex with its own position, scaled about the area-weighted centroid. Exaggerating the
/// difference from a smaller copy magnifies everything.
///
/// # Errors
/// A mesh without a surface, or a scale that is negative or not finite.
pub fn self_scaled(shape: &TriMesh, scale: f64) -> Result<Correspondence, MatchError> {
    if !(scale >= 0.0 && scale.is_finite()) {
        return Err(MatchError::Parameter { name: "scale", range: "finite and ≥ 0", value: scale });
    }
    let surface = UnitSurface::new(shape, Side::Shape)?;
    let (point, confidence) = shape
        .positions
        .iter()
        .zip(&surface.point_of_vertex)
        .map(|(p, used)| match used {
            Some(_) => {
                let p = DVec3::from_array(*p);
                ((surface.center + (p - surface.center) * scale).to_array(), 1.0)
            }
            None => (*p, 0.0),
        })
        .unzip();
    Ok(Correspondence::direct(point, confidence))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A latitude–longitude sphere, deformed by `f`.
    fn sphere(f: impl Fn(DVec3) -> DVec3) -> TriMesh {
        let (rows, columns) = (40_u32, 80_u32);
        let mut mesh = TriMesh::default();
        for r in 0..=rows {
            for c in 0..columns {
                let (theta, phi) = (
                    std::f64::consts::PI * r as f64 / rows as f64,
                    std::f64::consts::TAU * c as f64 / columns as f64,
                );
                let p = DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
                mesh.positions.push(f(p).to_array());
                if r < rows {
                    let (a, b) = (r * columns + c, r * columns + (c + 1) % columns);
                    mesh.triangles.push([a, a + columns, b]);
                    mesh.triangles.push([b, a + columns, b + columns]);
                }
            }
        }
        mesh
    }

    #[test]
    fn an_ellipsoid_is_recognized() {
        let turn = DMat3::from_rotation_z(0.7) * DMat3::from_rotation_x(0.4);
        let mesh = sphere(|p| turn * (p * DVec3::new(3.0, 2.0, 1.0)) + DVec3::new(10.0, -5.0, 1.0));
        let e = Ellipsoid::fitted(&mesh).unwrap();
        for (found, truth) in e.semi_axes.iter().zip([3.0, 2.0, 1.0]) {
            assert!((found - truth).abs() < 2e-3 * truth, "{e:?}");
        }
        for (found, truth) in e.center.iter().zip([10.0, -5.0, 1.0]) {
            assert!((found - truth).abs() < 1e-3);
        }
        let c = onto_ellipsoid(&mesh, &e).unwrap();
        for (p, q) in mesh.positions.iter().zip(&c.target) {
            assert!(DVec3::from_array(*p).distance(DVec3::from_array(*q)) < 0.01);
        }
    }

    #[test]
    fn the_nearest_ellipsoid_of_any_shape_has_its_size_and_place() {
        // A bowl with a long handle, a dented ball and two balls apart: flatter and farther would be nearer by the sum of
        // (1 − ‖u‖)², which vanishes far away.
        let bowl = sphere(|p| DVec3::new(p.x, p.y, p.z.min(-0.2) + 3.0 * (p.x - 0.9).max(0.0)));
        let dented = sphere(|p| p * (1.0 - 0.9 * (-8.0 * (p - DVec3::Z).length_squared()).exp()));
        let apart = sphere(|p| p * 0.3 + DVec3::X * p.z.signum());
        for mesh in [bowl, dented, apart] {
            let surface = UnitSurface::new(&mesh, Side::Shape).unwrap();
            let e = Ellipsoid::fitted(&mesh).unwrap();
            assert!(e.semi_axes.iter().all(|s| *s <= surface.diagonal * (1.0 + 1e-12)), "{e:?}");
            let points = mesh.positions.iter().map(|p| DVec3::from_array(*p));
            let low = points.clone().fold(DVec3::INFINITY, DVec3::min);
            let high = points.fold(DVec3::NEG_INFINITY, DVec3::max);
            // The box along its own axes may be a little larger than that along x, y and z.
            let middle = DVec3::from_array(e.center) - 0.5 * (low + high);
            assert!(middle.length() < 0.6 * surface.diagonal, "{e:?}");
        }
    }

    #[test]
    fn a_gradient_is_that_of_the_residual() {
        let (d, semi) = (DVec3::new(0.3, -0.2, 0.5), [0.4, 0.2, 0.7]);
        let found = Ray::of(d, semi).unwrap().gradient(semi);
        for i in 0..6 {
            let moved = |by: f64| {
                let (mut d, mut s) = (d, semi);
                if i < 3 {
                    d[i] -= by
                } else {
                    s[i - 3] *= by.exp()
                }
                Ray::of(d, s).unwrap().residual()
            };
            let slope = (moved(1e-6) - moved(-1e-6)) / 2e-6;
            assert!((found[i] - slope).abs() < 1e-8, "{i}: {} and {slope}", found[i]);
        }
    }

    #[test]
    fn a_given_ellipsoid_lies_as_it_was_turned() {
        let (center, semi, turn) = ([1.0, -2.0, 3.0], [3.0, 2.0, 1.0], [20.0, -35.0, 110.0]);
        let e = Ellipsoid::given(center, semi, turn).unwrap();
        let axis = DMat3::from_rotation_z(110_f64.to_radians())
            * DMat3::from_rotation_y(-35_f64.to_radians())
            * DVec3::X;
        assert!(DVec3::from_array(e.axes[0]).distance(axis) < 1e-12);
        let mirrored = Ellipsoid { axes: [e.axes[0], e.axes[1], e.axes[2].map(|c| -c)], ..e };
        for same in [e, mirrored] {
            assert!(same.turn_deg().iter().zip(turn).all(|(a, b)| (a - b).abs() < 1e-9));
        }
        let plain = Ellipsoid::given(center, [2.0; 3], [0.0; 3]).unwrap();
        assert_eq!(plain, Ellipsoid::sphere(center, 2.0).unwrap());
        assert!(Ellipsoid::given(center, [1.0, 0.0, 1.0], turn).is_err());
        assert!(Ellipsoid::given(center, semi, [f64::NAN, 0.0, 0.0]).is_err());
    }

    #[test]
    fn a_sphere_has_its_radius() {
        let s = Ellipsoid::fitted_sphere(&sphere(|p| p * 4.0)).unwrap();
        assert!((s.semi_axes[0] - 4.0).abs() < 1e-2);
        assert!(Ellipsoid::sphere([0.0; 3], -1.0).is_err());
        assert!(Ellipsoid::sphere([0.0; 3], f64::NAN).is_err());
    }

    #[test]
    fn a_scaled_self_keeps_its_center() {
        let mesh = sphere(|p| p + DVec3::X * 7.0);
        let c = self_scaled(&mesh, 0.5).unwrap();
        let p = DVec3::from_array(c.target[45]);
        let expected = DVec3::X * 7.0 + (DVec3::from_array(mesh.positions[45]) - DVec3::X * 7.0) * 0.5;
        assert!(p.distance(expected) < 1e-3);
        assert!(self_scaled(&mesh, f64::INFINITY).is_err());
    }
}
