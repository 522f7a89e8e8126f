//! Discs that face the viewer.

use glam::{Mat4, Vec3};

use super::curves::{mix, smoothstep};
use crate::Marker;
use crate::uniforms::CellUniform;

/// The opacity of a marker behind a surface.
const HIDDEN: f32 = 0.22;

/// First and last pixels that a disc may touch, along an axis.
pub(super) fn touched(center: [f32; 2], radius: f32, axis: usize) -> [i32; 2] {
    let grown = radius + 1.0;
    [(center[axis] - grown).floor() as i32, (center[axis] + grown).ceil() as i32]
}

/// A marker on the screen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Disc {
    center: [f32; 2],
    depth: f32,
    radius: f32,
    color: [f32; 4],
}

impl Disc {
    /// `None` before the near plane or beyond the far one.
    pub(super) fn new(marker: &Marker, cell: &CellUniform) -> Option<Self> {
        let (view, projection) =
            (Mat4::from_cols_array_2d(&cell.view), Mat4::from_cols_array_2d(&cell.projection));
        let at = view * Vec3::from(marker.position).extend(1.0);
        let clip = projection * at;
        let [left, top, width, height] = cell.viewport;
        // Half a disc towards the viewer, so that the surface below does not cut it.
        let lift = marker.radius_px * clip.w / (height * cell.projection[1][1]);
        let lifted = projection * (at + glam::Vec4::Z * (2.0 * lift));
        let depth = lifted.z / lifted.w;
        let center =
            [left + (0.5 + 0.5 * clip.x / clip.w) * width, top + (0.5 - 0.5 * clip.y / clip.w) * height];
        let on = clip.w > 0.0 && (0.0..=1.0).contains(&depth) && center.iter().all(|c| c.is_finite());
        let radius = marker.radius_px;
        let color = marker.color.map(|c| f32::from(c) / 255.0);
        (on && radius.is_finite()).then_some(Self { center, depth, radius, color })
    }

    /// First and last pixels that it may touch, along an axis.
    pub(super) fn span(&self, axis: usize) -> [i32; 2] {
        touched(self.center, self.radius, axis)
    }

    /// Premultiplied color at the middle of a pixel with samples of these depths, of its part behind them or of that before
    /// them.
    pub(super) fn color(&self, x: i32, y: i32, depths: [f32; 4], hidden: bool) -> [f32; 4] {
        let r = (x as f32 + 0.5 - self.center[0]).hypot(y as f32 + 0.5 - self.center[1]);
        let cover = 1.0 - smoothstep(self.radius - 0.7, self.radius + 0.7, r);
        let rim = smoothstep(self.radius * 0.68 - 0.6, self.radius * 0.68 + 0.6, r);
        let before = depths.iter().filter(|depth| self.depth <= **depth).count() as f32 / 4.0;
        let share = if hidden { HIDDEN * (1.0 - before) } else { before };
        let alpha = cover * self.color[3] * share;
        let [r, g, b, _] = self.color.map(|c| mix(c, 1.0, rim) * alpha);
        [r, g, b, alpha]
    }
}
