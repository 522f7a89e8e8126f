//! The viewpoint of the dance.

use chladni_mesh::Orientation;
use chladni_music::Viewpoint;
use chladni_view::Camera;
use egui::Ui;

use crate::studio::keys;
use crate::studio::viewport;

/// A camera at a viewpoint, for a picture whose size is not known yet.
pub fn camera_at(viewpoint: &Viewpoint, stands: Orientation) -> Camera {
    let Viewpoint { yaw_rad, pitch_rad, .. } = *viewpoint;
    let camera = Camera { yaw_rad, pitch_rad, stands, ..Camera::default() };
    let mut camera = Camera { distance: viewpoint.distance * camera.distance, ..camera };
    camera.pan(viewpoint.shift[0], viewpoint.shift[1], 1.0);
    camera
}

/// Moves the viewer by pointer and keys on `response`, which is so many cells high.
pub fn navigate(ui: &Ui, response: &egui::Response, viewpoint: &mut Viewpoint, cells_high: f32) {
    // A viewpoint is relative to how the shape stands: any stance gives the same.
    let before = camera_at(viewpoint, Orientation::Y_UP);
    let mut camera = before;
    if viewport::navigate(ui, response, &mut camera) {
        let shift = camera.shift_since(before.target);
        // It comes nearer to the middle of the picture, not to that of the shape.
        let nearer = before.distance / camera.distance;
        *viewpoint = Viewpoint {
            yaw_rad: camera.yaw_rad,
            pitch_rad: camera.pitch_rad,
            distance: camera.distance / Camera::default().distance,
            shift: std::array::from_fn(|i| nearer * viewpoint.shift[i] + cells_high * shift[i]),
        };
    }
    let asks = response.hovered() || response.has_focus();
    if asks && keys::view::FIT.pressed(ui.ctx()) {
        *viewpoint = Viewpoint { distance: 1.0, shift: [0.0; 2], ..*viewpoint };
    }
}
