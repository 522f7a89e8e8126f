//! Editing templates that are not meshes: the shape itself scaled or smoothed, given ellipsoids, and the results of
//! the layers below.

use chladni_caricature::{GivenEllipsoid, LayerId, Property, Template, wavelengths};
use chladni_match::Ellipsoid;
use egui::Ui;

use super::edits::Edits;
use super::session::Session;
use crate::studio::author_id::AuthorId;
use crate::studio::theme;
use crate::work::template_name;

/// The initial numbers of the scaled and the smoothed template.
const SCALED: Template = Template::Scaled(0.9);
const SMOOTHED_HARMONICS: usize = 20;

/// Draws the controls of `template`, if it has any.
pub fn show(ui: &mut Ui, session: &Session, id: LayerId, template: &Template, edits: &mut Edits) {
    match template {
        Template::Scaled(_) | Template::LowPass(_) => itself(ui, session, id, template, edits),
        Template::Ellipsoid | Template::Sphere => {
            let tip = "Give its center, its axes and its turn by numbers, from those that fit";
            if ui.button("Set by hand").author_id("ellipsoid-by-hand").on_hover_text(tip).clicked() {
                let round = *template == Template::Sphere;
                let fitted = if round { Ellipsoid::fitted_sphere } else { Ellipsoid::fitted };
                // Without a surface nothing fits; the match says so.
                if let Ok(fitted) = fitted(&session.subject.mesh) {
                    edits.set(id, Property::Template(Template::Given(fitted.into())));
                }
            }
        }
        Template::Given(known) => given(ui, session, id, *known, edits),
        Template::Original | Template::Layer(_) => below(ui, session, id, template, edits),
        Template::File(_) | Template::Sample(_) => {}
    }
}

/// Which of the shapes below: the original one, or that after a layer.
fn below(ui: &mut Ui, session: &Session, id: LayerId, template: &Template, edits: &mut Edits) {
    let project = session.project();
    let layers = project.layers().iter().map(|(below, _)| *below).take_while(|below| *below != id);
    let choice = egui::ComboBox::from_id_salt("below")
        .selected_text(template_name(template, project))
        .show_ui(ui, |ui| {
            for choice in std::iter::once(Template::Original).chain(layers.map(Template::Layer)) {
                let chosen = choice == *template;
                let place = match choice {
                    Template::Layer(layer) => format!("below/{}", layer.0),
                    _ => "below/original".to_owned(),
                };
                let name = template_name(&choice, project);
                if ui.selectable_label(chosen, name).author_id(place).clicked() && !chosen {
                    edits.set(id, Property::Template(choice));
                }
            }
        });
    let tip = "What the layers above it did is exaggerated";
    choice.response.on_hover_text(tip).accessible_name("Compare with the shape below").author_id("below");
}

/// The shape of the layers below, scaled down or smoothed: the paper magnifies all against either.
fn itself(ui: &mut Ui, session: &Session, id: LayerId, template: &Template, edits: &mut Edits) {
    let smoothed = Template::LowPass(SMOOTHED_HARMONICS.min(session.stack.body().basis.harmonics()));
    ui.horizontal(|ui| {
        for (choice, name, tip) in [
            (SCALED, "scaled", "Against itself scaled down: all that is there grows"),
            (smoothed, "smoothed", "Against itself without its detail: the detail grows"),
        ] {
            let chosen = std::mem::discriminant(&choice) == std::mem::discriminant(template);
            let button = ui.selectable_label(chosen, theme::capitalized(name)).on_hover_text(tip);
            if button.author_id(format!("itself/{name}")).clicked() && !chosen {
                edits.set(id, Property::Template(choice));
            }
        }
    });
    match *template {
        Template::Scaled(mut factor) => {
            theme::row(ui, "Scale", "Smaller makes all grow more at the same μ", |ui| {
                let slider = ui.add(theme::slider(&mut factor, 0.0..=1.5).fixed_decimals(2));
                edits.drag(id, &slider, || Property::Template(Template::Scaled(factor)));
            });
        }
        Template::LowPass(mut k0) => {
            let basis = &session.stack.body().basis;
            theme::row(ui, "Low-pass", "How many of its broadest harmonics the smooth version keeps", |ui| {
                let most = basis.harmonics().max(1);
                let slider = ui.add(theme::slider(&mut k0, 1..=most).logarithmic(true));
                edits.drag(id, &slider, || Property::Template(Template::LowPass(k0)));
            });
            let waves = wavelengths(basis);
            if let Some(wave) = waves.get(basis.harmonics_below(k0)).filter(|wave| wave.is_finite()) {
                let text = format!("What grows has waves of {:.0} % of its size and less", 100.0 * wave);
                theme::weak(ui, text);
            }
        }
        _ => {}
    }
}

/// Name for programs and for people, explanation, values, step and range of three numbers.
type Row<'a> = (&'static str, &'a str, &'a str, &'a mut [f64; 3], f64, std::ops::RangeInclusive<f64>);

fn given(ui: &mut Ui, session: &Session, id: LayerId, known: GivenEllipsoid, edits: &mut Edits) {
    let size = 1.0 / session.stack.body().frame.scale;
    // A thousandth of the shape can be set in any unit.
    let decimals = (3.0 - size.log10()).ceil().clamp(3.0, 15.0) as usize;
    let mut now = known;
    let rows: [Row<'_>; 3] = [
        (
            "center",
            "Center",
            "x, y and z in the units of the shape's file",
            &mut now.center,
            0.01 * size,
            f64::MIN..=f64::MAX,
        ),
        (
            "semi-axes",
            "Half axes",
            "Half the length of each axis",
            &mut now.semi_axes,
            0.01 * size,
            1e-6 * size..=1e6 * size,
        ),
        ("turn", "Turned", "Degrees about x, then y, then z", &mut now.turn_deg, 0.5, -360.0..=360.0),
    ];
    let mut responses = Vec::new();
    for (id, name, tip, values, speed, range) in rows {
        theme::row(ui, name, tip, |ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            for (value, axis) in values.iter_mut().zip(["x", "y", "z"]) {
                let field = theme::number(value).speed(speed).range(range.clone());
                // What a project holds is not changed by being shown.
                let field = field.max_decimals(decimals).clamp_existing_to_range(false);
                let field = ui.add_sized([52.0, ui.spacing().interact_size.y], field);
                responses
                    .push(field.accessible_name(format!("{name} {axis}")).author_id(format!("{id}/{axis}")));
            }
        });
    }
    for response in responses {
        edits.drag(id, &response, || Property::Template(Template::Given(now)));
    }
    let fit = ui.button("Fit to the shape").author_id("ellipsoid-fit");
    if fit.on_hover_text("The ellipsoid that fits the shape").clicked() {
        edits.set(id, Property::Template(Template::Ellipsoid));
    }
}
