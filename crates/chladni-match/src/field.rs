//! A coarse lookup of the nearest sample of a surface, for first tests of many poses.

use glam::DVec3;

use crate::samples::Sample;

/// Cells along each axis.
const CELLS: usize = 40;
/// Margin around the samples, in diagonals.
const MARGIN: f64 = 0.2;

/// A grid that stores for each cell the sample nearest to its center, found by propagation from the cells
/// that hold samples. The error is at most about one cell, which is the spacing of the samples themselves.
#[derive(Clone, Debug)]
pub(crate) struct Field {
    low: DVec3,
    cells_per_length: DVec3,
    nearest: Vec<u16>,
    samples: Vec<Sample>,
}

impl Field {
    /// Builds the grid. At most 65 535 samples are used.
    pub fn new(samples: &[Sample]) -> Self {
        let samples = samples[..samples.len().min(usize::from(u16::MAX))].to_vec();
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for s in &samples {
            low = low.min(s.point);
            high = high.max(s.point);
        }
        (low, high) = (low - MARGIN, high + MARGIN);
        let cells_per_length = DVec3::splat(CELLS as f64) / (high - low);
        let mut field = Self { low, cells_per_length, nearest: vec![u16::MAX; CELLS.pow(3)], samples };
        field.propagate();
        field
    }

    fn cell(&self, query: DVec3) -> [usize; 3] {
        let at = (query - self.low) * self.cells_per_length;
        std::array::from_fn(|i| (at[i].max(0.0) as usize).min(CELLS - 1))
    }

    fn center(&self, [x, y, z]: [usize; 3]) -> DVec3 {
        self.low + (DVec3::new(x as f64, y as f64, z as f64) + 0.5) / self.cells_per_length
    }

    /// Breadth-first search from the occupied cells: a cell takes over the sample of a neighbor if it is
    /// nearer.
    fn propagate(&mut self) {
        let index = |[x, y, z]: [usize; 3]| (x * CELLS + y) * CELLS + z;
        let mut best = vec![f64::INFINITY; self.nearest.len()];
        let mut front = Vec::new();
        for i in 0..self.samples.len() {
            let cell = self.cell(self.samples[i].point);
            let d = self.center(cell).distance_squared(self.samples[i].point);
            if d < best[index(cell)] {
                best[index(cell)] = d;
                self.nearest[index(cell)] = i as u16;
                front.push(cell);
            }
        }
        while !front.is_empty() {
            let mut next = Vec::new();
            for cell in front {
                let sample = self.nearest[index(cell)];
                let point = self.samples[usize::from(sample)].point;
                for axis in 0..3 {
                    for step in [-1_isize, 1] {
                        let Some(k) = cell[axis].checked_add_signed(step).filter(|k| *k < CELLS) else {
                            continue;
                        };
                        let mut other = cell;
                        other[axis] = k;
                        let d = self.center(other).distance_squared(point);
                        if d < best[index(other)] {
                            best[index(other)] = d;
                            self.nearest[index(other)] = sample;
                            next.push(other);
                        }
                    }
                }
            }
            front = next;
        }
    }

    /// A sample near `query`, and its index.
    pub fn near(&self, query: DVec3) -> Option<(usize, &Sample)> {
        let [x, y, z] = self.cell(query);
        let index = usize::from(self.nearest[(x * CELLS + y) * CELLS + z]);
        Some((index, self.samples.get(index)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_it_finds_is_hardly_farther_than_the_nearest() {
        let samples: Vec<Sample> = (0..2000)
            .map(|i| {
                let (s, t) = (i as f64 * 0.618, i as f64 * 0.0031);
                let point = DVec3::new(s.cos() * t.sin(), s.sin() * t.sin(), t.cos()) * 0.4;
                Sample { point, normal: point.normalize() }
            })
            .collect();
        let field = Field::new(&samples);
        for i in 0..500 {
            let q = DVec3::new((i as f64).sin(), (i as f64 * 1.7).cos(), (i as f64 * 0.3).sin()) * 0.5;
            let found = field.near(q).unwrap().1.point.distance(q);
            let least = samples.iter().map(|s| s.point.distance(q)).fold(f64::INFINITY, f64::min);
            assert!(found <= least + 0.03, "{found} {least}");
        }
    }
}
