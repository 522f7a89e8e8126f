//! Cross-parameterization: both surfaces are mapped to one sphere, where the landmarks are moved onto each
//! other; then the map is relaxed.

use chladni_mesh::surface::{Closest, SurfacePoint};
use chladni_task::Task;
use glam::DVec3;
use rayon::prelude::*;

use crate::closed::Closed;
use crate::flow::carry;
use crate::landmarks::Pinned;
use crate::laplacian::Laplacian;
use crate::project::nearest_facing;
use crate::quality::stretch;
use crate::similarity::{fit_pairs, fit_pairs_at};
use crate::sphere::{onto_sphere, orientation};
use crate::surface::{UnitSurface, triangle_tree};
use crate::{MatchError, Scaling, Side, Similarity};

/// Sweeps of the relaxation.
const SWEEPS: usize = 40;
/// More landmarks are refused: the flow factors a dense matrix of twice as many rows at each of its steps.
const MOST_LANDMARKS: usize = 2000;

/// For each welded vertex of the shape a point of the template and a confidence; and the pose that fits all
/// pairs.
pub(crate) struct CrossMap {
    pub at: Vec<Closest>,
    pub confidence: Vec<f64>,
    pub pose: Similarity,
    pub warnings: Vec<String>,
}

/// The template, mapped to the sphere.
struct Domain<'a> {
    closed: &'a Closed,
    sphere: &'a [DVec3],
}

impl Domain<'_> {
    fn corners(&self, t: u32) -> [DVec3; 3] {
        self.closed.triangles[t as usize].map(|v| self.sphere[v as usize])
    }

    /// Walks from `start` to the triangle that the ray through `x` meets.
    fn walk(&self, start: u32, x: DVec3) -> SurfacePoint {
        let mut t = start;
        let mut last = u32::MAX;
        for _ in 0..10_000 {
            let [a, b, c] = self.corners(t);
            let w = [x.dot(b.cross(c)), x.dot(c.cross(a)), x.dot(a.cross(b))];
            let size = w[0].abs() + w[1].abs() + w[2].abs();
            let worst = (0..3).min_by(|i, j| w[*i].total_cmp(&w[*j])).unwrap_or(0);
            let next = self.closed.across[t as usize][worst];
            if w[worst] >= -1e-12 * size || next == last {
                let clamped = w.map(|w| w.max(0.0));
                let total: f64 = clamped.iter().sum();
                let weights = if total > 0.0 { clamped.map(|w| w / total) } else { [1.0, 0.0, 0.0] };
                return SurfacePoint { triangle: t, weights };
            }
            last = t;
            t = next;
        }
        SurfacePoint { triangle: t, weights: [1.0 / 3.0; 3] }
    }

    /// The point of the template in space.
    fn point(&self, at: &SurfacePoint) -> DVec3 {
        let corners = self.closed.triangles[at.triangle as usize];
        (0..3).map(|i| self.closed.points[corners[i] as usize] * at.weights[i]).sum()
    }

    /// The place on the template's own surface. A point in a filled hole is moved to the rim, away from the
    /// center of the hole.
    fn land(&self, at: &SurfacePoint) -> SurfacePoint {
        if (at.triangle as usize) < self.closed.surface_triangle.len() {
            return *at;
        }
        // Triangles that fill a hole have the corners (rim, rim, center).
        let [a, b, _] = self.closed.triangles[at.triangle as usize];
        let total = at.weights[0] + at.weights[1];
        let share = if total > 0.0 { at.weights[0] / total } else { 0.5 };
        let triangle = self.closed.across[at.triangle as usize][2];
        let weights = self.closed.triangles[triangle as usize].map(|v| match v {
            v if v == a => share,
            v if v == b => 1.0 - share,
            _ => 0.0,
        });
        SurfacePoint { triangle, weights }
    }

    /// The direction on the sphere that moves the point of the template by `d` in space.
    fn pull_back(&self, at: &SurfacePoint, d: DVec3) -> DVec3 {
        let [p, q, r] = self.closed.triangles[at.triangle as usize].map(|v| self.closed.points[v as usize]);
        let [a, b, c] = self.corners(at.triangle);
        let (u, v) = (q - p, r - p);
        let (uu, uv, vv) = (u.dot(u), u.dot(v), v.dot(v));
        let det = uu * vv - uv * uv;
        if !(det > 1e-30) {
            return DVec3::ZERO;
        }
        let (du, dv) = (d.dot(u), d.dot(v));
        let (s, t) = ((du * vv - dv * uv) / det, (dv * uu - du * uv) / det);
        (b - a) * s + (c - a) * t
    }
}

/// Computes the map from three to [`MOST_LANDMARKS`] `landmarks`. `scale` is the scale of the pose, if it is not to be
/// fitted.
pub(crate) fn crossmap(
    shape: &UnitSurface,
    template: &UnitSurface,
    landmarks: &[Pinned],
    scale: Option<f64>,
    task: &Task,
) -> Result<CrossMap, MatchError> {
    let (s, t) = (Closed::new(shape, Side::Shape)?, Closed::new(template, Side::Template)?);
    let mut pins: Vec<(u32, u32)> = landmarks
        .iter()
        .filter_map(|l| Some((s.point_of[l.shape as usize]?, t.point_of[l.template as usize]?)))
        .collect();
    if pins.len() < 3 {
        return Err(MatchError::TooFewLandmarks(pins.len()));
    }
    if pins.len() > MOST_LANDMARKS {
        return Err(MatchError::Parameter {
            name: "the number of landmarks of a map",
            range: "at most 2000 (a fit takes any number)",
            value: pins.len() as f64,
        });
    }
    let users = pins.len();
    let unused = landmarks.len() - users;
    // If both surfaces are open, their largest holes are matched with each other.
    pins.extend(s.largest_hole.zip(t.largest_hole));
    let mut x = onto_sphere(&s, Side::Shape, task)?;
    let sphere = onto_sphere(&t, Side::Template, task)?;
    let turn = fit_pairs(
        pins[..users].iter().map(|(p, q)| (x[*p as usize], sphere[*q as usize], 1.0)),
        Scaling::Rigid,
    )?
    .rotation_matrix();
    x.iter_mut().for_each(|p| *p = turn * *p);
    let from: Vec<DVec3> = pins.iter().map(|(p, _)| x[*p as usize]).collect();
    let to: Vec<DVec3> = pins.iter().map(|(_, q)| sphere[*q as usize]).collect();
    carry(&mut x, &from, &to, task)?;
    let domain = Domain { closed: &t, sphere: &sphere };
    let tree = triangle_tree(&sphere, &t.triangles);
    let mut places: Vec<SurfacePoint> = x
        .par_iter()
        .map(|p| {
            let start = tree.closest(p.to_array(), f64::INFINITY).map_or(0, |at| at.on.triangle);
            domain.walk(start, *p)
        })
        .collect();
    relax(&s, &domain, &pins, &mut x, &mut places, task)?;
    let mut map = assemble(shape, template, &s, &domain, &places, scale)?;
    if unused > 0 {
        map.warnings.push(format!(
            "{unused} of {} landmarks lie outside the largest component of the shape or the template: they were not used",
            landmarks.len()
        ));
    }
    Ok(map)
}

/// Moves the image of each vertex toward the cotangent-weighted mean of its neighbors' images in space, by
/// steps that never turn a triangle over on the sphere.
fn relax(
    s: &Closed,
    domain: &Domain,
    pins: &[(u32, u32)],
    x: &mut [DVec3],
    places: &mut [SurfacePoint],
    task: &Task,
) -> Result<(), MatchError> {
    let laplacian = Laplacian::new(&s.points, &s.triangles);
    let mut around: Vec<Vec<u32>> = vec![Vec::new(); s.points.len()];
    for (t, corners) in s.triangles.iter().enumerate() {
        corners.iter().for_each(|v| around[*v as usize].push(t as u32));
    }
    let mut fixed = vec![false; s.points.len()];
    pins.iter().for_each(|(p, _)| fixed[*p as usize] = true);
    let mut image: Vec<DVec3> = places.iter().map(|p| domain.point(p)).collect();
    let stage = task.stage("relaxing", SWEEPS as u64);
    for _ in 0..SWEEPS {
        task.check()?;
        for v in (0..s.surface_vertex.len()).filter(|v| !fixed[*v]) {
            let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
            for (w, c) in laplacian.row(v) {
                sum += image[*w as usize] * *c;
                weight += c;
            }
            let direction = domain.pull_back(&places[v], sum / weight - image[v]);
            let near = laplacian
                .row(v)
                .iter()
                .map(|(w, _)| x[*w as usize].distance(x[v]))
                .fold(f64::INFINITY, f64::min);
            let mut step = direction.clamp_length_max(0.5 * near);
            let before = x[v];
            for _ in 0..3 {
                x[v] = (before + step).normalize_or(before);
                let upright = around[v]
                    .iter()
                    .all(|t| orientation(s.triangles[*t as usize].map(|w| x[w as usize])) > 0.0);
                if upright && x[v].is_finite() {
                    places[v] = domain.walk(places[v].triangle, x[v]);
                    image[v] = domain.point(&places[v]);
                    break;
                }
                x[v] = before;
                step *= 0.3;
            }
        }
        stage.advance(1);
    }
    Ok(())
}

/// Converts places in the closed template to points of the template's surface.
fn assemble(
    shape: &UnitSurface,
    template: &UnitSurface,
    s: &Closed,
    domain: &Domain,
    places: &[SurfacePoint],
    scale: Option<f64>,
) -> Result<CrossMap, MatchError> {
    let t = domain.closed;
    let landed: Vec<SurfacePoint> = places.iter().map(|p| domain.land(p)).collect();
    let image: Vec<DVec3> = landed.iter().map(|p| domain.point(p)).collect();
    let on_surface = s.surface_vertex.len();
    // 1 means undistorted; a triangle twice as long as wide gets 0.8, ten times as long 0.2.
    let mut trust = vec![(0.0, 0.0); s.points.len()];
    for corners in &s.triangles[..s.surface_triangle.len()] {
        let ratio = stretch(corners.map(|v| s.points[v as usize]), corners.map(|v| image[v as usize]));
        for v in corners {
            trust[*v as usize].0 += 2.0 / (ratio + 1.0 / ratio);
            trust[*v as usize].1 += 1.0;
        }
    }
    // Inside a filled hole the template has only a rim, not a surface.
    let filled = |v: usize| landed[v].triangle != places[v].triangle;
    let trust: Vec<f64> = (0..on_surface)
        .map(|v| if filled(v) { 0.1 } else { 1.0 } * (trust[v].0 / f64::max(trust[v].1, 1.0)).min(1.0))
        .collect();
    // Very distorted parts, such as a neck that fills a hole, must not tilt the head.
    let pose = fit_pairs_at(
        (0..on_surface).map(|v| {
            let vertex = s.surface_vertex[v] as usize;
            (image[v], shape.points[vertex], shape.areas[vertex] * trust[v])
        }),
        scale,
    )?;
    let back = pose.inverse();
    let turn = back.rotation_matrix();
    let mut outside = 0;
    let mut at = Vec::with_capacity(shape.points.len());
    let mut confidence = Vec::with_capacity(shape.points.len());
    for v in 0..shape.points.len() {
        let nothing = MatchError::NoSurface(Side::Template);
        let Some(p) = s.point_of[v] else {
            outside += 1;
            at.push(
                nearest_facing(template, back.at(shape.points[v]), turn * shape.normals[v]).ok_or(nothing)?,
            );
            confidence.push(0.1);
            continue;
        };
        let place = &landed[p as usize];
        let triangle = *t.surface_triangle.get(place.triangle as usize).ok_or(nothing)?;
        let on = SurfacePoint { triangle, weights: place.weights };
        at.push(Closest { on, point: image[p as usize].to_array(), distance_squared: 0.0 });
        confidence.push(trust[p as usize]);
    }
    let mut warnings = Vec::new();
    if outside > 0 {
        warnings.push(format!(
            "vertices outside the largest component of the shape, which got the closest point: {outside}"
        ));
    }
    Ok(CrossMap { at, confidence, pose, warnings })
}
