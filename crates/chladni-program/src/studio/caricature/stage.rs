//! The shape in the caricature room: one figure large or three models side by side, heat maps,
//! wires, and the brush on its surface.

use chladni_caricature::{Brush, Reach, Seen, Surface, SurfacePoint};
use chladni_mesh::Orientation;
use chladni_view::{
    Background, BrushRing, Camera, Cell, Figure, Gpu, ItemBuffers, Marker, PickTree, Projection, Rect, Scale,
    Skin, Topology, VertexPaint, View, ViewError, layout,
};
use eframe::egui_wgpu::RenderState;
use egui::Ui;

use super::shot::{Coat, Pose, Shot};
use crate::studio::theme;
use crate::studio::viewport::{self, Viewport};
use crate::work::OwnLook;

/// Figures that the stage holds room for: the result, the three models, and the original.
pub const FIGURES: usize = 5;
/// The result of the whole stack.
pub const RESULT: usize = 0;
/// The first of the three models of the selected layer.
pub const MODELS: usize = 1;
/// The shape as it was loaded.
pub const ORIGINAL: usize = 4;

/// What stands on the stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Show {
    /// The result, large.
    #[default]
    Result,
    /// The selected layer in all three models.
    Models,
    /// The original beside the result.
    BeforeAfter,
    /// The original alone, while a key is held.
    Original,
}

/// How it looks; a choice of the user, not of the project.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// What stands on the stage.
    pub show: Show,
    /// Edges of triangles.
    pub wire: bool,
    /// Index into [`Material::PRESETS`].
    pub material: usize,
    /// Index into [`Lights::PRESETS`].
    pub lights: usize,
}

impl Default for Look {
    fn default() -> Self {
        Self { show: Show::Result, wire: false, material: 0, lights: 0 }
    }
}

/// What gives the figures their colour.
#[derive(Debug)]
pub enum Coating {
    /// The material alone.
    Material,
    /// The colours that the shape brought along.
    Own,
    /// A heat map.
    Values(Vec<f32>, Scale),
    /// A region on the material: 0 is bare, 1 is painted.
    Region(Vec<f32>),
    /// Places on the material to look at: 0 is bare, 1 is marked.
    Marks(Vec<f32>),
}

/// What painted places look like, sRGB: far from clay for eyes of every kind.
const PAINTED: [u8; 3] = [52, 122, 190];
/// What the brush's ring looks like, sRGB.
const RING: [u8; 3] = [236, 170, 70];
/// What marked places look like, sRGB.
const MARKED: [u8; 3] = [214, 40, 30];

/// A point under the pointer.
#[derive(Clone, Copy, Debug)]
pub struct Touch {
    /// The triangle.
    pub triangle: u32,
    /// Its weights, summing to 1.
    pub barycentric: [f32; 3],
    /// The point, working frame.
    pub point: [f32; 3],
}

impl Touch {
    /// The same place on the surface at rest.
    pub fn on_surface(&self) -> SurfacePoint {
        SurfacePoint { triangle: self.triangle, weights: self.barycentric.map(f64::from) }
    }
}

/// A brush in hand and the surface that it paints.
#[derive(Clone, Copy)]
pub struct BrushInHand<'a> {
    /// The brush.
    pub brush: Brush,
    /// The surface at rest.
    pub surface: &'a Surface,
}

/// One press of the brush.
pub struct Press {
    /// Its centre.
    pub touch: Touch,
    /// What it covers of the figure under the pointer, as it is seen.
    pub reach: Reach,
}

/// What came of drawing the stage.
pub struct Shown {
    /// Clicks and drags on it.
    pub response: egui::Response,
    /// What a brush passed over since the last frame where it is dragged, so close together that its
    /// dabs overlap however quick the hand or slow the frames; then what it is on, which is ringed.
    pub presses: Vec<Press>,
    /// The figure in whose cell the pointer is.
    pub figure: Option<usize>,
}

/// Buffers and camera of one body.
pub struct Stage {
    viewport: Viewport,
    /// Who looks; survives changes of the shape.
    pub camera: Camera,
    topology: Topology,
    buffers: ItemBuffers,
    values: VertexPaint,
    tints: VertexPaint,
    coat: Coat,
    /// What `values` holds where the coat is a heat map.
    heat: Vec<f32>,
    own: Option<Coat>,
    own_look: Option<OwnLook>,
    poses: Vec<Pose>,
    triangles: Vec<[u32; 3]>,
    pick: Option<(usize, PickTree)>,
    /// Where a dragged brush was in the last frame, in pixels of the canvas.
    brushed: Option<[f32; 2]>,
    ring: BrushRing,
    fitted: bool,
    /// Somebody came nearer or looked aside since all was shown: nothing is brought back unasked.
    by_hand: bool,
    /// What is shown may reach farther than before.
    grown: bool,
    last_look: Option<Look>,
}

impl Stage {
    /// A stage for a body of `positions` (working frame) and `triangles`, all figures at rest, in
    /// its own look where it has one.
    pub fn new(
        gpu: Gpu,
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        own_look: Option<OwnLook>,
    ) -> Result<Self, ViewError> {
        let viewport = Viewport::on(gpu);
        let gpu = viewport.gpu();
        let n = positions.len();
        let topology = match &own_look {
            Some(OwnLook::Image { corner_uvs, .. }) => Topology::with_uvs(gpu, n, triangles, corner_uvs)?,
            _ => Topology::new(gpu, n, triangles)?,
        };
        let own = match &own_look {
            Some(OwnLook::Image { picture, .. }) => {
                Some(Coat::Skin(Skin::new(gpu, picture.width, picture.height, &picture.rgba)?))
            }
            Some(OwnLook::Colors(colors)) => {
                let paint = VertexPaint::new(gpu, n);
                paint.write_colors(gpu, colors)?;
                Some(Coat::Colors(paint))
            }
            None => None,
        };
        let buffers = ItemBuffers::new(gpu, n, FIGURES);
        let (values, tints) = (VertexPaint::new(gpu, n), VertexPaint::new(gpu, n));
        let ring = BrushRing::new(gpu, n, RING);
        let normals = chladni_view::smooth_normals(positions, triangles);
        let mut stage = Self {
            viewport,
            camera: Camera::looking(View::ThreeQuarter),
            topology,
            buffers,
            values,
            tints,
            coat: Coat::Material,
            heat: Vec::new(),
            own,
            own_look,
            poses: vec![(positions.to_vec(), normals.clone()); FIGURES],
            triangles: triangles.to_vec(),
            pick: None,
            brushed: None,
            ring,
            fitted: false,
            by_hand: false,
            grown: false,
            last_look: None,
        };
        for figure in 0..FIGURES {
            stage.set_figure(figure, positions, &normals)?;
        }
        Ok(stage)
    }

    /// The same shape on another device, seen from the same place; all figures are at rest.
    pub fn on(self, gpu: Gpu) -> Result<Self, ViewError> {
        let (original, _) = &self.poses[ORIGINAL];
        let stage = Self::new(gpu, original, &self.triangles, self.own_look)?;
        Ok(Self { camera: self.camera, fitted: self.fitted, ..stage })
    }

    /// Replaces one figure.
    pub fn set_figure(
        &mut self,
        figure: usize,
        positions: &[[f32; 3]],
        normals: &[[f32; 3]],
    ) -> Result<(), ViewError> {
        self.buffers.write(self.viewport.gpu(), figure, positions, normals)?;
        let (held_positions, held_normals) = &mut self.poses[figure];
        held_positions.clear();
        held_positions.extend_from_slice(positions);
        held_normals.clear();
        held_normals.extend_from_slice(normals);
        if self.pick.as_ref().is_some_and(|(picked, _)| *picked == figure) {
            self.pick = None;
        }
        self.grown = true;
        self.viewport.invalidate();
        Ok(())
    }

    /// Whether the shape has colours of its own.
    pub fn has_own_look(&self) -> bool {
        self.own.is_some()
    }

    /// The colours that the shape brought along, or its material.
    pub fn own_coat(&self) -> Coat {
        self.own.clone().unwrap_or(Coat::Material)
    }

    /// Paints every figure.
    pub fn set_coating(&mut self, coating: Coating, look: Look) -> Result<(), ViewError> {
        let tint = if matches!(coating, Coating::Marks(_)) { MARKED } else { PAINTED };
        self.coat = match coating {
            Coating::Material => Coat::Material,
            Coating::Region(values) | Coating::Marks(values) => {
                let tints = tints(&values, tint, look.material());
                self.tints.write_colors(self.viewport.gpu(), &tints)?;
                Coat::Colors(self.tints.clone())
            }
            Coating::Own => self.own_coat(),
            Coating::Values(values, scale) => {
                self.values.write_values(self.viewport.gpu(), &values)?;
                self.heat = values;
                Coat::Values(self.values.clone(), scale)
            }
        };
        self.viewport.invalidate();
        Ok(())
    }

    /// What is shown now, on its own, before a `background`.
    pub fn shot(&self, look: Look, background: Background) -> Result<Shot, ViewError> {
        let gpu = self.viewport.gpu().clone();
        let coat = match &self.coat {
            Coat::Values(_, scale) => {
                let own = VertexPaint::new(&gpu, self.heat.len());
                own.write_values(&gpu, &self.heat)?;
                Coat::Values(own, *scale)
            }
            constant => constant.clone(),
        };
        let poses = figures(look.show).iter().map(|figure| self.poses[*figure].clone()).collect();
        Ok(Shot { gpu, topology: self.topology.clone(), poses, coat, camera: self.camera, look, background })
    }

    /// Another pose of this shape, on its own.
    pub fn shot_of(&self, pose: Pose, coat: Coat, background: Background) -> Shot {
        let (gpu, topology) = (self.viewport.gpu().clone(), self.topology.clone());
        Shot {
            gpu,
            topology,
            poses: vec![pose],
            coat,
            camera: self.camera,
            look: Look::default(),
            background,
        }
    }

    /// Moves the camera so that what is shown fills the view.
    pub fn fit(&mut self) {
        self.fitted = false;
    }

    /// Turns the view where the shape stands otherwise than was thought.
    pub fn stand(&mut self, stands: Orientation) {
        if self.camera.stands != stands {
            self.camera.stands = stands;
            self.fitted = false;
        }
    }

    /// Brings all that is shown into view: fitted where it was asked for, else by going back where it
    /// grew beyond the edges and nobody has chosen where to stand.
    fn frame(&mut self, figures: &[usize], aspect: f32) {
        let shown = figures.iter().flat_map(|figure| self.poses[*figure].0.iter().copied());
        if !self.fitted {
            self.camera.fit(shown, aspect, 0.86);
            (self.fitted, self.by_hand) = (true, false);
            self.viewport.invalidate();
        } else if std::mem::take(&mut self.grown) && !self.by_hand && self.camera.hold(shown, aspect, 0.97) {
            self.viewport.invalidate();
        }
    }

    /// Draws the stage into `rect` and steers its camera.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        state: &RenderState,
        rect: egui::Rect,
        look: Look,
        brush: Option<BrushInHand<'_>>,
        markers: &[Marker],
    ) -> Result<Shown, ViewError> {
        let response = ui.allocate_rect(rect, egui::Sense::click_and_drag());
        let figures = figures(look.show);
        let canvas = Rect::of_size(
            ((rect.width() * ui.pixels_per_point()).round() as u32).max(1),
            ((rect.height() * ui.pixels_per_point()).round() as u32).max(1),
        );
        let (rows, columns) = layout::rows_and_columns(canvas.width, canvas.height, figures.len(), 0.8);
        let cells = layout::grid(canvas, rows, columns, 2, figures.len());
        if let Some(cell) = cells.first() {
            self.frame(figures, cell.aspect());
        }
        let free = brush.is_none();
        let before = self.camera;
        let moved = viewport::navigate_by(ui, &response, &mut self.camera, free);
        let stood = |camera: &Camera| (camera.target, camera.distance);
        self.by_hand |= stood(&before) != stood(&self.camera);
        if moved || self.last_look.replace(look) != Some(look) {
            self.grown = true;
            self.viewport.invalidate();
        }
        if ui.ctx().input(|input| input.key_pressed(egui::Key::Home))
            && (response.hovered() || response.has_focus())
        {
            self.fitted = false;
        }
        let pointed = Pointed::of(ui, &response, rect, figures, &cells);
        let touch = pointed.as_ref().and_then(|pointed| self.touch(pointed));
        let primary = egui::PointerButton::Primary;
        let began =
            ui.input(|input| input.pointer.press_origin()).filter(|_| response.drag_started_by(primary));
        let from = began.map(|at| viewport::to_pixels(ui, rect, at)).or(self.brushed);
        let stroke = brush.zip(pointed.as_ref()).filter(|_| response.dragged_by(primary));
        self.brushed = stroke.map(|(_, pointed)| pointed.at);
        let trail = match (stroke, from) {
            (Some((hand, pointed)), Some(from)) => {
                self.trail(from, pointed, touch, 0.5 * hand.brush.radius as f32)
            }
            _ => Vec::new(),
        };
        let mut presses = Vec::new();
        if let Some((hand, pointed)) = brush.zip(pointed.as_ref()) {
            let touches = trail.into_iter().chain(touch);
            presses.extend(touches.map(|touch| self.press(hand, pointed, touch)));
            self.ring_around(presses.last().filter(|_| touch.is_some()), hand.surface)?;
        } else {
            self.ring.lift();
        }
        if brush.is_some() && (response.hovered() || response.dragged()) {
            self.viewport.invalidate();
        }
        self.draw(ui, state, rect, look, figures, &cells, markers)?;
        if let Coat::Values(_, scale) = &self.coat {
            show_legend(ui, rect, *scale);
        }
        show_names(ui, rect, look.show, &cells);
        Ok(Shown { response, presses, figure: pointed.map(|pointed| pointed.figure) })
    }

    /// What the brush covers where it touches the figure that is `pointed` at.
    fn press(&self, hand: BrushInHand<'_>, pointed: &Pointed, touch: Touch) -> Press {
        let [x, y] = pointed.at;
        let ray = self.camera.ray(x, y, pointed.cell);
        let far = match self.camera.projection {
            Projection::Perspective => 0.0,
            // Everything is seen along the same direction.
            Projection::Orthographic => 1e6,
        };
        let eye = std::array::from_fn(|i| f64::from(ray.origin[i]) - far * f64::from(ray.direction[i]));
        let positions = &self.poses[pointed.figure].0;
        let seen = Seen { surface: hand.surface, positions, eye: Some(eye) };
        Press { touch, reach: hand.brush.reach(&seen, &touch.on_surface()) }
    }

    /// Lays the ring where `press` would paint.
    fn ring_around(&mut self, press: Option<&Press>, surface: &Surface) -> Result<(), ViewError> {
        let Some(Press { reach, .. }) = press else {
            self.ring.lift();
            return Ok(());
        };
        let triangles: Vec<[u32; 3]> =
            reach.triangles.iter().filter_map(|t| surface.triangles.get(*t as usize)).copied().collect();
        let distances = reach.distances.iter().map(|(v, d)| (*v, *d as f32));
        self.ring.lay(self.viewport.gpu(), reach.radius as f32, distances, &triangles)
    }

    /// What lies under the way `from` a pixel to where `pointed` is, about `step` apart, without
    /// its end, which is at `touch`.
    fn trail(&mut self, from: [f32; 2], pointed: &Pointed, touch: Option<Touch>, step: f32) -> Vec<Touch> {
        const MOST: f32 = 32.0;
        let on_the_way = |along: f32| Pointed {
            at: std::array::from_fn(|i| from[i] + (pointed.at[i] - from[i]) * along),
            ..*pointed
        };
        let Some((start, end)) = self.touch(&on_the_way(0.0)).zip(touch) else { return Vec::new() };
        let apart: f32 = (0..3).map(|i| (end.point[i] - start.point[i]).powi(2)).sum::<f32>().sqrt();
        let steps = (apart / step).ceil().clamp(1.0, MOST) as u16;
        let places = (0..steps).map(|i| on_the_way(f32::from(i) / f32::from(steps)));
        places.filter_map(|place| self.touch(&place)).collect()
    }

    fn draw(
        &mut self,
        ui: &mut Ui,
        state: &RenderState,
        rect: egui::Rect,
        look: Look,
        figures: &[usize],
        cells: &[Rect],
        markers: &[Marker],
    ) -> Result<(), ViewError> {
        let drawn: Vec<[Figure<'_>; 1]> = figures
            .iter()
            .map(|item| {
                let figure = look.figure(&self.topology, &self.buffers, *item, self.coat.paint());
                [Figure { brush: Some(&self.ring), ..figure }]
            })
            .collect();
        let (background, lights) = (backdrop(ui), look.lights());
        let camera = self.camera;
        self.viewport.show(ui, state, rect, |_| {
            cells
                .iter()
                .zip(&drawn)
                .map(|(cell, figures)| Cell { viewport: *cell, camera, lights, background, figures, markers })
                .collect()
        })
    }

    /// Where `pointed` meets its figure.
    fn touch(&mut self, pointed: &Pointed) -> Option<Touch> {
        let Pointed { at: [x, y], cell, figure } = *pointed;
        let positions = &self.poses[figure].0;
        match &mut self.pick {
            Some((picked, _)) if *picked == figure => {}
            Some((picked, tree)) => {
                tree.refit(positions, &self.triangles);
                *picked = figure;
            }
            None => self.pick = Some((figure, PickTree::new(positions, &self.triangles))),
        }
        let (_, tree) = self.pick.as_ref()?;
        let ray = self.camera.ray(x, y, cell);
        let hit = tree.pick(&ray, positions, &self.triangles)?;
        Some(Touch { triangle: hit.triangle, barycentric: hit.barycentric, point: hit.point(&ray) })
    }
}

/// What the pointer is on.
struct Pointed {
    /// Pixels of the canvas.
    at: [f32; 2],
    cell: Rect,
    figure: usize,
}

impl Pointed {
    fn of(
        ui: &Ui,
        response: &egui::Response,
        rect: egui::Rect,
        figures: &[usize],
        cells: &[Rect],
    ) -> Option<Self> {
        let at = response.interact_pointer_pos().or(response.hover_pos())?;
        let [x, y] = viewport::to_pixels(ui, rect, at);
        let (cell, figure) = cells.iter().zip(figures).find(|(cell, _)| cell.contains(x, y))?;
        Some(Self { at: [x, y], cell: *cell, figure: *figure })
    }
}

/// The material's colour where `values` are 0, `tint` where they are 1; linear light.
fn tints(values: &[f32], tint: [u8; 3], material: chladni_view::Material) -> Vec<[u8; 4]> {
    let linear = |c: u8| (f32::from(c) / 255.0).powf(2.2);
    let (bare, painted) = (material.color.map(linear), tint.map(linear));
    let mixed = |share: &f32| {
        let share = share.clamp(0.0, 1.0) * 0.85;
        let channel = |i: usize| ((bare[i] + (painted[i] - bare[i]) * share) * 255.0).round() as u8;
        [channel(0), channel(1), channel(2), 255]
    };
    values.iter().map(mixed).collect()
}

/// The figures that are shown, from left to right.
fn figures(show: Show) -> &'static [usize] {
    match show {
        Show::Result => &[RESULT],
        Show::Models => &[MODELS, MODELS + 1, MODELS + 2, ORIGINAL],
        Show::BeforeAfter => &[ORIGINAL, RESULT],
        Show::Original => &[ORIGINAL],
    }
}

/// What stands behind shapes in this window.
pub fn backdrop(ui: &Ui) -> Background {
    if !ui.visuals().dark_mode {
        return Background::PAPER;
    }
    let stage = theme::palette(ui).stage;
    let lift = |c: u8| c.saturating_add(22);
    Background {
        center: [lift(stage.r()), lift(stage.g()), lift(stage.b())],
        corner: [stage.r(), stage.g(), stage.b()],
        opacity: 1.0,
    }
}

fn show_names(ui: &Ui, rect: egui::Rect, show: Show, cells: &[Rect]) {
    let names: &[&str] = match show {
        Show::Result => return,
        Show::Models => &["Coordinate", "Normal", "Distance", "Original"],
        Show::BeforeAfter => &["Before", "After"],
        Show::Original => &["Original"],
    };
    let palette = theme::palette(ui);
    for (cell, name) in cells.iter().zip(names) {
        let cell = viewport::to_points(ui, rect, *cell);
        let font = egui::TextStyle::Body.resolve(ui.style());
        ui.painter().text(
            cell.left_top() + egui::vec2(12.0, 10.0),
            egui::Align2::LEFT_TOP,
            name,
            font,
            palette.weak,
        );
    }
}

/// A bar of the colour map with round numbers beside it.
fn show_legend(ui: &Ui, rect: egui::Rect, scale: Scale) {
    let bar = egui::Rect::from_min_size(
        egui::pos2(rect.left() + 16.0, rect.bottom() - 176.0),
        egui::vec2(12.0, 160.0),
    );
    let painter = ui.painter_at(rect);
    let mut mesh = egui::Mesh::default();
    const STEPS: u32 = 48;
    for step in 0..=STEPS {
        let t = step as f32 / STEPS as f32;
        let value = scale.low + (scale.high - scale.low) * t;
        let [r, g, b] = scale.color(value);
        let y = bar.bottom() - bar.height() * t;
        for x in [bar.left(), bar.right()] {
            mesh.colored_vertex(egui::pos2(x, y), egui::Color32::from_rgb(r, g, b));
        }
        if step > 0 {
            let base = 2 * (step - 1);
            mesh.add_triangle(base, base + 1, base + 2);
            mesh.add_triangle(base + 1, base + 3, base + 2);
        }
    }
    painter.add(mesh);
    let font = egui::TextStyle::Small.resolve(ui.style());
    let color = ui.visuals().text_color();
    for tick in scale.ticks(5) {
        let t = (tick - scale.low) / (scale.high - scale.low).max(f32::MIN_POSITIVE);
        let y = bar.bottom() - bar.height() * t;
        painter.hline(bar.right()..=bar.right() + 4.0, y, egui::Stroke::new(1.0, color));
        let at = egui::pos2(bar.right() + 8.0, y);
        painter.text(at, egui::Align2::LEFT_CENTER, format!("{tick}"), font.clone(), color);
    }
}
