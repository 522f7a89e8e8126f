//! The picture of a sitting: one figure, or some beside each other.

mod lineup;

use std::sync::Arc;

use chladni_caricature::{Base, Reach, Surface};
use chladni_harmonics::Body;
use chladni_mesh::Orientation;
use chladni_mesh::surface::vec3::single;
use chladni_program::work::{Coating, Error, MARKED, OwnLook, OwnPaint, PAINTED, RING, lay_ring, tints};
use chladni_view::{
    Background, BrushRing, Camera, Canvas, Cell, Device, Figure, Hit, ItemBuffers, Lights, Marker, Material,
    Paint, PickTree, Picture, Rect, Renderer, Scale, Topology, VertexPaint, View,
};

use self::lineup::Lineup;
use crate::screen::{Screen, device};

/// The figure's share of the picture's sides.
const FILL: f32 = 0.86;

/// The renderer, its last picture, and the camera.
pub struct Stage {
    pub camera: Camera,
    triangles: Arc<[[u32; 3]]>,
    /// The look that the shape's file brought along.
    look: Option<OwnLook>,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    model: Dressed,
    /// Figures in the place of it.
    lineup: Option<Lineup>,
    renderer: Renderer,
    screen: Screen,
    pick: Option<PickTree>,
    /// How often the figure has changed.
    changes: u64,
    /// The picture on screen is out of date.
    stale: bool,
    /// The whole figure is to be seen.
    fitted: bool,
    /// The viewer was moved since: the figure may leave the picture.
    by_hand: bool,
}

/// The shape as renderers have it, with its colors.
struct Dressed {
    topology: Topology,
    buffers: ItemBuffers,
    /// The numbers of a heat map.
    values: VertexPaint,
    /// Regions, marks and places.
    tints: VertexPaint,
    coating: Coating,
    /// The colors that the shape brought along.
    own: Option<OwnPaint>,
    ring: BrushRing,
}

impl Dressed {
    fn figure(&self) -> Figure<'_> {
        self.figure_in(&self.buffers, 0)
    }

    /// Another pose of it, in the same colors.
    fn figure_in<'a>(&'a self, buffers: &'a ItemBuffers, item: usize) -> Figure<'a> {
        let paint = match (&self.coating, &self.own) {
            (Coating::Values(_, scale), _) => Paint::Values(&self.values, *scale),
            (Coating::Region(_) | Coating::Marks(_) | Coating::Colors(_), _) => Paint::Colors(&self.tints),
            (Coating::Own, Some(own)) => own.paint(),
            (Coating::Own, None) | (Coating::Material, _) => Paint::Material,
        };
        Figure { paint, ..Figure::new(&self.topology, buffers, item) }
    }
}

impl Dressed {
    /// A shape of these positions and normals, for a device.
    fn new(
        device: &Device,
        (positions, normals): (&[[f32; 3]], &[[f32; 3]]),
        triangles: &[[u32; 3]],
        look: Option<&OwnLook>,
    ) -> Result<Self, Error> {
        let n = positions.len();
        let topology = OwnLook::topology(look, device, n, triangles)?;
        let own = look.map(|look| OwnPaint::on(device, look)).transpose()?;
        let buffers = ItemBuffers::new(device, n, 1);
        buffers.write(device, 0, positions, normals)?;
        let (values, tints) = (VertexPaint::new(device, n), VertexPaint::new(device, n));
        let ring = BrushRing::new(device, n, RING);
        Ok(Self { topology, buffers, values, tints, coating: Coating::Own, own, ring })
    }

    fn coat(&mut self, device: &Device, coating: Coating) -> Result<(), Error> {
        match &coating {
            Coating::Material | Coating::Own => {}
            Coating::Values(values, _) => self.values.write_values(device, values)?,
            Coating::Region(values) => {
                self.tints.write_colors(device, &tints(values, PAINTED, Material::CLAY))?;
            }
            Coating::Marks(values) => {
                self.tints.write_colors(device, &tints(values, MARKED, Material::CLAY))?;
            }
            Coating::Colors(colors) => self.tints.write_colors(device, colors)?,
        }
        self.coating = coating;
        Ok(())
    }
}

/// Figures in a part of the picture.
pub struct Placed<'a> {
    pub viewport: Rect,
    pub camera: Camera,
    pub figures: Vec<Figure<'a>>,
    pub markers: Vec<Marker>,
}

impl Stage {
    pub fn new(body: &Body, look: Option<OwnLook>, stands: Orientation) -> Result<Self, Error> {
        let device = device();
        let positions = single(&body.positions);
        let normals = chladni_view::smooth_normals(&positions, &body.triangles);
        Ok(Self {
            camera: Camera::on(stands, View::ThreeQuarter),
            triangles: body.triangles.as_slice().into(),
            model: Dressed::new(&device, (&positions, &normals), &body.triangles, look.as_ref())?,
            look,
            positions,
            normals,
            lineup: None,
            renderer: Renderer::new(&device),
            screen: Screen::new(device)?,
            pick: None,
            changes: 0,
            stale: true,
            fitted: false,
            by_hand: false,
        })
    }

    /// The shape as it is now, for the processor.
    fn on_processor(&self) -> Result<Dressed, Error> {
        let shape = (self.positions.as_slice(), self.normals.as_slice());
        let mut model = Dressed::new(&Device::Processor, shape, &self.triangles, self.look.as_ref())?;
        model.coat(&Device::Processor, self.model.coating.clone())?;
        Ok(model)
    }

    /// The processor draws from now on.
    pub fn draw_by_processor(&mut self) -> Result<(), Error> {
        (self.model, self.renderer) = (self.on_processor()?, Renderer::new(&Device::Processor));
        (self.screen, self.stale, self.lineup) = (Screen::new(Device::Processor)?, true, None);
        Ok(())
    }

    /// Shows another pose of the shape.
    pub fn take(&mut self, result: &Base) -> Result<(), Error> {
        (self.positions, self.normals) = (single(&result.positions), single(result.normals()));
        self.model.buffers.write(self.screen.device(), 0, &self.positions, &self.normals)?;
        if let Some(pick) = &mut self.pick {
            pick.refit(&self.positions, &self.triangles);
        }
        self.changes += 1;
        self.stale = true;
        Ok(())
    }

    /// Gives the figure its color.
    pub fn coat(&mut self, coating: Coating) -> Result<(), Error> {
        self.stale = true;
        self.model.coat(self.screen.device(), coating)
    }

    /// The scale of the heat map that is shown.
    pub fn scale(&self) -> Option<Scale> {
        match self.model.coating {
            Coating::Values(_, scale) => Some(scale),
            _ => None,
        }
    }

    /// Whether the shape brought colors along.
    pub fn has_own_look(&self) -> bool {
        self.look.is_some()
    }

    /// How often the figure has changed.
    pub fn changes(&self) -> u64 {
        self.changes
    }

    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    pub fn device(&self) -> &Device {
        self.screen.device()
    }

    /// Marks the picture on screen as out of date.
    pub fn stir(&mut self) {
        self.stale = true;
    }

    /// Lays the ring where a brush would paint; lifts it where there is none.
    pub fn lay_ring(&mut self, reach: Option<&Reach>, surface: &Surface) -> Result<(), Error> {
        self.stale = true;
        Ok(lay_ring(&mut self.model.ring, self.screen.device(), reach, surface)?)
    }

    /// Turns the viewer where the shape stands otherwise.
    pub fn stand(&mut self, stands: Orientation) {
        if self.camera.stands != stands {
            self.camera.stands = stands;
            self.fit();
        }
    }

    /// The whole figure is to be seen again.
    pub fn fit(&mut self) {
        (self.fitted, self.by_hand, self.stale) = (false, false, true);
    }

    /// The viewer has been moved.
    pub fn moved(&mut self, by_hand: bool) {
        self.by_hand |= by_hand;
        self.stale = true;
    }

    /// Whether a picture of this size has yet to be drawn.
    pub fn awaits(&mut self, width: u32, height: u32) -> Result<bool, Error> {
        let had = self.screen.fit(width, height)?;
        Ok(!had || self.stale)
    }

    /// Sees to it that all of the figure is in a picture of this size, where the viewer was not moved.
    pub fn frame(&mut self, width: u32, height: u32) -> Result<(), Error> {
        self.screen.fit(width, height)?;
        let positions = std::mem::take(&mut self.positions);
        self.aim(&positions, width as f32 / height as f32);
        self.positions = positions;
        Ok(())
    }

    /// Sees to it that all of `points` are in a picture of this aspect, where the viewer was not moved.
    fn aim(&mut self, points: &[[f32; 3]], aspect: f32) {
        let points = points.iter().copied();
        if !self.fitted {
            self.camera.fit(points, aspect, FILL);
            self.fitted = true;
        } else if !self.by_hand {
            self.camera.hold(points, aspect, 0.97);
        }
    }

    /// Draws the figure, or those beside each other.
    pub fn draw(&mut self) -> Result<(), Error> {
        if let Some(lineup) = self.lineup.take() {
            return self.draw_lineup(lineup);
        }
        let area = self.area();
        self.frame(area.width, area.height)?;
        let figure = Figure { brush: Some(&self.model.ring), ..self.model.figure() };
        let placed =
            [Placed { viewport: area, camera: self.camera, figures: vec![figure], markers: Vec::new() }];
        draw(&mut self.renderer, self.screen.canvas(), &placed, Background::SLATE)?;
        self.shown()
    }

    /// Draws others in its place.
    pub fn draw_others(&mut self, placed: &[Placed<'_>]) -> Result<(), Error> {
        draw(&mut self.renderer, self.screen.canvas(), placed, Background::SLATE)?;
        self.shown()
    }

    fn shown(&mut self) -> Result<(), Error> {
        self.screen.show()?;
        self.stale = false;
        Ok(())
    }

    /// The viewer of a picture of its own.
    pub fn held(&self, width: u32, height: u32) -> Camera {
        let mut camera = self.camera;
        camera.hold(self.positions.iter().copied(), width as f32 / height as f32, FILL);
        camera
    }

    /// A picture of its own as PNG, on paper. The processor draws it: its pixels are there at once.
    pub fn png(&self, width: u32, height: u32) -> Result<Vec<u8>, Error> {
        let canvas = Canvas::new(&Device::Processor, width, height)?;
        let copy;
        let model = match self.screen.device() {
            Device::Processor => &self.model,
            Device::Graphics(_) => {
                copy = self.on_processor()?;
                &copy
            }
        };
        // A renderer of its own: that of the page keeps room for pictures of the page's size only.
        let mut renderer = Renderer::new(&Device::Processor);
        let placed = Placed {
            viewport: Rect::of_size(width, height),
            camera: self.held(width, height),
            figures: vec![model.figure()],
            markers: Vec::new(),
        };
        draw(&mut renderer, &canvas, &[placed], Background::PAPER)?;
        Ok(canvas.read(&Device::Processor)?.to_png()?)
    }

    pub fn picture(&self) -> &Picture {
        self.screen.picture()
    }

    pub fn triangles(&self) -> &Arc<[[u32; 3]]> {
        &self.triangles
    }

    /// The tree that finds the triangle under the pointer, and the positions and triangles that it was built of.
    pub fn pick_tree(&mut self) -> (&PickTree, &[[f32; 3]], &[[u32; 3]]) {
        let (positions, triangles) = (&self.positions, &self.triangles);
        let tree = self.pick.get_or_insert_with(|| PickTree::new(positions, triangles));
        (tree, positions, triangles)
    }

    /// The place on the figure under a pixel of the last picture.
    pub fn hit(&mut self, x: f32, y: f32) -> Option<Hit> {
        let ray = self.camera.ray(x, y, self.area());
        let (tree, positions, triangles) = self.pick_tree();
        tree.pick(&ray, positions, triangles)
    }

    /// All of the last picture.
    pub fn area(&self) -> Rect {
        Rect::of_size(self.screen.canvas().width(), self.screen.canvas().height())
    }
}

fn draw(
    renderer: &mut Renderer,
    canvas: &Canvas,
    placed: &[Placed<'_>],
    background: Background,
) -> Result<(), Error> {
    let cells = placed.iter().map(|placed| Cell {
        viewport: placed.viewport,
        camera: placed.camera,
        lights: Lights::STUDIO,
        background,
        figures: &placed.figures,
        markers: &placed.markers,
    });
    Ok(renderer.draw(canvas, &cells.collect::<Vec<_>>())?)
}
