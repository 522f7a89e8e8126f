//! 255 colors for a whole clip.

use crate::Picture;

/// Bits a channel of the histogram and of the table that finds the nearest color.
const BITS: u32 = 6;
const CELLS: usize = 1 << (3 * BITS);

/// Colors chosen by median cut and improved by Lloyd's k-means, both on a histogram.
pub(super) struct Palette {
    colors: Vec<[u8; 3]>,
    /// Nearest color of each histogram cell.
    nearest: Vec<u8>,
    /// Half the typical distance between neighbors: the amplitude of the dither.
    spread: f32,
    /// Whether the clip has transparent pixels.
    pub(super) has_clear: bool,
}

/// A histogram cell that occurs: mean color and weight.
#[derive(Clone, Copy)]
struct Sample {
    color: [f32; 3],
    weight: f32,
}

impl Palette {
    /// The index that shows nothing.
    pub(super) const CLEAR: u8 = 255;

    pub(super) fn of(pictures: &[Picture]) -> Self {
        // About 32 evenly spread frames are enough.
        let step = pictures.len().div_ceil(32).max(1);
        let mut counts = vec![0_u32; CELLS];
        let has_clear =
            pictures.iter().any(|picture| picture.rgba.as_chunks::<4>().0.iter().any(|[.., a]| *a < 128));
        for picture in pictures.iter().step_by(step) {
            for &[r, g, b, a] in picture.rgba.as_chunks::<4>().0 {
                if a >= 128 {
                    counts[cell(r, g, b)] += 1;
                }
            }
        }
        let samples: Vec<Sample> = (0..)
            .zip(&counts)
            .filter(|(_, count)| **count > 0)
            // Large flat areas must not take all colors: their weight grows as the square root.
            .map(|(cell, count)| Sample { color: cell_color(cell), weight: (*count as f32).sqrt() })
            .collect();
        let mut means = median_cut(samples.clone(), 255);
        for _ in 0..4 {
            improve(&mut means, &samples);
        }
        let colors: Vec<[u8; 3]> =
            means.iter().map(|mean| mean.map(|c| c.round().clamp(0.0, 255.0) as u8)).collect();
        let nearest = (0..CELLS).map(|cell| nearest_of(&means, cell_color(cell)) as u8).collect();
        Self { spread: spread(&means), colors, nearest, has_clear }
    }

    /// 256 RGB triples.
    pub(super) fn bytes(&self) -> Vec<u8> {
        let mut bytes: Vec<u8> = self.colors.iter().flatten().copied().collect();
        bytes.resize(768, 0);
        bytes
    }

    /// One index a pixel. The dither is an ordered one, fixed to the screen, so that what does
    /// not move does not flicker.
    pub(super) fn indices(&self, picture: &Picture) -> Vec<u8> {
        let width = picture.width.max(1) as usize;
        picture
            .rgba
            .as_chunks::<4>()
            .0
            .iter()
            .enumerate()
            .map(|(i, &[r, g, b, a])| {
                // Where no hole was seen before, the index of one would show the frame before.
                if a < 128 && self.has_clear {
                    return Self::CLEAR;
                }
                let nudge = bayer(i % width, i / width) * self.spread;
                let nudged = [r, g, b].map(|c| (f32::from(c) + nudge).round().clamp(0.0, 255.0) as u8);
                self.nearest[cell(nudged[0], nudged[1], nudged[2])]
            })
            .collect()
    }
}

fn cell(r: u8, g: u8, b: u8) -> usize {
    let [r, g, b] = [r, g, b].map(|c| usize::from(c >> (8 - BITS)));
    (r << (2 * BITS)) | (g << BITS) | b
}

fn cell_color(cell: usize) -> [f32; 3] {
    let mask = (1 << BITS) - 1;
    [cell >> (2 * BITS), (cell >> BITS) & mask, cell & mask].map(|c| c as f32 * 255.0 / mask as f32)
}

/// Squared distance with the eye's weights for red, green and blue.
fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    const WEIGHTS: [f32; 3] = [0.9, 1.5, 0.6];
    (0..3).map(|i| WEIGHTS[i] * (a[i] - b[i]) * (a[i] - b[i])).sum()
}

fn nearest_of(means: &[[f32; 3]], color: [f32; 3]) -> usize {
    let by_distance =
        |a: &usize, b: &usize| distance(means[*a], color).total_cmp(&distance(means[*b], color));
    (0..means.len()).min_by(by_distance).unwrap_or(0)
}

/// Heckbert, "Color Image Quantization for Frame Buffer Display", SIGGRAPH 1982; the box with
/// the largest weighted variance is cut next.
fn median_cut(samples: Vec<Sample>, most: usize) -> Vec<[f32; 3]> {
    let mut boxes = vec![measure(samples)];
    while boxes.len() < most {
        let widest = (0..boxes.len()).max_by(|a, b| boxes[*a].1.total_cmp(&boxes[*b].1));
        let Some(widest) = widest.filter(|i| boxes[*i].1 > 0.0 && boxes[*i].0.len() > 1) else { break };
        let (mut samples, _, axis, mean) = boxes.swap_remove(widest);
        samples.sort_unstable_by(|a, b| a.color[axis].total_cmp(&b.color[axis]));
        let cut = samples.partition_point(|s| s.color[axis] <= mean[axis]).clamp(1, samples.len() - 1);
        let right = samples.split_off(cut);
        boxes.push(measure(samples));
        boxes.push(measure(right));
    }
    boxes.into_iter().map(|(_, _, _, mean)| mean).collect()
}

/// A box of samples with its largest variance (not divided by weight), the axis of it, and the mean.
fn measure(samples: Vec<Sample>) -> (Vec<Sample>, f32, usize, [f32; 3]) {
    let total: f32 = samples.iter().map(|s| s.weight).sum::<f32>().max(f32::MIN_POSITIVE);
    let mean: [f32; 3] =
        std::array::from_fn(|i| samples.iter().map(|s| s.weight * s.color[i]).sum::<f32>() / total);
    let variance: [f32; 3] = std::array::from_fn(|i| {
        samples.iter().map(|s| s.weight * (s.color[i] - mean[i]).powi(2)).sum::<f32>()
    });
    let axis = (0..3).max_by(|a, b| variance[*a].total_cmp(&variance[*b])).unwrap_or(0);
    (samples, variance[axis], axis, mean)
}

/// One step of Lloyd's algorithm.
fn improve(means: &mut [[f32; 3]], samples: &[Sample]) {
    let mut sums = vec![([0.0_f32; 3], 0.0_f32); means.len()];
    for sample in samples {
        let (sum, weight) = &mut sums[nearest_of(means, sample.color)];
        for i in 0..3 {
            sum[i] += sample.weight * sample.color[i];
        }
        *weight += sample.weight;
    }
    for (mean, (sum, weight)) in means.iter_mut().zip(sums) {
        if weight > 0.0 {
            *mean = sum.map(|s| s / weight);
        }
    }
}

/// Half the median distance from a color to its nearest neighbor.
fn spread(means: &[[f32; 3]]) -> f32 {
    let mut gaps: Vec<f32> = (0..means.len())
        .map(|i| {
            let others = (0..means.len()).filter(|j| *j != i).map(|j| distance(means[i], means[j]));
            others.fold(f32::INFINITY, f32::min).sqrt()
        })
        .filter(|gap| gap.is_finite())
        .collect();
    gaps.sort_unstable_by(f32::total_cmp);
    gaps.get(gaps.len() / 2).map_or(0.0, |gap| 0.5 * gap.min(24.0))
}

/// Bayer's 8×8 matrix, in [−1, 1).
fn bayer(x: usize, y: usize) -> f32 {
    let mut value = 0;
    for bit in 0..3 {
        let (x, y) = ((x >> bit) & 1, (y >> bit) & 1);
        value |= (((x ^ y) << 1) | y) << (2 * (2 - bit));
    }
    (value as f32 + 0.5) / 32.0 - 1.0
}
