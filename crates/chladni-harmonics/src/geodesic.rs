//! Distances along a surface by the heat method (Crane, Weischedel & Wardetzky 2013), on the intrinsic Delaunay
//! triangles of the tufted cover (Sharp & Crane 2020).

use std::sync::Arc;

use chladni_mesh::TriMesh;

use crate::heat::{HeatFlow, HeatStep};
use crate::laplacian::{Cover, MOLLIFY, cover_laplacian, delaunay_cover};
use crate::operator::Domain;
use crate::{HarmonicsError, laplacian};

/// The heat at a source. With it, heat stays above 0 over a path of 1,200 edges; with 1 it would over 700.
const SOURCE: f64 = 1e250;
/// The step with which Poisson's equation is solved, as a multiple of the surface's area: (M + tS)⁻¹ t
/// equals S⁻¹ up to a constant, to within 1 / (tλ) for the harmonic with eigenvalue λ.
const FOREVER: f64 = 1e10;
/// The longest step of heat, as a multiple of the surface's area. After it heat is level to within a millionth, and after
/// much longer ones its gradient is lost in rounding.
const LONGEST: f64 = 1e6;
/// Heat that differs by less than this share of itself between the corners of a triangle differs by rounding alone.
const LEVEL: f64 = 1e-12;

/// Geodesic distances from any vertices of one surface, in the units of its file. Two factorizations are
/// computed once and used for all sources.
///
/// The accuracy is that of the heat method: about half an edge for short distances, and 1 % of longer ones
/// on ten thousand vertices, half of that on four times as many.
#[derive(Debug)]
pub struct HeatGeodesics {
    cover: Cover,
    step: HeatStep,
    forever: HeatStep,
    /// The connected component of each operator vertex.
    component: Vec<u32>,
    operator_vertex: Vec<Option<u32>>,
    /// The scale from file units to those of the working frame.
    scale: f64,
}

impl HeatGeodesics {
    /// Prepares `mesh` for a heat step of `time` times the squared mean edge length of the intrinsic triangulation.
    /// 1 is usual; a longer step gives smoother distances and reaches farther.
    ///
    /// # Errors
    /// No usable triangle, coordinates that are not finite, an index out of range, a mesh without area, or a `time` that
    /// is not positive, infinite, or too large to compute with: a step of more than a million times the surface's area.
    pub fn of(mesh: &TriMesh, time: f64) -> Result<Self, HarmonicsError> {
        let domain = Domain::of(mesh)?;
        let component = domain.components()?;
        let Domain { frame, positions, triangles, operator_vertex, .. } = domain;
        let cover = delaunay_cover(&positions, &triangles, MOLLIFY)?;
        let (stiffness, mass) = cover_laplacian(&cover, positions.len());
        let area = mass.iter().sum::<f64>();
        let edge = cover.length.iter().sum::<f64>() / cover.length.len().max(1) as f64;
        let flow = Arc::new(HeatFlow::on(&stiffness, &mass));
        let short = time * edge * edge;
        if !(time.is_finite() && short > 0.0 && short <= LONGEST * area) {
            return Err(HarmonicsError::HeatStep { time });
        }
        Ok(Self {
            cover,
            step: flow.step(short)?,
            forever: flow.step(FOREVER * area)?,
            component,
            operator_vertex,
            scale: frame.scale,
        })
    }

    /// n, the number of file vertices.
    pub fn vertices(&self) -> usize {
        self.operator_vertex.len()
    }

    /// The distance of each of the n file vertices from the nearest of `sources`, n values in file units.
    /// It is infinite for vertices on other components and for those that no triangle uses, or only a piece without
    /// area. A source that is alone on its component, or has sources only around it, has 0; of several others, each may
    /// have up to a few edges.
    ///
    /// # Errors
    /// No source, a source that is not a vertex of the surface, or a surface with paths so long that no
    /// heat arrives: about 1,200 edges for a step of 1 ([`HarmonicsError::TooFar`]).
    pub fn distances(&self, sources: &[usize]) -> Result<Vec<f64>, HarmonicsError> {
        let mut sources = sources.iter().map(|v| self.on_surface(*v)).collect::<Result<Vec<usize>, _>>()?;
        sources.sort_unstable();
        sources.dedup();
        if sources.is_empty() {
            return Err(HarmonicsError::NoSource);
        }
        let n = self.component.len();
        let (mut reached, mut is_source) = (vec![false; n], vec![false; n]);
        for v in &sources {
            reached[self.component[*v] as usize] = true;
            is_source[*v] = true;
        }
        let is_reached = |v: usize| reached[self.component[v] as usize];
        // Of a patch of sources, the border alone is hot: those within are far from it, and would draw the mean along.
        let is_border = self.border(&is_source);
        let mut hot = vec![0.0; n];
        sources.retain(|v| is_border[*v]);
        sources.iter().for_each(|v| hot[*v] = SOURCE);
        let heat = self.step.solve_for(&hot);
        if let Some(v) = (0..n).find(|&v| is_reached(v) && !is_source[v] && heat[v] < f64::MIN_POSITIVE) {
            let vertex = self.operator_vertex.iter().position(|o| *o == Some(v as u32)).unwrap_or_default();
            return Err(HarmonicsError::TooFar { vertex });
        }
        let potential = self.forever.solve_for(&self.divergence(&heat));
        // Up to a constant on each component, and in units of 1 / t. Sources differ by the error of the method: from
        // the least of them all distances would be too long, from their mean they are not.
        let (mut sum, mut count) = (vec![0.0; n], vec![0.0; n]);
        for v in &sources {
            let component = self.component[*v] as usize;
            sum[component] += potential[*v];
            count[component] += 1.0;
        }
        let factor = self.forever.time() / self.scale;
        let distance = |v: usize| {
            let component = self.component[v] as usize;
            match is_reached(v) {
                true if is_source[v] && !is_border[v] => 0.0,
                true => (factor * (potential[v] - sum[component] / count[component])).max(0.0),
                false => f64::INFINITY,
            }
        };
        Ok(self.operator_vertex.iter().map(|v| v.map_or(f64::INFINITY, |v| distance(v as usize))).collect())
    }

    /// Whether each vertex is a source in a triangle with a corner that is none.
    fn border(&self, is_source: &[bool]) -> Vec<bool> {
        let mut is_border = vec![false; is_source.len()];
        for corners in self.cover.tail.as_chunks::<3>().0 {
            let corners = corners.map(|v| v as usize);
            if corners.iter().any(|v| !is_source[*v]) {
                corners.iter().for_each(|v| is_border[*v] |= is_source[*v]);
            }
        }
        is_border
    }

    fn on_surface(&self, vertex: usize) -> Result<usize, HarmonicsError> {
        let vertices = self.operator_vertex.len();
        let reason = match self.operator_vertex.get(vertex) {
            Some(Some(v)) => return Ok(*v as usize),
            Some(None) => "no triangle with an area uses it",
            None => "there is no such vertex",
        };
        Err(HarmonicsError::NotOnSurface { vertex, vertices, reason })
    }

    /// ∫ ∇φ_v · X for each hat function φ_v, where X is the unit field opposite to the gradient of `heat`.
    fn divergence(&self, heat: &[f64]) -> Vec<f64> {
        let share = 1.0 / self.cover.sheets as f64;
        let mut sums = vec![0.0; heat.len()];
        let corners = self.cover.tail.as_chunks::<3>().0;
        for (corners, length) in corners.iter().zip(self.cover.length.as_chunks::<3>().0) {
            let corners = corners.map(|v| v as usize);
            let slopes = laplacian::hat_slopes(*length);
            // Scaled per triangle: heat falls by many orders of magnitude from one end of a surface to the
            // other.
            let most = corners.iter().fold(0.0_f64, |most, v| most.max(heat[*v]));
            let least = corners.iter().fold(most, |least, v| least.min(heat[*v]));
            // Rounding points in no direction.
            if most - least <= LEVEL * most {
                continue;
            }
            let gradient: [f64; 2] =
                std::array::from_fn(|x| (0..3).map(|i| heat[corners[i]] / most * slopes[i][x]).sum());
            let size = gradient[0].hypot(gradient[1]);
            if size > 0.0 {
                for (v, slope) in corners.into_iter().zip(slopes) {
                    sums[v] -= share * (slope[0] * gradient[0] + slope[1] * gradient[1]) / size;
                }
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::threads::on_threads;
    use chladni_mesh::samples;

    #[test]
    fn a_sphere_has_great_circles() {
        let mut sphere = samples::icosphere(5);
        // At any place and of any size.
        for p in &mut sphere.positions {
            *p = [50.0 * p[0] + 1e3, 50.0 * p[1], 50.0 * p[2]];
        }
        let geodesics = HeatGeodesics::of(&sphere, 1.0).unwrap();
        let place = |v: usize| {
            let p = sphere.positions[v];
            [(p[0] - 1e3) / 50.0, p[1] / 50.0, p[2] / 50.0]
        };
        for source in [0, 777] {
            let found = geodesics.distances(&[source]).unwrap();
            let mut worst = 0.0_f64;
            for (v, found) in found.iter().enumerate() {
                let (a, b) = (place(source), place(v));
                let cosine = (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]).clamp(-1.0, 1.0);
                worst = worst.max((found / 50.0 - cosine.acos()).abs());
            }
            assert_eq!(found[source], 0.0);
            assert!(worst < 0.03, "{worst}");
        }
    }

    #[test]
    fn a_square_has_straight_lines_and_several_sources_share_it() {
        let square = samples::grid_square(60);
        let geodesics = HeatGeodesics::of(&square, 1.0).unwrap();
        let corners = [0, square.positions.len() - 1];
        let both = geodesics.distances(&corners).unwrap();
        let one = geodesics.distances(&corners[..1]).unwrap();
        for (v, p) in square.positions.iter().enumerate() {
            let to = |c: usize| {
                let q = square.positions[corners[c]];
                (p[0] - q[0]).hypot(p[1] - q[1])
            };
            assert!((one[v] - to(0)).abs() < 0.03, "{v}: {} {}", one[v], to(0));
            assert!((both[v] - to(0).min(to(1))).abs() < 0.05, "{v}: {}", both[v]);
        }
    }

    #[test]
    fn threads_change_no_bit() {
        let sphere = samples::icosphere(4);
        let on = |threads: usize| {
            on_threads(Some(threads), || {
                HeatGeodesics::of(&sphere, 1.0).and_then(|of| of.distances(&[0, 777]))
            })
            .unwrap()
            .unwrap()
        };
        let one = on(1);
        assert!([2, 5].into_iter().all(|threads| on(threads) == one));
    }

    /// The exact distances from the nearest of `sources` on the unit sphere.
    fn great_circles(sphere: &TriMesh, sources: &[usize]) -> Vec<f64> {
        let nearest = |p: &[f64; 3]| {
            let to = |v: &usize| p.iter().zip(sphere.positions[*v]).map(|(a, b)| a * b).sum::<f64>();
            sources.iter().map(to).fold(-1.0_f64, f64::max).min(1.0).acos()
        };
        sphere.positions.iter().map(nearest).collect()
    }

    #[test]
    fn distances_from_a_patch_of_sources_begin_at_its_border() {
        let sphere = samples::icosphere(3);
        let edge = (16.0 * std::f64::consts::PI / (3.0_f64.sqrt() * sphere.triangles.len() as f64)).sqrt();
        let geodesics = HeatGeodesics::of(&sphere, 1.0).unwrap();
        let n = sphere.positions.len();
        let sources: Vec<usize> = (0..n).filter(|v| sphere.positions[*v][2] > 0.5).collect();
        let found = geodesics.distances(&sources).unwrap();
        for (v, (found, exact)) in found.iter().zip(great_circles(&sphere, &sources)).enumerate() {
            assert!((found - exact).abs() < 0.5 * edge, "{v}: {found} {exact}");
        }
        let pole = (0..n).max_by(|a, b| sphere.positions[*a][2].total_cmp(&sphere.positions[*b][2])).unwrap();
        assert_eq!(found[pole], 0.0);
        // Without a vertex that is none, there is no border.
        let all: Vec<usize> = (0..n).collect();
        assert!(geodesics.distances(&all).unwrap().iter().all(|d| *d == 0.0));
    }

    #[test]
    fn many_sources_leave_no_bias() {
        let sphere = samples::icosphere(3);
        let geodesics = HeatGeodesics::of(&sphere, 1.0).unwrap();
        let sources: Vec<usize> = (0..30).map(|i| 21 * i).collect();
        let found = geodesics.distances(&sources).unwrap();
        let exact = great_circles(&sphere, &sources);
        let error = found.iter().zip(exact).map(|(found, exact)| (found - exact).abs()).sum::<f64>();
        assert!(error < 0.06 * found.len() as f64, "{}", error / found.len() as f64);
        // One that is given twice counts once.
        let doubled = [&sources[..], &sources[..3], &sources[..1]].concat();
        assert_eq!(geodesics.distances(&doubled).unwrap(), found);
    }

    #[test]
    fn corners_at_one_distance_stay_so() {
        // Heat is equal at the three corners of the face opposite the source.
        let mut corner = TriMesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
            ..TriMesh::default()
        };
        for angle in [0.0_f64, 0.3, 1.1] {
            let (sin, cos) = angle.sin_cos();
            for p in &mut corner.positions {
                *p = [p[2], cos * p[0] - sin * p[1], sin * p[0] + cos * p[1]];
            }
            let found = HeatGeodesics::of(&corner, 1.0).unwrap().distances(&[0]).unwrap();
            assert!(found[0].abs() < 1e-5, "{found:?}");
            // Each face at the source is a right triangle that heat leaves across the middle of its long side.
            for far in &found[1..] {
                assert!((far - std::f64::consts::FRAC_1_SQRT_2).abs() < 1e-4, "{found:?}");
            }
        }
    }

    #[test]
    fn other_pieces_are_infinitely_far_away_and_what_is_no_vertex_is_refused() {
        let mut two = samples::icosphere(2);
        let n = two.positions.len();
        two.positions.extend_from_within(..);
        two.positions[n..].iter_mut().for_each(|p| p[0] += 10.0);
        two.positions.push([0.0; 3]);
        two.triangles.extend_from_within(..);
        let half = two.triangles.len() / 2;
        two.triangles[half..].as_flattened_mut().iter_mut().for_each(|v| *v += n as u32);
        let geodesics = HeatGeodesics::of(&two, 1.0).unwrap();
        let found = geodesics.distances(&[3]).unwrap();
        assert!(found[..n].iter().all(|d| d.is_finite()) && found[n..].iter().all(|d| d.is_infinite()));
        for bad in [&[][..], &[2 * n], &[2 * n + 1]] {
            assert!(geodesics.distances(bad).is_err(), "{bad:?}");
        }
        for time in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e12] {
            assert!(HeatGeodesics::of(&two, time).is_err(), "{time}");
        }
        let long = HeatGeodesics::of(&two, 1e6).unwrap().distances(&[3]).unwrap();
        assert!(long[..n].iter().all(|d| (0.0..3.4).contains(d)) && long[..n].iter().any(|d| *d > 2.9));
    }

    #[test]
    fn a_mesh_without_area_is_refused() {
        let line = TriMesh {
            positions: (0..4).map(|i| [f64::from(i), 0.0, 0.0]).collect(),
            triangles: vec![[0, 1, 2], [1, 2, 3]],
            ..TriMesh::default()
        };
        assert!(matches!(HeatGeodesics::of(&line, 1.0), Err(HarmonicsError::ZeroArea { .. })));
    }

    #[test]
    fn a_piece_with_hardly_an_area_is_a_line_and_one_without_is_left_out() {
        let sphere = samples::icosphere(3);
        let n = sphere.positions.len();
        let alone = HeatGeodesics::of(&sphere, 1.0).unwrap().distances(&[3]).unwrap();
        for end in [[7.0, 0.0, 0.0], [7.0, 1e-12, 0.0]] {
            let mut two = sphere.clone();
            two.positions.extend([[5.0, 0.0, 0.0], [6.0, 0.0, 0.0], end]);
            let line = [0, 1, 2].map(|i| (n + i) as u32);
            two.triangles.push(line);
            let geodesics = HeatGeodesics::of(&two, 1.0).unwrap();
            let found = geodesics.distances(&[3]).unwrap();
            assert!(found.iter().zip(&alone).all(|(a, b)| (a - b).abs() < 1e-3));
            assert!(found[n..].iter().all(|d| d.is_infinite()));
            match geodesics.distances(&[n]) {
                Ok(along) => {
                    assert!((0..3).all(|i| (along[n + i] - i as f64).abs() < 1e-4), "{:?}", &along[n..])
                }
                Err(why) => assert!(end[1] == 0.0 && matches!(why, HarmonicsError::NotOnSurface { .. })),
            }
        }
    }

    #[test]
    fn a_way_that_no_heat_goes_is_refused() {
        // A strip of three thousand squares.
        let positions =
            (0..3000).flat_map(|i| [[f64::from(i), 0.0, 0.0], [f64::from(i), 1.0, 0.0]]).collect();
        let squares = (0..2999).map(|i| 2 * i);
        let triangles = squares.flat_map(|v| [[v, v + 2, v + 1], [v + 1, v + 2, v + 3]]).collect();
        let strip = TriMesh { positions, triangles, ..TriMesh::default() };
        let short = HeatGeodesics::of(&strip, 1.0).unwrap();
        assert!(matches!(short.distances(&[0]), Err(HarmonicsError::TooFar { .. })));
        let long = HeatGeodesics::of(&strip, 100.0).unwrap().distances(&[0]).unwrap();
        assert!((long[5998] - 2999.0).abs() < 3.0, "{}", long[5998]);
    }
}
