//! Drawings in ink: contours against closed forms, what is hidden, and the files they become.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use chladni_mesh::samples;
use chladni_mesh::surface::vec3::{Vec3, add, dot, scaled, unit};
use chladni_view::ink::{Drawing, Ink, Mark, Plate, Stroke, StrokePoint};
use chladni_view::{Camera, Rect, ViewError};

const CELL: Rect = Rect { x: 40, y: 20, width: 600, height: 500 };
const BARE: Ink = Ink { paper: [255; 3], color: [0; 3], pen: 0.003, detail: 0.0, hatching: 0.0, tones: 0 };

fn ball() -> Plate {
    let mesh = samples::icosphere(5);
    Plate::new(&mesh.positions, &mesh.triangles, Plate::SMOOTHING).unwrap()
}

/// The ring's and the tube's radius of [`ring`].
const RING: [f64; 2] = [1.0, 0.4];

fn ring() -> Plate {
    let (positions, triangles) = torus();
    Plate::new(&positions, &triangles, Plate::SMOOTHING).unwrap()
}

/// A torus about y.
fn torus() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let [around, tube] = [160_u32, 64];
    let mut positions = Vec::new();
    for i in 0..around {
        for j in 0..tube {
            let [a, b] =
                [(i, around), (j, tube)].map(|(i, n)| f64::from(i) / f64::from(n) * std::f64::consts::TAU);
            let r = RING[0] + RING[1] * b.cos();
            positions.push([r * a.cos(), RING[1] * b.sin(), r * a.sin()]);
        }
    }
    let at = |i: u32, j: u32| (i % around) * tube + j % tube;
    let quads = (0..around).flat_map(|i| (0..tube).map(move |j| [i, j]));
    let triangles = quads.flat_map(|[i, j]| {
        let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
        [[a, b, c], [a, c, d]]
    });
    (positions, triangles.collect())
}

fn ring_distance([x, y, z]: Vec3) -> f64 {
    (x.hypot(z) - RING[0]).hypot(y) - RING[1]
}

fn length(stroke: &Stroke) -> f64 {
    stroke.points.windows(2).map(|p| (p[0].at[0] - p[1].at[0]).hypot(p[0].at[1] - p[1].at[1])).sum()
}

#[test]
fn the_contour_of_a_ball_is_one_circle_of_the_radius_that_perspective_gives() {
    let camera = Camera { distance: 5.0, yaw_rad: 0.4, pitch_rad: 0.3, ..Camera::default() };
    let strokes = ball().strokes(&BARE, &camera, CELL);
    assert_eq!(strokes.len(), 1);
    let points = &strokes[0].points;
    assert_eq!(points.first().unwrap().at, points.last().unwrap().at);
    // The tangent from the eye to a ball of radius 1 at distance D rises 1 / √(D² − 1).
    let focal = 0.5 * f64::from(CELL.height) / (0.5 * f64::from(camera.fov_y_rad)).tan();
    let radius = focal / (25.0_f64 - 1.0).sqrt();
    let center = [340.0, 270.0];
    for point in points {
        let r = (point.at[0] - center[0]).hypot(point.at[1] - center[1]);
        assert!((r - radius).abs() < 0.3, "{r} and not {radius}");
    }
    assert!((length(&strokes[0]) / (std::f64::consts::TAU * radius) - 1.0).abs() < 0.005);
}

#[test]
fn what_is_drawn_of_a_ring_is_what_the_eye_grazes_first() {
    let plate = ring();
    let camera = Camera { distance: 6.0, pitch_rad: 0.35, ..Camera::default() };
    let strokes = plate.strokes(&BARE, &camera, CELL);
    let slope = |p: Vec3| {
        let step = |i: usize| {
            let h = |s: f64| std::array::from_fn(|j| p[j] + if i == j { s } else { 0.0 });
            ring_distance(h(1e-6)) - ring_distance(h(-1e-6))
        };
        unit([step(0), step(1), step(2)])
    };
    let mut points = 0;
    for (stroke, point) in strokes.iter().flat_map(|stroke| stroke.points.iter().map(move |p| (stroke, p))) {
        let ray = camera.ray(point.at[0] as f32, point.at[1] as f32, CELL);
        let (mut at, way) = (ray.origin.map(f64::from), ray.direction.map(f64::from));
        // As far as nothing can be, until the ring is within one or two pixels, or lies behind.
        let (mut distance, mut left) = (f64::INFINITY, 10.0);
        while distance > 0.012 && left > 0.0 {
            distance = ring_distance(at);
            let step = 0.5 * distance.max(0.01);
            (at, left) = (add(at, scaled(way, step)), left - step);
        }
        assert!(distance <= 0.012, "{point:?} lies beside the ring");
        // A stroke may end a little late.
        let ends = [&stroke.points[0], &stroke.points[stroke.points.len() - 1]];
        let left = ends.map(|end| (end.at[0] - point.at[0]).hypot(end.at[1] - point.at[1]));
        let hidden = dot(slope(at), way).abs() > 0.25;
        assert!(!hidden || left[0].min(left[1]) < 6.0, "{point:?} lies behind the ring");
        points += usize::from(!hidden);
    }
    assert!(points > 50);
    // The outline is closed; of the hole, a part is seen.
    assert!(strokes.len() >= 2 && strokes.len() <= 4, "{}", strokes.len());
    assert_eq!(strokes[0].points.first().unwrap().at, strokes[0].points.last().unwrap().at);
    assert!(length(&strokes[1]) > 60.0);
}

#[test]
fn the_contour_of_a_cube_is_one_closed_line_around_what_is_seen_of_it() {
    let positions: Vec<Vec3> = (0..8).map(|i| [0, 1, 2].map(|k| f64::from((i >> k) & 1) - 0.5)).collect();
    let quads: [[u32; 4]; 6] =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let plate = Plate::new(&positions, &triangles, Plate::SMOOTHING).unwrap();
    for yaw_rad in [0.0, 0.6, 2.0] {
        let camera = Camera { distance: 4.0, yaw_rad, pitch_rad: 0.4, ..Camera::default() };
        let strokes = plate.strokes(&BARE, &camera, CELL);
        assert_eq!(strokes.len(), 1, "{yaw_rad}");
        let points = &strokes[0].points;
        assert_eq!(points[0].at, points[points.len() - 1].at);
        let cross = |[a, b]: [[f64; 2]; 2]| 0.5 * (a[0] * b[1] - a[1] * b[0]);
        let around: f64 = points.windows(2).map(|p| cross([p[0].at, p[1].at])).sum();
        let is_hit = |x: u32, y: u32| {
            let ray = camera.ray((CELL.x + x) as f32 + 0.5, (CELL.y + y) as f32 + 0.5, CELL);
            let ends = (0..3).map(|i| {
                let [a, b] = [-0.5, 0.5].map(|side| (side - ray.origin[i]) / ray.direction[i]);
                [a.min(b), a.max(b)]
            });
            let both = ends.fold([0.0, f32::INFINITY], |[low, high], [a, b]| [low.max(a), high.min(b)]);
            both[0] < both[1]
        };
        let seen = (0..CELL.height).flat_map(|y| (0..CELL.width).map(move |x| (x, y)));
        let seen = seen.filter(|(x, y)| is_hit(*x, *y)).count() as f64;
        assert!((around.abs() / seen - 1.0).abs() < 0.01, "{around} around {seen} pixels at {yaw_rad}");
    }
}

#[test]
fn a_slit_in_a_sheet_is_drawn_only_where_it_is_long() {
    let n = 60_u32;
    let at = |i: u32| f64::from(i) / f64::from(n) - 0.5;
    let strokes = |slit: std::ops::Range<u32>| {
        let grid = (0..=n).flat_map(|j| (0..=n).map(move |i| [at(i), 0.0, at(j)]));
        let mut positions: Vec<Vec3> = grid.collect();
        let row = n / 2;
        // The triangles beyond the slit have vertices of their own along it.
        let own = positions.len() as u32;
        positions.extend(slit.clone().map(|i| [at(i), 0.0, at(row)]));
        let cells = (0..n).flat_map(|j| (0..n).map(move |i| [i, j]));
        let triangles = cells.flat_map(|[i, j]| {
            let corner = |i: u32, k: u32| {
                if k == row && j == row && slit.contains(&i) { own + i - slit.start } else { k * (n + 1) + i }
            };
            let [a, b, c, d] = [corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j)];
            [[a, b, c], [a, c, d]]
        });
        let plate = Plate::new(&positions, &triangles.collect::<Vec<_>>(), Plate::SMOOTHING).unwrap();
        let camera = Camera { distance: 2.5, pitch_rad: 0.9, ..Camera::default() };
        plate.strokes(&BARE, &camera, CELL).len()
    };
    // The border of the sheet, and beside it the slit.
    assert_eq!([strokes(30..30), strokes(30..32), strokes(15..45)], [1, 1, 2]);
}

#[test]
fn furrows_and_edges_are_drawn_where_they_are_seen() {
    // A washboard: valleys at multiples of ½, ridges between, along z.
    let n = 120_u32;
    let positions: Vec<Vec3> = (0..=n)
        .flat_map(|i| (0..=n).map(move |j| [f64::from(i), f64::from(j)].map(|x| 3.0 * x / f64::from(n))))
        .map(|[x, z]| [x, -0.14 * (2.0 * std::f64::consts::TAU * x).cos(), z])
        .collect();
    let at = |i: u32, j: u32| i * (n + 1) + j;
    let cells = (0..n).flat_map(|i| (0..n).map(move |j| [i, j]));
    let triangles: Vec<[u32; 3]> = cells
        .flat_map(|[i, j]| {
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    let plate = Plate::new(&positions, &triangles, Plate::SMOOTHING).unwrap();
    let mut camera = Camera { pitch_rad: std::f32::consts::FRAC_PI_2, ..Camera::default() };
    camera.fit(positions.iter().map(|p| p.map(|x| x as f32)), CELL.aspect(), 0.9);
    let strokes = plate.strokes(&Ink { detail: 1.0, ..BARE }, &camera, CELL);
    let lines = |mark: Mark| strokes.iter().filter(move |s| s.mark == mark && length(s) > 300.0);
    assert_eq!(lines(Mark::Valley).count(), 5);
    assert_eq!(lines(Mark::Ridge).count(), 6);
    for (mark, phase) in [(Mark::Valley, 0.0), (Mark::Ridge, 0.25)] {
        for point in lines(mark).flat_map(|stroke| &stroke.points) {
            let ray = camera.ray(point.at[0] as f32, point.at[1] as f32, CELL);
            // On the plane at the height of the lines.
            let height = if mark == Mark::Valley { -0.14 } else { 0.14 };
            let down = (height - f64::from(ray.origin[1])) / f64::from(ray.direction[1]);
            let x = f64::from(ray.origin[0]) + down * f64::from(ray.direction[0]);
            let off = ((x - phase) * 2.0).round() * 0.5 + phase - x;
            assert!(off.abs() < 0.02, "{mark:?} at {x}");
        }
    }
}

#[test]
fn lines_are_the_same_whichever_way_triangles_face() {
    let (positions, triangles) = torus();
    let camera = Camera { distance: 6.0, pitch_rad: 0.35, ..Camera::default() };
    let strokes = |triangles: &[[u32; 3]]| {
        let plate = Plate::new(&positions, triangles, Plate::SMOOTHING).unwrap();
        plate.outlines(&Ink { detail: 2.0, ..BARE }, &camera, CELL)
    };
    let expected = strokes(&triangles);
    // All of them, and every third.
    for step in [1, 3] {
        let mut turned = triangles.clone();
        turned.iter_mut().step_by(step).for_each(|t| t.swap(1, 2));
        assert_eq!(strokes(&turned), expected, "{step}");
    }
}

#[test]
fn a_relief_is_drawn_alike_whichever_way_it_faces() {
    let n = 24_u32;
    let at = |i: u32| f64::from(i) / f64::from(n) - 0.5;
    let height = |x: f64, y: f64| 0.25 * (-12.0 * (x * x + y * y)).exp();
    let grid = (0..=n).flat_map(|j| (0..=n).map(move |i| (at(i), at(j))));
    let positions: Vec<[f64; 3]> = grid.map(|(x, y)| [x, y, height(x, y)]).collect();
    let cells = (0..n).flat_map(|j| (0..n).map(move |i| j * (n + 1) + i));
    let triangles: Vec<[u32; 3]> =
        cells.flat_map(|v| [[v, v + 1, v + n + 2], [v, v + n + 2, v + n + 1]]).collect();
    let camera = Camera { distance: 2.0, pitch_rad: 0.9, ..Camera::default() };
    let strokes = |triangles: &[[u32; 3]]| {
        let plate = Plate::new(&positions, triangles, Plate::SMOOTHING).unwrap();
        plate.outlines(&Ink { detail: 2.0, ..BARE }, &camera, CELL)
    };
    let expected = strokes(&triangles);
    let turned: Vec<[u32; 3]> = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    assert!(!expected.is_empty() && strokes(&turned) == expected);
}

#[test]
fn hatching_lies_in_the_shade_and_keeps_its_distance() {
    let camera = Camera { distance: 5.0, ..Camera::default() };
    let strokes = ring().strokes(&Ink { hatching: 0.4, ..BARE }, &camera, CELL);
    let ball = ball().strokes(&Ink { hatching: 0.4, ..BARE }, &camera, CELL);
    assert!(strokes.iter().any(|stroke| stroke.mark == Mark::Hatching));
    let shade: Vec<[f64; 2]> = ball
        .iter()
        .filter(|s| s.mark == Mark::Hatching)
        .flat_map(|s| s.points.iter().map(|p| p.at))
        .collect();
    assert!(shade.len() > 20);
    for [x, y] in shade {
        let ray = camera.ray(x as f32, y as f32, CELL);
        let (from, way) = (ray.origin.map(f64::from), ray.direction.map(f64::from));
        let (b, c) = (dot(from, way), dot(from, from) - 1.0);
        let normal = add(from, scaled(way, -b - (b * b - c).max(0.0).sqrt()));
        // The lamp stands to the upper left, before the shape.
        assert!(dot(normal, unit([-0.5, 0.6, 0.6])) < 0.4, "{normal:?}");
    }
    // Less ink where more of it is light.
    let less = ring().strokes(&Ink { hatching: 0.2, ..BARE }, &camera, CELL);
    let amount = |strokes: &[Stroke]| strokes.iter().map(length).sum::<f64>();
    assert!(amount(&less) < 0.8 * amount(&strokes));
}

#[test]
fn a_drawing_is_the_same_for_any_number_of_threads_and_its_svg_is_well_formed() {
    let drawn = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let camera = Camera { distance: 5.0, pitch_rad: 0.3, ..Camera::default() };
            let ink = Ink::default();
            let mut drawing = Drawing::new(680, 540, &ink).unwrap();
            drawing.strokes = ring().strokes(&ink, &camera, CELL);
            drawing
        })
    };
    let drawing = drawn(1);
    assert_eq!(drawing, drawn(3));
    let svg = drawing.to_svg();
    assert_eq!(svg.matches("<path ").count(), drawing.strokes.len());
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
    let mut open = Vec::new();
    for tag in svg.split('<').skip(1) {
        let (tag, after) = tag.split_once('>').unwrap();
        assert!(after.trim().is_empty() && tag.matches('"').count() % 2 == 0, "{tag}");
        let name = tag.split([' ', '/']).find(|name| !name.is_empty()).unwrap();
        match (tag.strip_prefix('/'), tag.ends_with('/')) {
            (Some(closed), _) => assert_eq!(open.pop(), Some(closed)),
            (None, false) => open.push(name),
            (None, true) => {}
        }
    }
    assert!(open.is_empty());
}

#[test]
fn a_stroke_covers_its_length_times_its_width() {
    let ink = Ink { paper: [255; 3], color: [0; 3], ..Ink::default() };
    for width in [0.4, 1.0, 3.3] {
        let mut drawing = Drawing::new(200, 100, &ink).unwrap();
        let point = |x: f64, y: f64| StrokePoint { at: [x, y], width };
        drawing
            .strokes
            .push(Stroke { mark: Mark::Contour, points: vec![point(20.0, 20.3), point(180.0, 71.1)] });
        let picture = drawing.to_picture();
        let cover: f64 = picture.rgba.chunks(4).map(|p| 1.0 - f64::from(p[0]) / 255.0).sum();
        let length = 160.0_f64.hypot(50.8);
        // At each end a little more than half a disc.
        assert!((cover - length * width).abs() < 0.02 * length * width + width * width + 1.0, "{cover}");
    }
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let refused = |positions: &[Vec3], triangle: [u32; 3]| {
        matches!(Plate::new(positions, &[triangle], 0.01), Err(ViewError::Shape(_)))
    };
    assert!(!refused(&corners, [0, 1, 2]));
    assert!(refused(&corners, [0, 1, 3]) && refused(&corners, [0, 1, 1]) && refused(&[], [0, 1, 2]));
    assert!(refused(&[[0.0; 3], [f64::NAN, 0.0, 0.0], [0.0, 1.0, 0.0]], [0, 1, 2]));
    let plate = Plate::new(&corners, &[[0, 1, 2]], 0.01).unwrap();
    assert!(matches!(plate.weighted(vec![1.0; 2]), Err(ViewError::Shape(_))));
    assert!(matches!(Drawing::new(0, 10, &Ink::default()), Err(ViewError::Size { .. })));
}
