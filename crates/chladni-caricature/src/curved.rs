//! Where a surface bends: regions by curvature.

use std::fmt;
use std::str::FromStr;

use chladni_mesh::surface::vec3::Vec3;
use chladni_mesh::surface::{
    Principal, averaged_curvature, averaging_passes, facing_outward, vertex_areas, vertex_neighbors,
    vertex_triangles,
};

use crate::{CaricatureError, Painted};

/// Which way a surface bends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bend {
    /// Outward, as a nose does: the greatest mean curvature (κ₁ + κ₂) / 2.
    Bumps,
    /// Inward, as the corner of an eye does: the least.
    Hollows,
    /// Either way, as lips do: the greatest curvedness √((κ₁² + κ₂²) / 2) (Koenderink & van Doorn 1992).
    Both,
}

/// The places of a surface that bend most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curved {
    /// Which way.
    pub bend: Bend,
    /// The share of the area that they are, in (0, 1].
    pub share: f64,
}

/// How far normals and curvatures are averaged, as a share of the size √(A/π).
const SMOOTHING: f64 = 0.015;

impl Curved {
    /// The share where none is given.
    pub const USUAL_SHARE: f64 = 0.2;

    /// χ01, one value for each of `positions`: 1 at the vertices that bend most, up to the share of the area, and 0
    /// elsewhere. Normals and curvatures are averaged over 1.5 % of the size first. Outward is away from the inside, also
    /// where `triangles` face inward.
    ///
    /// # Panics
    /// If a triangle names a vertex that is not there.
    pub fn painted(&self, positions: &[Vec3], triangles: &[[u32; 3]]) -> Painted {
        let triangles = &facing_outward(positions, triangles);
        let areas = vertex_areas(positions, triangles);
        let bends = self.bends(positions, triangles, &areas);
        let mut order: Vec<usize> = (0..positions.len()).filter(|v| areas[*v] > 0.0).collect();
        order.sort_by(|a, b| bends[*b].total_cmp(&bends[*a]).then(a.cmp(b)));
        let whole = areas.iter().sum::<f64>();
        // All of it is all, though sums are rounded.
        let mut left = (self.share + 1e-9) * whole;
        let mut values = vec![0.0; positions.len()];
        for v in order {
            left -= areas[v];
            if left < 0.0 {
                break;
            }
            values[v] = 1.0;
        }
        Painted::Vertices(values.into())
    }

    /// How much each vertex bends that way.
    fn bends(&self, positions: &[Vec3], triangles: &[[u32; 3]], areas: &[f64]) -> Vec<f64> {
        let n = positions.len();
        let around = vertex_triangles(n, triangles);
        let neighbors = vertex_neighbors(n, triangles);
        let passes = averaging_passes(areas, SMOOTHING);
        let (normals, tensors) = averaged_curvature(positions, triangles, areas, &around, &neighbors, passes);
        let bend = |(tensor, normal): (_, &Vec3)| {
            let [a, b] = Principal::of(tensor, *normal).values;
            match self.bend {
                Bend::Bumps => a + b,
                Bend::Hollows => -a - b,
                Bend::Both => a.hypot(b),
            }
        };
        tensors.into_iter().zip(&normals).map(bend).collect()
    }
}

/// `bumps`, `hollows` or `both`, and the share of the area: `bumps:10%`.
impl FromStr for Curved {
    type Err = CaricatureError;

    fn from_str(text: &str) -> Result<Self, CaricatureError> {
        let bad = |why| CaricatureError::syntax("curvature", text, why);
        let (bend, share) = text.split_once(':').map_or((text, None), |(bend, share)| (bend, Some(share)));
        let bend = match bend.trim() {
            "bumps" => Bend::Bumps,
            "hollows" => Bend::Hollows,
            "both" => Bend::Both,
            _ => return Err(bad("must be bumps, hollows or both")),
        };
        let percent =
            |text: &str| text.trim().strip_suffix('%')?.parse().ok().map(|percent: f64| percent / 100.0);
        let share = match share {
            None => Self::USUAL_SHARE,
            Some(share) => percent(share)
                .filter(|share| *share > 0.0 && *share <= 1.0)
                .ok_or_else(|| bad("the share of the surface must be above 0% and up to 100%"))?,
        };
        Ok(Self { bend, share })
    }
}

impl fmt::Display for Curved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bend = match self.bend {
            Bend::Bumps => "bumps",
            Bend::Hollows => "hollows",
            Bend::Both => "both",
        };
        write!(f, "{bend}:{}%", 100.0 * self.share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_mesh::samples::torus;

    #[test]
    fn the_outside_of_a_ring_is_a_bump_and_its_inside_the_hollow() {
        let ring = torus(0.3, 96, 48);
        let areas = vertex_areas(&ring.positions, &ring.triangles);
        let total: f64 = areas.iter().sum();
        let reach = |p: &Vec3| {
            let mut squares = p.map(|x| x * x);
            squares.sort_by(f64::total_cmp);
            (squares[1] + squares[2]).sqrt()
        };
        for (bend, outside) in [(Bend::Bumps, true), (Bend::Hollows, false)] {
            for share in [0.1, 0.3] {
                let painted = Curved { bend, share }.painted(&ring.positions, &ring.triangles);
                let values = painted.values(&ring.positions).to_vec();
                let taken: f64 = values.iter().zip(&areas).map(|(x, a)| f64::from(*x) * a).sum();
                assert!((taken / total - share).abs() < 0.02, "{bend:?}: {}", taken / total);
                // The mean curvature of a torus grows with the distance from its axis.
                let inside = |want: f32| {
                    let of = ring.positions.iter().zip(&values).filter(move |(_, x)| **x == want);
                    of.map(|(p, _)| reach(p)).collect::<Vec<f64>>()
                };
                let mean = |v: Vec<f64>| v.iter().sum::<f64>() / v.len() as f64;
                assert_eq!(mean(inside(1.0)) > mean(inside(0.0)), outside, "{bend:?} {share}");
            }
        }
    }

    #[test]
    fn all_of_a_surface_leaves_no_vertex_out() {
        for (around, across) in [(12, 6), (24, 12), (31, 17), (96, 48)] {
            let ring = torus(0.3, around, across);
            for bend in [Bend::Bumps, Bend::Hollows, Bend::Both] {
                let painted = Curved { bend, share: 1.0 }.painted(&ring.positions, &ring.triangles);
                let left_out = painted.values(&ring.positions).iter().filter(|x| **x < 1.0).count();
                assert_eq!(left_out, 0, "{bend:?} of {around} by {across}");
            }
        }
    }

    #[test]
    fn a_surface_inside_out_bends_the_same_way() {
        let ring = torus(0.3, 32, 16);
        let turned: Vec<[u32; 3]> = ring.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
        for bend in [Bend::Bumps, Bend::Hollows] {
            let painted =
                |triangles: &[[u32; 3]]| Curved { bend, share: 0.2 }.painted(&ring.positions, triangles);
            assert_eq!(painted(&turned), painted(&ring.triangles), "{bend:?}");
        }
    }

    #[test]
    fn curvature_is_parsed_as_printed() {
        for text in ["bumps:20%", "hollows:5%", "both:100%"] {
            assert_eq!(text.parse::<Curved>().unwrap().to_string(), text);
        }
        assert_eq!("bumps".parse::<Curved>().unwrap().share, Curved::USUAL_SHARE);
        for bad in ["", "bump", "bumps:", "bumps:20", "bumps:0%", "bumps:101%", "bumps:NaN%"] {
            assert!(bad.parse::<Curved>().is_err(), "{bad}");
        }
    }
}
