//! The textures that are drawn into, and how their pixels come back.

use std::sync::mpsc::{Receiver, sync_channel};

use crate::pipelines::{DEPTH, smooth_layout};
use crate::{Gpu, Picture, Samples, ViewError};

/// A surface to draw on: colour samples, depth, and the finished picture as a texture
/// that a window can show or [`read`](Self::read) can fetch.
#[derive(Debug)]
pub struct Canvas {
    width: u32,
    height: u32,
    format: wgpu::TextureFormat,
    samples: Samples,
    color: wgpu::TextureView,
    depth: wgpu::TextureView,
    finished: wgpu::Texture,
    finished_view: wgpu::TextureView,
    /// The colours as an image, where their edges are still to be smoothed.
    rough: Option<wgpu::BindGroup>,
}

impl Canvas {
    /// The format of pictures and of what egui shows: sRGB-encoded numbers, premultiplied alpha.
    pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

    /// A canvas of `width` × `height` pixels in [`FORMAT`](Self::FORMAT), four samples each.
    ///
    /// # Errors
    /// [`ViewError::Size`] where a side is 0 or too long for the device.
    pub fn new(gpu: &Gpu, width: u32, height: u32) -> Result<Self, ViewError> {
        Self::with_format(gpu, width, height, Self::FORMAT, Samples::Four)
    }

    /// A canvas in [`FORMAT`](Self::FORMAT) of so many samples a pixel.
    ///
    /// # Errors
    /// [`ViewError::Size`] where a side is 0 or too long for the device.
    pub fn with_samples(gpu: &Gpu, width: u32, height: u32, samples: Samples) -> Result<Self, ViewError> {
        Self::with_format(gpu, width, height, Self::FORMAT, samples)
    }

    /// A canvas in another eight-bit format, `…Unorm` or `…UnormSrgb`; the renderer that draws on
    /// it must have been made for the same.
    ///
    /// # Errors
    /// [`ViewError::Size`] where a side is 0 or too long for the device.
    pub fn with_format(
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
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
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

    /// Another canvas like this one.
    pub(crate) fn twin(&self, gpu: &Gpu) -> Result<Self, ViewError> {
        Self::with_format(gpu, self.width, self.height, self.format, self.samples)
    }

    /// Width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Format of the finished picture.
    pub fn format(&self) -> wgpu::TextureFormat {
        self.format
    }

    /// How often a pixel is sampled.
    pub fn samples(&self) -> Samples {
        self.samples
    }

    /// The finished picture, to show in a window: `Renderer::register_native_texture` of
    /// egui-wgpu takes it as it is.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.finished_view
    }

    /// Begins a pass over the whole canvas, cleared to nothing.
    pub(crate) fn pass<'e>(&self, encoder: &'e mut wgpu::CommandEncoder) -> wgpu::RenderPass<'e> {
        let multisampled = self.rough.is_none();
        let store = if multisampled { wgpu::StoreOp::Discard } else { wgpu::StoreOp::Store };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("canvas"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.color,
                depth_slice: None,
                resolve_target: multisampled.then_some(&self.finished_view),
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(1.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        })
    }

    /// Where the device does not finish the picture by itself: the colours to be smoothed, and the
    /// pass that does it.
    pub(crate) fn smoothing<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
    ) -> Option<(&wgpu::BindGroup, wgpu::RenderPass<'e>)> {
        let rough = self.rough.as_ref()?;
        let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("smooth"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.finished_view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..Default::default()
        });
        Some((rough, pass))
    }

    /// The finished picture, fetched from the device. Alpha is straight, as PNG wants it.
    ///
    /// # Errors
    /// [`ViewError::Device`] where the device fails.
    pub fn read(&self, gpu: &Gpu) -> Result<Picture, ViewError> {
        let mut readback = Readback::new(gpu, self);
        readback.start(gpu, self);
        let mut rgba = Vec::new();
        readback.finish_into(gpu, &mut rgba)?;
        Ok(Picture { width: self.width, height: self.height, rgba })
    }
}

fn rough(device: &wgpu::Device, color: &wgpu::TextureView) -> wgpu::BindGroup {
    let resource = wgpu::BindingResource::TextureView(color);
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("rough picture"),
        layout: &smooth_layout(device),
        entries: &[wgpu::BindGroupEntry { binding: 0, resource }],
    })
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
    /// The copy that was started last, and where the word of its mapping arrives.
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

    /// Queues the copy of what has been drawn so far; does not wait.
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
        match receiver.try_recv() {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(ViewError::Device(error.to_string())),
            Err(_) => return Err(ViewError::Device("the picture was never handed over".into())),
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
        for pixel in rgba.as_chunks_mut::<4>().0 {
            if self.blue_first {
                pixel.swap(0, 2);
            }
            straighten(pixel);
        }
        Ok(())
    }
}

/// From premultiplied to straight alpha.
fn straighten(pixel: &mut [u8; 4]) {
    let alpha = u32::from(pixel[3]);
    if alpha == 0 || alpha == 255 {
        return;
    }
    for channel in &mut pixel[..3] {
        *channel = ((u32::from(*channel) * 255 + alpha / 2) / alpha).min(255) as u8;
    }
}
