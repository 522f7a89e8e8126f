//! What all synthesizers of one device share: the pipelines, and word of the device's loss.

use std::sync::{Arc, OnceLock};

use super::DeviceLoss;
use crate::SynthError;

/// Columns that one thread sums, multiples of 4: narrow for few columns, wide to read the basis seldom.
pub(super) const WIDTHS: [usize; 2] = [4, 12];

/// Storage buffers of the shader that has most.
const STORAGE_BUFFERS: u32 = 7;

/// Threads of a workgroup, in every shader.
pub(super) const WORKGROUP: u32 = 64;

/// A device made ready for synthesis. Cloning is cheap; make one per device.
#[derive(Clone, Debug)]
pub struct GpuContext {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pipelines: Arc<OnceLock<Pipelines>>,
    loss: DeviceLoss,
}

/// A compute pipeline with the layouts of its two groups.
#[derive(Debug)]
pub(super) struct Pipeline {
    pub pipeline: wgpu::ComputePipeline,
    pub groups: [wgpu::BindGroupLayout; 2],
}

#[derive(Debug)]
pub(super) struct Pipelines {
    /// One per entry of [`WIDTHS`].
    pub product: [Pipeline; WIDTHS.len()],
    pub place: Pipeline,
    pub normals: Pipeline,
}

impl GpuContext {
    /// A context. `loss` is the device's own, from whoever opened it. Whether the device can compute
    /// shows when a [`GpuSynthesizer`](crate::GpuSynthesizer) is made.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, loss: &DeviceLoss) -> Self {
        let pipelines = Arc::default();
        Self { device: device.clone(), queue: queue.clone(), pipelines, loss: loss.clone() }
    }

    /// The pipelines; the first call compiles them, so that nobody waits who uses the CPU.
    ///
    /// Fails if the device has no compute shaders of the size needed, or refuses ours.
    pub(super) fn pipelines(&self) -> Result<&Pipelines, SynthError> {
        if let Some(pipelines) = self.pipelines.get() {
            return Ok(pipelines);
        }
        let limits = self.device.limits();
        if limits.max_compute_invocations_per_workgroup < WORKGROUP
            || limits.max_storage_buffers_per_shader_stage < STORAGE_BUFFERS
        {
            return Err(SynthError::Device("it has no compute shaders of the size needed".into()));
        }
        let made = checked(&self.device, || Pipelines::new(&self.device))?;
        Ok(self.pipelines.get_or_init(|| made))
    }

    /// Why the device was lost; `None` while it is there.
    pub fn lost(&self) -> Option<&str> {
        self.loss.reason()
    }

    /// "NVIDIA GeForce RTX 4070 (Vulkan)", say.
    pub fn device_name(&self) -> String {
        let info = self.device.adapter_info();
        format!("{} ({})", info.name, info.backend)
    }

    /// Whether the device is a processor in disguise, on which the CPU backend is faster.
    pub fn is_software(&self) -> bool {
        self.device.adapter_info().device_type == wgpu::DeviceType::Cpu
    }

    pub(super) fn check_present(&self) -> Result<(), SynthError> {
        self.lost().map_or(Ok(()), |why| Err(SynthError::Device(format!("it was lost ({why})"))))
    }
}

/// Runs `make` and returns the errors that the device would otherwise panic with.
pub(super) fn checked<T>(device: &wgpu::Device, make: impl FnOnce() -> T) -> Result<T, SynthError> {
    let memory = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let validation = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let made = make();
    let errors = [pollster::block_on(validation.pop()), pollster::block_on(memory.pop())];
    match errors.into_iter().flatten().next() {
        Some(error) => Err(SynthError::Device(error.to_string())),
        None => Ok(made),
    }
}

/// How a shader sees a binding.
#[derive(Clone, Copy)]
enum Binding {
    Uniform,
    Read,
    Write,
}

impl Pipelines {
    fn new(device: &wgpu::Device) -> Self {
        use Binding::{Read, Uniform, Write};
        let product = WIDTHS.map(|width| {
            let source = format!("const WIDTH = {width}u;\n{}", include_str!("shaders/product.wgsl"));
            pipeline(device, "product", source, [&[Read, Uniform], &[Uniform, Read, Read, Write]])
        });
        let source = include_str!("shaders/place.wgsl").to_owned();
        let place =
            pipeline(device, "place", source, [&[Uniform, Read, Read], &[Read, Read, Read, Read, Write]]);
        let source = include_str!("shaders/normals.wgsl").to_owned();
        let normals =
            pipeline(device, "gather", source, [&[Uniform, Read, Read, Read], &[Uniform, Read, Write]]);
        Self { product, place, normals }
    }
}

fn pipeline(device: &wgpu::Device, entry: &str, source: String, groups: [&[Binding]; 2]) -> Pipeline {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(entry),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let groups = groups.map(|bindings| {
        let entries: Vec<_> =
            (0..).zip(bindings).map(|(binding, kind)| layout_entry(binding, *kind)).collect();
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(entry),
            entries: &entries,
        })
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(entry),
        bind_group_layouts: &[Some(&groups[0]), Some(&groups[1])],
        immediate_size: 0,
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry),
        layout: Some(&layout),
        module: &module,
        entry_point: Some(entry),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    Pipeline { pipeline, groups }
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

/// A bind group of whole buffers, bound in order.
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
