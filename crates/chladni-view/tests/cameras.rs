//! Cameras and picking, which need no device.
#![allow(
    clippy::unwrap_used,
    clippy::print_stderr,
    reason = "a panic is how a test fails, and a skipped one says so"
)]

mod shapes;

use chladni_mesh::Orientation;
use chladni_view::{Camera, PickTree, Projection, Ray, Rect, View};
use proptest::prelude::*;
use shapes::sphere;

fn camera() -> impl Strategy<Value = Camera> {
    let angles = (-3.1_f32..3.1, -1.57_f32..1.57);
    (angles, 0.3_f32..1.2, any::<bool>(), any::<bool>()).prop_map(
        |((yaw_rad, pitch_rad), fov, flat, z_up)| Camera {
            yaw_rad,
            pitch_rad,
            fov_y_rad: fov,
            projection: if flat { Projection::Orthographic } else { Projection::Perspective },
            stands: if z_up { Orientation::Z_UP } else { Orientation::Y_UP },
            ..Camera::default()
        },
    )
}

proptest! {
    #[test]
    fn a_fitted_frame_holds_every_point_and_touches_one(
        mut camera in camera(),
        points in prop::collection::vec(prop::array::uniform3(-5.0_f32..9.0), 2..40),
        aspect in 0.4_f32..2.5,
    ) {
        camera.fit(points.iter().copied(), aspect, 0.8);
        let viewport = Rect::of_size((1000.0 * aspect) as u32, 1000);
        let aspect = viewport.aspect();
        let mut most = 0.0_f32;
        for point in points {
            let ([x, y], depth) = camera.project(point, viewport).unwrap();
            prop_assert!((0.0..=1.0).contains(&depth), "depth {depth}");
            let off_center = ((x / 500.0 / aspect - 1.0).abs()).max((y / 500.0 - 1.0).abs());
            most = most.max(off_center);
        }
        // Only a shape much deeper than wide is drawn smaller: it must stay before the eye.
        let shallow = camera.distance > 1.2 * camera.reach;
        prop_assert!(most < 0.81 && (most > 0.79 || !shallow), "{most}");
    }

    #[test]
    fn the_ray_through_a_projected_point_meets_it(
        mut camera in camera(),
        point in prop::array::uniform3(-1.0_f32..1.0),
    ) {
        let viewport = Rect { x: 30, y: 50, width: 640, height: 480 };
        camera.fit([[-1.0_f32; 3], [1.0; 3]], viewport.aspect(), 0.9);
        let ([x, y], _) = camera.project(point, viewport).unwrap();
        let Ray { origin, direction } = camera.ray(x, y, viewport);
        let to: [f32; 3] = std::array::from_fn(|i| point[i] - origin[i]);
        let along: f32 = (0..3).map(|i| to[i] * direction[i]).sum();
        let miss = (0..3).map(|i| (to[i] - along * direction[i]).powi(2)).sum::<f32>().sqrt();
        prop_assert!(along > 0.0 && miss < 2e-3, "{along} {miss}");
    }

    #[test]
    fn the_tree_finds_what_looking_at_all_triangles_finds(
        origin in prop::array::uniform3(-3.0_f32..3.0),
        target in prop::array::uniform3(-0.9_f32..0.9),
        stretch in 0.5_f32..2.0,
    ) {
        let (mut positions, triangles) = sphere(9);
        let mut tree = PickTree::new(&positions, &triangles);
        for p in &mut positions {
            p[1] *= stretch;
        }
        tree.refit(&positions, &triangles);
        let d: [f32; 3] = std::array::from_fn(|i| target[i] - origin[i]);
        let length = d.iter().map(|d| d * d).sum::<f32>().sqrt();
        prop_assume!(length > 1e-3);
        let ray = Ray { origin, direction: d.map(|d| d / length) };
        let all = triangles
            .iter()
            .filter_map(|t| PickTree::new(&positions, &[*t]).pick(&ray, &positions, &[*t]))
            .map(|hit| hit.distance)
            .fold(f32::INFINITY, f32::min);
        let found = tree.pick(&ray, &positions, &triangles).map_or(f32::INFINITY, |hit| hit.distance);
        prop_assert_eq!(found, all);
    }
}

#[test]
fn a_vertex_that_is_seen_is_picked_through_its_pixel() {
    let (positions, triangles) = sphere(24);
    let tree = PickTree::new(&positions, &triangles);
    let viewport = Rect::of_size(800, 600);
    for (yaw_rad, pitch_rad) in [(0.0, 0.0), (1.0, 0.4), (-2.5, -1.2)] {
        let mut camera = Camera { yaw_rad, pitch_rad, ..Camera::default() };
        camera.fit(positions.iter().copied(), viewport.aspect(), 0.9);
        let eye = camera.eye();
        let mut seen = 0;
        for (v, p) in positions.iter().enumerate() {
            // Well within the near side of the sphere.
            let facing: f32 = (0..3).map(|i| p[i] * (eye[i] - p[i])).sum();
            if facing < 0.5 || p[1].abs() > 0.999 {
                continue;
            }
            seen += 1;
            let ([x, y], _) = camera.project(*p, viewport).unwrap();
            let ray = camera.ray(x, y, viewport);
            let hit = tree.pick(&ray, &positions, &triangles).unwrap();
            let corner = triangles[hit.triangle as usize][hit.nearest_corner()] as usize;
            assert_eq!(corner, v, "{hit:?} {p:?} {:?} {x} {y} {camera:?}", positions[corner]);
            assert!(hit.point(&ray).iter().zip(p).all(|(a, b)| (a - b).abs() < 1e-3));
            assert!((hit.barycentric.iter().sum::<f32>() - 1.0).abs() < 1e-5);
        }
        assert!(seen > 100);
    }
}

#[test]
fn the_far_side_is_blocked_and_the_near_side_is_not() {
    let (positions, triangles) = sphere(24);
    let tree = PickTree::new(&positions, &triangles);
    for eye in [[0.0, 0.5, 3.0], [-1e6, 2e5, 0.0]] {
        let (mut near, mut far) = (0, 0);
        for p in positions.iter().map(|p| p.map(f64::from)) {
            let way: [f64; 3] = std::array::from_fn(|i| eye[i] - p[i]);
            let cosine =
                (0..3).map(|i| p[i] * way[i]).sum::<f64>() / way.iter().map(|w| w * w).sum::<f64>().sqrt();
            // Where it is seen at a grazing angle, either answer will do.
            if cosine.abs() > 0.1 {
                assert_eq!(tree.blocks(eye, p, &positions, &triangles), cosine < 0.0, "{p:?}");
                *(if cosine < 0.0 { &mut far } else { &mut near }) += 1;
            }
        }
        assert!(near > 100 && far > 100);
    }
    assert!(!PickTree::new(&[], &[]).blocks([0.0; 3], [1.0; 3], &[], &[]));
}

#[test]
fn of_a_thin_part_the_side_toward_the_eye_is_seen() {
    let flat = |z: f32| [[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]];
    let (positions, triangles) = ([flat(0.0), flat(-5e-4)].concat(), [[0, 1, 2], [3, 5, 4]]);
    let tree = PickTree::new(&positions, &triangles);
    let seen_at = |eye, point| tree.seen_at(eye, point, &positions, &triangles);
    for far in [5.0, 1e6] {
        for z in [0.0, -5e-4] {
            let point = [0.2, 0.2, z];
            assert!(!tree.blocks([0.2, 0.2, far], point, &positions, &triangles));
            assert_eq!(seen_at([0.2, 0.2, far], point), Some(0));
            assert_eq!(seen_at([0.2, 0.2, -far], point), Some(1));
        }
        assert_eq!(seen_at([2.0, 2.0, far], [2.0, 2.0, 0.0]), None);
    }
}

#[test]
fn nothing_and_nonsense_are_never_hit() {
    let ray = Ray { origin: [0.0, 0.0, 5.0], direction: [0.0, 0.0, -1.0] };
    assert!(PickTree::new(&[], &[]).pick(&ray, &[], &[]).is_none());
    let positions = [[f32::NAN; 3], [0.0; 3], [1.0, 0.0, 0.0]];
    let triangles = [[0, 1, 2], [1, 1, 1], [7, 8, 9]];
    assert!(PickTree::new(&positions, &triangles).pick(&ray, &positions, &triangles).is_none());
}

#[test]
fn standard_views_look_along_the_axes() {
    let eye = |view, stands| {
        let camera = Camera::on(stands, view);
        camera.eye().map(|c| (c / camera.distance).round() as i32)
    };
    assert_eq!(eye(View::Front, Orientation::Y_UP), [0, 0, 1]);
    assert_eq!(eye(View::Right, Orientation::Y_UP), [1, 0, 0]);
    assert_eq!(eye(View::Top, Orientation::Y_UP), [0, 1, 0]);
    assert_eq!(eye(View::Front, Orientation::Z_UP), [0, -1, 0]);
    assert_eq!(eye(View::Right, Orientation::Z_UP), [1, 0, 0]);
    assert_eq!(eye(View::Top, Orientation::Z_UP), [0, 0, 1]);
    let lies = Orientation::new([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]).unwrap();
    assert_eq!(
        [View::Front, View::Right, View::Top].map(|view| eye(view, lies)),
        [[0, 1, 0], [0, 0, 1], [1, 0, 0]]
    );
}

#[test]
fn dragging_pans_the_target_with_the_pointer_and_zoom_is_bounded() {
    let viewport = Rect::of_size(640, 480);
    let mut camera = Camera { yaw_rad: 0.7, pitch_rad: 0.3, ..Camera::default() };
    let before = camera.target;
    camera.pan(40.0, -25.0, 480.0);
    let ([x, y], _) = camera.project(before, viewport).unwrap();
    assert!((x - 360.0).abs() < 0.5 && (y - 215.0).abs() < 0.5, "{x} {y}");
    camera.zoom(1e6);
    assert!(camera.distance > 0.0);
    camera.zoom(-1e6);
    assert!(camera.distance.is_finite());
    camera.orbit(1e4, -1e6);
    assert!(camera.pitch_rad >= -std::f32::consts::FRAC_PI_2 && camera.yaw_rad.abs() < 3.15);
}

#[test]
fn a_turntable_keeps_the_shape_in_the_frame_at_every_yaw() {
    let points = [[2.0_f32, 0.0, 0.3], [-0.5, 1.0, 0.0], [0.0, -1.0, -1.5], [0.4, 0.2, 0.9]];
    let leans = Orientation::new([0.2, 0.9, -0.4], [1.0, 0.0, 0.7]).unwrap();
    for stands in [Orientation::Y_UP, Orientation::Z_UP, leans] {
        let mut camera = Camera { pitch_rad: 0.25, stands, ..Camera::default() };
        camera.fit_turntable(&points, 1.5, 0.9);
        let viewport = Rect::of_size(300, 200);
        for step in 0..36 {
            camera.yaw_rad = step as f32 / 36.0 * std::f32::consts::TAU;
            for p in points {
                let ([x, y], _) = camera.project(p, viewport).unwrap();
                assert!((0.0..300.0).contains(&x) && (0.0..200.0).contains(&y), "{x} {y} at step {step}");
            }
        }
    }
}

#[test]
fn turntables_and_swings_keep_a_cone_in_the_frame_from_steep_above_and_below() {
    let turn = |i: usize| (i as f32 / 24.0 * std::f32::consts::TAU).sin_cos();
    let base = (0..24).map(|i| [turn(i).0, -1.0, turn(i).1]);
    let cone: Vec<[f32; 3]> = base.chain([[0.0, 1.0, 0.0]]).collect();
    let (viewport, fill) = (Rect::of_size(1600, 1000), 0.92);
    for pitch_rad in [-1.2, -0.4, 0.14, 0.7, 1.2] {
        for swing_rad in [0.4, std::f32::consts::PI] {
            let mut camera = Camera { pitch_rad, ..Camera::default() };
            camera.fit_swing(&cone, viewport.aspect(), fill, swing_rad);
            for step in -10..=10 {
                camera.yaw_rad = 0.1 * swing_rad * step as f32;
                for p in &cone {
                    let ([x, y], _) = camera.project(*p, viewport).unwrap();
                    let away = (x / 800.0 - 1.0).abs().max((y / 500.0 - 1.0).abs());
                    assert!(away < fill + 0.02, "{away} at {pitch_rad}, {swing_rad}, step {step}");
                }
            }
        }
    }
}

#[test]
fn a_frame_that_holds_goes_back_and_only_as_far_as_it_must() {
    let points: Vec<[f32; 3]> = sphere(8).0;
    let viewport = Rect::of_size(400, 300);
    let mut camera = Camera::looking(View::ThreeQuarter);
    camera.fit(points.iter().copied(), viewport.aspect(), 0.8);
    let fitted = camera;
    assert!(!camera.hold(points.iter().copied(), viewport.aspect(), 0.97) && camera == fitted);
    let grown = || points.iter().map(|p| [3.0 * p[0] + 1.0, 2.0 * p[1], p[2]]);
    assert!(camera.hold(grown(), viewport.aspect(), 0.97));
    assert_eq!((camera.target, camera.yaw_rad), (fitted.target, fitted.yaw_rad));
    let outermost = grown().map(|p| {
        let ([x, y], _) = camera.project(p, viewport).unwrap();
        ((x / 200.0 - 1.0).abs()).max((y / 150.0 - 1.0).abs())
    });
    let outermost = outermost.fold(0.0, f32::max);
    assert!((outermost - 0.97).abs() < 1e-3, "{outermost}");
}
