//! Drawing on a graphics device.

mod depths;

use bytemuck::{Pod, Zeroable};

use super::canvas::Canvas;
use super::corners::Corners;
use super::finishing::Finishing;
use super::focus::{Depths, Focusing};
use super::grains::GrainBuffer;
use super::images::Images;
use super::pipelines::{Coat, Kind, MARKER_BYTES, Part, Pass, Side};
use super::uniforms::Uniforms;
use crate::uniforms::{
    CellUniform, FigureUniform, casts_shadows, cell_uniform, check_cell, check_figure, figure_uniform,
    key_light_view,
};
use crate::{Cell, Figure, Finish, Gpu, Paint, Samples, Surroundings, ViewError};

/// The uniforms and targets of pictures of one device and target format. Make one and keep it. Each pipeline is compiled
/// when a picture of any renderer needs it first, and kept with the device.
pub(crate) struct Renderer {
    gpu: Gpu,
    format: wgpu::TextureFormat,
    images: Images,
    cells: Uniforms<CellUniform>,
    figures: Uniforms<FigureUniform>,
    markers: wgpu::Buffer,
    marker_bytes: Vec<MarkerInstance>,
    /// None before the first picture that has a finish.
    finishing: Option<Finishing>,
    /// None before the first picture that is not sharp everywhere.
    focusing: Option<Focusing>,
    grains: GrainBuffer,
    corners: Corners,
    surroundings: Surroundings,
}

impl std::fmt::Debug for Renderer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Renderer").field("format", &self.format).finish_non_exhaustive()
    }
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct MarkerInstance {
    position: [f32; 3],
    radius: f32,
    color: [u8; 4],
}

impl Renderer {
    pub(crate) fn for_pictures(gpu: &Gpu) -> Self {
        Self::new(gpu, Canvas::FORMAT)
    }

    /// A renderer for canvases of one eight-bit format.
    pub(crate) fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        let device = &gpu.device;
        let layouts = &gpu.drawing().layouts;
        let corners = Corners::new(gpu.lookup(), layouts.corners.clone());
        let images = Images::new(gpu);
        let cells = Uniforms::new(device, &layouts.cell, "cells");
        let figures = Uniforms::new(device, &layouts.figure, "figures");
        let markers = marker_buffer(device, 64);
        Self {
            gpu: gpu.clone(),
            format,
            images,
            cells,
            figures,
            markers,
            marker_bytes: Vec::new(),
            finishing: None,
            focusing: None,
            grains: GrainBuffer::new(),
            corners,
            surroundings: Surroundings::default(),
        }
    }

    fn pipeline(&self, kind: Kind) -> wgpu::RenderPipeline {
        self.gpu.drawing().pipelines.get(&self.gpu.device, self.format, kind)
    }

    pub(crate) fn surround(&mut self, surroundings: &Surroundings) -> Result<(), ViewError> {
        for skin in surroundings.behind.iter().map(|(skin, _)| skin).chain(&surroundings.around) {
            skin.held.gpu()?;
        }
        self.surroundings = surroundings.clone();
        let around = surroundings.around.as_ref().map(|skin| skin.held.gpu().cloned()).transpose()?;
        self.images.surround(&self.gpu, around);
        Ok(())
    }

    /// Draws `cells` on `canvas` with a finish for a moment, and submits; does not wait.
    pub(crate) fn draw(
        &mut self,
        canvas: &Canvas,
        cells: &[Cell<'_>],
        (finish, at_secs): (&Finish, f64),
    ) -> Result<(), ViewError> {
        self.gpu.check()?;
        if canvas.format != self.format {
            let (wanted, found) = (self.format, canvas.format);
            return Err(ViewError::Shape(format!("a canvas of {found:?} for a renderer of {wanted:?}")));
        }
        self.prepare(canvas, cells)?;
        let device = self.gpu.device.clone();
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.corners.prepare(&device, &mut encoder, cells)?;
        self.draw_shadows(&mut encoder, cells)?;
        let mut finishing = self.finishing.take();
        let finished = !finish.is_nothing();
        if finished {
            Finishing::fit(&mut finishing, &self.gpu, canvas)?;
        }
        let bare = finishing.as_ref().filter(|_| finished).map(Finishing::bare);
        let bare = bare.unwrap_or(&canvas.finished_view);
        let mut kept = self.focusing.take();
        let mut focusing =
            (finish.blur > 0.0).then(|| Focusing::fit(&mut kept, &self.gpu, canvas)).transpose()?;
        let [mut depth, sharp] = focusing.as_deref().map_or([None; 2], |of| of.targets().map(Some));
        if let Some(seen) = depth.take_if(|_| Depths::on(&device, canvas.samples) == Depths::Fine) {
            self.draw_seen_depths(&mut encoder, seen, cells)?;
        }
        let target = sharp.unwrap_or(bare);
        self.draw_cells(&mut encoder, canvas, (target, depth), cells)?;
        if let Some((rough, mut pass)) = canvas.smoothing(&mut encoder, target) {
            pass.set_pipeline(&self.pipeline(Kind::new(Part::Smooth, Samples::One)));
            pass.set_bind_group(0, rough, &[]);
            pass.draw(0..3, 0..1);
        }
        if let Some(focusing) = &mut focusing {
            focusing.draw(&self.gpu, &mut encoder, (finish, cells), bare);
        }
        self.focusing = kept;
        match &mut finishing {
            Some(finishing) if finished => {
                finishing.draw(&self.gpu, &mut encoder, canvas, finish, at_secs);
            }
            Some(finishing) => finishing.forget(),
            None => {}
        }
        self.finishing = finishing;
        self.gpu.queue.submit([encoder.finish()]);
        Ok(())
    }

    fn draw_cells(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        canvas: &Canvas,
        (target, depth): (&wgpu::TextureView, Option<&wgpu::TextureView>),
        cells: &[Cell<'_>],
    ) -> Result<(), ViewError> {
        let samples = canvas.samples;
        let behind = self.surroundings.behind.as_ref().map(|(skin, _)| skin.held.gpu()).transpose()?;
        let mut pass = canvas.pass(encoder, target, depth);
        let (mut figure_index, mut first_marker, mut first_grain) = (0, 0, 0);
        for (cell_index, cell) in cells.iter().enumerate() {
            let r = cell.viewport;
            pass.set_viewport(r.x as f32, r.y as f32, r.width as f32, r.height as f32, 0.0, 1.0);
            pass.set_scissor_rect(r.x, r.y, r.width, r.height);
            pass.set_bind_group(0, &self.cells.group, &[self.cells.offset(cell_index)]);
            pass.set_bind_group(1, &self.figures.group, &[0]);
            pass.set_bind_group(2, &self.images.group, &[]);
            if let Some(behind) = behind.filter(|_| cell.background.opacity > 0.0) {
                pass.set_bind_group(2, self.images.group_of(behind), &[]);
                pass.set_pipeline(&self.pipeline(Kind::new(Part::Pictured, samples)));
                pass.draw(0..3, 0..1);
                pass.set_bind_group(2, &self.images.group, &[]);
            } else if cell.background.opacity > 0.0 {
                pass.set_pipeline(&self.pipeline(Kind::new(Part::Backdrop, samples)));
                pass.draw(0..3, 0..1);
            }
            for figure in cell.figures {
                pass.set_bind_group(1, &self.figures.group, &[self.figures.offset(figure_index)]);
                self.draw_figure(&mut pass, (figure, figure_index), samples, casts_shadows(cell))?;
                figure_index += 1;
            }
            for (i, figure) in cell.figures.iter().enumerate() {
                let Some(of) = figure.grains else { continue };
                let grains = self.grains.slice(first_grain, of.grains.len() as u64);
                first_grain += of.grains.len() as u64;
                if let Some(grains) = grains.filter(|_| figure.topology.triangles > 0) {
                    let shadows = casts_shadows(cell);
                    let kind = Kind { shadows, ..Kind::new(Part::Grains, samples) };
                    let index = figure_index - cell.figures.len() + i;
                    pass.set_bind_group(1, &self.figures.group, &[self.figures.offset(index)]);
                    self.bind_corners(&mut pass, figure, index)?;
                    pass.set_bind_group(2, &self.images.group, &[]);
                    pass.set_vertex_buffer(0, grains);
                    pass.set_pipeline(&self.pipeline(kind));
                    pass.draw(0..4, 0..of.grains.len() as u32);
                }
            }
            if !cell.markers.is_empty() {
                let markers = first_marker..first_marker + cell.markers.len() as u32;
                pass.set_vertex_buffer(0, self.markers.slice(..));
                for part in [Part::HiddenMarkers, Part::Markers] {
                    pass.set_pipeline(&self.pipeline(Kind::new(part, samples)));
                    pass.draw(0..4, markers.clone());
                }
                first_marker = markers.end;
            }
        }
        // wgpu's GL resolves samples only within the last cell's scissors.
        pass.set_scissor_rect(0, 0, canvas.width, canvas.height);
        Ok(())
    }

    fn draw_figure(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        (figure, index): (&Figure<'_>, usize),
        samples: Samples,
        shadows: bool,
    ) -> Result<(), ViewError> {
        let (topology, buffers) = (figure.topology.held.gpu()?, figure.buffers.held.gpu()?);
        let corners = 3 * figure.topology.triangles as u32;
        // No part of a buffer may be empty.
        if corners == 0 {
            return Ok(());
        }
        let coat = Coat::of(figure);
        if coat == Coat::Corners {
            self.bind_corners(pass, figure, index)?;
        } else {
            let item = figure.buffers.item_bytes(figure.item);
            pass.set_vertex_buffer(0, buffers.positions.slice(item.clone()));
            pass.set_vertex_buffer(1, buffers.normals.slice(item));
            if let Paint::Values(paint, _) | Paint::Colors(paint) = figure.paint {
                pass.set_vertex_buffer(2, paint.held.gpu()?.slice(..));
            }
            if let Paint::Answer(rest, _) = figure.paint {
                pass.set_vertex_buffer(2, rest.held.gpu()?.slice(..));
            }
            if coat == Coat::Figured {
                // Without a lag, the buffer bound there has no effect.
                let lag = figure.buffers.item_bytes(figure.lag.unwrap_or(figure.item));
                pass.set_vertex_buffer(3, buffers.positions.slice(lag));
            }
            pass.set_index_buffer(topology.indices.slice(..), wgpu::IndexFormat::Uint32);
        }
        let part = |side| passes(figure).iter().map(move |pass| Part::Surface(coat, side, *pass));
        for part in sides(figure).into_iter().flat_map(part) {
            let kind = Kind { part, samples, shadows, around: self.images.is_surrounded() };
            pass.set_pipeline(&self.pipeline(kind));
            if coat == Coat::Corners {
                pass.draw(0..corners, 0..1);
            } else {
                pass.draw_indexed(0..corners, 0, 0..1);
            }
        }
        if coat == Coat::Corners {
            pass.set_bind_group(2, &self.images.group, &[]);
        }
        if let Some(ring) = figure.brush.filter(|ring| ring.corners > 0) {
            pass.set_pipeline(&self.pipeline(Kind::new(Part::Brush, samples)));
            pass.set_vertex_buffer(0, buffers.positions.slice(figure.buffers.item_bytes(figure.item)));
            pass.set_vertex_buffer(1, ring.reach.held.gpu()?.slice(..));
            pass.set_index_buffer(ring.triangles.gpu()?.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..ring.corners, 0, 0..1);
        }
        Ok(())
    }

    /// Binds the data that wires, skins and grains look up.
    fn bind_corners(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        figure: &Figure<'_>,
        index: usize,
    ) -> Result<(), ViewError> {
        pass.set_bind_group(3, self.corners.group(index), &[]);
        if let Paint::Skin(skin) = figure.paint {
            pass.set_bind_group(2, self.images.group_of(skin.held.gpu()?), &[]);
        }
        Ok(())
    }

    /// Checks the scene and queues its uniforms.
    fn prepare(&mut self, canvas: &Canvas, cells: &[Cell<'_>]) -> Result<(), ViewError> {
        self.cells.clear();
        self.figures.clear();
        self.marker_bytes.clear();
        let shadowed = cells.iter().filter(|cell| casts_shadows(cell)).count();
        self.images.make_room(&self.gpu, shadowed, canvas.samples);
        let behind = self.surroundings.behind.iter().map(|(skin, _)| skin);
        let worn = cells.iter().flat_map(|cell| cell.figures).filter_map(|figure| match figure.paint {
            Paint::Skin(skin) => Some(skin),
            _ => None,
        });
        // Skins of another device are refused where they are drawn.
        self.images.hold(&self.gpu, behind.chain(worn).filter_map(|skin| skin.held.gpu().ok()));
        let mut map = 0;
        for cell in cells {
            check_cell(cell, canvas.width, canvas.height)?;
            let mut uniform = cell_uniform(cell, !self.format.is_srgb(), &self.surroundings);
            if casts_shadows(cell) {
                let maps = &self.images.shadows;
                (uniform.shadow, uniform.shadow_map) = key_light_view(cell, maps.size);
                let ([x, y], [width, height]) = (maps.corner(map).map(|c| c as f32), maps.texel());
                uniform.shadow_place = [x, y, width, height];
                map += 1;
            }
            self.cells.push(&uniform);
            for figure in cell.figures {
                check_figure(figure)?;
                self.figures.push(&figure_uniform(figure));
            }
            self.marker_bytes.extend(cell.markers.iter().map(|marker| MarkerInstance {
                position: marker.position,
                radius: marker.radius_px,
                color: marker.color,
            }));
        }
        // The backdrop binds a figure even where there is none.
        if self.figures.bytes.is_empty() {
            self.figures.push(&FigureUniform::zeroed());
        }
        let (Gpu { device, queue, .. }, layouts) = (&self.gpu, &self.gpu.drawing().layouts);
        self.cells.upload(device, queue, &layouts.cell);
        self.figures.upload(device, queue, &layouts.figure);
        self.grains.upload(&self.gpu, cells);
        if !self.marker_bytes.is_empty() {
            let count = self.marker_bytes.len() as u64;
            if self.markers.size() < count * MARKER_BYTES {
                self.markers = marker_buffer(device, count.next_power_of_two());
            }
            queue.write_buffer(&self.markers, 0, bytemuck::cast_slice(&self.marker_bytes));
        }
        Ok(())
    }
}

/// The sides of a figure in the order in which they are drawn. Of a closed shape, too: a file may hold it
/// inside out, and a large deformation turns it over.
fn sides(figure: &Figure<'_>) -> [Side; 2] {
    if figure.opacity < 1.0 { [Side::Back, Side::Front] } else { [Side::Front, Side::Back] }
}

/// The passes in which one of them is drawn.
fn passes(figure: &Figure<'_>) -> &'static [Pass] {
    if figure.opacity < 1.0 { &[Pass::Depths, Pass::Colors] } else { &[Pass::Whole] }
}

fn marker_buffer(device: &wgpu::Device, count: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("markers"),
        size: count * MARKER_BYTES,
        usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Background, Camera, ItemBuffers, Lights, Rect, Skin, Topology};

    /// `None` where this machine cannot draw at all.
    fn gpu() -> Option<Gpu> {
        match Gpu::headless() {
            Err(ViewError::NoAdapter(reason)) => {
                eprintln!("skipped: no graphics adapter ({reason})");
                None
            }
            gpu => Some(gpu.unwrap()),
        }
    }

    #[test]
    fn renderers_and_synthesizers_of_a_device_share_pipelines() {
        let Some(gpu) = gpu() else { return };
        let clone = gpu.clone();
        let [one, other] = [&gpu, &clone].map(Renderer::for_pictures);
        let kind = |samples| Kind::new(Part::Backdrop, samples);
        assert_eq!(one.pipeline(kind(Samples::One)), other.pipeline(kind(Samples::One)));
        assert_ne!(one.pipeline(kind(Samples::One)), other.pipeline(kind(Samples::Four)));
        assert!(std::ptr::eq(gpu.synthesis(), clone.synthesis()));
    }

    #[test]
    fn bind_groups_are_made_anew_only_if_what_they_bind_changes() {
        let Some(gpu) = gpu() else { return };
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let topology = Topology::with_uvs(&gpu, 3, &[[0, 1, 2]], &corners.map(|[x, y, _]| [x, y])).unwrap();
        let buffers = ItemBuffers::new(&gpu, 3, 1);
        buffers.write(&gpu, 0, &corners, &[[0.0, 0.0, 1.0]; 3]).unwrap();
        let [skin, another] = [0, 255].map(|gray| Skin::new(&gpu, 1, 1, &[gray; 4]).unwrap());
        let canvas = Canvas::for_pictures(&gpu, 16, 16, Samples::One).unwrap();
        let mut renderer = Renderer::for_pictures(&gpu);
        let mut groups = |skin: &Skin, shadow: f32| {
            let figure = Figure { paint: Paint::Skin(skin), ..Figure::new(&topology, &buffers, 0) };
            let cell = Cell {
                viewport: Rect::of_size(16, 16),
                camera: Camera::default(),
                lights: Lights { shadow, ..Lights::default() },
                background: Background::TRANSPARENT,
                figures: &[figure],
                markers: &[],
            };
            renderer.draw(&canvas, &[cell], (&Finish::NOTHING, 0.0)).unwrap();
            let of_skin = renderer.images.group_of(skin.held.gpu().unwrap());
            [of_skin, renderer.corners.group(0)].map(|group| group.unwrap().clone())
        };
        let first = groups(&skin, 0.0);
        assert_eq!(groups(&skin, 0.0), first);
        let other = groups(&another, 0.0);
        assert!(other[0] != first[0] && other[1] == first[1], "another skin");
        let shadowed = groups(&another, 1.0);
        assert!(shadowed[0] != other[0] && shadowed[1] == other[1], "room for shadows");
        assert_eq!(groups(&another, 1.0), shadowed);
        gpu.check().unwrap();
    }
}
