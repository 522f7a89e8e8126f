//! Shapes in, picture out, in one call.

use std::collections::HashMap;

use chladni_task::Task;
use glam::Vec3;

use crate::film::shoot;
use crate::{
    Background, Camera, Canvas, Cell, Device, Figure, Film, ItemBuffers, Lights, Marker, Material, Paint,
    Picture, Rect, Renderer, Scale, Skin, Topology, Turntable, VertexPaint, ViewError, Wire, framing, layout,
    srgb_bytes,
};

/// One shape to be drawn, each in a cell of its own.
#[derive(Clone, Copy, Debug, Default)]
pub struct PictureShape<'a> {
    /// Positions, in any units.
    pub positions: &'a [[f32; 3]],
    /// Triangles of vertex indices.
    pub triangles: &'a [[u32; 3]],
    /// One per vertex; computed from the triangles where there are none.
    pub normals: Option<&'a [[f32; 3]]>,
    /// A heat map, one number a vertex.
    pub values: Option<(&'a [f32], Scale)>,
    /// Linear-light RGBA a vertex; a heat map goes before it.
    pub colors: Option<&'a [[f32; 4]]>,
    /// An image, and where each triangle's corners lie on it, v upward; a heat map and colors go before it.
    pub image: Option<(&'a Picture, &'a [[f32; 2]])>,
    /// Landmarks.
    pub markers: &'a [Marker],
    /// Where the same vertices lie on another shape, which is drawn over this one as a ghost. Cameras that are fitted to the
    /// shapes make no room for it.
    pub ghost: Option<&'a [[f32; 3]]>,
}

/// How a picture looks.
#[derive(Clone, Copy, Debug, Default)]
pub struct Style {
    /// The material of the shapes.
    pub material: Material,
    /// The lights.
    pub lights: Lights,
    /// The background.
    pub background: Background,
    /// Edges over the surface.
    pub wire: Option<Wire>,
}

/// A picture to be drawn by [`render_picture`].
#[derive(Clone, Copy, Debug)]
pub struct PictureRequest<'a> {
    /// Each in its own cell, row by row.
    pub shapes: &'a [PictureShape<'a>],
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// From where it is seen, and which way is up. The eye comes as near as the format allows, at one
    /// scale for all shapes, so that their sizes can be compared.
    pub from: Camera,
    /// Materials, lights, background.
    pub style: Style,
}

/// Draws shapes side by side and waits for the picture. Makes a renderer each time: for
/// more than one picture use [`render_picture_with`] or a [`Renderer`] of your own.
///
/// # Errors
/// See [`ViewError`]: arrays that do not fit together, sizes the device cannot draw, a device
/// that fails.
pub fn render_picture(on: impl Into<Device>, request: &PictureRequest<'_>) -> Result<Picture, ViewError> {
    render_picture_with(&mut Renderer::new(on), request)
}

/// As [`render_picture`], with a renderer that was made before.
///
/// # Errors
/// See [`render_picture`].
pub fn render_picture_with(
    renderer: &mut Renderer,
    request: &PictureRequest<'_>,
) -> Result<Picture, ViewError> {
    let shapes: Vec<&[[f32; 3]]> = request.shapes.iter().map(|shape| shape.positions).collect();
    let area = Rect::of_size(request.width, request.height);
    let placed = framing::side_by_side(request.from, &shapes, area, framing::FILL);
    render_placed(renderer, request, &placed)
}

/// As [`render_picture_with`], each shape in the cell that is given for it and seen by its own camera.
///
/// # Errors
/// See [`render_picture`].
pub fn render_placed(
    renderer: &mut Renderer,
    request: &PictureRequest<'_>,
    placed: &[(Rect, Camera)],
) -> Result<Picture, ViewError> {
    let device = renderer.device().clone();
    let canvas = Canvas::new(&device, request.width, request.height)?;
    let loaded = load(&device, request)?;
    draw(renderer, &canvas, request, &loaded, placed)?;
    canvas.read(&device)
}

/// Films the shapes of `request` turning once around, and finishes the film; nothing leaves the frame
/// at any angle. Its samples are those of
/// [`Device::live_samples`].
///
/// # Errors
/// See [`render_picture`] and [`shoot`].
pub fn film_turntable(
    renderer: &mut Renderer,
    request: &PictureRequest<'_>,
    film: Film,
    task: &Task,
) -> Result<(), ViewError> {
    let device = renderer.device().clone();
    let canvas = Canvas::with_samples(&device, request.width, request.height, device.live_samples())?;
    let loaded = load(&device, request)?;
    let viewports = viewports(request);
    let points: Vec<[f32; 3]> = request.shapes.iter().flat_map(|s| s.positions).copied().collect();
    let aspect = layout::narrowest(&viewports);
    let turntable = Turntable::new(request.from, &points, aspect, film.settings().frames);
    shoot(renderer, &canvas, film, task, |renderer, canvas, frame| {
        let camera = turntable.at(frame);
        let placed: Vec<_> = viewports.iter().map(|cell| (*cell, camera)).collect();
        draw(renderer, canvas, request, &loaded, &placed)
    })
}

fn load(on: &Device, request: &PictureRequest<'_>) -> Result<Vec<Loaded>, ViewError> {
    request.shapes.iter().map(|shape| Loaded::new(on, shape)).collect()
}

/// The cells of a turntable, row by row.
fn viewports(request: &PictureRequest<'_>) -> Vec<Rect> {
    layout::arranged(Rect::of_size(request.width, request.height), request.shapes.len(), 0.85, 0)
}

fn draw(
    renderer: &mut Renderer,
    canvas: &Canvas,
    request: &PictureRequest<'_>,
    loaded: &[Loaded],
    placed: &[(Rect, Camera)],
) -> Result<(), ViewError> {
    let figures: Vec<Vec<Figure<'_>>> = loaded
        .iter()
        .map(|shape| {
            let figure = Figure {
                material: request.style.material,
                paint: shape.paint(),
                wire: request.style.wire,
                ..Figure::new(&shape.topology, &shape.buffers, 0)
            };
            let ghost = shape.has_ghost.then(|| Figure { item: 1, ..figure }.ghost());
            std::iter::once(figure).chain(ghost).collect()
        })
        .collect();
    let area = Rect::of_size(request.width, request.height);
    let (background, lights) = (request.style.background, request.style.lights);
    let shown = placed.iter().map(|(cell, _)| *cell).zip(figures.iter().flat_map(|f| f.first()));
    let mut cells = Cell::gallery(area, background, request.from, lights, shown);
    let drawn = request.shapes.iter().zip(&figures).zip(placed);
    for (cell, ((shape, figures), (_, camera))) in cells.iter_mut().skip(1).zip(drawn) {
        (cell.markers, cell.camera, cell.figures) = (shape.markers, *camera, figures);
    }
    renderer.draw(canvas, &cells)?;
    Ok(())
}

struct Loaded {
    topology: Topology,
    buffers: ItemBuffers,
    paint: Painted,
    /// It is the second item.
    has_ghost: bool,
}

enum Painted {
    Bare,
    Values(VertexPaint, Scale),
    Colors(VertexPaint),
    Image(Skin),
}

impl Loaded {
    fn new(on: &Device, shape: &PictureShape<'_>) -> Result<Self, ViewError> {
        let vertices = shape.positions.len();
        let topology = match shape.image {
            Some((_, corner_uvs)) => Topology::with_uvs(on, vertices, shape.triangles, corner_uvs)?,
            None => Topology::new(on, vertices, shape.triangles)?,
        };
        let buffers = ItemBuffers::new(on, vertices, 1 + usize::from(shape.ghost.is_some()));
        if let Some(ghost) = shape.ghost {
            buffers.write(on, 1, ghost, &smooth_normals(ghost, shape.triangles))?;
        }
        match shape.normals {
            Some(normals) => buffers.write(on, 0, shape.positions, normals)?,
            None => {
                let normals = smooth_normals(shape.positions, shape.triangles);
                buffers.write(on, 0, shape.positions, &normals)?;
            }
        }
        let paint = if let Some((values, scale)) = shape.values {
            let paint = VertexPaint::new(on, vertices);
            paint.write_values(on, values)?;
            Painted::Values(paint, scale)
        } else if let Some(colors) = shape.colors {
            let paint = VertexPaint::new(on, vertices);
            let bytes: Vec<[u8; 4]> = colors.iter().copied().map(srgb_bytes).collect();
            paint.write_colors(on, &bytes)?;
            Painted::Colors(paint)
        } else if let Some((picture, _)) = shape.image {
            Painted::Image(Skin::new(on, picture.width, picture.height, &picture.rgba)?)
        } else {
            Painted::Bare
        };
        Ok(Self { topology, buffers, paint, has_ghost: shape.ghost.is_some() })
    }

    fn paint(&self) -> Paint<'_> {
        match &self.paint {
            Painted::Values(values, scale) => Paint::Values(values, *scale),
            Painted::Colors(colors) => Paint::Colors(colors),
            Painted::Image(skin) => Paint::Skin(skin),
            Painted::Bare => Paint::Material,
        }
    }
}

/// Area-weighted vertex normals, the same for all vertices at one place, so that UV seams and
/// files without shared vertices are drawn smooth. Triangles with an index out of range are left
/// out; a vertex without area gets (0, 0, 0), which is drawn facing the viewer.
pub fn smooth_normals(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let mut first_at: HashMap<[u32; 3], u32> = HashMap::with_capacity(positions.len());
    // Adding zero makes −0 into 0, which is the same place.
    let welded: Vec<u32> = (0..)
        .zip(positions)
        .map(|(v, p)| *first_at.entry(p.map(|c| (c + 0.0).to_bits())).or_insert(v))
        .collect();
    let mut sums = vec![Vec3::ZERO; positions.len()];
    let at = |v: u32| positions.get(v as usize).copied().map(Vec3::from);
    for t in triangles {
        let (Some(a), Some(b), Some(c)) = (at(t[0]), at(t[1]), at(t[2])) else { continue };
        let twice_area = (b - a).cross(c - a);
        if twice_area.is_finite() {
            for v in t {
                sums[welded[*v as usize] as usize] += twice_area;
            }
        }
    }
    welded.iter().map(|v| sums[*v as usize].normalize_or_zero().to_array()).collect()
}
