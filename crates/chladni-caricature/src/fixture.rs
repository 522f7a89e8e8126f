//! A shape with harmonics of its own, small and exact: a bumpy sphere whose basis are the
//! polynomials of the sphere, made M-orthonormal.

use std::sync::Arc;

use chladni_harmonics::{Basis, Body, Certificate};
use chladni_mesh::Frame;

use crate::{Base, Surface, Target};
use chladni_mesh::surface::vec3::{Vec3, add, length, scaled};
use chladni_mesh::surface::{corners, doubled_area_normal};

/// Degree of the harmonics: K = (DEGREE + 1)².
pub(crate) const DEGREE: usize = 6;

/// A bumpy sphere of 642 vertices with K = 49, in a frame that is not the file's.
pub(crate) fn bumpy_sphere() -> (Arc<Body>, Surface) {
    sphere_with_bumps(|p| 0.7 + 0.15 * (3.0 * p[0]).sin() + 0.1 * p[1] * p[2] + 0.03 * (9.0 * p[2]).cos())
}

/// A sphere whose radius is `bump` of each of its points, as [`bumpy_sphere`] is one.
pub(crate) fn sphere_with_bumps(bump: impl Fn(&Vec3) -> f64) -> (Arc<Body>, Surface) {
    let (points, triangles) = icosphere(3);
    let positions: Vec<Vec3> = points.iter().map(|p| scaled(*p, bump(p))).collect();
    let mut mass = vec![0.0; points.len()];
    for t in &triangles {
        let area = length(doubled_area_normal(corners(&positions, t))) / 2.0;
        t.iter().for_each(|v| mass[*v as usize] += area / 3.0);
    }
    let total: f64 = mass.iter().sum();
    let moment = positions.iter().zip(&mass).fold([0.0; 3], |m, (p, a)| add(m, scaled(*p, *a)));
    let positions: Vec<Vec3> = positions.iter().map(|p| add(*p, scaled(moment, -1.0 / total))).collect();
    let operator_vertex = (0..positions.len() as u32).map(Some).collect();
    let basis = Arc::new(polynomials(&points, mass));
    let frame = Frame { center: [10.0, -3.0, 0.25], scale: 0.37 };
    let surface = Surface::of(positions.clone(), triangles.clone(), frame);
    (Arc::new(Body { frame, positions, triangles, operator_vertex, basis }), surface)
}

/// The body's rest shape as a base, and a template that is another lump with the same vertices.
pub(crate) fn base_and_target() -> (Arc<Body>, Surface, Arc<Base>, Arc<Target>) {
    with_target(bumpy_sphere())
}

/// As [`base_and_target`] for another shape.
pub(crate) fn with_target(
    (body, surface): (Arc<Body>, Surface),
) -> (Arc<Body>, Surface, Arc<Base>, Arc<Target>) {
    let base = Base::new(body.basis.clone(), Arc::new(surface.clone()), body.positions.clone()).unwrap();
    let target = body.positions.iter().map(|p| {
        let r = length(*p);
        [p[0] * 0.9 + 0.05 * (5.0 * p[1]).sin(), p[1] * (0.8 + 0.3 * r), p[2] + 0.1 * p[0] * p[1] - 0.02]
    });
    let target = Target::new(body.basis.clone(), target.collect()).unwrap();
    (body, surface, Arc::new(base), Arc::new(target))
}

/// The first `harmonics` of `basis`.
pub(crate) fn fewer(basis: &Basis, harmonics: usize) -> Basis {
    Basis {
        eigenvalues: basis.eigenvalues[..harmonics].to_vec(),
        vectors: basis.vectors[..harmonics * basis.vertices()].to_vec().into(),
        ..basis.clone()
    }
}

pub(crate) fn polynomials(points: &[Vec3], mass: Vec<f64>) -> Basis {
    let mut columns: Vec<Vec<f64>> = Vec::new();
    let mut eigenvalues = Vec::new();
    let product = |f: &[f64], g: &[f64]| -> f64 { (0..f.len()).map(|v| mass[v] * f[v] * g[v]).sum() };
    for l in 0..=DEGREE {
        for e in 0..=1_usize.min(l) {
            for i in 0..=l - e {
                let j = l - e - i;
                let monomial = |p: &Vec3| p[0].powi(i as i32) * p[1].powi(j as i32) * p[2].powi(e as i32);
                let mut f: Vec<f64> = points.iter().map(monomial).collect();
                for _ in 0..2 {
                    for g in &columns {
                        let c = product(&f, g);
                        f.iter_mut().zip(g).for_each(|(f, g)| *f -= c * g);
                    }
                }
                let length = product(&f, &f).sqrt();
                columns.push(f.iter().map(|f| f / length).collect());
                eigenvalues.push((l * (l + 1)) as f64);
            }
        }
    }
    let certificate = Certificate {
        laplacian: chladni_harmonics::Laplacian::Delaunay,
        inertia_counts_match: Some(true),
        max_relative_residual: 0.0,
        max_orthogonality_error: 1e-14,
    };
    Basis { eigenvalues, vectors: columns.concat().into(), mass, certificate }
}

/// The icosahedron subdivided `levels` times, on the unit sphere.
pub(crate) fn icosphere(levels: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let ball = chladni_mesh::samples::icosphere(levels);
    (ball.positions, ball.triangles)
}
