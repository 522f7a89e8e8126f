//! A finished picture, and the files it becomes.

use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder};

use crate::ViewError;

/// An image in memory: sRGB, straight alpha, rows from the top.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Picture {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// 4 · width · height bytes.
    pub rgba: Vec<u8>,
}

/// Whether nothing shines through any pixel, of four bytes each.
pub(crate) fn is_opaque(rgba: &[u8]) -> bool {
    // Piece by piece, without a branch for each pixel.
    let opaque =
        |piece: &[u8]| piece.as_chunks::<4>().0.iter().fold(255, |alpha, pixel| alpha & pixel[3]) == 255;
    rgba.chunks(4096).all(opaque)
}

impl Picture {
    /// Whether nothing shines through any pixel.
    pub fn is_opaque(&self) -> bool {
        is_opaque(&self.rgba)
    }

    /// The color of a pixel of straight alpha that is laid on black.
    pub fn on_black([r, g, b, alpha]: [u8; 4]) -> [u8; 3] {
        [r, g, b].map(|channel| ((u16::from(channel) * u16::from(alpha) + 127) / 255) as u8)
    }

    /// A picture of one color.
    pub fn filled(width: u32, height: u32, color: [u8; 4]) -> Self {
        Self { width, height, rgba: color.repeat(width as usize * height as usize) }
    }

    /// The pixel at (x, y); `None` outside.
    pub fn pixel(&self, x: u32, y: u32) -> Option<[u8; 4]> {
        if x >= self.width || y >= self.height {
            return None;
        }
        let at = 4 * (y as usize * self.width as usize + x as usize);
        self.rgba.get(at..at + 4)?.try_into().ok()
    }

    /// Lays `other` over this picture with its upper left corner at (x, y); what hangs over the
    /// edge is cut off.
    pub fn paste(&mut self, other: &Self, x: u32, y: u32) {
        self.blend(other, x, y, 1.0);
    }

    /// The same with an `opacity` in [0, 1], by which the alpha of `other` is multiplied.
    pub fn blend(&mut self, other: &Self, x: u32, y: u32, opacity: f32) {
        let columns = other.width.min(self.width.saturating_sub(x)) as usize;
        if columns == 0 {
            return;
        }
        for row in 0..other.height.min(self.height.saturating_sub(y)) {
            let from = 4 * (row as usize * other.width as usize);
            let to = 4 * ((y + row) as usize * self.width as usize + x as usize);
            let source = other.rgba[from..from + 4 * columns].as_chunks::<4>().0;
            let target = self.rgba[to..to + 4 * columns].as_chunks_mut::<4>().0;
            for (below, above) in target.iter_mut().zip(source) {
                let [r, g, b, alpha] = *above;
                *below = over([r, g, b, (f32::from(alpha) * opacity) as u8], *below);
            }
        }
    }

    /// Half the width and height, each pixel the mean of four; for pictures drawn at twice
    /// their size.
    pub fn halved(&self) -> Self {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let mut rgba = Vec::with_capacity(4 * width as usize * height as usize);
        for y in 0..height {
            for x in 0..width {
                let four = [(0, 0), (1, 0), (0, 1), (1, 1)]
                    .map(|(i, j)| {
                        self.pixel((2 * x + i).min(self.width - 1), (2 * y + j).min(self.height - 1))
                    })
                    .map(Option::unwrap_or_default);
                let alpha: u32 = four.iter().map(|p| u32::from(p[3])).sum();
                for channel in 0..3 {
                    let sum: u32 = four.iter().map(|p| u32::from(p[channel]) * u32::from(p[3])).sum();
                    rgba.push((sum + alpha / 2).checked_div(alpha).unwrap_or(0) as u8);
                }
                rgba.push(((alpha + 2) / 4) as u8);
            }
        }
        Self { width, height, rgba }
    }

    /// The whole picture, made smaller where it is wider or higher than `side` pixels.
    pub fn thumbnail(self, side: u32) -> Self {
        if self.width.max(self.height) <= side {
            return self;
        }
        let image = image::RgbaImage::from_raw(self.width, self.height, self.rgba);
        let Some(image) = image.map(|image| shrunk(image, side)) else { return Self::default() };
        Self { width: image.width(), height: image.height(), rgba: image.into_raw() }
    }

    /// Encodes as PNG; without an alpha channel where all is opaque.
    ///
    /// # Errors
    /// [`ViewError::Image`] where the sizes do not agree.
    pub fn to_png(&self) -> Result<Vec<u8>, ViewError> {
        let opaque = is_opaque(&self.rgba);
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width, self.height);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_color(if opaque { png::ColorType::Rgb } else { png::ColorType::Rgba });
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        // A few percent larger than the tightest, in a tenth of the time: neighbors in a row predict both smooth
        // shading and the background's dither.
        encoder.set_filter(png::Filter::Sub);
        encoder.set_deflate_compression(png::DeflateCompression::Level(3));
        let mut writer = encoder.write_header().map_err(ViewError::image)?;
        if opaque {
            let rgb: Vec<u8> =
                self.rgba.as_chunks::<4>().0.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
            writer.write_image_data(&rgb).map_err(ViewError::image)?;
        } else {
            writer.write_image_data(&self.rgba).map_err(ViewError::image)?;
        }
        writer.finish().map_err(ViewError::image)?;
        Ok(bytes)
    }

    /// Width and height of a PNG or JPEG file, 64 megapixels at most, which is not decoded.
    ///
    /// # Errors
    /// [`ViewError::Image`] where the bytes do not begin such an image.
    pub fn size_of(bytes: &[u8]) -> Result<[u32; 2], ViewError> {
        let (width, height) = open(bytes)?.into_dimensions().map_err(ViewError::image)?;
        // The decoder's limit counts the bytes of the file's own colors; four channels of a gray picture take more.
        if u64::from(width) * u64::from(height) > MOST_PIXELS {
            return Err(ViewError::Image(format!("{width} × {height} pixels are more than 64 megapixels")));
        }
        Ok([width, height])
    }

    /// Decodes a PNG or JPEG file, 64 megapixels at most, its rows as they are stored.
    ///
    /// # Errors
    /// [`ViewError::Image`] where the bytes are no such image.
    pub fn decode(bytes: &[u8]) -> Result<Self, ViewError> {
        Ok(Self::of(stored(bytes)?.0))
    }

    /// The same, rotated to stand as the camera was held (the orientation of EXIF).
    ///
    /// # Errors
    /// As those of [`decode`](Self::decode).
    pub fn decode_upright(bytes: &[u8]) -> Result<Self, ViewError> {
        let (mut image, orientation) = stored(bytes)?;
        image.apply_orientation(orientation);
        Ok(Self::of(image))
    }

    fn of(image: DynamicImage) -> Self {
        let image = image.into_rgba8();
        Self { width: image.width(), height: image.height(), rgba: image.into_raw() }
    }
}

/// A picture as it is stored, in eight bits a channel, and how it is to be rotated.
fn stored(bytes: &[u8]) -> Result<(DynamicImage, Orientation), ViewError> {
    let (mut decoder, is_linear) = begun(bytes)?;
    if is_linear {
        return Err(ViewError::Image("a picture is a PNG or a JPEG".into()));
    }
    let orientation = decoder.orientation().map_err(ViewError::image)?;
    let image = DynamicImage::from_decoder(decoder).map_err(ViewError::image)?;
    Ok((DynamicImage::ImageRgba8(image.into_rgba8()), orientation))
}

/// `image`, made smaller where it is wider or higher than `side` pixels.
pub(crate) fn shrunk(image: image::RgbaImage, side: u32) -> image::RgbaImage {
    let (width, height) = image.dimensions();
    let largest = width.max(height);
    if largest <= side {
        return image;
    }
    let shrunk = |length: u32| {
        u32::try_from(u64::from(length) * u64::from(side) / u64::from(largest)).unwrap_or(side).max(1)
    };
    image::imageops::thumbnail(&image, shrunk(width), shrunk(height))
}

/// The largest picture that is decoded, in pixels.
const MOST_PIXELS: u64 = 64 << 20;

type Reader<'a> = image::ImageReader<std::io::Cursor<&'a [u8]>>;

fn open(bytes: &[u8]) -> Result<Reader<'_>, ViewError> {
    image::ImageReader::new(std::io::Cursor::new(bytes)).with_guessed_format().map_err(ViewError::image)
}

/// A PNG, JPEG or Radiance HDR file of 64 megapixels at most, and whether its numbers are linear light.
pub(crate) fn read(bytes: &[u8]) -> Result<(DynamicImage, bool), ViewError> {
    let (decoder, is_linear) = begun(bytes)?;
    Ok((DynamicImage::from_decoder(decoder).map_err(ViewError::image)?, is_linear))
}

/// The same before its pixels are decoded.
fn begun(bytes: &[u8]) -> Result<(impl ImageDecoder, bool), ViewError> {
    Picture::size_of(bytes)?;
    let mut reader = open(bytes)?;
    let is_linear = reader.format() == Some(image::ImageFormat::Hdr);
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(16_384);
    limits.max_image_height = Some(16_384);
    // Three floating-point numbers a pixel, or four bytes.
    limits.max_alloc = Some(MOST_PIXELS * if is_linear { 12 } else { 4 });
    reader.limits(limits.clone());
    let decoder = reader.into_decoder().map_err(ViewError::image)?;
    limits.reserve(decoder.total_bytes()).map_err(ViewError::image)?;
    Ok((decoder, is_linear))
}

/// Porter & Duff's "over" on straight alpha.
fn over(above: [u8; 4], below: [u8; 4]) -> [u8; 4] {
    let (a, b) = (u32::from(above[3]), u32::from(below[3]));
    let alpha = a * 255 + b * (255 - a);
    if alpha == 0 {
        return [0; 4];
    }
    let mix = |i: usize| {
        let sum = u32::from(above[i]) * a * 255 + u32::from(below[i]) * b * (255 - a);
        ((sum + alpha / 2) / alpha) as u8
    };
    [mix(0), mix(1), mix(2), ((alpha + 127) / 255) as u8]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Panorama;

    /// The beginning of a gray PNG.
    fn gray(width: u32, height: u32) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(png::ColorType::Grayscale);
        let mut writer = encoder.write_header().unwrap();
        writer.write_chunk(png::chunk::IDAT, &[]).unwrap();
        drop(writer);
        bytes
    }

    #[test]
    fn a_picture_of_more_than_64_megapixels_is_refused_before_it_takes_memory() {
        for (size, too_large) in [([16_384, 16_384], true), ([8192, 8193], true), ([8192, 8192], false)] {
            let bytes = gray(size[0], size[1]);
            for error in [Picture::decode(&bytes).map(drop), Panorama::decode(&bytes).map(drop)] {
                // The allowed one has no pixels.
                let error = error.unwrap_err().to_string();
                assert_eq!(error.contains("64 megapixels"), too_large, "{size:?}: {error}");
            }
        }
        // A panorama of 8K is small enough, but ends here.
        let large = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4096 +X 8192\n";
        let error = Panorama::decode(large).unwrap_err().to_string();
        assert!(!error.contains("limit"), "{error}");
    }

    #[test]
    fn a_picture_beyond_the_edge_is_cut_off() {
        let (white, red) = (Picture::filled(2, 2, [255; 4]), Picture::filled(2, 2, [255, 0, 0, 255]));
        for (x, y) in [(2, 0), (3, 1), (7, 0), (0, 2), (0, 7)] {
            let mut picture = white.clone();
            picture.paste(&red, x, y);
            assert_eq!(picture, white, "{x}, {y}");
        }
        let mut picture = white.clone();
        picture.paste(&red, 1, 1);
        assert_eq!(picture.pixel(1, 1), red.pixel(0, 0));
        assert_eq!(picture.pixel(0, 1), white.pixel(0, 0));
    }

    #[test]
    fn photos_stand_as_the_camera_was_held() {
        // Entry 0x112 (orientation) of a big-endian TIFF: the first row is on the right.
        let exif = b"MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0";
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(png::ColorType::Grayscale);
        let mut writer = encoder.write_header().unwrap();
        writer.write_chunk(png::chunk::eXIf, exif).unwrap();
        writer.write_image_data(&[10, 200]).unwrap();
        writer.finish().unwrap();
        let reds = |picture: &Picture| picture.rgba.iter().step_by(4).copied().collect::<Vec<_>>();
        let (stored, upright) = (Picture::decode(&bytes).unwrap(), Picture::decode_upright(&bytes).unwrap());
        assert_eq!((stored.width, stored.height, reds(&stored)), (2, 1, vec![10, 200]));
        assert_eq!((upright.width, upright.height, reds(&upright)), (1, 2, vec![10, 200]));
    }
}
