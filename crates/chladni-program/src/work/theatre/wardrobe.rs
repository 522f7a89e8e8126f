//! What a body wears: palettes, and the colors that it brings.

use chladni_view::{Device, Look, Paint, RestShape, Topology, ViewError};

use super::Staging;
use super::coarse_uvs::coarse_uvs;
use crate::work::{OwnLook, OwnPaint};

/// The sources of a body's colors, on the device that draws it.
pub struct Wardrobe {
    rest: RestShape,
    own: Option<OwnPaint>,
}

impl Wardrobe {
    /// The source of color that a look asks for. Where the body brings no colors it is as if the look did not ask for them.
    pub fn paint(&self, look: &Look) -> Paint<'_> {
        match (&self.own, look.answer) {
            (Some(own), _) if look.own_colors => own.paint(),
            (_, Some(answer)) => Paint::Answer(&self.rest, answer),
            (_, None) => Paint::Material,
        }
    }
}

impl Staging {
    /// The body has these colors of its own.
    pub fn color(&mut self, own: Option<OwnLook>) {
        self.own = own;
    }

    /// Whether the body has colors of its own.
    pub fn has_own_colors(&self) -> bool {
        self.own.is_some()
    }

    /// The body at rest, for palettes, and its own colors.
    ///
    /// # Errors
    /// Colors that the device cannot hold.
    pub fn wardrobe(&self, device: &Device) -> Result<Wardrobe, ViewError> {
        let rest = RestShape::new(device, &self.rest, &self.along, &self.bends)?;
        let own = self.own.as_ref().map(|own| OwnPaint::on(device, own)).transpose()?;
        Ok(Wardrobe { rest, own })
    }

    /// The body's `triangles` on a device; or, where there are `fewer` over the same vertices, those.
    ///
    /// # Errors
    /// Triangles that do not fit the vertices or the device.
    pub fn topology(
        &self,
        device: &Device,
        triangles: &[[u32; 3]],
        fewer: Option<&[[u32; 3]]>,
    ) -> Result<Topology, ViewError> {
        let vertices = self.rest.len();
        match (fewer, &self.own) {
            (Some(fewer), Some(OwnLook::Image { corner_uvs, .. })) => {
                let uvs = coarse_uvs(&self.rest, triangles, corner_uvs, fewer);
                Topology::with_uvs(device, vertices, fewer, &uvs)
            }
            (Some(fewer), _) => Topology::new(device, vertices, fewer),
            (None, own) => OwnLook::topology(own.as_ref(), device, vertices, triangles),
        }
    }
}
