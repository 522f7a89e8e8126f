//! How the stage is drawn in ink: a line of controls above it, while it is.

use chladni_view::ink::Ink;
use egui::Ui;

use crate::studio::author_id::AuthorId;
use crate::studio::theme;
use crate::work::Pen;

/// Points that a slider takes with its name and number.
const SLIDER: f32 = 215.0;

/// Points that a color takes with its name.
const COLOR: f32 = 80.0;

/// Draws the controls of `pen`.
pub fn show(ui: &mut Ui, pen: &mut Pen) {
    theme::group(ui, "Ink", |ui| {
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().slider_width = 56.0;
            let ink = &mut pen.ink;
            named(ui, "Detail", DETAIL, |ui| {
                ui.add(theme::slider(&mut ink.detail, 0.0..=2.0).fixed_decimals(2))
            });
            named(ui, "Hatching", HATCHING, |ui| {
                ui.add(theme::slider(&mut ink.hatching, 0.0..=1.0).fixed_decimals(2))
            });
            ui.label("Tones").on_hover_text(TONES);
            for (tones, name) in [(0, "None"), (2, "2"), (3, "3"), (Ink::MOST_TONES, "4")] {
                let button = ui.selectable_label(pen.ink.tones == tones, name);
                if button.author_id(format!("ink/tones/{tones}")).clicked() {
                    *pen = pen.toned(tones);
                }
            }
            named(ui, "Smoothing", SMOOTHING, |ui| {
                let slider = theme::slider(&mut pen.smoothing, 0.0..=Pen::MOST_SMOOTHING).fixed_decimals(3);
                ui.add(slider)
            });
            for (name, id, spoken, color) in [
                ("Ink", "ink/color", "Color of the ink", &mut pen.ink.color),
                ("Paper", "ink/paper", "Color of the paper", &mut pen.ink.paper),
            ] {
                beside_name(ui, COLOR, |ui| {
                    ui.label(name);
                    ui.color_edit_button_srgb(color).accessible_name(spoken).author_id(id);
                });
            }
            theme::checkbox(ui, &mut pen.exaggeration, "Wider where exaggerated")
                .author_id("ink/exaggeration")
                .on_hover_text("Lines are the wider the farther the shape is exaggerated there");
            let usual = Pen::default();
            if ui.add_enabled(*pen != usual, egui::Button::new("As usual")).clicked() {
                *pen = usual;
            }
        });
    });
}

const DETAIL: &str =
    "How many lines there are inside the contours: 0 none, 1 as a draftsman would, 2 far more";
const HATCHING: &str = "How far hatching reaches out of the shade: 0 none, 1 up to the light";
const TONES: &str =
    "Light as so few flat tones, the paper among them, with hatching over them where it is asked for";
const SMOOTHING: &str = "How far curvature is averaged before lines are drawn along it, as a share of the shape's size: \
                         more for a noisy scan, less for fine detail";

fn named(ui: &mut Ui, name: &str, tip: &str, control: impl FnOnce(&mut Ui) -> egui::Response) {
    beside_name(ui, SLIDER, |ui| {
        let label = ui.label(name).on_hover_text(tip).id;
        ui.label_inputs_by(label, |ui| {
            // A tip of the control itself would be read out as its name.
            control(ui).author_id(format!("ink/{}", name.to_lowercase()))
        });
    });
}

/// A name and its control, which take this many points.
fn beside_name(ui: &mut Ui, width: f32, content: impl FnOnce(&mut Ui)) {
    // They do not wrap together by themselves.
    if ui.available_size_before_wrap().x < width {
        ui.end_row();
    }
    // On the wrapping line itself the name would stand above the middle of the control.
    ui.horizontal(content);
}

#[cfg(test)]
mod tests {
    use egui_kittest::Harness;
    use egui_kittest::kittest::{NodeT, Queryable};

    use super::*;

    #[test]
    fn names_of_colors_stand_beside_them_however_the_line_wraps() {
        let mut pen = Pen::default();
        let mut window = Harness::builder().build_ui(move |ui| show(ui, &mut pen));
        theme::install(&window.ctx);
        for width in (300_u16..1300).step_by(25) {
            window.set_size(egui::vec2(f32::from(width), 300.0));
            window.run_steps(3);
            for (name, id) in [("Ink", "ink/color"), ("Paper", "ink/paper")] {
                let swatch = window.get_by(move |node| node.author_id() == Some(id)).rect();
                // The group of all has a name, too.
                let mut named = window.get_all_by_label(name);
                let label = named.find(|node| node.accesskit_node().role() == egui::Role::Label);
                let label = label.unwrap().rect();
                let apart = (label.center().y - swatch.center().y).abs();
                assert!(apart < 1.0 && label.right() < swatch.left(), "{name} at {width}: {label}, {swatch}");
            }
        }
    }
}
