//! Our own palettes, made in OKLab, and how they color a moving surface.

mod answer;
mod points;

pub use self::answer::{Answer, NodalLines};
use self::points::Point;

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

    /// Where in [0, 1] a surface finds its color for any `t`: circles go around, others run there and back.
    pub(crate) fn place(self, t: f32) -> f32 {
        let t = t.rem_euclid(self.period());
        if self.is_circle() { t } else { 1.0 - (1.0 - t).abs() }
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
