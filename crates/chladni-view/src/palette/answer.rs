//! How palettes color a moving surface.

use super::Palette;

/// How the movement of a surface chooses its color. The position in the palette is
/// offset + span · along + crease · bend + swing · (d · n) + travel · |d| + haste · |v|,
/// where d is the displacement from rest, n the normal, v the lag (how far the surface trails behind itself: its
/// speed, if the figure knows it), and `along` and `bend` come from its [`RestShape`](crate::RestShape). A palette
/// that is not a circle runs to its end and back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// Which colors.
    pub palette: Palette,
    /// Where the palette begins.
    pub offset: f32,
    /// How much of it lies along the shape.
    pub span: f32,
    /// How much of it lies between flat places and the sharpest ridge; hollows are as far on the other side.
    pub crease: f32,
    /// How much of it a unit of length outward is.
    pub swing: f32,
    /// How much of it a unit of length in any direction is.
    pub travel: f32,
    /// How much of it a unit of [lag](crate::Figure::lag) is: speed.
    pub haste: f32,
    /// Turns of the palette in one vibration: it follows the angle of (d · n, v · n). A whole number, so that colors
    /// do not jump.
    pub phase: f32,
    /// Glow that a unit of length adds to the material's own.
    pub glow: f32,
    /// Glow that a unit of lag adds.
    pub spark: f32,
    /// How strong the colors are: 0 is gray, 1 the palette's own.
    pub saturation: f32,
    /// Lines where the surface vibrates and does not move.
    pub lines: NodalLines,
    /// How far the surface may go, in the coordinates of its item: far smaller displacements have neither phase nor
    /// lines.
    pub farthest: f32,
}

/// Chladni's figures: lines where the current sound leaves the surface at rest along its normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodalLines {
    /// sRGB.
    pub color: [u8; 3],
    /// In [0, 1]; 0 draws none.
    pub opacity: f32,
    /// Half their width, where the picture is 720 high.
    pub width: f32,
}

impl NodalLines {
    /// No lines.
    pub const NONE: Self = Self { color: [255; 3], opacity: 0.0, width: 1.0 };
}

impl Answer {
    /// From the palette's beginning at rest to its end a unit away.
    pub const MOVED: Self = Self {
        palette: Palette::Aurora,
        offset: 0.0,
        span: 0.0,
        crease: 0.0,
        swing: 0.0,
        travel: 1.0,
        haste: 0.0,
        phase: 0.0,
        glow: 0.0,
        spark: 0.0,
        saturation: 1.0,
        lines: NodalLines::NONE,
        farthest: 1.0,
    };

    /// Whether it asks for the figure's [lag](crate::Figure::lag).
    pub fn feels_speed(&self) -> bool {
        [self.haste, self.phase, self.spark].iter().any(|share| *share != 0.0)
    }

    /// Whether it reads more of a vertex than its displacement.
    pub(crate) fn is_figured(&self) -> bool {
        self.feels_speed() || self.lines.opacity > 0.0
    }
}
