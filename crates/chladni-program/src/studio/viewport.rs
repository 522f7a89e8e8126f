//! A 3D view inside the window: drawn by chladni-view, shown as a texture, steered as in Blender.

use chladni_view::{
    Camera, Canvas, Cell, Device, Finish, Marker, Picture, Rect, Renderer, Samples, Surroundings, View,
    ViewError,
};
use egui::emath::GuiRounding;
use egui::{EventFilter, Key, Modifiers, Role};

use super::effort::{Effort, Quality};
use super::keys::view as keys;
use super::screen::{Screen, Shown};
use super::{shortcut, theme};
use crate::work::Scenery;

/// The key under which egui remembers that a view was drawn.
const DRAWN: &str = "a 3D view was drawn";

/// Whether any 3D view was drawn so far.
pub fn has_drawn(ctx: &egui::Context) -> bool {
    ctx.data(|data| data.get_temp(egui::Id::unique(DRAWN)).unwrap_or(false))
}

/// An arrow key turns as far as a drag of this many pixels.
const KEY_DRAG: f32 = 25.0;

/// After this time without a change a picture is drawn in full quality.
const REST_SECS: f64 = 0.3;

/// One canvas of the window and the renderer that draws on it.
pub struct Viewport {
    screen: Screen,
    renderer: Renderer,
    canvas: Option<(Canvas, Shown)>,
    /// The picture before, where that is shown until the one on the canvas may be.
    kept: Option<(Canvas, Shown)>,
    stale: bool,
    /// The last picture was drawn for a dark window: its background is the window's.
    dark: bool,
    /// Pixels of the window that the picture fills.
    shown: Rect,
    effort: Effort,
    /// Effects on finished pictures, and the time of the next one.
    finish: (Finish, f64),
    /// The version of the pictures around the scene.
    surrounded: u64,
    surroundings: Surroundings,
    /// Which picture of a film stands behind; 0 is that of the surroundings.
    behind: u64,
    /// When the picture last changed, where it is to be drawn more finely once it rests.
    moved_secs: Option<f64>,
}

impl Viewport {
    /// A view drawn on the window's own device; pipelines are compiled when a picture needs them first.
    pub fn new(screen: &Screen) -> Self {
        Self {
            renderer: Renderer::new(screen.device()),
            canvas: None,
            kept: None,
            stale: true,
            dark: false,
            shown: Rect::default(),
            effort: Effort::new(screen.device()),
            screen: screen.clone(),
            finish: (Finish::NOTHING, 0.0),
            surrounded: 0,
            surroundings: Surroundings::default(),
            behind: 0,
            moved_secs: None,
        }
    }

    /// The device that everything shown here must live on.
    pub fn device(&self) -> &Device {
        self.screen.device()
    }

    /// Where its pictures are shown.
    pub fn screen(&self) -> &Screen {
        &self.screen
    }

    /// Asks for a new picture in the next frame; without it the last one is shown again.
    pub fn invalidate(&mut self) {
        self.stale = true;
    }

    /// From now on pictures have this finish; the next one is that of `at_secs`.
    pub fn finish(&mut self, finish: Finish, at_secs: f64) {
        self.finish = (finish, at_secs);
    }

    /// How finely moving pictures are drawn, and why, in words.
    pub fn drawn(&self) -> String {
        let because = match (self.device().is_software(), self.effort.is_reduced()) {
            (true, false) => " (no graphics card)",
            (true, true) => " (no graphics card, and frames were late)",
            (false, true) => " (frames were late)",
            (false, false) => "",
        };
        format!("{}{because}; still pictures: {}", self.effort.quality(), Quality::STILL)
    }

    /// From the next picture on it is drawn in this scenery, whose number changes with it.
    pub fn surround(&mut self, number: u64, scenery: &Scenery) -> Result<(), ViewError> {
        if self.surrounded != number {
            self.surroundings = scenery.on(self.screen.device())?;
            self.renderer.surround(&self.surroundings)?;
            (self.surrounded, self.behind, self.stale) = (number, 0, true);
        }
        Ok(())
    }

    /// From the next picture on this one stands behind, whose number changes with it.
    pub fn put_behind(&mut self, number: u64, picture: &Picture) -> Result<(), ViewError> {
        if self.behind != number {
            self.surroundings =
                std::mem::take(&mut self.surroundings).before(self.screen.device(), picture)?;
            self.renderer.surround(&self.surroundings)?;
            (self.behind, self.stale) = (number, true);
        }
        Ok(())
    }

    /// Shows the cells that `scene` arranges on a canvas of the given pixels, filling `rect`. The radii of their markers
    /// are points.
    ///
    /// `scene` runs only when something has changed since the last frame (the window's theme, too), or when what was
    /// drawn quickly while it moved has come to rest.
    pub fn show<'a>(
        &mut self,
        ui: &mut egui::Ui,
        rect: egui::Rect,
        scene: impl FnOnce(Rect) -> Vec<Cell<'a>>,
    ) -> Result<(), ViewError> {
        self.draw(ui, rect, scene)?;
        self.paint(ui, rect);
        if self.moved_secs.is_some() && self.effort.is_reduced() {
            remark(ui, rect, format!("Frames were late: {} while it moves", self.effort.quality()));
        }
        Ok(())
    }

    /// As [`show`](Self::show), but leaves showing to [`paint`](Self::paint) and gives no message when frames
    /// are late. True if a picture was drawn.
    pub fn draw<'a>(
        &mut self,
        ui: &egui::Ui,
        rect: egui::Rect,
        scene: impl FnOnce(Rect) -> Vec<Cell<'a>>,
    ) -> Result<bool, ViewError> {
        let limit = self.device().longest_side();
        let pixels = |points: f32| ((points * ui.pixels_per_point()).round() as u32).clamp(1, limit);
        let shown = Rect::of_size(pixels(rect.width()), pixels(rect.height()));
        let resized = self.shown != shown;
        self.shown = shown;
        let dark = ui.visuals().dark_mode;
        self.stale |= std::mem::replace(&mut self.dark, dark) != dark;
        let now_secs = ui.input(|input| input.time);
        let quality = if self.stale || resized || self.canvas.is_none() {
            self.effort.frame(now_secs, self.finish.0);
            // The next frame is requested at once, so that a late frame can be distinguished from one that was not
            // needed.
            ui.ctx().request_repaint();
            self.moved_secs = (self.effort.quality() != Quality::STILL).then_some(now_secs);
            self.effort.quality()
        } else {
            self.effort.rest();
            match self.moved_secs {
                Some(moved_secs) if now_secs - moved_secs >= REST_SECS => Quality::STILL,
                Some(moved_secs) => {
                    let left = (moved_secs + REST_SECS - now_secs).max(0.01);
                    ui.ctx().request_repaint_after(std::time::Duration::from_secs_f64(left));
                    return Ok(false);
                }
                None => return Ok(false),
            }
        };
        if quality == Quality::STILL {
            self.moved_secs = None;
        }
        let scaled = |length: u32| (u64::from(length) * u64::from(quality.percent) / 100) as u32;
        self.fit(scaled(shown.width).max(1), scaled(shown.height).max(1), quality.samples)?;
        let Some((canvas, shown_as)) = &mut self.canvas else { return Ok(false) };
        let mut cells = scene(shown);
        let scale = ui.pixels_per_point() * quality.percent as f32 / 100.0;
        let markers: Vec<Vec<Marker>> = cells
            .iter()
            .map(|cell| cell.markers.iter().map(|marker| marker.scaled(scale)).collect())
            .collect();
        for (cell, markers) in cells.iter_mut().zip(&markers) {
            cell.markers = markers;
            let r = cell.viewport;
            let (x, y) = (scaled(r.x), scaled(r.y));
            let end = |start, length, limit: u32| scaled(start + length).clamp(1, limit);
            let (right, bottom) = (end(r.x, r.width, canvas.width()), end(r.y, r.height, canvas.height()));
            let (x, y) = (x.min(right - 1), y.min(bottom - 1));
            cell.viewport = Rect { x, y, width: right - x, height: bottom - y };
        }
        let (finish, at_secs) = self.finish;
        self.renderer.draw_finished(canvas, &cells, &quality.effects.of(finish), at_secs)?;
        shown_as.refresh(canvas);
        self.stale = false;
        ui.ctx().data_mut(|data| data.insert_temp(egui::Id::unique(DRAWN), true));
        Ok(true)
    }

    /// Shows the picture that was drawn last.
    pub fn paint(&self, ui: &egui::Ui, rect: egui::Rect) {
        if let Some(texture) = self.drawn_texture() {
            ui.painter().image(texture, rect, theme::WHOLE_IMAGE, egui::Color32::WHITE);
        }
    }

    /// Keeps the picture that was drawn last as [`kept_texture`](Self::kept_texture); the next one is drawn on
    /// another canvas.
    pub fn keep(&mut self) {
        std::mem::swap(&mut self.canvas, &mut self.kept);
    }

    /// The picture that was drawn last.
    pub fn drawn_texture(&self) -> Option<egui::TextureId> {
        self.canvas.as_ref().map(|(_, shown)| shown.id())
    }

    /// The picture that was kept last.
    pub fn kept_texture(&self) -> Option<egui::TextureId> {
        self.kept.as_ref().map(|(_, shown)| shown.id())
    }

    /// The canvas that was kept last; `None` before the first picture that was kept.
    pub fn kept_canvas(&self) -> Option<&Canvas> {
        self.kept.as_ref().map(|(canvas, _)| canvas)
    }

    /// The canvas that was drawn on last; `None` before the first picture.
    pub fn canvas(&self) -> Option<&Canvas> {
        self.canvas.as_ref().map(|(canvas, _)| canvas)
    }

    /// Makes the canvas match the request.
    fn fit(&mut self, width: u32, height: u32, samples: Samples) -> Result<(), ViewError> {
        let fits = |(canvas, _): &(Canvas, Shown)| {
            let is_sampled = canvas.samples() == samples || matches!(self.device(), Device::Processor);
            (canvas.width(), canvas.height()) == (width, height) && is_sampled
        };
        if self.canvas.as_ref().is_some_and(fits) {
            return Ok(());
        }
        let canvas = Canvas::with_samples(self.device(), width, height, samples)?;
        let before = self.canvas.take().map(|(_, shown)| shown);
        let shown = self.screen.hang(&canvas, before)?;
        self.canvas = Some((canvas, shown));
        Ok(())
    }
}

/// Puts `text` in the corner of a picture, on a ground of its own: a shape of any color may be behind it.
fn remark(ui: &egui::Ui, picture: egui::Rect, text: String) {
    let (weak, ground) = (theme::palette(ui).weak, ui.visuals().panel_fill.gamma_multiply(0.85));
    let (font, width) = (egui::FontId::proportional(11.0), (picture.width() - 20.0).max(0.0));
    let galley = ui.painter().layout(text, font, weak, width);
    let at = picture.right_bottom() - egui::vec2(10.0, 8.0) - galley.size();
    let plate = egui::Rect::from_min_size(at, galley.size()).expand2(egui::vec2(6.0, 3.0));
    ui.painter().rect_filled(plate, 4.0, ground);
    ui.painter().galley(at, galley, weak);
}

/// The space that is left, from pixel to pixel, so that the pixels of a view are those of the window.
pub fn whole_pixels(ui: &egui::Ui) -> egui::Rect {
    ui.available_rect_before_wrap().round_to_pixels(ui.pixels_per_point())
}

/// The pixels of `rect`.
pub fn area(ui: &egui::Ui, rect: egui::Rect) -> Rect {
    let pixels = |points: f32| ((points * ui.pixels_per_point()).round() as u32).max(1);
    Rect::of_size(pixels(rect.width()), pixels(rect.height()))
}

/// A rectangle of the canvas as points of the window.
pub fn to_points(ui: &egui::Ui, canvas: egui::Rect, cell: Rect) -> egui::Rect {
    let scale = 1.0 / ui.pixels_per_point();
    let min = canvas.min + egui::vec2(cell.x as f32, cell.y as f32) * scale;
    egui::Rect::from_min_size(min, egui::vec2(cell.width as f32, cell.height as f32) * scale)
}

/// A point of the window as a pixel of the canvas.
pub fn to_pixels(ui: &egui::Ui, canvas: egui::Rect, point: egui::Pos2) -> [f32; 2] {
    let offset = (point - canvas.min) * ui.pixels_per_point();
    [offset.x, offset.y]
}

/// Turns, shifts and zooms `camera` by the pointer on `response` and by the keys of
/// [`keys::view`]: middle drag (or right drag, or Alt and left drag) turns, with Shift it
/// shifts, the wheel zooms; where it has the focus, arrows turn, plus and minus zoom. True when the camera
/// moved.
pub fn navigate(ui: &egui::Ui, response: &egui::Response, camera: &mut Camera) -> bool {
    navigate_by(ui, response, camera, false)
}

/// As [`navigate`]; with `primary` a plain left drag turns too, where it has nothing else to do.
pub fn navigate_by(ui: &egui::Ui, response: &egui::Response, camera: &mut Camera, primary: bool) -> bool {
    let before = *camera;
    response.ctx.accesskit_node_builder(response.id, |node| {
        node.set_role(Role::Canvas);
        if node.label().is_none() {
            node.set_label("3D view");
            node.set_author_id("view");
        }
    });
    let (modifiers, scroll, zoom) =
        ui.input(|input| (input.modifiers, input.smooth_scroll_delta().y, input.zoom_delta()));
    let navigating = response.dragged_by(egui::PointerButton::Middle)
        || response.dragged_by(egui::PointerButton::Secondary)
        || ((primary || modifiers.alt) && response.dragged_by(egui::PointerButton::Primary));
    if navigating {
        let drag = response.drag_delta();
        if modifiers.matches_logically(Modifiers::SHIFT) && modifiers.shift {
            camera.pan(drag.x, drag.y, response.rect.height());
        } else {
            camera.orbit(drag.x, drag.y);
        }
    }
    if response.has_focus() {
        let arrows = EventFilter { horizontal_arrows: true, vertical_arrows: true, ..EventFilter::default() };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, arrows));
        let [right, down, nearer] =
            [(Key::ArrowRight, Key::ArrowLeft), (Key::ArrowDown, Key::ArrowUp), (Key::Plus, Key::Minus)]
                .map(|(more, less)| shortcut::steps(ui, more, less));
        if (right, down, nearer) != (0.0, 0.0, 0.0) {
            camera.orbit(KEY_DRAG * right, KEY_DRAG * down);
            camera.zoom(nearer);
        }
    }
    if response.hovered() {
        camera.zoom(scroll / 40.0 + zoom.ln() * 9.5);
    }
    if response.hovered() || response.has_focus() {
        for (shortcut, view) in [
            (keys::FRONT, View::Front),
            (keys::RIGHT, View::Right),
            (keys::ABOVE, View::Top),
            (keys::THREE_QUARTER, View::ThreeQuarter),
        ] {
            if shortcut.pressed(ui.ctx()) {
                camera.look(view);
            }
        }
    }
    *camera != before
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_view::{Background, Lights};

    #[test]
    fn a_marker_is_as_large_at_any_scale_of_the_window() {
        let marker = [Marker { position: [0.0; 3], radius_px: 6.0, color: [255, 0, 0, 255] }];
        let red = [1.0, 2.0].map(|scale| {
            let mut viewport = Viewport::new(&Screen::unseen(&Device::Processor));
            let ctx = egui::Context::default();
            ctx.options_mut(|options| options.zoom_factor = scale);
            let _ = ctx.run_ui(egui::RawInput::default(), |ui| {
                let rect = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(64.0, 64.0));
                let cell = |viewport| Cell {
                    viewport,
                    camera: Camera::default(),
                    lights: Lights::STUDIO,
                    background: Background::SLATE,
                    figures: &[],
                    markers: &marker,
                };
                viewport.draw(ui, rect, |shown| vec![cell(shown)]).unwrap();
            });
            let pixels = viewport.canvas().unwrap().pixels().unwrap().to_vec();
            let red = pixels.as_chunks::<4>().0.iter().filter(|[r, g, ..]| *r > 200 && *g < 100).count();
            red as f32 / (pixels.len() / 4) as f32
        });
        assert!(red[0] > 0.005 && (red[1] / red[0] - 1.0).abs() < 0.2, "{red:?}");
    }

    #[test]
    fn a_remark_has_a_ground_of_its_own_and_fits_a_narrow_picture() {
        check_remark("Late");
        check_remark(&"Frames were late: ".repeat(8));
    }

    /// The words lie whole on their ground, and that in the picture.
    fn check_remark(words: &str) {
        let ctx = egui::Context::default();
        let picture = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(300.0, 300.0));
        let output = ctx.run_ui(egui::RawInput::default(), |ui| remark(ui, picture, words.to_owned()));
        let mut plate = None;
        for clipped in &output.shapes {
            match &clipped.shape {
                egui::Shape::Rect(rect) => plate = Some(rect.rect),
                egui::Shape::Text(text) => {
                    let plate = plate.expect("something is behind it");
                    let words = text.visual_bounding_rect();
                    assert!(plate.contains_rect(words) && picture.contains_rect(plate), "{plate} {words}");
                    return;
                }
                _ => {}
            }
        }
        panic!("nothing is written");
    }

    #[test]
    fn a_picture_that_rests_is_drawn_again_where_the_theme_changes() {
        let mut viewport = Viewport::new(&Screen::unseen(&Device::Processor));
        let ctx = egui::Context::default();
        let drawn = [true, true, false, false, true].map(|dark| {
            let mut drawn = false;
            let _ = ctx.run_ui(egui::RawInput::default(), |ui| {
                ui.visuals_mut().dark_mode = dark;
                let rect = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(8.0, 8.0));
                drawn = viewport.draw(ui, rect, |_| Vec::new()).unwrap();
            });
            drawn
        });
        assert_eq!(drawn, [true, false, true, false, true]);
    }
}
