//! Where vertex stages look up numbers by index: in storage, or, where a device lends them none (WebGL2), in textures.

use super::bindings::layout;

/// Texels in a row of such a texture.
pub(super) const ROW: u32 = 2048;

/// Where numbers are looked up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lookup {
    Storage,
    Textures,
}

impl Lookup {
    /// The look-up that suits devices with these limits.
    pub(crate) fn within(limits: &wgpu::Limits) -> Self {
        if limits.max_storage_buffers_per_shader_stage < 5 { Self::Textures } else { Self::Storage }
    }

    /// Its part of the shader.
    pub(super) fn shader(self) -> String {
        match self {
            Self::Storage => include_str!("shader/storage.wgsl").into(),
            Self::Textures => format!("const ROW = {ROW}u;\n{}", include_str!("shader/textures.wgsl")),
        }
    }

    /// The bind group that it reads: positions, normals, corners, UVs and paint.
    pub(super) fn layout(self, device: &wgpu::Device) -> wgpu::BindGroupLayout {
        let texture = |sample_type| wgpu::BindingType::Texture {
            sample_type,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let float = texture(wgpu::TextureSampleType::Float { filterable: false });
        let uint = texture(wgpu::TextureSampleType::Uint);
        let storage = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: true },
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let bindings = match self {
            Self::Storage => [storage; 5],
            Self::Textures => [float, float, uint, float, uint],
        };
        layout(device, "corners", &bindings.map(|binding| (wgpu::ShaderStages::VERTEX, binding)))
    }
}
