//! The images that every pipeline reads: color maps, the skin, and the key light's shadow maps.

use super::bindings;
use super::memory::image;
use super::screen::{DEPTH, depth_pass, texture, view};
use crate::uniforms::arrangement;
use crate::{ColorMap, Gpu, Palette, Samples};

/// The color maps and the samplers, which never change: made once on a device.
#[derive(Debug)]
pub(super) struct Common {
    maps: wgpu::TextureView,
    map_sampler: wgpu::Sampler,
    skin_sampler: wgpu::Sampler,
    shadow_sampler: wgpu::Sampler,
    around_sampler: wgpu::Sampler,
}

/// The images of bind group 2 that a renderer has for itself, and its groups.
pub(crate) struct Images {
    pub(crate) shadows: ShadowMaps,
    /// The panorama, where there is one.
    around: Option<wgpu::TextureView>,
    /// Without a skin.
    pub(crate) group: wgpu::BindGroup,
    /// Of the last picture's skins; made anew only where one of their images changes.
    skins: Vec<(wgpu::TextureView, wgpu::BindGroup)>,
}

impl Common {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let device = &gpu.device;
        let sampler = |[across, down]: [wgpu::AddressMode; 2], anisotropy_clamp, compare| {
            device.create_sampler(&wgpu::SamplerDescriptor {
                address_mode_u: across,
                address_mode_v: down,
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter: wgpu::MipmapFilterMode::Linear,
                anisotropy_clamp,
                compare,
                ..Default::default()
            })
        };
        let (clamp, repeat) = (wgpu::AddressMode::ClampToEdge, wgpu::AddressMode::Repeat);
        Self {
            maps: map_texture(gpu),
            map_sampler: sampler([clamp, clamp], 1, None),
            skin_sampler: sampler([repeat, repeat], 4, None),
            shadow_sampler: sampler([clamp, clamp], 1, Some(wgpu::CompareFunction::LessEqual)),
            // A panorama ends at its poles.
            // Anisotropic filtering would be sharper than the level that the roughness chooses.
            around_sampler: sampler([repeat, clamp], 1, None),
        }
    }
}

impl Images {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let shadows = ShadowMaps::new(&gpu.device, 1, 1, 1);
        let group = group(gpu, None, &shadows, None);
        Self { shadows, around: None, group, skins: Vec::new() }
    }

    /// From now on this panorama shines, or none.
    pub(crate) fn surround(&mut self, gpu: &Gpu, around: Option<wgpu::TextureView>) {
        self.around = around;
        self.regroup(gpu);
    }

    fn regroup(&mut self, gpu: &Gpu) {
        self.group = group(gpu, None, &self.shadows, self.around.as_ref());
        self.skins.clear();
    }

    /// Whether there is one.
    pub(crate) fn is_surrounded(&self) -> bool {
        self.around.is_some()
    }

    /// Sees to it that these skins have groups, and no others.
    pub(crate) fn hold<'s>(&mut self, gpu: &Gpu, skins: impl Iterator<Item = &'s wgpu::TextureView> + Clone) {
        self.skins.retain(|(held, _)| skins.clone().any(|skin| skin == held));
        for skin in skins {
            if self.group_of(skin).is_none() {
                let group = group(gpu, Some(skin), &self.shadows, self.around.as_ref());
                self.skins.push((skin.clone(), group));
            }
        }
    }

    /// The group of a figure that has this skin, which must be [held](Self::hold).
    pub(crate) fn group_of(&self, skin: &wgpu::TextureView) -> Option<&wgpu::BindGroup> {
        self.skins.iter().find(|(held, _)| held == skin).map(|(_, group)| group)
    }

    /// Sees to it that `count` cells can have shadows: one large map, or many smaller ones. Pictures of
    /// one sample a pixel have maps of a quarter of the texels, which a software device fills sooner.
    pub(crate) fn make_room(&mut self, gpu: &Gpu, count: usize, samples: Samples) {
        if count == 0 {
            return;
        }
        let limit = gpu.longest_side();
        let (size, columns, rows) = arrangement(count as u32, samples, limit);
        let enough = self.shadows.columns == columns && self.shadows.rows >= rows;
        if self.shadows.size == size && enough {
            return;
        }
        self.shadows = ShadowMaps::new(&gpu.device, size, columns, rows);
        self.regroup(gpu);
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
        let (sides, drawn) = ([size * columns, size * rows], wgpu::TextureUsages::RENDER_ATTACHMENT);
        let view = view(&texture(device, "shadows", sides, DEPTH, (1, drawn)));
        Self { size, columns, rows, view }
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
    gpu: &Gpu,
    skin: Option<&wgpu::TextureView>,
    shadows: &ShadowMaps,
    around: Option<&wgpu::TextureView>,
) -> wgpu::BindGroup {
    let drawing = gpu.drawing();
    let common = &drawing.common;
    // Nothing samples the maps as a skin or a panorama where there is none.
    let [skin, around] = [skin, around].map(|image| image.unwrap_or(&common.maps));
    let resources = [
        wgpu::BindingResource::TextureView(&common.maps),
        wgpu::BindingResource::Sampler(&common.map_sampler),
        wgpu::BindingResource::TextureView(skin),
        wgpu::BindingResource::Sampler(&common.skin_sampler),
        wgpu::BindingResource::TextureView(&shadows.view),
        wgpu::BindingResource::Sampler(&common.shadow_sampler),
        wgpu::BindingResource::TextureView(around),
        wgpu::BindingResource::Sampler(&common.around_sampler),
    ];
    bindings::group(&gpu.device, "images", &drawing.layouts.images, &resources)
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
