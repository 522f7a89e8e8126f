//! What is known of a picture that may flash: how often each value occurs, and the mean color of each cell.

use chladni_mesh::{linear_from_srgb, srgb_from_linear};

use crate::Veil;

/// Cells of a picture, across and down; at a distance at which it fills 40° a cell is a degree wide.
pub(crate) const COLUMNS: usize = 48;
pub(crate) const ROWS: usize = 32;
/// All cells.
pub(crate) const CELLS: usize = COLUMNS * ROWS;

/// How often each sRGB-encoded value occurs in a picture, per channel, and the mean color of each of 48 × 32 cells.
///
/// It gives the mean relative luminance (WCAG) and the colors of cells under any [`Veil`] without reading the pixels
/// again.
#[derive(Clone, Debug)]
pub struct Histogram {
    counts: [[u32; 256]; 3],
    linear: [f32; 256],
    cells: Vec<Cell>,
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
        Self { counts: [[0; 256]; 3], linear, cells: vec![Cell::default(); CELLS] }
    }
}

impl Histogram {
    /// Forgets all pixels.
    pub fn clear(&mut self) {
        self.counts = [[0; 256]; 3];
        self.cells.fill(Cell::default());
    }

    /// Counts the pixel in column and row `at` of a picture of `size` columns and rows.
    #[inline]
    pub fn add(&mut self, at: [u32; 2], size: [u32; 2], rgb: [u8; 3]) {
        for (counts, value) in self.counts.iter_mut().zip(rgb) {
            counts[usize::from(value)] += 1;
        }
        let [column, row] = [(0, COLUMNS), (1, ROWS)].map(|(axis, cells)| {
            let cell = (at[axis] as f32 + 0.5) * (cells as f32 / size[axis].max(1) as f32);
            (cell as usize).min(cells - 1)
        });
        let cell = &mut self.cells[row * COLUMNS + column];
        for (light, value) in cell.light.iter_mut().zip(rgb) {
            *light += self.linear[usize::from(value)];
        }
        cell.pixels += 1.0;
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
        // Rounded as what is shown is: a veil just dense enough must not lose by it what it gains.
        Some(light.map(|sum| {
            let clear = (255.0 * srgb_from_linear(f64::from(sum / pixels))).round() as u8;
            self.linear[usize::from(veil.over(clear))]
        }))
    }
}
