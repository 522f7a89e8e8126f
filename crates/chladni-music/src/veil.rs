//! The last look at a picture: a veil toward black or white where it would flash.

use crate::{FlashLimiter, most_flashes_per_second};

/// How often each sRGB-encoded value occurs in a picture, per channel.
///
/// It gives the mean relative luminance (WCAG) under any [`Veil`] without reading the pixels again.
#[derive(Clone, Debug)]
pub struct Histogram {
    counts: [[u32; 256]; 3],
    linear: [f32; 256],
}

impl Default for Histogram {
    fn default() -> Self {
        let linear = std::array::from_fn(|byte| {
            let c = byte as f32 / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        });
        Self { counts: [[0; 256]; 3], linear }
    }
}

impl Histogram {
    /// Forgets all pixels.
    pub fn clear(&mut self) {
        self.counts = [[0; 256]; 3];
    }

    /// Counts a pixel.
    pub fn add(&mut self, rgb: [u8; 3]) {
        for (counts, value) in self.counts.iter_mut().zip(rgb) {
            counts[usize::from(value)] += 1;
        }
    }

    /// Mean relative luminance in [0, 1] behind `veil`; 0 without pixels.
    pub fn luminance(&self, veil: Veil) -> f32 {
        let pixels: u64 = self.counts[0].iter().map(|&count| u64::from(count)).sum();
        let mut sum = 0.0f64;
        for value in 0..=255u8 {
            let count = |channel: usize| f64::from(self.counts[channel][usize::from(value)]);
            let weighted = 0.2126 * count(0) + 0.7152 * count(1) + 0.0722 * count(2);
            sum += weighted * f64::from(self.linear[usize::from(veil.over(value))]);
        }
        (sum / pixels.max(1) as f64) as f32
    }
}

/// A film of black or white over the whole picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Veil {
    /// Nothing.
    #[default]
    Clear,
    /// Black of this opacity.
    Black(u8),
    /// White of this opacity.
    White(u8),
}

impl Veil {
    /// An sRGB-encoded value under the veil; blended on the encoded values, as windows do.
    pub fn over(self, value: u8) -> u8 {
        let mix = |opacity: u8, with: u32| {
            let opacity = u32::from(opacity);
            ((opacity * with + (255 - opacity) * u32::from(value) + 127) / 255) as u8
        };
        match self {
            Self::Clear => value,
            Self::Black(opacity) => mix(opacity, 0),
            Self::White(opacity) => mix(opacity, 255),
        }
    }
}

/// Keeps the pictures of a film or a window from flashing more than three times a second.
///
/// ```
/// use chladni_music::{FlashGuard, Histogram, Veil};
///
/// let (mut guard, mut picture) = (FlashGuard::default(), Histogram::default());
/// picture.add([0, 0, 0]);
/// assert_eq!(guard.veil(0.0, &picture), Veil::Clear);
/// // White a frame later is more than is let through at once.
/// picture.clear();
/// picture.add([255, 255, 255]);
/// assert!(matches!(guard.veil(1.0 / 60.0, &picture), Veil::Black(_)));
/// ```
#[derive(Clone, Debug, Default)]
pub struct FlashGuard {
    limiter: FlashLimiter,
}

impl FlashGuard {
    /// The thinnest veil with which the picture may be shown at `time_secs`, which must not fall
    /// from call to call. Allocates nothing.
    pub fn veil(&mut self, time_secs: f64, picture: &Histogram) -> Veil {
        let wanted = picture.luminance(Veil::Clear);
        let allowed = self.limiter.allowed(time_secs, wanted);
        let (mut veil, mut shown) = (Veil::Clear, wanted);
        if allowed != wanted {
            let kind = if allowed < wanted { Veil::Black } else { Veil::White };
            // The luminance falls or rises steadily with the opacity.
            let (mut thin, mut dense) = (0u8, 255u8);
            while thin < dense {
                let middle = thin + (dense - thin) / 2;
                let there = picture.luminance(kind(middle));
                let enough = if allowed < wanted { there <= allowed } else { there >= allowed };
                if enough { dense = middle } else { thin = middle + 1 }
            }
            veil = kind(dense);
            shown = picture.luminance(veil);
        }
        self.limiter.show(time_secs, shown);
        veil
    }

    /// Whether a change that no veil can soften, such as panels of the window appearing, may happen now. If
    /// so, it is counted as one of a flash's two changes.
    pub fn may_step(&mut self, time_secs: f64) -> bool {
        self.limiter.may_step(time_secs)
    }
}

/// The luminances that were shown, to count flashes afterwards.
#[derive(Clone, Debug, Default)]
pub struct FlashCount {
    times_secs: Vec<f64>,
    luminances: Vec<f32>,
}

impl FlashCount {
    /// Records the mean luminance shown at `time_secs`.
    pub fn note(&mut self, time_secs: f64, luminance: f32) {
        self.times_secs.push(time_secs);
        self.luminances.push(luminance);
    }

    /// Flashes in the worst second.
    pub fn most_per_second(&self) -> usize {
        most_flashes_per_second(&self.times_secs, &self.luminances)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn flat(value: u8) -> Histogram {
        let mut picture = Histogram::default();
        picture.add([value; 3]);
        picture
    }

    fn flashes(rate: f64, levels: &[u8], guarded: bool) -> (usize, Vec<f32>) {
        let (mut guard, mut count) = (FlashGuard::default(), FlashCount::default());
        for (i, &level) in levels.iter().enumerate() {
            let (time_secs, picture) = (i as f64 / rate, flat(level));
            let veil = if guarded { guard.veil(time_secs, &picture) } else { Veil::Clear };
            count.note(time_secs, picture.luminance(veil));
        }
        (count.most_per_second(), count.luminances)
    }

    #[test]
    fn veils_mix_as_a_window_does() {
        assert_eq!([Veil::Black(255), Veil::White(255), Veil::Clear].map(|veil| veil.over(77)), [0, 255, 77]);
        assert_eq!((Veil::Black(51).over(200), Veil::White(51).over(200)), (160, 211));
        assert!((flat(255).luminance(Veil::Black(0)) - 1.0).abs() < 1e-6);
        assert_eq!(Histogram::default().luminance(Veil::Clear), 0.0);
    }

    #[test]
    fn black_and_white_in_turn_are_tamed_and_what_is_slow_stays_clear() {
        let strobe: Vec<u8> = (0..180).map(|i| if i / 3 % 2 == 0 { 255 } else { 0 }).collect();
        assert!(flashes(30.0, &strobe, false).0 >= 4);
        assert!((1..=3).contains(&flashes(30.0, &strobe, true).0));
        let slow: Vec<u8> = (0..300).map(|i| (127.0 + 60.0 * (f64::from(i) * 0.05).sin()) as u8).collect();
        assert_eq!(flashes(30.0, &slow, true).1, flashes(30.0, &slow, false).1);
    }

    #[test]
    fn panels_may_come_and_go_five_times_a_second() {
        let mut guard = FlashGuard::default();
        let done = (0..40).filter(|i| guard.may_step(0.1 * f64::from(*i))).count();
        assert!((15..=20).contains(&done), "{done} of 40 in four seconds");
    }

    proptest! {
        #[test]
        fn no_row_of_pictures_flashes_more_than_three_times_a_second(
            levels in prop::collection::vec(any::<u8>(), 1..300), rate in 10.0f64..240.0)
        {
            prop_assert!(flashes(rate, &levels, true).0 <= crate::MAX_FLASHES);
        }
    }
}
