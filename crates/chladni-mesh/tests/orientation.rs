//! How shapes stand: all real heads and animals, as their files hold them and turned into other axes.
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "a panic is how a test fails")]

use chladni_mesh::{Axis, Estimate, Known, Orientation, TriMesh, load_mesh, samples};
use chladni_task::Task;
use chladni_testdata::shared;

/// Up and front of each, as a person sees them in pictures from six sides.
const TRUTHS: [(&str, &str); 12] = [
    ("heads/decimated-max.obj", "up y, front -z"),
    ("heads/demosthenes-low-res.obj", "up y, front z"),
    ("heads/face.obj", "up y, front z"),
    ("heads/generic_neutral_mesh.obj", "up y, front z"),
    ("heads/identity005.obj", "up y, front z"),
    ("heads/igea.ply", "up y, front z"),
    ("heads/reference.obj", "up y, front z"),
    ("heads/target.obj", "up y, front z"),
    ("animals/goathead.obj", "up y, front -x"),
    ("animals/koala.obj", "up y, front z"),
    // The head is turned a little to its left.
    ("animals/lion.off", "up y, front -z"),
    ("animals/spot.obj", "up y, front -z"),
];

/// An estimate that far from the truth still shows the shape upright and from its front.
const RIGHT_DEGREES: f64 = 40.0;

fn estimate(mesh: &TriMesh) -> Estimate {
    Estimate::of(mesh, Known::default(), &Task::new()).unwrap()
}

fn is_right(found: &Estimate, truth: &Orientation) -> bool {
    found.orientation.angle_to(truth).to_degrees() < RIGHT_DEGREES
}

/// `mesh` in other axes (where x, y and z come to lie) and other units.
fn turned(mesh: &TriMesh, axes: [[f64; 3]; 3]) -> TriMesh {
    let turn =
        |p: &[f64; 3]| std::array::from_fn(|i| 25.4 * (0..3).map(|j| axes[j][i] * p[j]).sum::<f64>() + 90.0);
    TriMesh { positions: mesh.positions.iter().map(turn).collect(), ..mesh.clone() }
}

const Z_UP: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]];
/// −x up and y in front: no program's custom.
const LYING: [[f64; 3]; 3] = [[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// Shapes that are right, and all of them, in these axes.
fn measured(axes: Option<[[f64; 3]; 3]>) -> Option<(usize, usize)> {
    let mut right = 0;
    for (name, truth) in TRUTHS {
        let path = shared(&format!("meshes/{name}"))?;
        let (mesh, truth) = (load_mesh(&path).unwrap().mesh, truth.parse::<Orientation>().unwrap());
        let (mesh, truth) = match axes {
            Some(axes) => (turned(&mesh, axes), truth.turned(axes).unwrap()),
            None => (mesh, truth),
        };
        let found = estimate(&mesh);
        let is_right = is_right(&found, &truth);
        right += usize::from(is_right);
        let doubt = if found.in_doubt { ", in doubt" } else { "" };
        let sort = if is_right { "right" } else { "WRONG" };
        eprintln!("{sort} {name}: {} because {}{doubt}", found.orientation, found.evidence.words());
    }
    Some((right, TRUTHS.len()))
}

#[test]
fn nine_of_ten_heads_and_animals_stand_upright_and_face_the_viewer() {
    let Some((right, all)) = measured(None) else { return };
    assert!(10 * right >= 9 * all, "{right} of {all}");
}

#[test]
fn so_they_do_where_z_is_up() {
    let Some((right, all)) = measured(Some(Z_UP)) else { return };
    assert!(10 * right >= 9 * all, "{right} of {all}");
}

#[test]
fn and_most_of_them_whatever_way_they_lie() {
    let Some((right, all)) = measured(Some(LYING)) else { return };
    assert!(4 * right >= 3 * all, "{right} of {all}");
}

#[test]
fn the_samples_stand_as_they_were_made_however_their_file_is_turned() {
    for name in ["head", "template"] {
        let mesh = samples::sample(name).unwrap();
        assert_eq!(estimate(&mesh).orientation, Orientation::Y_UP, "{name}");
        for axes in [Z_UP, LYING] {
            let (found, truth) = (estimate(&turned(&mesh, axes)), Orientation::Y_UP.turned(axes).unwrap());
            // Along the file's axes to the last bit: a picture of it is level.
            assert!(found.orientation.angle_to(&truth) < 1e-9, "{name}: {}", found.orientation);
            assert!(!found.in_doubt);
        }
    }
}

#[test]
fn four_legs_carry_a_head_in_front_of_them() {
    // The cat's tail reaches farther back than its muzzle to the front, and weighs less.
    let cat = samples::sample("cat").unwrap();
    for axes in [None, Some(Z_UP)] {
        let (mesh, truth) = match axes {
            Some(axes) => (turned(&cat, axes), Orientation::Y_UP.turned(axes).unwrap()),
            None => (cat.clone(), Orientation::Y_UP),
        };
        let found = estimate(&mesh);
        assert!(is_right(&found, &truth), "{}", found.orientation);
    }
}

#[test]
fn what_is_known_is_kept_and_the_rest_is_found() {
    let head = samples::sample("head").unwrap();
    let of = |up: Option<&str>, front: Option<&str>| {
        let direction = |axis: Option<&str>| axis.map(|a| a.parse::<Axis>().unwrap().direction());
        Estimate::of(
            &head,
            Known { up: direction(up), front: direction(front), ..Known::default() },
            &Task::new(),
        )
        .unwrap()
    };
    assert_eq!(of(Some("y"), None).orientation, Orientation::Y_UP);
    assert_eq!(of(None, Some("z")).orientation, Orientation::Y_UP);
    for (up, front) in [("z", None), ("-x", None), ("-y", None), ("x", Some("y"))] {
        let found = of(Some(up), front).orientation;
        assert_eq!(Axis::of(found.up()).unwrap().to_string(), up);
        assert!(front.is_none_or(|front| Axis::of(found.front()).unwrap().to_string() == front));
    }
}

#[test]
fn what_tells_nothing_is_in_doubt_and_no_panic() {
    let ball = samples::icosphere(2);
    assert!(estimate(&ball).in_doubt);
    let nothing = TriMesh { positions: vec![[1.0; 3]; 3], triangles: vec![[0, 1, 2]], ..TriMesh::default() };
    let found = estimate(&nothing);
    assert!(found.in_doubt && found.orientation == Orientation::Y_UP);
    let flat = samples::grid_square(3);
    assert!(estimate(&flat).orientation.up().iter().all(|c| c.is_finite()));
    let far = TriMesh { positions: vec![[1e75; 3], [-1e75, 0.0, 1e75], [0.0, 1e75, -1e75]], ..nothing };
    assert!(estimate(&far).orientation.front().iter().all(|c| c.is_finite()));
    let cancelled = Task::new();
    cancelled.cancel();
    assert!(Estimate::of(&ball, Known::default(), &cancelled).is_err());
}

#[test]
fn the_rules_of_a_format_decide_between_sides_that_differ_little() {
    let ball = samples::icosphere(2);
    let usual = |usual_front: [f64; 3]| {
        let known = Known { up: Some([0.0, 1.0, 0.0]), usual_front: Some(usual_front), front: None };
        Estimate::of(&ball, known, &Task::new()).unwrap().orientation.to_string()
    };
    assert_eq!(usual([0.0, 0.0, 1.0]), "up y, front z");
    assert_eq!(usual([-1.0, 0.0, 0.0]), "up y, front -x");
    // A face is clearer than rules.
    let head = samples::sample("head").unwrap();
    let known = Known { usual_front: Some([0.0, 0.0, -1.0]), ..Known::default() };
    assert_eq!(Estimate::of(&head, known, &Task::new()).unwrap().orientation, Orientation::Y_UP);
}
