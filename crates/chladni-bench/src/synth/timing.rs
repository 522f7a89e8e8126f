//! How long a frame takes: by the wall clock, and on a device by its own clock.

use std::time::{Duration, Instant};

use chladni_synth::{CpuSynthesizer, DeviceFrameBuffers, FrameSettings, GpuSynthesizer, Item, Synthesizer};
use chladni_view::Gpu;
use eframe::wgpu;
use rayon::prelude::*;

use super::clock::DeviceClock;
use super::report::Times;
use super::stage::{Scene, Stage, wait};
use chladni_program::work::Error;

/// Frames measured: at least this many, and for at least this long.
const FRAMES: usize = 3;
const PATIENCE: Duration = Duration::from_millis(250);
/// Anything slower than this is measured once: a software device takes seconds to draw the largest shapes.
const SLOW: Duration = Duration::from_secs(1);

/// The median time of `work` in seconds, after one run that warms up.
fn median_secs(mut work: impl FnMut() -> Result<(), Error>) -> Result<f64, Error> {
    median_of(|| {
        let before = Instant::now();
        work()?;
        Ok(before.elapsed().as_secs_f64())
    })
}

/// The median time of what `work` submits, by the device's own clock where it has one.
fn median_device_secs(gpu: &Gpu, mut work: impl FnMut() -> Result<(), Error>) -> Result<f64, Error> {
    match DeviceClock::new(gpu) {
        Some(clock) => median_of(|| clock.secs(&mut work)),
        None => median_secs(|| {
            work()?;
            wait(gpu)
        }),
    }
}

/// The median of what `measured` says, after one run that warms up.
fn median_of(mut measured: impl FnMut() -> Result<f64, Error>) -> Result<f64, Error> {
    let start = Instant::now();
    measured()?;
    let frames = if start.elapsed() > SLOW { 1 } else { FRAMES };
    let (start, mut times) = (Instant::now(), Vec::new());
    while times.len() < frames || start.elapsed() < PATIENCE {
        times.push(measured()?);
    }
    times.sort_by(f64::total_cmp);
    Ok(times[times.len() / 2])
}

/// The CPU's times. Drawing includes the upload.
pub fn on_cpu(
    synthesizer: &mut CpuSynthesizer,
    items: &[Item],
    triangles: &[[u32; 3]],
    stage: Option<&mut Stage>,
    copy: f64,
) -> Result<Times, Error> {
    let synthesis = median_secs(|| synthesizer.synthesize_positions(items).map_err(Error::other))?;
    let normals =
        median_secs(|| synthesizer.synthesize_normals(&FrameSettings::default()).map_err(Error::other))?;
    let draw = stage.map(|stage| draw_from_cpu(synthesizer, triangles, stage)).transpose()?;
    let device = format!("{}, {} threads", synthesizer.path(), rayon::current_num_threads());
    Ok(Times { device, synthesis, normals, draw, copy })
}

fn draw_from_cpu(
    synthesizer: &CpuSynthesizer,
    triangles: &[[u32; 3]],
    stage: &mut Stage,
) -> Result<f64, Error> {
    let mut buffers = DeviceFrameBuffers::new(&stage.gpu.device);
    let upload = |buffers: &mut _| synthesizer.upload(&stage.gpu.queue, buffers).map_err(Error::other);
    upload(&mut buffers)?;
    let scene = Scene::new(&stage.gpu, buffers.frame(), triangles)?;
    median_secs(|| {
        upload(&mut buffers)?;
        scene.draw(&mut stage.renderer, &stage.canvas)
    })
}

/// Copies `bytes` in memory, with all threads.
pub fn copy_secs(bytes: usize) -> Result<f64, Error> {
    let (source, mut target) = (vec![1_u8; bytes], vec![0_u8; bytes]);
    let chunk = bytes.div_ceil(8 * rayon::current_num_threads()).max(1);
    median_secs(|| {
        target
            .par_chunks_mut(chunk)
            .zip(source.par_chunks(chunk))
            .for_each(|(to, from)| to.copy_from_slice(from));
        std::hint::black_box(&mut target);
        Ok(())
    })
}

/// The device's times.
pub fn on_gpu(
    synthesizer: &mut GpuSynthesizer,
    items: &[Item],
    triangles: &[[u32; 3]],
    stage: &mut Stage,
    draw: bool,
    copy: f64,
) -> Result<Times, Error> {
    let gpu = stage.gpu.clone();
    let synthesis =
        median_device_secs(&gpu, || synthesizer.synthesize_positions(items).map_err(Error::other))?;
    let normals = median_device_secs(&gpu, || {
        synthesizer.synthesize_normals(&FrameSettings::default()).map_err(Error::other)
    })?;
    let scene = Scene::new(&gpu, synthesizer.frame(), triangles)?;
    let draw = draw.then(|| median_secs(|| scene.draw(&mut stage.renderer, &stage.canvas))).transpose()?;
    Ok(Times { device: synthesizer.context().device_name(), synthesis, normals, draw, copy })
}

/// Copies `bytes` from buffer to buffer, in pieces that a buffer may have.
pub fn copy_on_device_secs(gpu: &Gpu, bytes: usize) -> Result<f64, Error> {
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
    let secs = median_device_secs(gpu, || {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(&source, 0, &target, 0, piece);
        gpu.queue.submit([encoder.finish()]);
        Ok(())
    })?;
    Ok(secs * bytes as f64 / piece as f64)
}
