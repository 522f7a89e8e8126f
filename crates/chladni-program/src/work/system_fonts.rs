//! The fonts of the system, for scripts that the built-in ones lack: Chinese, Japanese, Arabic and many others.

use std::sync::{Arc, LazyLock};

use egui_system_font_provider::SystemFontProvider;
use epaint::text::FontProvider;

/// Finds a font for characters that no other has. Window and pictures share it: it lists the fonts once, on a thread of its
/// own.
pub fn system_fonts() -> Arc<dyn FontProvider> {
    static FONTS: LazyLock<Arc<SystemFontProvider>> = LazyLock::new(Arc::default);
    Arc::<SystemFontProvider>::clone(&FONTS)
}
