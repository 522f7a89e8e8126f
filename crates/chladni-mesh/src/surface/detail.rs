//! Coarser triangles over a subset of the vertices.

use std::collections::HashSet;

use meshopt::{SimplifyOptions, simplify_decoder};

/// A shape over the vertices of a larger one.
#[derive(Clone, Debug, PartialEq)]
pub struct Detail {
    /// Triangles over the larger shape's vertices.
    pub triangles: Vec<[u32; 3]>,
    /// How many vertices they name.
    pub vertices: usize,
}

/// Shapes of about as many vertices as `wanted` says, in falling order; what is drawn through them
/// moves exactly as the whole does.
///
/// Vertices are collapsed into neighbors one by one, the one that changes the surface least first (quadric
/// error metric: Garland and Heckbert 1997), with triangles kept even, as shapes bend where they are flat at
/// rest. A shape that cannot become as small as wanted ends with fewer details.
pub fn details(positions: &[[f32; 3]], triangles: &[[u32; 3]], wanted: &[usize]) -> Vec<Detail> {
    let inside = |t: &&[u32; 3]| t.iter().all(|v| (*v as usize) < positions.len());
    let mut indices: Vec<u32> = triangles.iter().filter(inside).flatten().copied().collect();
    let mut details = Vec::new();
    for &count in wanted {
        // A closed surface without handles has two triangles a vertex, less four.
        let target = (6 * count).saturating_sub(12);
        indices = simplify_decoder(&indices, positions, target, f32::MAX, SimplifyOptions::Regularize, None);
        if indices.is_empty() || indices.len() > target {
            break;
        }
        let triangles: Vec<[u32; 3]> = indices.as_chunks().0.to_vec();
        let named: HashSet<u32> = indices.iter().copied().collect();
        details.push(Detail { triangles, vertices: named.len() });
    }
    details
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::doubled_area_normal;
    use crate::surface::vec3::{Vec3, cross, dot, length, single};
    use crate::{TriMesh, samples};
    use std::collections::HashMap;

    fn positions(mesh: &TriMesh) -> Vec<[f32; 3]> {
        single(&mesh.positions)
    }

    /// How often each edge is there in each direction.
    fn directed(triangles: &[[u32; 3]]) -> HashMap<[u32; 2], usize> {
        let mut edges = HashMap::new();
        for [a, b, c] in triangles {
            [[*a, *b], [*b, *c], [*c, *a]].into_iter().for_each(|edge| *edges.entry(edge).or_default() += 1);
        }
        edges
    }

    #[test]
    fn levels_of_the_octopus_are_closed_and_lie_on_it() {
        let mesh = samples::sample("octopus").expect("it is there");
        let positions = positions(&mesh);
        let area = |triangles: &[[u32; 3]]| {
            0.5 * triangles.iter().map(|t| length(normal(&positions, t))).sum::<f64>()
        };
        let (whole, volume) = (area(&mesh.triangles), volume(&positions, &mesh.triangles));
        let found = details(&positions, &mesh.triangles, &[4000, 1300]);
        assert_eq!(found.iter().map(|detail| detail.vertices).collect::<Vec<_>>(), [4000, 1300]);
        for detail in &found {
            let named: HashSet<u32> = detail.triangles.iter().flatten().copied().collect();
            assert_eq!(named.len(), detail.vertices);
            // Closed, oriented and of one piece without a handle, as the octopus is.
            assert_eq!(detail.triangles.len(), 2 * detail.vertices - 4);
            let edges = directed(&detail.triangles);
            assert!(edges.iter().all(|([a, b], count)| *count == 1 && edges.contains_key(&[*b, *a])));
            let (area, volume) =
                (area(&detail.triangles) / whole, self::volume(&positions, &detail.triangles) / volume);
            assert!((0.97..1.01).contains(&area) && (0.97..1.01).contains(&volume), "{area} {volume}");
        }
        assert_eq!(found, details(&positions, &mesh.triangles, &[4000, 1300]));
    }

    /// As long as twice the triangle's area.
    fn normal(positions: &[[f32; 3]], triangle: &[u32; 3]) -> Vec3 {
        doubled_area_normal(triangle.map(|v| positions[v as usize].map(f64::from)))
    }

    fn volume(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> f64 {
        let at = |v: u32| positions[v as usize].map(f64::from);
        let of = |[a, b, c]: &[u32; 3]| dot(at(*a), cross(at(*b), at(*c))) / 6.0;
        triangles.iter().map(of).sum()
    }

    #[test]
    fn a_border_stays() {
        // A flat square of 20 × 20 cells.
        let n = 21_u32;
        let positions: Vec<[f32; 3]> = (0..n * n).map(|i| [(i % n) as f32, (i / n) as f32, 0.0]).collect();
        let cells = (0..n * n).filter(|i| i % n < n - 1 && i / n < n - 1);
        let triangles: Vec<[u32; 3]> =
            cells.flat_map(|i| [[i, i + 1, i + n], [i + n, i + 1, i + n + 1]]).collect();
        let detail = details(&positions, &triangles, &[50]).pop().expect("it becomes smaller");
        let edges = directed(&detail.triangles);
        let border = edges.keys().filter(|[a, b]| !edges.contains_key(&[*b, *a]));
        let on_side = |v: u32| positions[v as usize][..2].iter().any(|c| *c == 0.0 || *c == 20.0);
        assert!(border.flatten().all(|v| on_side(*v)));
        let area: f64 = detail.triangles.iter().map(|t| 0.5 * normal(&positions, t)[2]).sum();
        assert!((area - 400.0).abs() < 1e-9, "{area}");
    }

    #[test]
    fn hostile_shapes_keep_the_promises() {
        let mut chance = chladni_testdata::chance(7);
        let mut draw = |below: usize| (chance() >> 33) as usize % below;
        let extremes =
            [0.0, -0.0, 1.0, 1.0 + f32::EPSILON, f32::MIN_POSITIVE, 1e-45, 1e20, -1e20, f32::MAX, f32::MIN];
        for case in 0..200 {
            let count = 1 + draw(40);
            // Few values, so that vertices coincide and triangles collapse; all of them, or those of a usual shape.
            let usual = case % 2 == 0;
            let values = if usual { &extremes[..4] } else { &extremes[..] };
            let positions: Vec<[f32; 3]> =
                (0..count).map(|_| std::array::from_fn(|_| values[draw(values.len())])).collect();
            // Corners repeat within a triangle, triangles repeat, and some name vertices that are not there.
            let mut triangles: Vec<[u32; 3]> = (0..1 + draw(120))
                .map(|_| std::array::from_fn(|_| draw(count + usize::from(case % 3 == 0)) as u32))
                .collect();
            let last = u32::try_from(positions.len()).expect("few");
            triangles.extend([triangles[0], [0; 3], [last, u32::MAX, 0]]);
            let wanted = [count, count / 2, count / 4, 1, 0];
            let found = details(&positions, &triangles, &wanted);
            assert!(found.len() <= wanted.len(), "{case}");
            for (detail, wanted) in found.iter().zip(wanted) {
                let named: HashSet<u32> = detail.triangles.iter().flatten().copied().collect();
                assert!(named.iter().all(|v| *v < last), "{case}: a vertex that is not there");
                assert_eq!(named.len(), detail.vertices, "{case}");
                assert!(!detail.triangles.is_empty() && 3 * detail.triangles.len() <= 6 * wanted, "{case}");
            }
            assert_eq!(found, details(&positions, &triangles, &wanted), "{case}: by chance");
        }
    }

    #[test]
    fn what_cannot_become_smaller_stays() {
        let ring = [[0, 1, 2], [2, 1, 0]];
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, f32::NAN]];
        assert!(details(&corners, &ring, &[2]).is_empty());
        assert!(details(&[], &[], &[5]).iter().all(|detail| detail.triangles.is_empty()));
        assert!(details(&corners, &[[0, 1, 7]], &[2]).iter().all(|detail| detail.triangles.is_empty()));
    }
}
