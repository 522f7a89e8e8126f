//! The show that runs in a window of its own: the current dance, the next one, and controls for both.

use chladni_music::{Action, Instrument, ItemId, Target};
use egui::{RichText, Ui};

use super::concert::Concert;
use super::lineage;
use super::wish::Wish;
use crate::studio::author_id::AuthorId;
use crate::studio::keys::music::{BLACKOUT, FREEZE, GO, LEAVE, NEXT_UP};
use crate::studio::theme;

/// Draws the bar.
pub fn show(ui: &mut Ui, concert: &Concert, wishes: &mut Vec<Wish>) {
    let instrument = concert.instrument();
    ui.horizontal_centered(|ui| {
        concert.preview(ui);
        ui.label(RichText::new("On stage").color(theme::palette(ui).weak));
        ui.label(
            RichText::new(concert.on_stage_now().map_or_else(String::new, |id| name(instrument, id)))
                .strong(),
        );
        ui.separator();
        ui.label(RichText::new("Next").color(theme::palette(ui).weak));
        let next = instrument.next_on_stage().map(|(id, _)| name(instrument, id));
        match &next {
            Some(name) => ui.label(RichText::new(name).strong()),
            None => ui.label("–").on_hover_text(NEXT_UP.tooltip(ui.ctx())),
        };
        let go = ui.add_enabled(next.is_some(), egui::Button::new("Go")).author_id("go");
        if go.on_hover_text(GO.tooltip(ui.ctx())).clicked() {
            wishes.push(Wish::Do(Action::Go));
        }
        let mut fader = instrument.fader();
        ui.spacing_mut().slider_width = 120.0;
        let label = ui.label("Fade").id;
        let slider = ui.add_enabled(next.is_some(), theme::slider(&mut fader, 0.0..=1.0).show_value(false));
        let tip = "From the one on stage to the next: to the other end, and back again for the one after";
        if slider.labelled_by(label).on_hover_text(tip).changed() {
            wishes.push(Wish::Do(Action::Crossfade { share: fader }));
        }
        ui.separator();
        for (on, text, key, target) in [
            (concert.house.is_black(), "Black", BLACKOUT, Target::Blackout),
            (concert.house.frozen, "Freeze", FREEZE, Target::Freeze),
        ] {
            let button = ui.selectable_label(on, text).author_id(target.name());
            if button.on_hover_text(key.tooltip(ui.ctx())).clicked() {
                wishes.push(Wish::Press(target));
            }
        }
        let leave = ui.button("Leave the stage").author_id("leave");
        if leave.on_hover_text(LEAVE.tooltip(ui.ctx())).clicked() {
            wishes.push(Wish::Do(Action::LeaveStage));
        }
    });
}

/// A dance's name.
fn name(instrument: &Instrument, id: ItemId) -> String {
    instrument.item(id).map_or_else(String::new, |item| lineage::called(instrument, item))
}
