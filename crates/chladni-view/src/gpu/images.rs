//! The images that every pipeline reads: color maps, the skin, and the key light's shadow maps.

use super::memory::image;
use super::pipelines::Layouts;
use super::screen::{DEPTH, depth_pass};
use crate::uniforms::arrangement;
use crate::{ColorMap, Gpu, Palette, Samples};

/// Textures and samplers of bind group 2.
pub(crate) struct Images {
    maps: wgpu::TextureView,
    map_sampler: wgpu::Sampler,
    skin_sampler: wgpu::Sampler,
    shadow_sampler: wgpu::Sampler,
    around_sampler: wgpu::Sampler,
    pub(crate) shadows: ShadowMaps,
    /// The panorama, where there is one.
    around: Option<wgpu::TextureView>,
    /// Without a skin.
    pub(crate) group: wgpu::BindGroup,
}

impl Images {
    pub(crate) fn new(gpu: &Gpu, layouts: &Layouts) -> Self {
        let device = &gpu.device;
        let sampler = |mode, anisotropy_clamp, compare| {
            device.create_sampler(&wgpu::SamplerDescriptor {
                address_mode_u: mode,
                address_mode_v: mode,
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter: wgpu::MipmapFilterMode::Linear,
                anisotropy_clamp,
                compare,
                ..Default::default()
            })
        };
        let (clamp, repeat) = (wgpu::AddressMode::ClampToEdge, wgpu::AddressMode::Repeat);
        let maps = map_texture(gpu);
        let map_sampler = sampler(clamp, 1, None);
        let skin_sampler = sampler(repeat, 4, None);
        let shadow_sampler = sampler(clamp, 1, Some(wgpu::CompareFunction::LessEqual));
        // Anisotropic filtering would be sharper than the level that the roughness chooses.
        let around_sampler = sampler(repeat, 1, None);
        let shadows = ShadowMaps::new(device, 1, 1, 1);
        let samplers = [&map_sampler, &skin_sampler, &shadow_sampler, &around_sampler];
        // Nothing samples the maps as a skin unless a figure has one.
        let group = group(device, layouts, [&maps; 3], &shadows, samplers);
        Self { maps, map_sampler, skin_sampler, shadow_sampler, around_sampler, shadows, around: None, group }
    }

    /// From now on this panorama shines, or none.
    pub(crate) fn surround(
        &mut self,
        device: &wgpu::Device,
        layouts: &Layouts,
        around: Option<wgpu::TextureView>,
    ) {
        self.around = around;
        self.group = self.group_with(device, layouts, &self.maps);
    }

    /// Whether there is one.
    pub(crate) fn is_surrounded(&self) -> bool {
        self.around.is_some()
    }

    /// The group of a figure that has a skin.
    pub(crate) fn group_with(
        &self,
        device: &wgpu::Device,
        layouts: &Layouts,
        skin: &wgpu::TextureView,
    ) -> wgpu::BindGroup {
        let samplers = [&self.map_sampler, &self.skin_sampler, &self.shadow_sampler, &self.around_sampler];
        let around = self.around.as_ref().unwrap_or(&self.maps);
        group(device, layouts, [&self.maps, skin, around], &self.shadows, samplers)
    }

    /// Sees to it that `count` cells can have shadows: one large map, or many smaller ones. Pictures of
    /// one sample a pixel have maps of a quarter of the texels, which a software device fills sooner.
    pub(crate) fn make_room(
        &mut self,
        device: &wgpu::Device,
        layouts: &Layouts,
        count: usize,
        samples: Samples,
    ) {
        if count == 0 {
            return;
        }
        let limit = device.limits().max_texture_dimension_2d;
        let (size, columns, rows) = arrangement(count as u32, samples, limit);
        let enough = self.shadows.columns == columns && self.shadows.rows >= rows;
        if self.shadows.size == size && enough {
            return;
        }
        self.shadows = ShadowMaps::new(device, size, columns, rows);
        self.group = self.group_with(device, layouts, &self.maps);
    }
}

/// Depth as the key light sees it, one square of a texture for each cell.
pub(crate) struct ShadowMaps {
    /// Texels of a side of one map.
    pub(crate) size: u32,
    columns: u32,
    rows: u32,
    view: wgpu::TextureView,
}

impl ShadowMaps {
    fn new(device: &wgpu::Device, size: u32, columns: u32, rows: u32) -> Self {
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("shadows"),
            size: wgpu::Extent3d { width: size * columns, height: size * rows, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: DEPTH,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        Self { size, columns, rows, view: texture.create_view(&wgpu::TextureViewDescriptor::default()) }
    }

    /// Upper left texel of the map with this index.
    pub(crate) fn corner(&self, index: u32) -> [u32; 2] {
        [index % self.columns * self.size, index / self.columns * self.size]
    }

    /// From the texels of all maps to texture coordinates.
    pub(crate) fn texel(&self) -> [f32; 2] {
        [self.columns, self.rows].map(|count| 1.0 / (count * self.size) as f32)
    }

    pub(crate) fn pass<'e>(&self, encoder: &'e mut wgpu::CommandEncoder) -> wgpu::RenderPass<'e> {
        depth_pass(encoder, "shadows", &self.view)
    }
}

fn group(
    device: &wgpu::Device,
    layouts: &Layouts,
    [maps, skin, around]: [&wgpu::TextureView; 3],
    shadows: &ShadowMaps,
    [map_sampler, skin_sampler, shadow_sampler, around_sampler]: [&wgpu::Sampler; 4],
) -> wgpu::BindGroup {
    let resources = [
        wgpu::BindingResource::TextureView(maps),
        wgpu::BindingResource::Sampler(map_sampler),
        wgpu::BindingResource::TextureView(skin),
        wgpu::BindingResource::Sampler(skin_sampler),
        wgpu::BindingResource::TextureView(&shadows.view),
        wgpu::BindingResource::Sampler(shadow_sampler),
        wgpu::BindingResource::TextureView(around),
        wgpu::BindingResource::Sampler(around_sampler),
    ];
    let entries: Vec<_> =
        (0..).zip(resources).map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("images"),
        layout: &layouts.images,
        entries: &entries,
    })
}

/// All color maps, then all palettes, one a row.
fn map_texture(gpu: &Gpu) -> wgpu::TextureView {
    let at = |i: u32| i as f32 / 255.0;
    let maps = ColorMap::ALL.iter().flat_map(|map| (0..256).map(move |i| map.color(at(i))));
    let palettes = Palette::ALL.iter().flat_map(|palette| (0..256).map(move |i| palette.color(at(i))));
    let pixels: Vec<u8> = maps.chain(palettes).flat_map(|[r, g, b]| [r, g, b, 255]).collect();
    let height = (ColorMap::ALL.len() + Palette::ALL.len()) as u32;
    image(gpu, "color maps", [256, height, 1], &pixels)
}
