//! Color maps for values on a surface: perceptually uniform and readable by color-blind eyes.

/// How a value in [0, 1] becomes a color.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ColorMap {
    /// Violet over green to yellow; for magnitudes (van der Walt & Smith, matplotlib 2015).
    #[default]
    Viridis,
    /// Blue over gray to yellow, the same to all eyes (Nuñez, Anderton & Renslow 2018).
    Cividis,
    /// Black over magenta to cream; for magnitudes on a dark ground (matplotlib 2015).
    Magma,
    /// Blue over white to red; for signed values, white is zero (Brewer's RdBu, reversed).
    BlueRed,
}

impl ColorMap {
    /// All maps, in the order of the rows of the renderer's lookup texture.
    pub const ALL: [Self; 4] = [Self::Viridis, Self::Cividis, Self::Magma, Self::BlueRed];

    /// Name for menus.
    pub fn name(self) -> &'static str {
        match self {
            Self::Viridis => "Viridis",
            Self::Cividis => "Cividis",
            Self::Magma => "Magma",
            Self::BlueRed => "Blue–red",
        }
    }

    /// Equidistant control points, sRGB.
    fn points(self) -> &'static [[u8; 3]] {
        match self {
            Self::Viridis => &VIRIDIS,
            Self::Cividis => &CIVIDIS,
            Self::Magma => &MAGMA,
            Self::BlueRed => &BLUE_RED,
        }
    }

    /// The sRGB color of `t`; `t` outside [0, 1] is clamped, NaN gives gray.
    pub fn color(self, t: f32) -> [u8; 3] {
        if t.is_nan() {
            return [128; 3];
        }
        let points = self.points();
        let at = t.clamp(0.0, 1.0) * (points.len() - 1) as f32;
        let left = (at as usize).min(points.len() - 2);
        let share = at - left as f32;
        std::array::from_fn(|i| {
            let (a, b) = (f32::from(points[left][i]), f32::from(points[left + 1][i]));
            (a + (b - a) * share).round() as u8
        })
    }

    /// Row of this map in the lookup texture.
    pub(crate) fn row(self) -> usize {
        self as usize
    }
}

/// A color map over a range of values, as a legend shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Colors.
    pub map: ColorMap,
    /// Value of the map's first color.
    pub low: f32,
    /// Value of the map's last color.
    pub high: f32,
}

impl Scale {
    /// The range of `values`, symmetric about zero for [`ColorMap::BlueRed`]; values that are
    /// not finite are left out, and a range of no width becomes one of width 1, or wider where f32 is coarser.
    pub fn of(map: ColorMap, values: &[f32]) -> Self {
        let finite = values.iter().copied().filter(|value| value.is_finite());
        let (mut low, mut high) =
            finite.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        if map == ColorMap::BlueRed {
            high = high.abs().max(low.abs());
            low = -high;
        }
        if low == high {
            let half = 0.5_f32.max(low.abs() * 2.0 * f32::EPSILON);
            (low, high) = (low - half, high + half);
        }
        Self { map, low, high }
    }

    /// sRGB color of `value`.
    pub fn color(&self, value: f32) -> [u8; 3] {
        self.map.color((value - self.low) / (self.high - self.low))
    }

    /// At most `most` round values between `low` and `high`, for the ticks of a legend; none where `most` is below 2.
    pub fn ticks(&self, most: usize) -> Vec<f32> {
        let span = f64::from(self.high) - f64::from(self.low);
        if !(span > 0.0 && span.is_finite()) || most < 2 {
            return Vec::new();
        }
        let raw = span / most as f64;
        let decade = 10_f64.powf(raw.log10().floor());
        // A step may leave one tick too many, where both ends of the range are round; the next does not.
        for step in [1.0, 2.0, 5.0, 10.0, 20.0].map(|s| s * decade).into_iter().filter(|s| *s >= raw) {
            let first = (f64::from(self.low) / step).ceil() as i64;
            let last = (f64::from(self.high) / step + 1e-9).floor() as i64;
            let ticks = first..=last;
            if ticks.clone().count() <= most {
                return ticks.map(|i| (i as f64 * step) as f32).collect();
            }
        }
        Vec::new()
    }
}

const VIRIDIS: [[u8; 3]; 10] = [
    [0x44, 0x01, 0x54],
    [0x48, 0x28, 0x78],
    [0x3e, 0x49, 0x89],
    [0x31, 0x68, 0x8e],
    [0x26, 0x82, 0x8e],
    [0x1f, 0x9e, 0x89],
    [0x35, 0xb7, 0x79],
    [0x6e, 0xce, 0x58],
    [0xb5, 0xde, 0x2b],
    [0xfd, 0xe7, 0x25],
];
const CIVIDIS: [[u8; 3]; 10] = [
    [0x00, 0x22, 0x4e],
    [0x12, 0x35, 0x70],
    [0x3b, 0x49, 0x6c],
    [0x57, 0x5d, 0x6d],
    [0x70, 0x71, 0x73],
    [0x8a, 0x86, 0x78],
    [0xa5, 0x9c, 0x74],
    [0xc3, 0xb3, 0x69],
    [0xe1, 0xcc, 0x55],
    [0xfe, 0xe8, 0x38],
];
const MAGMA: [[u8; 3]; 10] = [
    [0x00, 0x00, 0x04],
    [0x18, 0x0f, 0x3d],
    [0x44, 0x0f, 0x76],
    [0x72, 0x1f, 0x81],
    [0x9e, 0x2f, 0x7f],
    [0xcd, 0x40, 0x71],
    [0xf1, 0x60, 0x5d],
    [0xfd, 0x96, 0x68],
    [0xfe, 0xca, 0x8d],
    [0xfc, 0xfd, 0xbf],
];
const BLUE_RED: [[u8; 3]; 11] = [
    [5, 48, 97],
    [33, 102, 172],
    [67, 147, 195],
    [146, 197, 222],
    [209, 229, 240],
    [247, 247, 247],
    [253, 219, 199],
    [244, 165, 130],
    [214, 96, 77],
    [178, 24, 43],
    [103, 0, 31],
];

#[cfg(test)]
mod tests {
    use super::*;

    /// CIE L* of an sRGB color (IEC 61966-2-1, CIE 15).
    fn lightness(color: [u8; 3]) -> f64 {
        let [r, g, b] = color.map(|c| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        });
        let y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        if y > 0.008856 { 116.0 * y.cbrt() - 16.0 } else { 903.3 * y }
    }

    #[test]
    fn lightness_rises_steadily_along_each_sequential_map() {
        for map in [ColorMap::Viridis, ColorMap::Cividis, ColorMap::Magma] {
            let l: Vec<f64> = (0..=64).map(|i| lightness(map.color(i as f32 / 64.0))).collect();
            assert!(l.windows(2).all(|pair| pair[1] > pair[0]), "{map:?} {l:?}");
            // Even steps: no step of 1/8 of the map is over twice its fair share.
            let fair = (l[64] - l[0]) / 8.0;
            assert!(l.iter().step_by(8).zip(l[8..].iter().step_by(8)).all(|(a, b)| b - a < 2.0 * fair));
        }
    }

    #[test]
    fn the_signed_map_is_lightest_at_zero_and_as_dark_on_either_side() {
        let l: Vec<f64> = (0..=64).map(|i| lightness(ColorMap::BlueRed.color(i as f32 / 64.0))).collect();
        assert!(l[..33].windows(2).all(|pair| pair[1] > pair[0]));
        assert!(l[32..].windows(2).all(|pair| pair[1] < pair[0]));
        assert!((l[0] - l[64]).abs() < 5.0);
    }

    #[test]
    fn legends_have_round_ticks_inside_their_range() {
        let scale = Scale { map: ColorMap::Viridis, low: -0.13, high: 1.02 };
        assert_eq!(scale.ticks(6), [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]);
        assert!(Scale { low: f32::NAN, ..scale }.ticks(5).is_empty());
        let scale = Scale { low: 0.0, high: 1.0, ..scale };
        assert_eq!(scale.ticks(5), [0.0, 0.5, 1.0]);
        for most in 2..40 {
            assert!((1..=most).contains(&scale.ticks(most).len()), "{most}");
        }
    }

    #[test]
    fn a_range_leaves_out_what_is_not_finite() {
        let scale = Scale::of(ColorMap::BlueRed, &[f32::NAN, -1.0, 3.0, f32::INFINITY]);
        assert_eq!((scale.low, scale.high), (-3.0, 3.0));
        for value in [2.0, 1e8, -1e30] {
            let color = Scale::of(ColorMap::Viridis, &[value]).color(value);
            assert_eq!(color, ColorMap::Viridis.color(0.5), "{value}");
        }
    }
}
