//! `chladni bench synth`: the papers' frame rates, here and now.

use std::time::{Duration, Instant};

use chladni_synth::{
    Coefficients, CpuSynthesizer, DeviceFrame, DeviceFrameBuffers, FrameSettings, GpuContext, GpuSynthesizer,
    Item, SynthModel, Synthesizer, Term,
};
use chladni_view::{
    Background, Camera, Canvas, Cell, Figure, Gpu, ItemBuffers, Lights, Rect, Renderer, Topology, View,
    layout,
};
use clap::{Args, ValueEnum};
use eframe::wgpu;
use rayon::prelude::*;
use serde::Serialize;

use super::sphere::{bumpy_sphere, waves};
use super::synth_rows::{ROWS, Row};
use crate::cli::{Failure, Terminal};

/// The papers' size of picture.
const SIZE_PX: (u32, u32) = (1024, 768);

/// Frames measured: at least so many, and for at least so long.
const FRAMES: usize = 5;
const PATIENCE: Duration = Duration::from_millis(400);

/// Reproduce the papers' tables of frame rates on generated shapes of the same n and K.
#[derive(Args)]
pub struct BenchSynth {
    /// Print JSON instead of a table.
    #[arg(long)]
    json: bool,
    /// Only these rows, such as bunny,cow.
    #[arg(long, value_delimiter = ',', value_name = "NAME")]
    rows: Vec<String>,
    /// Only this backend.
    #[arg(long)]
    backend: Option<BackendName>,
    /// Draw nothing.
    #[arg(long)]
    no_draw: bool,
    /// Threads of the CPU backend; all cores if left out.
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
enum BackendName {
    Cpu,
    Gpu,
}

/// One line of the result. Times are medians per frame.
#[derive(Serialize)]
struct Measured {
    model: &'static str,
    vertices: usize,
    harmonics: usize,
    items: usize,
    backend: BackendName,
    device: String,
    synthesis_ms: f64,
    normals_ms: f64,
    /// Null where nothing can draw. Includes the upload of a frame made on the CPU.
    draw_ms: Option<f64>,
    /// Of synthesis and normals.
    fps: f64,
    /// With drawing.
    drawn_fps: Option<f64>,
    /// What the paper prints, where it prints it.
    published_fps: Option<f64>,
    /// Bytes of the basis read and of positions written.
    bytes_moved: usize,
    /// Bytes moved per second of synthesis, over those of a copy of the basis in the same run.
    bandwidth_share: f64,
}

impl BenchSynth {
    /// Measures and prints.
    pub fn run(self, terminal: &Terminal) -> Result<(), Failure> {
        let known = |name: &String| ROWS.iter().any(|row| row.model == name);
        if let Some(name) = self.rows.iter().find(|name| !known(name)) {
            let names: Vec<&str> = ROWS.iter().map(|row| row.model).collect();
            return Err(Failure::input(format!(
                "--rows: no row is named {name}; there are {}",
                names.join(", ")
            )));
        }
        let mut pool = rayon::ThreadPoolBuilder::new();
        if let Some(threads) = self.threads {
            pool = pool.num_threads(threads);
        }
        let pool = pool.build().map_err(Failure::other)?;
        // The CPU needs a device for drawing only.
        let cpu_only = self.no_draw && self.backend == Some(BackendName::Cpu);
        let stage = match (!cpu_only).then(Stage::new).transpose() {
            Ok(stage) => stage,
            Err(failure) if self.backend == Some(BackendName::Gpu) => return Err(failure),
            Err(failure) => {
                terminal.warn(format!("nothing is drawn, and only the CPU measured: {failure}"));
                None
            }
        };
        let rows: Vec<&Row> = ROWS
            .iter()
            .filter(|row| self.rows.is_empty() || self.rows.iter().any(|name| name == row.model))
            .collect();
        if !self.json {
            terminal.result(HEAD)?;
        }
        let measured = pool.install(|| self.measure(terminal, &rows, stage))?;
        if self.json { terminal.json(&measured) } else { Ok(()) }
    }

    fn measure(
        &self,
        terminal: &Terminal,
        rows: &[&Row],
        mut stage: Option<Stage>,
    ) -> Result<Vec<Measured>, Failure> {
        let mut measured = Vec::new();
        let wanted = |backend| self.backend.is_none_or(|only| only == backend);
        for row in rows {
            let (positions, triangles) = bumpy_sphere(row.vertices);
            let basis = waves(&positions, row.harmonics);
            let model = SynthModel::from_parts(&positions, &triangles, &basis).map_err(Failure::other)?;
            drop(basis);
            for &(items, published) in row.published {
                if terminal.task().is_cancelled() {
                    return Err(Failure::Cancelled);
                }
                let published = (!published.is_nan()).then_some(published);
                let items = items_of(row, items);
                let mut done = Vec::new();
                if wanted(BackendName::Cpu) {
                    let mut synthesizer = CpuSynthesizer::new(model.clone());
                    let mut bench = OnCpu { synthesizer: &mut synthesizer, buffers: None };
                    done.push((
                        bench.measure(&items, &triangles, stage.as_mut().filter(|_| !self.no_draw))?,
                        BackendName::Cpu,
                    ));
                }
                if let (true, Some(stage)) = (wanted(BackendName::Gpu), stage.as_mut()) {
                    match GpuSynthesizer::new(&stage.context, model.clone()) {
                        Ok(synthesizer) => {
                            done.push((
                                OnGpu(synthesizer).measure(&items, &triangles, stage, !self.no_draw)?,
                                BackendName::Gpu,
                            ));
                        }
                        Err(error) => terminal.warn(format!("{}: {error}", row.model)),
                    }
                }
                for (times, backend) in done {
                    let row = times.report(row, items.len(), backend, published, &model);
                    if !self.json {
                        terminal.result(row.line())?;
                    }
                    measured.push(row);
                }
            }
        }
        Ok(measured)
    }
}

/// Items that give every harmonic weight.
fn items_of(row: &Row, count: usize) -> Vec<Item> {
    (0..count)
        .map(|s| {
            let weight = |k: usize, c: usize| 0.05 * ((k + 7 * s + 3 * c) as f32).sin() / (1.0 + k as f32);
            let coefficients =
                Coefficients::Vector((0..row.harmonics).map(|k| [0, 1, 2].map(|c| weight(k, c))).collect());
            Item { terms: vec![Term { coefficients, residual: None, residual_gain: 0.0, mask: None }] }
        })
        .collect()
}

struct Times {
    device: String,
    synthesis: f64,
    normals: f64,
    draw: Option<f64>,
    /// A copy of as many bytes as the basis.
    copy: f64,
}

impl Times {
    fn report(
        self,
        row: &Row,
        items: usize,
        backend: BackendName,
        published_fps: Option<f64>,
        model: &SynthModel,
    ) -> Measured {
        let bytes_moved = model.basis_bytes() + 12 * items * row.vertices;
        // A copy reads and writes.
        let copied_per_sec = 2.0 * model.basis_bytes() as f64 / self.copy;
        Measured {
            model: row.model,
            vertices: row.vertices,
            harmonics: row.harmonics,
            items,
            backend,
            device: self.device,
            synthesis_ms: 1e3 * self.synthesis,
            normals_ms: 1e3 * self.normals,
            draw_ms: self.draw.map(|draw| 1e3 * draw),
            fps: 1.0 / (self.synthesis + self.normals),
            drawn_fps: self.draw.map(|draw| 1.0 / (self.synthesis + self.normals + draw)),
            published_fps,
            bytes_moved,
            bandwidth_share: bytes_moved as f64 / self.synthesis / copied_per_sec,
        }
    }
}

const HEAD: &str = "model                n     K   S  backend  synthesis   normals   drawing       fps  published  bandwidth";

impl Measured {
    fn line(&self) -> String {
        let backend = if self.backend == BackendName::Cpu { "cpu" } else { "gpu" };
        let draw = self.draw_ms.map_or("-".into(), |draw| format!("{draw:.2} ms"));
        let published = self.published_fps.map_or("-".into(), |fps| format!("{fps:.1}"));
        format!(
            "{:<14} {:>7} {:>5} {:>3}  {backend:<7} {:>7.2} ms {:>6.2} ms {draw:>9} {:>9.1} {published:>10} {:>8.0} %",
            self.model,
            self.vertices,
            self.harmonics,
            self.items,
            self.synthesis_ms,
            self.normals_ms,
            self.fps,
            100.0 * self.bandwidth_share,
        )
    }
}

/// The median time of `work` in seconds, after one run that warms up.
fn median_secs(mut work: impl FnMut() -> Result<(), Failure>) -> Result<f64, Failure> {
    work()?;
    let (start, mut times) = (Instant::now(), Vec::new());
    while times.len() < FRAMES || start.elapsed() < PATIENCE {
        let before = Instant::now();
        work()?;
        times.push(before.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    Ok(times[times.len() / 2])
}

struct OnCpu<'a> {
    synthesizer: &'a mut CpuSynthesizer,
    buffers: Option<DeviceFrameBuffers>,
}

impl OnCpu<'_> {
    fn measure(
        &mut self,
        items: &[Item],
        triangles: &[[u32; 3]],
        stage: Option<&mut Stage>,
    ) -> Result<Times, Failure> {
        let synthesizer = &mut *self.synthesizer;
        let synthesis = median_secs(|| synthesizer.synthesize_positions(items).map_err(Failure::other))?;
        let normals = median_secs(|| {
            synthesizer.synthesize_normals(&FrameSettings::default()).map_err(Failure::other)
        })?;
        let draw = match stage {
            None => None,
            Some(stage) => {
                let buffers = self.buffers.insert(DeviceFrameBuffers::new(&stage.gpu.device));
                let upload =
                    |buffers: &mut _| synthesizer.upload(&stage.gpu.queue, buffers).map_err(Failure::other);
                upload(buffers)?;
                let scene = Scene::new(&stage.gpu, buffers.frame(), triangles)?;
                let renderer = &mut stage.renderer;
                let canvas = &stage.canvas;
                Some(median_secs(|| {
                    upload(buffers)?;
                    scene.draw(renderer, canvas)
                })?)
            }
        };
        let size = synthesizer.model().basis_bytes();
        let (source, mut target) = (vec![1_u8; size], vec![0_u8; size]);
        let chunk = size.div_ceil(8 * rayon::current_num_threads()).max(1);
        let copy = median_secs(|| {
            target
                .par_chunks_mut(chunk)
                .zip(source.par_chunks(chunk))
                .for_each(|(to, from)| to.copy_from_slice(from));
            std::hint::black_box(&mut target);
            Ok(())
        })?;
        let device = format!("{}, {} threads", synthesizer.path(), rayon::current_num_threads());
        Ok(Times { device, synthesis, normals, draw, copy })
    }
}

struct OnGpu(GpuSynthesizer);

impl OnGpu {
    fn measure(
        &mut self,
        items: &[Item],
        triangles: &[[u32; 3]],
        stage: &mut Stage,
        draw: bool,
    ) -> Result<Times, Failure> {
        let synthesizer = &mut self.0;
        let gpu = stage.gpu.clone();
        let synthesis = median_secs(|| {
            synthesizer.synthesize_positions(items).map_err(Failure::other)?;
            wait(&gpu)
        })?;
        let normals = median_secs(|| {
            synthesizer.synthesize_normals(&FrameSettings::default()).map_err(Failure::other)?;
            wait(&gpu)
        })?;
        let scene = Scene::new(&gpu, synthesizer.frame(), triangles)?;
        let draw =
            draw.then(|| median_secs(|| scene.draw(&mut stage.renderer, &stage.canvas))).transpose()?;
        let copy = copy_on_device_secs(&gpu, synthesizer.model().basis_bytes())?;
        Ok(Times { device: synthesizer.context().device_name(), synthesis, normals, draw, copy })
    }
}

/// Copies `bytes` from buffer to buffer, in pieces that a buffer may have.
fn copy_on_device_secs(gpu: &Gpu, bytes: usize) -> Result<f64, Failure> {
    let size = (bytes as u64).min(gpu.device.limits().max_buffer_size).next_multiple_of(4);
    let piece = size.min(gpu.device.limits().max_buffer_size / 4 * 4);
    let buffer = || {
        gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("copy"),
            size: piece,
            usage: wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    };
    let (source, target) = (buffer(), buffer());
    let secs = median_secs(|| {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(&source, 0, &target, 0, piece);
        gpu.queue.submit([encoder.finish()]);
        wait(gpu)
    })?;
    Ok(secs * bytes as f64 / piece as f64)
}

fn wait(gpu: &Gpu) -> Result<(), Failure> {
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(Failure::other)?;
    gpu.check().map_err(Failure::other)
}

/// Where frames are drawn.
struct Stage {
    gpu: Gpu,
    context: GpuContext,
    renderer: Renderer,
    canvas: Canvas,
}

impl Stage {
    fn new() -> Result<Self, Failure> {
        let gpu = Gpu::headless().map_err(Failure::other)?;
        let context = GpuContext::new(&gpu.device, &gpu.queue, gpu.loss()).map_err(Failure::other)?;
        let renderer = Renderer::new(&gpu);
        let canvas = Canvas::new(&gpu, SIZE_PX.0, SIZE_PX.1).map_err(Failure::other)?;
        Ok(Self { gpu, context, renderer, canvas })
    }
}

/// The items of a frame, side by side.
struct Scene {
    gpu: Gpu,
    topology: Topology,
    buffers: ItemBuffers,
    items: usize,
}

impl Scene {
    fn new(gpu: &Gpu, frame: DeviceFrame<'_>, triangles: &[[u32; 3]]) -> Result<Self, Failure> {
        let (vertices, items) = (frame.vertices as usize, frame.items as usize);
        let topology = Topology::new(gpu, vertices, triangles).map_err(Failure::other)?;
        let buffers = ItemBuffers::borrowed(frame.positions.clone(), frame.normals.clone(), vertices, items)
            .map_err(Failure::other)?;
        Ok(Self { gpu: gpu.clone(), topology, buffers, items })
    }

    fn draw(&self, renderer: &mut Renderer, canvas: &Canvas) -> Result<(), Failure> {
        let figures: Vec<_> =
            (0..self.items).map(|item| Figure::new(&self.topology, &self.buffers, item)).collect();
        let (rows, columns) = layout::rows_and_columns(SIZE_PX.0, SIZE_PX.1, self.items, 1.0);
        let viewports = layout::grid(Rect::of_size(SIZE_PX.0, SIZE_PX.1), rows, columns, 0, self.items);
        let camera = Camera::looking(View::ThreeQuarter);
        let cells: Vec<_> = viewports
            .into_iter()
            .zip(&figures)
            .map(|(viewport, figure)| Cell {
                viewport,
                camera,
                // The papers' pictures have no shadows.
                lights: Lights { shadow: 0.0, ..Lights::default() },
                background: Background::default(),
                figures: std::slice::from_ref(figure),
                markers: &[],
            })
            .collect();
        renderer.draw(canvas, &cells).map_err(Failure::other)?;
        wait(&self.gpu)
    }
}
