//! The finish of a picture on a graphics device: its passes, and the textures between them.

use super::bindings::{IMAGE, SAMPLER, group, layout, uniform};
use super::canvas::Canvas;
use super::screen::{self, Pipes, smooth_sampler, texture, view};
use crate::finish::{FinishUniform, step};
use crate::{Finish, Gpu, ViewError};

/// The format of the pictures in which light spreads: more than eight bits, because faint light is spread far.
const SMALL: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// All that finishes pictures of one size.
pub(crate) struct Finishing {
    size: [u32; 2],
    uniform: wgpu::Buffer,
    bare: wgpu::TextureView,
    last: wgpu::Texture,
    /// Passes in order, each with its pipeline, inputs and target.
    spreading: Vec<(Pass, wgpu::BindGroup, wgpu::TextureView)>,
    finish: wgpu::BindGroup,
    /// When the picture that shows on was drawn.
    before_secs: Option<f64>,
}

#[derive(Clone, Copy, Debug)]
enum Pass {
    Bright,
    Smaller,
    Across,
    Down,
    Finish,
}

/// Made once on a device.
#[derive(Debug)]
pub(super) struct Pipelines {
    layout: wgpu::BindGroupLayout,
    sampler: wgpu::Sampler,
    /// By [`Pass`].
    made: Vec<wgpu::RenderPipeline>,
}

impl Finishing {
    /// Sees to it that there is one for `canvas`.
    pub(crate) fn fit(kept: &mut Option<Self>, gpu: &Gpu, canvas: &Canvas) -> Result<(), ViewError> {
        let size = [canvas.width, canvas.height];
        if kept.as_ref().is_some_and(|kept| kept.size == size) {
            return Ok(());
        }
        if canvas.format != Canvas::FORMAT {
            return Err(ViewError::Shape(format!("a finish on a canvas of {:?}", canvas.format)));
        }
        // The textures of another size go before the new ones come.
        *kept = None;
        *kept = Some(Self::new(&gpu.device, gpu.drawing().finishing(&gpu.device), size));
        Ok(())
    }

    fn new(device: &wgpu::Device, pipelines: &Pipelines, size: [u32; 2]) -> Self {
        let texture = |label, size, format, usage| texture(device, label, size, format, (1, usage));
        let drawn = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let small = size.map(|side| side.div_ceil(step(size[1])));
        let smaller = small.map(|side| side.div_ceil(4));
        let [near, near_half] = ["near", "near half"].map(|label| view(&texture(label, small, SMALL, drawn)));
        let [far, far_half] = ["far", "far half"].map(|label| view(&texture(label, smaller, SMALL, drawn)));
        let bare = view(&texture("bare picture", size, Canvas::FORMAT, drawn));
        let last = texture("last picture", size, Canvas::FORMAT, wgpu::TextureUsages::COPY_DST);
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("finish"),
            size: size_of::<FinishUniform>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let group = |images: [&wgpu::TextureView; 4]| pipelines.group(device, &uniform, images);
        // A pass reads only its first image, so the same one fills all four slots.
        let one = |image: &wgpu::TextureView| group([image; 4]);
        let spreading = vec![
            (Pass::Bright, one(&bare), near.clone()),
            (Pass::Across, one(&near), near_half.clone()),
            (Pass::Down, one(&near_half), near.clone()),
            (Pass::Smaller, one(&near), far.clone()),
            (Pass::Across, one(&far), far_half.clone()),
            (Pass::Down, one(&far_half), far.clone()),
        ];
        let finish = group([&bare, &near, &far, &view(&last)]);
        Self { size, uniform, bare, last, spreading, finish, before_secs: None }
    }

    /// A picture had no finish: the next one has no trail of those before it.
    pub fn forget(&mut self) {
        self.before_secs = None;
    }

    /// Where the picture is drawn that is to be finished.
    pub(crate) fn bare(&self) -> &wgpu::TextureView {
        &self.bare
    }

    /// From the bare picture to the canvas.
    pub(crate) fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        canvas: &Canvas,
        finish: &Finish,
        at_secs: f64,
    ) {
        let pipelines = gpu.drawing().finishing(&gpu.device);
        let uniform = finish.uniform(self.size, at_secs, self.before_secs);
        gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&uniform));
        if finish.bloom > 0.0 {
            for (pass, group, target) in &self.spreading {
                pipelines.pass(encoder, *pass, group, target);
            }
        }
        pipelines.pass(encoder, Pass::Finish, &self.finish, &canvas.finished_view);
        self.before_secs = (finish.trail_secs > 0.0).then_some(at_secs);
        if self.before_secs.is_some() {
            let [width, height] = self.size;
            let whole = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
            let (from, to) = (canvas.finished.as_image_copy(), self.last.as_image_copy());
            encoder.copy_texture_to_texture(from, to, whole);
        }
    }
}

impl Pipelines {
    pub(super) fn new(device: &wgpu::Device) -> Self {
        let fragment = wgpu::ShaderStages::FRAGMENT;
        let bindings =
            [uniform(false), SAMPLER, IMAGE, IMAGE, IMAGE, IMAGE].map(|binding| (fragment, binding));
        let groups = layout(device, "finish", &bindings);
        let module = device.create_shader_module(wgpu::include_wgsl!("finish.wgsl"));
        let pipes = Pipes::new(device, &module, &[Some(&groups)]);
        let pipeline = |entry_point, format| pipes.pipeline(entry_point, &[format]);
        let small = ["bright_fragment", "smaller_fragment", "across_fragment", "down_fragment"];
        let mut made: Vec<_> = small.into_iter().map(|name| pipeline(name, SMALL)).collect();
        made.push(pipeline("finish_fragment", Canvas::FORMAT));
        let sampler = smooth_sampler(device);
        Self { layout: groups, sampler, made }
    }

    fn group(
        &self,
        device: &wgpu::Device,
        uniform: &wgpu::Buffer,
        images: [&wgpu::TextureView; 4],
    ) -> wgpu::BindGroup {
        let first = [uniform.as_entire_binding(), wgpu::BindingResource::Sampler(&self.sampler)];
        let images = images.map(wgpu::BindingResource::TextureView);
        let all: Vec<_> = first.into_iter().chain(images).collect();
        group(device, "finish", &self.layout, &all)
    }

    fn pass(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pass: Pass,
        group: &wgpu::BindGroup,
        target: &wgpu::TextureView,
    ) {
        screen::pass(encoder, &self.made[pass as usize], group, &[target]);
    }
}
