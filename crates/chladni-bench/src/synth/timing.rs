//! How long a frame takes: by the wall clock, and on a device by its own clock.

use std::time::{Duration, Instant};

use chladni_synth::{CpuSynthesizer, FrameSettings, GpuSynthesizer, Item, Synthesizer};
use chladni_view::{Camera, Gpu, ItemBuffers, Topology, View};
use eframe::wgpu;
use rayon::prelude::*;

use super::clock::DeviceClock;
use super::report::Times;
use crate::easel::{Easel, wait};
use chladni_program::work::Error;

/// Frames measured: at least this many, and for at least this long.
const FRAMES: usize = 3;
const PATIENCE: Duration = Duration::from_millis(250);
/// Anything slower than this is measured once: without a graphics card the largest shapes may take seconds.
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

/// The CPU's times. Drawing includes the upload to a graphics device, where one draws.
pub fn on_cpu(
    synthesizer: &mut CpuSynthesizer,
    items: &[Item],
    triangles: &[[u32; 3]],
    easel: Option<&mut Easel>,
    copy: f64,
) -> Result<Times, Error> {
    let synthesis = median_secs(|| synthesizer.synthesize_positions(items).map_err(Error::other))?;
    let normals =
        median_secs(|| synthesizer.synthesize_normals(&FrameSettings::default()).map_err(Error::other))?;
    let drawn_by = easel.as_deref().map(|easel| easel.device.description());
    let draw = easel.map(|easel| draw_from_cpu(synthesizer, triangles, easel)).transpose()?;
    let device = format!("{}, {} threads", synthesizer.path(), rayon::current_num_threads());
    Ok(Times { device, synthesis, normals, draw, drawn_by, copy })
}

fn draw_from_cpu(
    synthesizer: &CpuSynthesizer,
    triangles: &[[u32; 3]],
    easel: &mut Easel,
) -> Result<f64, Error> {
    let vertices = synthesizer.model().vertices();
    let topology = Topology::new(&easel.device, vertices, triangles)?;
    let mut buffers = ItemBuffers::new(&easel.device, vertices, synthesizer.items());
    median_secs(|| {
        buffers.take_frame(&easel.device, synthesizer)?;
        easel.draw(&topology, &buffers, Camera::looking(View::ThreeQuarter))
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

/// The times of a graphics device; `easel` draws on the same.
pub fn on_gpu(
    synthesizer: &mut GpuSynthesizer,
    items: &[Item],
    triangles: &[[u32; 3]],
    gpu: &Gpu,
    easel: Option<&mut Easel>,
    copy: f64,
) -> Result<Times, Error> {
    let synthesis =
        median_device_secs(gpu, || synthesizer.synthesize_positions(items).map_err(Error::other))?;
    let normals = median_device_secs(gpu, || {
        synthesizer.synthesize_normals(&FrameSettings::default()).map_err(Error::other)
    })?;
    let drawn_by = easel.as_deref().map(|easel| easel.device.description());
    let draw = easel.map(|easel| draw_from_gpu(synthesizer, triangles, easel)).transpose()?;
    let device = synthesizer.context().device_name();
    Ok(Times { device, synthesis, normals, draw, drawn_by, copy })
}

fn draw_from_gpu(
    synthesizer: &GpuSynthesizer,
    triangles: &[[u32; 3]],
    easel: &mut Easel,
) -> Result<f64, Error> {
    let topology = Topology::new(&easel.device, synthesizer.model().vertices(), triangles)?;
    let buffers = ItemBuffers::of_frame(&synthesizer.frame())?;
    median_secs(|| easel.draw(&topology, &buffers, Camera::looking(View::ThreeQuarter)))
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

#[cfg(test)]
mod tests {
    use chladni_synth::SynthModel;
    use chladni_view::{Device, Draw};

    use super::*;
    use crate::sphere::{bumpy_sphere, waves};

    #[test]
    fn the_processors_frames_are_drawn_by_the_device_that_draws_films() {
        let (positions, triangles) = bumpy_sphere(40);
        let model = SynthModel::from_parts(&positions, &triangles, &waves(&positions, 3)).unwrap();
        let mut easel = Easel::new().unwrap();
        let items = vec![Item::default(); 2];
        let times =
            on_cpu(&mut CpuSynthesizer::new(model), &items, &triangles, Some(&mut easel), 1.0).unwrap();
        assert_eq!(times.drawn_by, Some(Device::open(Draw::Auto).unwrap().description()));
        assert!(times.draw.is_some());
    }
}
