//! Picking landmarks on the shape and its template, side by side.

mod drawing;
mod list;

use std::sync::Arc;

use chladni_caricature::{LayerId, Matched, Property, Template};
use chladni_match::MatchSettings;
use chladni_mesh::{Estimate, Orientation, TriMesh};
use chladni_view::{Cell, Marker};
use egui::{Color32, PointerButton, Pos2, Ui};

pub use list::show_list;

use self::drawing::{cell_of, hint, numbers};
use super::edits::Edits;
use super::look::Portrayal;
use super::overlay::{backdrop, mark_place, show_name};
use super::session::Session;
use crate::studio::author_id::AuthorId;
use crate::studio::job::{self, Job};
use crate::studio::keys::{self, caricature::FIT};
use crate::studio::room::Shared;
use crate::studio::theme;
use crate::studio::viewport::{self, Viewport};
use crate::work::landmarks::{self, Gesture, Picks, Side, Which};
use crate::work::{Aside, Error, template_mesh};

/// Said where another template takes the place of the one on which they were picked.
pub const GONE: &str = "The landmarks belonged to the template before and are gone: pick new ones, or undo.";

/// How near a landmark the pointer must be to grab it, in window points.
const GRIP: f32 = 12.0;

/// The color of landmark `index`.
pub fn color(index: usize) -> Color32 {
    let [r, g, b] = landmarks::color(index);
    Color32::from_rgb(r, g, b)
}

/// The view of both shapes while landmarks of one layer are picked.
pub struct Picking {
    layer: LayerId,
    template: Template,
    /// The renewals of templates when it was begun.
    renewals: usize,
    viewport: Viewport,
    shape: Side,
    /// `None` while it is read.
    other: Option<Side>,
    /// Nothing is known of how the template stands: it does as the shape.
    follows: bool,
    reading: Option<Job<(TriMesh, Estimate)>>,
    picks: Picks,
    /// The match whose confidence is shown.
    shown_match: Option<Arc<Matched>>,
    /// The dots of the last picture on either side, and how it looked.
    drawn: Option<(Vec<Dots>, Portrayal)>,
}

/// Numbers of landmarks, and their vertices.
type Dots = Vec<(usize, u32)>;

impl Picking {
    /// Opens both shapes for the selected layer; `None` where its template is not a mesh.
    pub fn begin(session: &Session, shared: &Shared<'_>) -> Option<Result<Self, Error>> {
        let (layer, chosen) = session.chosen()?;
        let template = chosen.template.clone();
        if !template.is_mesh() {
            return None;
        }
        let viewport = Viewport::new(shared.screen);
        let shape = match Side::new(viewport.device(), &session.subject.mesh, session.stands()) {
            Ok(shape) => shape,
            Err(error) => return Some(Err(error.into())),
        };
        let wanted = template.clone();
        let reading = Job::start("Reading the template", &shared.ctx, move |task| {
            let mesh = template_mesh(&wanted, &Aside::new(task))?;
            let mesh = mesh.ok_or_else(|| Error::Input(format!("{wanted} is no mesh")))?;
            let stands = Estimate::of(&mesh, wanted.known(), task)?;
            Ok((mesh, stands))
        });
        Some(Ok(Self {
            layer,
            template,
            renewals: session.renewals(),
            viewport,
            shape,
            other: None,
            follows: false,
            reading: Some(reading),
            picks: Picks::default(),
            shown_match: None,
            drawn: None,
        }))
    }

    /// Whether it still belongs to the selected layer.
    pub fn belongs_to(&self, session: &Session) -> bool {
        session.chosen().is_some_and(|(id, layer)| id == self.layer && layer.template == self.template)
            && self.renewals == session.renewals()
    }

    /// Whether half a pair waits for its other half.
    pub fn has_pending(&self) -> bool {
        self.picks.pending().is_some()
    }

    /// Forgets half a pair; false where there was none.
    pub fn drop_pending(&mut self) -> bool {
        self.picks.drop_pending()
    }

    /// Draws both shapes and handles the pointer; shows how far the match is to be trusted where
    /// `confidence` is wanted.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        session: &Session,
        edits: &mut Edits,
        (look, confidence): (Portrayal, bool),
        shared: &mut Shared<'_>,
    ) -> Result<(), Error> {
        self.poll(session.stands())?;
        self.stand(session.stands());
        self.update_confidence(session.selected_match().filter(|_| confidence))?;
        let Some(settings) = session.project().layer(self.layer).map(|layer| layer.matching.clone()) else {
            return Ok(());
        };
        let rect = viewport::whole_pixels(ui);
        let half = egui::vec2(rect.width() / 2.0, rect.height());
        let left = egui::Rect::from_min_size(rect.min, half);
        let right = left.translate(egui::vec2(half.x, 0.0));
        let areas = [(Which::Shape, left), (Which::Template, right)];
        let gestures = areas.map(|(which, area)| (which, self.interact(ui, which, area, rect, &settings)));
        self.draw(ui, rect, [left, right], &settings, look)?;
        if let Some(matched) = session.selected_match() {
            self.mark_counterpart(ui, rect, areas, matched);
        }
        for (which, gesture) in gestures {
            if let Some(gesture) = gesture {
                self.act(which, gesture, settings.clone(), edits, shared);
            }
        }
        if let Some(reading) = &self.reading {
            ui.scope_builder(egui::UiBuilder::new().max_rect(right.shrink(24.0)), |ui| {
                job::show_progress(ui, reading)
            });
        }
        Ok(())
    }

    fn poll(&mut self, beside: Orientation) -> Result<(), Error> {
        if let Some(read) = self.reading.as_ref().and_then(Job::ended) {
            self.reading = None;
            let (mesh, found) = read?;
            // Shapes that belong together mostly use the same axes.
            self.follows = found.in_doubt;
            let stands = if self.follows { beside } else { found.orientation };
            self.other = Some(Side::new(self.viewport.device(), &mesh, stands)?);
            self.viewport.invalidate();
        }
        Ok(())
    }

    /// Turns the view when the shape's orientation changes.
    fn stand(&mut self, stands: Orientation) {
        let template = self.other.as_mut().filter(|_| self.follows);
        for side in [Some(&mut self.shape), template].into_iter().flatten() {
            if side.camera.stands != stands {
                side.camera.stands = stands;
                side.refit();
                self.viewport.invalidate();
            }
        }
    }

    fn update_confidence(&mut self, matched: Option<&Arc<Matched>>) -> Result<(), Error> {
        if matched.map(Arc::as_ptr) != self.shown_match.as_ref().map(Arc::as_ptr) {
            self.shown_match = matched.cloned();
            let confidence = matched.map(|matched| matched.confidence.as_slice());
            let device = self.viewport.device();
            self.shape.set_confidence(device, confidence)?;
            self.viewport.invalidate();
        }
        Ok(())
    }

    fn side(&mut self, which: Which) -> Option<&mut Side> {
        match which {
            Which::Shape => Some(&mut self.shape),
            Which::Template => self.other.as_mut(),
        }
    }

    /// Steers the camera of one shape and finds the gesture of the pointer there.
    fn interact(
        &mut self,
        ui: &mut Ui,
        which: Which,
        area: egui::Rect,
        whole: egui::Rect,
        settings: &MatchSettings,
    ) -> Option<Gesture> {
        let cell = cell_of(ui, area, whole);
        let response =
            ui.interact(area, ui.scope_id().with(("landmarks", which as u8)), egui::Sense::click_and_drag());
        let (name, id) = match which {
            Which::Shape => ("Landmarks on the shape", "landmarks/shape"),
            Which::Template => ("Landmarks on the template", "landmarks/template"),
        };
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Canvas, true, name));
        let response = response.author_id(id);
        let held = self.picks.held(which);
        let side = self.side(which)?;
        side.fit(cell.aspect());
        let ctx = ui.ctx();
        let home = response.hovered() && (FIT.pressed(ctx) || keys::view::FIT.pressed(ctx));
        if home {
            side.refit();
            side.fit(cell.aspect());
        }
        let pixel = |at: Pos2| viewport::to_pixels(ui, whole, at);
        let under = |side: &Side, at: Pos2| {
            let [x, y] = pixel(at);
            side.vertex_at(x, y, cell)
        };
        let at = response.interact_pointer_pos().or(response.hover_pos());
        // A drag is noticed some way from where it began.
        let began = ui.input(|input| input.pointer.press_origin()).filter(|_| response.drag_started());
        let near = began.or(at).and_then(|at| {
            let grip = GRIP * ui.pixels_per_point();
            side.near(which, &settings.landmarks, pixel(at), grip, cell)
        });
        let primary = PointerButton::Primary;
        // A left drag that holds no landmark turns the shape.
        let began_free = response.drag_started_by(primary) && near.is_none();
        let turning = ui.scope_id().with(("turning", which as u8));
        if response.drag_started() || !response.dragged() {
            ui.data_mut(|data| data.insert_temp(turning, began_free));
        }
        let free = ui.data(|data| data.get_temp(turning).unwrap_or(false));
        let moved = viewport::navigate_by(ui, &response, &mut side.camera, free) || home;
        let steering = ui.input(|input| input.modifiers.alt);
        let gesture = if steering {
            None
        } else if let Some((index, vertex)) = held {
            if response.dragged_by(primary) {
                Some(Gesture::Hold(index, at.and_then(|at| under(side, at)).unwrap_or(vertex)))
            } else {
                Some(Gesture::Drop)
            }
        } else if response.drag_started_by(primary) {
            near.map(|(index, vertex)| Gesture::Hold(index, vertex))
        } else if response.secondary_clicked() {
            near.map(|(index, _)| Gesture::Remove(index))
        } else if response.clicked_by(primary) && near.is_none() {
            at.and_then(|at| under(side, at)).map(Gesture::Pick)
        } else {
            None
        };
        if near.is_some() || held.is_some() {
            ui.ctx().set_cursor_icon(egui::CursorIcon::Grab);
        } else if response.hovered() {
            ui.ctx().set_cursor_icon(egui::CursorIcon::Crosshair);
        }
        if moved {
            self.viewport.invalidate();
        }
        gesture
    }

    /// Marks, on the other shape, where the match puts the place under the pointer.
    fn mark_counterpart(
        &self,
        ui: &Ui,
        rect: egui::Rect,
        areas: [(Which, egui::Rect); 2],
        matched: &Matched,
    ) {
        let (Some(other), Some(on_template)) = (&self.other, &matched.on_template) else { return };
        let hovered = ui.ctx().pointer_hover_pos().filter(|_| !ui.input(|input| input.pointer.any_down()));
        let sides = [&self.shape, other];
        for (i, (which, area)) in areas.into_iter().enumerate() {
            let Some(at) = hovered.filter(|at| area.contains(*at)) else { continue };
            let [x, y] = viewport::to_pixels(ui, rect, at);
            let Some(vertex) = sides[i].vertex_at(x, y, cell_of(ui, area, rect)) else { continue };
            let over = 1 - i;
            let place = landmarks::counterpart(which, vertex, on_template, sides);
            let area = areas[over].1;
            let seen = place.and_then(|place| sides[over].pixel_of(place, cell_of(ui, area, rect)));
            if let Some(([x, y], faces)) = seen {
                let at = rect.min + egui::vec2(x, y) / ui.pixels_per_point();
                mark_place(ui, area, at, faces);
            }
        }
    }

    fn act(
        &mut self,
        which: Which,
        gesture: Gesture,
        mut settings: MatchSettings,
        edits: &mut Edits,
        shared: &mut Shared<'_>,
    ) {
        match self.picks.act(which, gesture, &settings.landmarks) {
            Ok(Some(landmarks)) => settings.landmarks = landmarks,
            Ok(None) => return,
            Err(why) => return shared.notices.warn(why.to_string()),
        }
        edits.set(self.layer, Property::Matching(settings));
    }

    fn draw(
        &mut self,
        ui: &mut Ui,
        rect: egui::Rect,
        areas: [egui::Rect; 2],
        settings: &MatchSettings,
        look: Portrayal,
    ) -> Result<(), Error> {
        let cells = areas.map(|area| cell_of(ui, area, rect));
        let material = look.material();
        let (background, lights) = (backdrop(ui), look.lights());
        let sides = [(Which::Shape, Some(&self.shape)), (Which::Template, self.other.as_ref())];
        let ends: Vec<Dots> =
            sides.iter().map(|(which, _)| self.picks.ends(*which, &settings.landmarks)).collect();
        let markers: Vec<Vec<Marker>> = sides
            .iter()
            .zip(&ends)
            .map(|((_, side), ends)| side.map_or_else(Vec::new, |side| side.dots(ends)))
            .collect();
        let figures: Vec<Vec<chladni_view::Figure<'_>>> =
            sides.iter().map(|(_, side)| side.iter().map(|side| side.figure(material)).collect()).collect();
        // They may also change outside of this view: by a step back, or in the list.
        if self.drawn.as_ref().is_none_or(|(before, with)| *before != ends || *with != look) {
            self.viewport.invalidate();
            self.drawn = Some((ends.clone(), look));
        }
        let drawn = self.viewport.show(ui, rect, |_| {
            let each = sides.iter().zip(cells).zip(figures.iter().zip(&markers));
            each.map(|(((_, side), viewport), (figures, markers))| Cell {
                viewport,
                camera: side.map_or_else(Default::default, |side| side.camera),
                lights,
                background,
                figures,
                markers,
            })
            .collect()
        });
        drawn?;
        for ((((_, side), ends), area), name) in sides.iter().zip(&ends).zip(areas).zip(["Shape", "Template"])
        {
            show_name(ui, area, name, theme::palette(ui).weak);
            if let Some(side) = side {
                numbers(ui, side, ends, area, rect);
            }
        }
        ui.painter().vline(areas[1].left(), rect.y_range(), egui::Stroke::new(1.0, theme::palette(ui).line));
        hint(ui, rect, &self.picks.hint(settings.landmarks.len()));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::studio::screen::Screen;
    use chladni_match::Landmark;
    use chladni_mesh::samples::icosphere;
    use chladni_view::Device;

    #[test]
    fn a_view_that_rests_shows_landmarks_and_materials_that_change_elsewhere() {
        let ball = icosphere(1);
        let viewport = Viewport::new(&Screen::unseen(&Device::Processor));
        let mut picking = Picking {
            layer: LayerId(1),
            template: Template::Ellipsoid,
            renewals: 0,
            shape: Side::new(viewport.device(), &ball, Orientation::Y_UP).unwrap(),
            viewport,
            other: None,
            follows: false,
            reading: None,
            picks: Picks::default(),
            shown_match: None,
            drawn: None,
        };
        let ctx = egui::Context::default();
        let rect = egui::Rect::from_min_size(Pos2::ZERO, egui::vec2(120.0, 60.0));
        let half = egui::Rect::from_min_size(Pos2::ZERO, egui::vec2(60.0, 60.0));
        let areas = [half, half.translate(egui::vec2(60.0, 0.0))];
        picking.shape.fit(1.0);
        let mut seen = |count: u32, material: usize| {
            let landmarks = (0..count).map(|vertex| Landmark { shape: vertex, template: 0 }).collect();
            let settings = MatchSettings { landmarks, ..MatchSettings::default() };
            let look = Portrayal { material, ..Portrayal::default() };
            let _ = ctx.run_ui(egui::RawInput::default(), |ui| {
                picking.draw(ui, rect, areas, &settings, look).unwrap();
            });
            picking.viewport.canvas().unwrap().pixels().unwrap().to_vec()
        };
        let without = seen(0, 0);
        let dotted = seen(42, 0);
        assert!(without != dotted && dotted != seen(42, 1) && without == seen(0, 0));
    }
}
