//! From how far a shape fills a picture: wanted from any side, at every frame.

use chladni_mesh::Orientation;
use glam::Vec3;

use crate::Camera;

/// Sides from which it is measured; in between it is interpolated.
const YAWS: usize = 16;
const PITCHES: [f32; 6] = [-0.8, -0.4, 0.0, 0.4, 0.8, 1.2];
/// Rows of the grid in which the covered share of a picture is counted.
const ROWS: usize = 24;
/// Halvings until a distance is found.
const HALVINGS: usize = 9;
/// The upper end of a figure that has risen is at most this share of half a picture above the middle.
const TOP: f32 = 0.97;
/// A figure that has risen is at most this many pictures high, so that a standing one is seen down to its knees,
/// however slim.
const MOST_HEIGHTS: f32 = 0.93;
/// And a part of one that is looked at.
const MOST_HEIGHTS_OF_PART: f32 = 1.7;
/// The nearest an eye comes to a shape, as a share of the shape's reach about the point looked at.
const CLEARANCE: f32 = 0.15;

/// Where the eye is to be so that a shape covers a share of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standpoint {
    /// From the eye to the point looked at.
    pub distance: f32,
    /// How far the point looked at is below the middle of the picture, in heights of the picture.
    pub lift: f32,
}

/// The standpoints around a shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Filling {
    around: Vec<[Standpoint; PITCHES.len()]>,
}

impl Filling {
    /// Around `target`, so that what has these `points` spread evenly over its surface covers `share` of a picture of
    /// `aspect`, or less where it would not have room to rise by `rises`. Where it does not fit, its lower part is
    /// cut off, not its upper one. `None` for a part of a shape, of which anything may be cut off.
    pub fn new(
        points: &[[f32; 3]],
        stands: Orientation,
        target: [f32; 3],
        aspect: f32,
        share: f32,
        rises: Option<f32>,
    ) -> Self {
        let of_yaw = |yaw: usize| {
            let yaw_rad = yaw as f32 * std::f32::consts::TAU / YAWS as f32;
            PITCHES.map(|pitch_rad| {
                let camera = Camera { yaw_rad, pitch_rad, target, stands, ..Camera::default() };
                standpoint(&camera, points, aspect.clamp(0.05, 20.0), share, rises)
            })
        };
        Self { around: (0..YAWS).map(of_yaw).collect() }
    }

    /// Seen from there.
    pub fn from(&self, yaw_rad: f32, pitch_rad: f32) -> Standpoint {
        let turn = (yaw_rad / std::f32::consts::TAU).rem_euclid(1.0) * YAWS as f32;
        let step = PITCHES[1] - PITCHES[0];
        let height = ((pitch_rad - PITCHES[0]) / step).clamp(0.0, (PITCHES.len() - 1) as f32);
        let (column, row) = (turn as usize % YAWS, (height as usize).min(PITCHES.len() - 2));
        let at = |yaw: usize, pitch: usize| self.around[yaw % YAWS][pitch];
        let across = |pitch: usize| mix(at(column, pitch), at(column + 1, pitch), turn.fract());
        mix(across(row), across(row + 1), height - row as f32)
    }
}

/// Distances are mixed as factors.
fn mix(a: Standpoint, b: Standpoint, share: f32) -> Standpoint {
    let distance = a.distance * (b.distance / a.distance).powf(share);
    Standpoint { distance, lift: a.lift + share * (b.lift - a.lift) }
}

fn standpoint(
    camera: &Camera,
    points: &[[f32; 3]],
    aspect: f32,
    share: f32,
    rises: Option<f32>,
) -> Standpoint {
    let axes = camera.axes();
    let target = Vec3::from(camera.target);
    let seen: Vec<Vec3> = points
        .iter()
        .map(|p| Vec3::from(*p) - target)
        .filter(|p| p.is_finite())
        .map(|p| Vec3::from(axes.map(|axis| p.dot(axis))))
        .collect();
    let reach = seen.iter().fold(1e-6f32, |reach, p| reach.max(p.length()));
    let near = seen.iter().fold(0.0f32, |near, p| near.max(p.z)) + CLEARANCE * reach;
    let tan_y = (0.5 * camera.fov_y_rad).tan();
    let (bottom, top) = seen.iter().fold((0.0f32, 0.0f32), |(b, t), p| (b.min(p.y), t.max(p.y)));
    let most = if rises.is_some() { MOST_HEIGHTS } else { MOST_HEIGHTS_OF_PART };
    let near = near.max((top + rises.unwrap_or(0.0) - bottom) / (2.0 * tan_y * most));
    let lift = |distance| rises.map_or(0.0, |rises| lift(&seen, rises, distance, tan_y));
    let (mut low, mut high) = (near, 6.0 * (near + reach) / tan_y.min(tan_y * aspect));
    for _ in 0..HALVINGS {
        let distance = (low * high).sqrt();
        if covered(&seen, distance, lift(distance), tan_y, aspect) > share {
            low = distance;
        } else {
            high = distance;
        }
    }
    let distance = (low * high).sqrt();
    Standpoint { distance, lift: lift(distance) }
}

/// How far the shape is lowered so that its upper end is seen when it has risen.
fn lift(seen: &[Vec3], rises: f32, distance: f32, tan_y: f32) -> f32 {
    let top = seen.iter().fold(f32::NEG_INFINITY, |top, p| top.max((p.y + rises) / (distance - p.z)));
    ((top - TOP * tan_y) / (2.0 * tan_y)).max(0.0)
}

/// The share of the picture's cells in which there is a point.
fn covered(seen: &[Vec3], distance: f32, lift: f32, tan_y: f32, aspect: f32) -> f32 {
    let columns = ((ROWS as f32 * aspect).round() as usize).clamp(4, 240);
    let mut cells = vec![false; ROWS * columns];
    for p in seen {
        let depth = distance - p.z;
        let (x, y) = (p.x / (depth * tan_y * aspect), p.y / (depth * tan_y) - 2.0 * lift);
        if x.abs() < 1.0 && y.abs() < 1.0 {
            let cell = |at: f32, count: usize| ((0.5 * (at + 1.0) * count as f32) as usize).min(count - 1);
            cells[cell(y, ROWS) * columns + cell(x, columns)] = true;
        }
    }
    cells.iter().filter(|cell| **cell).count() as f32 / cells.len() as f32
}

/// About `count` points spread evenly over a surface. Triangles that name no vertex are left out.
pub fn surface_points(positions: &[[f32; 3]], triangles: &[[u32; 3]], count: usize) -> Vec<[f32; 3]> {
    let corners = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|v| positions.get(v as usize).copied().map(Vec3::from));
        Some([a?, b?, c?])
    };
    let area = |[a, b, c]: [Vec3; 3]| 0.5 * (b - a).cross(c - a).length();
    let whole: f32 = triangles.iter().filter_map(corners).map(area).filter(|area| area.is_finite()).sum();
    let (mut points, mut due) = (Vec::with_capacity(count), 0.5f32);
    for [a, b, c] in triangles.iter().filter_map(corners) {
        let share = area([a, b, c]) / whole.max(f32::MIN_POSITIVE) * count as f32;
        due += if share.is_finite() { share } else { 0.0 };
        while due >= 1.0 && points.len() < 2 * count {
            // Two steps that share no period fill any triangle evenly (M. Roberts 2018).
            let n = points.len() as f32;
            let (mut u, mut v) = ((0.754_877_7 * n).fract(), (0.569_840_3 * n).fract());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            points.push((a + (b - a) * u + (c - a) * v).to_array());
            due -= 1.0;
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box of this size: its corners and twelve triangles.
    fn cuboid(size: [f32; 3]) -> Vec<[f32; 3]> {
        let corner = |i: usize| std::array::from_fn(|a| if i >> a & 1 == 1 { 0.5 } else { -0.5 } * size[a]);
        let corners: Vec<[f32; 3]> = (0..8).map(corner).collect();
        let faces = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
        let triangles: Vec<[u32; 3]> =
            faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        surface_points(&corners, &triangles, 6000)
    }

    #[test]
    fn a_wall_covers_what_it_should_from_every_side() {
        let points = cuboid([2.0, 1.0, 0.8]);
        assert!((5000..7000).contains(&points.len()));
        let filling = Filling::new(&points, Orientation::Y_UP, [0.0; 3], 1.5, 0.27, Some(0.0));
        for (yaw_rad, pitch_rad) in [(0.0, 0.0), (0.6, 0.1), (3.0, -0.4), (-1.2, 0.8), (7.0, 0.5)] {
            let Standpoint { distance, lift } = filling.from(yaw_rad, pitch_rad);
            let camera = Camera { yaw_rad, pitch_rad, ..Camera::default() };
            let axes = camera.axes();
            let seen: Vec<Vec3> =
                points.iter().map(|p| Vec3::from(axes.map(|a| Vec3::from(*p).dot(a)))).collect();
            let tan_y = (0.5 * camera.fov_y_rad).tan();
            let share = covered(&seen, distance, lift, tan_y, 1.5);
            assert!((share - 0.27).abs() < 0.06, "from {yaw_rad}, {pitch_rad}: {share}");
        }
    }

    #[test]
    fn the_head_of_a_tall_figure_is_seen_and_the_eye_stays_outside() {
        let points = cuboid([0.3, 2.0, 0.3]);
        let filling = Filling::new(&points, Orientation::Y_UP, [0.0; 3], 1.7, 0.4, Some(0.4));
        let Standpoint { distance, lift } = filling.from(0.0, 0.0);
        let tan_y = (0.5 * Camera::default().fov_y_rad).tan();
        let [rest, risen] = [1.0, 1.4].map(|y| y / (distance * tan_y) - 2.0 * lift);
        assert!(lift > 0.05 && rest > 0.4 && (0.85..0.98).contains(&risen), "{lift} {rest} {risen}");
        let near = Filling::new(&points, Orientation::Y_UP, [0.0; 3], 1.7, 1.0, None);
        assert!(near.from(0.0, 0.0).distance > 0.15);
    }

    #[test]
    fn it_changes_smoothly_with_the_side() {
        let filling =
            Filling::new(&cuboid([2.0, 0.7, 0.4]), Orientation::Y_UP, [0.2, 0.0, 0.0], 1.5, 0.42, Some(0.1));
        let steps = (0..2000).map(|i| filling.from(0.005 * i as f32, (0.01 * i as f32).sin()).distance);
        let distances: Vec<f32> = steps.collect();
        let most = distances.windows(2).map(|pair| (pair[1] / pair[0]).ln().abs()).fold(0.0, f32::max);
        assert!(most < 0.03, "{most}");
    }
}
