//! Shapes side by side, all to one scale, as large as a format allows.

use crate::{Camera, Rect, layout};

/// The share of its cell that the shape which needs most room fills in pictures.
pub const FILL: f32 = 0.9;

/// A cell for each of `shapes` within `area`, row by row, and its camera, which looks in the direction of `from`. Each shape
/// is in the middle of its cell, all have the same scale, and the one that needs most room takes up the share `fill` of its
/// cell. The numbers of rows and columns are those that show the shapes largest.
pub fn side_by_side(from: Camera, shapes: &[&[[f32; 3]]], area: Rect, fill: f32) -> Vec<(Rect, Camera)> {
    let arranged = |columns: usize| {
        let rows = shapes.len().div_ceil(columns);
        let cells = layout::grid(area, rows, columns, 0, shapes.len());
        let mut placed: Vec<(Rect, Camera)> = cells
            .into_iter()
            .zip(shapes)
            .map(|(cell, shape)| {
                let mut camera = from;
                camera.fit(shape.iter().copied(), cell.aspect(), fill);
                (cell, camera)
            })
            .collect();
        let scale = placed.iter().map(pixels_per_unit).fold(f32::INFINITY, f32::min);
        for (cell, camera) in &mut placed {
            camera.distance *= pixels_per_unit(&(*cell, *camera)) / scale;
        }
        (scale, placed)
    };
    let all = (1..=shapes.len()).map(arranged);
    let largest = all.max_by(|a, b| a.0.total_cmp(&b.0));
    let mut placed = largest.map_or_else(Vec::new, |(_, placed)| placed);
    for ((_, camera), shape) in placed.iter_mut().zip(shapes) {
        camera.center(shape.iter().copied());
    }
    placed
}

/// How large a length at the target is drawn, up to a factor that all lenses of one kind share.
fn pixels_per_unit((cell, camera): &(Rect, Camera)) -> f32 {
    cell.height.max(1) as f32 / camera.distance.max(f32::MIN_POSITIVE)
}

/// Those of `points` that are farthest in one of 400 directions, spread evenly over the sphere: few points that
/// need as much room as all, to within half a percent. Points that are not finite are left out.
pub fn extremes(points: &[[f32; 3]]) -> Vec<[f32; 3]> {
    const DIRECTIONS: usize = 400;
    let golden_angle = std::f32::consts::PI * (3.0 - 5.0_f32.sqrt());
    let direction = |i: usize| {
        let z = 1.0 - (2 * i + 1) as f32 / DIRECTIONS as f32;
        let (sin, cos) = (golden_angle * i as f32).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        [radius * cos, radius * sin, z]
    };
    let finite: Vec<usize> = (0..points.len()).filter(|&i| points[i].iter().all(|c| c.is_finite())).collect();
    let farthest = |along: [f32; 3]| {
        let reach = |i: &usize| (0..3).map(|c| along[c] * points[*i][c]).sum::<f32>();
        finite.iter().copied().max_by(|a, b| reach(a).total_cmp(&reach(b)))
    };
    let mut chosen: Vec<usize> = (0..DIRECTIONS).filter_map(|i| farthest(direction(i))).collect();
    chosen.sort_unstable();
    chosen.dedup();
    chosen.into_iter().map(|i| points[i]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Projection;

    #[test]
    fn extremes_need_the_room_of_all() {
        let ball: Vec<[f32; 3]> = (0..20_000)
            .map(|i| {
                let z = 1.0 - (2 * i + 1) as f32 / 20_000.0;
                let (sin, cos) = (2.399_963 * i as f32).sin_cos();
                let radius = (1.0 - z * z).sqrt();
                [2.0 * radius * cos, radius * sin, 0.5 * z]
            })
            .collect();
        let few = extremes(&ball);
        assert!(few.len() <= 400);
        let (mut all, mut some) = (Camera::default(), Camera::default());
        all.fit(ball.iter().copied(), 1.5, 0.9);
        some.fit(few.iter().copied(), 1.5, 0.9);
        assert!((some.distance / all.distance - 1.0).abs() < 0.005, "{} {}", some.distance, all.distance);
        assert!(extremes(&[[f32::NAN; 3]]).is_empty());
    }

    #[test]
    fn a_swing_needs_no_more_room_than_a_turntable_and_keeps_all_in_the_frame() {
        let cow = corners([3.0, 0.0, -1.0], [0.5, 1.0, 4.0]);
        let mut turntable = Camera { pitch_rad: 0.2, ..Camera::default() };
        let mut swing = turntable;
        turntable.fit_turntable(&cow, 1.0, 0.9);
        swing.fit_swing(&cow, 1.0, 0.9, 0.35);
        assert!(swing.distance < 0.9 * turntable.distance, "{} {}", swing.distance, turntable.distance);
        for yaw_rad in [-0.35f32, -0.1, 0.0, 0.2, 0.35] {
            seen(&cow, &(Rect::of_size(300, 300), Camera { yaw_rad, ..swing }));
        }
    }

    /// A box of this size around `center`.
    fn corners(center: [f32; 3], size: [f32; 3]) -> Vec<[f32; 3]> {
        let at = |i: usize, a: usize| center[a] + if i >> a & 1 == 1 { 0.5 } else { -0.5 } * size[a];
        (0..8).map(|i| [at(i, 0), at(i, 1), at(i, 2)]).collect()
    }

    /// Width and height in pixels of the visible part of `points`, after checking that it is in its cell.
    fn seen(points: &[[f32; 3]], (cell, camera): &(Rect, Camera)) -> [f32; 2] {
        let pixels: Vec<[f32; 2]> = points.iter().map(|p| camera.project(*p, *cell).unwrap().0).collect();
        assert!(pixels.iter().all(|[x, y]| cell.contains(*x, *y)), "{cell:?}: {pixels:?}");
        std::array::from_fn(|i| {
            let along = || pixels.iter().map(|p| p[i]);
            along().fold(f32::MIN, f32::max) - along().fold(f32::MAX, f32::min)
        })
    }

    #[test]
    fn a_format_is_used_and_both_shapes_have_one_scale() {
        let man = corners([0.0; 3], [0.3, 1.8, 0.2]);
        // Moved far away and grown: neither may make the first one small beyond its own scale.
        let grown = corners([7.0, -3.0, 1.0], [0.4, 2.0, 0.3]);
        for (width, height) in [(1600, 900), (900, 1600), (600, 600)] {
            let area = Rect::of_size(width, height);
            let placed = side_by_side(Camera::default(), &[&man, &grown], area, 0.9);
            let ([_, man_high], [_, grown_high]) = (seen(&man, &placed[0]), seen(&grown, &placed[1]));
            // The taller one touches its margins, in cells of the format's full height.
            assert!((grown_high / height as f32 - 0.9).abs() < 0.01, "{width}×{height}: {grown_high}");
            let ratio = man_high / grown_high;
            assert!((ratio - 0.9).abs() < 0.03, "{ratio}");
        }
    }

    #[test]
    fn shapes_are_in_the_middle_of_their_cells_from_wherever_they_are_seen() {
        let rod = [corners([0.0; 3], [10.0, 1.0, 1.0]), corners([3.0, 0.0, 1.0], [0.5, 0.8, 8.0])];
        let shapes = rod.each_ref().map(Vec::as_slice);
        for (projection, yaw_rad) in [(Projection::Perspective, 0.1), (Projection::Orthographic, 1.0)] {
            let from = Camera { yaw_rad, pitch_rad: 0.2, projection, ..Camera::default() };
            for area in [Rect::of_size(600, 600), Rect::of_size(1000, 200)] {
                for ((cell, camera), shape) in side_by_side(from, &shapes, area, 0.9).iter().zip(shapes) {
                    let pixels: Vec<[f32; 2]> =
                        shape.iter().map(|p| camera.project(*p, *cell).unwrap().0).collect();
                    for (i, begin, side) in [(0, cell.x, cell.width), (1, cell.y, cell.height)] {
                        let before = pixels.iter().map(|p| p[i] - begin as f32).fold(f32::MAX, f32::min);
                        let behind =
                            pixels.iter().map(|p| (begin + side) as f32 - p[i]).fold(f32::MAX, f32::min);
                        assert!((before - behind).abs() < 0.5, "{area:?}: {before} and {behind}");
                    }
                }
            }
        }
    }

    #[test]
    fn wide_shapes_stand_above_each_other() {
        let whale = corners([0.0; 3], [6.0, 1.0, 1.0]);
        let placed = side_by_side(Camera::default(), &[&whale, &whale], Rect::of_size(1600, 900), 0.9);
        assert!(placed[0].0.width == 1600 && placed[1].0.y > 400);
        assert!(seen(&whale, &placed[0])[0] > 0.88 * 1600.0);
        assert!(side_by_side(Camera::default(), &[], Rect::of_size(10, 10), 0.9).is_empty());
    }
}
