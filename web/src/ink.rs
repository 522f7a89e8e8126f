//! Drawings in ink, which take too long for the page's own thread: a worker makes them.

use chladni_mesh::Orientation;
use chladni_program::work::{Depth, Error, pen, plate};
use chladni_view::ink::{Drawing, Plate};
use chladni_view::{Camera, Projection, Rect};
use serde::{Deserialize, Serialize};
use wasm_bindgen::prelude::*;

/// Where somebody looks from, on its way to a worker.
#[derive(Serialize, Deserialize)]
pub struct Viewer {
    target: [f32; 3],
    yaw_rad: f32,
    pitch_rad: f32,
    distance: f32,
    reach: f32,
    fov_y_rad: f32,
    orthographic: bool,
    stands: Orientation,
}

impl From<Camera> for Viewer {
    fn from(camera: Camera) -> Self {
        let Camera { target, yaw_rad, pitch_rad, distance, reach, fov_y_rad, projection, stands } = camera;
        let orthographic = projection == Projection::Orthographic;
        Self { target, yaw_rad, pitch_rad, distance, reach, fov_y_rad, orthographic, stands }
    }
}

impl From<Viewer> for Camera {
    fn from(viewer: Viewer) -> Self {
        let Viewer { target, yaw_rad, pitch_rad, distance, reach, fov_y_rad, orthographic, stands } = viewer;
        let projection = if orthographic { Projection::Orthographic } else { Projection::Perspective };
        Self { target, yaw_rad, pitch_rad, distance, reach, fov_y_rad, projection, stands }
    }
}

/// A shape that is ready to be drawn.
#[wasm_bindgen]
pub struct Inker {
    plate: Plate,
}

#[wasm_bindgen]
impl Inker {
    /// A shape of these coordinates and corners, three each.
    ///
    /// # Errors
    /// A shape without a surface.
    #[wasm_bindgen(constructor)]
    pub fn new(positions: &[f32], triangles: &[u32]) -> Result<Self, JsError> {
        Ok(Self { plate: plate(positions.as_chunks().0, triangles.as_chunks().0)? })
    }

    /// The drawing as RGBA, rows from the top, seen by [`Sitting::viewer`](crate::Sitting::viewer): with `shade`, or only
    /// its lines.
    ///
    /// # Errors
    /// A picture without pixels or too large.
    pub fn pixels(
        &self,
        viewer: &str,
        tones: bool,
        shade: bool,
        width: u32,
        height: u32,
    ) -> Result<Vec<u8>, JsError> {
        let depth = if shade { Depth::Shade } else { Depth::Lines };
        Ok(self.drawing(viewer, tones, depth, width, height)?.to_picture().rgba)
    }

    /// All of the drawing as PNG.
    ///
    /// # Errors
    /// As [`pixels`](Self::pixels).
    pub fn png(&self, viewer: &str, tones: bool, width: u32, height: u32) -> Result<Vec<u8>, JsError> {
        let drawing = self.drawing(viewer, tones, Depth::Shade, width, height)?;
        Ok(drawing.to_picture().to_png()?)
    }

    /// All of the drawing as the text of an SVG.
    ///
    /// # Errors
    /// As [`pixels`](Self::pixels).
    pub fn svg(&self, viewer: &str, tones: bool, width: u32, height: u32) -> Result<String, JsError> {
        Ok(self.drawing(viewer, tones, Depth::Shade, width, height)?.to_svg())
    }
}

impl Inker {
    fn drawing(
        &self,
        viewer: &str,
        tones: bool,
        depth: Depth,
        width: u32,
        height: u32,
    ) -> Result<Drawing, JsError> {
        let camera = Camera::from(serde_json::from_str::<Viewer>(viewer)?);
        let ink = pen(tones);
        let mut drawing = Drawing::new(width, height, &ink).map_err(Error::from)?;
        depth.draw(&mut drawing, &self.plate, &ink, &camera, Rect::of_size(width, height));
        Ok(drawing)
    }
}
