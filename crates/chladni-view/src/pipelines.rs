//! Pipelines and bind-group layouts, made once per device and target format.

use wgpu::{BindGroupLayout, RenderPipeline, TextureFormat};

/// Samples per pixel.
pub(crate) const SAMPLES: u32 = 4;
/// Depth of a canvas.
pub(crate) const DEPTH: TextureFormat = TextureFormat::Depth32Float;

/// Bytes of one marker: position, radius, colour.
pub(crate) const MARKER_BYTES: u64 = 20;

pub(crate) struct Layouts {
    pub(crate) cell: BindGroupLayout,
    pub(crate) figure: BindGroupLayout,
    pub(crate) images: BindGroupLayout,
    pub(crate) corners: BindGroupLayout,
}

/// The same surface twice: its front faces, and its back faces. Opaque surfaces draw the front
/// first, so that what lies behind it is never shaded; translucent ones the back first.
pub(crate) struct Sides {
    pub(crate) front: RenderPipeline,
    pub(crate) back: RenderPipeline,
}

pub(crate) struct Pipelines {
    pub(crate) shadow: RenderPipeline,
    pub(crate) backdrop: RenderPipeline,
    pub(crate) plain: Sides,
    pub(crate) values: Sides,
    pub(crate) colors: Sides,
    pub(crate) corners: Sides,
    pub(crate) markers: RenderPipeline,
    pub(crate) hidden_markers: RenderPipeline,
}

impl Layouts {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        use wgpu::ShaderStages;
        let both = ShaderStages::VERTEX_FRAGMENT;
        let uniform = |label| {
            let ty = wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: true,
                min_binding_size: None,
            };
            layout(device, label, &[(both, ty)])
        };
        let image = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let depth = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Depth,
            view_dimension: wgpu::TextureViewDimension::D2Array,
            multisampled: false,
        };
        let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        let storage = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: true },
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let fragment = ShaderStages::FRAGMENT;
        Self {
            cell: uniform("cell"),
            figure: uniform("figure"),
            images: layout(
                device,
                "images",
                &[
                    (fragment, image),
                    (fragment, sampler),
                    (fragment, image),
                    (fragment, sampler),
                    (fragment, depth),
                    (fragment, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison)),
                ],
            ),
            corners: layout(device, "corners", &[(ShaderStages::VERTEX, storage); 5]),
        }
    }
}

fn layout(
    device: &wgpu::Device,
    label: &str,
    bindings: &[(wgpu::ShaderStages, wgpu::BindingType)],
) -> BindGroupLayout {
    let entries: Vec<_> = (0..)
        .zip(bindings)
        .map(|(binding, &(visibility, ty))| wgpu::BindGroupLayoutEntry {
            binding,
            visibility,
            ty,
            count: None,
        })
        .collect();
    device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

/// What sets one pipeline apart.
#[derive(Clone, Copy)]
struct Kind<'a> {
    label: &'a str,
    vertex: &'a str,
    fragment: &'a str,
    buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    strip: bool,
    cull: Option<wgpu::Face>,
    depth: (bool, wgpu::CompareFunction),
}

impl Pipelines {
    pub(crate) fn new(device: &wgpu::Device, layouts: &Layouts, format: TextureFormat) -> Self {
        use wgpu::VertexFormat::{Float32, Float32x3, Unorm8x4};
        let module = device.create_shader_module(wgpu::include_wgsl!("shader.wgsl"));
        let groups = [&layouts.cell, &layouts.figure, &layouts.images, &layouts.corners].map(Some);
        let pipeline_layout = |count: usize| {
            device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("chladni-view"),
                bind_group_layouts: &groups[..count],
                immediate_size: 0,
            })
        };
        let (shadowed, indexed, cornered) = (pipeline_layout(2), pipeline_layout(3), pipeline_layout(4));
        let build = |layout: &wgpu::PipelineLayout, kind: Kind<'_>| {
            device.create_render_pipeline(&descriptor(&module, layout, &kind, &[Some(target(format))]))
        };
        let attribute =
            |format, location| [wgpu::VertexAttribute { format, offset: 0, shader_location: location }];
        let (position, normal) = (attribute(Float32x3, 0), attribute(Float32x3, 1));
        let (value, color) = (attribute(Float32, 2), attribute(Unorm8x4, 2));
        let slot = |stride, attributes| {
            Some(wgpu::VertexBufferLayout {
                array_stride: stride,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes,
            })
        };
        let body = [slot(12, &position), slot(12, &normal)];
        let valued = [body[0].clone(), body[1].clone(), slot(4, &value)];
        let colored = [body[0].clone(), body[1].clone(), slot(4, &color)];
        let marker_attributes = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32, 2 => Unorm8x4];
        let marker = [Some(wgpu::VertexBufferLayout {
            array_stride: MARKER_BYTES,
            step_mode: wgpu::VertexStepMode::Instance,
            attributes: &marker_attributes,
        })];
        let (less, more) = (wgpu::CompareFunction::LessEqual, wgpu::CompareFunction::Greater);
        let surface = |label, vertex, fragment, buffers| Kind {
            label,
            vertex,
            fragment,
            buffers,
            strip: false,
            cull: None,
            depth: (true, less),
        };
        let disc = |label, fragment, compare| Kind {
            label,
            vertex: "marker_vertex",
            fragment,
            buffers: &marker,
            strip: true,
            cull: None,
            depth: (false, compare),
        };
        let sides = |layout: &wgpu::PipelineLayout, kind: Kind<'_>| Sides {
            front: build(layout, Kind { cull: Some(wgpu::Face::Back), ..kind }),
            back: build(layout, Kind { cull: Some(wgpu::Face::Front), ..kind }),
        };
        // The same attributes, seen from the key light: no colour, one sample.
        let mut shadow =
            descriptor(&module, &shadowed, &surface("shadow", "shadow_vertex", "", &body[..1]), &[]);
        shadow.fragment = None;
        shadow.multisample.count = 1;
        if let Some(depth) = &mut shadow.depth_stencil {
            depth.bias = wgpu::DepthBiasState { constant: 2, slope_scale: 1.5, clamp: 0.0 };
        }
        Self {
            shadow: device.create_render_pipeline(&shadow),
            backdrop: build(
                &indexed,
                Kind {
                    label: "backdrop",
                    vertex: "backdrop_vertex",
                    fragment: "backdrop_fragment",
                    buffers: &[],
                    strip: false,
                    cull: None,
                    depth: (false, wgpu::CompareFunction::Always),
                },
            ),
            plain: sides(&indexed, surface("plain", "plain_vertex", "plain_fragment", &body)),
            values: sides(&indexed, surface("values", "value_vertex", "value_fragment", &valued)),
            colors: sides(&indexed, surface("colors", "color_vertex", "color_fragment", &colored)),
            corners: sides(&cornered, surface("corners", "corner_vertex", "corner_fragment", &[])),
            markers: build(&indexed, disc("markers", "marker_fragment", less)),
            hidden_markers: build(&indexed, disc("hidden markers", "hidden_marker_fragment", more)),
        }
    }
}

fn target(format: TextureFormat) -> wgpu::ColorTargetState {
    wgpu::ColorTargetState {
        format,
        blend: Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
        write_mask: wgpu::ColorWrites::ALL,
    }
}

fn descriptor<'a>(
    module: &'a wgpu::ShaderModule,
    layout: &'a wgpu::PipelineLayout,
    kind: &Kind<'a>,
    targets: &'a [Option<wgpu::ColorTargetState>],
) -> wgpu::RenderPipelineDescriptor<'a> {
    use wgpu::PrimitiveTopology::{TriangleList, TriangleStrip};
    wgpu::RenderPipelineDescriptor {
        label: Some(kind.label),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(kind.vertex),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: kind.buffers,
        },
        primitive: wgpu::PrimitiveState {
            topology: if kind.strip { TriangleStrip } else { TriangleList },
            cull_mode: kind.cull,
            ..Default::default()
        },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(kind.depth.0),
            depth_compare: Some(kind.depth.1),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState { count: SAMPLES, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(kind.fragment),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets,
        }),
        multiview_mask: None,
        cache: None,
    }
}
