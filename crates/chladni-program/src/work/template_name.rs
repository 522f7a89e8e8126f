//! Names of templates in the window and on the web page.

use chladni_caricature::{Project, Template};
use chladni_mesh::samples::portrait_sliders;

use super::shown_name;

/// The name under which a template of a layer of `project` is shown.
pub fn template_name(template: &Template, project: &Project) -> String {
    match template {
        Template::File(path) => shown_name(path).into_owned(),
        Template::Sample(name) if portrait_sliders(name).is_some() => "head of sliders".into(),
        Template::Sample(name) => format!("sample {name}"),
        Template::Ellipsoid => "fitted ellipsoid".into(),
        Template::Sphere => "fitted sphere".into(),
        Template::Given(given) if given.semi_axes == [given.semi_axes[0]; 3] => "given sphere".into(),
        Template::Given(_) => "given ellipsoid".into(),
        Template::Scaled(factor) => format!("itself × {factor:.2}"),
        Template::LowPass(k0) => format!("itself below harmonic {k0}"),
        Template::Original => "the original shape".into(),
        Template::Layer(id) => {
            let name = project.layer(*id).map_or_else(|| id.0.to_string(), |layer| layer.name.clone());
            format!("the result of {name}")
        }
    }
}
