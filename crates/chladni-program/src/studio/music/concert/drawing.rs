//! The picture of all items, which is shown once its brightness is known.

use chladni_mesh::surface::Detail;
use chladni_music::{Framing, Switch, Veil};
use chladni_view::{Device, Figure, Rect, Topology};
use egui::Ui;

use super::super::outgoing::Over;
use super::super::projection::Projection;
use super::Concert;
use super::coarse;
use super::frame::Frame;
use super::stillness::StillPicture;
use crate::studio::room::Shared;
use crate::studio::theme;
use crate::work::{Error, Staging, look_on_stage};

/// So many times a trail's length after the last movement, less than a hundredth of it is left.
const TRAILS_FADE: f64 = 5.0;

impl Concert {
    pub(super) fn draw(
        &mut self,
        ui: &mut Ui,
        shared: &Shared<'_>,
        (rect, area): (egui::Rect, Rect),
        cells: &[Rect],
        (frame, framing): (&Frame, Option<Framing>),
        pose: u64,
    ) -> Result<(), Error> {
        let flash_area = self.instrument.parameters().flash_area();
        self.pane.limit(flash_area.is_some());
        let from = (&self.viewpoint, framing.as_ref());
        let staged = self.staging.set(area, cells.len(), from, &frame.look, frame.reaction, &self.instrument);
        self.pane.viewport.finish(staged.look.finish, frame.at_secs);
        self.hang()?;
        let shown = StillPicture { pose, staged: staged.clone() };
        let has_changed = self.pane.shown.as_ref() != Some(&shown);
        if has_changed {
            self.pane.changed_secs = frame.at_secs;
        }
        let trails_secs = TRAILS_FADE * f64::from(shown.staged.look.finish.trail_secs);
        let is_new = has_changed || (0.0..trails_secs).contains(&(frame.at_secs - self.pane.changed_secs));
        self.moving |= is_new;
        if is_new {
            self.pane.viewport.invalidate();
        }
        let buffers = self.deformed.buffers()?;
        // Beside a stage in a window of its own the gallery and a close-up have no sand: that lies on the stage.
        let has_sand = self.draws_stage || !frame.is_apart;
        let on_stage = look_on_stage(&self.instrument, shared.settings.music.look());
        let grains = Some(self.sand.drawn(&on_stage)).filter(|all| has_sand && all.len() == cells.len());
        let grains = grains.unwrap_or_default();
        let mut drawn_vertices = 0;
        let figures: Vec<Figure<'_>> = (0..)
            .zip(cells)
            .map(|(item, cell)| {
                let pixels = cell.width as usize * cell.height as usize;
                let seen = self.seen.get(item).copied().unwrap_or(0);
                let needed = coarse::vertices_needed(seen, pixels);
                let detail = self.details.iter().rev().find(|(detail, _)| detail.vertices >= needed);
                drawn_vertices += detail.map_or(self.staging.rest().len(), |(detail, _)| detail.vertices);
                let topology = detail.map_or(&self.deformed.topology, |(_, topology)| topology);
                Figure {
                    grains: grains.get(item).copied(),
                    ..staged.figure(topology, &buffers, item, &self.wardrobe)
                }
            })
            .collect();
        self.drawn_vertices = drawn_vertices / cells.len().max(1);
        let behind = theme::palette(ui).stage;
        ui.painter().rect_filled(rect, 0.0, behind);
        if let Some(flash_area) = flash_area {
            // The picture is shown once its brightness is known; until then the previous one is shown, and no new
            // one is started.
            self.pane.judge()?;
            if !self.pane.glimpse.is_coming() {
                let drawn = self.pane.viewport.draw(ui, rect, |_| staged.cells(&figures));
                if drawn? && let Some(canvas) = self.pane.viewport.canvas() {
                    self.pane.glimpse.begin(self.pane.viewport.device(), canvas, behind);
                    // A picture drawn by the processor can be judged at once.
                    self.pane.judge()?;
                }
                self.pane.shown = Some(shown);
            }
            self.pane.guard.set_area(flash_area);
            self.moving |= self.pane.glimpse.is_coming();
        } else {
            self.pane.viewport.draw(ui, rect, |_| staged.cells(&figures))?;
            self.pane.shown = Some(shown);
        }
        self.present(ui, shared.settings.music.projection, rect, flash_area.is_some())
    }

    /// Shows the picture, on stage as the projector needs it, behind all that covers it, and gives it to others.
    fn present(
        &mut self,
        ui: &Ui,
        projection: Projection,
        rect: egui::Rect,
        is_kept: bool,
    ) -> Result<(), Error> {
        let projection = if self.draws_stage { projection } else { Projection::default() };
        if let Some(texture) = self.pane.texture() {
            projection.paint(ui, rect, texture);
        }
        self.cover(is_kept);
        self.pane.lay_veil(ui, rect);
        self.send(is_kept)
    }

    /// Chooses the veil: the black of the stage and, where flashes are limited, what the guard adds to it.
    fn cover(&mut self, limited: bool) {
        let (dark, changes) = if self.draws_stage { self.house.opacity(self.seconds) } else { (0, false) };
        let pane = &mut self.pane;
        pane.veil = if limited && pane.judged {
            pane.guard.veil_over_dark(self.seconds, pane.glimpse.histogram(), dark)
        } else {
            Veil::black(dark)
        };
        self.moving |= changes || pane.veil != Veil::black(dark);
    }

    /// Gives films and other programs the picture of the stage or, where there is none, the window.
    pub(super) fn send(&mut self, is_kept: bool) -> Result<(), Error> {
        let seen = self.draws_stage || !self.on_stage();
        let canvas = if is_kept { self.pane.viewport.kept_canvas() } else { self.pane.viewport.canvas() };
        let Some(canvas) = canvas.filter(|_| seen) else { return Ok(()) };
        let title = if self.draws_stage { self.title_opacity(self.seconds) } else { 0.0 };
        let over = Over { veil: self.pane.veil, title: self.song_title.seen(title) };
        self.outgoing.take(self.pane.viewport.device(), canvas, self.seconds, over, &mut self.song_title)
    }

    /// How opaque the song's title is on stage: not at all where that is frozen.
    pub fn title_opacity(&self, now_secs: f64) -> f32 {
        if self.house.frozen { 0.0 } else { self.house.light() * self.song_title.opacity(now_secs) }
    }

    /// Shows the last picture again, as it was but for the veil, which may change.
    pub(super) fn repaint(
        &mut self,
        ui: &mut Ui,
        projection: Projection,
        rect: egui::Rect,
    ) -> Result<(), Error> {
        ui.allocate_rect(rect, egui::Sense::hover());
        let limited = self.instrument.parameters().is_on(Switch::FlashLimit);
        self.pane.limit(limited);
        self.present(ui, projection, rect, limited)
    }
}

/// Levels of a shape of these `triangles`, with their own on the device.
pub fn on_device(
    device: &Device,
    (staging, triangles): (&Staging, &[[u32; 3]]),
    details: impl IntoIterator<Item = Detail>,
) -> Result<Vec<(Detail, Topology)>, Error> {
    let upload = |detail: Detail| {
        staging.topology(device, triangles, Some(&detail.triangles)).map(|topology| (detail, topology))
    };
    Ok(details.into_iter().map(upload).collect::<Result<_, _>>()?)
}
