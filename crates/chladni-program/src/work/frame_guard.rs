//! The last check of a frame before it is encoded: no more than three flashes a second, and no bright stripes for long.

use chladni_music::{FlashArea, FlashCount, FlashGuard, Histogram, Veil};
use chladni_view::Picture;

/// The approximate number of pixels of a frame that are examined.
const PIXELS: usize = 100_000;

/// Keeps flashes and stripes of the frames within safe limits.
pub struct FrameGuard {
    guard: Option<FlashGuard>,
    histogram: Histogram,
    shown: FlashCount,
    damped: usize,
}

impl FrameGuard {
    /// A guard of an area; without one it only watches.
    pub fn new(area: Option<FlashArea>) -> Self {
        let guard = area.map(|area| {
            let mut guard = FlashGuard::default();
            guard.set_area(area);
            guard
        });
        let shown = FlashCount::of(area.unwrap_or_default());
        Self { guard, histogram: Histogram::default(), shown, damped: 0 }
    }

    /// Guards another area from now on.
    pub fn set_area(&mut self, area: FlashArea) {
        self.guard.iter_mut().for_each(|guard| guard.set_area(area));
    }

    /// Looks at the frame of `time_secs`, of straight alpha, and veils it where it would flash.
    pub fn pass(&mut self, time_secs: f64, picture: &mut Picture) {
        let veil = self.judge(time_secs, picture.rgba.as_chunks().0, [picture.width, picture.height]);
        lay(veil, picture);
    }

    /// Judges the frame of `time_secs` by some of its pixels (by all, if it is small), over black where they are
    /// translucent; returns the veil that it needs.
    pub fn judge(&mut self, time_secs: f64, pixels: &[[u8; 4]], size: [u32; 2]) -> Veil {
        self.histogram.clear();
        let step = step(pixels.len(), size[0] as usize);
        let [mut column, mut row] = [0, 0];
        for pixel in pixels.iter().step_by(step) {
            self.histogram.add([column, row], size, Picture::on_black(*pixel));
            // Cheaper than a division for each.
            column += step as u32;
            while column >= size[0].max(1) {
                (column, row) = (column - size[0].max(1), row + 1);
            }
        }
        let veil = match &mut self.guard {
            Some(guard) => guard.veil(time_secs, &self.histogram),
            None => Veil::Clear,
        };
        self.damped += usize::from(veil != Veil::Clear);
        self.shown.note(time_secs, &self.histogram, veil);
        veil
    }

    /// How many frames were changed.
    pub fn damped_frames(&self) -> usize {
        self.damped
    }

    /// Flashes in the worst second shown.
    pub fn most_flashes(&self) -> usize {
        self.shown.most_per_second()
    }

    /// The longest time for which bright stripes were shown.
    pub fn longest_stripes_secs(&self) -> f64 {
        self.shown.longest_stripes_secs()
    }
}

/// Lays a veil over a picture.
fn lay(veil: Veil, picture: &mut Picture) {
    match veil {
        Veil::Clear => {}
        // It is seen where the picture is transparent, too.
        Veil::White(opacity) if !picture.is_opaque() => {
            let white = Picture::filled(picture.width, picture.height, [255, 255, 255, opacity]);
            picture.blend(&white, 0, 0, 1.0);
        }
        Veil::Black(_) | Veil::White(_) => {
            let table: [u8; 256] = std::array::from_fn(|value| veil.over(value as u8));
            for pixel in picture.rgba.as_chunks_mut::<4>().0 {
                for channel in &mut pixel[..3] {
                    *channel = table[usize::from(*channel)];
                }
            }
        }
    }
}

/// Step between examined pixels, coprime to the width, so that they do not line up in columns.
fn step(pixels: usize, width: usize) -> usize {
    let coprime = |step: &usize| {
        let (mut a, mut b) = (*step, width);
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a == 1
    };
    ((pixels / PIXELS).max(1)..).find(coprime).unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_column_is_looked_at() {
        for (width, height) in [(1440, 1080), (1920, 1080), (3840, 2160), (1001, 999), (16, 16), (1, 500_000)]
        {
            let (pixels, step) = (width * height, step(width * height, width));
            let mut seen = vec![false; width];
            (0..pixels).step_by(step).for_each(|i| seen[i % width] = true);
            assert!(seen.iter().all(|seen| *seen), "{width}×{height}, each {step}");
            assert!(pixels / step >= PIXELS.min(pixels) / 2);
        }
    }

    #[test]
    fn a_strobe_of_pictures_is_tamed_down_to_black() {
        for dark in [10, 0] {
            let mut watched = FrameGuard::new(None);
            let mut guarded = FrameGuard::new(Some(FlashArea::Screen));
            let mut seen = FrameGuard::new(None);
            for frame in 0..180 {
                let level = if frame / 3 % 2 == 0 { 255 } else { dark };
                let strobe = || Picture::filled(16, 16, [level, level, level, 255]);
                let (time_secs, mut shown) = (f64::from(frame) / 30.0, strobe());
                watched.pass(time_secs, &mut strobe());
                guarded.pass(time_secs, &mut shown);
                seen.pass(time_secs, &mut shown);
            }
            assert!(watched.most_flashes() >= 4, "{}", watched.most_flashes());
            assert!(guarded.most_flashes() <= 3, "{}", guarded.most_flashes());
            assert_eq!(seen.most_flashes(), guarded.most_flashes());
            assert!(guarded.damped_frames() > 0);
        }
    }

    #[test]
    fn translucent_pictures_are_judged_by_the_light_that_they_bring() {
        let frames = |shades: [[u8; 4]; 2]| {
            let mut watched = FrameGuard::new(None);
            let mut guarded = FrameGuard::new(Some(FlashArea::Screen));
            let mut seen = FrameGuard::new(None);
            for frame in 0..120 {
                let strobe = || Picture::filled(16, 16, shades[frame / 3 % 2]);
                let (time_secs, mut shown) = (frame as f64 / 30.0, strobe());
                watched.pass(time_secs, &mut strobe());
                guarded.pass(time_secs, &mut shown);
                seen.pass(time_secs, &mut shown);
            }
            assert_eq!(seen.most_flashes(), guarded.most_flashes());
            [watched.most_flashes(), guarded.most_flashes(), guarded.damped_frames()]
        };
        // A faint glow is no flash, however white it is by itself.
        assert_eq!(frames([[255, 255, 255, 2], [0; 4]]), [0; 3]);
        // White that comes and goes is one, though its color stays.
        let [watched, guarded, damped] = frames([[255; 4], [255, 255, 255, 0]]);
        assert!(watched >= 4 && guarded <= 3 && damped > 0, "{watched} {guarded} {damped}");
    }

    #[test]
    fn a_white_veil_changes_opaque_pixels_alike_in_any_picture_and_is_seen_in_transparent_ones() {
        let shades = (0..=255_u8).flat_map(|shade| [shade, shade, shade, 255]);
        for opacity in [1, 100, 255] {
            let mut opaque = Picture { width: 256, height: 1, rgba: shades.clone().collect() };
            let rgba = shades.clone().chain([0; 4]).collect();
            let mut with_hole = Picture { width: 257, height: 1, rgba };
            lay(Veil::White(opacity), &mut opaque);
            lay(Veil::White(opacity), &mut with_hole);
            assert_eq!(opaque.rgba, with_hole.rgba[..1024]);
            assert_eq!(with_hole.rgba[1024..], [255, 255, 255, opacity]);
        }
    }

    #[test]
    fn stripes_of_pictures_are_darkened_soon() {
        let bars = || {
            let mut picture = Picture::filled(640, 360, [0, 0, 0, 255]);
            for (i, pixel) in picture.rgba.as_chunks_mut::<4>().0.iter_mut().enumerate() {
                if (i % 640 + i / 640) % 24 < 12 {
                    *pixel = [250, 240, 230, 255];
                }
            }
            picture
        };
        let shown = |area| {
            let mut guard = FrameGuard::new(area);
            (0..60).for_each(|frame| guard.pass(f64::from(frame) / 30.0, &mut bars()));
            guard.longest_stripes_secs()
        };
        assert!(shown(None) > 1.9 && shown(Some(FlashArea::Screen)) < 0.5);
    }
}
