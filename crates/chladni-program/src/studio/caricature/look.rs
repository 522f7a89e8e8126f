//! The stage of the caricature room, and how it looks.

use chladni_view::{Figure, ItemBuffers, Lights, Material, Paint, Topology, Wire};

use crate::work::Pen;

/// The figures on the stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Show {
    /// The result, large.
    #[default]
    Result,
    /// The selected layer in all three models.
    Models,
    /// The original beside the result.
    BeforeAfter,
    /// The result beside the template of the selected layer.
    Template,
    /// The original alone, while a key is held.
    Original,
}

/// How it looks; a choice of the user, not of the project.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Portrayal {
    /// The figures on the stage.
    pub show: Show,
    /// Edges of triangles.
    pub wire: bool,
    /// The template of the selected layer over the figures, translucent.
    pub ghost: bool,
    /// A drawing in ink instead of material and light.
    pub ink: bool,
    /// How it is drawn in ink.
    pub pen: Pen,
    /// Index into [`Material::PRESETS`].
    pub material: usize,
    /// Index into [`Lights::PRESETS`].
    pub lights: usize,
}

impl Portrayal {
    /// The chosen lights.
    pub fn lights(&self) -> Lights {
        Lights::PRESETS.get(self.lights).map_or(Lights::STUDIO, |preset| preset.1)
    }

    /// The chosen material.
    pub fn material(&self) -> Material {
        Material::PRESETS.get(self.material).map_or(Material::CLAY, |preset| preset.1)
    }

    /// A figure in the chosen material, with edges where they are wanted, for `scale` pixels a point.
    pub fn figure<'a>(
        &self,
        topology: &'a Topology,
        buffers: &'a ItemBuffers,
        item: usize,
        paint: Paint<'a>,
        scale: f32,
    ) -> Figure<'a> {
        let material = self.material();
        // Thinner ones would be lost between pixels.
        let width_px = scale.max(0.5);
        let wire = self.wire.then_some(Wire { color: [20, 20, 24], opacity: 0.35, width_px });
        Figure { material, paint, wire, ..Figure::new(topology, buffers, item) }
    }
}
