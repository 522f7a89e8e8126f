//! The part of the displayed shape under a brush: all within its radius along the surface.

use std::fmt;

use chladni_mesh::MirrorPlane;
use rayon::prelude::*;

use crate::{Surface, SurfacePoint};
use chladni_mesh::surface::vec3::{Vec3, dot, sub};

/// Whether something stands between an eye and a point, both in the working frame.
pub type Blocked<'a> = dyn Fn([f64; 3], [f64; 3]) -> bool + Sync + 'a;

/// The triangle that an eye sees right at a point of the surface, both in the working frame; `None` where it sees past it.
pub type SeenAt<'a> = dyn Fn([f64; 3], [f64; 3]) -> Option<u32> + Sync + 'a;

/// The shape as displayed, and the viewpoint.
#[derive(Clone, Copy)]
pub struct Seen<'a> {
    /// Its triangles and rest positions.
    pub surface: &'a Surface,
    /// Its N displayed vertices, moved by layers; working frame.
    pub positions: &'a [[f32; 3]],
    /// The eye, far away for a parallel view; `None` ignores visibility.
    pub eye: Option<[f64; 3]>,
    /// Tells whether another part of the shape hides a point from the eye; `None` hides nothing.
    pub blocked: Option<&'a Blocked<'a>>,
}

impl fmt::Debug for Seen<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Seen").field("vertices", &self.positions.len()).field("eye", &self.eye).finish()
    }
}

/// A round brush.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brush {
    /// Radius along the displayed surface, working frame.
    pub radius: f64,
    /// The share of the radius within which it paints in full, in [0, 1]: 1 has a hard edge, less fades out smoothly.
    pub hardness: f64,
    /// Covers the mirrored place too. The plane is one of the shape at rest.
    pub mirror: Option<MirrorPlane>,
}

/// The vertices and triangles under a brush.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reach {
    /// The brush's radius.
    pub radius: f64,
    /// How far from its center it paints in full.
    pub core: f64,
    /// Vertices within the radius and their neighbors, ascending, each with its distance from the
    /// brush's center along the surface.
    pub distances: Vec<(u32, f64)>,
    /// The triangles over these vertices that the brush lies on, ascending: where its ring is drawn.
    pub triangles: Vec<u32>,
}

impl Seen<'_> {
    fn at(&self, v: u32) -> Vec3 {
        self.positions[v as usize].map(f64::from)
    }

    /// How much triangle `t` faces `eye`: positive if its front is visible.
    fn facing(&self, t: u32, eye: Vec3) -> f64 {
        let [a, b, c] = self.surface.triangles[t as usize].map(|v| self.at(v));
        dot(chladni_mesh::surface::vec3::cross(sub(b, a), sub(c, a)), sub(eye, a))
    }

    /// Whether triangle `t` shows the eye this side, 1 for its front and -1 for its back; either where there is no eye.
    fn shows(&self, t: u32, side: f64) -> bool {
        self.eye.is_none_or(|eye| side * self.facing(t, eye) >= 0.0)
    }
}

impl Seen<'_> {
    /// Those of `vertices` < N that nothing hides from the eye, not even the front of a thin part of which they are the
    /// back; all where there is no eye. Empty if the positions belong to another shape.
    pub fn shown(&self, mut vertices: Vec<u32>, seen_at: &SeenAt<'_>) -> Vec<u32> {
        if self.positions.len() != self.surface.vertices() {
            return Vec::new();
        }
        if let Some((eye, blocked)) = self.eye.zip(self.blocked) {
            let side = |t: u32| self.facing(t, eye).signum();
            // On the vertex's own side of a thin part, what is seen faces as some triangle around the vertex does.
            let is_back = |v: u32| {
                let seen = seen_at(eye, self.at(v)).map(side);
                seen.is_some_and(|seen| self.surface.triangles_around(v).iter().all(|t| side(*t) != seen))
            };
            vertices =
                vertices.into_par_iter().filter(|v| !blocked(eye, self.at(*v)) && !is_back(*v)).collect();
        }
        vertices
    }
}

impl Brush {
    /// The part of `seen` under the brush when it is pressed at `at`: all within its radius along the surface, over
    /// triangles that show the eye the same side as the one at `at`. So it passes neither through the shape nor
    /// around its edge onto the hidden side; parts behind another part, such as the cheek behind a nose, stay bare,
    /// too. Empty if there is no such triangle or the positions belong to another shape.
    pub fn reach(&self, seen: &Seen<'_>, at: &SurfacePoint) -> Reach {
        let surface = seen.surface;
        if seen.positions.len() != surface.vertices() || at.triangle as usize >= surface.triangles.len() {
            return Reach { radius: self.radius, core: self.core(), ..Reach::default() };
        }
        let side = seen.eye.map_or(1.0, |eye| seen.facing(at.triangle, eye).signum());
        let twin = || {
            let plane = self.mirror?;
            let image = plane.image(surface.position(at)?);
            // It sees the same side of the image.
            let seen = Seen { eye: seen.eye.map(|eye| plane.image(eye)), ..*seen };
            let at = surface.nearest_corner(image, |t| seen.shows(t, side))?;
            // The part there may be wound the other way.
            let side = if seen.shows(at.triangle, side) { side } else { -side };
            Some(self.press(&seen, &at, side))
        };
        let (mut reach, twin) = rayon::join(|| self.press(seen, at, side), twin);
        if let Some(twin) = twin {
            reach.join(twin);
        }
        reach
    }

    /// The vertex at the mirror image of a place at rest; `None` where the brush does not mirror.
    pub fn twin(&self, at: &SurfacePoint, surface: &Surface) -> Option<SurfacePoint> {
        let plane = self.mirror?;
        surface.nearest_vertex(plane.image(surface.position(at)?))
    }

    fn press(&self, seen: &Seen<'_>, at: &SurfacePoint, side: f64) -> Reach {
        let surface = seen.surface;
        let marched = surface.march(at, self.radius, |v| seen.at(v), |t| seen.shows(t, side));
        let (mut distances, mut triangles) = (marched.distances, marched.triangles);
        distances.sort_unstable_by_key(|(v, _)| *v);
        if let Some((eye, blocked)) = seen.eye.zip(seen.blocked) {
            let shown = |v: u32| !blocked(eye, seen.at(v));
            distances = distances.into_par_iter().filter(|(v, _)| shown(*v)).collect();
            let kept = |v: &u32| distances.binary_search_by_key(v, |(kept, _)| *kept).is_ok();
            triangles.retain(|t| surface.triangles[*t as usize].iter().all(kept));
        }
        Reach { radius: self.radius, core: self.core(), distances, triangles }
    }

    fn core(&self) -> f64 {
        self.hardness.clamp(0.0, 1.0) * self.radius
    }

    /// How far apart the dabs of a stroke may be: near enough that the middle between two of a soft brush is painted in
    /// full, but for 5 %.
    pub fn spacing(&self) -> f64 {
        (2.0 * self.core()).clamp(0.25 * self.radius, 0.5 * self.radius)
    }
}

impl Reach {
    /// The vertices under the brush, ascending: all within the radius, or the nearest one where the
    /// brush is smaller than a triangle.
    pub fn vertices(&self) -> Vec<u32> {
        let within: Vec<u32> =
            self.distances.iter().filter(|(_, d)| *d <= self.radius).map(|(v, _)| *v).collect();
        if !within.is_empty() {
            return within;
        }
        let nearest = self.distances.iter().min_by(|a, b| a.1.total_cmp(&b.1));
        nearest.map(|(v, _)| *v).into_iter().collect()
    }

    /// How much of the brush reaches each of its [`vertices`](Self::vertices): 1 in its core, smoothly down to 0 at its
    /// radius. Empty where that is 1 of all, as of a hard brush.
    pub fn weights(&self) -> Vec<f32> {
        if self.core >= self.radius {
            return Vec::new();
        }
        let within = self.distances.iter().map(|(_, d)| *d).filter(|d| *d <= self.radius);
        within.map(|d| faded((d - self.core) / (self.radius - self.core)) as f32).collect()
    }

    fn join(&mut self, other: Self) {
        self.distances.extend(other.distances);
        self.distances.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        self.distances.dedup_by_key(|(v, _)| *v);
        self.triangles.extend(other.triangles);
        self.triangles.sort_unstable();
        self.triangles.dedup();
    }
}

/// 1 below 0, 0 above 1, and level at both ends.
fn faded(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    1.0 - t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::icosphere;
    use chladni_mesh::Frame;
    use chladni_mesh::surface::vec3::{distance, single};

    const FILE: Frame = Frame { center: [0.0; 3], scale: 1.0 };

    /// A flat plate of `side`² vertices a `step` apart at height z, facing up or down.
    fn plate(side: u32, step: f64, z: f64, up: bool) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let middle = 0.5 * step * f64::from(side - 1);
        let at = |i: u32| [f64::from(i % side) * step - middle, f64::from(i / side) * step - middle, z];
        let corners = (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| y * side + x));
        let quads = corners.flat_map(|v| [[v, v + 1, v + side + 1], [v, v + side + 1, v + side]]);
        let triangles = quads.map(|[a, b, c]| if up { [a, b, c] } else { [a, c, b] }).collect();
        ((0..side * side).map(at).collect(), triangles)
    }

    /// A thin flap, such as an ear: two plates back to back, joined along their rims.
    fn ear() -> (Surface, usize) {
        const SIDE: u32 = 31;
        let (mut positions, mut triangles) = plate(SIDE, 0.05, 0.02, true);
        let (below, under) = plate(SIDE, 0.05, -0.02, false);
        let front = positions.len() as u32;
        positions.extend(below);
        triangles.extend(under.iter().map(|t| t.map(|v| v + front)));
        let rim: Vec<u32> = (0..SIDE)
            .chain((1..SIDE).map(|y| y * SIDE + SIDE - 1))
            .chain((0..SIDE - 1).rev().map(|x| (SIDE - 1) * SIDE + x))
            .chain((0..SIDE - 1).rev().map(|y| y * SIDE))
            .collect();
        for w in rim.windows(2) {
            triangles.extend([[w[1], w[0], w[0] + front], [w[1], w[0] + front, w[1] + front]]);
        }
        (Surface::of(positions, triangles, FILE), front as usize)
    }

    fn reach(surface: &Surface, at: Vec3, radius: f64, eye: Option<Vec3>) -> Reach {
        let positions = single(&surface.positions);
        let seen = Seen { surface, positions: &positions, eye, blocked: None };
        Brush { radius, hardness: 1.0, mirror: None }.reach(&seen, &surface.nearest_vertex(at).unwrap())
    }

    #[test]
    fn the_back_of_an_ear_stays_bare() {
        let (ear, front) = ear();
        let above = Some([0.2, 0.1, 5.0]);
        // In the middle and at the rim, where the way around is shorter than the brush.
        for at in [[0.0, 0.0, 0.02], [0.7, 0.0, 0.02]] {
            let seen = reach(&ear, at, 0.3, above).vertices();
            assert!(seen.len() > 40 && seen.iter().all(|v| (*v as usize) < front), "{at:?}");
            let in_a_ball = |v: usize| distance(ear.positions[v], at) <= 0.3;
            assert!((front..2 * front).any(in_a_ball), "a ball goes through");
        }
        // Without an eye it goes around the rim, but not through.
        let around = reach(&ear, [0.7, 0.0, 0.02], 0.3, None).vertices();
        assert!(around.iter().any(|v| *v as usize >= front));
        let middle = reach(&ear, [0.0, 0.0, 0.02], 0.3, None).vertices();
        assert!(middle.iter().all(|v| (*v as usize) < front));
        // Seen from behind, it paints the back.
        let below = Some([0.2, 0.1, -5.0]);
        let back = reach(&ear, [0.0, 0.0, -0.02], 0.3, below).vertices();
        assert!(back.len() > 40 && back.iter().all(|v| *v as usize >= front));
    }

    #[test]
    fn what_is_shown_of_a_thin_part_is_the_side_toward_the_eye() {
        let (ear, front) = ear();
        let (positions, front) = (single(&ear.positions), front as u32);
        let blocked = |_: [f64; 3], _: [f64; 3]| false;
        let first_of = |v: u32| ear.triangles_around(v)[0];
        for (z, side) in [(5.0, 0..front), (-5.0, front..2 * front)] {
            let eye = Some([0.2, 0.1, z]);
            let seen = Seen { surface: &ear, positions: &positions, eye, blocked: Some(&blocked) };
            // In the middle of the side.
            let before = first_of(side.start + front / 2);
            let shown = seen.shown((0..2 * front).collect(), &|_, _| Some(before));
            assert_eq!(shown, side.collect::<Vec<u32>>());
            assert_eq!(seen.shown(vec![front + 1, 2], &|_, _| None), [front + 1, 2]);
        }
    }

    #[test]
    fn what_another_part_hides_stays_bare_here_and_in_the_mirror() {
        let (positions, triangles) = plate(61, 1.0 / 30.0, 0.0, true);
        let surface = Surface::of(positions, triangles, FILE);
        let positions = single(&surface.positions);
        // A wall across the plate hides a strip behind it, also from the mirrored eye.
        let blocked = |eye: [f64; 3], p: [f64; 3]| {
            let side = eye[0].signum();
            (0.21..0.31).contains(&(side * p[0]))
        };
        let plane = MirrorPlane { normal: [1.0, 0.0, 0.0], offset: 0.0, misfit: 0.0 };
        for mirror in [None, Some(plane)] {
            let seen = |blocked| Seen {
                surface: &surface,
                positions: &positions,
                eye: Some([2.0, 0.0, 9.0]),
                blocked,
            };
            let at = surface.nearest_vertex([0.4, 0.0, 0.0]).unwrap();
            let brush = Brush { radius: 0.35, hardness: 1.0, mirror };
            let all = brush.reach(&seen(None), &at);
            let shown = brush.reach(&seen(Some(&blocked)), &at);
            let expected: Vec<u32> = all
                .vertices()
                .into_iter()
                .filter(|v| !(0.21..0.31).contains(&surface.positions[*v as usize][0].abs()))
                .collect();
            assert!(expected.len() + 20 < all.vertices().len());
            assert_eq!(shown.vertices(), expected);
            assert!(shown.triangles.len() < all.triangles.len());
        }
    }

    #[test]
    fn after_a_strong_layer_the_dab_is_round_where_it_is_seen() {
        let (positions, triangles) = plate(61, 1.0 / 30.0, 0.0, true);
        let surface = Surface::of(positions, triangles, FILE);
        // A lower layer has made a part of it four times as wide and pulled it up.
        let moved: Vec<[f32; 3]> = surface
            .positions
            .iter()
            .map(|p| [4.0 * p[0], 2.0 * p[1], 1.0 + p[0]].map(|c| c as f32))
            .collect();
        let start = surface.nearest_vertex([0.0, 0.0, 0.0]).unwrap();
        let seen = Seen { surface: &surface, positions: &moved, eye: Some([0.0, 0.0, 9.0]), blocked: None };
        let radius = 0.6;
        let covered = Brush { radius, hardness: 1.0, mirror: None }.reach(&seen, &start).vertices();
        let center = surface.position(&start).map(|p| [4.0 * p[0], 2.0 * p[1], 1.0 + p[0]]).unwrap();
        let edge = 4.3 / 30.0;
        for v in 0..surface.vertices() as u32 {
            let d = distance(moved[v as usize].map(f64::from), center);
            let inside = covered.binary_search(&v).is_ok();
            assert!(inside || d > radius - edge, "{d} is left out");
            assert!(!inside || d < radius + edge, "{d} is painted");
        }
        // At rest the same brush would cover what is now four times as far away.
        let rest = reach(&surface, [0.0; 3], radius, None).vertices();
        let farthest = rest.iter().map(|v| distance(moved[*v as usize].map(f64::from), center));
        assert!(farthest.fold(0.0, f64::max) > 2.0 * radius);
    }

    #[test]
    fn the_ring_lies_between_what_is_painted_and_what_is_not() {
        let (points, triangles) = icosphere(4);
        let surface = Surface::of(points, triangles, FILE);
        let reach = reach(&surface, [0.0, 0.0, 1.0], 0.4, Some([0.0, 0.0, 4.0]));
        let (painted, known) = (reach.vertices(), |v: &u32| {
            reach.distances.binary_search_by_key(v, |(v, _)| *v).map(|at| reach.distances[at].1)
        });
        let mut crossed = 0;
        for t in &reach.triangles {
            let corners = surface.triangles[*t as usize];
            let distances = corners.map(|v| known(&v).unwrap());
            let inside = corners.map(|v| painted.binary_search(&v).is_ok());
            // The ring is where the distance is the radius: in a triangle of both kinds.
            let ring = distances.iter().any(|d| *d <= 0.4) && distances.iter().any(|d| *d > 0.4);
            assert_eq!(ring, inside.contains(&true) && inside.contains(&false));
            crossed += usize::from(ring);
        }
        assert!(crossed > 20);
        // Every triangle of a painted vertex is drawn, so that the ring is closed.
        for v in &painted {
            let drawn = |t: &u32| reach.triangles.binary_search(t).is_ok();
            assert!(surface.triangles_around(*v).iter().all(drawn));
        }
    }

    #[test]
    fn a_mirrored_press_has_a_twin_across_a_plane_of_any_slope() {
        let (points, triangles) = icosphere(4);
        let surface = Surface::of(points, triangles, FILE);
        let normal = chladni_mesh::surface::vec3::scaled([1.0, 2.0, -0.5], 1.0 / 5.25_f64.sqrt());
        let plane = MirrorPlane { normal, offset: 0.0, misfit: 0.0 };
        let positions = single(&surface.positions);
        let seen = Seen { surface: &surface, positions: &positions, eye: None, blocked: None };
        let at = surface.nearest_vertex([0.8, 0.6, 0.1]).unwrap();
        let alone = Brush { radius: 0.25, hardness: 1.0, mirror: None }.reach(&seen, &at).vertices();
        let both = Brush { radius: 0.25, hardness: 1.0, mirror: Some(plane) }.reach(&seen, &at).vertices();
        let twin: Vec<u32> = both.iter().copied().filter(|v| alone.binary_search(v).is_err()).collect();
        assert!(twin.len().abs_diff(alone.len()) < alone.len() / 5, "{} and {}", alone.len(), twin.len());
        let center = plane.image(surface.position(&at).unwrap());
        assert!(twin.iter().all(|v| distance(surface.positions[*v as usize], center) < 0.25 + 0.08));
    }

    #[test]
    fn at_a_rim_the_twin_lies_on_the_side_that_is_seen() {
        let (ear, front) = ear();
        // The triangles of the rim come first.
        let triangles = ear.triangles.iter().rev().copied().collect();
        let ear = Surface::of(ear.positions, triangles, FILE);
        let positions = single(&ear.positions);
        let seen = Seen { surface: &ear, positions: &positions, eye: Some([0.2, 0.1, 5.0]), blocked: None };
        let is_front = |t: u32| ear.triangles[t as usize].iter().all(|v| (*v as usize) < front);
        let at = ear.nearest_corner([0.75, 0.0, 0.02], is_front).unwrap();
        let plane = MirrorPlane { normal: [1.0, 0.0, 0.0], offset: 0.0, misfit: 0.0 };
        let both = Brush { radius: 0.3, hardness: 1.0, mirror: Some(plane) }.reach(&seen, &at).vertices();
        assert!(both.iter().all(|v| (*v as usize) < front));
        let is_twin = |v: &&u32| ear.positions[**v as usize][0] < 0.0;
        assert!(both.iter().filter(is_twin).count() > 30);
    }

    #[test]
    fn the_twin_is_as_large_on_a_part_that_is_wound_the_other_way() {
        let (right, mut triangles) = plate(31, 0.05, 0.0, true);
        let (left, under) = plate(31, 0.05, 0.0, false);
        let count = right.len() as u32;
        let beside = |x: f64| move |p: Vec3| [p[0] + x, p[1], p[2]];
        let positions =
            right.into_iter().map(beside(1.0)).chain(left.into_iter().map(beside(-1.0))).collect();
        triangles.extend(under.iter().map(|t| t.map(|v| v + count)));
        let surface = Surface::of(positions, triangles, FILE);
        let positions = single(&surface.positions);
        let eye = Some([0.2, 0.1, 9.0]);
        let seen = Seen { surface: &surface, positions: &positions, eye, blocked: None };
        let at = surface.nearest_vertex([1.0, 0.0, 0.0]).unwrap();
        let plane = MirrorPlane { normal: [1.0, 0.0, 0.0], offset: 0.0, misfit: 0.0 };
        let both = Brush { radius: 0.3, hardness: 1.0, mirror: Some(plane) }.reach(&seen, &at).vertices();
        let here = both.iter().filter(|v| **v < count).count();
        assert!(here > 60 && 4 * (both.len() - here) > 3 * here, "{here} of {}", both.len());
    }

    #[test]
    fn a_soft_brush_fades_from_its_core_to_its_radius() {
        let (positions, triangles) = plate(61, 1.0 / 30.0, 0.0, true);
        let surface = Surface::of(positions, triangles, FILE);
        let (positions, radius) = (single(&surface.positions), 0.6);
        let seen = Seen { surface: &surface, positions: &positions, eye: None, blocked: None };
        let middle = surface.nearest_vertex([0.0; 3]).unwrap();
        let reach = |hardness: f64| Brush { radius, hardness, mirror: None }.reach(&seen, &middle);
        assert!(reach(1.0).weights().is_empty() && reach(7.0).weights().is_empty());
        for hardness in [0.0, 0.25, 0.8, -1.0] {
            let soft = reach(hardness);
            let (vertices, weights) = (soft.vertices(), soft.weights());
            assert_eq!((&vertices, vertices.len()), (&reach(1.0).vertices(), weights.len()));
            let core = radius * hardness.max(0.0);
            for (v, w) in vertices.iter().zip(&weights) {
                // By the cosine, which fades as smoothly, from the distance on the flat plate.
                let d = distance(surface.positions[*v as usize], [0.0; 3]);
                let t = ((d - core) / (radius - core)).clamp(0.0, 1.0);
                let cosine = 0.5 + 0.5 * (std::f64::consts::PI * t).cos();
                assert!((f64::from(*w) - cosine).abs() < 0.02 + 0.1 / (30.0 * (radius - core)), "{d}: {w}");
            }
        }
    }

    #[test]
    fn dabs_of_a_stroke_leave_no_beads() {
        for hardness in [0.0, 0.1, 0.2, 0.5, 1.0] {
            let brush = Brush { radius: 2.0, hardness, mirror: None };
            let between = faded((0.5 * brush.spacing() - brush.core()) / (2.0 - brush.core()).max(1e-9));
            assert!(between > 0.95 && brush.spacing() <= 1.0, "{hardness}: {between}");
        }
    }

    #[test]
    fn a_brush_smaller_than_a_triangle_paints_its_nearest_corner_and_strangers_nothing() {
        let (points, triangles) = icosphere(1);
        let surface = Surface::of(points, triangles, FILE);
        let positions = single(&surface.positions);
        let seen = Seen { surface: &surface, positions: &positions, eye: None, blocked: None };
        let corner = SurfacePoint { triangle: 5, weights: [0.2, 0.7, 0.1] };
        // A soft one as much as a hard one.
        let brush = |hardness: f64| Brush { radius: 1e-3, hardness, mirror: None };
        for hardness in [0.0, 1.0] {
            let reach = brush(hardness).reach(&seen, &corner);
            assert_eq!((reach.vertices(), reach.weights()), (vec![surface.triangles[5][1]], Vec::new()));
        }
        let brush = brush(1.0);
        let nowhere = SurfacePoint { triangle: 1_000_000, weights: [1.0, 0.0, 0.0] };
        assert!(brush.reach(&seen, &nowhere).vertices().is_empty());
        let another = Seen { positions: &positions[1..], ..seen };
        assert!(brush.reach(&another, &corner).vertices().is_empty());
    }
}
