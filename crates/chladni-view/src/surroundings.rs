//! Users' own pictures around a scene: one behind it, and one that lights it from all sides.

use std::borrow::Cow;

use image::RgbaImage;

use crate::style::{brightness, decoded, encoded};
use crate::{Device, Picture, Skin, ViewError};

/// A picture behind all cells of a renderer, in place of the backgrounds' colors, and a panorama that lights their
/// figures, in place of sky, ground and softboxes.
#[derive(Clone, Debug, Default)]
pub struct Surroundings {
    /// With its width over its height.
    pub(crate) behind: Option<(Skin, f32)>,
    pub(crate) around: Option<Skin>,
}

impl Surroundings {
    /// The same light, with another picture behind.
    ///
    /// # Errors
    /// [`ViewError::Size`] for a picture without pixels.
    pub fn before(self, on: impl Into<Device>, behind: &Picture) -> Result<Self, ViewError> {
        let Self { behind, .. } = Self::new(on, Some(behind), None)?;
        Ok(Self { behind, ..self })
    }

    /// Uploads the given pictures. The picture behind fills a cell and is cropped to fit.
    ///
    /// # Errors
    /// [`ViewError::Size`] for a picture without pixels.
    pub fn new(
        on: impl Into<Device>,
        behind: Option<&Picture>,
        around: Option<&Panorama>,
    ) -> Result<Self, ViewError> {
        let device = on.into();
        let picture = |picture: &Picture| {
            let Picture { width, height, rgba } = picture;
            Skin::new(&device, *width, *height, rgba).map(|skin| (skin, *width as f32 / *height as f32))
        };
        let light = |panorama: &Panorama| Skin::of_levels(&device, panorama.levels.clone());
        Ok(Self { behind: behind.map(picture).transpose()?, around: around.map(light).transpose()? })
    }
}

/// Light from all directions, as surfaces of five roughnesses see it.
#[derive(Clone, Debug)]
pub struct Panorama {
    /// Each of half the size of the one before, light l as l / (1 + l).
    levels: Vec<RgbaImage>,
}

/// Texels around the sharpest level; it has half as many rows.
const AROUND: u32 = 256;
/// How narrow the lobes of the levels after the first are (Phong's exponent): of roughness ⅓, ⅔ and 1, and of chalk.
const LOBES: [f32; 4] = [19.0, 2.5, 1.0, 1.0];

/// Light is bounded by this many times the mean, so that a few pixels, as of the sun, do not outshine all others.
const BRIGHTEST: f32 = 2e4;

type Light = [f32; 3];

impl Panorama {
    /// The mean light that any panorama is scaled to, where eight bits have the most levels for light and dark.
    pub(crate) const MEAN: f32 = 0.5;

    /// Decodes a Radiance HDR, PNG or JPEG file that holds all directions, twice as wide as high (equirectangular, the middle
    /// in front of the viewer). Numbers of PNG and JPEG are sRGB.
    ///
    /// # Errors
    /// [`ViewError::Image`] where the bytes are no such image, or another format.
    pub fn decode(bytes: &[u8]) -> Result<Self, ViewError> {
        let (image, is_linear) = crate::picture::read(bytes)?;
        let (width, height) = (image.width(), image.height());
        if width != 2 * height {
            return Err(ViewError::Image(format!(
                "{width}×{height} pixels, where a panorama is twice as wide as high"
            )));
        }
        let mut image = image.into_rgb32f();
        for c in image.iter_mut() {
            let light = if is_linear { *c } else { decoded(*c) };
            // Sums stay finite.
            *c = if light > 0.0 { light.min(1e30) } else { 0.0 };
        }
        let pixels = Cow::Borrowed(image.as_raw().as_chunks::<3>().0);
        Ok(Self::of(&Sphere { width: width as usize, height: height as usize, pixels }))
    }

    fn of(sphere: &Sphere<'_>) -> Self {
        let around = AROUND as usize;
        let most = BRIGHTEST * sphere.shrunk(around, f32::INFINITY).mean();
        let mut sharp = sphere.shrunk(around, most);
        let mean = sharp.mean();
        if mean > 0.0 {
            for light in sharp.pixels.to_mut() {
                *light = light.map(|c| Self::MEAN * c / mean);
            }
        }
        let source = sharp.shrunk(64, f32::INFINITY);
        let rough = (1u32..).zip(LOBES).map(|(level, lobe)| source.blurred((AROUND >> level) as usize, lobe));
        let levels = [sharp.encoded()].into_iter().chain(rough.map(|level| level.encoded())).collect();
        Self { levels }
    }
}

/// Light by direction: longitude along a row, latitude from above.
struct Sphere<'a> {
    width: usize,
    height: usize,
    pixels: Cow<'a, [Light]>,
}

impl Sphere<'_> {
    /// Towards the middle of a texel: x right, y up, z to the viewer, who looks at the middle of the picture.
    fn direction(&self, x: usize, y: usize) -> [f32; 3] {
        use std::f32::consts::{PI, TAU};
        let (around, down) =
            ((x as f32 + 0.5) / self.width as f32 - 0.5, (y as f32 + 0.5) / self.height as f32);
        let ((sin, cos), flat) = ((TAU * around).sin_cos(), (PI * down).sin());
        [flat * sin, (PI * down).cos(), -flat * cos]
    }

    /// The solid angle of a texel in row `y`, up to a constant factor.
    fn share(&self, y: usize) -> f32 {
        (std::f32::consts::PI * (y as f32 + 0.5) / self.height as f32).sin()
    }

    fn texels(&self) -> impl Iterator<Item = (usize, usize, Light)> + '_ {
        self.pixels.iter().enumerate().map(|(i, light)| (i % self.width, i / self.width, *light))
    }

    fn mean(&self) -> f32 {
        let (sum, all) = self.texels().fold((0.0, 0.0), |(sum, all), (_, y, light)| {
            let share = self.share(y);
            (sum + share * brightness(light), all + share)
        });
        if all > 0.0 { sum / all } else { 0.0 }
    }

    /// With `width` texels around, each the mean of those that it covers, or the nearest one; none counts as brighter
    /// than `most`.
    fn shrunk(&self, width: usize, most: f32) -> Sphere<'static> {
        let height = width / 2;
        let span = |i: usize, count: usize, of: usize| {
            let first = i * of / count;
            first..((i + 1) * of / count).max(first + 1).min(of)
        };
        let texel = |i: usize| {
            let (columns, rows) = (span(i % width, width, self.width), span(i / width, height, self.height));
            let count = (columns.len() * rows.len()).max(1) as f32;
            let mut sum = [0.0; 3];
            for y in rows {
                for light in &self.pixels[y * self.width..][columns.clone()] {
                    (0..3).for_each(|k| sum[k] += light[k].min(most) / count);
                }
            }
            sum
        };
        Sphere { width, height, pixels: (0..width * height).map(texel).collect() }
    }

    /// The light from each direction, averaged over a lobe around it.
    fn blurred(&self, width: usize, lobe: f32) -> Sphere<'static> {
        use rayon::prelude::*;
        let mut level = Sphere { width, height: width / 2, pixels: Cow::Borrowed(&[]) };
        let from: Vec<([f32; 3], f32, Light)> =
            self.texels().map(|(x, y, light)| (self.direction(x, y), self.share(y), light)).collect();
        let texel = |i: usize| {
            let towards = level.direction(i % width, i / width);
            let (mut sum, mut all) = ([0.0; 3], 1e-9);
            for (direction, share, light) in &from {
                let near = (0..3).map(|k| towards[k] * direction[k]).sum::<f32>();
                if near > 0.0 {
                    let weight = share * near.powf(lobe);
                    (0..3).for_each(|k| sum[k] += weight * light[k]);
                    all += weight;
                }
            }
            sum.map(|c| c / all)
        };
        let pixels: Vec<Light> = (0..width * level.height).into_par_iter().map(texel).collect();
        level.pixels = pixels.into();
        level
    }

    fn encoded(&self) -> RgbaImage {
        let number = |light: f32| (255.0 * encoded(light / (1.0 + light)) + 0.5) as u8;
        RgbaImage::from_fn(self.width as u32, self.height as u32, |x, y| {
            let [r, g, b] = self.pixels[y as usize * self.width + x as usize].map(number);
            image::Rgba([r, g, b, 255])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_light_stays_even_and_rough_surfaces_see_half_of_the_sky() {
        let even = Sphere { width: 64, height: 32, pixels: vec![[0.5_f32; 3]; 64 * 32].into() };
        let panorama = Panorama::of(&even);
        let first = panorama.levels[0].get_pixel(0, 0).0;
        assert!(panorama.levels.iter().flat_map(|level| level.pixels()).all(|p| p.0 == first));
        let sizes: Vec<u32> = panorama.levels.iter().map(RgbaImage::width).collect();
        assert_eq!(sizes, [256, 128, 64, 32, 16]);
        // Bright above, dark below: chalk that looks aside sees half of it.
        let pixels = (0..64 * 32).map(|i| if i < 64 * 16 { [1.0; 3] } else { [0.0; 3] }).collect();
        let sky = Sphere { width: 64, height: 32, pixels };
        let chalk = sky.blurred(16, 1.0);
        let [above, aside, below] = [0, 3, 7].map(|y| chalk.pixels[y * 16][0]);
        assert!(above > 0.9 && below < 0.1, "{above} {below}");
        assert!((aside + chalk.pixels[4 * 16][0] - 1.0).abs() < 0.02);
    }

    #[test]
    fn a_panorama_looks_the_same_at_any_exposure() {
        let levels = |exposure: f32| {
            let light = |i: usize| [exposure * (0.1 + (i % 7) as f32); 3];
            let pixels: Vec<Light> = (0..64 * 32).map(light).collect();
            Panorama::of(&Sphere { width: 64, height: 32, pixels: pixels.into() }).levels
        };
        let usual = levels(1.0);
        assert!(usual == levels(1024.0) && usual == levels(1.0 / 1024.0));
        let black = Panorama::of(&Sphere { width: 2, height: 1, pixels: vec![[0.0_f32; 3]; 2].into() });
        assert!(black.levels.iter().flat_map(|level| level.pixels()).all(|p| p.0 == [0, 0, 0, 255]));
    }

    #[test]
    fn only_whole_spheres_are_panoramas() {
        let png = |width, height| Picture::filled(width, height, [90, 120, 200, 255]).to_png().unwrap();
        assert!(Panorama::decode(&png(64, 32)).is_ok());
        for bytes in [png(64, 64), b"no picture".to_vec(), Vec::new()] {
            assert!(matches!(Panorama::decode(&bytes), Err(ViewError::Image(_))));
        }
        let header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n";
        // Of each pixel three mantissas and an exponent: 1, 1, 1.
        let hdr = |exponent| [&header[..], &[128, 128, 128, exponent].repeat(8)].concat();
        let [ones, bright] = [129, 149].map(|exponent| Panorama::decode(&hdr(exponent)).unwrap());
        assert_eq!(ones.levels, bright.levels);
    }
}
