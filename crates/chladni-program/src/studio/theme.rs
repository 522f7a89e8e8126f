//! One look for the whole window: colors, type scale, spacing. Dark and light.

use egui::class::HasClasses;
use egui::theme::{DefaultStyle, StyleProvider};
use egui::widget_style::{ButtonStyle, StyleArgs};
use egui::{Color32, CornerRadius, FontFamily, FontId, Margin, Shadow, Stroke, TextStyle, Theme, Vec2};

mod numbers;

pub use numbers::{in_units, number, number_in, slider};

/// Small gap, between an icon and its label.
pub const GAP_SMALL: f32 = 4.0;
/// Gap between controls.
pub const GAP: f32 = 8.0;
/// Gap between groups of controls.
pub const GAP_LARGE: f32 = 16.0;
/// Width of a panel of controls.
pub const PANEL_WIDTH: f32 = 308.0;
/// The least side of what is clicked, or its distance from the next (WCAG 2.2, criterion 2.5.8).
pub const TARGET: f32 = 24.0;
/// All of an image, in its own coordinates.
pub const WHOLE_IMAGE: egui::Rect = egui::Rect::from_min_max(egui::Pos2::ZERO, egui::pos2(1.0, 1.0));

/// The colors that egui has no name for.
#[derive(Clone, Copy, Debug)]
pub struct Palette {
    /// The one accent: brass, as of the plates that Chladni bowed.
    pub accent: Color32,
    /// The accent where it fills an area behind text.
    pub accent_fill: Color32,
    /// Behind the 3D view.
    pub stage: Color32,
    /// Raised cards and group backgrounds.
    pub card: Color32,
    /// Lines between things.
    pub line: Color32,
    /// Text that may be overlooked.
    pub weak: Color32,
    /// All is well.
    pub good: Color32,
    /// Worth a look.
    pub warning: Color32,
    /// Something is wrong.
    pub error: Color32,
}

const DARK: Palette = Palette {
    accent: Color32::from_rgb(226, 166, 70),
    accent_fill: Color32::from_rgb(206, 146, 52),
    stage: Color32::from_rgb(23, 24, 28),
    card: Color32::from_rgb(38, 40, 46),
    line: Color32::from_rgb(54, 57, 65),
    weak: Color32::from_rgb(152, 153, 158),
    good: Color32::from_rgb(112, 190, 134),
    warning: Color32::from_rgb(232, 178, 84),
    error: Color32::from_rgb(240, 120, 108),
};

const LIGHT: Palette = Palette {
    accent: Color32::from_rgb(134, 80, 0),
    accent_fill: Color32::from_rgb(196, 132, 34),
    stage: Color32::from_rgb(226, 225, 221),
    card: Color32::from_rgb(255, 255, 254),
    line: Color32::from_rgb(214, 211, 204),
    weak: Color32::from_rgb(94, 93, 89),
    good: Color32::from_rgb(26, 104, 55),
    warning: Color32::from_rgb(134, 80, 0),
    error: Color32::from_rgb(170, 38, 31),
};

/// Text on the accent.
pub const ON_ACCENT: Color32 = Color32::from_rgb(24, 18, 8);

/// The palette of the theme that `ui` is drawn in.
pub fn palette(ui: &egui::Ui) -> Palette {
    palette_of(ui.visuals())
}

fn palette_of(visuals: &egui::Visuals) -> Palette {
    if visuals.dark_mode { DARK } else { LIGHT }
}

/// The line around what is chosen, whose fill alone hardly stands out.
pub fn chosen_line(visuals: &egui::Visuals) -> Stroke {
    Stroke::new(1.0, palette_of(visuals).accent)
}

/// Buttons as egui draws them, with a line around those that are chosen.
struct Outlined;

impl StyleProvider<ButtonStyle> for Outlined {
    fn style(&mut self, modifiers: &StyleArgs<'_>) -> ButtonStyle {
        let mut style: ButtonStyle = DefaultStyle.style(modifiers);
        let is = |class: &str| modifiers.classes.has_class(class);
        // A button without a frame has none around it, either. In menus a frame has no line, and must not grow by this one.
        if is(&egui::Button::CLASS_SELECTED) && !is(&egui::Button::CLASS_NO_FRAME) {
            let line = chosen_line(&modifiers.style.visuals);
            let frame = &mut style.atom_layout.frame;
            *frame = frame.apply_stroke_and_expansion_without_layout_shift(line, 0.0);
        }
        style
    }
}

/// Type scale: a title on the start screen.
pub fn title() -> TextStyle {
    TextStyle::Name("title".into())
}

/// A question or a choice in front of everything else; true beside its result where Escape or a
/// click beside it dismissed it.
pub fn modal<R>(
    ctx: &egui::Context,
    title: &str,
    width: f32,
    content: impl FnOnce(&mut egui::Ui) -> R,
) -> (R, bool) {
    let frame = egui::Frame::popup(&ctx.global_style()).inner_margin(22.0).corner_radius(12.0);
    let id = egui::Id::unique(title);
    let area = egui::Modal::default_area(id).accessible_name(title);
    let shown = egui::Modal::new(id).area(area).frame(frame).show(ctx, |ui| {
        ui.set_width(width);
        ui.heading(title);
        ui.add_space(GAP);
        content(ui)
    });
    let dismissed = shown.should_close();
    (shown.inner, dismissed)
}

/// A group of controls below a line and a heading.
pub fn section<R>(ui: &mut egui::Ui, name: &str, content: impl FnOnce(&mut egui::Ui) -> R) -> R {
    ui.add_space(GAP);
    ui.separator();
    heading(ui, name);
    group(ui, name, content)
}

/// The heading of a group of controls.
pub fn heading(ui: &mut egui::Ui, name: &str) {
    ui.label(egui::RichText::new(name).size(14.5).strong());
}

/// A remark, small and weak.
pub fn weak(ui: &mut egui::Ui, text: impl Into<String>) {
    ui.label(egui::RichText::new(text).small().color(palette(ui).weak));
}

/// A small line of warning.
pub fn warning(ui: &mut egui::Ui, text: impl Into<String>) {
    ui.label(egui::RichText::new(text).small().color(palette(ui).warning));
}

/// One line of a form: a label of fixed width, its tooltip, and controls. Sliders in it end where
/// those of the other lines do; those that have no name of their own are called as the label.
pub fn row<R>(ui: &mut egui::Ui, label: &str, tip: &str, controls: impl FnOnce(&mut egui::Ui) -> R) -> R {
    wide_row(ui, 66.0, label, tip, controls)
}

/// As [`row`], with another width of its label.
pub fn wide_row<R>(
    ui: &mut egui::Ui,
    width: f32,
    label: &str,
    tip: &str,
    controls: impl FnOnce(&mut egui::Ui) -> R,
) -> R {
    const VALUE: f32 = 58.0;
    ui.horizontal(|ui| {
        let size = egui::vec2(width, ui.spacing().interact_size.y);
        let label = egui::Label::new(label).selectable(false);
        let layout = egui::Layout::left_to_right(egui::Align::Center);
        let label = ui.allocate_ui_with_layout(size, layout, |ui| {
            ui.set_min_width(width);
            ui.add(label).on_hover_text(tip).id
        });
        ui.spacing_mut().slider_width = (ui.available_width() - VALUE - GAP).max(40.0);
        ui.label_inputs_by(label.inner, controls)
    })
    .inner
}

/// A checkbox whose empty box is seen, too.
pub fn checkbox(ui: &mut egui::Ui, on: &mut bool, label: &str) -> egui::Response {
    ui.scope(|ui| {
        ui.visuals_mut().widgets.inactive.bg_stroke.color = palette(ui).weak;
        ui.checkbox(on, label)
    })
    .inner
}

/// Controls that belong together, as a group called `name` for screen readers. Controls in different groups
/// may then have the same name.
pub fn group<R>(ui: &mut egui::Ui, name: &str, content: impl FnOnce(&mut egui::Ui) -> R) -> R {
    let builder = egui::UiBuilder::new().accessibility_role(egui::Role::Group).accessibility_label(name);
    ui.scope_builder(builder, content).inner
}

/// A name as it begins a label.
pub fn capitalized(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// The button that most people want: filled with the accent.
pub fn primary_button(ui: &mut egui::Ui, label: impl Into<String>) -> egui::Response {
    let palette = palette(ui);
    let text = egui::RichText::new(label).color(ON_ACCENT).strong();
    ui.add(egui::Button::new(text).fill(palette.accent_fill))
}

/// Sets fonts and both themes once, when the window opens.
pub fn install(ctx: &egui::Context) {
    let mut fonts = egui::FontDefinitions::default();
    super::icon::install(&mut fonts);
    ctx.set_fonts(fonts);
    ctx.add_plugin(super::icon::Unspoken);
    ctx.add_widget_theme::<ButtonStyle>(Outlined);
    ctx.all_styles_mut(|style| {
        style.text_styles = [
            (title(), FontId::new(30.0, FontFamily::Proportional)),
            (TextStyle::Heading, FontId::new(17.0, FontFamily::Proportional)),
            (TextStyle::Body, FontId::new(13.5, FontFamily::Proportional)),
            (TextStyle::Button, FontId::new(13.5, FontFamily::Proportional)),
            (TextStyle::Small, FontId::new(11.5, FontFamily::Proportional)),
            (TextStyle::Monospace, FontId::new(12.5, FontFamily::Monospace)),
        ]
        .into();
        let spacing = &mut style.spacing;
        spacing.item_spacing = Vec2::new(GAP, 6.0);
        spacing.button_padding = Vec2::new(9.0, 5.0);
        spacing.interact_size = Vec2::new(32.0, 26.0);
        spacing.slider_width = 122.0;
        spacing.slider_rail_height = 4.0;
        spacing.window_margin = Margin::same(14);
        spacing.menu_margin = Margin::same(6);
        spacing.icon_spacing = 6.0;
        // A scroll bar lies beside what is scrolled, not over it; under the pointer it is as light as elsewhere.
        let scroll = &mut spacing.scroll;
        scroll.floating_allocated_width = scroll.bar_width + 2.0;
        scroll.interact_handle_opacity = scroll.active_handle_opacity;
        style.interaction.tooltip_delay = 0.35;
    });
    ctx.style_mut_of(Theme::Dark, |style| {
        visuals(&mut style.visuals, &DARK, Surface { base: 0x1c, panel: 0x20, control: 0x2f, text: 0xe9 });
    });
    ctx.style_mut_of(Theme::Light, |style| {
        visuals(&mut style.visuals, &LIGHT, Surface { base: 0xff, panel: 0xf4, control: 0xe6, text: 0x1d });
    });
}

/// Gray levels of the surfaces; a touch of blue in the dark and of yellow in the light keeps them alive.
struct Surface {
    base: u8,
    panel: u8,
    control: u8,
    text: u8,
}

fn visuals(visuals: &mut egui::Visuals, palette: &Palette, surface: Surface) {
    let dark = visuals.dark_mode;
    let gray = |level: u8| {
        if dark {
            Color32::from_rgb(level, level.saturating_add(1), level.saturating_add(4))
        } else {
            Color32::from_rgb(level, level.saturating_sub(1), level.saturating_sub(4))
        }
    };
    let step =
        |level: u8, by: i16| gray((i16::from(level) + if dark { by } else { -by }).clamp(0, 255) as u8);
    let text = gray(surface.text);
    visuals.panel_fill = gray(surface.panel);
    visuals.window_fill = gray(surface.panel);
    visuals.extreme_bg_color = gray(surface.base.saturating_sub(if dark { 8 } else { 0 }));
    visuals.faint_bg_color = step(surface.panel, 5);
    visuals.window_stroke = Stroke::new(1.0, palette.line);
    visuals.window_corner_radius = CornerRadius::same(10);
    visuals.menu_corner_radius = CornerRadius::same(8);
    visuals.window_shadow = Shadow {
        offset: [0, 8],
        blur: 28,
        spread: 0,
        color: Color32::from_black_alpha(if dark { 120 } else { 50 }),
    };
    visuals.popup_shadow = visuals.window_shadow;
    visuals.hyperlink_color = palette.accent;
    visuals.warn_fg_color = palette.warning;
    visuals.error_fg_color = palette.error;
    visuals.weak_text_color = Some(palette.weak);
    visuals.selection.bg_fill = palette.accent_fill.gamma_multiply(if dark { 0.55 } else { 0.45 });
    visuals.selection.stroke = Stroke::new(1.0, text);
    visuals.slider_trailing_fill = true;
    visuals.handle_shape = egui::style::HandleShape::Circle;
    visuals.interact_cursor = Some(egui::CursorIcon::PointingHand);
    let widgets = &mut visuals.widgets;
    let looks = [
        (&mut widgets.noninteractive, 0, palette.line, text),
        (&mut widgets.inactive, 0, Color32::TRANSPARENT, text),
        (&mut widgets.hovered, 10, palette.line, text),
        (&mut widgets.active, 18, palette.accent, text),
        (&mut widgets.open, 8, palette.line, text),
    ];
    for (look, raise, stroke, text) in looks {
        look.bg_fill = step(surface.control, raise);
        look.weak_bg_fill = step(surface.control, raise);
        look.bg_stroke = Stroke::new(1.0, stroke);
        look.fg_stroke = Stroke::new(1.2, text);
        look.corner_radius = CornerRadius::same(6);
        look.expansion = 0.0;
    }
    widgets.noninteractive.bg_fill = gray(surface.panel);
    widgets.noninteractive.weak_bg_fill = gray(surface.panel);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance of an opaque color (WCAG 2.2).
    fn luminance(color: Color32) -> f32 {
        let linear = |level: u8| {
            let share = f32::from(level) / 255.0;
            if share <= 0.04045 { share / 12.92 } else { ((share + 0.055) / 1.055).powf(2.4) }
        };
        let [r, g, b, _] = color.to_array();
        0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b)
    }

    fn contrast(a: Color32, b: Color32) -> f32 {
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn a_scroll_bar_covers_nothing() {
        let ctx = egui::Context::default();
        install(&ctx);
        for theme in [Theme::Dark, Theme::Light] {
            let scroll = ctx.style_of(theme).spacing.scroll;
            assert!(scroll.allocated_width() > scroll.bar_width, "{theme:?}");
        }
    }

    #[test]
    fn a_line_that_stands_out_surrounds_what_is_chosen() {
        for (theme, in_menu) in
            [Theme::Dark, Theme::Light].into_iter().flat_map(|theme| [(theme, false), (theme, true)])
        {
            let (ctx, mut panel) = (egui::Context::default(), Color32::TRANSPARENT);
            install(&ctx);
            ctx.set_theme(theme);
            let look = |chosen: bool| {
                let mut place = egui::Rect::NOTHING;
                let output = ctx.run_ui(egui::RawInput::default(), |ui| {
                    if in_menu {
                        egui::containers::menu::menu_style(ui.style_mut());
                    }
                    panel = ui.visuals().panel_fill;
                    place = ui.selectable_label(chosen, "Everywhere").rect;
                });
                let is_outlined = output.shapes.iter().any(|clipped| match &clipped.shape {
                    egui::Shape::Rect(rect) => {
                        let Stroke { width, color } = rect.stroke;
                        width >= 1.0 && color.is_opaque() && contrast(color, panel) >= 3.0
                    }
                    _ => false,
                });
                (is_outlined, place)
            };
            let [chosen, plain] = [true, false].map(look);
            assert_eq!([chosen.0, plain.0], [true, false], "{theme:?}, menu: {in_menu}");
            assert_eq!(chosen.1, plain.1, "{theme:?}, menu: {in_menu}");
        }
    }

    /// WCAG 2.2, criteria 1.4.3 and 1.4.11.
    #[test]
    fn text_and_controls_stand_out_from_what_they_are_drawn_on() {
        let white_on_black = contrast(Color32::WHITE, Color32::BLACK);
        assert!((white_on_black - 21.0).abs() < 1e-3, "{white_on_black}");
        let ctx = egui::Context::default();
        install(&ctx);
        for (theme, palette) in [(Theme::Dark, DARK), (Theme::Light, LIGHT)] {
            let visuals = &ctx.style_of(theme).visuals;
            let check = |what: &str, color, on: &str, ground, least: f32| {
                let found = contrast(color, ground);
                assert!(found >= least, "{theme:?}: {what} on {on}: {found:.2} of {least}");
            };
            let (panel, widgets) = (visuals.panel_fill, &visuals.widgets);
            let grounds = [
                ("a panel", panel),
                ("a field", visuals.extreme_bg_color),
                ("a card", palette.card),
                ("the stage", palette.stage),
                ("a button", widgets.inactive.weak_bg_fill),
            ];
            let texts = [
                ("text", visuals.text_color()),
                ("weak text", palette.weak),
                ("the accent", palette.accent),
                ("good news", palette.good),
                ("a warning", palette.warning),
                ("an error", palette.error),
            ];
            for (what, color) in texts {
                for (on, ground) in grounds {
                    check(what, color, on, ground, 4.5);
                }
            }
            // Buttons have no weak text, and none of errors.
            for (what, color) in [texts[0], texts[2], texts[3], texts[4]] {
                check(what, color, "a button under the pointer", widgets.hovered.weak_bg_fill, 4.5);
            }
            check("text", visuals.text_color(), "a pressed button", widgets.active.weak_bg_fill, 4.5);
            let selected = panel.blend(visuals.selection.bg_fill);
            check("text", visuals.selection.stroke.color, "what is selected", selected, 4.5);
            check("text", ON_ACCENT, "the accent", palette.accent_fill, 4.5);
            check("a slider's handle", widgets.inactive.fg_stroke.color, "a panel", panel, 3.0);
            check("an empty checkbox", palette.weak, "a panel", panel, 3.0);
            check("the ring of the focus", palette.accent, "a panel", panel, 3.0);
        }
    }
}
