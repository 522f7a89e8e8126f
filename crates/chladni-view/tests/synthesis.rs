//! Drawing straight from a synthesizer's buffers.
#![allow(
    clippy::unwrap_used,
    clippy::print_stderr,
    reason = "a panic is how a test fails, and a skipped one says so"
)]

mod shapes;

use chladni_synth::{
    AutoSynthesizer, Backend, Coefficients, FrameSettings, Item, SynthModel, Synthesizer, Term,
};
use chladni_view::{
    Background, Camera, Canvas, Cell, Figure, ItemBuffers, Lights, Picture, Rect, Renderer, Topology, layout,
};
use shapes::{gpu, sphere};

#[test]
fn both_backends_are_drawn_without_a_copy_and_look_the_same() {
    let Some(gpu) = gpu() else { return };
    let (positions, triangles) = sphere(16);
    // Harmonic 0 swells the sphere, harmonic 1 shifts it along y.
    let rest: Vec<[f64; 3]> = positions.iter().map(|p| p.map(f64::from)).collect();
    let basis: Vec<f64> = rest.iter().map(|_| 1.0).chain(rest.iter().map(|p| p[1])).collect();
    let model = SynthModel::from_parts(&rest, &triangles, &basis).unwrap();
    let swollen = |c: [f32; 2]| Item {
        terms: vec![Term {
            coefficients: Coefficients::Normal(c.to_vec()),
            residual: None,
            residual_gain: 0.0,
            mask: None,
        }],
    };
    let items = [Item::default(), swollen([0.3, 0.0]), swollen([-0.3, 0.2])];
    let topology = Topology::new(&gpu, positions.len(), &triangles).unwrap();
    let canvas = Canvas::new(&gpu, 240, 80).unwrap();
    let mut renderer = Renderer::new(&gpu);
    let mut camera = Camera::default();
    camera.fit(positions.iter().map(|p| p.map(|c| 1.4 * c)), 1.0, 1.0);
    let pictures = [Backend::Cpu, Backend::Gpu].map(|backend| {
        let mut synthesizer = AutoSynthesizer::new(gpu.synthesis(), model.clone(), backend);
        synthesizer.synthesize(&items, &FrameSettings::default()).unwrap();
        assert!(synthesizer.take_fallback().is_none());
        let buffers = ItemBuffers::of_frame(&synthesizer.frame()).unwrap();
        assert_eq!((buffers.items(), buffers.vertices()), (3, positions.len()));
        let figures: Vec<Figure<'_>> = (0..3).map(|item| Figure::new(&topology, &buffers, item)).collect();
        let viewports = layout::grid(Rect::of_size(240, 80), 1, 3, 0, 3);
        let cells: Vec<Cell<'_>> = viewports
            .into_iter()
            .zip(figures.chunks(1))
            .map(|(viewport, figures)| Cell {
                viewport,
                camera,
                lights: Lights::STUDIO,
                background: Background::TRANSPARENT,
                figures,
                markers: &[],
            })
            .collect();
        renderer.draw(&canvas, &cells).unwrap();
        canvas.read(&gpu).unwrap()
    });
    let width = |picture: &Picture, item: u32| {
        (80 * item..80 * (item + 1)).filter(|x| picture.pixel(*x, 40).unwrap()[3] > 127).count()
    };
    for picture in &pictures {
        let widths = [0, 1, 2].map(|item| width(picture, item));
        assert!(widths[1] > widths[0] + 10 && widths[0] > widths[2] + 10, "{widths:?}");
    }
    let differ = pictures[0].rgba.iter().zip(&pictures[1].rgba).filter(|(a, b)| a.abs_diff(**b) > 6).count();
    assert!(differ < 40, "{differ} channels differ");
}

#[test]
fn a_lost_device_is_known_to_drawing_and_synthesis() {
    let Some(gpu) = gpu() else { return };
    let context = gpu.synthesis();
    assert!(gpu.check().is_ok() && context.lost().is_none());
    gpu.device.destroy();
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    assert!(context.lost().is_some());
    assert!(gpu.check().unwrap_err().to_string().contains(context.lost().unwrap()));
}
