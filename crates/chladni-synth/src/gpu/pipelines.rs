//! The compute pipelines of the shaders, and the layouts of their bindings.

use std::sync::OnceLock;

use super::checked::checked;
use super::product::TILES;
use crate::SynthError;

#[derive(Debug)]
pub(super) struct Pipelines {
    pub product: Product,
    pub place: Pipeline,
    pub normals: Pipeline,
}

/// A compute pipeline with the layouts of its two groups.
#[derive(Debug)]
pub(super) struct Pipeline {
    pub pipeline: wgpu::ComputePipeline,
    pub groups: [wgpu::BindGroupLayout; 2],
}

/// The pipelines of the product, one for each entry of [`TILES`]. Each is compiled when a frame first needs
/// it.
#[derive(Debug)]
pub(super) struct Product {
    pub groups: [wgpu::BindGroupLayout; 2],
    layout: wgpu::PipelineLayout,
    tiles: [OnceLock<wgpu::ComputePipeline>; TILES.len()],
}

impl Product {
    /// The pipeline for entry `index` of [`TILES`].
    pub fn tile(&self, device: &wgpu::Device, index: usize) -> Result<&wgpu::ComputePipeline, SynthError> {
        let (tile, pipeline) = (&TILES[index], &self.tiles[index]);
        if let Some(pipeline) = pipeline.get() {
            return Ok(pipeline);
        }
        let made = checked(device, || compiled(device, "product", &tile.source(), &self.layout))?;
        Ok(pipeline.get_or_init(|| made))
    }
}

/// How a shader accesses a binding.
#[derive(Clone, Copy)]
enum Binding {
    Uniform,
    Read,
    Write,
}

impl Pipelines {
    pub fn new(device: &wgpu::Device) -> Self {
        use Binding::{Read, Uniform, Write};
        let (groups, layout) = layouts(device, "product", [&[Read, Uniform], &[Uniform, Read, Read, Write]]);
        let place = include_str!("shaders/place.wgsl");
        let normals = include_str!("shaders/normals.wgsl");
        Self {
            product: Product { groups, layout, tiles: Default::default() },
            place: pipeline(
                device,
                "place",
                place,
                [&[Uniform, Read, Read], &[Read, Read, Read, Read, Write]],
            ),
            normals: pipeline(
                device,
                "gather",
                normals,
                [&[Uniform, Read, Read, Read], &[Uniform, Read, Write]],
            ),
        }
    }
}

fn pipeline(device: &wgpu::Device, entry: &str, source: &str, groups: [&[Binding]; 2]) -> Pipeline {
    let (groups, layout) = layouts(device, entry, groups);
    Pipeline { pipeline: compiled(device, entry, source, &layout), groups }
}

fn layouts(
    device: &wgpu::Device,
    label: &str,
    groups: [&[Binding]; 2],
) -> ([wgpu::BindGroupLayout; 2], wgpu::PipelineLayout) {
    let groups = groups.map(|bindings| {
        let entries: Vec<_> =
            (0..).zip(bindings).map(|(binding, kind)| layout_entry(binding, *kind)).collect();
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(label),
            entries: &entries,
        })
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(label),
        bind_group_layouts: &[Some(&groups[0]), Some(&groups[1])],
        immediate_size: 0,
    });
    (groups, layout)
}

fn compiled(
    device: &wgpu::Device,
    entry: &str,
    source: &str,
    layout: &wgpu::PipelineLayout,
) -> wgpu::ComputePipeline {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(entry),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry),
        layout: Some(layout),
        module: &module,
        entry_point: Some(entry),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    })
}

fn layout_entry(binding: u32, kind: Binding) -> wgpu::BindGroupLayoutEntry {
    let ty = match kind {
        Binding::Uniform => wgpu::BufferBindingType::Uniform,
        Binding::Read => wgpu::BufferBindingType::Storage { read_only: true },
        Binding::Write => wgpu::BufferBindingType::Storage { read_only: false },
    };
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    }
}

/// A bind group of whole buffers, in the order of their bindings.
pub(super) fn bind(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    buffers: &[&wgpu::Buffer],
) -> wgpu::BindGroup {
    let entries: Vec<_> = (0..)
        .zip(buffers)
        .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}
