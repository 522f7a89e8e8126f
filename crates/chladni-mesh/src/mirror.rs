//! The plane in which a shape comes closest to its own mirror image.

use std::collections::HashMap;

use chladni_task::{Cancelled, Task};
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;

use crate::eigen::symmetric_eigen;
use crate::surface::vec3::{Vec3, add, dot, length, scaled, sub, unit};
use crate::surface::{Bounds, BoxTree, closest_on_triangle, corners, doubled_area_normal, mixed};
use crate::{Rows, vertex_triangles};

/// The plane {p : normal · p = offset}, and how far the shape is from being symmetric in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirrorPlane {
    /// Unit normal; its largest component is positive.
    pub normal: [f64; 3],
    /// Distance from the origin along the normal.
    pub offset: f64,
    /// The estimate's error, how far mirrored vertices miss the surface: root mean square over
    /// the best nine tenths of the vertices, as a share of the bounding box's diagonal.
    pub misfit: f64,
}

impl MirrorPlane {
    /// The largest misfit of a plane in which a shape can be called symmetric.
    pub const TOLERANCE: f64 = 0.015;

    /// Whether the shape can be called symmetric in this plane.
    pub fn fits(&self) -> bool {
        self.misfit <= Self::TOLERANCE
    }

    /// The mirror image of `p`.
    pub fn image(&self, p: [f64; 3]) -> [f64; 3] {
        sub(p, scaled(self.normal, 2.0 * (dot(self.normal, p) - self.offset)))
    }

    /// The mirror image of `other`; its misfit is not known.
    fn image_of(&self, other: &Self) -> Self {
        let through_origin = Self { offset: 0.0, ..*self };
        let normal = signed(through_origin.image(other.normal));
        let point = self.image(scaled(other.normal, other.offset));
        Self { normal, offset: dot(normal, point), misfit: 1.0 }
    }

    /// Whether the two are no more than about 8° apart.
    fn is_near(&self, other: &Self) -> bool {
        dot(self.normal, other.normal).abs() > 0.99
    }
}

/// A point of a surface: corners of a triangle and their weights.
pub type OnSurface = ([u32; 3], [f64; 3]);

/// A distance squared, a point, and the point that its mirror image comes to lie on.
type Pair = (f64, Vec3, Vec3);

/// Vertices on which candidates are tested.
const JUDGES: usize = 600;
/// Vertices that the plane is refined on in the end, and that its misfit is measured on.
const FINAL_JUDGES: usize = 6000;
/// Directions over the half sphere that are tried besides those that the shape suggests. Every normal is
/// within 13° of one of them, near enough for refinement.
const DIRECTIONS: usize = 64;
/// Candidates that are refined, none near another: exact copies of one plane would leave no place for the others.
const FINALISTS: usize = 12;
/// The most planes after their images in one another have been added: a body of revolution has any number.
const MOST_PLANES: usize = 32;
/// Planes whose misfits are below this fit equally well: refinement ends before those of a shape with flat faces are 0.
const EQUALLY_WELL: f64 = 1e-3;
/// Around a vertex of more triangles the nearest is searched for in a tree.
const FEW_TRIANGLES: usize = 64;

/// A surface ready to be compared with its mirror images.
pub struct MirrorSearch<'a> {
    positions: &'a [Vec3],
    triangles: &'a [[u32; 3]],
    tree: ImmutableKdTree<f64, 3>,
    around: Rows,
    /// Of each vertex with more than [`FEW_TRIANGLES`], these by their directions from it.
    fans: HashMap<usize, BoxTree>,
    diagonal: f64,
}

impl std::fmt::Debug for MirrorSearch<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("MirrorSearch").field("vertices", &self.positions.len()).finish_non_exhaustive()
    }
}

impl<'a> MirrorSearch<'a> {
    /// `None` where there is no vertex or no finite extent.
    ///
    /// # Panics
    /// If a triangle names a vertex that is not there.
    pub fn of(positions: &'a [[f64; 3]], triangles: &'a [[u32; 3]]) -> Option<Self> {
        let diagonal = Bounds::of(positions.iter().copied()).diagonal();
        let finite = diagonal.is_finite() && positions.iter().flatten().all(|c| c.is_finite());
        if positions.is_empty() || !finite {
            return None;
        }
        let tree = ImmutableKdTree::<f64, 3>::new_from_slice(positions).ok()?;
        let around = vertex_triangles(positions.len(), triangles);
        let many = (0..positions.len()).filter(|v| around.row(*v).len() > FEW_TRIANGLES);
        let fans = many.map(|v| (v, fan(positions, triangles, v, around.row(v)))).collect();
        Some(Self { positions, triangles, tree, around, fans, diagonal: diagonal.max(f64::MIN_POSITIVE) })
    }

    /// The plane in which the shape comes closest to its mirror image, whichever way it stands. A shape
    /// without symmetry gets a plane, too, with a large misfit. `hints` are further normals to try, of any
    /// length.
    ///
    /// Where several planes fit about as well (a box, an eight-armed octopus), it is the one whose
    /// normal is nearest to x: a viewer's left and right. A plane in which the shape itself lies, as a flat sheet in its
    /// own, is none: it would fit any outline. `None` for a single point, which lies in all its planes.
    ///
    /// # Errors
    /// [`Cancelled`] through `task`.
    pub fn best(&self, hints: &[[f64; 3]], task: &Task) -> Result<Option<MirrorPlane>, Cancelled> {
        let few = self.judges(JUDGES);
        let centroid = self.centroid();
        let plane = |normal: Vec3| -> Result<MirrorPlane, Cancelled> {
            let normal = signed(unit(normal));
            let plane = MirrorPlane { normal, offset: dot(normal, centroid), misfit: 1.0 };
            Ok(MirrorPlane { misfit: self.misfit(&plane, &few, task)?, ..plane })
        };
        let axes = symmetric_eigen(self.covariance(centroid)).1;
        let coordinates = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let normals = coordinates.into_iter().chain(axes).chain(half_sphere()).chain(hints.iter().copied());
        let normals: Vec<Vec3> = normals.filter(|n| length(*n) > 1e-6).collect();
        let mut candidates: Vec<MirrorPlane> =
            normals.into_par_iter().map(plane).collect::<Result<_, Cancelled>>()?;
        candidates.retain(|plane| !self.lies_in(plane, &few));
        candidates.sort_by(|a, b| preference(a).total_cmp(&preference(b)));
        let mut finalists: Vec<MirrorPlane> = Vec::new();
        for plane in candidates {
            if finalists.len() < FINALISTS && !finalists.iter().any(|known| known.is_near(&plane)) {
                finalists.push(plane);
            }
        }
        let mut planes: Vec<MirrorPlane> = Vec::new();
        for plane in finalists {
            planes.extend(self.refined(plane, &few, task)?);
        }
        self.add_images(&mut planes, &few, task)?;
        let preferred = planes.iter().min_by(|a, b| preference(a).total_cmp(&preference(b))).copied();
        // Several candidates may have become it, one more exactly than the others.
        let copies = planes.iter().filter(|plane| preferred.is_some_and(|known| known.is_near(plane)));
        let best = copies.min_by(|a, b| a.misfit.total_cmp(&b.misfit)).copied();
        best.map(|best| self.refine(best, &self.judges(FINAL_JUDGES), task)).transpose()
    }

    /// Adds the images of those that fit best in one another: the image of a shape's mirror plane in another one is a
    /// third, so that a few give all that a cube has.
    fn add_images(
        &self,
        planes: &mut Vec<MirrorPlane>,
        judges: &[usize],
        task: &Task,
    ) -> Result<(), Cancelled> {
        let mut next = 0;
        while let Some(plane) = planes.get(next).copied() {
            let least = planes.iter().map(|plane| plane.misfit).fold(f64::INFINITY, f64::min);
            let enough = EQUALLY_WELL.max(2.0 * least);
            let is_good = |plane: &MirrorPlane| plane.fits() && plane.misfit <= enough;
            let others = planes.iter().take(next).filter(|other| is_good(&plane) && is_good(other));
            let images: Vec<MirrorPlane> =
                others.flat_map(|other| [plane.image_of(other), other.image_of(&plane)]).collect();
            for image in images {
                let is_known = planes.iter().any(|known| is_good(known) && known.is_near(&image));
                if !is_known && planes.len() < MOST_PLANES {
                    planes.extend(self.refined(image, judges, task)?);
                }
            }
            next += 1;
        }
        Ok(())
    }

    /// `plane` refined, unless the shape lies in what it becomes.
    fn refined(
        &self,
        plane: MirrorPlane,
        judges: &[usize],
        task: &Task,
    ) -> Result<Option<MirrorPlane>, Cancelled> {
        let refined = self.refine(plane, judges, task)?;
        Ok(Some(refined).filter(|refined| !self.lies_in(refined, judges)))
    }

    /// Where `plane` takes each vertex: the nearest point of the surface.
    pub fn image(&self, plane: &MirrorPlane) -> Vec<OnSurface> {
        self.positions.par_iter().map(|p| self.closest(plane.image(*p)).1).collect()
    }

    fn judges(&self, most: usize) -> Vec<usize> {
        (0..self.positions.len()).step_by(self.positions.len().div_ceil(most).max(1)).collect()
    }

    /// Area and centroid of each triangle.
    fn patches(&self) -> impl Iterator<Item = (f64, Vec3)> + '_ {
        self.triangles.iter().map(|t| {
            let at = corners(self.positions, t);
            (length(doubled_area_normal(at)), scaled(add(add(at[0], at[1]), at[2]), 1.0 / 3.0))
        })
    }

    /// A mirror keeps the centroid of the surface.
    fn centroid(&self) -> Vec3 {
        let (area, moment) = self
            .patches()
            .fold((0.0, [0.0; 3]), |(area, moment), (a, p)| (area + a, add(moment, scaled(p, a))));
        if area > 0.0 { scaled(moment, 1.0 / area) } else { self.positions[0] }
    }

    /// A mirror permutes the axes of inertia.
    fn covariance(&self, centroid: Vec3) -> [[f64; 3]; 3] {
        let mut covariance = [[0.0; 3]; 3];
        for (area, p) in self.patches() {
            let p = sub(p, centroid);
            for i in 0..3 {
                (0..3).for_each(|j| covariance[i][j] += area * p[i] * p[j]);
            }
        }
        covariance
    }

    /// The nearest point among the triangles around the nearest vertex, and its squared distance.
    fn closest(&self, p: Vec3) -> (f64, OnSurface) {
        let v = self.tree.query(&p).nearest_one::<SquaredEuclidean<f64>>().execute().item as usize;
        let from_vertex = sub(p, self.positions[v]);
        let reach = dot(from_vertex, from_vertex);
        let (mut best, mut nearest) = ((reach, ([v as u32; 3], [1.0, 0.0, 0.0])), 0);
        let mut compare = |t: u32| {
            let triangle = self.triangles[t as usize];
            let at = corners(self.positions, &triangle);
            let (_, weights) = closest_on_triangle(p, &at);
            let offset = sub(p, mixed(at, weights));
            let distance = dot(offset, offset);
            // Of several as near, the one with the lowest number: their order in the tree is not to decide.
            if distance < best.0 || distance == best.0 && t < nearest {
                (best, nearest) = ((distance, (triangle, weights)), t);
            }
            best.0
        };
        let row = self.around.row(v);
        if let Some(fan) = self.fans.get(&v) {
            let toward = unit(from_vertex);
            // The sine of the angle to a direction, by the square of the chord; from 90° on, the vertex is nearest.
            let nearness = |directions: &Bounds| match directions.distance_squared(toward) {
                chord if chord < 2.0 => reach * (chord - 0.25 * chord * chord),
                _ => reach,
            };
            fan.search(reach, nearness, |slot, _| compare(row[fan.order()[slot] as usize]));
        } else {
            row.iter().for_each(|t| _ = compare(*t));
        }
        best
    }

    /// The best nine tenths of `vertices` with the points that their mirror images come to lie on.
    fn matches(&self, plane: &MirrorPlane, vertices: &[usize], task: &Task) -> Result<Vec<Pair>, Cancelled> {
        let pair = |v: &usize| -> Result<Pair, Cancelled> {
            task.check()?;
            let p = self.positions[*v];
            let (distance, (triangle, weights)) = self.closest(plane.image(p));
            Ok((distance, p, mixed(corners(self.positions, &triangle), weights)))
        };
        let mut matches: Vec<Pair> = vertices.par_iter().map(pair).collect::<Result<_, Cancelled>>()?;
        matches.sort_by(|a, b| a.0.total_cmp(&b.0));
        matches.truncate((vertices.len() * 9).div_ceil(10));
        Ok(matches)
    }

    fn misfit(&self, plane: &MirrorPlane, vertices: &[usize], task: &Task) -> Result<f64, Cancelled> {
        Ok(self.distance(&self.matches(plane, vertices, task)?))
    }

    /// Whether the best nine tenths of `vertices` lie so near to `plane` that it fits whatever they form: the mirror moves
    /// each by twice its distance from the plane, and brings none nearer to the surface. It does so in a thin closed slab,
    /// whose two faces it exchanges.
    fn lies_in(&self, plane: &MirrorPlane, vertices: &[usize]) -> bool {
        let moved = |v: &usize| 2.0 * (dot(plane.normal, self.positions[*v]) - plane.offset) / self.diagonal;
        let mut squares: Vec<f64> = vertices.iter().map(|v| moved(v).powi(2)).collect();
        squares.sort_by(f64::total_cmp);
        squares.truncate((vertices.len() * 9).div_ceil(10));
        let own = (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt();
        own <= MirrorPlane::TOLERANCE && (own < 1e-9 || plane.misfit > 0.5 * own)
    }

    /// Root mean square, as a share of the diagonal.
    fn distance(&self, matches: &[Pair]) -> f64 {
        let mean = matches.iter().map(|m| m.0).sum::<f64>() / matches.len().max(1) as f64;
        mean.sqrt() / self.diagonal
    }

    /// Iterated closest points over reflections: with p matched to q, the best normal is the
    /// eigenvector of least eigenvalue of Σ (p qᵀ + q pᵀ), centered, and the plane passes through
    /// the middle of the two centroids.
    fn refine(&self, plane: MirrorPlane, vertices: &[usize], task: &Task) -> Result<MirrorPlane, Cancelled> {
        let mut matches = self.matches(&plane, vertices, task)?;
        let mut best = MirrorPlane { misfit: self.distance(&matches), ..plane };
        for _ in 0..20 {
            let share = 1.0 / matches.len().max(1) as f64;
            let mean =
                |f: fn(&Pair) -> Vec3| matches.iter().fold([0.0; 3], |sum, m| add(sum, scaled(f(m), share)));
            let (center_p, center_q) = (mean(|m| m.1), mean(|m| m.2));
            let mut b = [[0.0; 3]; 3];
            for (_, p, q) in &matches {
                let (p, q) = (sub(*p, center_p), sub(*q, center_q));
                for i in 0..3 {
                    (0..3).for_each(|j| b[i][j] += p[i] * q[j] + q[i] * p[j]);
                }
            }
            let [.., normal] = symmetric_eigen(b).1;
            let normal = signed(normal);
            let middle = scaled(add(center_p, center_q), 0.5);
            let mut next = MirrorPlane { normal, offset: dot(normal, middle), misfit: 0.0 };
            let closer = self.matches(&next, vertices, task)?;
            next.misfit = self.distance(&closer);
            if next.misfit >= best.misfit * (1.0 - 1e-6) {
                break;
            }
            (best, matches) = (next, closer);
        }
        Ok(best)
    }
}

/// A tree of the triangles in `row`, all of which `vertex` belongs to, by their directions from it: each lies
/// within the cone over an arc of the unit sphere.
fn fan(positions: &[Vec3], triangles: &[[u32; 3]], vertex: usize, row: &[u32]) -> BoxTree {
    let directions = |t: &u32| {
        let sides = triangles[*t as usize].map(|corner| sub(positions[corner as usize], positions[vertex]));
        let ends = Bounds::of(sides.into_iter().filter(|side| length(*side) > 0.0).map(unit));
        let half_chord = 0.5 * ends.diagonal();
        // The arc leaves the box of its ends by no more than its height; rounding may add to that.
        let height = 1.0 - (1.0 - half_chord * half_chord).max(0.0).sqrt() + 1e-9;
        Bounds { low: ends.low.map(|c| c - height), high: ends.high.map(|c| c + height) }
    };
    let boxes: Vec<Bounds> = row.iter().map(directions).collect();
    let centers: Vec<Vec3> = boxes.iter().map(|b| scaled(add(b.low, b.high), 0.5)).collect();
    BoxTree::new(&centers, |item| boxes[item as usize])
}

/// `normal` or its opposite, so that its largest component is positive.
fn signed(normal: Vec3) -> Vec3 {
    let largest = normal.into_iter().fold(0.0, |m: f64, c| if c.abs() > m.abs() { c } else { m });
    scaled(normal, largest.signum())
}

/// Smaller is better.
fn preference(plane: &MirrorPlane) -> f64 {
    (plane.misfit.max(EQUALLY_WELL) + 0.002) * (1.5 - 0.5 * plane.normal[0].abs())
}

/// Directions spread evenly over the half sphere x ≥ 0, along a Fibonacci spiral.
fn half_sphere() -> impl Iterator<Item = Vec3> {
    let golden_angle = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..DIRECTIONS).map(move |i| {
        let x = (i as f64 + 0.5) / DIRECTIONS as f64;
        let (sin, cos) = (golden_angle * i as f64).sin_cos();
        let radius = (1.0 - x * x).sqrt();
        [x, radius * cos, radius * sin]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::sample;

    /// Turned so that no axis of coordinates stays an axis of the shape.
    fn turned(p: Vec3) -> Vec3 {
        let turn = |[x, y]: [f64; 2], angle_rad: f64| {
            let (sin, cos) = angle_rad.sin_cos();
            [cos * x - sin * y, sin * x + cos * y]
        };
        let [x, y] = turn([p[0], p[1]], 0.7);
        let [y, z] = turn([y, p[2]], 0.6);
        [x + 3.0, y - 1.0, z + 0.5]
    }

    #[test]
    fn the_plane_of_a_head_is_found_however_it_is_turned() {
        let head = sample("head").unwrap();
        let task = Task::new();
        let straight = MirrorSearch::of(&head.positions, &head.triangles).unwrap();
        let plane = straight.best(&[], &task).unwrap().unwrap();
        assert!(plane.misfit < 1e-3 && plane.normal[0] > 0.9999, "{plane:?}");

        let positions: Vec<Vec3> = head.positions.iter().map(|p| turned(*p)).collect();
        let search = MirrorSearch::of(&positions, &head.triangles).unwrap();
        let found = search.best(&[], &task).unwrap().unwrap();
        let direction = sub(turned([1.0, 0.0, 0.0]), turned([0.0; 3]));
        assert!(found.misfit < 1e-3, "{found:?}");
        assert!(dot(found.normal, direction).abs() > 0.9999, "{found:?} for {direction:?}");
        // No plane across a coordinate axis comes close, so a search among those three would fail.
        for axis in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
            let offset = dot(axis, search.centroid());
            let across = MirrorPlane { normal: axis, offset, misfit: 0.0 };
            let misfit = search.misfit(&across, &search.judges(JUDGES), &task).unwrap();
            assert!(misfit > 10.0 * found.misfit);
        }
        // The image of a vertex lies where the plane takes it.
        let images = search.image(&found);
        let far = positions.iter().zip(images).map(|(p, (triangle, weights))| {
            length(sub(found.image(*p), mixed(corners(&positions, &triangle), weights)))
        });
        assert!(far.fold(0.0, f64::max) < 0.02 * search.diagonal);
    }

    #[test]
    fn what_has_no_mirror_says_so() {
        // Three legs of different lengths and widths on the three axes.
        let mut positions: Vec<Vec3> = Vec::new();
        let mut triangles: Vec<[u32; 3]> = Vec::new();
        for (axis, (reach, width)) in [(1.0, 0.1), (0.5, 0.3), (0.7, 0.02)].into_iter().enumerate() {
            for i in 0..60_u32 {
                let t = f64::from(i) / 60.0;
                let bend = 0.4 * reach * t * t;
                let at = |off: f64| {
                    let mut p = [0.0; 3];
                    (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (reach * t, bend + off, 0.3 * off * t);
                    p
                };
                positions.extend([at(-width), at(width)]);
                let v = positions.len() as u32;
                if i > 0 {
                    triangles.extend([[v - 4, v - 3, v - 2], [v - 3, v - 1, v - 2]]);
                }
            }
        }
        let search = MirrorSearch::of(&positions, &triangles).unwrap();
        let found = search.best(&[], &Task::new()).unwrap().unwrap();
        assert!(found.misfit > 0.02, "{found:?}");
    }

    #[test]
    fn a_flat_sheet_is_not_mirrored_in_its_own_plane() {
        let rectangle: fn(f64, f64) -> [f64; 2] = |s, t| [s, 0.7 * t];
        // It winds inward along a spiral and tapers off.
        let horn: fn(f64, f64) -> [f64; 2] = |s, t| {
            let (sin, cos) = (4.2 * s).sin_cos();
            let radius = 0.3 + s + 0.1 * t * (1.0 - 0.8 * s);
            [radius * cos, radius * sin]
        };
        let at = |i: u32| f64::from(i) / 12.0;
        let cells = (0..12).flat_map(|i| (0..12).map(move |j| 13 * i + j));
        let triangles: Vec<[u32; 3]> =
            cells.flat_map(|v| [[v, v + 1, v + 13], [v + 1, v + 14, v + 13]]).collect();
        for (outline, is_symmetric) in [(rectangle, true), (horn, false)] {
            for axis in 0..3 {
                let vertex = |v: u32| {
                    let (mut p, [x, y]) = ([0.0; 3], outline(at(v / 13), at(v % 13)));
                    (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (x, y);
                    p
                };
                let positions: Vec<Vec3> = (0..169).map(vertex).collect();
                let search = MirrorSearch::of(&positions, &triangles).unwrap();
                let found = search.best(&[], &Task::new()).unwrap().unwrap();
                assert_eq!(found.fits(), is_symmetric, "{found:?}");
                assert!(found.normal[axis].abs() < 0.01 || !is_symmetric, "{found:?}");
            }
        }
    }

    /// A box of `sides` about the origin, each face in 4 × 4 cells.
    fn boxed(sides: Vec3) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for (axis, end) in (0..3).flat_map(|axis| [-0.5, 0.5].map(|end| (axis, end))) {
            let first = positions.len() as u32;
            for (i, j) in (0..5_u32).flat_map(|i| (0..5_u32).map(move |j| (i, j))) {
                let mut p = [end; 3];
                p[(axis + 1) % 3] = f64::from(i) / 4.0 - 0.5;
                p[(axis + 2) % 3] = f64::from(j) / 4.0 - 0.5;
                positions.push(std::array::from_fn(|k| sides[k] * p[k]));
                if i < 4 && j < 4 {
                    let v = first + 5 * i + j;
                    triangles.extend([[v, v + 5, v + 1], [v + 1, v + 5, v + 6]]);
                }
            }
        }
        (positions, triangles)
    }

    #[test]
    fn of_planes_that_fit_as_well_it_is_the_one_nearest_x_however_the_shape_is_turned() {
        let s = std::f64::consts::FRAC_1_SQRT_2;
        let prism = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [s, 0.0, s], [s, 0.0, -s]];
        let others = [[s, s, 0.0], [s, -s, 0.0], [0.0, s, s], [0.0, s, -s]];
        let cube = [&prism[..], &others].concat();
        let task = Task::new();
        for (sides, normals) in [([1.0, 0.5, 1.0], &prism[..]), ([1.0; 3], &cube[..])] {
            let (straight, triangles) = boxed(sides);
            for turn in half_sphere().step_by(16) {
                // A turn about x, and a half turn that takes x to `turn`.
                let axis = unit(add(turn, [1.0, 0.0, 0.0]));
                let (sin, cos) = (7.0 * turn[0]).sin_cos();
                let turned = |[x, y, z]: Vec3| {
                    let p = [x, cos * y - sin * z, sin * y + cos * z];
                    sub(scaled(axis, 2.0 * dot(axis, p)), p)
                };
                let positions: Vec<Vec3> = straight.iter().map(|p| turned(*p)).collect();
                let search = MirrorSearch::of(&positions, &triangles).unwrap();
                let nearest = normals.iter().map(|n| turned(*n)[0].abs()).fold(0.0, f64::max);
                // Hints that are copies of a single plane's normal, as pairs of vertices give them.
                for hints in [vec![], vec![turned([0.0, 0.0, 1.0]); 20]] {
                    let found = search.best(&hints, &task).unwrap().unwrap();
                    assert!(found.misfit < 1e-3, "{found:?}");
                    assert!(found.normal[0].abs() > nearest - 0.02, "{found:?} for {nearest}");
                }
            }
        }
    }

    #[test]
    fn around_a_vertex_of_many_triangles_the_nearest_is_found_without_trying_all() {
        let sides = 400_u32;
        let around = (0..sides).map(|i| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / f64::from(sides)).sin_cos();
            [0.2 * cos, cos, sin]
        });
        let positions: Vec<Vec3> = [[0.3, 0.0, 0.0], [-0.3, 0.0, 0.0]].into_iter().chain(around).collect();
        let edges = (0..sides).map(|i| (i + 2, (i + 1) % sides + 2));
        let triangles: Vec<[u32; 3]> = edges.flat_map(|(a, b)| [[0, a, b], [1, b, a], [0, 0, a]]).collect();
        let search = MirrorSearch::of(&positions, &triangles).unwrap();
        let all = MirrorSearch { fans: HashMap::new(), ..MirrorSearch::of(&positions, &triangles).unwrap() };
        assert_eq!(search.fans.len(), 2);
        for p in half_sphere().flat_map(|d| [0.02, 0.3, 0.5, 2.0].map(|r| scaled(d, r))) {
            assert_eq!(search.closest(p), all.closest(p), "{p:?}");
        }
        assert_eq!(search.closest(positions[0]), all.closest(positions[0]));

        let (task, judges) = (Task::new(), search.judges(JUDGES));
        let plane = MirrorPlane { normal: [1.0, 0.0, 0.0], offset: 0.0, misfit: 1.0 };
        assert!(search.refine(plane, &judges, &task).is_ok());
        task.cancel();
        assert!(search.refine(plane, &judges, &task).is_err());
    }

    #[test]
    fn nothing_and_no_extent_are_no_panic() {
        assert!(MirrorSearch::of(&[], &[]).is_none());
        assert!(MirrorSearch::of(&[[f64::NAN; 3]], &[]).is_none());
        let point = [[1.0; 3]];
        let search = MirrorSearch::of(&point, &[[0, 0, 0]]).unwrap();
        assert!(search.best(&[[0.0; 3]], &Task::new()).unwrap().is_none());
    }
}
