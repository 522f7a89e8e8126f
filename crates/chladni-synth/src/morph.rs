//! Converts a recorded movement to a few fixed displacements with changing weights, the form that file
//! formats with morph targets store.

use std::sync::Arc;

use chladni_mesh::symmetric_eigen;

use crate::{Coefficients, Item, Residual, Term};

/// The coefficients of one moving item, recorded frame by frame.
#[derive(Clone, Debug, Default)]
pub struct Movement {
    frames: usize,
    /// One track for each combination of mask, form and residual, in the order of their first occurrence.
    tracks: Vec<Track>,
}

/// The sum of all terms that have the same mask, form and residual.
#[derive(Clone, Debug)]
struct Track {
    /// One of these terms, as an example.
    like: Term,
    channels: usize,
    /// One series of frames for each channel of each harmonic. Shorter series are continued by zeros.
    coefficients: Vec<Vec<f32>>,
    residual_gain: Vec<f32>,
}

/// One fixed displacement of a [`Movement`].
#[derive(Clone, Debug)]
pub struct Morph {
    /// The displacement at weight 1.
    pub item: Item,
    /// The harmonic that contributes most; `None` for the detail above K.
    pub harmonic: Option<u32>,
    /// The indices of the tracks that contribute, in the order in which their kinds of terms first
    /// occurred.
    pub terms: Vec<usize>,
}

/// A movement, separated into fixed displacements and their weights.
#[derive(Clone, Debug)]
pub struct Morphs {
    /// The displacements, strongest first.
    pub morphs: Vec<Morph>,
    /// For each frame the weight of each morph, in [−1, 1].
    pub weights: Vec<f32>,
}

/// A displacement by one harmonic of one track: a direction and its series of amplitudes.
struct Motion {
    track: usize,
    /// `None` stands for the residual.
    harmonic: Option<u32>,
    direction: [f32; 3],
    series: Vec<f32>,
    /// The sum of the squares of `series`.
    squares: f64,
    energy: f64,
}

/// Series are the same movement if their cosine differs from 1 by less than this.
const SAME: f64 = 1e-6;
/// Motions with less than this share of the largest motion's energy are rounding errors.
const NEGLIGIBLE: f64 = 1e-12;

impl Movement {
    /// Adds a frame.
    pub fn push(&mut self, item: &Item) {
        let frame = self.frames;
        for term in &item.terms {
            let found = self.tracks.iter().position(|track| track.takes(term));
            let track = found.unwrap_or_else(|| {
                self.tracks.push(Track::like(term));
                self.tracks.len() - 1
            });
            self.tracks[track].add(frame, term);
        }
        self.frames += 1;
    }

    /// The number of frames so far.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// At most `most` displacements that reproduce as much of the movement as that number can. They are the
    /// strongest directions of single harmonics; directions that move in proportion are combined into one
    /// displacement. If `most` does not limit their number, they reproduce the movement exactly (up to
    /// rounding).
    ///
    /// # Errors
    /// The first error of `check`, which is called before each direction is compared with those before it: of a
    /// long movement they are many.
    pub fn morphs<E>(&self, most: usize, mut check: impl FnMut() -> Result<(), E>) -> Result<Morphs, E> {
        let mut motions: Vec<Motion> =
            self.tracks.iter().enumerate().flat_map(|(i, track)| track.motions(i, self.frames)).collect();
        motions.sort_by(|a, b| b.energy.total_cmp(&a.energy));
        let least = NEGLIGIBLE * motions.first().map_or(0.0, |motion| motion.energy);
        motions.retain(|motion| motion.energy > least);
        let mut kept: Vec<Vec<(Motion, f32)>> = Vec::new();
        for motion in motions {
            check()?;
            let mut leaders = kept.iter().enumerate();
            let leader = leaders.find_map(|(i, group)| Some((i, group[0].0.proportion(&motion)?)));
            match leader {
                Some((i, ratio)) => kept[i].push((motion, ratio)),
                None if kept.len() < most => kept.push(vec![(motion, 1.0)]),
                None => {}
            }
        }
        let mut weights = vec![0.0; self.frames * kept.len()];
        let count = kept.len();
        let morphs = (kept.iter().enumerate()).map(|(j, group)| {
            let series = &group[0].0.series;
            let largest = series.iter().fold(f32::MIN_POSITIVE, |m, w| m.max(w.abs()));
            series.iter().enumerate().for_each(|(f, w)| weights[f * count + j] = w / largest);
            self.morph(group, largest)
        });
        Ok(Morphs { morphs: morphs.collect(), weights })
    }

    fn morph(&self, group: &[(Motion, f32)], largest: f32) -> Morph {
        let mut terms: Vec<usize> = group.iter().map(|(motion, _)| motion.track).collect();
        terms.sort_unstable();
        terms.dedup();
        let items = terms.iter().map(|&track| {
            let mut term = self.tracks[track].like.clone();
            for (motion, ratio) in group.iter().filter(|(motion, _)| motion.track == track) {
                let size = ratio * largest;
                match (motion.harmonic, &mut term.coefficients) {
                    (None, _) => term.residual_gain += size,
                    (Some(k), Coefficients::Vector(c)) => {
                        let k = k as usize;
                        c.resize(c.len().max(k + 1), [0.0; 3]);
                        (0..3).for_each(|i| c[k][i] += size * motion.direction[i]);
                    }
                    (Some(k), Coefficients::Normal(c)) => {
                        let k = k as usize;
                        c.resize(c.len().max(k + 1), 0.0);
                        c[k] += size;
                    }
                }
            }
            term
        });
        Morph { item: Item { terms: items.collect() }, harmonic: group[0].0.harmonic, terms }
    }
}

impl Motion {
    /// How many times this motion `other` is, if it is a multiple of it.
    fn proportion(&self, other: &Self) -> Option<f32> {
        let (aa, ab, bb) = (self.squares, dot(&self.series, &other.series), other.squares);
        (ab * ab >= (1.0 - SAME) * aa * bb && aa > 0.0).then(|| (ab / aa) as f32)
    }
}

impl Track {
    fn like(term: &Term) -> Self {
        let (coefficients, channels) = match term.coefficients {
            Coefficients::Vector(_) => (Coefficients::Vector(Vec::new()), 3),
            Coefficients::Normal(_) => (Coefficients::Normal(Vec::new()), 1),
        };
        let like = Term { coefficients, residual_gain: 0.0, ..term.clone() };
        Self { like, channels, coefficients: Vec::new(), residual_gain: Vec::new() }
    }

    fn takes(&self, term: &Term) -> bool {
        let same_form = matches!(
            (&self.like.coefficients, &term.coefficients),
            (Coefficients::Vector(_), Coefficients::Vector(_))
                | (Coefficients::Normal(_), Coefficients::Normal(_))
        );
        let same_residual = match (&self.like.residual, &term.residual) {
            (Some(Residual::Vector(a)), Some(Residual::Vector(b))) => Arc::ptr_eq(a, b),
            (Some(Residual::Normal(a)), Some(Residual::Normal(b))) => Arc::ptr_eq(a, b),
            (None, None) => true,
            _ => false,
        };
        let same_mask = match (&self.like.mask, &term.mask) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (None, None) => true,
            _ => false,
        };
        same_form && same_residual && same_mask
    }

    fn add(&mut self, frame: usize, term: &Term) {
        let values: &[f32] = match &term.coefficients {
            Coefficients::Vector(c) => c.as_flattened(),
            Coefficients::Normal(c) => c,
        };
        if self.coefficients.len() < values.len() {
            self.coefficients.resize(values.len(), Vec::new());
        }
        let add = |series: &mut Vec<f32>, value: f32| {
            if value != 0.0 {
                series.resize(series.len().max(frame + 1), 0.0);
                series[frame] += value;
            }
        };
        self.coefficients.iter_mut().zip(values).for_each(|(series, value)| add(series, *value));
        add(&mut self.residual_gain, term.residual_gain);
    }

    /// All motions of a track: at most three directions per harmonic.
    fn motions(&self, track: usize, frames: usize) -> Vec<Motion> {
        // A half-mask lets half of the energy through.
        let mask = self.like.mask.as_ref().map_or(1.0, |mask| mean_square(mask));
        let padded = |series: &[f32]| {
            let mut series = series.to_vec();
            series.resize(frames, 0.0);
            series
        };
        let energy = |series: &[f32]| mask * series.iter().map(|x| f64::from(x * x)).sum::<f64>();
        let motion = |harmonic, direction, series: Vec<f32>, energy| {
            let squares = dot(&series, &series);
            Motion { track, harmonic, direction, series, squares, energy }
        };
        let mut motions = Vec::new();
        for (k, series) in (0..).zip(self.coefficients.chunks(self.channels)) {
            if self.channels == 1 {
                let series = padded(&series[0]);
                let energy = energy(&series);
                motions.push(motion(Some(k), [0.0; 3], series, energy));
                continue;
            }
            let at = |f: usize| -> [f32; 3] { [0, 1, 2].map(|i| series[i].get(f).copied().unwrap_or(0.0)) };
            let mut spread = [[0.0; 3]; 3];
            for c in (0..frames).map(at) {
                (0..3).for_each(|i| (0..3).for_each(|j| spread[i][j] += f64::from(c[i]) * f64::from(c[j])));
            }
            for direction in symmetric_eigen(spread).1 {
                let direction = direction.map(|d| d as f32);
                let along = |c: [f32; 3]| (0..3).map(|i| c[i] * direction[i]).sum::<f32>();
                let series: Vec<f32> = (0..frames).map(|f| along(at(f))).collect();
                let energy = energy(&series);
                motions.push(motion(Some(k), direction, series, energy));
            }
        }
        let series = padded(&self.residual_gain);
        let size = match &self.like.residual {
            Some(Residual::Vector(r)) => 3.0 * mean_square(r.as_flattened()),
            Some(Residual::Normal(r)) => mean_square(r),
            None => 0.0,
        };
        let energy = size * energy(&series);
        motions.push(motion(None, [0.0; 3], series, energy));
        motions
    }
}

fn mean_square(values: &[f32]) -> f64 {
    values.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>() / values.len().max(1) as f64
}

fn dot(x: &[f32], y: &[f32]) -> f64 {
    x.iter().zip(y).map(|(x, y)| f64::from(*x) * f64::from(*y)).sum()
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;

    fn separated(movement: &Movement, most: usize) -> Morphs {
        movement.morphs(most, || Ok::<(), Infallible>(())).unwrap()
    }

    fn frame(at: f32, mask: &Arc<[f32]>, residual: &Arc<[[f32; 3]]>) -> Item {
        let swing = (3.0 * at).sin();
        let half = Term {
            coefficients: Coefficients::Vector(vec![[0.0; 3], [swing, 2.0 * swing, 0.0], [0.0, at, -at]]),
            residual: Some(Residual::Vector(Arc::clone(residual))),
            residual_gain: 0.1 * at,
            mask: Some(Arc::clone(mask)),
        };
        let along = Coefficients::Normal(vec![0.0, 0.0, 0.0, 0.25 * swing]);
        let plain = Term { coefficients: along, residual: None, residual_gain: 0.0, mask: None };
        Item { terms: vec![half, plain] }
    }

    /// All coefficients of a frame, track by track.
    fn flat(items: &[(&Item, f32)], mask: &Arc<[f32]>) -> Vec<f32> {
        let mut out = vec![0.0; 3 * 4 + 4 + 1];
        for (term, w) in items.iter().flat_map(|(item, w)| item.terms.iter().map(move |t| (t, *w))) {
            assert_eq!(
                term.mask.as_ref().map(Arc::as_ptr),
                match &term.coefficients {
                    Coefficients::Vector(_) => Some(Arc::as_ptr(mask)),
                    Coefficients::Normal(_) => None,
                }
            );
            match &term.coefficients {
                Coefficients::Vector(c) => {
                    c.as_flattened().iter().enumerate().for_each(|(i, c)| out[i] += w * c);
                    out[16] += w * term.residual_gain;
                }
                Coefficients::Normal(c) => c.iter().enumerate().for_each(|(i, c)| out[12 + i] += w * c),
            }
        }
        out
    }

    #[test]
    fn morphs_and_weights_give_the_movement_and_proportional_motions_are_one() {
        let mask: Arc<[f32]> = vec![0.5; 6].into();
        let residual: Arc<[[f32; 3]]> = vec![[0.1, 0.0, 0.2]; 6].into();
        let frames: Vec<Item> = (0..40).map(|f| frame(f as f32 / 10.0, &mask, &residual)).collect();
        let mut movement = Movement::default();
        frames.iter().for_each(|item| movement.push(item));
        let all = separated(&movement, usize::MAX);
        // Harmonic 1 along one direction together with the normal motion of harmonic 3; harmonic 2 together
        // with the residual.
        assert_eq!(all.morphs.len(), 2);
        assert!(all.weights.iter().all(|w| w.abs() <= 1.0));
        let mut firsts: Vec<_> = all.morphs.iter().map(|m| (m.harmonic, m.terms.clone())).collect();
        firsts.sort();
        assert_eq!(firsts, [(Some(1), vec![0, 1]), (Some(2), vec![0])]);
        for (f, item) in frames.iter().enumerate() {
            let weights = &all.weights[2 * f..2 * f + 2];
            let sum: Vec<(&Item, f32)> =
                all.morphs.iter().zip(weights).map(|(morph, w)| (&morph.item, *w)).collect();
            let (wanted, found) = (flat(&[(item, 1.0)], &mask), flat(&sum, &mask));
            assert!(wanted.iter().zip(&found).all(|(a, b)| (a - b).abs() < 1e-4), "{wanted:?} {found:?}");
        }
        let one = separated(&movement, 1);
        assert_eq!(one.morphs.len(), 1);
        assert_eq!(one.morphs[0].harmonic, all.morphs[0].harmonic);
        // Harmonics 1 and 2, the residual, and the normal motion of harmonic 3: each can be the last.
        let mut left = 4;
        let counted = movement.morphs(1, || {
            left -= 1;
            if left > 0 { Ok(()) } else { Err("stopped") }
        });
        assert_eq!(counted.unwrap_err(), "stopped");
        assert_eq!(left, 0);
    }

    #[test]
    fn nothing_that_moves_is_no_morph() {
        let mut movement = Movement::default();
        assert!(separated(&movement, 8).morphs.is_empty());
        movement.push(&Item::default());
        let still = Term {
            coefficients: Coefficients::Normal(vec![0.0; 5]),
            residual: None,
            residual_gain: 0.0,
            mask: None,
        };
        movement.push(&Item { terms: vec![still] });
        assert_eq!(movement.frames(), 2);
        let morphs = separated(&movement, 8);
        assert!(morphs.morphs.is_empty() && morphs.weights.is_empty());
    }
}
