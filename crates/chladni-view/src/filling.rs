//! The distance from which a shape fills a picture, for every direction; cheap enough to ask in every frame.

use chladni_mesh::Orientation;
use glam::Vec3;
use rayon::prelude::*;

use crate::Camera;

/// Directions for which it is measured; in between it is interpolated.
const YAWS: usize = 16;
const PITCHES: [f32; 6] = [-0.8, -0.4, 0.0, 0.4, 0.8, 1.2];
/// Rows of the grid in which the covered share of a picture is counted.
const ROWS: usize = 24;
/// Halvings until a distance is found.
const HALVINGS: usize = 11;
/// The upper end of a figure is at most this share of half a picture above the middle.
pub const TOP: f32 = 0.94;
/// The greatest height of a figure seen as a whole, in heights of the picture, however slim it is.
pub const WHOLE_HEIGHTS: f32 = 0.94;
/// The same of a figure that is cut off below where it is slim: at the knees, of one that stands.
pub const CROPPED_HEIGHTS: f32 = 1.4;
/// The same of a figure seen from near, whose upper part fills the picture.
pub const NEAR_HEIGHTS: f32 = 1.8;
/// The point looked at is at most this many pictures below the upper end.
const DEEPEST: f32 = 0.8;
/// The least distance of an eye from a shape, as a share of the shape's reach about the point looked at.
const CLEARANCE: f32 = 0.15;

/// Distances from the eye to the point looked at, all around a shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Filling {
    around: Vec<[f32; PITCHES.len()]>,
}

/// How far a moving shape reaches beyond its place at rest, and how large it may then be seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Headroom {
    /// How far its upper end rises, in the shape's units.
    pub rises: f32,
    /// How far its lower end sinks, in the same units.
    pub sinks: f32,
    /// How far its sides move outward, in the same units.
    pub spreads: f32,
    /// [`WHOLE_HEIGHTS`], [`CROPPED_HEIGHTS`] or [`NEAR_HEIGHTS`].
    pub most_heights: f32,
    /// How far from the middle its sides may then be, in halves of the picture.
    pub most_widths: f32,
}

impl Filling {
    /// Distances around `target` at which the surface sampled evenly by `points` covers `share` of a picture of this
    /// `aspect`, or less if `room` requires it. If the whole does not fit, a camera there that [keeps the upper
    /// end](Camera::keep_below) in the picture cuts off the lower part.
    pub fn new(
        points: &[[f32; 3]],
        stands: Orientation,
        target: [f32; 3],
        aspect: f32,
        share: f32,
        room: Headroom,
    ) -> Self {
        let of_yaw = |yaw: usize| {
            let yaw_rad = yaw as f32 * std::f32::consts::TAU / YAWS as f32;
            PITCHES.map(|pitch_rad| {
                let camera = Camera { yaw_rad, pitch_rad, target, stands, ..Camera::default() };
                distance(&camera, points, aspect.clamp(0.05, 20.0), share, room)
            })
        };
        Self { around: (0..YAWS).into_par_iter().map(of_yaw).collect() }
    }

    /// The distance from that side.
    pub fn from(&self, yaw_rad: f32, pitch_rad: f32) -> f32 {
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
fn mix(a: f32, b: f32, share: f32) -> f32 {
    a * (b / a).powf(share)
}

fn distance(camera: &Camera, points: &[[f32; 3]], aspect: f32, share: f32, room: Headroom) -> f32 {
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
    let top = seen.iter().fold(0.0f32, |top, p| top.max(p.y));
    let near = near.max((top + room.rises) / (2.0 * tan_y * DEEPEST));
    let moves = room.rises.max(room.spreads);
    let (mut low, mut high) = (near, 6.0 * (near + reach + moves) / tan_y.min(tan_y * aspect));
    for _ in 0..HALVINGS {
        let distance = (low * high).sqrt();
        let lift = lift(&seen, room.rises, distance, tan_y);
        if heights(&seen, room, distance) > 2.0 * tan_y * room.most_heights
            || width(&seen, room.spreads, distance) > tan_y * aspect * room.most_widths
            || covered(&seen, distance, lift, tan_y, aspect) > share
        {
            low = distance;
        } else {
            high = distance;
        }
    }
    high
}

/// How high the shape is seen, at a distance of 1, when its upper end has risen and its lower end has sunk.
fn heights(seen: &[Vec3], room: Headroom, distance: f32) -> f32 {
    let (low, high) = seen.iter().fold((0.0f32, 0.0f32), |(low, high), p| {
        let depth = distance - p.z;
        (low.min((p.y - room.sinks) / depth), high.max((p.y + room.rises) / depth))
    });
    high - low
}

/// How far from the middle its sides are seen, at a distance of 1, when they have moved outward.
fn width(seen: &[Vec3], spreads: f32, distance: f32) -> f32 {
    seen.iter().fold(0.0f32, |width, p| width.max((p.x.abs() + spreads) / (distance - p.z)))
}

/// How far the shape is lowered so that its upper end is seen when it has risen, in heights of the picture.
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
    use crate::Rect;

    /// A box of this size: its corners and twelve triangles.
    fn cuboid(size: [f32; 3]) -> Vec<[f32; 3]> {
        let corner = |i: usize| std::array::from_fn(|a| if i >> a & 1 == 1 { 0.5 } else { -0.5 } * size[a]);
        let corners: Vec<[f32; 3]> = (0..8).map(corner).collect();
        let faces = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
        let triangles: Vec<[u32; 3]> =
            faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        surface_points(&corners, &triangles, 6000)
    }

    fn whole(rises: f32) -> Headroom {
        let (most_heights, most_widths) = (WHOLE_HEIGHTS, f32::INFINITY);
        Headroom { rises, sinks: 0.3 * rises, spreads: 0.0, most_heights, most_widths }
    }

    #[test]
    fn a_wall_covers_what_it_should_from_every_side() {
        let points = cuboid([2.0, 1.0, 0.8]);
        assert!((5000..7000).contains(&points.len()));
        let filling = Filling::new(&points, Orientation::Y_UP, [0.0; 3], 1.5, 0.27, whole(0.0));
        for (yaw_rad, pitch_rad) in [(0.0, 0.0), (0.6, 0.1), (3.0, -0.4), (-1.2, 0.8), (7.0, 0.5)] {
            let distance = filling.from(yaw_rad, pitch_rad);
            let camera = Camera { yaw_rad, pitch_rad, ..Camera::default() };
            let axes = camera.axes();
            let seen: Vec<Vec3> =
                points.iter().map(|p| Vec3::from(axes.map(|a| Vec3::from(*p).dot(a)))).collect();
            let tan_y = (0.5 * camera.fov_y_rad).tan();
            let share = covered(&seen, distance, lift(&seen, 0.0, distance, tan_y), tan_y, 1.5);
            assert!((share - 0.27).abs() < 0.06, "from {yaw_rad}, {pitch_rad}: {share}");
        }
    }

    #[test]
    fn the_head_of_a_tall_figure_is_seen_and_the_eye_stays_outside() {
        let points = cuboid([0.3, 2.0, 0.3]);
        let seen_from = |most_heights: f32, target: [f32; 3], share: f32| {
            let room = Headroom { most_heights, ..whole(0.4) };
            let filling = Filling::new(&points, Orientation::Y_UP, target, 1.7, share, room);
            let mut camera = Camera { target, distance: filling.from(0.0, 0.0), ..Camera::default() };
            camera.keep_below(points.iter().copied(), room.rises, TOP);
            let at = |y: f32| {
                let picture = Rect::of_size(1700, 1000);
                let ([_, down], _) = camera.project([0.0, y, 0.15], picture).unwrap();
                1.0 - down / 500.0
            };
            [-1.0, target[1], 1.0, 1.4].map(at)
        };
        let [feet, _, head, risen] = seen_from(WHOLE_HEIGHTS, [0.0; 3], 0.4);
        assert!(feet > -1.0 && head > 0.3 && risen <= TOP + 1e-3, "{feet} {head} {risen}");
        let [feet, _, head, risen] = seen_from(NEAR_HEIGHTS, [0.0; 3], 1.0);
        assert!(feet < -1.2 && head > 0.3 && risen <= TOP + 1e-3, "{feet} {head} {risen}");
        // The point looked at is in the picture, too, even at the feet.
        let [_, looked_at, head, risen] = seen_from(NEAR_HEIGHTS, [0.0, -0.9, 0.0], 1.0);
        assert!(looked_at > -0.95 && head > 0.3 && risen <= TOP + 1e-3, "{looked_at} {head} {risen}");
        let near = Filling::new(&points, Orientation::Y_UP, [0.0; 3], 1.7, 1.0, whole(0.0));
        assert!(near.from(0.0, 0.0) > 0.15);
    }

    #[test]
    fn what_reaches_toward_the_viewer_is_in_the_picture_too() {
        // As wide and deep as an octopus with its arms spread.
        let ring = (0..48).map(|i| (i as f32 * std::f32::consts::PI / 24.0).sin_cos());
        let points: Vec<[f32; 3]> =
            ring.flat_map(|(sin, cos)| [-0.5, 0.5].map(|y| [1.2 * sin, y, 1.2 * cos])).collect();
        let room = whole(0.5);
        let filling = Filling::new(&points, Orientation::Y_UP, [0.0; 3], 1.7, 0.9, room);
        for (yaw_rad, pitch_rad) in [(0.0, 0.0), (0.4, 0.1), (1.0, -0.4), (2.0, 0.4), (-0.7, 0.7)] {
            let distance = filling.from(yaw_rad, pitch_rad);
            let mut camera = Camera { yaw_rad, pitch_rad, distance, ..Camera::default() };
            camera.keep_below(points.iter().copied(), room.rises, TOP);
            let [_, up, back] = camera.axes();
            let edge = (0.5 * camera.fov_y_rad).tan();
            let height = |p: &[f32; 3], rises: f32| {
                let p = Vec3::from(*p) - Vec3::from(camera.target);
                (p.dot(up) + rises) / (edge * (distance - p.dot(back)))
            };
            let high = points.iter().map(|p| height(p, room.rises)).fold(f32::MIN, f32::max);
            let low = points.iter().map(|p| height(p, -room.sinks)).fold(f32::MAX, f32::min);
            assert!(high < TOP + 1e-3 && low > -1.0, "from {yaw_rad}, {pitch_rad}: {low} to {high}");
        }
    }

    #[test]
    fn a_figure_that_is_cropped_below_keeps_its_sides() {
        let most = |size: [f32; 3]| {
            let room = Headroom { most_heights: CROPPED_HEIGHTS, most_widths: 0.8, ..whole(0.2) };
            let points = cuboid(size);
            let distance = Filling::new(&points, Orientation::Y_UP, [0.0; 3], 1.4, 0.9, room).from(0.0, 0.0);
            let edge = (0.5 * Camera::default().fov_y_rad).tan();
            let ends =
                points.iter().map(|p| [p[0].abs() / 1.4, p[1].abs()].map(|c| c / (distance - p[2]) / edge));
            ends.fold([0.0f32; 2], |most, end| [0, 1].map(|i| most[i].max(end[i])))
        };
        let [wide, slim] = [most([2.0, 1.5, 0.4]), most([0.4, 2.0, 0.4])];
        assert!((0.7..0.81).contains(&wide[0]) && wide[1] < 1.0, "{wide:?}");
        assert!(slim[0] < 0.4 && slim[1] > 1.1, "{slim:?}");
    }

    #[test]
    fn sides_that_move_outward_stay_in_a_narrow_picture() {
        let points = cuboid([1.0, 1.0, 0.4]);
        let most = |spreads: f32| {
            let room = Headroom { spreads, most_widths: 0.9, ..whole(0.1) };
            let distance = Filling::new(&points, Orientation::Y_UP, [0.0; 3], 0.6, 0.9, room).from(0.0, 0.0);
            let edge = 0.6 * (0.5 * Camera::default().fov_y_rad).tan();
            points.iter().map(|p| (p[0].abs() + spreads) / (distance - p[2]) / edge).fold(0.0, f32::max)
        };
        for spreads in [0.0, 0.2, 0.6] {
            assert!((0.87..0.905).contains(&most(spreads)), "{spreads}: {}", most(spreads));
        }
    }

    #[test]
    fn it_changes_smoothly_with_the_side() {
        let filling =
            Filling::new(&cuboid([2.0, 0.7, 0.4]), Orientation::Y_UP, [0.2, 0.0, 0.0], 1.5, 0.42, whole(0.1));
        let steps = (0..2000).map(|i| filling.from(0.005 * i as f32, (0.01 * i as f32).sin()));
        let distances: Vec<f32> = steps.collect();
        let most = distances.windows(2).map(|pair| (pair[1] / pair[0]).ln().abs()).fold(0.0, f32::max);
        assert!(most < 0.03, "{most}");
    }
}
