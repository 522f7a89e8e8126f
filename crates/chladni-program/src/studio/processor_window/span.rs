//! A run of pixels in one row, filled with a color, a blend of colors, or a texture.

use egui::{Color32, ColorImage};

/// The fill of a triangle.
pub enum Ink {
    /// One color: 0xAARRGGBB.
    Flat(u32),
    /// Colors that change from corner to corner: red, green, blue, alpha.
    Shaded([Gradient; 4]),
    /// A texture, in its own colors or times one.
    Textured { across: Gradient, down: Gradient, reading: Reading, tint: Option<[u8; 4]> },
    /// A texture times colors that change.
    Both { across: Gradient, down: Gradient, reading: Reading, colors: [Gradient; 4] },
}

/// The texels of a triangle.
pub enum Texels {
    /// The same everywhere.
    One([u8; 4]),
    /// Where in it, in texels.
    Many { across: Gradient, down: Gradient, linear: bool },
}

/// How texels are read.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Reading {
    /// Each pixel shows the texel that lies on it.
    Aligned,
    /// Filtered; rows of the texture are rows of the picture, not much smaller than it.
    Upright,
    Nearest,
    Linear,
}

/// A number that changes evenly over the picture.
#[derive(Clone, Copy)]
pub struct Gradient {
    /// From column to column.
    pub x: f32,
    /// From row to row.
    pub y: f32,
    /// In the middle of the first pixel of the first row.
    pub at: f32,
}

impl Gradient {
    fn of(&self, x: f32, y: f32) -> f32 {
        self.at + self.x * x + self.y * y
    }
}

/// Where a run begins.
pub struct Span {
    pub x: f32,
    pub y: f32,
}

impl Ink {
    /// The ink of one color or four gradients, times texels.
    pub fn new(color: Result<[u8; 4], [Gradient; 4]>, texels: Texels) -> Self {
        match (color, texels) {
            (Ok(color), Texels::One(texel)) => Self::Flat(pixel(times(color, texel))),
            (Err(colors), Texels::One(texel)) => {
                let mut colors = colors;
                for (gradient, texel) in colors.iter_mut().zip(texel) {
                    let share = f32::from(texel) / 255.0;
                    let Gradient { x, y, at } = *gradient;
                    *gradient = Gradient { x: share * x, y: share * y, at: share * at };
                }
                Self::Shaded(colors)
            }
            (Ok(tint), Texels::Many { across, down, linear }) => {
                let tint = Some(tint).filter(|tint| *tint != [255; 4]);
                Self::Textured { across, down, reading: Reading::of(&across, &down, linear), tint }
            }
            (Err(colors), Texels::Many { across, down, linear }) => {
                Self::Both { across, down, reading: Reading::of(&across, &down, linear), colors }
            }
        }
    }

    /// Paints over `pixels`, which begin at `from`.
    pub fn paint(&self, image: &ColorImage, from: Span, pixels: &mut [u32]) {
        match self {
            Self::Flat(color) if color >> 24 == 255 => pixels.fill(*color),
            Self::Flat(color) => pixels.iter_mut().for_each(|below| *below = over(*color, *below)),
            Self::Shaded(colors) => {
                for (below, x) in pixels.iter_mut().zip(0..) {
                    *below = over(pixel(shade(colors, &from, x)), *below);
                }
            }
            Self::Textured { across, down, reading: Reading::Aligned, tint: None } => {
                copy(row(image, across, down, &from, pixels.len()), pixels);
            }
            Self::Textured { across, down, reading: Reading::Upright, tint } => {
                stretch(image, across, down, &from, *tint, pixels);
            }
            Self::Textured { across, down, reading, tint } => {
                let tint = tint.unwrap_or([255; 4]);
                for (below, x) in pixels.iter_mut().zip(0..) {
                    let texel = reading.texel(image, across, down, &from, x);
                    *below = over(pixel(times(texel, tint)), *below);
                }
            }
            Self::Both { across, down, reading, colors } => {
                for (below, x) in pixels.iter_mut().zip(0..) {
                    let texel = reading.texel(image, across, down, &from, x);
                    *below = over(pixel(times(texel, shade(colors, &from, x))), *below);
                }
            }
        }
    }
}

impl Reading {
    /// A texture that lies on the pixels as it is needs no filter.
    fn of(across: &Gradient, down: &Gradient, linear: bool) -> Self {
        let near = |a: f32, b: f32| (a - b).abs() < 1e-3;
        let is_whole = |at: f32| near(at.rem_euclid(1.0), 0.5);
        // Over the widest window this moves nothing by a tenth of a texel.
        let is_upright = across.y.abs() < 1e-5 && down.x.abs() < 1e-5;
        let is_equal = near(across.x, 1.0) && near(down.y, 1.0);
        match (linear, is_upright) {
            (_, true) if is_equal && is_whole(across.at) && is_whole(down.at) => Self::Aligned,
            (true, true) if (0.0..=2.0).contains(&across.x) => Self::Upright,
            (true, _) => Self::Linear,
            (false, _) => Self::Nearest,
        }
    }

    fn texel(
        self,
        image: &ColorImage,
        across: &Gradient,
        down: &Gradient,
        from: &Span,
        column: u16,
    ) -> [u8; 4] {
        let x = from.x + f32::from(column);
        let (u, v) = (across.of(x, from.y), down.of(x, from.y));
        let at = |x: i32, y: i32| {
            let [width, height] = image.size;
            let x = (x.max(0) as usize).min(width.saturating_sub(1));
            let y = (y.max(0) as usize).min(height.saturating_sub(1));
            image.pixels.get(y * width + x).map_or([0; 4], Color32::to_array)
        };
        if matches!(self, Self::Aligned | Self::Nearest) {
            return at(u.floor() as i32, v.floor() as i32);
        }
        let (u, v) = (u - 0.5, v - 0.5);
        let (x, y) = (u.floor(), v.floor());
        let [right, lower] = [u - x, v - y].map(|share| (share * 256.0) as u32);
        let (x, y) = (x as i32, y as i32);
        let corners = [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)];
        std::array::from_fn(|channel| {
            let [a, b, c, d] = corners.map(|corner| u32::from(corner[channel]));
            let (top, bottom) = (a * (256 - right) + b * right, c * (256 - right) + d * right);
            ((top * (256 - lower) + bottom * lower + (1 << 15)) >> 16) as u8
        })
    }
}

/// The texels that lie on a run of `length` pixels.
fn row<'a>(
    image: &'a ColorImage,
    across: &Gradient,
    down: &Gradient,
    from: &Span,
    length: usize,
) -> &'a [Color32] {
    let (x, y) = (across.of(from.x, from.y).max(0.0) as usize, down.of(from.x, from.y).max(0.0) as usize);
    let first = y * image.size[0] + x;
    image.pixels.get(first..first + length).unwrap_or_default()
}

/// A texture that is larger or smaller than the pixels, filtered between two of its rows.
fn stretch(
    image: &ColorImage,
    across: &Gradient,
    down: &Gradient,
    from: &Span,
    tint: Option<[u8; 4]>,
    pixels: &mut [u32],
) {
    const ONE: f64 = 65536.0;
    const RUN: usize = 64;
    let [width, height] = image.size;
    let v = down.of(from.x, from.y) - 0.5;
    let row = |y: f32| {
        let y = (y.max(0.0) as usize).min(height.saturating_sub(1));
        image.pixels.get(y * width..(y + 1) * width).unwrap_or_default()
    };
    let (upper, lower) = (row(v.floor()), row(v.floor() + 1.0));
    let Some(last) = upper.len().min(lower.len()).checked_sub(1) else { return };
    let down = ((v - v.floor()) * 256.0) as u32;
    let mut u = ((f64::from(across.of(from.x, from.y)) - 0.5) * ONE) as i64;
    let step = (f64::from(across.x) * ONE).round() as i64;
    // Both rows are mixed once a texel, for some pixels at a time, and then between texels.
    let mut mixed = [0; 2 * RUN + 2];
    for pixels in pixels.chunks_mut(RUN) {
        let first = (u >> 16).max(0) as usize;
        let end = ((u + step * pixels.len() as i64) >> 16).max(0) as usize;
        let needed = (end.max(first) - first + 2).min(mixed.len());
        for (mixed, x) in mixed[..needed].iter_mut().zip(first..) {
            let x = x.min(last);
            let texel = |row: &[Color32]| u32::from_le_bytes(row[x].to_array());
            *mixed = between(texel(upper), texel(lower), down);
        }
        for below in pixels {
            let x = ((u >> 16).max(0) as usize - first).min(needed - 2);
            // Before the first texel there is nothing to mix with.
            let right = if u < 0 { 0 } else { (u >> 8 & 255) as u32 };
            let own = between(mixed[x], mixed[x + 1], right).to_le_bytes();
            *below = over(pixel(tint.map_or(own, |tint| times(own, tint))), *below);
            u += step;
        }
    }
}

/// All four channels at once, `share` 256ths of the way from `a` to `b`.
fn between(a: u32, b: u32, share: u32) -> u32 {
    const HALF: u32 = 0x00ff_00ff;
    let mix = |a: u32, b: u32| ((a & HALF) * (256 - share) + (b & HALF) * share + 0x0080_0080) >> 8 & HALF;
    mix(a, b) | mix(a >> 8, b >> 8) << 8
}

fn copy(texels: &[Color32], pixels: &mut [u32]) {
    const RUN: usize = 16;
    for (pixels, texels) in pixels.chunks_mut(RUN).zip(texels.chunks(RUN)) {
        let opaque = texels.iter().all(|texel| texel.a() == 255);
        for (below, texel) in pixels.iter_mut().zip(texels) {
            let own = pixel(texel.to_array());
            *below = if opaque { own } else { over(own, *below) };
        }
    }
}

fn shade(colors: &[Gradient; 4], from: &Span, column: u16) -> [u8; 4] {
    let x = from.x + f32::from(column);
    // A cast keeps to 0 to 255 by itself.
    colors.map(|gradient| (gradient.of(x, from.y) + 0.5) as u8)
}

/// A product of colors, each channel of 255.
fn times(a: [u8; 4], b: [u8; 4]) -> [u8; 4] {
    std::array::from_fn(|channel| share(u32::from(a[channel]) * u32::from(b[channel])) as u8)
}

/// A 255th, rounded.
fn share(product: u32) -> u32 {
    let product = product + 128;
    (product + (product >> 8)) >> 8
}

/// Red, green, blue, alpha as a pixel: 0xAARRGGBB.
fn pixel([r, g, b, a]: [u8; 4]) -> u32 {
    u32::from_be_bytes([a, r, g, b])
}

/// A premultiplied color over a pixel; colors that only add light may exceed 255, which is cut off.
fn over(own: u32, below: u32) -> u32 {
    let left = 255 - (own >> 24);
    if left == 0 {
        return own;
    }
    let (own, below) = (own.to_ne_bytes(), below.to_ne_bytes());
    u32::from_ne_bytes(std::array::from_fn(|channel| {
        own[channel].saturating_add(share(u32::from(below[channel]) * left) as u8)
    }))
}
