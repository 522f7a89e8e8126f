//! Data that vertex stages look up by index: in storage, or, where a device lends them none (WebGL2), in textures
//! that the same buffers are copied to before each picture.

use wgpu::{Buffer, Texture, TextureFormat};

use super::bindings::group;
use super::lookup::{Lookup, ROW};
use super::pipelines::Coat;
use super::screen::{texture, view};
use crate::{Cell, Figure, Paint, ViewError};

/// The bind groups of a picture's figures.
pub(crate) struct Corners {
    lookup: Lookup,
    layout: wgpu::BindGroupLayout,
    /// By figure; none of those that look nothing up.
    groups: Vec<Option<Group>>,
    /// The first of them hold numbers of this picture, those behind are left from others.
    sheets: Vec<Sheet>,
}

/// A bind group, kept for the figures of later pictures that look up the same.
struct Group {
    source: Source,
    group: wgpu::BindGroup,
}

/// Positions, normals, corners, UVs and paint.
#[derive(PartialEq)]
#[allow(clippy::large_enum_variant, reason = "there are as many as figures of one picture, all of one kind")]
enum Source {
    Storage([Buffer; 5]),
    Textures([Texture; 5]),
}

/// Numbers of a buffer in a texture.
struct Sheet {
    texture: Texture,
    /// Where they are from.
    source: Numbers,
}

/// A part of a buffer.
#[derive(Clone, PartialEq)]
struct Numbers {
    buffer: Buffer,
    format: TextureFormat,
    start: u64,
    count: u32,
}

impl Corners {
    /// `layout` is that of `lookup`.
    pub(crate) fn new(lookup: Lookup, layout: wgpu::BindGroupLayout) -> Self {
        Self { lookup, layout, groups: Vec::new(), sheets: Vec::new() }
    }

    /// The bind group of a figure, by its number in the picture.
    pub(crate) fn group(&self, figure: usize) -> Option<&wgpu::BindGroup> {
        self.groups.get(figure)?.as_ref().map(|group| &group.group)
    }

    /// Prepares the data that the figures of a picture look up.
    pub(crate) fn prepare(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        cells: &[Cell<'_>],
    ) -> Result<(), ViewError> {
        self.groups.resize_with(cells.iter().map(|cell| cell.figures.len()).sum(), || None);
        let mut filled = 0;
        for (i, figure) in cells.iter().flat_map(|cell| cell.figures).enumerate() {
            let looks_up = Coat::of(figure) == Coat::Corners || figure.grains.is_some();
            let source = if looks_up && figure.topology.triangles > 0 {
                Some(match self.lookup {
                    Lookup::Storage => storage(figure)?,
                    Lookup::Textures => self.textures(device, encoder, figure, &mut filled)?,
                })
            } else {
                None
            };
            if self.groups[i].as_ref().map(|group| &group.source) != source.as_ref() {
                let layout = &self.layout;
                self.groups[i] = source.map(|source| Group { group: source.group(device, layout), source });
            }
        }
        Ok(())
    }

    fn textures(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        figure: &Figure<'_>,
        filled: &mut usize,
    ) -> Result<Source, ViewError> {
        let (topology, items) = (figure.topology.held.gpu()?, figure.buffers.held.gpu()?);
        let item = figure.buffers.item_bytes(figure.item);
        let paint = paint(figure)?;
        // Grains read positions and normals only.
        let has_corners = Coat::of(figure) == Coat::Corners;
        let if_read = |is_read: bool, count: u64| if is_read { count as u32 } else { 1 };
        let numbers =
            |buffer: &Buffer, format, start, count| Numbers { buffer: buffer.clone(), format, start, count };
        let of_item =
            |buffer| numbers(buffer, TextureFormat::R32Float, item.start, 3 * figure.buffers.vertices as u32);
        let corners = if_read(has_corners, topology.corners.size() / 4);
        let uvs = if_read(has_corners, topology.uvs.size() / 8);
        let paints = if_read(has_corners && paint.is_some(), paint.map_or(0, Buffer::size) / 4);
        let sources = [
            of_item(&items.positions),
            of_item(&items.normals),
            numbers(&topology.corners, TextureFormat::R32Uint, 0, corners),
            numbers(&topology.uvs, TextureFormat::Rg32Float, 0, uvs),
            numbers(paint.unwrap_or(&topology.corners), TextureFormat::R32Uint, 0, paints),
        ];
        let mut sheets = [0; 5];
        for (sheet, numbers) in sheets.iter_mut().zip(sources) {
            *sheet = self.sheet(device, encoder, numbers, filled)?;
        }
        Ok(Source::Textures(sheets.map(|i| self.sheets[i].texture.clone())))
    }

    /// The index of a sheet of these numbers, filled unless this picture has it already.
    fn sheet(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        source: Numbers,
        filled: &mut usize,
    ) -> Result<usize, ViewError> {
        if let Some(there) = self.sheets[..*filled].iter().position(|sheet| sheet.source == source) {
            return Ok(there);
        }
        let index = *filled;
        let fits = |sheet: &Sheet| {
            sheet.texture.format() == source.format && sheet.texture.height() >= source.rows()
        };
        match self.sheets.get_mut(index).filter(|sheet| fits(sheet)) {
            Some(sheet) => sheet.source = source,
            None => {
                let texture = source.texture(device)?;
                self.sheets.truncate(index);
                self.sheets.push(Sheet { texture, source });
            }
        }
        *filled += 1;
        self.sheets[index].fill(encoder);
        Ok(index)
    }
}

fn storage(figure: &Figure<'_>) -> Result<Source, ViewError> {
    let (topology, items) = (figure.topology.held.gpu()?, figure.buffers.held.gpu()?);
    let paint = paint(figure)?.unwrap_or(&topology.corners);
    let buffers = [&items.positions, &items.normals, &topology.corners, &topology.uvs, paint];
    Ok(Source::Storage(buffers.map(Buffer::clone)))
}

impl Source {
    fn group(&self, device: &wgpu::Device, layout: &wgpu::BindGroupLayout) -> wgpu::BindGroup {
        match self {
            Self::Storage(buffers) => {
                group(device, "corners", layout, &buffers.each_ref().map(Buffer::as_entire_binding))
            }
            Self::Textures(textures) => {
                let views = textures.each_ref().map(view);
                group(device, "corners", layout, &views.each_ref().map(wgpu::BindingResource::TextureView))
            }
        }
    }
}

/// The buffer of a figure's paint by vertex, if it has one.
fn paint<'a>(figure: &Figure<'a>) -> Result<Option<&'a Buffer>, ViewError> {
    Ok(match figure.paint {
        Paint::Values(paint, _) | Paint::Colors(paint) => Some(paint.held.gpu()?),
        Paint::Answer(rest, _) => Some(rest.held.gpu()?),
        Paint::Material | Paint::Skin(_) => None,
    })
}

impl Numbers {
    fn rows(&self) -> u32 {
        self.count.div_ceil(ROW)
    }

    fn texture(&self, device: &wgpu::Device) -> Result<Texture, ViewError> {
        let (rows, limit) = (self.rows(), device.limits().max_texture_dimension_2d);
        if rows > limit {
            let (count, most) = (self.count, u64::from(limit) * u64::from(ROW));
            return Err(ViewError::Shape(format!(
                "{count} numbers of a shape where this graphics device has room for {most}"
            )));
        }
        let usage = wgpu::TextureUsages::COPY_DST;
        Ok(texture(device, "looked up", [ROW, rows], self.format, (1, usage)))
    }
}

impl Sheet {
    /// Queues the copy: whole rows, then the rest.
    fn fill(&self, encoder: &mut wgpu::CommandEncoder) {
        let Numbers { buffer, format, start, count } = &self.source;
        let bytes = u64::from(format.block_copy_size(None).unwrap_or(4));
        let (rows, rest) = (count / ROW, count % ROW);
        for (y, width, height) in [(0, ROW, rows), (rows, rest, 1)] {
            if width == 0 || height == 0 {
                continue;
            }
            let from = wgpu::TexelCopyBufferInfo {
                buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: start + bytes * u64::from(y * ROW),
                    bytes_per_row: Some(bytes as u32 * ROW),
                    rows_per_image: None,
                },
            };
            let mut to = self.texture.as_image_copy();
            to.origin.y = y;
            encoder.copy_buffer_to_texture(
                from,
                to,
                wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            );
        }
    }
}
