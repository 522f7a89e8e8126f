//! Templates whose numbers are edited as text.

use chladni_caricature::Template;

use super::Error;

/// The text of a template that needs neither a mesh nor another layer; `None` for those that do.
pub fn template_text(template: &Template) -> Option<String> {
    let is_own = !template.is_mesh() && !matches!(template, Template::Layer(_));
    is_own.then(|| template.to_string())
}

/// The template of such a text.
///
/// # Errors
/// Text of another kind of template, or of none.
pub fn template_from(text: &str) -> Result<Template, Error> {
    let text = text.trim();
    let template: Template = text.parse()?;
    if template_text(&template).is_some() {
        return Ok(template);
    }
    Err(Error::input(format!(
        "{text}: write ellipsoid, sphere, ellipsoid:x,y,z,a,b,c, sphere:x,y,z,radius, self:scale=0.9, \
         self:lowpass=20 or self:original"
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_templates_are_edited_as_text() {
        let known =
            ["ellipsoid", "sphere:0,1,2,3", "ellipsoid:0,0,0,1,2,3", "self:scale=0.8", "self:lowpass=12"];
        for text in known {
            let template = template_from(&format!(" {text}")).unwrap();
            assert_eq!(template_text(&template).as_deref(), Some(text));
        }
        // A mesh has to be brought, and layers are chosen by their names.
        for text in ["head.ply", "sample:head", "self:layer=1", "self:scale=loud", ""] {
            assert!(template_from(text).is_err(), "{text}");
        }
        assert_eq!(template_text(&Template::Sample("head".into())), None);
    }
}
