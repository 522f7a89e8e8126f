//! The texts of presets and shows, whose files have one ending.

/// Whether a text that is neither a valid preset nor a valid show was probably meant as a show.
pub fn is_like_a_show(text: &str) -> bool {
    text.parse::<toml::Table>().is_ok_and(|table| table.contains_key("actions") || table.contains_key("size"))
}

#[cfg(test)]
mod tests {
    use chladni_music::{Preset, Show};

    use super::*;

    #[test]
    fn a_newer_show_is_known_as_one() {
        let newer = "format_version = 99\nactions = []\n";
        assert!(Preset::from_text(newer).is_err() && Show::from_text(newer).is_err());
        assert!(is_like_a_show(newer));
        assert!(!is_like_a_show("format_version = 99\nmapping = {}\n"));
        assert!(!is_like_a_show("actions = ["));
    }
}
