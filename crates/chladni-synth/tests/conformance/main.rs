//! One test suite for every backend and every path, against a reference in f64.

#![allow(
    clippy::unwrap_used,
    clippy::print_stderr,
    reason = "a panic is how a test fails, a printed line how it tells what it skipped"
)]

mod cases;
mod device;
mod reference;

use chladni_harmonics::{Basis, Body, Certificate};
use chladni_mesh::Frame;
use chladni_synth::{
    AutoSynthesizer, Backend, Coefficients, CpuPath, CpuSynthesizer, DeviceFrameBuffers, DeviceLoss,
    FrameSettings, GpuContext, GpuSynthesizer, Item, Residual, SynthError, SynthModel, Synthesizer, Term,
    Tiles, displacements_f64,
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

/// All backends that this machine has.
fn backends(model: &SynthModel) -> Vec<Box<dyn Readable>> {
    let cpu = CpuPath::available().iter().map(|&path| {
        let backend = CpuSynthesizer::with_path(model.clone(), path);
        Box::new(backend.expect("an available path")) as Box<dyn Readable>
    });
    let gpu = device::context().into_iter().flat_map(|context| {
        [Tiles::Narrow, Tiles::Wide].map(|tiles| {
            let backend = GpuSynthesizer::with_tiles(context, model.clone(), tiles);
            Box::new(backend.expect("the model fits the device")) as Box<dyn Readable>
        })
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
    check_positions(&name, shape, items, &positions);
    for s in 0..items.len() {
        let found = &positions[s * n..(s + 1) * n];
        let (expected, bounds) = reference::normals(shape, found, f64::from(normal_blending));
        for v in 0..n {
            let found = normals[s * n + v].map(f64::from);
            let error = norm(sub(found, expected[v]));
            assert!(error <= bounds[v], "{name}: item {s}, normal {v}: {found:?} for {:?}", expected[v]);
            assert!((norm(found) - 1.0).abs() < 1e-5, "{name}: normals have unit length");
        }
    }
}

/// Compares every coordinate of every item with the reference.
fn check_positions(name: &str, shape: &Shape, items: &[Item], positions: &[[f32; 3]]) {
    let n = shape.vertices();
    for (s, item) in items.iter().enumerate() {
        let found = &positions[s * n..(s + 1) * n];
        let (expected, bounds) = reference::positions(shape, item);
        for v in 0..n {
            let error = sub(found[v].map(f64::from), expected[v]);
            let within = (0..3).all(|i| error[i].abs() <= bounds[v][i]);
            assert!(within, "{name}: item {s}, vertex {v}: {error:?} against {:?}", bounds[v]);
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
fn threads_change_no_bit() {
    let shape = cases::shape(6, 40, 31, 64);
    let items = cases::items(6, &shape, 9);
    for path in CpuPath::available() {
        let on = |threads: usize| -> Vec<u32> {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut backend = CpuSynthesizer::with_path(model(&shape), *path).unwrap();
            let settings = FrameSettings { normal_blending: 0.3 };
            pool.install(|| backend.synthesize(&items, &settings)).unwrap();
            let (positions, normals) = backend.read();
            positions.iter().chain(&normals).flatten().map(|x| x.to_bits()).collect()
        };
        let one = on(1);
        assert!([2, 4].into_iter().all(|threads| on(threads) == one), "{path}");
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

#[test]
fn what_the_device_cannot_hold_is_synthesized_on_the_cpu() {
    // 64 KiB per binding: too little for one panel of 2000 harmonics, enough for one of 100 in many chunks.
    let Some((device, queue)) = device::open(|limits| limits.max_storage_buffer_binding_size = 1 << 16)
    else {
        return;
    };
    let context = GpuContext::new(&device, &queue, &DeviceLoss::watch(&device));
    let settings = FrameSettings::default();
    for (rings, harmonics, fits) in [(20, 100, true), (4, 2000, false)] {
        let shape = cases::shape(11, rings, 16, harmonics);
        let items = cases::items(12, &shape, 2);
        let mut auto = AutoSynthesizer::new(&context, model(&shape), Backend::Gpu);
        assert_eq!(auto.take_fallback().is_none(), fits);
        assert_eq!(auto.take_fallback(), None, "reported once");
        auto.synthesize(&items, &settings).unwrap();
        assert_eq!(auto.cpu().is_none(), fits);
        let found = device::read_buffer(&device, &queue, auto.frame().positions, &auto.frame());
        check_positions(&auto.device_name(), &shape, &items, &found);
        for tiles in [Tiles::Narrow, Tiles::Wide] {
            let Ok(mut gpu) = GpuSynthesizer::with_tiles(&context, model(&shape), tiles) else {
                assert!(!fits);
                continue;
            };
            gpu.synthesize(&items, &settings).unwrap();
            let found = device::read_buffer(&device, &queue, gpu.frame().positions, &gpu.frame());
            check_positions(&format!("{tiles:?}"), &shape, &items, &found);
        }
    }
}

#[test]
fn masks_that_the_device_cannot_hold_are_refused_each_time() {
    let Some((device, queue)) = device::open(|limits| limits.max_storage_buffer_binding_size = 1 << 16)
    else {
        return;
    };
    let context = GpuContext::new(&device, &queue, &DeviceLoss::watch(&device));
    let shape = cases::shape(18, 20, 16, 6);
    let n = shape.vertices();
    let mut gpu = GpuSynthesizer::new(&context, model(&shape)).unwrap();
    let masked = |value: f32| Term { mask: Some(vec![value; n].into()), ..normal(vec![0.1; 6]) };
    // More scalars than the 16,384 that one binding holds, in terms of one column each.
    let with_residual = |i: u8| {
        let residual = Some(Residual::Normal(vec![0.1 * f32::from(i); n].into()));
        Term { residual, residual_gain: 0.1, ..masked(0.5) }
    };
    let count = (8192 / n + 2) as u8;
    let many = [Item { terms: (0..count).map(with_residual).collect() }];
    for _ in 0..2 {
        let refused = gpu.synthesize_positions(&many);
        assert!(matches!(refused, Err(SynthError::DeviceLimit { .. })), "{refused:?}");
    }
    let one = [item(masked(0.25))];
    gpu.synthesize(&one, &FrameSettings::default()).unwrap();
    let found = device::read_buffer(&device, &queue, gpu.frame().positions, &gpu.frame());
    check_positions("after a refusal", &shape, &one, &found);
}

#[test]
fn a_device_that_cannot_compute_shows_what_the_cpu_makes() {
    let Some((device, queue)) = device::open(|limits| limits.max_storage_buffers_per_shader_stage = 4) else {
        return;
    };
    let context = GpuContext::new(&device, &queue, &DeviceLoss::watch(&device));
    let shape = cases::shape(21, 9, 9, 30);
    let items = cases::items(22, &shape, 3);
    let mut auto = AutoSynthesizer::new(&context, model(&shape), Backend::Gpu);
    let fallback = auto.take_fallback().expect("it says so");
    assert!(fallback.to_string().contains("compute shaders"), "{fallback}");
    auto.synthesize(&items, &FrameSettings::default()).unwrap();
    let found = device::read_buffer(&device, &queue, auto.frame().positions, &auto.frame());
    check_positions(&auto.device_name(), &shape, &items, &found);
}

#[test]
fn the_cpu_takes_over_when_the_device_is_lost() {
    let Some((device, queue)) = device::open(|_| ()) else { return };
    let context = GpuContext::new(&device, &queue, &DeviceLoss::watch(&device));
    let shape = cases::shape(13, 9, 9, 30);
    let items = cases::items(14, &shape, 5);
    let mut auto = AutoSynthesizer::new(&context, model(&shape), Backend::Gpu);
    auto.synthesize(&items, &FrameSettings::default()).unwrap();
    assert!(auto.cpu().is_none() && auto.take_fallback().is_none());
    device.destroy();
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    assert!(context.lost().is_some());
    auto.synthesize(&items, &FrameSettings::default()).unwrap();
    let fallback = auto.take_fallback().expect("it says so");
    assert!(fallback.to_string().contains("lost"), "{fallback}");
    check_positions("after the loss", &shape, &items, auto.cpu().unwrap().all_positions());
    assert!(GpuSynthesizer::new(&context, model(&shape)).is_err());
}

#[test]
fn the_cpu_takes_over_when_the_memory_of_the_device_is_full() {
    let Some((device, queue)) = device::open_short_of_memory() else { return };
    let context = GpuContext::new(&device, &queue, &DeviceLoss::watch(&device));
    let shape = cases::shape(23, 40, 40, 30);
    let items = cases::items(24, &shape, 9);
    let mut auto = AutoSynthesizer::new(&context, model(&shape), Backend::Gpu);
    auto.synthesize(&items[..1], &FrameSettings::default()).unwrap();
    assert!(auto.cpu().is_none() && auto.take_fallback().is_none());
    let Some(taken) = device::fill(&device) else { return };
    // Nine times as much as before does not fit any more.
    auto.synthesize(&items, &FrameSettings::default()).unwrap();
    let fallback = auto.take_fallback().expect("it says so");
    assert!(fallback.to_string().to_lowercase().contains("memory"), "{fallback}");
    check_positions("beside full memory", &shape, &items, auto.cpu().unwrap().all_positions());
    drop(taken);
}

#[test]
fn frames_of_the_cpu_reach_the_device() {
    let Some((device, queue)) = device::open(|_| ()) else { return };
    let shape = cases::shape(15, 30, 9, 30);
    let mut cpu = CpuSynthesizer::new(model(&shape));
    let mut buffers = DeviceFrameBuffers::new(&device);
    for count in [2, 7, 1] {
        cpu.synthesize(&cases::items(16, &shape, count), &FrameSettings::default()).unwrap();
        cpu.upload(&queue, &mut buffers).unwrap();
        let frame = buffers.frame();
        assert_eq!((frame.items as usize, frame.vertices as usize), (count, shape.vertices()));
        let read = |buffer| device::read_buffer(&device, &queue, buffer, &frame);
        assert_eq!(read(frame.positions), cpu.all_positions());
        assert_eq!(read(frame.normals), cpu.all_normals());
    }
}

#[test]
fn masks_and_residuals_may_come_and_go() {
    let shape = cases::shape(17, 8, 8, 6);
    let n = shape.vertices();
    for mut backend in backends(&model(&shape)) {
        let keep: std::sync::Arc<[f32]> = vec![0.25; n].into();
        for frame in 0..6_u8 {
            let mask = if frame % 2 == 0 { keep.clone() } else { vec![f32::from(frame); n].into() };
            let residual = Some(Residual::Vector(vec![[f32::from(frame); 3]; n].into()));
            let first = Term { mask: Some(mask), ..normal(vec![0.1; 6]) };
            let second =
                Term { residual, residual_gain: 0.1, mask: Some(keep.clone()), ..vector(vec![[0.1; 3]; 2]) };
            check(&mut *backend, &shape, &[item(first), item(second)], 0.0);
        }
    }
}

#[test]
fn exports_are_exact() {
    let shape = cases::shape(18, 9, 9, 40);
    let n = shape.vertices();
    let certificate = Certificate {
        laplacian: chladni_harmonics::Laplacian::Delaunay,
        inertia_counts_match: Some(true),
        max_relative_residual: 0.0,
        max_orthogonality_error: 0.0,
    };
    let body = Body {
        frame: Frame { center: [0.0; 3], scale: 1.0 },
        positions: shape.positions.clone(),
        triangles: shape.triangles.clone(),
        operator_vertex: (0..n as u32).map(Some).collect(),
        basis: std::sync::Arc::new(Basis {
            eigenvalues: vec![0.0; 40],
            vectors: shape.basis.clone().into(),
            mass: vec![1.0; n],
            certificate,
        }),
    };
    for item in cases::items(19, &shape, 12) {
        let found = displacements_f64(&body, &item).unwrap();
        let (expected, _) = reference::positions(&shape, &item);
        for v in 0..n {
            let error = norm(sub(found[v], sub(expected[v], shape.positions[v])));
            assert!(error < 1e-12, "{error}");
        }
    }
    let nothing = Item { terms: vec![vector(vec![[0.0; 3]; 40]), normal(vec![])] };
    assert_eq!(displacements_f64(&body, &nothing).unwrap(), vec![[0.0; 3]; n]);
    assert!(displacements_f64(&body, &item(normal(vec![f32::NAN]))).is_err());
}
