//! The data of a model on the device.

use wgpu::BufferUsages as Usage;

use super::buffer::filled;
use super::context::{GpuContext, WORKGROUP};
use super::pipelines::bind;
use super::product::{TILES, Tile};
use crate::packed_basis::PANEL;
use crate::{SynthError, SynthModel};

/// The bind groups of a model, which keep its buffers alive.
#[derive(Debug)]
pub(super) struct ShapeOnDevice {
    pub chunks: Vec<Chunk>,
    pub place: wgpu::BindGroup,
    pub normals: wgpu::BindGroup,
    /// N, rounded up to whole panels.
    pub padded_vertices: usize,
}

/// As many panels of the basis as one binding can hold.
#[derive(Debug)]
pub(super) struct Chunk {
    pub group: wgpu::BindGroup,
    panels: usize,
}

impl ShapeOnDevice {
    pub fn new(context: &GpuContext, model: &SynthModel) -> Result<Self, SynthError> {
        let GpuContext { device, queue, .. } = context;
        let pipelines = context.pipelines()?;
        let limits = device.limits();
        let vertices = model.vertices();
        let reach = limits.max_compute_workgroups_per_dimension;
        if vertices.div_ceil(WORKGROUP as usize) > reach as usize {
            return Err(SynthError::DeviceLimit {
                what: "number of vertices",
                needed: vertices as u64,
                limit: u64::from(reach) * u64::from(WORKGROUP),
            });
        }
        let padded_vertices = model.basis.panels() * PANEL;
        let filled = |label, usage, content: &[u8]| filled(device, queue, label, usage, content);
        let shape: [u32; 4] = [vertices as u32, padded_vertices as u32, 0, 0];
        let shape = filled("shape", Usage::UNIFORM, bytemuck::bytes_of(&shape))?;
        let positions = bytemuck::cast_slice(&model.rest_positions);
        let rest_positions = filled("rest positions", Usage::STORAGE, positions)?;
        let normals = bytemuck::cast_slice(&model.rest_normals);
        let rest_normals = filled("rest normals", Usage::STORAGE, normals)?;
        let offsets = filled("rings", Usage::STORAGE, bytemuck::cast_slice(&model.rings.offsets))?;
        let pairs = filled("rings", Usage::STORAGE, bytemuck::cast_slice(&model.rings.pairs))?;
        Ok(Self {
            chunks: chunks(context, model)?,
            place: bind(device, &pipelines.place.groups[0], &[&shape, &rest_positions, &rest_normals]),
            normals: bind(device, &pipelines.normals.groups[0], &[&shape, &rest_normals, &offsets, &pairs]),
            padded_vertices,
        })
    }
}

impl Chunk {
    /// The number of workgroups that cover the vertices.
    pub fn workgroups(&self, tile: &Tile) -> u32 {
        (self.panels * tile.threads_per_panel()).div_ceil(WORKGROUP as usize) as u32
    }
}

fn chunks(context: &GpuContext, model: &SynthModel) -> Result<Vec<Chunk>, SynthError> {
    let GpuContext { device, queue, .. } = context;
    let pipelines = context.pipelines()?;
    let limits = device.limits();
    let panel_bytes = size_of::<crate::packed_basis::Line>() * model.harmonics().max(1);
    let binding = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
    let fit = usize::try_from(binding).unwrap_or(usize::MAX) / panel_bytes;
    let threads = limits.max_compute_workgroups_per_dimension as usize * WORKGROUP as usize;
    let reach = threads / TILES.iter().map(Tile::threads_per_panel).max().unwrap_or(1);
    let per_chunk = fit.min(reach);
    if per_chunk == 0 {
        let needed = panel_bytes as u64;
        return Err(SynthError::DeviceLimit { what: "basis of 32 vertices", needed, limit: binding });
    }
    let panels = model.basis.panels();
    (0..panels)
        .step_by(per_chunk)
        .map(|first| {
            let count = per_chunk.min(panels - first);
            let lines = bytemuck::cast_slice(model.basis.lines(first..first + count));
            let basis = filled(device, queue, "basis", Usage::STORAGE, lines)?;
            let about: [u32; 4] = [first as u32, count as u32, 0, 0];
            let about = filled(device, queue, "chunk", Usage::UNIFORM, bytemuck::bytes_of(&about))?;
            Ok(Chunk { group: bind(device, &pipelines.product.groups[0], &[&basis, &about]), panels: count })
        })
        .collect()
}
