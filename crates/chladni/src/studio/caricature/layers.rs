//! The stack of layers: names, eyes, solo, order. The topmost layer is the topmost row.

use chladni_caricature::{Action, Layer, LayerId, Project, Property, Template};
use egui::{RichText, Ui};

use super::edits::Edits;
use crate::studio::icon::{self, Icon};
use crate::studio::theme;

/// What the list itself remembers.
#[derive(Debug, Default)]
pub struct LayerList {
    renaming: Option<(LayerId, String)>,
}

impl LayerList {
    /// Draws the list and its buttons; `selected` is the layer that the other panels edit.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        project: &Project,
        selected: &mut Option<LayerId>,
        edits: &mut Edits,
    ) {
        ui.horizontal(|ui| {
            ui.label(RichText::new("Layers").strong());
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                stack_buttons(ui, project, *selected, edits);
            });
        });
        if project.layers().is_empty() {
            ui.add_space(theme::GAP_SMALL);
            ui.label(
                RichText::new("A layer exaggerates the shape against a template. Add one to begin.")
                    .color(theme::palette(ui).weak),
            );
            return;
        }
        let count = project.layers().len();
        let mut dropped: Option<(LayerId, usize)> = None;
        for (index, (id, layer)) in project.layers().iter().enumerate().rev() {
            let row = ui.push_id(id.0, |ui| self.row(ui, project, *id, layer, selected, edits)).inner;
            row.dnd_set_drag_payload(*id);
            if let Some(dragged) = row.dnd_release_payload::<LayerId>() {
                dropped = Some((*dragged, index));
            } else if row.dnd_hover_payload::<LayerId>().is_some() {
                let line = egui::Stroke::new(2.0, theme::palette(ui).accent);
                ui.painter().hline(row.rect.x_range(), row.rect.top() - 3.0, line);
            }
        }
        if let Some((layer, index)) = dropped {
            edits.once(Action::Move { layer, index: index.min(count - 1) });
        }
    }

    fn row(
        &mut self,
        ui: &mut Ui,
        project: &Project,
        id: LayerId,
        layer: &Layer,
        selected: &mut Option<LayerId>,
        edits: &mut Edits,
    ) -> egui::Response {
        let palette = theme::palette(ui);
        let chosen = *selected == Some(id);
        let fill = if chosen { ui.visuals().selection.bg_fill } else { palette.card };
        let frame =
            egui::Frame::new().fill(fill).corner_radius(6.0).inner_margin(egui::Margin::symmetric(8, 5));
        let inner = frame.show(ui, |ui| {
            ui.horizontal(|ui| {
                let (eye, tip) = if layer.enabled {
                    (Icon::Eye, "Hide this layer")
                } else {
                    (Icon::EyeOff, "Show this layer")
                };
                if icon_button(ui, eye, tip).clicked() {
                    edits.set(id, Property::Enabled(!layer.enabled));
                }
                let text = RichText::new(&layer.name);
                let text = if project.acts(layer) { text } else { text.color(palette.weak) };
                self.name(ui, id, text, edits);
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    let solo = RichText::new(icon::text(Icon::Headphones));
                    let solo = if layer.solo { solo.color(palette.accent) } else { solo.color(palette.weak) };
                    if ui.add(egui::Button::new(solo).frame(false)).on_hover_text("Only this layer").clicked()
                    {
                        edits.set(id, Property::Solo(!layer.solo));
                    }
                    ui.label(
                        RichText::new(format!("μ {:.2}", layer.effective_mu())).small().color(palette.weak),
                    );
                });
            });
        });
        let response = inner.response.interact(egui::Sense::click_and_drag());
        if response.clicked() {
            *selected = Some(id);
        }
        if response.double_clicked() {
            self.renaming = Some((id, layer.name.clone()));
        }
        response.on_hover_text("Click to edit, double-click to rename, drag to reorder")
    }

    fn name(&mut self, ui: &mut Ui, id: LayerId, text: RichText, edits: &mut Edits) {
        let Some((_, draft)) = self.renaming.as_mut().filter(|(layer, _)| *layer == id) else {
            ui.add(egui::Label::new(text).truncate().selectable(false));
            return;
        };
        let field = ui.add(egui::TextEdit::singleline(draft).desired_width(120.0));
        field.request_focus();
        let (enter, escape) =
            ui.input(|input| (input.key_pressed(egui::Key::Enter), input.key_pressed(egui::Key::Escape)));
        if escape {
            self.renaming = None;
        } else if enter || field.clicked_elsewhere() {
            if !draft.trim().is_empty() {
                edits.set(id, Property::Name(draft.trim().to_owned()));
            }
            self.renaming = None;
        }
    }
}

/// A frameless button of one icon.
pub fn icon_button(ui: &mut Ui, mark: Icon, tip: &str) -> egui::Response {
    let response = ui.add(egui::Button::new(icon::text(mark)).frame(false));
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, tip));
    response.on_hover_text(tip)
}

fn stack_buttons(ui: &mut Ui, project: &Project, selected: Option<LayerId>, edits: &mut Edits) {
    if let Some(layer) = selected {
        if icon_button(ui, Icon::Trash2, "Delete the layer").clicked() {
            edits.once(Action::Remove(layer));
        }
        if icon_button(ui, Icon::Copy, "Duplicate the layer").clicked() {
            edits.once(Action::Duplicate(layer));
        }
    }
    ui.menu_button(icon::label(Icon::Plus, "Add"), |ui| {
        for (name, tip, template) in starting_points() {
            if ui.button(name).on_hover_text(tip).clicked() {
                let name = format!("{name} {}", project.layers().len() + 1);
                let layer = Box::new(Layer::new(name, template));
                edits.once(Action::Add { index: project.layers().len(), layer });
                ui.close();
            }
        }
    });
}

/// Templates that need no file; meshes are dropped on the window or chosen in the match panel.
fn starting_points() -> [(&'static str, &'static str, Template); 6] {
    [
        ("Ellipsoid", "Against the ellipsoid that fits the shape", Template::Ellipsoid),
        ("Sphere", "Against the sphere that fits the shape", Template::Sphere),
        ("Plain head", "Against the sample head", Template::Sample("template".into())),
        ("Own detail", "Against a smooth version of itself: its own detail grows", Template::LowPass(20)),
        ("Own size", "Against a smaller version of itself: everything grows", Template::Scaled(0.9)),
        ("Magnify all", "Against the shape under all layers: all changes below grow", Template::Original),
    ]
}
