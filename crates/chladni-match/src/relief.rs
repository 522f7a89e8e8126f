//! Relief: how far a surface stands out from its surroundings. It is positive on noses and ears, negative
//! at eyes and mouths.

use rayon::prelude::*;

use crate::samples::Sample;

/// Radius of the surroundings on the shape, in diagonals.
pub(crate) const RADIUS: f64 = 0.1;
/// Number of levels. Each level's radius is √2 times that of the level before; the middle one has
/// [`RADIUS`].
const LEVELS: usize = 9;

/// For each sample, its height along its normal above the mean of the samples around it, divided by the
/// radius, at several radii. No similarity changes these numbers.
#[derive(Clone, Debug)]
pub(crate) struct Relief {
    heights: Vec<[f64; LEVELS]>,
}

fn radius(level: usize) -> f64 {
    RADIUS * 2_f64.powf(0.5 * (level as f64 - (LEVELS / 2) as f64))
}

impl Relief {
    pub fn new(samples: &[Sample]) -> Self {
        let widest = radius(LEVELS - 1).powi(2);
        let squared: [f64; LEVELS] = std::array::from_fn(|level| radius(level).powi(2));
        let heights = samples
            .par_iter()
            .map(|s| {
                let mut sums = [(0.0, 0.0); LEVELS];
                for other in samples {
                    let d = other.point - s.point;
                    let d2 = d.length_squared();
                    // The far side of a thin sheet does not count as surroundings.
                    if d2 >= widest || other.normal.dot(s.normal) < -0.2 {
                        continue;
                    }
                    let height = -d.dot(s.normal);
                    for ((sum, weight), r2) in sums.iter_mut().zip(squared).rev() {
                        if d2 >= r2 {
                            break;
                        }
                        let w = (1.0 - d2 / r2).powi(2);
                        *sum += w * height;
                        *weight += w;
                    }
                }
                // A sample belongs to its own surroundings: the weights are at least 1.
                std::array::from_fn(|level| sums[level].0 / sums[level].1 / radius(level))
            })
            .collect();
        Self { heights }
    }

    /// The height of a sample above the surface within about `around` of it.
    pub fn height(&self, sample: usize, around: f64) -> f64 {
        let level = (2.0 * (around / RADIUS).log2()).round() + (LEVELS / 2) as f64;
        self.heights[sample][(level.max(0.0) as usize).min(LEVELS - 1)]
    }
}

/// Pearson's correlation of pairs that are added one by one.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Correlation {
    count: f64,
    x: f64,
    y: f64,
    xx: f64,
    yy: f64,
    xy: f64,
}

impl Correlation {
    pub fn add(&mut self, x: f64, y: f64) {
        self.count += 1.0;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.yy += y * y;
        self.xy += x * y;
    }

    /// The correlation, in [−1, 1]; 0 if one side is constant.
    pub fn value(&self) -> f64 {
        let n = self.count.max(1.0);
        let (vx, vy) = (self.xx - self.x * self.x / n, self.yy - self.y * self.y / n);
        let size = (vx.max(0.0) * vy.max(0.0)).sqrt();
        // Heights of 1e-4 of the radius come from the sampling.
        if size > 1e-8 * n { ((self.xy - self.x * self.y / n) / size).clamp(-1.0, 1.0) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn a_sphere_is_convex_alike_everywhere_and_size_does_not_matter() {
        let samples: Vec<Sample> = (0..3000)
            .map(|i| {
                let z = (i as f64 + 0.5) / 1500.0 - 1.0;
                let (s, c) = (i as f64 * 2.399_963).sin_cos();
                let normal = DVec3::new(c * (1.0 - z * z).sqrt(), s * (1.0 - z * z).sqrt(), z);
                Sample { point: normal * 0.4, normal }
            })
            .collect();
        let relief = Relief::new(&samples);
        // A cap of radius r on a sphere of radius R is r²/(2R) deep; (1 − d²/r²)² weighs d² by r²/4.
        let expected = RADIUS / (8.0 * 0.4);
        for i in (0..3000).step_by(97) {
            assert!((relief.height(i, RADIUS) - expected).abs() < 0.15 * expected);
        }
        let double: Vec<Sample> = samples.iter().map(|s| Sample { point: s.point * 2.0, ..*s }).collect();
        let doubled = Relief::new(&double);
        for i in (0..3000).step_by(97) {
            assert!((doubled.height(i, 2.0 * RADIUS) - relief.height(i, RADIUS)).abs() < 1e-12);
        }
    }

    #[test]
    fn correlation_tells_alike_from_opposite_and_constant() {
        let of = |f: fn(f64) -> f64| {
            let mut c = Correlation::default();
            (0..50).for_each(|i| c.add(f64::from(i), f(f64::from(i))));
            c.value()
        };
        assert!((of(|x| 3.0 * x - 1.0) - 1.0).abs() < 1e-12 && (of(|x| -x) + 1.0).abs() < 1e-12);
        assert_eq!((of(|_| 2.0), Correlation::default().value()), (0.0, 0.0));
    }
}
