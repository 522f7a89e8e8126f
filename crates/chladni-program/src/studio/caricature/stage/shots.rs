//! Pictures of the stage, independent of later edits.

use std::sync::Arc;

use chladni_view::{Background, VertexPaint, ViewError};

use super::super::look::Portrayal;
use super::super::shot::{Coat, Pose, Shot};
use super::Stage;
use super::figures::moved;

impl Stage {
    /// What is shown now, on its own, before a `background`.
    pub fn shot(&self, look: Portrayal, background: Background) -> Result<Shot, ViewError> {
        let device = self.viewport.device();
        let coat = match &self.coat {
            Coat::Values(_, scale) => {
                let own = VertexPaint::new(device, self.heat.len());
                own.write_values(device, &self.heat)?;
                Coat::Values(own, *scale)
            }
            Coat::Colors(_) => {
                let own = VertexPaint::new(device, self.colors.len());
                own.write_colors(device, &self.colors)?;
                Coat::Colors(own)
            }
            constant @ (Coat::Material | Coat::Own(_)) => constant.clone(),
        };
        let figures = self.figures(look.show).iter();
        let (poses, moved) =
            figures.map(|f| (self.poses[*f].clone(), moved(&self.poses, *f, look.pen))).unzip();
        Ok(Shot { poses, moved, look, background, ..self.shot_of(Pose::default(), coat) })
    }

    /// Another pose of this shape, on its own, with nothing behind it.
    pub fn shot_of(&self, pose: Pose, coat: Coat) -> Shot {
        let (device, topology) = (self.viewport.device().clone(), self.topology.clone());
        Shot {
            device,
            topology,
            triangles: Arc::clone(&self.triangles),
            poses: vec![pose],
            moved: Vec::new(),
            coat,
            camera: self.camera,
            aspect: self.aspect,
            height: self.height,
            look: Portrayal::default(),
            background: Background::TRANSPARENT,
        }
    }
}
