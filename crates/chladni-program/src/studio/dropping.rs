//! A sign of what dropping does, while files are held over the window.

use std::path::PathBuf;

use egui::{Align2, Area, Context, Frame, Id, Order, RichText, Vec2};

use crate::work::shown_name;

/// Shows what a drop `does`.
pub fn show(ctx: &Context, does: &str) {
    let area = Area::new(Id::unique("dropping")).order(Order::Tooltip).interactable(false);
    area.anchor(Align2::CENTER_CENTER, Vec2::ZERO).show(ctx, |ui| {
        Frame::popup(ui.style()).inner_margin(16.0).show(ui, |ui| ui.label(RichText::new(does).heading()));
    });
}

/// Files as the sign names them: the first, and how many more there are.
pub fn named(paths: &[PathBuf]) -> Option<String> {
    let [first, others @ ..] = paths else { return None };
    let first = shown_name(first);
    Some(match others.len() {
        0 => first.into_owned(),
        more => format!("{first} and {more} more"),
    })
}
