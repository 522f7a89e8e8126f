//! The depth of a triangle's own plane.

use super::Bias;
use crate::cpu::project::{Corner, SUBPIXELS};

/// Depth over the screen.
pub(super) struct Plane {
    corner: Corner,
    /// Per sub-pixel.
    pub(super) across: f32,
    pub(super) down: f32,
    bias: f32,
    pub(super) low: f32,
    pub(super) high: f32,
}

impl Plane {
    #[inline(always)]
    pub(super) fn new([a, b, c]: [Corner; 3], area: i64, bias: Bias) -> Self {
        let area = area as f32;
        let (dx, dy) = ([(b.x - a.x) as f32, (c.x - a.x) as f32], [(b.y - a.y) as f32, (c.y - a.y) as f32]);
        let (db, dc) = (b.z - a.z, c.z - a.z);
        let across = (db * dy[1] - dc * dy[0]) / area;
        let down = (dc * dx[0] - db * dx[1]) / area;
        let low = if a.z < b.z { a.z } else { b.z };
        let high = if a.z > b.z { a.z } else { b.z };
        let (low, high) = (if low < c.z { low } else { c.z }, if high > c.z { high } else { c.z });
        // A unit in the last place of the farthest corner.
        let unit = f32::from_bits((high.to_bits() & 0x7f80_0000).saturating_sub(23 << 23));
        let steepest = if across.abs() > down.abs() { across.abs() } else { down.abs() };
        let bias = bias.units * unit + bias.slope * steepest * SUBPIXELS as f32;
        Self { corner: a, across, down, bias, low: low + bias, high: high + bias }
    }

    #[inline(always)]
    pub(super) fn at(&self, [x, y]: [i32; 2]) -> f32 {
        let corner = self.corner;
        corner.z + self.bias + self.across * (x - corner.x) as f32 + self.down * (y - corner.y) as f32
    }
}
