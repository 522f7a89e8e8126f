//! The place under the pointer, marked on all shapes that stand side by side: the same triangle holds it on each, on a
//! template through its match.

use chladni_view::Rect;
use egui::Ui;

use super::super::overlay::mark_place;
use super::Stage;
use super::pointing::Touch;
use crate::studio::viewport;

impl Stage {
    /// Draws the marks of `touch` over the figures that are `shown`, each in its cell of the canvas that fills `rect`: a disk
    /// where the place faces the viewer, a ring where it faces away.
    pub(super) fn mark_on_each(&self, ui: &Ui, rect: egui::Rect, touch: &Touch, shown: &[(usize, Rect)]) {
        let scale = 1.0 / ui.pixels_per_point();
        for (figure, cell) in shown {
            let Some((point, normal)) = self.place(*figure, touch) else { continue };
            let Some((at, _)) = self.camera.project(point, *cell) else { continue };
            let at = rect.min + egui::Vec2::from(at) * scale;
            let [x, y] = [at.x - rect.min.x, at.y - rect.min.y].map(|c| c / scale);
            let eye = self.camera.eye_at(x, y, *cell);
            let faces =
                (0..3).map(|i| f64::from(normal[i]) * (eye[i] - f64::from(point[i]))).sum::<f64>() > 0.0;
            mark_place(ui, viewport::to_points(ui, rect, *cell), at, faces);
        }
    }

    /// Where `touch` lies on a figure, and its normal there.
    fn place(&self, figure: usize, touch: &Touch) -> Option<([f32; 3], [f32; 3])> {
        let (positions, normals) = self.poses.get(figure)?;
        let corners = self.triangles.get(touch.hit.triangle as usize)?;
        let mixed = |values: &[[f32; 3]]| {
            let corner = |i: usize| values.get(corners[i] as usize).copied().unwrap_or_default();
            let [a, b, c] = [corner(0), corner(1), corner(2)];
            let [u, v, w] = touch.hit.barycentric;
            std::array::from_fn(|i| u * a[i] + v * b[i] + w * c[i])
        };
        Some((mixed(positions), mixed(normals)))
    }
}
