//! The icons of the window, by what they mean here. Drawn from the Lucide font.

use egui::accesskit::{Node, Role};
pub use lucide_icons::Icon;

/// An icon as text, to stand alone or in a label.
pub fn text(icon: Icon) -> String {
    char::from(icon).to_string()
}

/// An icon followed by a label.
pub fn label(icon: Icon, label: &str) -> String {
    format!("{}  {label}", char::from(icon))
}

/// Adds the icon font as second choice, behind the text font.
pub fn install(fonts: &mut egui::FontDefinitions) {
    let name = "lucide";
    let mut data = egui::FontData::from_static(lucide_icons::LUCIDE_FONT_BYTES);
    // Lucide's glyphs sit on the baseline; text of this size wants them a little lower.
    data.tweak.y_offset_factor = 0.09;
    fonts.font_data.insert(name.into(), data.into());
    for family in [egui::FontFamily::Proportional, egui::FontFamily::Monospace] {
        let fonts_of_family = fonts.families.entry(family).or_default();
        fonts_of_family.insert(fonts_of_family.len().min(1), name.into());
    }
}

/// Keeps icons out of what screen readers say: they have no names there. A control that is nothing but
/// an icon is called what its tooltip says.
pub struct Unspoken;

impl egui::Plugin for Unspoken {
    fn debug_name(&self) -> &'static str {
        "unspoken icons"
    }

    fn output_hook(&mut self, _: &egui::Context, output: &mut egui::FullOutput) {
        let Some(update) = &mut output.platform_output.accesskit_update else { return };
        for (_, node) in &mut update.nodes {
            silence(node);
        }
    }
}

fn silence(node: &mut Node) {
    // The lengths of a run's characters are stored beside it.
    if node.role() == Role::TextRun {
        return;
    }
    if let Some(text) = node.value().and_then(without_icons) {
        node.set_value(text);
    }
    if let Some(text) = node.label().and_then(without_icons) {
        let tooltip = node.description().map(str::to_owned);
        node.set_label(if text.is_empty() { tooltip.unwrap_or_default() } else { text });
    }
}

/// `text` without its icons; `None` where there are none.
fn without_icons(text: &str) -> Option<String> {
    let is_icon = |c: char| ('\u{e000}'..='\u{f8ff}').contains(&c);
    text.contains(is_icon).then(|| text.replace(is_icon, "").trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn icons_are_not_said_and_stand_for_their_tooltips() {
        let spoken = |label: &str| {
            let mut node = Node::new(Role::Button);
            node.set_label(label);
            node.set_description("Save (Ctrl+S)");
            silence(&mut node);
            node.label().map(str::to_owned)
        };
        assert_eq!(spoken(&label(Icon::Save, "Keep")).as_deref(), Some("Keep"));
        assert_eq!(spoken(&text(Icon::Save)).as_deref(), Some("Save (Ctrl+S)"));
        assert_eq!(spoken("×2 …").as_deref(), Some("×2 …"));
    }
}
