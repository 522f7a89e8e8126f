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
    /// them, which is laid over the other.
    pub(super) fn color(&self, x: i32, y: i32, depths: [f32; 4], hidden: bool) -> [f32; 4] {
        let r = (x as f32 + 0.5 - self.center[0]).hypot(y as f32 + 0.5 - self.center[1]);
        let cover = 1.0 - smoothstep(self.radius - 0.7, self.radius + 0.7, r);
        let rim = smoothstep(self.radius * 0.68 - 0.6, self.radius * 0.68 + 0.6, r);
        let before = depths.iter().filter(|depth| self.depth <= **depth).count() as f32 / 4.0;
        let own = cover * self.color[3];
        let alpha = if hidden {
            // The two share no samples: what the part before will take from this one is added.
            own * HIDDEN * (1.0 - before) / (1.0 - own * before).max(1e-6)
        } else {
            own * before
        };
        let [r, g, b, _] = self.color.map(|c| mix(c, 1.0, rim) * alpha);
        [r, g, b, alpha]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disc_that_a_surface_cuts_is_the_mean_of_its_samples() {
        for opacity in [0.4, 1.0] {
            let disc = Disc { center: [0.5, 0.5], depth: 0.5, radius: 9.0, color: [0.0, 0.0, 0.0, opacity] };
            for before in 0..=4 {
                let depths = std::array::from_fn(|s| if s < before { 1.0 } else { 0.0 });
                let left = |hidden: bool| 1.0 - disc.color(0, 0, depths, hidden)[3];
                let share = before as f32 / 4.0;
                let mean = share * (1.0 - opacity) + (1.0 - share) * (1.0 - opacity * HIDDEN);
                let both = left(true) * left(false);
                assert!((both - mean).abs() < 1e-6, "{before} samples of opacity {opacity}: {both}, {mean}");
            }
        }
    }
}
