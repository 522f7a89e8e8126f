//! The drawer at the right of the room, and its content.

use chladni_music::Action;
use egui::{RichText, ScrollArea, Ui};

use super::concert::Concert;
use super::harmonics::CELLS;
use super::listening::Listening;
use super::preferences::with_lasting;
use super::remote::Remote;
use super::shelf::Shelf;
use super::songs::{self, Devices};
use super::view::View;
use super::wish::Wish;
use super::{knobs, look, voices};
use crate::studio::author_id::AuthorId;
use crate::studio::icon::{self, Icon};
use crate::studio::room::Shared;
use crate::studio::theme;

/// One drawer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Drawer {
    /// Knobs and switches.
    #[default]
    Knobs,
    /// Playlist and live input.
    Songs,
    /// Favorites and presets.
    Shelf,
    /// Materials, lights and the stage's screen.
    Look,
    /// Layers as voices, and symmetry.
    Body,
    /// MIDI and OSC.
    Remote,
}

const DRAWERS: [(Drawer, Icon, &str, &str); 6] = [
    (Drawer::Knobs, Icon::SlidersHorizontal, "drawer/knobs", "Knobs"),
    (Drawer::Songs, Icon::ListMusic, "drawer/songs", "Songs"),
    (Drawer::Shelf, Icon::Library, "drawer/shelf", "Shelf"),
    (Drawer::Look, Icon::Palette, "drawer/look", "Look"),
    (Drawer::Body, Icon::Drama, "drawer/body", "Body"),
    (Drawer::Remote, Icon::Cable, "drawer/remote", "Remote"),
];

/// State of the drawers between frames.
#[derive(Default)]
pub struct Drawers {
    /// The one that is open.
    pub open: Drawer,
    /// Presets.
    pub shelf: Shelf,
    /// Controllers.
    pub remote: Remote,
    /// The corners of the projected picture are being moved.
    pub adjusts: bool,
    devices: Devices,
}

impl Drawers {
    /// Draws the tabs and the open drawer.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        concert: &Concert,
        listening: &mut Listening,
        shared: &mut Shared<'_>,
        wishes: &mut Vec<Wish>,
    ) {
        self.tabs(ui);
        let instrument = concert.instrument();
        ScrollArea::vertical().id_salt(self.open as usize).show(ui, |ui| match self.open {
            Drawer::Knobs => knobs::show(ui, instrument, !concert.voice_names().is_empty(), wishes),
            Drawer::Songs => {
                let preferences = &mut shared.settings.music;
                songs::show(ui, listening, &mut self.devices, preferences, shared.notices, wishes);
            }
            Drawer::Shelf => {
                self.shelf.ready(shared.folders.dances.as_deref(), shared.notices);
                self.shelf.show(ui, instrument, shared.notices, wishes);
            }
            Drawer::Look => {
                // The controls edit the preferences, so these hold the look that is seen while they are drawn. If nothing
                // was changed, the show's own look goes back; otherwise the autopilot's look ends.
                let of_show = shared.settings.music.looks();
                let seen = look::seen(instrument, of_show.clone());
                shared.settings.music.look_like(&seen);
                let shape = (concert.standing(), concert.has_own_colors());
                look::show(ui, shared, shape, &mut self.adjusts, wishes);
                let now = shared.settings.music.looks();
                if now == with_lasting(seen, &now) {
                    shared.settings.music.look_like(&with_lasting(of_show, &now));
                } else if instrument.look().is_some() {
                    wishes.push(Wish::Do(Action::SetLook { look: String::new() }));
                }
            }
            Drawer::Remote => self.remote.show(ui, shared, listening, wishes),
            Drawer::Body => {
                voices::show(ui, instrument, concert.voice_names(), wishes);
                symmetry(ui, concert, wishes);
            }
        });
    }

    fn tabs(&mut self, ui: &mut Ui) {
        ui.add_space(theme::GAP_SMALL);
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            let width = (ui.available_width() - 2.0 * DRAWERS.len() as f32) / DRAWERS.len() as f32;
            for (drawer, mark, id, name) in DRAWERS {
                let text = RichText::new(icon::text(mark)).size(17.0);
                let tab = egui::Button::selectable(self.open == drawer, text);
                let tab = ui.add_sized([width, 30.0], tab);
                tab.widget_info(|| {
                    egui::WidgetInfo::selected(egui::Role::Tab, true, self.open == drawer, name)
                });
                if tab.author_id(id).on_hover_text(name).clicked() {
                    self.open = drawer;
                }
            }
        });
        ui.separator();
    }
}

fn symmetry(ui: &mut Ui, concert: &Concert, wishes: &mut Vec<Wish>) {
    ui.add_space(theme::GAP_LARGE);
    ui.label(RichText::new("Symmetry").strong());
    let harmonics = concert.harmonics();
    let [symmetric, antisymmetric, undecided] = harmonics.class_counts();
    let text = format!("{symmetric} symmetric, {antisymmetric} antisymmetric, {undecided} undecided");
    ui.label(text);
    theme::weak(ui, harmonics.method());
    let shown = match concert.view() {
        View::Harmonics(first) => Some(first),
        _ => None,
    };
    let button = ui.selectable_label(shown.is_some(), icon::label(Icon::FlipHorizontal2, "Show harmonics"));
    if button.author_id("show-harmonics").clicked() {
        let first = harmonics.first_waving();
        wishes.push(Wish::Show(if shown.is_some() { View::Gallery } else { View::Harmonics(first) }));
    }
    if let Some(first) = shown {
        let last = harmonics.count().saturating_sub(1);
        let mut at = first;
        let slider = theme::slider(&mut at, harmonics.first_waving()..=last).step_by((CELLS - 1) as f64);
        if ui.add(slider).on_hover_text("The first harmonic that is shown").changed() {
            wishes.push(Wish::Show(View::Harmonics(at)));
        }
    }
    let pace = concert.pace();
    ui.add_space(theme::GAP_LARGE);
    ui.label(RichText::new("Pace").strong());
    let used = pace.harmonics().map_or(harmonics.count(), |k| (k as usize).min(harmonics.count()));
    let text = format!(
        "At most {used} of {} harmonics, {:.1} ms a frame before drawing",
        harmonics.count(),
        1e3 * pace.mean_secs()
    );
    theme::weak(ui, text);
    theme::weak(ui, concert.means());
    let (all, drawn) = concert.drawn_vertices();
    if drawn < all {
        let about = 100 * drawn.div_ceil(100);
        let text = format!(
            "The processor draws here: of {all} vertices it shows as many as a picture needs, now about {about}."
        );
        theme::weak(ui, text);
    }
}
