//! Projects as documents: undo, files, formats, recovery.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod bodies;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use chladni_caricature::*;
use chladni_harmonics::Laplacian;
use proptest::prelude::*;

fn action() -> impl Strategy<Value = Action> {
    let id = || (1..9_u64).prop_map(LayerId);
    let vertices = prop::collection::vec(0..642_u32, 0..60);
    let dab = (vertices, 0_f32..=1.0, any::<bool>(), any::<bool>()).prop_map(|(vertices, x, erase, soft)| {
        let weights = if soft { vertices.iter().map(|v| *v as f32 / 642.0).collect() } else { Vec::new() };
        PaintEdit::Dab(Dab { weights, ..Dab::even(vertices, x, erase) })
    });
    let edit = prop_oneof![dab, Just(PaintEdit::Grow), Just(PaintEdit::Invert), Just(PaintEdit::Clear)];
    let property = prop_oneof![
        (-3.0..3.0).prop_map(Property::Mu),
        (0.0..2.0).prop_map(Property::Strength), // above 1 is refused
        any::<bool>().prop_map(Property::Solo),
        "[a-zé \"\n]{0,8}".prop_map(Property::Name),
        (0.0..4.0).prop_map(|g| Property::Curve(ScaleCurve::flat(g))),
        Just(Property::Model(Model::Normal)),
        Just(Property::Template(Template::LowPass(12))),
        id().prop_map(|below| Property::Template(Template::Layer(below))),
    ];
    prop_oneof![
        (0..4_usize)
            .prop_map(|index| Action::Add { index, layer: Box::new(Layer::new("new", Template::Sphere)) }),
        id().prop_map(Action::Remove),
        id().prop_map(Action::Duplicate),
        (id(), 0..5_usize).prop_map(|(layer, index)| Action::Move { layer, index }),
        (id(), property).prop_map(|(layer, to)| Action::Set { layer, to }),
        (id(), edit).prop_map(|(layer, edit)| Action::Paint { layer, edit }),
        (0..300_usize).prop_map(Action::SetHarmonics),
        Just(Action::SetLaplacian(Laplacian::Cotangent)),
        any::<bool>().prop_map(Action::KeepTriangles),
    ]
}

fn empty() -> Project {
    Project::new(ShapeSource::File(std::path::absolute("shape.obj").unwrap()), 64)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(24) })]
    #[test]
    fn undo_takes_every_action_back_and_a_saved_project_is_read_back(
        actions in prop::collection::vec((action(), any::<bool>()), 1..30)
    ) {
        let mesh = bodies::lump();
        let body = chladni_harmonics::Body {
            frame: chladni_mesh::Frame::of(&mesh),
            positions: mesh.positions.clone(),
            triangles: mesh.triangles.clone(),
            operator_vertex: (0..mesh.positions.len() as u32).map(Some).collect(),
            basis: Arc::new(chladni_harmonics::Basis {
                eigenvalues: vec![], vectors: vec![].into(), mass: vec![1.0; mesh.positions.len()],
                certificate: chladni_harmonics::Certificate {
                    laplacian: Laplacian::Delaunay,
                    inertia_counts_match: Some(true), max_relative_residual: 0.0, max_orthogonality_error: 0.0 },
            }),
        };
        let surface = Surface::new(&body);
        let mut history = History::new(empty());
        let mut states = vec![empty()];
        for (action, live) in &actions {
            let before = history.project().clone();
            let json = serde_json::to_string(action).unwrap();
            prop_assert_eq!(&serde_json::from_str::<Action>(&json).unwrap(), action);
            let steps = history.steps();
            let done = if *live { history.apply_live(action, Some(&surface)) } else { history.apply(action, Some(&surface)) };
            match done {
                Err(_) => prop_assert_eq!(&before, history.project()),
                Ok(()) if history.steps() > steps => states.push(history.project().clone()),
                Ok(()) => *states.last_mut().unwrap() = history.project().clone(),
            }
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.chladni");
        history.project().save(&path).unwrap();
        let loaded = Project::load(&path).unwrap();
        prop_assert_eq!(&loaded.shape, &history.project().shape);
        let layers = |p: &Project| {
            let numbered = |layer: &Layer| match layer.template {
                Template::Layer(below) => Template::Layer(LayerId(p.number(below).unwrap() as u64)),
                ref other => other.clone(),
            };
            p.layers().iter().map(|(_, l)| Layer { template: numbered(l), ..Layer::clone(l) }).collect::<Vec<_>>()
        };
        prop_assert_eq!(layers(&loaded), layers(history.project()));
        for state in states.iter().rev().skip(1) {
            history.undo().unwrap();
            prop_assert_eq!(history.project(), state);
        }
        prop_assert!(history.undo().is_none() && !history.is_modified());
        for state in states.iter().skip(1) {
            history.redo().unwrap();
            prop_assert_eq!(history.project(), state);
        }
        prop_assert!(history.redo().is_none());
    }
}

#[test]
fn keys_that_a_file_lacks_have_their_defaults() {
    let layer = |more: &str| {
        let head = "format_version = 4\n[shape]\nsource = \"sample:head\"\n";
        let text = format!("{head}[[layer]]\nname = \"round\"\ntemplate = \"sphere\"\n{more}");
        let (project, _) = Project::from_text(&text, Path::new("/p.chladni")).unwrap();
        Layer::clone(&project.layers()[0].1)
    };
    assert_eq!(layer(""), Layer::new("round", Template::Sphere));
    let points = layer("[layer.scale]\npoints = [[0.9, 1.0], [0.4, 0.25]]\n").curve;
    assert_eq!(points, ScaleCurve { points: vec![[0.9, 1.0], [0.4, 0.25]], residual: 0.25 });
    let residual = layer("[layer.scale]\nresidual = 0.5\n").curve;
    assert_eq!(residual, ScaleCurve { residual: 0.5, ..ScaleCurve::default() });
}

/// A reference names a layer, wherever that is moved to, and nothing may make it point at the layer itself, above it, or
/// at nothing.
#[test]
fn a_layer_keeps_the_layer_below_whose_result_is_its_template() {
    let mut history = History::new(empty());
    let template = [Template::Sphere, Template::Ellipsoid, Template::Layer(LayerId(1))];
    for (name, template) in ["round", "long", "since"].into_iter().zip(template) {
        let layer = Box::new(Layer::new(name, template));
        history.apply(&Action::Add { index: 9, layer }, None).unwrap();
    }
    let [round, long, since] = [1, 2, 3].map(LayerId);
    let of = |layer, below| Action::Set { layer, to: Property::Template(Template::Layer(below)) };
    let before = history.project().clone();
    for refused in [
        Action::Remove(round),
        Action::Move { layer: since, index: 0 },
        Action::Move { layer: round, index: 2 },
        Action::Add { index: 0, layer: Box::new(Layer::new("new", Template::Layer(round))) },
        of(since, since),
        of(long, since),
        of(since, LayerId(7)),
    ] {
        let why = history.apply(&refused, None).unwrap_err().to_string();
        assert!(why.contains("is compared with the result of layer"), "{why}");
        assert_eq!(*history.project(), before);
    }
    let why = history.apply(&Action::Remove(round), None).unwrap_err().to_string();
    assert_eq!(why, "layer since is compared with the result of layer round, which has to be below it");
    // Moved up, it is the second layer of the file, and still the same one.
    history.apply(&Action::Move { layer: round, index: 1 }, None).unwrap();
    assert_eq!(history.project().layer(since).unwrap().template, Template::Layer(round));
    let text = history.project().to_text(Path::new("/p.chladni"), None).unwrap();
    assert!(text.contains("\"self:layer=2\""), "{text}");
    let (read, _) = Project::from_text(&text, Path::new("/p.chladni")).unwrap();
    let [_, (second, below), (_, top)] = read.layers() else { panic!("{read:?}") };
    assert_eq!((&below.name[..], &top.template), ("round", &Template::Layer(*second)));
    // The layer between may go, and the one below once nothing is compared with it.
    history.apply(&Action::Remove(long), None).unwrap();
    history.apply(&Action::Set { layer: since, to: Property::Template(Template::Original) }, None).unwrap();
    history.apply(&Action::Remove(round), None).unwrap();
    for _ in 0..4 {
        history.undo().unwrap();
    }
    assert_eq!(*history.project(), before);
}

#[test]
fn a_drag_is_one_step() {
    let mut history = History::new(empty());
    let add = Action::Add { index: 0, layer: Box::new(Layer::new("a", Template::Ellipsoid)) };
    history.apply(&add, None).unwrap();
    let id = history.project().layers()[0].0;
    let mu = |mu| Action::Set { layer: id, to: Property::Mu(mu) };
    let now = |history: &History| history.project().layers()[0].1.mu;
    for i in 0..50 {
        history.apply_live(&mu(-f64::from(i) / 10.0), None).unwrap();
    }
    history.finish();
    history.apply_live(&mu(2.0), None).unwrap();
    assert_eq!((history.steps(), history.undo_label()), (3, Some("μ")));
    history.undo();
    assert_eq!(now(&history), -4.9);
    history.undo();
    assert_eq!(now(&history), -0.5);
    history.redo();
    assert_eq!(now(&history), -4.9);
    assert!(history.apply(&mu(f64::NAN), None).is_err());
    assert_eq!(history.redo_label(), Some("μ"), "a refused action leaves the future alone");
}

fn fixture(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures").join(name);
    // Built on another system, it lacks the drive.
    std::path::absolute(path).unwrap()
}

#[test]
fn older_formats_load_and_newer_ones_say_so() {
    let project = Project::load(&fixture("format-1.chladni")).unwrap();
    assert_eq!(project.shape, ShapeSource::File(fixture("heads/igea.ply")));
    assert_eq!((project.harmonics, project.layers().len()), (256, 2));
    let nose = &project.layers()[0].1;
    assert_eq!(nose.template, Template::File(fixture("heads/decimated-max.obj")));
    assert_eq!((nose.model, nose.mu), (Model::Distance, -6.0));
    let sharp = Smoothing { wavelength: usual_wavelength(32.0), roll_off: RollOff::Sharp, clamp: false };
    assert_eq!(nose.region.smoothing, sharp);
    let sphere = Sphere { center: [0.0, 0.1, 0.9], radius: 0.35 };
    assert_eq!(nose.region.painted, Painted::Spheres(vec![sphere]));
    // It ran from 0 over 2 at half the highest frequency to 1 at the highest.
    let finest = usual_wavelength(256.0);
    for (wavelength, gain) in [(f64::INFINITY, 0.0), (2.0 * finest, 2.0), (finest, 1.0), (0.1, 1.0)] {
        assert!((nose.curve.at(wavelength) - gain).abs() < 0.02, "{}", nose.curve.at(wavelength));
    }
    assert_eq!(nose.curve.residual, 0.5);
    assert!(project.taken_over().unwrap().contains("format 1"));
    assert!(!project.layers()[1].1.enabled);

    let project = Project::load(&fixture("format-2.chladni")).unwrap();
    let [(_, bent), (_, soft)] = project.layers() else { panic!("{project:?}") };
    // Its second highest point stood at 30 % of the frequency of the last of 64 harmonics.
    let peak = usual_wavelength(64.0) / 0.3;
    assert!((bent.curve.at(peak) - 1.8).abs() < 0.01 && bent.curve.at(1.3 * peak) < 1.75);
    assert_eq!(bent.region.smoothing.wavelength, usual_wavelength(96.0));
    assert_eq!(soft.region.smoothing.wavelength, usual_wavelength(20.0));
    assert_eq!(soft.region.smoothing.roll_off, RollOff::Heat);
    // Filling in came later: what was made without it stays without.
    assert_eq!((bent.infill, soft.infill), (0.0, 0.0));
    let message = project.taken_over().unwrap();
    assert!(message.contains("format 2") && message.contains("heat"), "{message}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("now.chladni");
    project.save(&path).unwrap();
    let again = Project::load(&path).unwrap();
    assert_eq!((again.layers()[0].1.clone(), again.taken_over()), (bent.clone(), None));

    let newer = Project::load(&fixture("format-99.chladni"));
    assert!(matches!(newer, Err(CaricatureError::NewerFormat { found: 99, supported: FORMAT_VERSION, .. })));
}

#[test]
fn a_file_made_by_hand_may_leave_out_what_is_usual() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.chladni");
    let text = "format_version = 3\nshape.source = 'h.obj'\n\n[[layer]]\nname = 'n'\ntemplate = 'ellipsoid'\nmu = -1\n\
                match.seed = 7\n";
    std::fs::write(&path, text).unwrap();
    let project = Project::load(&path).unwrap();
    let mut expected = Layer { mu: -1.0, ..Layer::new("n", Template::Ellipsoid) };
    expected.matching.seed = 7;
    assert_eq!(*project.layers()[0].1, expected);
    assert_eq!(project.harmonics, DEFAULT_HARMONICS);
    // Of format 3, which could not keep triangles.
    assert_eq!((project.keep_triangles, project.taken_over()), (false, None));
}

#[test]
fn only_an_unusual_resolution_needs_the_newest_format() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.chladni");
    let mut project = Project::new(ShapeSource::File(folder.path().join("h.obj")), 8);
    for (resolution, version) in [
        (Resolution::Usual, 4),
        (Resolution::Whole, 5),
        (Resolution::Proxy(ProxyKey { vertices: 1000, fingerprint: None }), 5),
        (Resolution::Proxy(ProxyKey { vertices: 1000, fingerprint: Some("2f".into()) }), 5),
    ] {
        project.resolution = resolution;
        project.save(&path).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains(&format!("format_version = {version}")), "{text}");
        assert_eq!(Project::load(&path).unwrap(), project);
    }
    let few = "format_version = 5\nshape.source = 'h.obj'\nshape.proxy.vertices = 3\n";
    std::fs::write(&path, few).unwrap();
    assert!(Project::load(&path).unwrap_err().to_string().contains("100 vertices or more"));
}

#[test]
fn what_is_wrong_with_a_file_is_told_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.chladni");
    let head = "format_version = 3\nshape.source = 'h.obj'\n";
    let layer = "[[layer]]\nname = 'n'\ntemplate = 'sphere'\nmu = 1\n";
    let cases = [
        (String::new(), "format_version"),
        ("format_version = 'two'".into(), "format_version"),
        ("format_version = 0".into(), "never existed"),
        ("format_version = 3".into(), "shape"),
        (format!("{head}[[layer]]\nname = "), "line 4"),
        (format!("{head}[[layer]]\nname = 'n'\ntemplate = 'sphere'\nmu = 1\nmuu = 2\n"), "line 7, column 1"),
        (format!("{head}{layer}muu = 2\n"), "unknown field `muu`; a newer Chladni may have written it"),
        (format!("{head}[[layer]]\nname = 'n'\ntemplate = 'self:loud'\nmu = 1\n"), "layer 1 (n)"),
        (format!("{head}[[layer]]\nname = 'n'\ntemplate = 'self:layer=0'\nmu = 1\n"), "from the lowest, 1"),
        (
            format!("{head}[[layer]]\nname = 'n'\ntemplate = 'self:layer=1'\nmu = 1\n"),
            "layer 1 (n): layer n is",
        ),
        (format!("{head}{layer}strength = 7\n"), "strength"),
        (format!("{head}{layer}mu = nan\n").replacen("mu = 1\n", "", 1), "μ"),
        (format!("{head}{layer}[layer.region]\npainted = '99999999999*1'\n"), "more painted values"),
        (format!("{head}{layer}[layer.region]\npainted = '1'\nspheres = ['1,1,1,1']\n"), "exclude"),
        (format!("{head}{layer}[layer.match]\nmethud = 'icp'\n"), "methud"),
        (
            format!("{head}{layer}[layer.scale]\npoints = [[0.1, 1.0], [0.5, 1.0]]\nresidual = 1.0\n"),
            "below the point",
        ),
        ("\u{0}\u{1}".into(), "p.chladni"),
    ];
    for (text, expected) in cases {
        std::fs::write(&path, &text).unwrap();
        let message = Project::load(&path).unwrap_err().to_string();
        assert!(message.contains(expected) && !message.contains('\n'), "{text:?}: {message}");
    }
}

#[test]
fn a_few_bytes_do_not_ask_for_all_memory() {
    let layer = |i: usize, painted: &str| {
        format!(
            "[[layer]]\nname = \"{i}\"\ntemplate = \"sphere\"\nmu = 1.0\nregion.painted = \"{painted}\"\n"
        )
    };
    let head = "format_version = 3\nshape.source = \"head.obj\"\n";
    let text = |count: usize, painted: &str| -> String {
        std::iter::once(head.to_owned()).chain((0..count).map(|i| layer(i, painted))).collect()
    };
    let path = Path::new("/p.chladni");
    assert_eq!(Project::from_text(&text(3, "5000*1"), path).unwrap().0.layers().len(), 3);
    // A gigabyte, if it were read.
    let refused = Project::from_text(&text(4, "60000000*0"), path).unwrap_err().to_string();
    assert!(refused.contains("layer 2 (1)") && refused.contains("more painted values"), "{refused}");
}

#[test]
fn a_project_does_not_become_one_that_would_not_open_again() {
    let (mut project, path) = (empty(), Path::new("/p.chladni"));
    let mut layer = Layer::new("painted", Template::Sphere);
    // The layers share the values.
    layer.region.painted = Painted::Vertices(vec![1.0; 1 << 22].into());
    for _ in 0..16 {
        project.push(layer.clone()).unwrap();
    }
    assert!(project.to_text(path, None).is_ok());
    // What would be too much is refused when it is done.
    let (first, before) = (project.layers()[0].0, project.clone());
    assert!(project.push(layer).is_err());
    let refused = project.apply(&Action::Duplicate(first), None).unwrap_err().to_string();
    assert!(refused.contains("71303168") && refused.contains("set a region to Everywhere"), "{refused}");
    assert_eq!(project, before);
    project.apply(&Action::Set { layer: first, to: Property::Mu(2.0) }, None).unwrap();
}

#[test]
fn a_dead_session_is_found_and_a_living_one_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let state = folder.path().join("state");
    assert!(Recovery::find(&state).0.is_empty());
    let session = Recovery::start(&state, 7).unwrap();
    let original = std::path::absolute("/somewhere/mine.chladni").unwrap();
    session.keep(&empty(), Some(&original)).unwrap();
    assert!(Recovery::find(&state).0.is_empty(), "it lives");
    drop(session);
    let second = Recovery::start(&state, 7).unwrap();
    second.keep(&empty(), None).unwrap();
    let (found, unreadable) = Recovery::find(&state);
    assert!(unreadable.is_empty());
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].project, empty());
    assert_eq!(found[0].original.as_ref(), Some(&original));
    found[0].discard();
    second.finish();
    assert_eq!(std::fs::read_dir(&state).unwrap().count(), 0);
}

#[test]
fn copies_of_any_date_are_found_the_newest_first() {
    let folder = tempfile::tempdir().unwrap();
    let now = SystemTime::now();
    let dates = [now, now + Duration::from_secs(1 << 25), SystemTime::UNIX_EPOCH];
    for (id, written) in (1..).zip(dates) {
        let session = Recovery::start(folder.path(), id).unwrap();
        session.keep(&empty(), Some(&folder.path().join(format!("{id}.chladni")))).unwrap();
        drop(session);
        let copies = Recovery::find(folder.path()).0.into_iter();
        let own = format!("{id}.chladni");
        let copy = copies.filter(|found| found.original.as_ref().is_some_and(|path| path.ends_with(&own)));
        for Recovered { copy, .. } in copy {
            std::fs::File::options().write(true).open(copy).unwrap().set_modified(written).unwrap();
        }
    }
    let (found, unreadable) = Recovery::find(folder.path());
    assert!(unreadable.is_empty());
    let originals = found.into_iter().map(|found| found.original.unwrap());
    let names: Vec<_> = originals.map(|path| path.file_name().unwrap().to_owned()).collect();
    assert_eq!(names, ["2.chladni", "1.chladni", "3.chladni"]);
}

#[test]
fn what_changes_nothing_is_no_step_and_keeps_what_was_undone() {
    let mut history = History::new(empty());
    let add = Action::Add { index: 0, layer: Box::new(Layer::new("a", Template::Ellipsoid)) };
    history.apply(&add, None).unwrap();
    let id = history.project().layers()[0].0;
    let set = |to| Action::Set { layer: id, to };
    history.apply(&set(Property::Mu(-1.0)), None).unwrap();
    history.undo().unwrap();
    let same = set(Property::Model(history.project().layers()[0].1.model));
    history.apply(&same, None).unwrap();
    history.apply_together(&[same.clone(), same.clone()], None).unwrap();
    history.apply_live(&same, None).unwrap();
    assert_eq!((history.steps(), history.redo_label()), (1, Some("μ")));
    // A drag whose first move changes nothing is one step all the same.
    let before = history.project().clone();
    let mu = before.layers()[0].1.mu;
    for mu in [mu, -2.0, -3.0] {
        history.apply_live(&set(Property::Mu(mu)), None).unwrap();
    }
    history.finish();
    assert_eq!(history.steps(), 2);
    history.undo().unwrap();
    assert_eq!(*history.project(), before);
}

#[test]
fn a_step_is_taken_only_where_it_leads_to_a_project_that_is_wanted() {
    let mut history = History::new(empty());
    for harmonics in [100, 200] {
        history.apply(&Action::SetHarmonics(harmonics), None).unwrap();
    }
    let mut steps_to = |wanted| {
        let steps = history.step_to(|project| project.harmonics == wanted);
        (steps, history.project().harmonics, history.steps())
    };
    assert_eq!(steps_to(64), (false, 200, 2), "two steps back");
    assert_eq!(steps_to(100), (true, 100, 1));
    assert_eq!(steps_to(200), (true, 200, 2));
}

#[test]
fn landmarks_go_with_the_template_that_they_were_set_on() {
    let mut layer = Layer::new("a", Template::File("one/other.obj".into()));
    layer.matching.landmarks = vec![chladni_match::Landmark { shape: 5, template: 9 }; 3];
    let mut history = History::new(empty());
    history.apply(&Action::Add { index: 0, layer: Box::new(layer) }, None).unwrap();
    let id = history.project().layers()[0].0;
    let left = |history: &History| history.project().layers()[0].1.matching.landmarks.len();
    let put = |history: &mut History, template: &str| {
        let to = Property::Template(template.parse().unwrap());
        history.apply(&Action::Set { layer: id, to }, None).unwrap();
        left(history)
    };
    // A file that was moved.
    assert_eq!(put(&mut history, "two/other.obj"), 3);
    assert_eq!(put(&mut history, "two/third.obj"), 0);
    history.undo().unwrap();
    assert_eq!(left(&history), 3);
    // What is no mesh does not carry them on to another one.
    assert_eq!((put(&mut history, "ellipsoid"), put(&mut history, "two/third.obj")), (0, 0));
    history.undo().unwrap();
    history.undo().unwrap();
    assert_eq!(left(&history), 3);
}

#[test]
fn landmarks_of_a_head_go_where_its_sliders_make_another_mesh_of_it() {
    let mut layer = Layer::new("a", Template::Sample("portrait".into()));
    layer.matching.landmarks = vec![chladni_match::Landmark { shape: 5, template: 9 }; 3];
    let mut history = History::new(empty());
    history.apply(&Action::Add { index: 0, layer: Box::new(layer) }, None).unwrap();
    let id = history.project().layers()[0].0;
    let landmarks = |history: &History| history.project().layers()[0].1.matching.landmarks.len();
    let to = Property::Template(Template::Sample("portrait?nose=0.50".into()));
    history.apply(&Action::Set { layer: id, to }, None).unwrap();
    assert_eq!(landmarks(&history), 0);
    history.undo().unwrap();
    assert_eq!(landmarks(&history), 3);
}
