//! An image around a shape, at all its sizes, sampled as a graphics device does.

use image::RgbaImage;

use crate::style::LINEAR;

/// Levels of an image, the largest first, in linear light.
#[derive(Debug)]
pub(crate) struct Pyramid {
    levels: Vec<RgbaImage>,
    /// [`LINEAR`], at hand.
    linear: &'static [f32; 256],
}

/// The most samples along the longer side of a pixel's footprint.
const ANISOTROPY: f32 = 4.0;

impl Pyramid {
    pub(crate) fn new(levels: impl Iterator<Item = RgbaImage>) -> Self {
        Self { levels: levels.collect(), linear: &LINEAR }
    }

    /// Linear light at `uv`, v down, where a step to the right changes it by `right` and one down by
    /// `down`. The image repeats.
    pub(crate) fn sample(&self, uv: [f32; 2], right: [f32; 2], down: [f32; 2]) -> [f32; 3] {
        self.filtered(uv, (right, down), ANISOTROPY, Self::bilinear)
    }

    /// The same of an image that ends at its edges, with one sample: graphics devices draw it so, too.
    pub(crate) fn sample_within(&self, uv: [f32; 2], right: [f32; 2], down: [f32; 2]) -> [f32; 3] {
        self.filtered(uv, (right, down), 1.0, Self::bilinear_within)
    }

    #[inline]
    fn filtered(
        &self,
        uv: [f32; 2],
        (right, down): ([f32; 2], [f32; 2]),
        most: f32,
        bilinear: impl Fn(&Self, usize, [f32; 2]) -> [f32; 3],
    ) -> [f32; 3] {
        let Some(first) = self.levels.first() else { return [0.0; 3] };
        let (width, height) = (first.width() as f32, first.height() as f32);
        let texels = |[u, v]: [f32; 2]| (u * width).hypot(v * height);
        let (a, b) = (texels(right), texels(down));
        let (long, short, along) = if a > b { (a, b, right) } else { (b, a, down) };
        // Rounding alone makes no side longer.
        let count = (long / short.max(1e-6) - 1e-3).ceil().clamp(1.0, most);
        let level = (long / count).max(1e-6).log2().clamp(0.0, (self.levels.len() - 1) as f32);
        let mut sum = [0.0; 3];
        for i in 0..count as u32 {
            let step = (i as f32 + 0.5) / count - 0.5;
            let at = [uv[0] + along[0] * step, uv[1] + along[1] * step];
            let (low, share) = (level.floor(), level.fract());
            let near = bilinear(self, low as usize, at);
            let far = if share > 0.0 { bilinear(self, low as usize + 1, at) } else { near };
            for k in 0..3 {
                sum[k] += (near[k] * (1.0 - share) + far[k] * share) / count;
            }
        }
        sum
    }

    /// Linear light at `uv` of a level between two. The image repeats to the sides, not up and down.
    pub(crate) fn level(&self, [u, v]: [f32; 2], level: f32) -> [f32; 3] {
        let (low, share) = (level.max(0.0) as usize, level.max(0.0).fract());
        let at = |level: usize| {
            let rows = self.levels.get(level).or(self.levels.last()).map_or(1, RgbaImage::height) as f32;
            self.bilinear(level, [u, v.clamp(0.5 / rows, 1.0 - 0.5 / rows)])
        };
        if self.levels.is_empty() {
            return [0.0; 3];
        }
        let (near, far) = (at(low), if share > 0.0 { at(low + 1) } else { [0.0; 3] });
        std::array::from_fn(|k| near[k] * (1.0 - share) + far[k] * share)
    }

    fn bilinear_within(&self, level: usize, [u, v]: [f32; 2]) -> [f32; 3] {
        let image = &self.levels[level.min(self.levels.len() - 1)];
        let within = |x: f32, texels: u32| x.clamp(0.5 / texels as f32, 1.0 - 0.5 / texels as f32);
        self.bilinear(level, [within(u, image.width()), within(v, image.height())])
    }

    fn bilinear(&self, level: usize, [u, v]: [f32; 2]) -> [f32; 3] {
        let image = &self.levels[level.min(self.levels.len() - 1)];
        let (width, height) = (i64::from(image.width()), i64::from(image.height()));
        let (x, y) = (u * width as f32 - 0.5, v * height as f32 - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (fx, fy) = (x - left, y - top);
        let texel = |dx: i64, dy: i64| {
            let x = (left as i64).saturating_add(dx).rem_euclid(width);
            let y = (top as i64).saturating_add(dy).rem_euclid(height);
            let [r, g, b, _] = image.get_pixel(x as u32, y as u32).0;
            [r, g, b].map(|c| self.linear[usize::from(c)])
        };
        let [a, b, c, d] = [texel(0, 0), texel(1, 0), texel(0, 1), texel(1, 1)];
        std::array::from_fn(|k| {
            let (above, below) = (a[k] * (1.0 - fx) + b[k] * fx, c[k] * (1.0 - fx) + d[k] * fx);
            above * (1.0 - fy) + below * fy
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_makes_no_pixel_longer_and_an_image_that_ends_has_one_sample() {
        let image =
            RgbaImage::from_fn(4, 4, |x, _| image::Rgba([if x % 2 == 0 { 255 } else { 0 }, 0, 0, 255]));
        let levels = [image.clone(), image::imageops::thumbnail(&image, 2, 2)];
        let pyramid = Pyramid::new(levels.into_iter());
        let (at, right) = ([0.375, 0.5], [0.5, 0.0]);
        let [even, rounded, long] = [0.5, 0.499_999_9, 0.25].map(|step| [0.0, step]);
        assert_eq!(pyramid.sample(at, right, rounded), pyramid.sample(at, right, even));
        assert_ne!(pyramid.sample(at, right, long), pyramid.sample(at, right, even));
        for down in [rounded, long] {
            assert_eq!(pyramid.sample_within(at, right, down), pyramid.sample_within(at, right, even));
        }
    }

    #[test]
    fn an_image_repeats_and_its_middle_is_its_mean_from_far_away() {
        let image = RgbaImage::from_fn(4, 4, |x, _| image::Rgba([if x < 2 { 255 } else { 0 }, 0, 0, 255]));
        let levels = [
            image.clone(),
            image::imageops::thumbnail(&image, 2, 2),
            image::imageops::thumbnail(&image, 1, 1),
        ];
        let pyramid = Pyramid::new(levels.into_iter());
        let near = |u| pyramid.sample([u, 0.5], [1e-4, 0.0], [0.0, 1e-4])[0];
        assert!((near(0.25) - 1.0).abs() < 1e-6 && near(0.75).abs() < 1e-6 && (near(0.5) - 0.5).abs() < 1e-6);
        assert!((near(-3.75) - 1.0).abs() < 1e-4);
        let edges = [0.0, 1.0].map(|u| pyramid.sample_within([u, 0.5], [1e-4, 0.0], [0.0, 1e-4])[0]);
        assert!((near(0.0) - 0.5).abs() < 1e-6 && edges == [1.0, 0.0], "{edges:?}");
        let far = pyramid.sample([0.25, 0.5], [3.0, 0.0], [0.0, 3.0])[0];
        assert!((0.1..0.6).contains(&far), "{far}");
        assert_eq!(pyramid.sample([f32::NAN; 2], [0.0; 2], [0.0; 2]).len(), 3);
    }
}
