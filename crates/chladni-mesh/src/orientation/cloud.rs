//! Points spread evenly over a surface, with its normals.

use std::collections::HashMap;

use kiddo::{ImmutableKdTree, SquaredEuclidean};

use crate::surface::vec3::{Vec3, add, dot, length, scaled, sub};
use crate::surface::{Bounds, corners, doubled_area_normal};

/// A surface as points of equal area, centered at its centroid and scaled to a diagonal of 1.
pub(super) struct Cloud {
    pub points: Vec<Vec3>,
    /// Outward as far as can be determined.
    pub normals: Vec<Vec3>,
    /// Vertices, thinned out if there are very many: they include tips that the points may miss.
    pub vertices: Vec<Vec3>,
    /// The surface's area.
    pub area: f64,
    /// The opening of a surface that is not closed, as a vector: its area times its outward normal.
    pub opening: Vec3,
    tree: ImmutableKdTree<f64, 3>,
}

/// At most this many vertices are used.
const MOST_VERTICES: usize = 6000;

impl Cloud {
    /// `None` where the surface has no area. `positions` are used by `triangles`, all of them.
    pub fn of(positions: &[Vec3], triangles: &[[u32; 3]], count: usize) -> Option<Self> {
        let mut area = 0.0;
        let (mut centroid, mut missing) = ([0.0; 3], [0.0; 3]);
        let mut areas = Vec::with_capacity(triangles.len());
        for triangle in triangles {
            let at = corners(positions, triangle);
            let normal = scaled(doubled_area_normal(at), 0.5);
            let own = length(normal);
            area += own;
            areas.push(area);
            centroid = add(centroid, scaled(add(add(at[0], at[1]), at[2]), own / 3.0));
            missing = sub(missing, normal);
        }
        let center = scaled(centroid, 1.0 / area);
        let diagonal = Bounds::of(positions.iter().copied()).diagonal();
        if !(area > 0.0 && diagonal > 0.0 && center.iter().all(|c| c.is_finite()) && diagonal.is_finite()) {
            return None;
        }
        let unscaled = 1.0 / diagonal;
        let placed = |p: Vec3| scaled(sub(p, center), unscaled);
        let (mut points, mut normals) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let mut outward = 0.0;
        let mut t = 0;
        for i in 0..count {
            let wanted = area * (i as f64 + 0.5) / count as f64;
            while t + 1 < areas.len() && areas[t] < wanted {
                t += 1;
            }
            let at = corners(positions, &triangles[t]);
            let normal = crate::surface::vec3::unit(doubled_area_normal(at));
            let point = placed(within(at, i));
            outward += dot(normal, point);
            points.push(point);
            normals.push(normal);
        }
        if outward < 0.0 {
            normals.iter_mut().for_each(|n| *n = scaled(*n, -1.0));
            missing = scaled(missing, -1.0);
        }
        let step = positions.len().div_ceil(MOST_VERTICES).max(1);
        let tree = ImmutableKdTree::<f64, 3>::new_from_slice(&points).ok()?;
        Some(Self {
            points,
            normals,
            vertices: positions.iter().step_by(step).map(|p| placed(*p)).collect(),
            area: area * unscaled * unscaled,
            opening: scaled(missing, unscaled * unscaled),
            tree,
        })
    }

    /// The point nearest to `p`, and how far it is.
    pub fn nearest(&self, p: Vec3) -> (usize, f64) {
        let found = self.tree.query(&p).nearest_one::<SquaredEuclidean<f64>>().execute();
        let i = found.item as usize;
        (i, length(sub(self.points[i], p)))
    }

    /// The lowest and the highest coordinate along `direction`.
    pub fn span(&self, direction: Vec3) -> (f64, f64) {
        self.vertices.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
            let x = dot(*p, direction);
            (low.min(x), high.max(x))
        })
    }

    /// How much the surface bends within `radius` of each point: 1 minus the length of the mean normal.
    pub fn roughness(&self, radius: f64) -> Vec<f64> {
        let key = |p: Vec3| p.map(|c| (c / radius).floor() as i32);
        let mut cells: HashMap<[i32; 3], Vec<usize>> = HashMap::new();
        for (i, p) in self.points.iter().enumerate() {
            cells.entry(key(*p)).or_default().push(i);
        }
        let near = |p: Vec3| {
            let [i, j, k] = key(p);
            let around = (-1..=1)
                .flat_map(move |a| (-1..=1).flat_map(move |b| (-1..=1).map(move |c| [i + a, j + b, k + c])));
            around.filter_map(|cell| cells.get(&cell)).flatten()
        };
        let rough = |p: &Vec3| {
            let (mut sum, mut count) = ([0.0; 3], 0.0);
            for &i in near(*p) {
                if length(sub(self.points[i], *p)) < radius {
                    sum = add(sum, self.normals[i]);
                    count += 1.0;
                }
            }
            1.0 - length(sum) / f64::max(count, 1.0)
        };
        self.points.iter().map(rough).collect()
    }
}

/// The `i`th point of a sequence that fills a triangle evenly (Roberts' R2).
fn within([a, b, c]: [Vec3; 3], i: usize) -> Vec3 {
    const R2: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2];
    let [mut u, mut v] = R2.map(|step| (0.5 + step * (i + 1) as f64).fract());
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    add(a, add(scaled(sub(b, a), u), scaled(sub(c, a), v)))
}
