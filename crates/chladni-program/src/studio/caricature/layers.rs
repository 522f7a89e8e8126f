//! The stack of layers: names, eyes, solo, order. The topmost layer is the topmost row.

use chladni_caricature::{Action, Layer, LayerId, MatchRequest, Project, Property};
use egui::text::{CCursor, CCursorRange, LayoutJob, TextFormat};
use egui::{RichText, TextStyle, Ui};

use super::edits::Edits;
use super::session::Session;
use super::thumbnails::Thumbnails;
use crate::studio::author_id::AuthorId;
use crate::studio::context_menu;
use crate::studio::icon::{self, Icon};
use crate::studio::keys::caricature::{ADD_MESH, DELETE, DUPLICATE, HIDE, SOLO};
use crate::studio::theme;
use crate::work::{STARTING_POINTS, layer_since, results};

/// Side of a layer's picture, points.
const THUMBNAIL: f32 = 38.0;

/// State of the list itself.
#[derive(Debug, Default)]
pub struct LayerList {
    renaming: Option<(LayerId, String)>,
    wants_mesh: bool,
}

impl LayerList {
    /// Draws the list and its buttons; `selected` is the layer that the other panels edit, `failed` are those whose
    /// template could not be read or matched.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        session: &Session,
        pictures: &Thumbnails,
        failed: &[LayerId],
        selected: &mut Option<LayerId>,
        edits: &mut Edits,
    ) {
        let project = session.project();
        ui.horizontal(|ui| {
            theme::heading(ui, "Layers");
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                self.stack_buttons(ui, session, *selected, edits);
            });
        });
        if project.layers().is_empty() {
            ui.add_space(theme::GAP_SMALL);
            let weak = |text: &str| RichText::new(text).color(theme::palette(ui).weak);
            let (what, how) = (
                weak("A layer exaggerates what makes the shape differ from another one, its template."),
                weak("Add offers templates that need no file."),
            );
            ui.label(what);
            ui.add_space(theme::GAP_SMALL);
            self.wants_mesh |= theme::primary_button(ui, "Compare with a mesh…").clicked();
            ui.add_space(theme::GAP_SMALL);
            ui.label(how);
            return;
        }
        let count = project.layers().len();
        let mut dropped: Option<(LayerId, usize)> = None;
        for (index, (id, layer)) in project.layers().iter().enumerate().rev() {
            let failure = failed.contains(id).then(|| {
                let request = MatchRequest::of(layer);
                let is_matched = request.is_some_and(|request| session.stack.matched(&request).is_some());
                if layer.template.is_mesh() && !is_matched { "Has no template" } else { "Does nothing" }
            });
            let row = |ui: &mut Ui| self.row(ui, project, (pictures, failure), *id, layer, selected, edits);
            let row = ui.push_id(id.0, row).inner;
            row.dnd_set_drag_payload(*id);
            if let Some(dragged) = row.dnd_release_payload::<LayerId>() {
                dropped = Some((*dragged, index));
            } else if let Some(dragged) = row.dnd_hover_payload::<LayerId>() {
                // A layer dragged from above goes below this row.
                let from_above = project.layers()[index..].iter().any(|(id, _)| id == &*dragged);
                let y = if from_above { row.rect.bottom() + 3.0 } else { row.rect.top() - 3.0 };
                let line = egui::Stroke::new(2.0, theme::palette(ui).accent);
                ui.painter().hline(row.rect.x_range(), y, line);
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
        (pictures, failure): (&Thumbnails, Option<&str>),
        id: LayerId,
        layer: &Layer,
        selected: &mut Option<LayerId>,
        edits: &mut Edits,
    ) -> egui::Response {
        let palette = theme::palette(ui);
        let chosen = *selected == Some(id);
        let fill = if chosen { ui.visuals().selection.bg_fill } else { palette.card };
        let weak = if chosen { ui.visuals().text_color() } else { palette.weak };
        // The row is there before its buttons, so that they lie on top of it for the pointer.
        let size = egui::vec2(ui.available_width(), THUMBNAIL + 10.0);
        let (rect, response) = ui.allocate_exact_size(size, egui::Sense::click_and_drag());
        response.widget_info(|| {
            egui::WidgetInfo::selected(egui::Role::Button, true, chosen, format!("Layer {}", layer.name))
        });
        let response = response.author_id(format!("layer/{}", id.0));
        let line = if chosen { theme::chosen_line(ui.visuals()) } else { egui::Stroke::NONE };
        ui.painter().rect(rect, 6.0, fill, line, egui::StrokeKind::Inside);
        let inside = egui::UiBuilder::new()
            .max_rect(rect.shrink2(egui::vec2(8.0, 5.0)))
            .accessibility_role(egui::Role::Group)
            .accessibility_label(&layer.name);
        ui.scope_builder(inside, |ui| {
            ui.horizontal(|ui| {
                ui.set_min_height(THUMBNAIL);
                let (eye, tip) = if layer.enabled {
                    (Icon::Eye, "Hide this layer")
                } else {
                    (Icon::EyeOff, "Show this layer")
                };
                let tip = HIDE.with_key(ui.ctx(), tip);
                if icon_button(ui, eye, &tip).clicked() {
                    edits.set(id, Property::Enabled(!layer.enabled));
                }
                let acts = project.acts(layer);
                thumbnail(ui, pictures.of(id), acts && failure.is_none());
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    let tip = if layer.solo { "Show the other layers again" } else { "Only this layer" };
                    let color = if layer.solo { palette.accent } else { weak };
                    let tip = SOLO.with_key(ui.ctx(), tip);
                    let under = ui.painter().add(egui::Shape::Noop);
                    let solo = tinted_button(ui, Icon::Headphones, &tip, color);
                    if layer.solo {
                        // The accent is not seen on a chosen row.
                        ui.painter().set(under, epaint::RectShape::filled(solo.rect, 5.0, palette.stage));
                    }
                    if solo.clicked() {
                        edits.set(id, Property::Solo(!layer.solo));
                    }
                    ui.with_layout(egui::Layout::top_down(egui::Align::LEFT), |ui| {
                        ui.spacing_mut().item_spacing.y = 1.0;
                        ui.add_space(3.0);
                        let text = RichText::new(&layer.name);
                        let text = if acts { text } else { text.color(weak) };
                        self.name(ui, id, text, edits);
                        let summary = summary(ui, layer, failure, chosen);
                        ui.add(egui::Label::new(summary).truncate().selectable(false));
                    });
                });
            });
        });
        if response.clicked() {
            *selected = Some(id);
        }
        if response.double_clicked() {
            self.rename(id, layer);
        }
        context_menu::show(&response, |ui| {
            *selected = Some(id);
            self.menu(ui, project, id, layer, edits);
        });
        response.on_hover_text("Click to edit, double-click to rename, drag to reorder, right-click for more")
    }

    /// Whether the user asked for a template mesh since the last call.
    pub fn takes_mesh(&mut self) -> bool {
        std::mem::take(&mut self.wants_mesh)
    }

    /// Begins to rename a layer.
    pub fn rename(&mut self, id: LayerId, layer: &Layer) {
        self.renaming = Some((id, layer.name.clone()));
    }

    /// Ends the name that is being typed, if one is; it counts unless it is empty.
    pub fn commit(&mut self, edits: &mut Edits) {
        if let Some((id, draft)) = self.renaming.take()
            && !draft.trim().is_empty()
        {
            edits.set(id, Property::Name(draft.trim().to_owned()));
        }
    }

    fn menu(&mut self, ui: &mut Ui, project: &Project, id: LayerId, layer: &Layer, edits: &mut Edits) {
        let place = project.layers().iter().position(|(known, _)| *known == id).unwrap_or(0);
        let top = project.layers().len().saturating_sub(1);
        let rename = context_menu::entry(ui, true, icon::label(Icon::Pencil, "Rename"));
        if rename.author_id("rename").clicked() {
            self.rename(id, layer);
        }
        if context_menu::entry(ui, true, icon::label(Icon::Copy, "Duplicate")).clicked() {
            edits.once(Action::Duplicate(id));
        }
        if context_menu::entry(ui, place < top, icon::label(Icon::ArrowUp, "Move up")).clicked() {
            edits.once(Action::Move { layer: id, index: place + 1 });
        }
        if context_menu::entry(ui, place > 0, icon::label(Icon::ArrowDown, "Move down")).clicked() {
            edits.once(Action::Move { layer: id, index: place - 1 });
        }
        ui.separator();
        if context_menu::entry(ui, true, icon::label(Icon::Trash2, "Delete")).clicked() {
            edits.once(Action::Remove(id));
        }
    }

    fn stack_buttons(
        &mut self,
        ui: &mut Ui,
        session: &Session,
        selected: Option<LayerId>,
        edits: &mut Edits,
    ) {
        let (project, harmonics) = (session.project(), session.stack.body().basis.harmonics());
        if let Some(layer) = selected {
            if icon_button(ui, Icon::Trash2, &DELETE.tooltip(ui.ctx())).clicked() {
                // Its name goes with it.
                self.renaming.take_if(|(id, _)| *id == layer);
                edits.once(Action::Remove(layer));
            }
            if icon_button(ui, Icon::Copy, &DUPLICATE.tooltip(ui.ctx())).clicked() {
                self.commit(edits);
                edits.once(Action::Duplicate(layer));
            }
        }
        let add = ui.menu_button(icon::label(Icon::Plus, "Add"), |ui| {
            if ui.button("A mesh…").on_hover_text(ADD_MESH.tooltip(ui.ctx())).clicked() {
                self.wants_mesh = true;
                ui.close();
            }
            ui.separator();
            for point in STARTING_POINTS {
                let button = ui.button(point.name).author_id(format!("template/{}", point.id));
                if button.on_hover_text(point.tip).clicked() {
                    let layer = Box::new(point.layer(project, harmonics));
                    edits.once(Action::Add { index: project.layers().len(), layer });
                    ui.close();
                }
            }
            result_of_layer(ui, project, edits);
        });
        add.response.author_id("add");
    }

    fn name(&mut self, ui: &mut Ui, id: LayerId, text: RichText, edits: &mut Edits) {
        let Some((_, draft)) = self.renaming.as_mut().filter(|(layer, _)| *layer == id) else {
            ui.add(egui::Label::new(text).truncate().selectable(false));
            return;
        };
        let mut shown = egui::TextEdit::singleline(draft).desired_width(130.0).show(ui);
        let field = shown.response.response.accessible_name("Name of the layer");
        if !field.has_focus() {
            // The first letter that is typed replaces the old name.
            let end = CCursor::new(draft.chars().count());
            shown.state.cursor.set_char_range(Some(CCursorRange::two(CCursor::default(), end)));
            shown.state.store(ui.ctx(), field.id);
        }
        field.request_focus();
        let (enter, escape) =
            ui.input(|input| (input.key_pressed(egui::Key::Enter), input.key_pressed(egui::Key::Escape)));
        if escape {
            self.renaming = None;
        } else if enter || field.clicked_elsewhere() {
            self.commit(edits);
        }
    }
}

/// The choice of a layer whose result is the template of a new one on top.
fn result_of_layer(ui: &mut Ui, project: &Project, edits: &mut Edits) {
    let below = results(project);
    let menu = |ui: &mut Ui| {
        for (id, layer) in below.iter().rev() {
            if ui.button(&layer.name).author_id(format!("result/{}", id.0)).clicked() {
                let layer = Box::new(layer_since(project, *id, &layer.name));
                edits.once(Action::Add { index: project.layers().len(), layer });
                ui.close();
            }
        }
    };
    let menu =
        ui.add_enabled_ui(!below.is_empty(), |ui| ui.menu_button("The result of layer", menu).response);
    let tip = "Against the shape after that layer: all changes above it grow";
    menu.inner
        .author_id("result")
        .on_hover_text(tip)
        .on_disabled_hover_text("With two layers or more: what came after one of them grows");
}

/// A frameless button of one icon.
pub fn icon_button(ui: &mut Ui, mark: Icon, tip: &str) -> egui::Response {
    let color = ui.visuals().text_color();
    tinted_button(ui, mark, tip, color)
}

/// The line below a layer's name: how it acts, or why it does not. On a chosen row only the sign is red, since so small a
/// text would hardly be read there.
fn summary(ui: &Ui, layer: &Layer, failure: Option<&str>, chosen: bool) -> LayoutJob {
    let palette = theme::palette(ui);
    let font = TextStyle::Small.resolve(ui.style());
    let unless_chosen = |color| if chosen { ui.visuals().text_color() } else { color };
    let mut line = LayoutJob::default();
    let mut append = |text: &str, color| line.append(text, 0.0, TextFormat::simple(font.clone(), color));
    match failure {
        Some(why) => {
            append(&icon::label(Icon::TriangleAlert, ""), palette.error);
            append(why, unless_chosen(palette.error));
        }
        None => {
            let text = format!("μ {:.2}  {}", layer.effective_mu(), layer.model);
            append(&text, unless_chosen(palette.weak));
        }
    }
    line
}

/// The picture of a layer, or a place for one.
fn thumbnail(ui: &mut Ui, picture: Option<egui::TextureId>, acts: bool) {
    let (rect, _) = ui.allocate_exact_size(egui::Vec2::splat(THUMBNAIL), egui::Sense::hover());
    ui.painter().rect_filled(rect, 5.0, theme::palette(ui).stage);
    if let Some(picture) = picture {
        let tint = if acts { egui::Color32::WHITE } else { egui::Color32::from_white_alpha(70) };
        ui.painter().image(picture, rect, theme::WHOLE_IMAGE, tint);
    }
}

fn tinted_button(ui: &mut Ui, mark: Icon, tip: &str, color: egui::Color32) -> egui::Response {
    let button = egui::Button::new(RichText::new(icon::text(mark)).color(color)).frame(false);
    let response = ui.add(button.min_size(egui::Vec2::splat(theme::TARGET)));
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, tip));
    response.on_hover_text(tip)
}

#[cfg(test)]
mod tests {
    use chladni_caricature::Template;

    use super::*;

    #[test]
    fn why_a_chosen_layer_does_not_act_is_written_in_the_color_of_text_behind_a_red_sign() {
        let ctx = egui::Context::default();
        theme::install(&ctx);
        let layer = Layer::new("Head", Template::Ellipsoid);
        let _ = ctx.run_ui(egui::RawInput::default(), |ui| {
            let colors = |chosen| {
                let line = summary(ui, &layer, Some("Has no template"), chosen);
                line.sections.iter().map(|section| section.format.color).collect::<Vec<_>>()
            };
            let (error, text) = (theme::palette(ui).error, ui.visuals().text_color());
            assert_eq!((colors(true), colors(false)), (vec![error, text], vec![error]));
        });
    }
}
