//! Depth of field on a graphics device: its passes, and the depths that they read.

use super::bindings::{IMAGE, SAMPLER, group, layout, uniform};
use super::canvas::Canvas;
use super::lookup::Lookup;
use super::memory::initialized;
use super::screen::{self, DEPTH, Pipes, smooth_sampler, texture, view};
use super::uniforms::Uniforms;
use crate::focus::{Circle, Spread, step};
use crate::{Cell, Finish, Gpu, Samples, ViewError};

/// Light that spreads: more than eight bits, as these are squares.
pub(super) const LIGHT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// Radii of circles, and how much light before the focus covers.
pub(super) const NUMBER: wgpu::TextureFormat = wgpu::TextureFormat::R16Float;

/// All that softens pictures of one size.
pub(crate) struct Focusing {
    size: [u32; 2],
    samples: Samples,
    cells: Uniforms<Circle>,
    depth: wgpu::TextureView,
    sharp: wgpu::TextureView,
    circles: wgpu::TextureView,
    /// Light and circles of the small picture.
    small: [wgpu::TextureView; 2],
    /// Spread light: from behind the focus, from before it, and how much the latter covers.
    spread: [wgpu::TextureView; 3],
    /// The same, evened out: the first takes the place of the light that has not spread yet.
    even: [wgpu::TextureView; 3],
    depths: wgpu::BindGroup,
    shrink: wgpu::BindGroup,
    gather: wgpu::BindGroup,
    evening: wgpu::BindGroup,
    compose: wgpu::BindGroup,
}

/// Depths on either side of a pixel where the picture's own cannot be read.
pub(super) const FINE: u32 = 2;

/// The depths of a picture that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Depths {
    /// Those of its samples.
    Samples,
    /// Others, drawn once more, [`FINE`]: WebGL2 reads no textures of many samples.
    Fine,
}

impl Depths {
    pub(super) fn on(device: &wgpu::Device, samples: Samples) -> Self {
        match Lookup::within(&device.limits()) {
            Lookup::Textures if samples == Samples::Four => Self::Fine,
            Lookup::Textures | Lookup::Storage => Self::Samples,
        }
    }
}

/// Made once on a device for each number of samples.
#[derive(Debug)]
pub(super) struct Pipelines {
    /// Which they read.
    depths: Depths,
    /// Layouts of one cell, of depths, and of images.
    cell: wgpu::BindGroupLayout,
    depth: wgpu::BindGroupLayout,
    images: wgpu::BindGroupLayout,
    sampler: wgpu::Sampler,
    depth_sampler: wgpu::Sampler,
    circles: wgpu::RenderPipeline,
    shrink: wgpu::RenderPipeline,
    gather: wgpu::RenderPipeline,
    even: wgpu::RenderPipeline,
    compose: wgpu::RenderPipeline,
}

impl Focusing {
    /// Sees to it that there is one for `canvas`.
    pub(crate) fn fit<'k>(
        kept: &'k mut Option<Self>,
        gpu: &Gpu,
        canvas: &Canvas,
    ) -> Result<&'k mut Self, ViewError> {
        let size = [canvas.width, canvas.height];
        let limit = gpu.longest_side() / FINE;
        if Depths::on(&gpu.device, canvas.samples) == Depths::Fine && size.iter().any(|side| *side > limit) {
            return Err(ViewError::Size { width: canvas.width, height: canvas.height, limit });
        }
        let fits = |kept: &Self| kept.size == size && kept.samples == canvas.samples;
        let fitting = kept.take().filter(fits).unwrap_or_else(|| {
            let pipelines = gpu.drawing().focusing(&gpu.device, canvas.samples);
            Self::new(&gpu.device, pipelines, size, canvas.samples)
        });
        Ok(kept.insert(fitting))
    }

    fn new(device: &wgpu::Device, pipelines: &Pipelines, size: [u32; 2], samples: Samples) -> Self {
        let drawn = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let image = |label, size, format| view(&texture(device, label, size, format, (1, drawn)));
        let (depths, by) = match pipelines.depths {
            Depths::Samples => (samples.count(), 1),
            Depths::Fine => (1, FINE),
        };
        let depth = view(&texture(device, "kept depth", size.map(|side| by * side), DEPTH, (depths, drawn)));
        let sharp = image("sharp picture", size, Canvas::FORMAT);
        let circles = image("circles", size, NUMBER);
        let few = size.map(|side| side.div_ceil(step(size[1])));
        let small = [image("small picture", few, LIGHT), image("small circles", few, NUMBER)];
        let spread = [("far", LIGHT), ("near", LIGHT), ("cover", NUMBER)];
        let spread = spread.map(|(label, format)| image(label, few, format));
        let even = [small[0].clone(), image("even near", few, LIGHT), image("even cover", few, NUMBER)];
        let spread_of_size = Spread::new(size);
        let contents = bytemuck::bytes_of(&spread_of_size);
        let uniform = initialized(device, "spread", contents, wgpu::BufferUsages::UNIFORM);
        let images = |images: [&wgpu::TextureView; 5]| {
            let first = [uniform.as_entire_binding(), wgpu::BindingResource::Sampler(&pipelines.sampler)];
            let all: Vec<_> =
                first.into_iter().chain(images.map(wgpu::BindingResource::TextureView)).collect();
            group(device, "spread", &pipelines.images, &all)
        };
        Self {
            size,
            samples,
            cells: Uniforms::new(device, &pipelines.cell, "circles"),
            depths: group(
                device,
                "depths",
                &pipelines.depth,
                &[
                    wgpu::BindingResource::TextureView(&depth),
                    wgpu::BindingResource::Sampler(&pipelines.depth_sampler),
                ],
            ),
            // Slots that a pass does not read are bound to some texture that it may read.
            shrink: images([&sharp, &circles, &sharp, &sharp, &sharp]),
            gather: images([&small[0], &small[1], &small[0], &small[0], &small[0]]),
            evening: images([&sharp, &small[1], &spread[0], &spread[1], &spread[2]]),
            compose: images([&sharp, &circles, &even[0], &even[1], &even[2]]),
            depth,
            sharp,
            circles,
            small,
            spread,
            even,
        }
    }

    /// Where the depths of the picture are kept, and where it is drawn before it is softened.
    pub(crate) fn targets(&self) -> [&wgpu::TextureView; 2] {
        [&self.depth, &self.sharp]
    }

    /// From the sharp picture of `cells` to `target`.
    pub(crate) fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        (finish, cells): (&Finish, &[Cell<'_>]),
        target: &wgpu::TextureView,
    ) {
        self.cells.clear();
        for cell in cells {
            self.cells.push(&Circle::new(finish, cell, self.size[1]));
        }
        let pipelines = gpu.drawing().focusing(&gpu.device, self.samples);
        if !cells.is_empty() {
            self.cells.upload(&gpu.device, &gpu.queue, &pipelines.cell);
        }
        let mut pass = screen::begin(encoder, "finish", &[&self.circles]);
        pass.set_pipeline(&pipelines.circles);
        pass.set_bind_group(1, &self.depths, &[]);
        for (i, cell) in cells.iter().enumerate() {
            let r = cell.viewport;
            pass.set_scissor_rect(r.x, r.y, r.width, r.height);
            pass.set_bind_group(0, &self.cells.group, &[self.cells.offset(i)]);
            pass.draw(0..3, 0..1);
        }
        drop(pass);
        for (pipeline, group, targets) in [
            (&pipelines.shrink, &self.shrink, &self.small[..]),
            (&pipelines.gather, &self.gather, &self.spread[..]),
            (&pipelines.even, &self.evening, &self.even[..]),
        ] {
            screen::pass(encoder, pipeline, group, &targets.iter().collect::<Vec<_>>());
        }
        screen::pass(encoder, &pipelines.compose, &self.compose, &[target]);
    }
}

impl Pipelines {
    pub(super) fn new(device: &wgpu::Device, samples: Samples) -> Self {
        let fragment = wgpu::ShaderStages::FRAGMENT;
        let depths_are = Depths::on(device, samples);
        // As plain numbers, since GL loads no depths.
        let plain = wgpu::TextureSampleType::Float { filterable: false };
        let (sample_type, circles) = match (depths_are, samples) {
            (Depths::Fine, _) => (plain, "fine_circle_fragment"),
            (Depths::Samples, Samples::One) => (plain, "circle_fragment"),
            (Depths::Samples, Samples::Four) => (wgpu::TextureSampleType::Depth, "circles_fragment"),
        };
        let depth = wgpu::BindingType::Texture {
            sample_type,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: sample_type == wgpu::TextureSampleType::Depth,
        };
        let cell = layout(device, "circle", &[(fragment, uniform(true))]);
        let nearest = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::NonFiltering);
        let depth = layout(device, "depths", &[(fragment, depth), (fragment, nearest)]);
        let bindings = [uniform(false), SAMPLER, IMAGE, IMAGE, IMAGE, IMAGE, IMAGE];
        let images = layout(device, "spread", &bindings.map(|binding| (fragment, binding)));
        let module = device.create_shader_module(wgpu::include_wgsl!("focus.wgsl"));
        let of_cell = Pipes::new(device, &module, &[Some(&cell), Some(&depth)]);
        let of_images = Pipes::new(device, &module, &[Some(&images)]);
        Self {
            depths: depths_are,
            circles: of_cell.pipeline(circles, &[NUMBER]),
            shrink: of_images.pipeline("shrink_fragment", &[LIGHT, NUMBER]),
            gather: of_images.pipeline("gather_fragment", &[LIGHT, LIGHT, NUMBER]),
            even: of_images.pipeline("even_fragment", &[LIGHT, LIGHT, NUMBER]),
            compose: of_images.pipeline("compose_fragment", &[Canvas::FORMAT]),
            sampler: smooth_sampler(device),
            depth_sampler: device.create_sampler(&wgpu::SamplerDescriptor::default()),
            cell,
            depth,
            images,
        }
    }
}
