//! The GPU backend: three passes per frame, whose results stay on the device.

use bytemuck::{Pod, Zeroable, bytes_of, cast_slice};
use wgpu::BufferUsages as Usage;

use super::buffer::GrowingBuffer;
use super::checked::checked;
use super::context::{GpuContext, WORKGROUP};
use super::frame::{DeviceFrame, DeviceFrameBuffers};
use super::pipelines::bind;
use super::product::{BATCH, TILES, Tiles};
use super::shape::ShapeOnDevice;
use super::signals::{Signal, SignalPool};
use crate::plan::{Plan, columns_of};
use crate::{FrameSettings, Item, SynthError, SynthModel, Synthesizer};

/// Stands for "no signal" in place of the index of a signal's first scalar.
const NONE: u32 = u32::MAX;

/// The product shader computes with values of the basis that are larger by this factor.
const SHIFT: f64 = 65536.0;

/// `Frame` of product.wgsl.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct FrameUniform {
    harmonics: u32,
    active_harmonics: u32,
    padded_vertices: u32,
    padding: u32,
}

/// `Term` of place.wgsl.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct TermOnDevice {
    first_column: u32,
    channels: u32,
    residual_gain: f32,
    residual: u32,
    mask: u32,
}

/// The bind groups over the buffers that grow.
#[derive(Debug)]
struct FrameGroups {
    product: wgpu::BindGroup,
    place: wgpu::BindGroup,
    normals: wgpu::BindGroup,
}

/// The GPU backend. Each call submits its own commands; commands submitted to the same queue later see the
/// results.
#[derive(Debug)]
pub struct GpuSynthesizer {
    context: GpuContext,
    model: SynthModel,
    shape: ShapeOnDevice,
    plan: Plan,
    frame: DeviceFrameBuffers,
    frame_uniform: GrowingBuffer,
    blending: GrowingBuffer,
    active_harmonics: GrowingBuffer,
    coefficients: GrowingBuffer,
    columns: GrowingBuffer,
    items: GrowingBuffer,
    terms: GrowingBuffer,
    signals: SignalPool,
    /// Kept only to reuse its memory.
    active_list: Vec<u32>,
    item_list: Vec<[u32; 2]>,
    term_list: Vec<TermOnDevice>,
    scales: Vec<f64>,
    groups: Option<FrameGroups>,
}

impl GpuSynthesizer {
    /// Uploads the model: its packed basis, rest shape and rings.
    ///
    /// # Errors
    /// The device is lost, out of memory, or has limits that are too small.
    pub fn new(context: &GpuContext, model: SynthModel) -> Result<Self, SynthError> {
        // A software device has too few registers for the wide tiles, and it keeps the basis in its cache.
        let tiles = if context.is_software() { Tiles::Narrow } else { Tiles::Wide };
        Self::with_tiles(context, model, tiles)
    }

    /// The same as [`new`](Self::new), with a choice of the product's tiles.
    ///
    /// # Errors
    /// Those of [`new`](Self::new).
    pub fn with_tiles(context: &GpuContext, model: SynthModel, tiles: Tiles) -> Result<Self, SynthError> {
        context.check_present()?;
        let device = &context.device;
        let shape = checked(device, || ShapeOnDevice::new(context, &model))??;
        let storage = |label| GrowingBuffer::new(device, label, Usage::STORAGE | Usage::COPY_DST);
        let uniform = |label| GrowingBuffer::new(device, label, Usage::UNIFORM | Usage::COPY_DST);
        Ok(Self {
            scales: device_scales(&model),
            shape,
            model,
            plan: Plan::new(tiles.widths(), BATCH),
            frame: DeviceFrameBuffers::new(device),
            frame_uniform: uniform("frame"),
            blending: uniform("normal blending"),
            active_harmonics: storage("harmonics with weight"),
            coefficients: storage("coefficients"),
            columns: storage("columns"),
            items: storage("items"),
            terms: storage("terms"),
            signals: SignalPool::new(device),
            active_list: Vec::new(),
            item_list: Vec::new(),
            term_list: Vec::new(),
            groups: None,
            context: context.clone(),
        })
    }

    /// The last frame.
    pub fn frame(&self) -> DeviceFrame<'_> {
        self.frame.frame()
    }

    /// The device on which it runs.
    pub fn context(&self) -> &GpuContext {
        &self.context
    }

    /// Uploads the items. Returns whether a buffer was replaced.
    fn upload(&mut self, items: &[Item]) -> Result<bool, SynthError> {
        let mut replaced = self.upload_terms(items)?;
        let Self { plan, shape, model, active_list, .. } = self;
        active_list.clear();
        active_list.extend(&plan.active);
        // Padding has zero weight: any harmonic will do.
        active_list.resize(plan.rows, 0);
        let queue = &self.context.queue;
        let columns = 4 * (plan.columns() * shape.padded_vertices) as u64;
        let frame = FrameUniform {
            harmonics: model.harmonics() as u32,
            active_harmonics: plan.rows as u32,
            padded_vertices: shape.padded_vertices as u32,
            padding: 0,
        };
        replaced |= self.columns.reserve(columns)?;
        replaced |= self.frame.resize(items.len(), model.vertices())?;
        replaced |= self.frame_uniform.write(queue, bytes_of(&frame))?;
        replaced |= self.active_harmonics.write(queue, cast_slice(active_list))?;
        replaced |= self.coefficients.write(queue, cast_slice(&plan.coefficients))?;
        replaced |= self.items.write(queue, cast_slice(&self.item_list))?;
        replaced |= self.terms.write(queue, cast_slice(&self.term_list))?;
        Ok(replaced)
    }

    /// Uploads the items, and binds the buffers where one was replaced.
    fn upload_and_bind(&mut self, items: &[Item]) -> Result<(), SynthError> {
        if self.upload(items)? || self.groups.is_none() {
            self.groups = Some(self.bind_frame()?);
        }
        Ok(())
    }

    /// Lists items and terms in the layout of the shader, and uploads their signals. Returns whether a
    /// buffer was replaced.
    fn upload_terms(&mut self, items: &[Item]) -> Result<bool, SynthError> {
        let terms = || items.iter().flat_map(|item| &item.terms);
        self.signals.begin(terms().flat_map(|term| {
            let mask = term.mask.iter().map(|mask| Signal::Scalar(mask.clone()));
            mask.chain(term.residual.iter().map(Signal::from))
        }));
        self.item_list.clear();
        self.term_list.clear();
        let (mut replaced, mut column) = (false, 0);
        for item in items {
            self.item_list.push([self.term_list.len() as u32, item.terms.len() as u32]);
            for term in &item.terms {
                let mut place = |signal: Option<Signal>| match signal {
                    None => Ok(NONE),
                    Some(signal) => self.signals.place(&self.context.queue, signal).map(|(first, grown)| {
                        replaced |= grown;
                        first
                    }),
                };
                let residual = term.residual.as_ref().filter(|_| term.residual_gain != 0.0);
                self.term_list.push(TermOnDevice {
                    first_column: column,
                    channels: columns_of(term) as u32,
                    residual_gain: term.residual_gain,
                    residual: place(residual.map(Signal::from))?,
                    mask: place(term.mask.clone().map(Signal::Scalar))?,
                });
                column += columns_of(term) as u32;
            }
        }
        Ok(replaced)
    }

    fn bind_frame(&self) -> Result<FrameGroups, SynthError> {
        let (device, pipelines) = (&self.context.device, self.context.pipelines()?);
        let frame = self.frame.frame();
        let columns = self.columns.buffer();
        let product = [
            self.frame_uniform.buffer(),
            self.active_harmonics.buffer(),
            self.coefficients.buffer(),
            columns,
        ];
        let place =
            [self.items.buffer(), self.terms.buffer(), self.signals.buffer(), columns, frame.positions];
        let normals = [self.blending.buffer(), frame.positions, frame.normals];
        Ok(FrameGroups {
            product: bind(device, &pipelines.product.groups[1], &product),
            place: bind(device, &pipelines.place.groups[1], &place),
            normals: bind(device, &pipelines.normals.groups[1], &normals),
        })
    }

    fn submit(&self, encode: impl FnOnce(&mut wgpu::ComputePass<'_>)) {
        let GpuContext { device, queue, .. } = &self.context;
        let mut encoder =
            device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("synthesis") });
        encode(&mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default()));
        queue.submit([encoder.finish()]);
    }

    /// The number of workgroups for all vertices of all items.
    fn vertex_workgroups(&self) -> (u32, u32) {
        let frame = self.frame.frame();
        (frame.vertices.div_ceil(WORKGROUP), frame.items)
    }
}

/// The scales of the basis, divided by the factor that the shader leaves in its values.
fn device_scales(model: &SynthModel) -> Vec<f64> {
    model.basis.scales().iter().map(|scale| scale / SHIFT).collect()
}

impl Synthesizer for GpuSynthesizer {
    fn model(&self) -> &SynthModel {
        &self.model
    }

    fn replace_model(&mut self, model: SynthModel) -> Result<(), SynthError> {
        self.context.check_present()?;
        self.shape = checked(&self.context.device, || ShapeOnDevice::new(&self.context, &model))??;
        self.groups = None;
        self.scales = device_scales(&model);
        self.model = model;
        self.signals.clear();
        self.frame.resize(0, 0)?;
        Ok(())
    }

    fn items(&self) -> usize {
        self.frame.frame().items as usize
    }

    fn synthesize_positions(&mut self, items: &[Item]) -> Result<(), SynthError> {
        self.context.check_present()?;
        self.plan.lay_out(items, self.model.vertices(), &self.scales)?;
        let reach = self.context.device.limits().max_compute_workgroups_per_dimension;
        if items.len().max(self.plan.blocks) > reach as usize {
            return Err(SynthError::DeviceLimit {
                what: "number of items",
                needed: items.len() as u64,
                limit: u64::from(reach),
            });
        }
        let device = self.context.device.clone();
        let bound = checked(&device, || self.upload_and_bind(items));
        if !matches!(bound, Ok(Ok(()))) {
            // They may be of buffers for which there was no memory.
            self.groups = None;
        }
        bound??;
        let Some(groups) = &self.groups else { return Ok(()) };
        let pipelines = self.context.pipelines()?;
        let tile = TILES.iter().position(|tile| tile.columns == self.plan.width);
        let product = tile.map(|t| pipelines.product.tile(&self.context.device, t).map(|p| (&TILES[t], p)));
        let product = product.transpose()?;
        let (workgroups, items) = self.vertex_workgroups();
        self.submit(|pass| {
            if let Some((tile, pipeline)) = product {
                pass.set_pipeline(pipeline);
                pass.set_bind_group(1, &groups.product, &[]);
                for chunk in &self.shape.chunks {
                    pass.set_bind_group(0, &chunk.group, &[]);
                    pass.dispatch_workgroups(self.plan.blocks as u32, chunk.workgroups(tile), 1);
                }
            }
            pass.set_pipeline(&pipelines.place.pipeline);
            pass.set_bind_group(0, &self.shape.place, &[]);
            pass.set_bind_group(1, &groups.place, &[]);
            pass.dispatch_workgroups(workgroups, items, 1);
        });
        Ok(())
    }

    fn synthesize_normals(&mut self, settings: &FrameSettings) -> Result<(), SynthError> {
        settings.check()?;
        self.context.check_present()?;
        let blending = [settings.normal_blending, 0.0, 0.0, 0.0];
        self.blending.write(&self.context.queue, bytes_of(&blending))?;
        let Some(groups) = &self.groups else { return Ok(()) };
        let (workgroups, items) = self.vertex_workgroups();
        let pipelines = self.context.pipelines()?;
        self.submit(|pass| {
            pass.set_pipeline(&pipelines.normals.pipeline);
            pass.set_bind_group(0, &self.shape.normals, &[]);
            pass.set_bind_group(1, &groups.normals, &[]);
            pass.dispatch_workgroups(workgroups, items, 1);
        });
        Ok(())
    }
}
