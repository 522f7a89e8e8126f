//! The initial gallery of mappings.

use chladni_breeding::ChaCha8Rng;
use rand::RngExt;

use crate::symmetry::spare_constants;
use crate::{Mapping, direct_transfer};

/// A gallery of mappings.
pub type Gallery = chladni_breeding::Gallery<Mapping>;
/// One item of a gallery.
pub type GalleryItem = chladni_breeding::GalleryItem<Mapping>;

/// The body and the number of bands that an initial gallery is made for.
#[derive(Clone, Debug, PartialEq)]
pub struct GalleryShape {
    /// λ_k of the body, ascending; K of them.
    pub eigenvalues: Vec<f64>,
    /// #ω.
    pub bands: usize,
}

impl GalleryShape {
    /// How many waves of each harmonic fit into the size of the body, twice its farthest coordinate from its
    /// centroid: √λ_k/π, because that is 2 in the working frame. It does not depend on units or on K, but on how the
    /// body lies in its file: its longest side is 1 to 2 in the working frame.
    pub fn waves_per_size(&self) -> Vec<f32> {
        self.eigenvalues.iter().map(|l| (l.max(0.0).sqrt() / std::f64::consts::PI) as f32).collect()
    }
}

/// The initial gallery of `size` mappings, which are made for `shape`.
pub(crate) fn initial(size: usize, shape: &GalleryShape) -> impl FnOnce(&mut ChaCha8Rng) -> Vec<Mapping> {
    move |rng| {
        let mu = initial_mu(size, rng);
        let items = initial_mappings(size, shape).into_iter().zip(mu);
        items.map(|(mapping, stereo_mu)| Mapping { stereo_mu, ..mapping }).collect()
    }
}

/// μ of the initial items: random, with 0 and 1 always among them.
fn initial_mu(size: usize, rng: &mut ChaCha8Rng) -> Vec<f32> {
    let mut mu: Vec<f32> = (0..size).map(|_| rng.random()).collect();
    let zero = rng.random_range(0..size);
    let one = (zero + rng.random_range(1..size)) % size;
    mu[zero] = 0.0;
    mu[one] = 1.0;
    mu
}

/// The initial gallery without μ (docs/music.md, "The initial gallery"): each amplification gets a transfer
/// of its own. The paper leaves open which. Paired in order, most items are silent, because their sound goes
/// to harmonics that they do not amplify.
fn initial_mappings(size: usize, shape: &GalleryShape) -> Vec<Mapping> {
    let k = shape.eigenvalues.len().max(1);
    let spare = spare_constants(&shape.eigenvalues);
    let mut transfers = initial_transfers(size, shape);
    let mut amplifications: Vec<Vec<f32>> =
        (0..size).map(|item| initial_amplification(size, item, k, spare)).collect();
    let targets = |t: &[f32]| t.iter().map(|t| (t * (k - 1) as f32).round() as usize).collect::<Vec<_>>();
    let driven: Vec<Vec<usize>> = transfers.iter().map(|t| targets(t)).collect();
    let feeds: Vec<Vec<usize>> = (amplifications.iter())
        .map(|a| driven.iter().map(|ks| ks.iter().filter(|&&k| a[k] != 0.0).count()).collect())
        .collect();
    let choice = pairs(&feeds);
    for (item, (a, &t)) in amplifications.iter_mut().zip(&choice).enumerate() {
        if feeds[item][t] == 0 {
            reach_out(a, &driven[t], spare);
        }
    }
    (amplifications.into_iter().zip(choice))
        .map(|(amplification, t)| {
            let transfer = std::mem::take(&mut transfers[t]);
            let mapping = Mapping { transfer, amplification, stereo_mu: 0.0, gain: 1.0 };
            Mapping { gain: mapping.even_gain(), ..mapping }
        })
        .collect()
}

/// A different transfer for each amplification: a maximum matching in which transfers feed their
/// amplification (with `feeds[amplification][transfer]` bands), preferring the one that feeds it most.
fn pairs(feeds: &[Vec<usize>]) -> Vec<usize> {
    /// Finds a transfer for `item`, moving other items to another one where needed (Kuhn's algorithm).
    fn place(item: usize, feeds: &[Vec<usize>], seen: &mut [bool], owner: &mut [Option<usize>]) -> bool {
        let mut wanted: Vec<usize> = (0..owner.len()).filter(|&t| feeds[item][t] > 0).collect();
        wanted.sort_by_key(|&t| (std::cmp::Reverse(feeds[item][t]), t));
        for t in wanted {
            if !std::mem::replace(&mut seen[t], true)
                && owner[t].is_none_or(|other| place(other, feeds, seen, owner))
            {
                owner[t] = Some(item);
                return true;
            }
        }
        false
    }
    let mut owner = vec![None; feeds.len()];
    let without: Vec<usize> = (0..feeds.len())
        .filter(|&item| !place(item, feeds, &mut vec![false; feeds.len()], &mut owner))
        .collect();
    let free: Vec<usize> = (0..owner.len()).filter(|&t| owner[t].is_none()).collect();
    free.into_iter().zip(without).for_each(|(t, item)| owner[t] = Some(item));
    let mut choice = vec![0; feeds.len()];
    for (t, item) in owner.into_iter().enumerate() {
        if let Some(item) = item {
            choice[item] = t;
        }
    }
    choice
}

/// Extends an amplification that covers none of the `driven` harmonics to the nearest of them beyond the constant ones.
fn reach_out(a: &mut [f32], driven: &[usize], spare: usize) {
    let Some(first) = a.iter().position(|a| *a != 0.0) else { return };
    let last = a.iter().rposition(|a| *a != 0.0).unwrap_or(first);
    let away = |k: usize| first.saturating_sub(k).max(k.saturating_sub(last));
    if let Some(nearest) = driven.iter().copied().filter(|&k| k > spare).min_by_key(|&k| away(k)) {
        let sign = a[first];
        a[first.min(nearest)..=last.max(nearest)].fill(sign);
    }
}

/// t_ini(α ω) with α in ⌈S/2⌉ even steps from 0 to 1, then t_rev(α ω) likewise: S transfers, each once. Odd S
/// has room for one less of the latter: t_rev(0) is left out; like t_ini(0), it is constant.
fn initial_transfers(size: usize, shape: &GalleryShape) -> Vec<Vec<f32>> {
    let half = size.div_ceil(2);
    let transfer = |i: usize, reversed: bool| {
        let alpha = i as f64 / (half - 1) as f64;
        direct_transfer(&shape.eigenvalues, shape.bands, alpha, reversed)
    };
    let straight = (0..half).map(|i| transfer(i, false));
    straight.chain((size % 2..half).map(|i| transfer(i, true))).collect()
}

/// Band b covers k/K in [(2b/S)², (2(b+1)/S)²); the first ⌊S/2⌋ items amplify, the rest damp.
/// A band too narrow for any harmonic that moves the shape takes the next one up.
/// The first `spare` harmonics, constant like the next, get nothing.
fn initial_amplification(size: usize, item: usize, harmonics: usize, spare: usize) -> Vec<f32> {
    let half = size / 2;
    let (band, sign) = if item < half { (item, 1.0) } else { (item - half, -1.0) };
    let edge = |b: usize| (2.0 * b as f64 / size as f64).powi(2);
    let count = harmonics - spare;
    let mut a: Vec<f32> = (0..count)
        .map(|k| {
            let at = k as f64 / count as f64;
            if at >= edge(band) && at < edge(band + 1) { sign } else { 0.0 }
        })
        .collect();
    if a.iter().skip(1).all(|a| *a == 0.0) {
        let next = ((edge(band) * count as f64).ceil() as usize).clamp(1.min(count - 1), count - 1);
        a[next] = sign;
    }
    std::iter::repeat_n(0.0, spare).chain(a).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_breeding::GALLERY_SIZES;

    fn shape() -> GalleryShape {
        // Weyl: λ_k grows like k.
        GalleryShape { eigenvalues: (0..256).map(f64::from).collect(), bands: 128 }
    }

    #[test]
    fn bands_cover_all_harmonics_once_per_sign() {
        for size in GALLERY_SIZES {
            for sign in [1.0, -1.0] {
                let items = if sign > 0.0 { 0..size / 2 } else { size / 2..size };
                let sum = items.fold(vec![0.0f32; 1000], |mut sum, item| {
                    sum.iter_mut().zip(initial_amplification(size, item, 1000, 0)).for_each(|(s, a)| *s += a);
                    sum
                });
                // With odd S the amplifying half ends at ((S−1)/S)².
                let covered = if sign > 0.0 { ((size / 2 * 2) as f64 / size as f64).powi(2) } else { 1.0 };
                let end = (covered * 1000.0) as usize;
                assert!(sum[..end].iter().all(|a| *a == sign), "S = {size}");
            }
        }
    }

    #[test]
    fn every_initial_transfer_is_used_once_and_every_amplification_is_fed() {
        for size in GALLERY_SIZES {
            let transfers = initial_transfers(size, &shape());
            assert_eq!(transfers.len(), size);
            let direct = |reversed| direct_transfer(&shape().eigenvalues, 128, 1.0, reversed);
            assert!(transfers.contains(&direct(false)) && transfers.contains(&direct(true)), "S = {size}");
            let items = initial_mappings(size, &shape());
            let mut reached = 0;
            for (i, item) in items.iter().enumerate() {
                assert_eq!(items.iter().filter(|other| other.transfer == item.transfer).count(), 1);
                assert!(transfers.contains(&item.transfer), "S = {size}");
                assert!(item.loudness() > 0.0, "S = {size}, item {i}");
                reached += usize::from(item.amplification != initial_amplification(size, i, 256, 0));
            }
            // Three, four of t_rev stay in the highest band, which has two amplifications.
            assert!(reached <= size / 8, "S = {size}: {reached}");
        }
    }

    #[test]
    fn a_shape_of_many_pieces_gets_the_gallery_of_its_waves() {
        let (one, spare) = (shape(), 49);
        let eigenvalues = std::iter::repeat_n(0.0, spare).chain(one.eigenvalues.iter().copied()).collect();
        let many = GalleryShape { eigenvalues, ..one };
        for size in GALLERY_SIZES {
            for (alone, apart) in initial_mappings(size, &one).iter().zip(&initial_mappings(size, &many)) {
                assert_eq!(apart.amplification[..spare], vec![0.0; spare]);
                assert_eq!(apart.amplification[spare..], alone.amplification);
                let shifted = alone.targets(128, 256).iter().map(|k| k + spare as u32).collect::<Vec<_>>();
                assert_eq!((apart.targets(128, 256 + spare), apart.gain), (shifted, alone.gain));
            }
        }
        // All are constant: there is a gallery, although it moves nothing.
        let still = GalleryShape { eigenvalues: vec![0.0; 8], bands: 128 };
        initial_mappings(12, &still).iter().for_each(|mapping| mapping.validate().unwrap());
    }

    #[test]
    fn every_initial_item_sounds_and_mu_spans_its_range() {
        for size in GALLERY_SIZES {
            let gallery = Gallery::new(3, size, initial(size, &shape())).unwrap();
            assert_eq!(gallery.items().len(), size);
            for item in gallery.items() {
                item.genome.validate().unwrap();
                let targets = item.genome.targets(128, 256);
                let heard = targets.iter().any(|&k| k > 0 && item.genome.amplification[k as usize] != 0.0);
                assert!(heard, "item {} of {size}", item.id);
            }
            let mu: Vec<f32> = gallery.items().iter().map(|i| i.genome.stereo_mu).collect();
            assert!(mu.contains(&0.0) && mu.contains(&1.0));
        }
    }
}
