//! Titles of the gallery's caricatures.

use super::sitter::Sitter;
use super::variant::{Group, Variant};
use super::weights::STIR;
use crate::Template;

impl Sitter {
    /// The effect of `variant`, in a few words.
    pub fn title(&self, variant: &Variant) -> String {
        let numbers = variant.genes(Group::Parts);
        let named = |wanted: fn(f32) -> bool| -> Vec<&str> {
            let mut stirred: Vec<usize> = (0..self.parts().len().min(numbers.len())).collect();
            stirred.retain(|part| wanted(numbers[*part]));
            stirred.sort_by(|a, b| numbers[*b].abs().total_cmp(&numbers[*a].abs()));
            stirred.into_iter().take(3).map(|part| self.parts()[part].name.as_str()).collect()
        };
        let (more, less) = (named(|x| x >= STIR), named(|x| x <= -STIR));
        let mut title = match (more.is_empty(), less.is_empty()) {
            (false, false) => format!("more {}, less {}; ", more.join(" and "), less.join(" and ")),
            (false, true) => format!("more {}; ", more.join(" and ")),
            (true, false) => format!("less {}; ", less.join(" and ")),
            (true, true) => String::new(),
        };
        title.push_str(&format!(
            "against {}, {} model",
            in_words(self.template_of(variant)),
            variant.model()
        ));
        title
    }
}

/// A template's name in a title.
fn in_words(template: &Template) -> String {
    match template {
        Template::File(path) => path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned(),
        Template::Sample(name) if name == "template" => "a plain head".into(),
        Template::Ellipsoid => "its ellipsoid".into(),
        Template::Sphere => "its sphere".into(),
        Template::LowPass(_) => "itself made smooth".into(),
        other => other.to_string(),
    }
}
