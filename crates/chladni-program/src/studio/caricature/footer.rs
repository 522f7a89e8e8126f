//! The foot of the layer panel: the shape's size and health, and its harmonics with their certificate.

use std::time::Duration;

use chladni_caricature::Action;
use chladni_harmonics::{Basis, Certificate, Laplacian};
use egui::text::{LayoutJob, TextFormat};
use egui::{RichText, TextStyle, Ui};

use super::edits::Edits;
use super::health::Health;
use super::session::Session;
use crate::studio::author_id::AuthorId;
use crate::studio::icon::{self, Icon};
use crate::studio::job;
use crate::studio::theme;

/// Numbers of harmonics on offer.
const CHOICES: [usize; 5] = [64, 128, 256, 512, 1024];
/// In place of the shape's size, and no longer than that, while what is shown is long behind the document.
const BEHIND: &str = "Following…";
const PAPER_MODE: &str = "The paper's plain cotangent Laplacian, which not every shape can have; new layers begin \
                          with the paper's settings";

/// Draws it.
pub fn show(ui: &mut Ui, session: &Session, health: &Health, edits: &mut Edits) {
    let palette = theme::palette(ui);
    let body = session.stack.body();
    ui.add_space(theme::GAP_SMALL);
    if let Some(solving) = session.solving() {
        job::show_progress(ui, solving);
        return;
    }
    let slow_in = session.slow_in();
    if let Some(rest) = slow_in {
        ui.ctx().request_repaint_after(rest.max(Duration::from_millis(100)));
    }
    let slow = slow_in.is_some_and(|rest| rest.is_zero());
    // Two numbers and a mark need a line of their own.
    let is_long = session.subject.proxy.is_some();
    if is_long {
        vertices(ui, session, health, slow);
    }
    ui.horizontal(|ui| {
        if !is_long {
            vertices(ui, session, health, slow);
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let good = body.basis.certificate.is_precise();
            let (mark, color) =
                if good { (Icon::BadgeCheck, palette.good) } else { (Icon::TriangleAlert, palette.warning) };
            let label = icon::label(mark, &format!("{} harmonics", grouped(body.basis.harmonics())));
            let menu = ui.menu_button(RichText::new(label).small().color(color), |ui| {
                ui.label(RichText::new("How much detail to take apart").color(palette.weak));
                for choice in CHOICES {
                    let chosen = session.project().harmonics == choice;
                    let button = ui.selectable_label(chosen, format!("{} harmonics", grouped(choice)));
                    if button.author_id(format!("harmonics/{choice}")).clicked() {
                        edits.once(Action::SetHarmonics(choice));
                        ui.close();
                    }
                }
                ui.separator();
                let paper = session.project().laplacian == Laplacian::Cotangent;
                if ui.selectable_label(paper, "Paper mode").on_hover_text(PAPER_MODE).clicked() {
                    let other = if paper { Laplacian::Delaunay } else { Laplacian::Cotangent };
                    edits.once(Action::SetLaplacian(other));
                    ui.close();
                }
            });
            menu.response.author_id("harmonics").on_hover_ui(|ui| certificate(ui, &body.basis));
        });
    });
    ui.add_space(theme::GAP_SMALL);
}

/// The number of vertices, with a mark where something was found in their file; or that what is shown is `slow` to follow.
fn vertices(ui: &mut Ui, session: &Session, health: &Health, slow: bool) {
    let (palette, font) = (theme::palette(ui), TextStyle::Small.resolve(ui.style()));
    let [worked_on, all] = [&session.subject.mesh, session.subject.whole()].map(|m| m.positions.len());
    let text = match worked_on == all {
        _ if slow => BEHIND.to_owned(),
        true => format!("{} vertices", grouped(all)),
        false => format!("{} of {} vertices", grouped(worked_on), grouped(all)),
    };
    let mut marked = LayoutJob::default();
    if health.is_worth_a_look() && !slow {
        let mark = TextFormat::simple(font.clone(), palette.warning);
        marked.append(&icon::label(Icon::CircleAlert, ""), 0.0, mark);
    }
    marked.append(&text, 0.0, TextFormat::simple(font, palette.weak));
    let count = ui.label(marked).author_id("vertices");
    health.show_on(count, session.stack.body().basis.certificate.laplacian);
}

/// The certificate in plain words.
fn certificate(ui: &mut Ui, basis: &Basis) {
    let palette = theme::palette(ui);
    let certificate = &basis.certificate;
    ui.set_max_width(360.0);
    ui.label(
        RichText::new("The harmonics are the natural vibrations of this shape, from the broadest.").strong(),
    );
    let line = |ui: &mut Ui, good: bool, text: String| {
        let (mark, color) = if good { (Icon::Check, palette.good) } else { (Icon::X, palette.warning) };
        ui.horizontal_top(|ui| {
            ui.label(RichText::new(icon::text(mark)).color(color));
            ui.add(egui::Label::new(text).wrap());
        });
    };
    if certificate.laplacian == Laplacian::Cotangent {
        ui.label(RichText::new("Paper mode: those of its plain cotangent Laplacian.").strong());
    }
    for (good, text) in certified(certificate) {
        line(ui, good, text);
    }
    ui.label(RichText::new("Click to take another number of them.").color(palette.weak));
}

/// The parts of a certificate: whether they are good, and in words.
fn certified(certificate: &Certificate) -> [(bool, String); 3] {
    let (residual, overlap) = (certificate.max_relative_residual, certificate.max_orthogonality_error);
    let complete = match certificate.inertia_counts_match {
        Some(true) => {
            "Complete: an independent count finds as many below the last one, so none is missing and none is double."
        }
        Some(false) => "Not certified complete: an independent count does not agree, some may be missing.",
        None => "Not certified complete: no count shows that none is missing.",
    };
    let worst = format!("the worst solves its equation to {residual:.0e} of its size");
    let exact = match Certificate::RESIDUAL {
        most if residual <= most => (true, format!("Exact: {worst}.")),
        most => (false, format!("Not exact: {worst}, of a sound mesh to {most:.0e}.")),
    };
    let worst = format!("any two overlap by at most {overlap:.0e}");
    let independent = match Certificate::ORTHOGONALITY {
        most if overlap <= most => (true, format!("Independent: {worst}.")),
        most => (false, format!("Not independent: {worst}, of a sound mesh by {most:.0e}.")),
    };
    [(certificate.inertia_counts_match == Some(true), complete.into()), exact, independent]
}

/// A whole number with a thin space between thousands.
pub fn grouped(number: usize) -> String {
    let digits = number.to_string();
    let mut out = String::with_capacity(digits.len() + 4);
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            out.push('\u{202f}');
        }
        out.push(digit);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_certified_is_not_called_so() {
        let certificate = |residual, overlap| Certificate {
            laplacian: Laplacian::Delaunay,
            inertia_counts_match: Some(true),
            max_relative_residual: residual,
            max_orthogonality_error: overlap,
        };
        let said = |residual, overlap| certified(&certificate(residual, overlap));
        let good = said(1e-12, 1e-14);
        let begins = |(good, text): &(bool, String), with: &str| *good && text.starts_with(with);
        assert!(begins(&good[1], "Exact: ") && begins(&good[2], "Independent: "), "{good:?}");
        for bad in [said(1e-6, 1e-5), said(f64::NAN, f64::NAN)] {
            assert!(!bad[1].0 && bad[1].1.starts_with("Not exact: "), "{bad:?}");
            assert!(!bad[2].0 && bad[2].1.starts_with("Not independent: "), "{bad:?}");
        }
        assert!(begins(&good[0], "Complete: "), "{good:?}");
        for counted in [Some(false), None] {
            let [complete, ..] =
                certified(&Certificate { inertia_counts_match: counted, ..certificate(1e-12, 1e-14) });
            assert!(!complete.0 && complete.1.starts_with("Not certified complete: "), "{complete:?}");
        }
    }

    #[test]
    fn thousands_stand_apart() {
        let grouped = |n| grouped(n).replace('\u{202f}', "_");
        assert_eq!([0, 12, 999, 1000, 1234567].map(grouped), ["0", "12", "999", "1_000", "1_234_567"]);
    }
}
