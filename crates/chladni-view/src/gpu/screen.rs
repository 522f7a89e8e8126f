//! Passes over a whole picture: textures and pipelines of the finish, and of depths.

/// Depth of a canvas.
pub(super) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// A texture of one level to draw into and to read; `usage` says what else.
pub(super) fn texture(
    device: &wgpu::Device,
    label: &str,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    (sample_count, usage): (u32, wgpu::TextureUsages),
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: usage | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    })
}

/// The whole of a texture.
pub(super) fn view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// Between pixels, and no farther than the last.
pub(super) fn smooth_sampler(device: &wgpu::Device) -> wgpu::Sampler {
    let linear = wgpu::FilterMode::Linear;
    device.create_sampler(&wgpu::SamplerDescriptor {
        mag_filter: linear,
        min_filter: linear,
        ..Default::default()
    })
}

/// Makes pipelines that draw the shader's `screen_vertex`.
pub(super) struct Pipes<'a> {
    device: &'a wgpu::Device,
    module: &'a wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
}

impl<'a> Pipes<'a> {
    /// With these bind groups.
    pub(super) fn new(
        device: &'a wgpu::Device,
        module: &'a wgpu::ShaderModule,
        groups: &[Option<&wgpu::BindGroupLayout>],
    ) -> Self {
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("finish"),
            bind_group_layouts: groups,
            immediate_size: 0,
        });
        Self { device, module, layout }
    }

    /// With this fragment stage, into targets of these formats.
    pub(super) fn pipeline(
        &self,
        entry_point: &str,
        formats: &[wgpu::TextureFormat],
    ) -> wgpu::RenderPipeline {
        let target = |format: &wgpu::TextureFormat| {
            Some(wgpu::ColorTargetState { format: *format, blend: None, write_mask: wgpu::ColorWrites::ALL })
        };
        let targets: Vec<_> = formats.iter().map(target).collect();
        self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(entry_point),
            layout: Some(&self.layout),
            vertex: wgpu::VertexState {
                module: self.module,
                entry_point: Some("screen_vertex"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: self.module,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// Begins a pass over whole targets, cleared to nothing.
pub(super) fn begin<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    label: &str,
    targets: &[&wgpu::TextureView],
) -> wgpu::RenderPass<'e> {
    let target = |view| {
        Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                store: wgpu::StoreOp::Store,
            },
        })
    };
    let targets: Vec<_> = targets.iter().copied().map(target).collect();
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: &targets,
        ..Default::default()
    })
}

/// Begins a pass over a whole target of depths, cleared to the farthest depth.
pub(super) fn depth_pass<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    label: &str,
    view: &wgpu::TextureView,
) -> wgpu::RenderPass<'e> {
    let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Store };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(ops),
            stencil_ops: None,
        }),
        ..Default::default()
    })
}

/// One pass over whole targets.
pub(super) fn pass(
    encoder: &mut wgpu::CommandEncoder,
    pipeline: &wgpu::RenderPipeline,
    group: &wgpu::BindGroup,
    targets: &[&wgpu::TextureView],
) {
    let mut drawing = begin(encoder, "finish", targets);
    drawing.set_pipeline(pipeline);
    drawing.set_bind_group(0, group, &[]);
    drawing.draw(0..3, 0..1);
}
