//! New layers: against templates that need no file, and against a mesh.

use std::path::PathBuf;
use std::sync::Arc;

use chladni_caricature::{Layer, LayerId, Project, Template};
use chladni_mesh::ShapeSource;

/// A template that needs no file.
#[derive(Clone, Copy, Debug)]
pub struct StartingPoint {
    /// A lasting identifier; the name may change.
    pub id: &'static str,
    /// Its name, which its layers get, too, with a number.
    pub name: &'static str,
    /// The comparison that it makes, for a tooltip.
    pub tip: &'static str,
    template: fn() -> Template,
}

/// All of them, in the order of menus.
pub const STARTING_POINTS: [StartingPoint; 7] = [
    point("ellipsoid", "Ellipsoid", "Against the ellipsoid that fits the shape", || Template::Ellipsoid),
    point("sphere", "Sphere", "Against the sphere that fits the shape", || Template::Sphere),
    point("head", "Plain head", "Against the sample head", || Template::Sample("template".into())),
    point("sliders", "Head of sliders", "Against a head that is made by sliders", || {
        Template::Sample("portrait".into())
    }),
    point("own-detail", "Own detail", "Against a smooth version of itself: its own detail grows", || {
        Template::LowPass(20)
    }),
    point("magnify", "Magnify all", "Against itself scaled down: all that is there grows", || {
        Template::Scaled(0.9)
    }),
    point("original", "Layers below", "Against the shape under all layers: all changes below grow", || {
        Template::Original
    }),
];

const fn point(
    id: &'static str,
    name: &'static str,
    tip: &'static str,
    template: fn() -> Template,
) -> StartingPoint {
    StartingPoint { id, name, tip, template }
}

impl StartingPoint {
    /// A layer of `project` against it, to be put on top, where the shape has `most` harmonics: a small shape has fewer
    /// than the project asks for.
    pub fn layer(&self, project: &Project, most: usize) -> Layer {
        let template = match (self.template)() {
            Template::LowPass(harmonics) => Template::LowPass(harmonics.min(most)),
            other => other,
        };
        project.new_layer(format!("{} {}", self.name, project.layers().len() + 1), template)
    }
}

/// The layers whose results a new layer on top can be compared with. Not the topmost: nothing comes between them.
pub fn results(project: &Project) -> &[(LayerId, Arc<Layer>)] {
    project.layers().split_last().map_or(&[], |(_, below)| below)
}

/// A layer of `project` against the result of its layer `below`, which is called `name`, to be put on top.
pub fn layer_since(project: &Project, below: LayerId, name: &str) -> Layer {
    project.new_layer(format!("Since {name}"), Template::Layer(below))
}

/// A layer of `project` against the mesh at `path`, or `sample:NAME`, to be put on top.
pub fn layer_against(project: &Project, path: PathBuf) -> Layer {
    match ShapeSource::named(path) {
        ShapeSource::Sample(name) => project.new_layer(name.clone(), Template::Sample(name)),
        ShapeSource::File(path) => {
            let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
            project.new_layer(stem.unwrap_or_else(|| "Template".into()), Template::File(path))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smooth_template_keeps_no_more_harmonics_than_the_shape_has() {
        let project = Project::new(ShapeSource::Sample("head".into()), 96);
        let own = STARTING_POINTS.iter().find(|point| point.id == "own-detail").unwrap();
        for (most, kept) in [(12, 12), (96, 20)] {
            assert_eq!(own.layer(&project, most).template, Template::LowPass(kept));
        }
    }

    #[test]
    fn a_sample_is_a_template_wherever_a_file_is() {
        let project = Project::new(ShapeSource::Sample("head".into()), 20);
        let layer = layer_against(&project, "sample:template".into());
        assert_eq!((layer.name.as_str(), layer.template), ("template", Template::Sample("template".into())));
        let layer = layer_against(&project, "heads/max.ply".into());
        assert_eq!((layer.name.as_str(), layer.template), ("max", Template::File("heads/max.ply".into())));
    }
}
