//! Statistics of a picture that may flash: how often each value occurs, the mean color of each cell, and the
//! luminance on a finer grid.

use chladni_mesh::{linear_from_srgb, srgb_from_linear};

use crate::Veil;

/// Cells of a picture, across and down; at a distance at which it fills 40° a cell is a degree wide.
pub(crate) const COLUMNS: usize = 48;
pub(crate) const ROWS: usize = 32;
/// All cells.
pub(crate) const CELLS: usize = COLUMNS * ROWS;
/// Dots of a cell, across and down: stripes are looked for among them.
pub(crate) const FINE: usize = 4;

/// How often each sRGB-encoded value occurs in a picture, per channel, the mean color of each of 48 × 32 cells, and the
/// mean luminance of each of 192 × 128 dots.
///
/// It gives the mean relative luminance (WCAG) and the colors of cells under any [`Veil`] without reading the pixels
/// again.
#[derive(Clone, Debug)]
pub struct Histogram {
    counts: [[u32; 256]; 3],
    linear: [f32; 256],
    cells: Vec<Cell>,
    /// Sum of the luminances of a dot, and its pixels.
    dots: Vec<[f32; 2]>,
    /// The dot of each column and row of a picture of the size counted last.
    dot_of: [Vec<u16>; 2],
}

/// Relative luminance (WCAG) of a linear color.
pub(crate) fn relative_luminance([r, g, b]: [f32; 3]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Sum of the linear colors of a cell, and its pixels.
#[derive(Clone, Copy, Debug, Default)]
struct Cell {
    light: [f32; 3],
    pixels: f32,
}

impl Default for Histogram {
    fn default() -> Self {
        let linear = std::array::from_fn(|byte| linear_from_srgb(byte as f64 / 255.0) as f32);
        Self {
            counts: [[0; 256]; 3],
            linear,
            cells: vec![Cell::default(); CELLS],
            dots: vec![[0.0; 2]; FINE * COLUMNS * FINE * ROWS],
            dot_of: [Vec::new(), Vec::new()],
        }
    }
}

impl Histogram {
    /// Dots of a picture, across and down.
    pub const DOTS: [u32; 2] = [(FINE * COLUMNS) as u32, (FINE * ROWS) as u32];

    /// Forgets all pixels.
    pub fn clear(&mut self) {
        self.counts = [[0; 256]; 3];
        self.cells.fill(Cell::default());
        self.dots.fill([0.0; 2]);
    }

    /// Counts the pixel in column and row `at` of a picture of `size` columns and rows; one outside is not counted.
    #[inline]
    pub fn add(&mut self, at: [u32; 2], size: [u32; 2], rgb: [u8; 3]) {
        if [0, 1].map(|axis| self.dot_of[axis].len()) != size.map(|side| side as usize) {
            self.lay_out(size);
        }
        let [x, y] = at.map(|place| place as usize);
        let (Some(&column), Some(&row)) = (self.dot_of[0].get(x), self.dot_of[1].get(y)) else { return };
        let [column, row] = [column, row].map(usize::from);
        for (counts, value) in self.counts.iter_mut().zip(rgb) {
            counts[usize::from(value)] += 1;
        }
        let light = rgb.map(|value| self.linear[usize::from(value)]);
        let cell = &mut self.cells[row / FINE * COLUMNS + column / FINE];
        (0..3).for_each(|i| cell.light[i] += light[i]);
        cell.pixels += 1.0;
        let [sum, pixels] = &mut self.dots[row * FINE * COLUMNS + column];
        *sum += relative_luminance(light);
        *pixels += 1.0;
    }

    /// Finds the dots of all columns and rows of a picture, so that pixels need not.
    #[cold]
    fn lay_out(&mut self, size: [u32; 2]) {
        for ((dot_of, side), dots) in self.dot_of.iter_mut().zip(size).zip(Self::DOTS) {
            dot_of.clear();
            let scale = dots as f32 / side as f32;
            dot_of.extend((0..side).map(|i| ((i as f32 + 0.5) * scale).min((dots - 1) as f32) as u16));
        }
    }

    /// Writes the mean luminance of each dot, row by row. One without pixels is like the one on its left, a row without any
    /// like the row above, so that a small picture shows no edges of its own.
    pub(crate) fn write_luminances(&self, into: &mut [f32]) {
        let wide = FINE * COLUMNS;
        for (row, dots) in self.dots.chunks_exact(wide).enumerate() {
            let known = |&[sum, pixels]: &[f32; 2]| (pixels > 0.0).then(|| sum / pixels);
            if let Some(mut last) = dots.iter().find_map(known) {
                for (into, dot) in into[row * wide..].iter_mut().zip(dots) {
                    last = known(dot).unwrap_or(last);
                    *into = last;
                }
            } else if row > 0 {
                into.copy_within((row - 1) * wide..row * wide, row * wide);
            } else {
                into[..wide].fill(0.0);
            }
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

    /// Whether a cell has pixels.
    pub(crate) fn has(&self, cell: usize) -> bool {
        self.cells.get(cell).is_some_and(|cell| cell.pixels > 0.0)
    }

    /// Mean linear color of a cell that has pixels, behind `veil`: exact where the veil is clear or the cell of one color.
    pub(crate) fn color(&self, cell: usize, veil: Veil) -> Option<[f32; 3]> {
        let Cell { light, pixels } = *self.cells.get(cell).filter(|cell| cell.pixels > 0.0)?;
        if veil == Veil::Clear {
            return Some(light.map(|sum| sum / pixels));
        }
        // Rounded like the picture shown: a veil that is just dense enough must not be undone by rounding.
        Some(light.map(|sum| {
            let clear = (255.0 * srgb_from_linear(f64::from(sum / pixels))).round() as u8;
            self.linear[usize::from(veil.over(clear))]
        }))
    }
}
