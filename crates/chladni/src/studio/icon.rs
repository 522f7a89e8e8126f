//! The icons of the window, by what they mean here. Drawn from the Lucide font.

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
