//! The textures that are drawn into, and how their pixels come back.

use std::sync::mpsc::{Receiver, sync_channel};

use super::bindings::{group, smooth_layout};
use super::screen::{DEPTH, begin, view};
use crate::{Gpu, Samples, ViewError};

/// Color samples, depth, and the finished picture.
#[derive(Debug)]
pub(crate) struct Canvas {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) format: wgpu::TextureFormat,
    pub(crate) samples: Samples,
    color: wgpu::TextureView,
    depth: wgpu::TextureView,
    pub(super) finished: wgpu::Texture,
    pub(crate) finished_view: wgpu::TextureView,
    /// The colors as an image, where their edges are still to be smoothed.
    rough: Option<wgpu::BindGroup>,
}

impl Canvas {
    /// The format of pictures.
    pub(crate) const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

    pub(crate) fn for_pictures(
        gpu: &Gpu,
        width: u32,
        height: u32,
        samples: Samples,
    ) -> Result<Self, ViewError> {
        Self::new(gpu, width, height, Self::FORMAT, samples)
    }

    /// Another canvas like this one.
    pub(crate) fn twin(&self, gpu: &Gpu) -> Result<Self, ViewError> {
        Self::new(gpu, self.width, self.height, self.format, self.samples)
    }

    pub(crate) fn new(
        gpu: &Gpu,
        width: u32,
        height: u32,
        format: wgpu::TextureFormat,
        samples: Samples,
    ) -> Result<Self, ViewError> {
        let limit = gpu.device.limits().max_texture_dimension_2d;
        if width == 0 || height == 0 || width > limit || height > limit {
            return Err(ViewError::Size { width, height, limit });
        }
        let texture = |label, format, samples: Samples, usage| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: samples.count(),
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let attachment = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let finished = texture(
            "picture",
            format,
            Samples::One,
            attachment | wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::TEXTURE_BINDING,
        );
        let usage = match samples {
            Samples::One => attachment | wgpu::TextureUsages::TEXTURE_BINDING,
            Samples::Four => attachment,
        };
        let color = view(&texture("samples", format, samples, usage));
        Ok(Self {
            width,
            height,
            format,
            samples,
            rough: (samples == Samples::One).then(|| rough(&gpu.device, &color)),
            color,
            depth: view(&texture("depth", DEPTH, samples, attachment)),
            finished_view: view(&finished),
            finished,
        })
    }

    /// Begins a pass over the whole canvas, cleared to transparent. Resolved samples go to `target`; depths are kept
    /// if they are needed.
    pub(crate) fn pass<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        kept: Option<&wgpu::TextureView>,
    ) -> wgpu::RenderPass<'e> {
        let multisampled = self.rough.is_none();
        let store = if multisampled { wgpu::StoreOp::Discard } else { wgpu::StoreOp::Store };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("canvas"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.color,
                depth_slice: None,
                resolve_target: multisampled.then_some(target),
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: kept.unwrap_or(&self.depth),
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(1.0),
                    store: if kept.is_some() { wgpu::StoreOp::Store } else { wgpu::StoreOp::Discard },
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        })
    }

    /// If edges are smoothed in a pass of our own: the colors to be smoothed, and the pass that writes them
    /// to `target`.
    pub(crate) fn smoothing<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
    ) -> Option<(&wgpu::BindGroup, wgpu::RenderPass<'e>)> {
        let rough = self.rough.as_ref()?;
        Some((rough, begin(encoder, "smooth", &[target])))
    }
}

fn rough(device: &wgpu::Device, color: &wgpu::TextureView) -> wgpu::BindGroup {
    group(device, "rough picture", &smooth_layout(device), &[wgpu::BindingResource::TextureView(color)])
}

/// A buffer that one picture of a canvas comes back through.
#[derive(Debug)]
pub(crate) struct Readback {
    buffer: wgpu::Buffer,
    width: u32,
    height: u32,
    /// Bytes of a row in the buffer, a multiple of 256.
    stride: u32,
    blue_first: bool,
    /// The copy that was started last, and where we learn that it is mapped.
    copy: Option<(wgpu::SubmissionIndex, Receiver<Result<(), wgpu::BufferAsyncError>>)>,
}

impl Readback {
    pub(crate) fn new(gpu: &Gpu, canvas: &Canvas) -> Self {
        let stride = (canvas.width * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("readback"),
            size: u64::from(stride) * u64::from(canvas.height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let blue_first =
            matches!(canvas.format, wgpu::TextureFormat::Bgra8Unorm | wgpu::TextureFormat::Bgra8UnormSrgb);
        Self { buffer, width: canvas.width, height: canvas.height, stride, blue_first, copy: None }
    }

    /// Queues the copy of the picture drawn so far; does not wait.
    pub(crate) fn start(&mut self, gpu: &Gpu, canvas: &Canvas) {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_texture_to_buffer(
            canvas.finished.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &self.buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(self.stride),
                    rows_per_image: None,
                },
            },
            wgpu::Extent3d { width: self.width, height: self.height, depth_or_array_layers: 1 },
        );
        let submission = gpu.queue.submit([encoder.finish()]);
        let (sender, receiver) = sync_channel(1);
        self.buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            // Nobody waits for a film that was given up.
            let _ = sender.send(result);
        });
        self.copy = Some((submission, receiver));
    }

    /// Waits for the copy and unpacks it into `rgba`.
    pub(crate) fn finish_into(&mut self, gpu: &Gpu, rgba: &mut Vec<u8>) -> Result<(), ViewError> {
        let Some((submission, receiver)) = self.copy.take() else {
            return Err(ViewError::Device("no picture was asked for".into()));
        };
        gpu.wait(submission)?;
        // Of a shared device another thread may have taken the answer, and is about to hand it over. Pages cannot wait.
        let answer =
            if cfg!(target_family = "wasm") { receiver.try_recv().ok() } else { receiver.recv().ok() };
        match answer {
            Some(Ok(())) => {}
            Some(Err(error)) => return Err(ViewError::Device(error.to_string())),
            None => return Err(ViewError::Device("the picture was never handed over".into())),
        }
        {
            let mapped =
                self.buffer.get_mapped_range(..).map_err(|error| ViewError::Device(error.to_string()))?;
            rgba.clear();
            for row in mapped.chunks_exact(self.stride as usize) {
                rgba.extend_from_slice(&row[..self.width as usize * 4]);
            }
        }
        self.buffer.unmap();
        if self.blue_first {
            rgba.as_chunks_mut::<4>().0.iter_mut().for_each(|pixel| pixel.swap(0, 2));
        }
        Ok(())
    }
}
