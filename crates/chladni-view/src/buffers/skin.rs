//! Images on surfaces, where they are drawn.

use std::sync::Arc;

use super::{Held, Pyramid};
use crate::gpu;
use crate::picture::shrunk;
use crate::{Device, ViewError};

/// An image to wrap around a shape.
#[derive(Clone, Debug)]
pub struct Skin {
    pub(crate) held: Held<Arc<Pyramid>, gpu::Image>,
}

impl Skin {
    /// Takes `width` × `height` sRGB pixels, the first row at the top (v = 1), and makes its mipmaps. An image whose sides
    /// are too long for the device is made smaller.
    ///
    /// # Errors
    /// [`ViewError::Size`] where a side is 0, [`ViewError::Shape`] where the bytes are not 4 · width · height.
    pub fn new(on: impl Into<Device>, width: u32, height: u32, rgba: &[u8]) -> Result<Self, ViewError> {
        let device = on.into();
        let limit = device.longest_side();
        if width == 0 || height == 0 {
            return Err(ViewError::Size { width, height, limit });
        }
        let picture = image::RgbaImage::from_raw(width, height, rgba.to_vec()).ok_or_else(|| {
            ViewError::Shape(format!("{} bytes for an image of {width}×{height}", rgba.len()))
        })?;
        let picture = shrunk(picture, limit);
        let (width, height) = picture.dimensions();
        let levels = u32::BITS - width.max(height).leading_zeros();
        // Each is made from the one before; made from the whole picture, every level would cost as much as
        // the first.
        let half = |level: &image::RgbaImage| {
            let [w, h] = [level.width(), level.height()].map(|side| (side / 2).max(1));
            Some(image::imageops::thumbnail(level, w, h))
        };
        let levels = std::iter::successors(Some(picture), half).take(levels as usize).collect();
        Self::of_levels(&device, levels)
    }

    /// A skin of levels, each half the size of the one before.
    pub(crate) fn of_levels(device: &Device, levels: Vec<image::RgbaImage>) -> Result<Self, ViewError> {
        let Some((width, height)) = levels.first().map(image::RgbaImage::dimensions) else {
            return Err(ViewError::Shape("an image without levels".into()));
        };
        let held = match device {
            Device::Processor => Held::Cpu(Arc::new(Pyramid::new(levels.into_iter()))),
            Device::Graphics(gpu) => {
                let size = [width, height, levels.len() as u32];
                let pyramid: Vec<u8> = levels.into_iter().flat_map(image::RgbaImage::into_raw).collect();
                Held::Gpu(gpu::image(gpu, "skin", size, &pyramid))
            }
        };
        Ok(Self { held })
    }
}
