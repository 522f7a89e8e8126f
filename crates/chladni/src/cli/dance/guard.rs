//! The last look at a frame before it is encoded: no more than three flashes a second.

use chladni_music::{FlashLimiter, most_flashes_per_second};
use chladni_view::Picture;

/// Keeps the mean relative luminance of the frames within what is safe.
pub struct FlashGuard {
    limiter: Option<FlashLimiter>,
    linear: [f32; 256],
    times_secs: Vec<f64>,
    shown: Vec<f32>,
    damped: usize,
}

impl FlashGuard {
    /// A guard; one that is not `active` only watches.
    pub fn new(active: bool) -> Self {
        let linear = std::array::from_fn(|byte| {
            let c = byte as f32 / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        });
        let limiter = active.then(FlashLimiter::default);
        Self { limiter, linear, times_secs: Vec::new(), shown: Vec::new(), damped: 0 }
    }

    /// Looks at the frame of `time_secs` and brightens or darkens it where that is needed.
    pub fn pass(&mut self, time_secs: f64, picture: &mut Picture) {
        let luminance = self.mean_luminance(picture);
        let mut shown = luminance;
        if let Some(limiter) = &mut self.limiter {
            let allowed = limiter.limit(time_secs, luminance);
            if (allowed - luminance).abs() > 1e-4 {
                self.expose(picture, allowed / luminance.max(1e-4));
                shown = self.mean_luminance(picture);
                self.damped += 1;
            }
        }
        self.times_secs.push(time_secs);
        self.shown.push(shown);
    }

    /// How many frames were changed.
    pub fn damped_frames(&self) -> usize {
        self.damped
    }

    /// Flashes in the worst second of what was shown.
    pub fn most_flashes(&self) -> usize {
        most_flashes_per_second(&self.times_secs, &self.shown)
    }

    /// Relative luminance (WCAG), the mean of every 7th pixel.
    fn mean_luminance(&self, picture: &Picture) -> f32 {
        let mut sum = 0.0f64;
        let mut count = 0u32;
        for pixel in picture.rgba.chunks_exact(4).step_by(7) {
            let [r, g, b] = [pixel[0], pixel[1], pixel[2]].map(|byte| self.linear[usize::from(byte)]);
            sum += f64::from(0.2126 * r + 0.7152 * g + 0.0722 * b);
            count += 1;
        }
        (sum / f64::from(count.max(1))) as f32
    }

    /// Multiplies linear light by `gain`.
    fn expose(&self, picture: &mut Picture, gain: f32) {
        let table: [u8; 256] = std::array::from_fn(|byte| {
            let l = (self.linear[byte] * gain).clamp(0.0, 1.0);
            let c = if l <= 0.003_130_8 { 12.92 * l } else { 1.055 * l.powf(1.0 / 2.4) - 0.055 };
            (c * 255.0).round() as u8
        });
        for pixel in picture.rgba.chunks_exact_mut(4) {
            for channel in &mut pixel[..3] {
                *channel = table[usize::from(*channel)];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_strobe_of_pictures_is_tamed() {
        let mut watched = FlashGuard::new(false);
        let mut guarded = FlashGuard::new(true);
        for frame in 0..180 {
            let level = if frame / 3 % 2 == 0 { 255 } else { 10 };
            let strobe = || Picture::filled(16, 16, [level, level, level, 255]);
            watched.pass(f64::from(frame) / 30.0, &mut strobe());
            guarded.pass(f64::from(frame) / 30.0, &mut strobe());
        }
        assert!(watched.most_flashes() >= 4, "{}", watched.most_flashes());
        assert!(guarded.most_flashes() <= 3, "{}", guarded.most_flashes());
        assert!(guarded.damped_frames() > 0);
    }
}
