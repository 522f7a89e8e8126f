//! Bind-group layouts, made once per device, and pipelines, once per device and target format.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use wgpu::{BindGroupLayout, RenderPipeline, TextureFormat};

use super::bindings::{IMAGE, SAMPLER, layout, smooth_layout, uniform};
use super::grains::GRAIN_BYTES;
use super::lookup::Lookup;
use super::screen::DEPTH;
use crate::{Figure, Paint, Samples};

/// Bytes of one marker: position, radius, color.
pub(crate) const MARKER_BYTES: u64 = 20;

/// The shader, in parts that use each other's names and those of `gpu/lookup.rs`, which look up the vertices.
const SHADER: &str = concat!(
    include_str!("shader/scene.wgsl"),
    include_str!("shader/surface.wgsl"),
    include_str!("shader/color.wgsl"),
    include_str!("shader/light.wgsl"),
    include_str!("shader/paint.wgsl"),
    include_str!("shader/backdrop.wgsl"),
    include_str!("shader/marker.wgsl"),
    include_str!("shader/edges.wgsl"),
    include_str!("shader/grains.wgsl"),
);

#[derive(Debug)]
pub(crate) struct Layouts {
    pub(crate) cell: BindGroupLayout,
    pub(crate) figure: BindGroupLayout,
    pub(crate) images: BindGroupLayout,
    pub(crate) corners: BindGroupLayout,
}

/// The task of a pipeline. Each pipeline is compiled when first needed, so that a picture waits only for its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Kind {
    pub(crate) part: Part,
    pub(crate) samples: Samples,
    /// Whether the key light's shadows are looked up: sixteen samples a pixel that a software device
    /// would take even where their result is thrown away.
    pub(crate) shadows: bool,
    /// Whether a panorama shines.
    pub(crate) around: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Part {
    /// A surface's depth as the key light sees it.
    Shadow,
    /// As the viewer sees it.
    Depth,
    Backdrop,
    /// A picture in its place.
    Pictured,
    Surface(Coat, Side, Pass),
    /// A brush's ring on a surface that is drawn already.
    Brush,
    Markers,
    HiddenMarkers,
    /// Sand on a surface that is drawn already.
    Grains,
    /// Smooths the edges of a picture of one sample a pixel.
    Smooth,
}

/// Where a surface's color comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Coat {
    Plain,
    Values,
    Colors,
    Answer,
    /// The same, by speed and with nodal lines.
    Figured,
    Corners,
}

/// One side of a surface. Opaque surfaces draw the front first, so that surfaces behind it are never
/// shaded; translucent ones the back first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Side {
    Front,
    Back,
}

/// The part of a side's drawing. Only what is nearest of a translucent side is seen, in whatever order its triangles
/// come: its depths are drawn before its colors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Pass {
    /// Depths and colors, of an opaque surface.
    Whole,
    /// The depths of a translucent one.
    Depths,
    /// Its colors, where those depths are.
    Colors,
}

impl Coat {
    pub(crate) fn of(figure: &Figure<'_>) -> Self {
        match figure.paint {
            _ if figure.wire.is_some() => Self::Corners,
            Paint::Skin(_) => Self::Corners,
            Paint::Material => Self::Plain,
            Paint::Values(..) => Self::Values,
            Paint::Colors(_) => Self::Colors,
            Paint::Answer(_, by) if by.is_figured() => Self::Figured,
            Paint::Answer(..) => Self::Answer,
        }
    }
}

impl Kind {
    pub(crate) fn new(part: Part, samples: Samples) -> Self {
        Self { part, samples, shadows: false, around: false }
    }
}

impl Layouts {
    pub(crate) fn new(device: &wgpu::Device, lookup: Lookup) -> Self {
        use wgpu::ShaderStages;
        let both = ShaderStages::VERTEX_FRAGMENT;
        let one_of_many = |label| layout(device, label, &[(both, uniform(true))]);
        let depth = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Depth,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let fragment = ShaderStages::FRAGMENT;
        Self {
            cell: one_of_many("cell"),
            figure: one_of_many("figure"),
            images: layout(
                device,
                "images",
                &[
                    (fragment, IMAGE),
                    (fragment, SAMPLER),
                    (fragment, IMAGE),
                    (fragment, SAMPLER),
                    (fragment, depth),
                    (fragment, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison)),
                    (fragment, IMAGE),
                    (fragment, SAMPLER),
                ],
            ),
            corners: lookup.layout(device),
        }
    }
}

/// A place for a pipeline, empty until it is compiled.
type Slot = Arc<OnceLock<RenderPipeline>>;

/// The pipelines that any renderer of a device needed so far.
#[derive(Debug)]
pub(crate) struct Pipelines {
    module: wgpu::ShaderModule,
    /// Layouts of groups: the first two, three, all four, and that of [`Part::Smooth`].
    shadowed: wgpu::PipelineLayout,
    indexed: wgpu::PipelineLayout,
    cornered: wgpu::PipelineLayout,
    smoothing: wgpu::PipelineLayout,
    made: Mutex<HashMap<(TextureFormat, Kind), Slot>>,
}

impl Pipelines {
    pub(crate) fn new(device: &wgpu::Device, layouts: &Layouts, lookup: Lookup) -> Self {
        let smooth = smooth_layout(device);
        let layout = |groups: &[Option<&BindGroupLayout>]| {
            device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("chladni-view"),
                bind_group_layouts: groups,
                immediate_size: 0,
            })
        };
        let groups = [&layouts.cell, &layouts.figure, &layouts.images, &layouts.corners].map(Some);
        Self {
            module: device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("gpu/shader"),
                source: wgpu::ShaderSource::Wgsl((lookup.shader() + SHADER).into()),
            }),
            shadowed: layout(&groups[..2]),
            indexed: layout(&groups[..3]),
            cornered: layout(&groups),
            smoothing: layout(&[Some(&smooth)]),
            made: Mutex::default(),
        }
    }

    /// The pipeline of `kind` for targets of `format`, compiled if this is its first use on the device.
    pub(crate) fn get(&self, device: &wgpu::Device, format: TextureFormat, kind: Kind) -> RenderPipeline {
        // Nothing is compiled under the lock: other threads wait only for the pipeline that they need, too.
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        let slot = Arc::clone(made.entry((format, kind)).or_default());
        drop(made);
        slot.get_or_init(|| self.build(device, format, kind)).clone()
    }

    fn build(&self, device: &wgpu::Device, format: TextureFormat, kind: Kind) -> RenderPipeline {
        use wgpu::VertexFormat::{Float32, Float32x3, Unorm8x4};
        let attribute =
            |format, location| [wgpu::VertexAttribute { format, offset: 0, shader_location: location }];
        let (position, normal) = (attribute(Float32x3, 0), attribute(Float32x3, 1));
        let (value, color) = (attribute(Float32, 2), attribute(Unorm8x4, 2));
        let (reach, lag) = (attribute(Float32, 1), attribute(Float32x3, 4));
        let rest = wgpu::vertex_attr_array![2 => Float32x4, 3 => Float32];
        let marker = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32, 2 => Unorm8x4];
        let grain = wgpu::vertex_attr_array![0 => Uint32x3, 1 => Float32x3, 2 => Float32];
        let slot = |step_mode, stride, attributes| {
            Some(wgpu::VertexBufferLayout { array_stride: stride, step_mode, attributes })
        };
        let each = |stride, attributes| slot(wgpu::VertexStepMode::Vertex, stride, attributes);
        let [at, towards] = [each(12, &position), each(12, &normal)];
        let (vertex, fragment, buffers) = match kind.part {
            Part::Shadow => ("shadow_vertex", None, vec![at]),
            Part::Depth => ("depth_vertex", None, vec![at]),
            Part::Backdrop => ("screen_vertex", Some("backdrop_fragment"), vec![]),
            Part::Pictured => ("screen_vertex", Some("pictured_fragment"), vec![]),
            Part::Smooth => ("screen_vertex", Some("smooth_fragment"), vec![]),
            Part::Surface(Coat::Plain, ..) => ("plain_vertex", Some("plain_fragment"), vec![at, towards]),
            Part::Surface(Coat::Values, ..) => {
                ("value_vertex", Some("value_fragment"), vec![at, towards, each(4, &value)])
            }
            Part::Surface(Coat::Colors, ..) => {
                ("color_vertex", Some("color_fragment"), vec![at, towards, each(4, &color)])
            }
            Part::Surface(Coat::Answer, ..) => {
                ("answer_vertex", Some("answer_fragment"), vec![at, towards, each(20, &rest)])
            }
            Part::Surface(Coat::Figured, ..) => {
                let buffers = vec![at, towards, each(20, &rest), each(12, &lag)];
                ("figured_vertex", Some("figured_fragment"), buffers)
            }
            Part::Surface(Coat::Corners, ..) => ("corner_vertex", Some("corner_fragment"), vec![]),
            Part::Brush => ("brush_vertex", Some("brush_fragment"), vec![at, each(4, &reach)]),
            Part::Grains => {
                let each = slot(wgpu::VertexStepMode::Instance, GRAIN_BYTES, &grain);
                ("grain_vertex", Some("grain_fragment"), vec![each])
            }
            Part::Markers | Part::HiddenMarkers => {
                let fragment =
                    if kind.part == Part::Markers { "marker_fragment" } else { "hidden_marker_fragment" };
                let stride = wgpu::VertexStepMode::Instance;
                ("marker_vertex", Some(fragment), vec![slot(stride, MARKER_BYTES, &marker)])
            }
        };
        // No light is computed where it would be thrown away.
        let fragment = match kind.part {
            Part::Surface(.., Pass::Depths) => Some("no_fragment"),
            _ => fragment,
        };
        let layout = match kind.part {
            Part::Grains => &self.cornered,
            Part::Shadow | Part::Depth => &self.shadowed,
            Part::Surface(Coat::Corners, ..) => &self.cornered,
            Part::Smooth => &self.smoothing,
            _ => &self.indexed,
        };
        let targets = [Some(kind.part.target(format))];
        let (module, flag) = (&self.module, |on: bool| f64::from(u8::from(on)));
        let constants = [
            ("SHADOWS", flag(kind.shadows)),
            ("FILTERED", flag(kind.samples == Samples::Four)),
            ("AROUND", flag(kind.around)),
        ];
        let compilation = || wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() };
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(vertex),
            layout: Some(layout),
            vertex: wgpu::VertexState {
                module,
                entry_point: Some(vertex),
                compilation_options: compilation(),
                buffers: &buffers,
            },
            primitive: kind.part.primitive(),
            depth_stencil: kind.part.depth_stencil(),
            multisample: wgpu::MultisampleState { count: kind.samples.count(), ..Default::default() },
            fragment: fragment.map(|entry_point| wgpu::FragmentState {
                module,
                entry_point: Some(entry_point),
                compilation_options: compilation(),
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

impl Part {
    fn target(self, format: TextureFormat) -> wgpu::ColorTargetState {
        let blend = Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING).filter(|_| self != Self::Smooth);
        let write_mask = match self {
            Self::Surface(.., Pass::Depths) => wgpu::ColorWrites::empty(),
            _ => wgpu::ColorWrites::ALL,
        };
        wgpu::ColorTargetState { format, blend, write_mask }
    }

    fn primitive(self) -> wgpu::PrimitiveState {
        use wgpu::PrimitiveTopology::{TriangleList, TriangleStrip};
        let discs = matches!(self, Self::Markers | Self::HiddenMarkers | Self::Grains);
        let cull_mode = match self {
            Self::Surface(_, Side::Front, _) => Some(wgpu::Face::Back),
            Self::Surface(_, Side::Back, _) => Some(wgpu::Face::Front),
            _ => None,
        };
        let topology = if discs { TriangleStrip } else { TriangleList };
        wgpu::PrimitiveState { topology, cull_mode, ..Default::default() }
    }

    fn depth_stencil(self) -> Option<wgpu::DepthStencilState> {
        use wgpu::CompareFunction::{Always, Greater, Less, LessEqual};
        let (write, compare) = match self {
            Self::Smooth => return None,
            Self::Markers | Self::Grains | Self::Brush => (false, LessEqual),
            // Of surfaces in one place the first is seen, as on the processor: colors of translucent ones, too, hide those
            // of others.
            Self::Shadow | Self::Depth | Self::Surface(..) => (true, Less),
            Self::Backdrop | Self::Pictured => (false, Always),
            Self::HiddenMarkers => (false, Greater),
        };
        let (constant, slope_scale) = match self {
            Self::Shadow => (2, 1.5),
            // The surface under it was drawn by another shader, which may round otherwise.
            Self::Brush => (-2, -1.0),
            Self::Surface(_, side, pass) => {
                // What is translucent yields to a surface in the same place, and its fronts to its backs. Its colors lie
                // a little before its depths, which may be rounded otherwise.
                let steps: i16 = match (side, pass) {
                    (_, Pass::Whole) => 0,
                    (Side::Back, Pass::Colors) => 1,
                    (Side::Back, Pass::Depths) => 2,
                    (Side::Front, Pass::Colors) => 3,
                    (Side::Front, Pass::Depths) => 4,
                };
                (8 * i32::from(steps), f32::from(steps) / 512.0)
            }
            _ => (0, 0.0),
        };
        Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(write),
            depth_compare: Some(compare),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState { constant, slope_scale, clamp: 0.0 },
        })
    }
}
