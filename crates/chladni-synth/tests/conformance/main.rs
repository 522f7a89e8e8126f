//! One suite that every backend and every path passes, against a reference in f64.

mod cases;
mod device;
mod reference;

use chladni_synth::{
    Coefficients, CpuPath, CpuSynthesizer, FrameSettings, GpuSynthesizer, Item, Residual, SynthError,
    SynthModel, Synthesizer, Term,
};
use proptest::prelude::*;
use reference::{Shape, norm, sub};

/// A backend whose results can be read.
trait Readable: Synthesizer {
    fn name(&self) -> String;
    /// Positions and normals of all items.
    fn read(&mut self) -> (Vec<[f32; 3]>, Vec<[f32; 3]>);
}

impl Readable for CpuSynthesizer {
    fn name(&self) -> String {
        format!("CPU {}", self.path())
    }

    fn read(&mut self) -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
        (self.all_positions().to_vec(), self.all_normals().to_vec())
    }
}

impl Readable for GpuSynthesizer {
    fn name(&self) -> String {
        format!("GPU {}", self.context().device_name())
    }

    fn read(&mut self) -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
        device::read(self.frame())
    }
}

/// Every backend that this machine has.
fn backends(model: &SynthModel) -> Vec<Box<dyn Readable>> {
    let cpu = CpuPath::available().iter().map(|&path| {
        let backend = CpuSynthesizer::with_path(model.clone(), path);
        Box::new(backend.expect("an available path")) as Box<dyn Readable>
    });
    let gpu = device::context().map(|context| {
        let backend = GpuSynthesizer::new(context, model.clone());
        Box::new(backend.expect("the model fits the device")) as Box<dyn Readable>
    });
    cpu.chain(gpu).collect()
}

fn model(shape: &Shape) -> SynthModel {
    SynthModel::from_parts(&shape.positions, &shape.triangles, &shape.basis).unwrap()
}

/// Synthesizes `items` and compares every coordinate of every item with the reference.
fn check(backend: &mut dyn Readable, shape: &Shape, items: &[Item], normal_blending: f32) {
    let name = backend.name();
    backend.synthesize(items, &FrameSettings { normal_blending }).unwrap();
    let (positions, normals) = backend.read();
    let n = shape.vertices();
    assert_eq!((positions.len(), normals.len()), (n * items.len(), n * items.len()), "{name}");
    for (s, item) in items.iter().enumerate() {
        let found = &positions[s * n..(s + 1) * n];
        let (expected, bounds) = reference::positions(shape, item);
        for v in 0..n {
            let error = sub(found[v].map(f64::from), expected[v]);
            let within = (0..3).all(|i| error[i].abs() <= bounds[v][i]);
            assert!(within, "{name}: item {s}, vertex {v}: {error:?} against {:?}", bounds[v]);
        }
        let (expected, bounds) = reference::normals(shape, found, f64::from(normal_blending));
        for v in 0..n {
            let found = normals[s * n + v].map(f64::from);
            let error = norm(sub(found, expected[v]));
            assert!(error <= bounds[v], "{name}: item {s}, normal {v}: {found:?} for {:?}", expected[v]);
            assert!((norm(found) - 1.0).abs() < 1e-5, "{name}: normals have unit length");
        }
    }
}

#[test]
fn one_to_twenty_four_items_of_every_form() {
    let shape = cases::shape(1, 9, 7, 40);
    for mut backend in backends(&model(&shape)) {
        for count in (1..=24).chain([1, 12]) {
            check(&mut *backend, &shape, &cases::items(count, &shape, count as usize), 0.3);
        }
    }
}

#[test]
fn two_to_many_harmonics() {
    for (harmonics, rings) in [(2, 3), (3, 11), (64, 40), (257, 6), (2500, 5)] {
        let shape = cases::shape(harmonics as u64, rings, 5, harmonics);
        for mut backend in backends(&model(&shape)) {
            check(&mut *backend, &shape, &cases::items(7, &shape, 4), 0.0);
        }
    }
}

#[test]
fn more_vertices_than_a_task() {
    let shape = cases::shape(5, 120, 90, 20);
    for mut backend in backends(&model(&shape)) {
        check(&mut *backend, &shape, &cases::items(9, &shape, 3), 0.5);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn any_frame(seed: u64, rings in 3_u32..12, sides in 3_u32..12, harmonics in 1_usize..90, count in 0_usize..8, blending in 0.0_f32..=1.0) {
        let shape = cases::shape(seed, rings, sides, harmonics);
        for mut backend in backends(&model(&shape)) {
            check(&mut *backend, &shape, &cases::items(seed ^ 1, &shape, count), blending);
        }
    }
}

fn vector(coefficients: Vec<[f32; 3]>) -> Term {
    Term { coefficients: Coefficients::Vector(coefficients), residual: None, residual_gain: 0.0, mask: None }
}

fn normal(coefficients: Vec<f32>) -> Term {
    Term { coefficients: Coefficients::Normal(coefficients), residual: None, residual_gain: 0.0, mask: None }
}

fn item(term: Term) -> Item {
    Item { terms: vec![term] }
}

#[test]
fn what_does_nothing_leaves_the_rest_shape_bit_for_bit() {
    let shape = cases::shape(2, 6, 6, 10);
    let n = shape.vertices();
    let full = vec![[0.5; 3]; 10];
    let items = [
        Item::default(),
        item(vector(vec![[0.0; 3]; 10])),
        item(normal(Vec::new())),
        item(Term { mask: Some(vec![0.0; n].into()), ..vector(full) }),
        item(Term { residual: Some(Residual::Normal(vec![3.0; n].into())), ..normal(vec![0.0; 4]) }),
    ];
    let model = model(&shape);
    for mut backend in backends(&model) {
        backend.synthesize(&items, &FrameSettings::default()).unwrap();
        let (positions, _) = backend.read();
        for found in positions.chunks(n) {
            assert_eq!(found, model.rest_positions(), "{}", backend.name());
        }
    }
}

#[test]
fn nonsense_is_refused_and_the_next_frame_is_whole() {
    let shape = cases::shape(3, 6, 6, 10);
    let n = shape.vertices();
    let good = cases::items(4, &shape, 3);
    let settings = FrameSettings::default();
    for mut backend in backends(&model(&shape)) {
        check(&mut *backend, &shape, &good, 0.0);
        let mut refused = |term: Term| {
            let items = [good[0].clone(), Item { terms: vec![normal(vec![1.0]), term] }];
            backend.synthesize(&items, &settings).unwrap_err()
        };
        let weight = |what: &str| SynthError::WeightNotFinite { item: 1, term: 1, what: what.into() };
        let nan = |what| weight(&format!("coefficient of harmonic {what}"));
        assert_eq!(refused(vector(vec![[0.0; 3], [0.0, f32::NAN, 0.0]])), nan(1));
        assert_eq!(refused(normal(vec![f32::INFINITY])), nan(0));
        let gain = Term { residual_gain: f32::NAN, ..normal(vec![1.0]) };
        assert_eq!(refused(gain), weight("residual gain"));
        let long = SynthError::TooManyCoefficients { item: 1, term: 1, found: 11, harmonics: 10 };
        assert_eq!(refused(normal(vec![0.0; 11])), long);
        let length = |what, found| SynthError::SignalLength { item: 1, term: 1, what, found, vertices: n };
        let mask = Term { mask: Some(vec![1.0; n - 1].into()), ..normal(vec![1.0]) };
        assert_eq!(refused(mask), length("mask", n - 1));
        let residual = Some(Residual::Normal(vec![1.0; n + 1].into()));
        assert_eq!(refused(Term { residual, ..normal(vec![1.0]) }), length("residual", n + 1));
        let residual = Some(Residual::Normal(vec![1.0; n].into()));
        assert_eq!(
            refused(Term { residual, ..vector(vec![[1.0; 3]]) }),
            SynthError::MixedForms { item: 1, term: 1 }
        );
        for blending in [-0.1, 1.1, f32::NAN] {
            let refused = backend.synthesize(&good, &FrameSettings { normal_blending: blending });
            assert!(matches!(refused, Err(SynthError::NormalBlending(_))));
        }
        check(&mut *backend, &shape, &good, 0.0);
    }
}

#[test]
fn bad_shapes_are_refused() {
    let Shape { positions, triangles, mut basis } = cases::shape(4, 4, 4, 3);
    let build = |p: &[[f64; 3]], t: &[[u32; 3]], b: &[f64]| SynthModel::from_parts(p, t, b).unwrap_err();
    assert_eq!(
        build(&positions, &triangles, &basis[1..]),
        SynthError::BasisShape { vertices: 16, found: 47 }
    );
    assert_eq!(
        build(&positions, &[[0, 1, 2], [3, 99, 4]], &basis),
        SynthError::TriangleCorner { triangle: 1, vertex: 99, vertices: 16 }
    );
    let mut far = positions.clone();
    far[7][2] = f64::INFINITY;
    assert_eq!(build(&far, &triangles, &basis), SynthError::NotFinite { what: "rest position", index: 7 });
    basis[33] = f64::NAN;
    assert_eq!(build(&positions, &triangles, &basis), SynthError::NotFinite { what: "harmonic", index: 2 });
}

#[test]
fn a_shape_without_vertices_is_an_empty_frame() {
    let model = SynthModel::from_parts(&[], &[], &[]).unwrap();
    for mut backend in backends(&model) {
        backend.synthesize(&[Item::default(), Item::default()], &FrameSettings::default()).unwrap();
        assert!(backend.read().0.is_empty());
    }
}

#[test]
fn another_model_takes_over() {
    let (first, second) = (cases::shape(6, 8, 8, 12), cases::shape(7, 5, 4, 30));
    for mut backend in backends(&model(&first)) {
        check(&mut *backend, &first, &cases::items(1, &first, 5), 0.0);
        backend.replace_model(model(&second)).unwrap();
        assert_eq!(backend.items(), 0);
        check(&mut *backend, &second, &cases::items(2, &second, 7), 0.0);
    }
}
