//! Our own palettes, made in OKLab, and how they color a moving surface.

/// Colors in a row: lightness rises steadily, or the row closes into a circle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Palette {
    /// Night blue over green to pale yellow.
    #[default]
    Aurora,
    /// Coal over red to pale gold.
    Ember,
    /// Deep blue over turquoise to foam.
    Abyss,
    /// Violet over magenta to cream.
    Orchid,
    /// Brown over gold to pale yellow.
    Gold,
    /// Forest over leaves to spring.
    Moss,
    /// Verdigris over old bronze to what hands have polished.
    Patina,
    /// Black to white, hardly warm.
    Ink,
    /// White in the middle between dark green and dark magenta: still lines on a moving surface are light.
    Nodes,
    /// All hues, equally light; a circle.
    Prism,
    /// Pink, violet, blue and cyan, there and back; a circle.
    Neon,
    /// Indigo over rose to gold and back; a circle.
    Dusk,
    /// Pale pink, apricot, mint and lilac; a circle.
    Candy,
    /// A bright line on the dark, turquoise to either side; a circle. Along a shape it draws contours.
    Contour,
}

/// Lightness, chroma and hue in degrees (Ottosson, "A perceptual color space for image processing", 2020).
type Point = [f32; 3];

impl Palette {
    /// All of them, in the order of the rows of the renderer's lookup texture, after the color maps.
    pub const ALL: [Self; 14] = [
        Self::Aurora,
        Self::Ember,
        Self::Abyss,
        Self::Orchid,
        Self::Gold,
        Self::Moss,
        Self::Patina,
        Self::Ink,
        Self::Nodes,
        Self::Prism,
        Self::Neon,
        Self::Dusk,
        Self::Candy,
        Self::Contour,
    ];

    /// Name for menus and the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Aurora => "aurora",
            Self::Ember => "ember",
            Self::Abyss => "abyss",
            Self::Orchid => "orchid",
            Self::Gold => "gold",
            Self::Moss => "moss",
            Self::Patina => "patina",
            Self::Ink => "ink",
            Self::Nodes => "nodes",
            Self::Prism => "prism",
            Self::Neon => "neon",
            Self::Dusk => "dusk",
            Self::Candy => "candy",
            Self::Contour => "contour",
        }
    }

    /// The palette called `name`.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|palette| palette.name() == name)
    }

    /// Whether the last color is the first one, so that it can run around; others run there and back.
    pub fn is_circle(self) -> bool {
        matches!(self, Self::Prism | Self::Neon | Self::Dusk | Self::Candy | Self::Contour)
    }

    /// After how much of it it is as it was: other palettes than circles run there and back.
    pub(crate) fn period(self) -> f32 {
        if self.is_circle() { 1.0 } else { 2.0 }
    }

    /// Equidistant points; colors between two lie on a straight line in OKLab.
    fn points(self) -> &'static [Point] {
        match self {
            Self::Aurora => &[
                [0.20, 0.09, 285.0],
                [0.38, 0.14, 262.0],
                [0.56, 0.13, 200.0],
                [0.74, 0.18, 152.0],
                [0.91, 0.16, 126.0],
            ],
            Self::Ember => &[
                [0.14, 0.04, 15.0],
                [0.34, 0.13, 25.0],
                [0.54, 0.20, 33.0],
                [0.73, 0.18, 58.0],
                [0.92, 0.12, 95.0],
            ],
            Self::Abyss => &[
                [0.15, 0.06, 270.0],
                [0.34, 0.13, 258.0],
                [0.54, 0.13, 235.0],
                [0.74, 0.13, 205.0],
                [0.94, 0.07, 185.0],
            ],
            Self::Orchid => &[
                [0.20, 0.10, 295.0],
                [0.38, 0.19, 310.0],
                [0.56, 0.23, 345.0],
                [0.74, 0.17, 20.0],
                [0.93, 0.07, 75.0],
            ],
            Self::Gold => &[
                [0.17, 0.04, 50.0],
                [0.37, 0.09, 58.0],
                [0.57, 0.13, 70.0],
                [0.77, 0.16, 85.0],
                [0.95, 0.10, 100.0],
            ],
            Self::Moss => &[
                [0.18, 0.05, 165.0],
                [0.38, 0.10, 150.0],
                [0.57, 0.15, 138.0],
                [0.77, 0.18, 122.0],
                [0.95, 0.11, 108.0],
            ],
            Self::Patina => &[
                [0.24, 0.05, 195.0],
                [0.41, 0.085, 182.0],
                [0.57, 0.075, 165.0],
                [0.73, 0.11, 66.0],
                [0.90, 0.10, 78.0],
            ],
            Self::Ink => &[[0.10, 0.01, 265.0], [0.97, 0.01, 90.0]],
            Self::Nodes => &[
                [0.30, 0.12, 160.0],
                [0.46, 0.14, 185.0],
                [0.95, 0.01, 100.0],
                [0.46, 0.20, 350.0],
                [0.30, 0.15, 315.0],
            ],
            Self::Prism => &[
                [0.74, 0.16, 0.0],
                [0.74, 0.16, 30.0],
                [0.74, 0.16, 60.0],
                [0.74, 0.16, 90.0],
                [0.74, 0.16, 120.0],
                [0.74, 0.16, 150.0],
                [0.74, 0.16, 180.0],
                [0.74, 0.16, 210.0],
                [0.74, 0.16, 240.0],
                [0.74, 0.16, 270.0],
                [0.74, 0.16, 300.0],
                [0.74, 0.16, 330.0],
                [0.74, 0.16, 0.0],
            ],
            Self::Neon => &[
                [0.66, 0.27, 355.0],
                [0.56, 0.27, 312.0],
                [0.58, 0.21, 268.0],
                [0.72, 0.15, 225.0],
                [0.86, 0.14, 195.0],
                [0.72, 0.15, 225.0],
                [0.58, 0.21, 268.0],
                [0.56, 0.27, 312.0],
                [0.66, 0.27, 355.0],
            ],
            Self::Dusk => &[
                [0.28, 0.14, 282.0],
                [0.45, 0.19, 320.0],
                [0.64, 0.20, 10.0],
                [0.80, 0.16, 65.0],
                [0.92, 0.12, 95.0],
                [0.80, 0.16, 65.0],
                [0.64, 0.20, 10.0],
                [0.45, 0.19, 320.0],
                [0.28, 0.14, 282.0],
            ],
            Self::Contour => &[
                [0.16, 0.04, 265.0],
                [0.16, 0.05, 260.0],
                [0.18, 0.06, 255.0],
                [0.50, 0.13, 235.0],
                [0.95, 0.06, 190.0],
                [0.50, 0.13, 190.0],
                [0.18, 0.06, 255.0],
                [0.16, 0.05, 260.0],
                [0.16, 0.04, 265.0],
            ],
            Self::Candy => &[
                [0.78, 0.14, 0.0],
                [0.83, 0.12, 55.0],
                [0.88, 0.11, 110.0],
                [0.85, 0.10, 180.0],
                [0.78, 0.11, 250.0],
                [0.75, 0.14, 310.0],
                [0.78, 0.14, 0.0],
            ],
        }
    }

    /// The sRGB color of `t`; `t` outside [0, 1] is clamped, NaN gives the first.
    pub fn color(self, t: f32) -> [u8; 3] {
        let points = self.points();
        let at = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) } * (points.len() - 1) as f32;
        let left = (at as usize).min(points.len() - 2);
        let share = at - left as f32;
        let [a, b] = [left, left + 1].map(|i| lab_of(points[i]));
        in_gamut(std::array::from_fn(|i| a[i] + (b[i] - a[i]) * share))
    }

    /// Row of this palette in the lookup texture.
    pub(crate) fn row(self) -> usize {
        crate::ColorMap::ALL.len() + self as usize
    }
}

fn lab_of([lightness, chroma, hue]: Point) -> [f32; 3] {
    let (sin, cos) = hue.to_radians().sin_cos();
    [lightness, chroma * cos, chroma * sin]
}

/// The sRGB color of this lightness and hue in OKLab, with as much of its chroma as a screen can show.
fn in_gamut([lightness, a, b]: [f32; 3]) -> [u8; 3] {
    let inside = |rgb: &[f32; 3]| rgb.iter().all(|c| (-1e-4..=1.0001).contains(c));
    let at = |share: f32| linear_of([lightness, a * share, b * share]);
    let rgb = (0..=50).map(|i| at(1.0 - i as f32 / 50.0)).find(inside).unwrap_or(at(0.0));
    rgb.map(|c| (crate::style::encoded(c.clamp(0.0, 1.0)) * 255.0).round() as u8)
}

/// Linear-light sRGB of OKLab: Ottosson's matrices.
fn linear_of([lightness, a, b]: [f32; 3]) -> [f32; 3] {
    let [l, m, s] = [
        lightness + 0.396_337_78 * a + 0.215_803_76 * b,
        lightness - 0.105_561_346 * a - 0.063_854_17 * b,
        lightness - 0.089_484_18 * a - 1.291_485_5 * b,
    ]
    .map(|c| c * c * c);
    [
        4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_94 * s,
        -1.268_438 * l + 2.609_757_4 * m - 0.341_319_4 * s,
        -0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s,
    ]
}

/// How a surface is colored by what it does. A place of the palette is the sum
/// offset + span · along + crease · bend + swing · (d · n) + travel · |d| + haste · |v|, with d the way from the place's
/// rest, n the normal there, v what it lags behind itself (its speed, where the figure knows it), and `along` and
/// `bend` the numbers that its [`RestShape`](crate::RestShape) has for it. Palettes that are no circle run there and back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// Which colors.
    pub palette: Palette,
    /// Where the palette begins.
    pub offset: f32,
    /// How much of it lies along the shape.
    pub span: f32,
    /// How much of it lies between what is flat and the sharpest ridge; hollows are as far on the other side.
    pub crease: f32,
    /// How much of it a unit of length outward is.
    pub swing: f32,
    /// How much of it a unit of length in any direction is.
    pub travel: f32,
    /// How much of it a unit of [lag](crate::Figure::lag) is: speed.
    pub haste: f32,
    /// How often the palette goes around in one vibration: the angle of (d · n, v · n). A whole number, lest colors jump.
    pub phase: f32,
    /// Glow that a unit of length adds to the material's own.
    pub glow: f32,
    /// Glow that a unit of lag adds.
    pub spark: f32,
    /// How strong the colors are: 0 is gray, 1 the palette's own.
    pub saturation: f32,
    /// Lines where the surface vibrates and does not move.
    pub lines: NodalLines,
    /// How far the surface may go, in the coordinates of its item: what is far smaller has neither phase nor lines.
    pub farthest: f32,
}

/// Lines on a surface where what sounds now leaves it where it rests, along its normal: Chladni's figures.
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

    /// Whether it looks at more of a vertex than its way from the rest.
    pub(crate) fn is_figured(&self) -> bool {
        self.feels_speed() || self.lines.opacity > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// OKLab of an sRGB color.
    fn lab(color: [u8; 3]) -> [f32; 3] {
        let [r, g, b] = crate::style::linear(color);
        let [l, m, s] = [
            0.412_221_46 * r + 0.536_332_55 * g + 0.051_445_995 * b,
            0.211_903_5 * r + 0.680_699_5 * g + 0.107_396_96 * b,
            0.088_302_46 * r + 0.281_718_85 * g + 0.629_978_7 * b,
        ]
        .map(f32::cbrt);
        [
            0.210_454_26 * l + 0.793_617_8 * m - 0.004_072_047 * s,
            1.977_998_5 * l - 2.428_592_2 * m + 0.450_593_7 * s,
            0.025_904_037 * l + 0.782_771_77 * m - 0.808_675_77 * s,
        ]
    }

    fn row(palette: Palette) -> Vec<[f32; 3]> {
        (0..=64).map(|i| lab(palette.color(i as f32 / 64.0))).collect()
    }

    fn distance(a: &[f32; 3], b: &[f32; 3]) -> f32 {
        a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f32>().sqrt()
    }

    #[test]
    fn lightness_rises_along_a_row_and_circles_close() {
        for palette in Palette::ALL {
            let row = row(palette);
            let l: Vec<f32> = row.iter().map(|c| c[0]).collect();
            if palette.is_circle() {
                assert_eq!(palette.color(0.0), palette.color(1.0), "{palette:?}");
            } else if palette == Palette::Nodes {
                assert!(l[..33].windows(2).all(|pair| pair[1] > pair[0] - 0.002));
                assert!(l[32..].windows(2).all(|pair| pair[1] < pair[0] + 0.002));
                assert!((l[0] - l[64]).abs() < 0.01);
            } else {
                assert!(l.windows(2).all(|pair| pair[1] > pair[0]), "{palette:?} {l:?}");
                // Even steps of lightness: an eighth is no more than twice its fair share.
                let fair = (l[64] - l[0]) / 8.0;
                assert!(l.iter().step_by(8).zip(l[8..].iter().step_by(8)).all(|(a, b)| b - a < 2.0 * fair));
            }
        }
        let l: Vec<f32> = row(Palette::Prism).iter().map(|c| c[0]).collect();
        assert!(l.iter().all(|l| (l - 0.74).abs() < 0.01), "hues are not equally light: {l:?}");
    }

    #[test]
    fn no_two_neighbors_are_far_apart() {
        for palette in Palette::ALL {
            let row = row(palette);
            let steps: Vec<f32> = row.windows(2).map(|pair| distance(&pair[0], &pair[1])).collect();
            let mean = steps.iter().sum::<f32>() / steps.len() as f32;
            let most = steps.iter().copied().fold(0.0, f32::max);
            assert!(most < 3.0 * mean, "{palette:?}: {most} where {mean} is usual");
        }
    }

    #[test]
    fn names_are_found_again_and_numbers_that_are_none_have_a_color() {
        for palette in Palette::ALL {
            assert_eq!(Palette::named(palette.name()), Some(palette));
            assert_eq!(palette.color(f32::NAN), palette.color(0.0));
        }
    }
}
