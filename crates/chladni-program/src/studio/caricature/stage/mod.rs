//! The shape in the caricature room: one figure large or three models side by side, heat maps,
//! wires, and the brush on its surface.

mod figures;
mod inked;
mod linked;
mod pointing;
mod shots;

pub use figures::{FIGURES, MODELS, ORIGINAL, RESULT};
pub use pointing::{BrushInHand, Press};

use figures::TEMPLATE;
use inked::{InkedStage, Scene};
use pointing::Pointed;

use std::sync::Arc;

use chladni_caricature::Brush;
use chladni_mesh::Orientation;
use chladni_view::{
    BrushRing, Camera, Cell, Figure, ItemBuffers, PickTree, Rect, Topology, VertexPaint, View, ViewError,
};
use egui::{Color32, Ui};

use super::evaluating::Figures;
use super::look::Portrayal;
use super::overlay::{backdrop, show_legend, show_names};
use super::shot::{Coat, Pose};
use crate::studio::keys;
use crate::studio::screen::Screen;
use crate::studio::theme;
use crate::studio::viewport::{self, Viewport};
use crate::work::{Coating, Error, MARKED, OwnLook, OwnPaint, PAINTED, RING, lay_ring, tints};

/// The result of drawing the stage.
pub struct StageResponse {
    /// Clicks and drags on it.
    pub response: egui::Response,
    /// The places that a dragged brush passed over since the last frame, so close together that the dabs
    /// overlap however fast the hand or slow the frames; the last one is where it is now, where the ring is
    /// drawn.
    pub presses: Vec<Press>,
    /// The figure in whose cell the pointer is.
    pub figure: Option<usize>,
}

/// Buffers and camera of one body.
pub struct Stage {
    viewport: Viewport,
    /// The viewer's camera; survives changes of the shape.
    pub camera: Camera,
    /// Width by height of a figure's cell.
    aspect: f32,
    /// Its height in points.
    height: f32,
    topology: Topology,
    buffers: ItemBuffers,
    values: VertexPaint,
    tints: VertexPaint,
    coat: Coat,
    /// The numbers in `values` where the coat is a heat map.
    heat: Vec<f32>,
    /// What is in `tints` where the coat has colors.
    colors: Vec<[u8; 4]>,
    own: Option<OwnPaint>,
    own_look: Option<OwnLook>,
    poses: Vec<Pose>,
    /// How often each figure was replaced.
    changes: Vec<u64>,
    /// The three models were evaluated.
    shows_models: bool,
    /// There is a template to be seen.
    has_template: bool,
    inked: InkedStage,
    triangles: Arc<[[u32; 3]]>,
    pick: Option<(usize, PickTree)>,
    /// Where a dragged brush was in the last frame, in pixels of the canvas.
    brushed: Option<[f32; 2]>,
    ring: BrushRing,
    /// Whose ring that is: the figure, the pixel of the canvas, and the brush.
    ringed: Option<(usize, [f32; 2], Brush)>,
    fitted: bool,
    /// The user has moved the camera since all was shown: it is not moved automatically.
    by_hand: bool,
    /// The shapes may reach farther than before, or less far.
    grown: bool,
    /// Target and distance of the camera before it moved back by itself.
    stood: Option<([f32; 3], f32)>,
    last_look: Option<Portrayal>,
}

impl Stage {
    /// A stage for a body of `positions` (working frame) and `triangles`, all figures at rest, in
    /// its own look where it has one.
    pub fn new(
        screen: &Screen,
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        own_look: Option<OwnLook>,
    ) -> Result<Self, ViewError> {
        let viewport = Viewport::new(screen);
        let device = viewport.device();
        let n = positions.len();
        let topology = OwnLook::topology(own_look.as_ref(), device, n, triangles)?;
        let own = own_look.as_ref().map(|look| OwnPaint::on(device, look)).transpose()?;
        let buffers = ItemBuffers::new(device, n, FIGURES);
        let (values, tints) = (VertexPaint::new(device, n), VertexPaint::new(device, n));
        let ring = BrushRing::new(device, n, RING);
        let normals = chladni_view::smooth_normals(positions, triangles);
        let mut stage = Self {
            viewport,
            camera: Camera::looking(View::ThreeQuarter),
            aspect: 1.0,
            height: 600.0,
            topology,
            buffers,
            values,
            tints,
            coat: Coat::Material,
            heat: Vec::new(),
            colors: Vec::new(),
            own,
            own_look,
            poses: vec![Pose::default(); FIGURES],
            changes: vec![0; FIGURES],
            shows_models: false,
            has_template: false,
            inked: InkedStage::default(),
            triangles: triangles.into(),
            pick: None,
            brushed: None,
            ring,
            ringed: None,
            fitted: false,
            by_hand: false,
            grown: false,
            stood: None,
            last_look: None,
        };
        for figure in 0..FIGURES {
            stage.set_figure(figure, (positions.to_vec(), normals.clone()))?;
        }
        Ok(stage)
    }

    /// The same figures on another device, seen from the same place.
    pub fn on(self, screen: &Screen) -> Result<Self, ViewError> {
        let Self { camera, fitted, shows_models, has_template, poses, .. } = self;
        let stage = Self::new(screen, &poses[ORIGINAL].0, &self.triangles, self.own_look)?;
        let mut stage = Self { camera, fitted, shows_models, has_template, ..stage };
        for (figure, pose) in poses.into_iter().enumerate() {
            stage.set_figure(figure, pose)?;
        }
        Ok(stage)
    }

    /// Takes the figures of an evaluation.
    pub fn take(&mut self, figures: Figures) -> Result<(), ViewError> {
        let Figures { result, models, template } = figures;
        (self.shows_models, self.has_template) = (models.is_some(), template.is_some());
        self.set_figure(RESULT, result)?;
        for (index, pose) in models.into_iter().flatten().enumerate() {
            self.set_figure(MODELS + index, pose)?;
        }
        template.map_or(Ok(()), |template| self.set_figure(TEMPLATE, template))
    }

    /// Replaces one figure.
    fn set_figure(&mut self, figure: usize, pose: Pose) -> Result<(), ViewError> {
        let (positions, normals) = &pose;
        self.buffers.write(self.viewport.device(), figure, positions, normals)?;
        self.poses[figure] = pose;
        self.changes[figure] += 1;
        if self.pick.as_ref().is_some_and(|(picked, _)| *picked == figure) {
            self.pick = None;
        }
        self.grown = true;
        self.viewport.invalidate();
        Ok(())
    }

    /// Whether the shape has colors of its own.
    pub fn has_own_look(&self) -> bool {
        self.own.is_some()
    }

    /// The colors that the shape brought along, or its material.
    pub fn own_coat(&self) -> Coat {
        self.own.clone().map_or(Coat::Material, Coat::Own)
    }

    /// Paints every figure.
    pub fn set_coating(&mut self, coating: Coating, look: Portrayal) -> Result<(), ViewError> {
        let tint = if matches!(coating, Coating::Marks(_)) { MARKED } else { PAINTED };
        self.coat = match coating {
            Coating::Material => Coat::Material,
            Coating::Region(values) | Coating::Marks(values) => {
                self.tinted(tints(&values, tint, look.material()))?
            }
            Coating::Colors(colors) => self.tinted(colors)?,
            Coating::Own => self.own_coat(),
            Coating::Values(values, scale) => {
                self.values.write_values(self.viewport.device(), &values)?;
                self.heat = values;
                Coat::Values(self.values.clone(), scale)
            }
        };
        self.viewport.invalidate();
        Ok(())
    }

    fn tinted(&mut self, colors: Vec<[u8; 4]>) -> Result<Coat, ViewError> {
        self.tints.write_colors(self.viewport.device(), &colors)?;
        self.colors = colors;
        Ok(Coat::Colors(self.tints.clone()))
    }

    /// Moves the camera so that the figures fill the view.
    pub fn fit(&mut self) {
        self.fitted = false;
    }

    /// Turns the view when the shape's orientation changes.
    pub fn stand(&mut self, stands: Orientation) {
        if self.camera.stands != stands {
            self.camera.stands = stands;
            self.fitted = false;
        }
    }

    /// Brings everything shown into view: fitted on request, else by moving back if it grew beyond the edges
    /// and the user has not moved the camera. With the hand at rest it comes forward again as far as it can.
    fn frame(&mut self, figures: &[usize], aspect: f32, resting: bool) {
        let shown = figures.iter().flat_map(|figure| self.poses[*figure].0.iter().copied());
        if !self.fitted {
            self.camera.fit(shown, aspect, 0.86);
            (self.fitted, self.by_hand, self.stood) = (true, false, None);
            self.viewport.invalidate();
        } else if self.by_hand {
            self.stood = None;
            // A hand may have shifted it: what lies far from its middle must not be cut off.
            if std::mem::take(&mut self.grown) {
                let before = self.camera.reach;
                self.camera.reach_all(shown);
                if self.camera.reach != before {
                    self.viewport.invalidate();
                }
            }
        } else if std::mem::take(&mut self.grown) {
            let before = (self.camera.target, self.camera.distance);
            let stood = self.stood.take().unwrap_or(before);
            if resting {
                (self.camera.target, self.camera.distance) = stood;
            }
            self.camera.hold(shown, aspect, 0.97);
            let now = (self.camera.target, self.camera.distance);
            self.stood = (now != stood).then_some(stood);
            if now != before {
                self.viewport.invalidate();
            }
        }
    }

    /// Draws the stage into `rect` and steers its camera.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        rect: egui::Rect,
        look: Portrayal,
        brush: Option<BrushInHand<'_>>,
    ) -> Result<StageResponse, Error> {
        let response = ui.allocate_rect(rect, egui::Sense::click_and_drag());
        let canvas = viewport::area(ui, rect);
        let (figures, cells) = self.arranged(ui, rect, look.show);
        if let Some(cell) = cells.first() {
            let resting = !ui.input(|input| input.pointer.any_down());
            self.aspect = cell.aspect();
            self.height = cell.height as f32 / ui.pixels_per_point();
            self.frame(figures, self.aspect, resting);
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
        if (response.hovered() || response.has_focus()) && keys::view::FIT.pressed(ui.ctx()) {
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
                self.trail(from, pointed, touch, hand.brush.spacing() as f32)
            }
            _ => Vec::new(),
        };
        let mut presses = Vec::new();
        if let Some((hand, pointed)) = brush.zip(pointed.as_ref()) {
            let touches = trail.into_iter().chain(touch);
            presses.extend(touches.map(|touch| self.press(hand, pointed, touch)));
            let reach = presses.last().filter(|_| touch.is_some()).map(|press| &press.reach);
            lay_ring(&mut self.ring, self.viewport.device(), reach, hand.surface)?;
        } else {
            self.ring.lift();
        }
        let under = brush.zip(pointed.as_ref()).filter(|_| touch.is_some());
        let ringed = under.map(|(hand, pointed)| (pointed.figure, pointed.at, hand.brush));
        // A ring that lies still needs no new picture.
        if std::mem::replace(&mut self.ringed, ringed) != ringed {
            self.viewport.invalidate();
        }
        let figure = pointed.map(|pointed| pointed.figure);
        let shown: Vec<(usize, Rect)> = figures.iter().copied().zip(cells.iter().copied()).collect();
        // A brush has its ring on all of them.
        let linked = touch.filter(|_| shown.len() > 1 && brush.is_none() && !response.dragged());
        let is_inked = look.ink && brush.is_none();
        if is_inked {
            let figures = shown.iter().map(|(figure, cell)| ((*figure, self.changes[*figure]), *cell));
            let (camera, size) = (self.camera, [canvas.width, canvas.height]);
            let scene = Scene { camera, pen: look.pen, size, figures: figures.collect() };
            self.inked.show(ui, (rect, response.id), scene, &self.poses, &self.triangles)?;
        } else {
            self.draw(ui, rect, look, &shown)?;
            if let Coat::Values(_, scale) = &self.coat {
                show_legend(ui, rect, *scale);
            }
        }
        if let Some(touch) = linked {
            self.mark_on_each(ui, rect, &touch, &shown);
        }
        // Paper has its own color, whatever the theme.
        let [r, g, b] = look.pen.ink.color;
        let color = if is_inked { Color32::from_rgb(r, g, b) } else { theme::palette(ui).weak };
        show_names(ui, rect, look.show, &cells, color);
        Ok(StageResponse { response, presses, figure })
    }

    fn draw(
        &mut self,
        ui: &mut Ui,
        rect: egui::Rect,
        look: Portrayal,
        shown: &[(usize, Rect)],
    ) -> Result<(), ViewError> {
        let haunted = self.has_template && look.ghost;
        let ghost = haunted.then(|| Figure::new(&self.topology, &self.buffers, TEMPLATE).ghost());
        let scale = ui.pixels_per_point();
        let drawn: Vec<Vec<Figure<'_>>> = shown
            .iter()
            .map(|(item, _)| {
                let figure = look.figure(&self.topology, &self.buffers, *item, self.coat.paint(), scale);
                let ghost = ghost.filter(|_| *item != TEMPLATE);
                [Figure { brush: Some(&self.ring), ..figure }].into_iter().chain(ghost).collect()
            })
            .collect();
        let (background, lights) = (backdrop(ui), look.lights());
        let camera = self.camera;
        self.viewport.show(ui, rect, |_| {
            let cell = |((_, cell), figures): (&(usize, Rect), _)| Cell {
                viewport: *cell,
                camera,
                lights,
                background,
                figures,
                markers: &[],
            };
            shown.iter().zip(drawn.iter().map(Vec::as_slice)).map(cell).collect()
        })
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use chladni_caricature::Surface;
    use chladni_harmonics::{BasisSettings, Body};
    use chladni_mesh::samples::icosphere;
    use chladni_mesh::surface::vec3::single;
    use chladni_task::Task;
    use chladni_view::Device;

    use super::super::look::Show;
    use super::*;

    #[test]
    fn names_are_written_in_the_ink_of_a_drawing() {
        let ball = icosphere(1);
        let screen = Screen::unseen(&Device::Processor);
        let mut stage = Stage::new(&screen, &single(&ball.positions), &ball.triangles, None).unwrap();
        let rect = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(64.0, 64.0));
        let ctx = egui::Context::default();
        let mut color = |ink| {
            let look = Portrayal { show: Show::Original, ink, ..Portrayal::default() };
            let output = ctx.run_ui(egui::RawInput::default(), |ui| {
                stage.show(ui, rect, look, None).unwrap();
            });
            output.shapes.iter().find_map(|clipped| match &clipped.shape {
                egui::Shape::Text(text) => Some(text.galley.job.sections.first()?.format.color),
                _ => None,
            })
        };
        let [r, g, b] = Portrayal::default().pen.ink.color;
        let inked = Some(Color32::from_rgb(r, g, b));
        assert_eq!(color(true), inked);
        assert!(color(false).is_some_and(|weak| Some(weak) != inked));
    }

    #[test]
    fn a_brush_at_rest_asks_for_no_more_frames() {
        let body = Body::build(&icosphere(2), &BasisSettings::new(6), &Task::new()).unwrap();
        let surface = Surface::new(&body);
        let screen = Screen::unseen(&Device::Processor);
        let mut stage = Stage::new(&screen, &single(&body.positions), &body.triangles, None).unwrap();
        let brush = Brush { radius: 0.1, hardness: 1.0, mirror: None };
        let rect = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(64.0, 64.0));
        let ctx = egui::Context::default();
        // After how long the next frame is asked for.
        let frame = |stage: &mut Stage, events: Vec<egui::Event>| {
            let input = egui::RawInput { events, ..egui::RawInput::default() };
            let output = ctx.run_ui(input, |ui| {
                let hand = BrushInHand { brush, surface: &surface };
                stage.show(ui, rect, Portrayal::default(), Some(hand)).unwrap();
            });
            output.viewport_output[&egui::ViewportId::ROOT].repaint_delay
        };
        for _ in 0..3 {
            frame(&mut stage, Vec::new());
        }
        frame(&mut stage, vec![egui::Event::PointerMoved(rect.center())]);
        let asked: Vec<Duration> = (0..12).map(|_| frame(&mut stage, Vec::new())).collect();
        assert!(stage.ringed.is_some());
        assert!(asked.last().is_some_and(|wait| !wait.is_zero()), "{asked:?}");
        assert!(frame(&mut stage, vec![egui::Event::PointerGone]).is_zero());
        assert!(stage.ringed.is_none());
    }
}
