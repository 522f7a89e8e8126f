//! The match panel: which template the selected layer uses, how well it fits, and how to help it.

use chladni_caricature::{Action, Layer, LayerId, MatchRequest, Matched, Project, Property, Template};
use chladni_match::{MatchSettings, Method, Scaling};
use egui::{RichText, Ui};

use super::analytic;
use super::edits::Edits;
use super::head_sliders;
use super::landmarks;
use super::session::Session;
use super::shelf;
use crate::studio::author_id::AuthorId;
use crate::studio::icon::{self, Icon};
use crate::studio::job;
use crate::studio::room::Shared;
use crate::studio::theme;
use crate::work::formats::MESHES;
use crate::work::{is_namesake, template_name};

/// Draws the panel for the selected layer.
///
/// `picking` says whether landmarks are picked, and is toggled by a button. True if the user wants to see the
/// match's confidence on the shape.
pub fn show(
    ui: &mut Ui,
    session: &mut Session,
    picking: &mut bool,
    edits: &mut Edits,
    shared: &mut Shared<'_>,
) -> bool {
    let Some((id, layer)) = session.chosen() else {
        theme::section(ui, "Template", |ui| first(ui, session.project(), edits, shared));
        return false;
    };
    theme::section(ui, "Template", |ui| {
        // As of the controls: what is typed stays with its layer.
        ui.push_id(id.0, |ui| template(ui, session, id, &layer, picking, edits, shared)).inner
    })
}

/// If no layer is selected, a template from the shelf becomes a new layer.
fn first(ui: &mut Ui, project: &Project, edits: &mut Edits, shared: &mut Shared<'_>) {
    if let Some((name, template)) = shelf::show(ui, shared) {
        let layer = Box::new(project.new_layer(name, template));
        edits.once(Action::Add { index: project.layers().len(), layer });
    }
}

fn template(
    ui: &mut Ui,
    session: &mut Session,
    id: LayerId,
    layer: &Layer,
    picking: &mut bool,
    edits: &mut Edits,
    shared: &mut Shared<'_>,
) -> bool {
    ui.horizontal(|ui| {
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if ui.button(icon::text(Icon::FolderOpen)).on_hover_text("Use another mesh as template").clicked()
                && let Some(path) = shared.chooser.open(&[("Meshes", &MESHES)])
            {
                let template = Template::File(path);
                renew(session, &template, shared);
                replace(layer, id, template, edits, shared);
            }
            if let Some((_, template)) = shelf::show(ui, shared) {
                replace(layer, id, template, edits, shared);
            }
            ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                ui.add(egui::Label::new(template_name(&layer.template, session.project())).truncate());
            });
        });
    });
    if let Some(why) = session.selected_failure().map(str::to_owned) {
        ui.label(RichText::new(why).color(theme::palette(ui).error));
        if ui.button("Try again").clicked() {
            session.retry_match();
            shared.ctx.request_repaint();
        }
    }
    if MatchRequest::of(layer)
        .is_some_and(|request| layer.template.is_mesh() && request.template == layer.template)
    {
        method(ui, session, id, edits);
        landmarks::show_list(ui, session, id, &layer.matching, picking, edits, shared);
        ui.add_space(theme::GAP_SMALL);
    }
    analytic::show(ui, session, id, &layer.template, edits);
    head_sliders::show(ui, id, layer, edits, shared);
    // A running match is shown in place of the report, so that the layout does not jump.
    if let Some(running) = session.running_match() {
        job::show_progress(ui, running);
    } else if let Some(matched) = session.selected_match()
        && let Some(report) = &matched.report
    {
        quality(ui, report);
        return infill(ui, id, layer, matched, edits);
    }
    false
}

/// How far places where the match is not trusted are filled in; true if the user wants to see them.
fn infill(ui: &mut Ui, id: LayerId, layer: &Layer, matched: &Matched, edits: &mut Edits) -> bool {
    let Some((_, share)) = matched.infill else { return false };
    let tip = "Where the match is not trusted, such as hair, holes and the cut of a neck, the difference goes on \
               from its surroundings instead: 0 is as it was found";
    theme::row(ui, "Fill in", tip, |ui| {
        let mut infill = layer.infill;
        let slider = ui.add(theme::slider(&mut infill, 0.0..=1.0).fixed_decimals(2));
        edits.drag(id, &slider, || Property::Infill(infill));
    });
    let share = if share < 0.001 { "Less than 0.1 %".into() } else { percent(share) };
    let text = format!("{share} of it is not trusted");
    let text = RichText::new(icon::label(Icon::Info, &text)).color(theme::palette(ui).weak).small();
    let tip = "By area. Click to see how far the match is trusted, and where.";
    ui.add(egui::Button::new(text).frame(false)).on_hover_text(tip).author_id("trust").clicked()
}

fn method(ui: &mut Ui, session: &Session, id: LayerId, edits: &mut Edits) {
    let Some(layer) = session.project().layer(id) else { return };
    let mut matching = layer.matching.clone();
    let chosen = describe(matching.method).0;
    let choice = egui::ComboBox::from_id_salt("method").selected_text(chosen).show_ui(ui, |ui| {
        for method in [Method::Fit, Method::Icp, Method::Map, Method::Same] {
            let (name, tip) = describe(method);
            let is_possible = method != Method::Same || session.subject.proxy.is_none();
            let choice = ui.add_enabled_ui(is_possible, |ui| {
                ui.selectable_value(&mut matching.method, method, name).on_hover_text(tip)
            });
            choice.inner.on_disabled_hover_text(NEEDS_ALL);
        }
    });
    choice.response.accessible_name("How to match");
    let mut fitted = matching.scaling == Scaling::Free;
    let tip =
        "Off: the template keeps its own size, in the units of its file, and a difference of size counts";
    let fit = theme::checkbox(ui, &mut fitted, "Fit its size").author_id("fit-size");
    if fit.on_hover_text(tip).changed() {
        matching.scaling = if fitted { Scaling::Free } else { Scaling::Rigid };
    }
    if matching != layer.matching {
        edits.set(id, Property::Matching(matching));
    }
}

/// Why vertices are not matched one by one.
const NEEDS_ALL: &str = "The shape is worked on with a part of its vertices, and this needs all: begin anew with \
                         chladni project new --proxy 0";

fn describe(method: Method) -> (&'static str, &'static str) {
    match method {
        Method::Fit => {
            ("Bend to fit", "Aligns the template, then bends the shape onto it: the best for heads")
        }
        Method::Icp => ("Closest points", "Aligns the template and takes the closest points"),
        Method::Map => (
            "Map by landmarks",
            "A continuous map led by landmarks, for shapes as different as a man and a lion",
        ),
        Method::Same => ("Same vertices", "Both meshes have the same vertices in the same order"),
    }
}

fn quality(ui: &mut Ui, report: &chladni_match::MatchReport) {
    let palette = theme::palette(ui);
    egui::Grid::new("quality").num_columns(2).show(ui, |ui| {
        let mut row = |name: &str, tip: &str, value: String| {
            ui.label(RichText::new(name).color(palette.weak)).on_hover_text(tip);
            ui.label(value);
            ui.end_row();
        };
        row(
            "Distance",
            "Median distance after aligning, share of the diagonal",
            percent(report.median_distance),
        );
        if let Some(residual) = report.residual_median {
            let tip = "Median distance to the template that is left after fitting, share of the diagonal";
            row("Remaining", tip, percent(residual));
        }
        row("Covered", "Share of the surface that found a trustworthy partner", percent(report.coverage));
        row(
            "Confidence",
            "Mean trust in the match, by area; the heat map shows where",
            percent(report.mean_confidence),
        );
        row("Turned over", "Triangles whose image is inside out", report.flipped_triangles.to_string());
        let tip = "Triangles more than five times as long, for their width, as on the shape";
        row("Stretched", tip, report.strongly_stretched.to_string());
    });
    for warning in &report.warnings {
        let text = icon::label(Icon::TriangleAlert, &theme::capitalized(warning));
        ui.add(egui::Label::new(RichText::new(text).color(palette.warning).small()).wrap().selectable(true));
    }
}

fn percent(share: f64) -> String {
    format!("{:.1} %", share * 100.0)
}

/// Reads a template again where it is chosen again and its file is another now.
pub fn renew(session: &mut Session, template: &Template, shared: &mut Shared<'_>) {
    match session.renew(template) {
        Ok(said) => said.into_iter().for_each(|said| shared.notices.warn(said)),
        Err(why) => shared.notices.failed(why),
    }
}

/// Gives a layer another template, and says what becomes of its landmarks.
fn replace(layer: &Layer, id: LayerId, template: Template, edits: &mut Edits, shared: &mut Shared<'_>) {
    let steps = replacement(layer, template);
    if steps.len() > 1 {
        shared.notices.warn(landmarks::GONE);
    }
    edits.together(steps.into_iter().map(|to| Action::Set { layer: id, to }).collect());
}

/// The changes that give a layer another template: without the landmarks that it has, where they belong to the mesh before.
fn replacement(layer: &Layer, template: Template) -> Vec<Property> {
    let has_landmarks = !layer.matching.landmarks.is_empty();
    let goes = layer.template.loses_landmarks_to(&template);
    let bare = (has_landmarks && (goes || is_namesake(&layer.template, &template)))
        .then(|| Property::Matching(MatchSettings { landmarks: Vec::new(), ..layer.matching.clone() }));
    bare.into_iter().chain([Property::Template(template)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_match::Landmark;
    use chladni_mesh::{samples, save_mesh};

    #[test]
    fn landmarks_stay_with_a_file_that_was_moved_and_not_with_another_of_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for (place, detail) in [("a", 1), ("b", 2), ("copy", 1)] {
            std::fs::create_dir(at(place)).unwrap();
            save_mesh(&samples::icosphere(detail), &at(place).join("head.ply")).unwrap();
        }
        let mut layer = Layer::new("head", Template::File(at("a").join("head.ply")));
        let landmark = |vertex: u32| Landmark { shape: vertex, template: vertex };
        layer.matching.landmarks = (0..3).map(landmark).collect();
        let left = |place: &str| {
            let mut project = Project::new(chladni_caricature::ShapeSource::Sample("head".into()), 8);
            let id = project.push(layer.clone()).unwrap();
            for to in replacement(&layer, Template::File(at(place).join("head.ply"))) {
                project.apply(&Action::Set { layer: id, to }, None).unwrap();
            }
            project.layer(id).unwrap().matching.landmarks.len()
        };
        assert_eq!((left("b"), left("copy")), (0, 3));
        std::fs::remove_file(at("a").join("head.ply")).unwrap();
        assert_eq!(left("b"), 3, "it was moved there");
    }
}
