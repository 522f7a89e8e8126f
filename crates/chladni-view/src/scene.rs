//! The scene: figures, their paint, and the cells they stand in.

use bytemuck::{Pod, Zeroable};

use crate::{
    Answer, Background, BrushRing, Camera, ItemBuffers, Lights, Material, Rect, RestShape, Scale, Skin,
    Topology, VertexPaint,
};

/// The source of a surface's color.
#[derive(Clone, Copy, Debug, Default)]
pub enum Paint<'a> {
    /// The material's own.
    #[default]
    Material,
    /// A heat map: one number a vertex through a color map.
    Values(&'a VertexPaint, Scale),
    /// One color a vertex.
    Colors(&'a VertexPaint),
    /// An image by the topology's corner UVs.
    Skin(&'a Skin),
    /// A palette, by how far each vertex is from where it rests.
    Answer(&'a RestShape, Answer),
}

/// Edges drawn over a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wire {
    /// sRGB.
    pub color: [u8; 3],
    /// In [0, 1].
    pub opacity: f32,
    /// Pixels on either side of the edge.
    pub width_px: f32,
}

impl Default for Wire {
    fn default() -> Self {
        Self { color: [20, 22, 28], opacity: 0.45, width_px: 0.7 }
    }
}

/// A grain of sand on a figure.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Grain {
    /// Vertices of the figure's item, and what share each has of the grain's place.
    pub corners: [u32; 3],
    /// They sum to 1.
    pub weights: [f32; 3],
    /// How high it is above the surface, along the normal, in the item's coordinates.
    pub lift: f32,
}

/// Grains on a figure: lit discs that move with its surface, on the side that its normals look to.
#[derive(Clone, Copy, Debug)]
pub struct Grains<'a> {
    /// In the order in which they are drawn.
    pub grains: &'a [Grain],
    /// In the item's coordinates.
    pub radius: f32,
    /// sRGB.
    pub color: [u8; 3],
}

/// One item in a cell.
#[derive(Clone, Copy, Debug)]
pub struct Figure<'a> {
    /// Triangles.
    pub topology: &'a Topology,
    /// Positions and normals.
    pub buffers: &'a ItemBuffers,
    /// Which item of the buffers.
    pub item: usize,
    /// Which item of the buffers is the rest, moved by what each vertex lags behind itself: how far it went lately. It
    /// tells palettes of speed; without one all stand still to them.
    pub lag: Option<usize>,
    /// From the item's coordinates to the scene's: a similarity, column-major.
    pub model: [[f32; 4]; 4],
    /// How it answers to light.
    pub material: Material,
    /// The source of its color.
    pub paint: Paint<'a>,
    /// 1 is opaque. Translucent figures are to be listed last.
    pub opacity: f32,
    /// Edges, where they are to be seen.
    pub wire: Option<Wire>,
    /// Brush ring, where there is one.
    pub brush: Option<&'a BrushRing>,
    /// Sand on it, where there is some. It is drawn after all figures of a cell.
    pub grains: Option<Grains<'a>>,
}

/// A similarity that changes nothing.
pub const IDENTITY: [[f32; 4]; 4] =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

impl<'a> Figure<'a> {
    /// Item `item` in the default material, where its coordinates say.
    pub fn new(topology: &'a Topology, buffers: &'a ItemBuffers, item: usize) -> Self {
        Self {
            topology,
            buffers,
            item,
            lag: None,
            model: IDENTITY,
            material: Material::CLAY,
            paint: Paint::Material,
            opacity: 1.0,
            wire: None,
            brush: None,
            grains: None,
        }
    }

    /// The same as a bluish ghost of itself, to be listed last.
    pub fn ghost(self) -> Self {
        let material = Material { color: [92, 146, 205], ..Material::CLAY };
        Self {
            material,
            paint: Paint::Material,
            opacity: 0.34,
            wire: None,
            brush: None,
            grains: None,
            ..self
        }
    }
}

/// A disc that faces the viewer: a landmark. Behind the surface it shows through faintly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Marker {
    /// In the scene.
    pub position: [f32; 3],
    /// Pixels.
    pub radius_px: f32,
    /// sRGB and opacity.
    pub color: [u8; 4],
}

impl Marker {
    /// The same for a picture with `by` times as many pixels in each direction.
    pub fn scaled(self, by: f32) -> Self {
        Self { radius_px: by * self.radius_px, ..self }
    }
}

/// One picture within the canvas.
#[derive(Clone, Copy, Debug)]
pub struct Cell<'a> {
    /// Where on the canvas, pixels.
    pub viewport: Rect,
    /// The viewer's camera.
    pub camera: Camera,
    /// The lights.
    pub lights: Lights,
    /// The background.
    pub background: Background,
    /// The figures.
    pub figures: &'a [Figure<'a>],
    /// Landmarks.
    pub markers: &'a [Marker],
}

impl<'a> Cell<'a> {
    /// Each of `figures` in its own viewport, before one `background` over `area`, so that no
    /// seams show; the background's cell comes first. No markers.
    pub fn gallery(
        area: Rect,
        background: Background,
        camera: Camera,
        lights: Lights,
        figures: impl IntoIterator<Item = (Rect, &'a Figure<'a>)>,
    ) -> Vec<Self> {
        let cell = |viewport, background, figures| Self {
            viewport,
            camera,
            lights,
            background,
            figures,
            markers: &[],
        };
        let mut cells = vec![cell(area, background, &[])];
        cells.extend(
            figures.into_iter().map(|(viewport, figure)| {
                cell(viewport, Background::TRANSPARENT, std::slice::from_ref(figure))
            }),
        );
        cells
    }
}
