//! Lines on the surface that are worth drawing.

use chladni_mesh::surface::vec3::{Vec3, add, dot, length, scaled, sub, unit};
use chladni_mesh::surface::{EdgePoint, chained, times, vertex_gradients, zero_lines};
use rayon::prelude::*;

use super::sight::Sight;
use super::{Ink, Mark};

/// A line on the surface, hidden or not.
pub(super) struct Line {
    pub mark: Mark,
    pub points: Vec<LinePoint>,
}

/// A point of it.
#[derive(Clone, Copy)]
pub(super) struct LinePoint {
    pub at: Vec3,
    pub normal: Vec3,
    /// How much it says, or 0 for what is measured later: it is drawn from ½ on where it reaches 1 nearby.
    pub strength: f64,
    /// A factor of its width.
    pub weight: f64,
}

/// How fast the radial curvature must rise along the line of sight to say something, in 1 / size².
const SUGGESTIVE: f64 = 90.0;
/// How sharp valleys and ridges must be, in 1 / size.
const VALLEY: f64 = 14.0;
const RIDGE: f64 = 26.0;
/// How far across a border must be to be drawn even where it lies on other parts of the surface, as a share of the
/// size: slits in scans are smaller.
const SEAM: f64 = 0.1;

/// All lines of a plate as it is seen.
pub(super) fn lines(sight: &Sight<'_>, ink: &Ink) -> Vec<Line> {
    let mut lines = contours(sight);
    lines.extend(seams(sight));
    if ink.detail > 0.0 {
        let seen = Seen::new(sight);
        lines.extend(seen.suggestive(ink.detail));
        lines.extend(seen.creases(Mark::Valley, 1, VALLEY / ink.detail));
        lines.extend(seen.creases(Mark::Ridge, 0, RIDGE / ink.detail));
    }
    lines
}

/// Quantities of each vertex from which lines are traced.
struct Seen<'a, 'b> {
    sight: &'a Sight<'b>,
    /// ⟨n, v⟩, v the unit vector toward the viewer.
    facing: Vec<f64>,
    /// The unit vector along v in the tangent plane, and the radial curvature along it.
    radial: Vec<(Vec3, f64)>,
}

impl<'a, 'b> Seen<'a, 'b> {
    fn new(sight: &'a Sight<'b>) -> Self {
        let plate = sight.plate;
        let at = |v: usize| {
            let (n, toward) = (plate.normals[v], sight.toward(plate.positions[v]));
            let facing = dot(n, toward);
            let w = unit(sub(toward, scaled(n, facing)));
            (facing, (w, dot(w, times(plate.tensors[v], w))))
        };
        let (facing, radial) = (0..plate.positions.len()).into_par_iter().map(at).unzip();
        Self { sight, facing, radial }
    }

    /// Traces the zeros of `values`; each point has the strength that `strength` gives.
    fn traced(
        &self,
        mark: Mark,
        values: impl Fn(usize, [u32; 3]) -> Option<[f64; 3]>,
        strength: impl Fn(&EdgePoint) -> f64,
    ) -> Vec<Line> {
        let point = |on: &EdgePoint| line_point(self.sight, on, strength(on));
        let lines = zero_lines(&self.sight.plate.triangles, values);
        lines.iter().map(|line| Line { mark, points: line.iter().map(point).collect() }).collect()
    }

    /// κ_r = 0 where D_w κ_r > 0 (DeCarlo et al., "Suggestive contours for conveying shape", 2003), fading
    /// where the surface faces the viewer: there the direction w means little.
    fn suggestive(&self, detail: f64) -> Vec<Line> {
        let plate = self.sight.plate;
        let curvature: Vec<f64> = self.radial.iter().map(|(_, k)| *k).collect();
        let slopes = vertex_gradients(&plate.positions, &plate.triangles, &curvature, &plate.around);
        let unit = plate.size * plate.size * detail / SUGGESTIVE;
        let rise = |v: u32| {
            let v = v as usize;
            let sideways = (1.0 - self.facing[v] * self.facing[v]).max(0.0).sqrt();
            dot(slopes[v], self.radial[v].0) * unit * smooth_step((sideways - 0.15) / 0.35)
        };
        let values = |_: usize, t: [u32; 3]| {
            let fronts = t.iter().all(|v| self.facing[*v as usize] > 0.0);
            fronts.then(|| t.map(|v| curvature[v as usize]))
        };
        self.traced(Mark::Suggestive, values, |on| on.number(rise))
    }

    /// Where principal curvature `which` is extreme along its own direction, and greater than the other: the
    /// bottoms of furrows (κ₂ < 0 least) or the tops of edges (κ₁ > 0 greatest).
    fn creases(&self, mark: Mark, which: usize, sharp: f64) -> Vec<Line> {
        let plate = self.sight.plate;
        let sign = if which == 0 { 1.0 } else { -1.0 };
        let sharpness = |v: u32| {
            let [a, b] = plate.principal[v as usize].values;
            let (own, other) = if which == 0 { (a, b) } else { (b, a) };
            if sign * own > other.abs() { sign * own * plate.size / sharp } else { 0.0 }
        };
        let values = |_: usize, t: [u32; 3]| {
            if t.iter().any(|v| self.facing[*v as usize] < 0.0) || t.iter().all(|v| sharpness(*v) < 0.3) {
                return None;
            }
            // Directions have no sign: the corners' are turned to agree with the first.
            let [a, b, c] = t.map(|v| plate.principal[v as usize].directions[which]);
            let turns = [1.0, dot(a, b).signum(), dot(a, c).signum()];
            if dot(b, c) * turns[1] * turns[2] <= 0.0 {
                return None;
            }
            let values: [f64; 3] = std::array::from_fn(|i| turns[i] * plate.slopes[which][t[i] as usize]);
            let along = add(add(a, scaled(b, turns[1])), scaled(c, turns[2]));
            let places = t.map(|v| dot(plate.positions[v as usize], along));
            // Along the direction the slope falls through a maximum and rises through a minimum.
            let trend: f64 = {
                let (x, y) = (mean(places), mean(values));
                (0..3).map(|i| (places[i] - x) * (values[i] - y)).sum()
            };
            (sign * trend < 0.0).then_some(values)
        };
        let strength = |on: &EdgePoint| {
            let facing = on.number(|v| self.facing[v as usize]);
            on.number(sharpness) * smooth_step((facing - 0.05) / 0.25)
        };
        self.traced(mark, values, strength)
    }
}

fn mean(x: [f64; 3]) -> f64 {
    (x[0] + x[1] + x[2]) / 3.0
}

/// 0 below 0, 1 above 1, smooth between.
pub(super) fn smooth_step(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

fn line_point(sight: &Sight<'_>, on: &EdgePoint, strength: f64) -> LinePoint {
    let plate = sight.plate;
    let normal = unit(on.mixed(|v| plate.normals[v as usize]));
    let weight = plate.weights.as_ref().map_or(1.0, |weights| on.number(|v| f64::from(weights[v as usize])));
    LinePoint { at: on.mixed(|v| plate.positions[v as usize]), normal, strength, weight }
}

/// Edges that have all their triangles on one side on paper: where the surface turns away, or ends. How much they say
/// is measured where they are seen: [`Sight::step`].
fn contours(sight: &Sight<'_>) -> Vec<Line> {
    let plate = sight.plate;
    let places: Vec<Option<[f64; 2]>> = plate.positions.par_iter().map(|p| sight.project(*p)).collect();
    // Each, and whether it is seen; none behind the eye.
    let fold = |triangles: &[([u32; 2], u32)]| {
        let (edge, _) = *triangles.first()?;
        let [Some(a), Some(b)] = edge.map(|v| places[v as usize]) else { return None };
        let side = |(_, across): &([u32; 2], u32)| {
            let Some(c) = places[*across as usize] else { return 0.0 };
            (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        };
        let is_fold = triangles.iter().all(|t| side(t) >= 0.0) || triangles.iter().all(|t| side(t) <= 0.0);
        if !is_fold {
            return None;
        }
        let [p, q] = edge.map(|v| plate.positions[v as usize]);
        let middle = std::array::from_fn(|i| 0.5 * (a[i] + b[i]));
        Some((edge, sight.step(scaled(add(p, q), 0.5), middle, way(a, b)) >= 0.5))
    };
    let mut folds: Vec<([u32; 2], bool)> =
        plate.edges.par_chunk_by(|a, b| a.0 == b.0).filter_map(fold).collect();
    // Where more than two meet, the first two go together: those that are seen.
    folds.sort_by_key(|(_, is_seen)| !is_seen);
    let edges: Vec<[u32; 2]> = folds.into_iter().map(|(edge, _)| edge).collect();
    chains(sight, &edges, 0.0)
}

/// The borders of larger pieces of the surface, such as the panels of a car.
fn seams(sight: &Sight<'_>) -> Vec<Line> {
    let plate = sight.plate;
    let alone = plate.edges.chunk_by(|a, b| a.0 == b.0).filter(|triangles| triangles.len() == 1);
    let edges: Vec<[u32; 2]> = alone.map(|triangles| triangles[0].0).collect();
    let mut lines = chains(sight, &edges, 1.0);
    lines.retain(|line| {
        let mut from_first = line.points.iter().map(|point| length(sub(point.at, line.points[0].at)));
        from_first.any(|far| far >= SEAM * plate.size)
    });
    lines
}

/// Edges as contours, from vertex to vertex.
fn chains(sight: &Sight<'_>, edges: &[[u32; 2]], strength: f64) -> Vec<Line> {
    let vertex = |v: u32| EdgePoint { ends: [v, v], along: 0.0 };
    let edges: Vec<[EdgePoint; 2]> = edges.iter().map(|edge| edge.map(vertex)).collect();
    let point = |on: &EdgePoint| line_point(sight, on, strength);
    let line =
        |chain: Vec<EdgePoint>| Line { mark: Mark::Contour, points: chain.iter().map(point).collect() };
    chained(&edges).into_iter().map(line).collect()
}

/// Unit from `a` to `b` on paper; zero where they are one.
pub(super) fn way([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    let l = (a - c).hypot(b - d);
    if l > 0.0 { [(c - a) / l, (d - b) / l] } else { [0.0; 2] }
}

/// Where a point lies between two.
pub(super) fn between(a: &LinePoint, b: &LinePoint, t: f64) -> LinePoint {
    let mix = |x: f64, y: f64| x + (y - x) * t;
    let at = std::array::from_fn(|i| mix(a.at[i], b.at[i]));
    let normal = std::array::from_fn(|i| mix(a.normal[i], b.normal[i]));
    let normal = if length(normal) > 0.0 { unit(normal) } else { a.normal };
    LinePoint { at, normal, strength: mix(a.strength, b.strength), weight: mix(a.weight, b.weight) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::Plate;
    use crate::{Camera, Projection, Rect};
    use std::f64::consts::{PI, TAU};

    /// A ring of revolution about z, whose curvatures are known.
    const LARGE: f64 = 1.0;
    const SMALL: f64 = 0.45;
    const AROUND: u32 = 240;
    const ACROSS: u32 = 120;
    /// The curvature of a ring changes so slowly that its suggestive contours are faint at the usual detail of 1.
    const DETAIL: f64 = 60.0;

    fn ring() -> Plate {
        let at = |i: u32| {
            let (sin, cos) = (TAU * f64::from(i % ACROSS) / f64::from(ACROSS)).sin_cos();
            let (south, north) = (TAU * f64::from(i / ACROSS) / f64::from(AROUND)).sin_cos();
            let far = LARGE + SMALL * cos;
            [far * north, far * south, SMALL * sin]
        };
        let corner = |i: u32, j: u32| (i % AROUND) * ACROSS + j % ACROSS;
        let quads = (0..AROUND).flat_map(|i| (0..ACROSS).map(move |j| (i, j)));
        let triangles = quads.flat_map(|(i, j)| {
            let [a, b, c, d] = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| corner(i, j));
            [[a, b, c], [a, c, d]]
        });
        let positions: Vec<Vec3> = (0..AROUND * ACROSS).map(at).collect();
        Plate::new(&positions, &triangles.collect::<Vec<_>>(), 0.0).unwrap()
    }

    /// What is known at the angles `across` and `around` of the ring as it is seen from along `toward`.
    struct Known {
        /// κ_r.
        radial: f64,
        /// ⟨n, v⟩.
        facing: f64,
        /// Unit direction of the line of sight in the tangent plane, across and around.
        along: [f64; 2],
    }

    fn known(across: f64, around: f64, toward: Vec3) -> Known {
        let ((sin, cos), (south, north)) = (across.sin_cos(), around.sin_cos());
        let a = dot(toward, [-sin * north, -sin * south, cos]);
        let b = dot(toward, [-south, north, 0.0]);
        let square = a * a + b * b;
        let radial = (a * a / SMALL + b * b * cos / (LARGE + SMALL * cos)) / square;
        let facing = dot(toward, [cos * north, cos * south, sin]);
        Known { radial, facing, along: [a / square.sqrt(), b / square.sqrt()] }
    }

    /// How fast κ_r changes along the ring, across it and around it, in 1 / length².
    fn slope(across: f64, around: f64, toward: Vec3) -> [f64; 2] {
        const STEP: f64 = 1e-5;
        let change = |a: f64, b: f64| {
            let at = |s: f64| known(across + s * a, around + s * b, toward).radial;
            (at(STEP) - at(-STEP)) / (2.0 * STEP)
        };
        [change(1.0, 0.0) / SMALL, change(0.0, 1.0) / (LARGE + SMALL * across.cos())]
    }

    fn rise(across: f64, around: f64, toward: Vec3) -> f64 {
        let ([a, b], along) = (slope(across, around, toward), known(across, around, toward).along);
        a * along[0] + b * along[1]
    }

    #[test]
    fn nothing_behind_the_eye_is_a_contour() {
        let plate = ring();
        // In the hole, where a part of the ring is behind.
        let camera = Camera { distance: 0.2, ..Camera::default() };
        let sight = Sight::new(&plate, &camera, Rect::of_size(800, 800));
        let lines = contours(&sight);
        let points: Vec<Vec3> = lines.iter().flat_map(|line| &line.points).map(|point| point.at).collect();
        assert!(points.len() > 40, "{} points", points.len());
        assert!(points.iter().all(|p| sight.project(*p).is_some()));
    }

    /// DeCarlo et al. 2003: where the radial curvature is 0 and rises toward the viewer. On a ring it is
    /// ⟨v, e⟩² / r + ⟨v, f⟩² cos θ / (R + r cos θ), with the unit directions e across and f around it.
    #[test]
    fn suggestive_contours_of_a_ring_lie_where_its_radial_curvature_is_zero_and_rises() {
        let plate = ring();
        let edge = TAU * (LARGE + SMALL) / f64::from(AROUND);
        for pitch_rad in [0.5, 0.9] {
            let camera =
                Camera { yaw_rad: 0.3, pitch_rad, projection: Projection::Orthographic, ..Camera::default() };
            let sight = Sight::new(&plate, &camera, Rect::of_size(800, 800));
            let toward = sight.toward([0.0; 3]);
            let angles = |p: Vec3| {
                let around = p[1].atan2(p[0]);
                (p[2].atan2(p[0].hypot(p[1]) - LARGE), around)
            };
            let lines = Seen::new(&sight).suggestive(DETAIL);
            let drawn: Vec<Vec3> = lines
                .iter()
                .flat_map(|line| &line.points)
                .filter(|point| point.strength > 0.5)
                .map(|point| point.at)
                .collect();
            assert!(drawn.len() > 40, "{} points", drawn.len());
            for p in &drawn {
                let (across, around) = angles(*p);
                let ([a, b], at) = (slope(across, around, toward), known(across, around, toward));
                // To first order, the distance to the zeros.
                let off = at.radial.abs() / a.hypot(b);
                assert!(off < edge, "{off} from a zero at {across}, {around}");
                assert!(rise(across, around, toward) > 0.0 && at.facing > 0.0, "{across}, {around}");
            }
            // And none is missing: wherever the formula has one that says enough, a line is near.
            let size = plate.size;
            let enough = |across: f64, around: f64| {
                let facing = known(across, around, toward).facing;
                let sideways = (1.0 - facing * facing).max(0.0).sqrt();
                facing > 0.1 && sideways > 0.5 && rise(across, around, toward) * size * size * DETAIL > 90.0
            };
            let mut expected = 0;
            for i in 0..720 {
                let around = TAU * f64::from(i) / 720.0;
                for j in 0..720 {
                    let across = TAU * f64::from(j) / 720.0 - PI;
                    let next = across + TAU / 720.0;
                    let [here, there] = [across, next].map(|across| known(across, around, toward).radial);
                    if here * there > 0.0 || !enough(across, around) {
                        continue;
                    }
                    expected += 1;
                    let far = LARGE + SMALL * across.cos();
                    let p = [far * around.cos(), far * around.sin(), SMALL * across.sin()];
                    let nearest = drawn.iter().map(|q| length(sub(*q, p))).fold(f64::INFINITY, f64::min);
                    assert!(nearest < 2.0 * edge, "{nearest} at {across}, {around}");
                }
            }
            assert!(expected > 20, "{expected}");
        }
    }
}
