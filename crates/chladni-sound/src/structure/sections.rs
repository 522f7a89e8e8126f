//! Where sections begin: novelty of the song's self-similarity, bar by bar.
//!
//! J. Foote, "Automatic audio segmentation using a measure of audio novelty" (ICME 2000): a checkerboard
//! kernel slides along the diagonal of the self-similarity matrix. The boundaries are chosen among its
//! peaks all at once: they maximize the sum of the novelty, less a cost for each section whose length is
//! not a multiple of four bars.

use super::Section;
use super::beat_features::BeatFeatures;
use super::frame::{CLASSES, OCTAVES};

/// How many bars on either side of a boundary are compared.
const REACH: usize = 6;
/// Novelty, in [0, 1] (0: all bars are alike), below which no section begins.
const LEAST: f32 = 0.2;
/// The smallest length of a section, in bars.
const SHORTEST: usize = 2;
/// Cost of a section whose length is not a multiple of four bars.
const ODD: f32 = 0.08;
/// Sections whose bars are at least this similar get the same name.
const SAME: f32 = 0.55;

const DIMENSIONS: usize = 2 * CLASSES + OCTAVES + 8;
type BarFeatures = [f32; DIMENSIONS];

/// Features of a bar: the mean of its beats.
fn of_bar(beats: &[BeatFeatures]) -> BarFeatures {
    let mut mean = [0.0; DIMENSIONS];
    for beat in beats {
        let values =
            beat.chroma.iter().chain(&beat.bass).chain(&beat.octaves).chain(beat.rhythm.as_flattened());
        mean.iter_mut().zip(values).for_each(|(mean, value)| *mean += value / beats.len() as f32);
    }
    mean
}

/// Standardizes the features: subtracts the mean over all bars and divides by the standard deviation.
/// Harmony, timbre and rhythm get equal weight.
fn even(bars: &mut [BarFeatures]) {
    let count = bars.len().max(1) as f32;
    for d in 0..DIMENSIONS {
        let mean = bars.iter().map(|bar| bar[d]).sum::<f32>() / count;
        let square = bars.iter().map(|bar| (bar[d] - mean).powi(2)).sum::<f32>() / count;
        let kind = match d {
            d if d < 2 * CLASSES => 2.0 * (2 * CLASSES) as f32,
            d if d < 2 * CLASSES + OCTAVES => OCTAVES as f32,
            _ => 8.0,
        };
        // The constant keeps deviations that are only noise from being amplified to the size of audible
        // ones.
        let scale = 1.0 / ((square.sqrt() + 0.02) * kind.sqrt());
        bars.iter_mut().for_each(|bar| bar[d] = (bar[d] - mean) * scale);
    }
}

/// Similarity of two bars, in [0, 1].
fn likeness(a: &BarFeatures, b: &BarFeatures) -> f32 {
    let square: f32 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
    (-0.25 * square).exp()
}

/// The indices of the bars with which sections begin; the first is 0.
fn boundaries(bars: &[BarFeatures]) -> Vec<usize> {
    let count = bars.len();
    let novelty: Vec<f32> = (0..count).map(|at| novelty_at(bars, at)).collect();
    // best[i]: the greatest total worth of sections that end before bar i, and where the last of them
    // begins.
    let mut best = vec![(f32::NEG_INFINITY, 0); count + 1];
    best[0] = (0.0, 0);
    for end in 1..=count {
        let worth = if end == count { 0.0 } else { novelty[end] - LEAST };
        for begin in 0..end {
            if end - begin < SHORTEST.min(count) {
                continue;
            }
            let odd = if end == count || (end - begin) % 4 == 0 { 0.0 } else { ODD };
            let value = best[begin].0 + worth - odd;
            if value > best[end].0 {
                best[end] = (value, begin);
            }
        }
    }
    let mut begins = Vec::new();
    let mut at = count;
    while at > 0 {
        at = best[at].1;
        begins.push(at);
    }
    begins.reverse();
    begins
}

/// How much the bars from `at` on differ from those before, and how similar each side is in itself.
fn novelty_at(bars: &[BarFeatures], at: usize) -> f32 {
    let reach = REACH.min(at).min(bars.len() - at);
    if reach == 0 {
        return 0.0;
    }
    let (mut within, mut across, mut weights) = (0.0, 0.0, [0.0f32; 2]);
    for i in at - reach..at + reach {
        for j in at - reach..i {
            let far = |k: usize| (k as f32 + 0.5 - at as f32) / REACH as f32;
            let weight = (-2.0 * (far(i).powi(2) + far(j).powi(2))).exp();
            let like = weight * likeness(&bars[i], &bars[j]);
            let is_across = j < at && i >= at;
            weights[usize::from(is_across)] += weight;
            *(if is_across { &mut across } else { &mut within }) += like;
        }
    }
    let within = if weights[0] > 0.0 { within / weights[0] } else { 1.0 };
    within - across / weights[1].max(1e-6)
}

/// The name of the section that is the `i`-th of its kind, from 0: A to Z, then a to z, then again from A.
pub(crate) fn section_name(i: usize) -> char {
    const LETTERS: &[u8; 52] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz";
    LETTERS[i % LETTERS.len()].into()
}

/// The sections of a song; `bars` begin with the beats that have these indices.
pub(super) fn sections(
    first_beats: &[usize],
    beats_secs: &[f64],
    heard: &[BeatFeatures],
    energy_between: impl Fn(f64, f64) -> f32,
) -> Vec<Section> {
    let ends = first_beats.iter().skip(1).copied().chain([heard.len()]);
    let mut bars: Vec<BarFeatures> =
        first_beats.iter().zip(ends).map(|(&from, to)| of_bar(&heard[from..to.max(from)])).collect();
    even(&mut bars);
    let begins = boundaries(&bars);
    let mut sections: Vec<Section> = Vec::new();
    // For each name, its first section.
    let mut models: Vec<(char, &[BarFeatures])> = Vec::new();
    for (i, &begin) in begins.iter().enumerate() {
        let end = begins.get(i + 1).copied().unwrap_or(bars.len());
        let own = &bars[begin..end];
        let alike = |model: &[BarFeatures]| {
            // Bar by bar, because a repetition follows the same order.
            let pairs = own.iter().zip(model.iter().cycle());
            pairs.map(|(a, b)| likeness(a, b)).sum::<f32>() / own.len() as f32
        };
        let known = models.iter().map(|(name, model)| (*name, alike(model)));
        let name = match known.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, alike)| *alike >= SAME) {
            Some((name, _)) => name,
            None => {
                let name = section_name(models.len());
                models.push((name, own));
                name
            }
        };
        let secs = |bar: usize| first_beats.get(bar).and_then(|&beat| beats_secs.get(beat)).copied();
        let Some(at_secs) = secs(begin) else { continue };
        let end_secs = secs(end).or(beats_secs.last().copied()).unwrap_or(at_secs);
        sections.push(Section { at_secs, name, energy: energy_between(at_secs, end_secs) });
    }
    sections
}

#[cfg(test)]
mod tests {
    use super::*;

    fn song(form: &str) -> Vec<BarFeatures> {
        let mut bars: Vec<BarFeatures> = form
            .chars()
            .flat_map(|name| {
                (0..8).map(move |bar| {
                    let mut features = [0.0; DIMENSIONS];
                    features[(name as usize - 'A' as usize) * 3 + bar % 2] = 1.0;
                    features[2 * CLASSES + (name as usize) % OCTAVES] = 1.0;
                    features
                })
            })
            .collect();
        even(&mut bars);
        bars
    }

    #[test]
    fn fifty_two_kinds_of_sections_have_names_of_their_own() {
        let names: std::collections::HashSet<char> = (0..52).map(section_name).collect();
        assert_eq!(names.len(), 52);
        assert_eq!([0, 25, 26, 51, 52].map(section_name), ['A', 'Z', 'a', 'z', 'A']);
    }

    #[test]
    fn sections_begin_where_something_else_does() {
        assert_eq!(boundaries(&song("ABCA")), [0, 8, 16, 24]);
        // A repetition (AA) has no audible boundary.
        assert_eq!(boundaries(&song("AABA")), [0, 16, 24]);
        assert_eq!(boundaries(&song("A")), [0]);
        assert!(boundaries(&[]).is_empty());
    }
}
