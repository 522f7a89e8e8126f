//! How many vertices a small picture of a dance needs.

use chladni_synth::{Coefficients, Item, Term};

/// A level of detail has one vertex per this many pixels of its cell, of which a shape fills about a third:
/// edges of five or six pixels.
const PIXELS_OF_VERTEX: usize = 50;
/// So many for each harmonic up to the finest that is seen: four in a wave's length, as the length of the
/// k-th wave squared is π/k of the surface (Weyl's law).
const VERTICES_OF_HARMONIC: usize = 5;
/// Displacements below this (the shape's area is one) are invisible in a cell: a third of a pixel.
const SEEN: f32 = 0.002;

/// How many harmonics of `item` are needed for all visible movement in a cell.
pub fn harmonics_seen(item: &Item) -> usize {
    let seen = |squares: &mut dyn DoubleEndedIterator<Item = f32>, count: usize| {
        let mut above = 0.0;
        let reaches = |square| {
            above += square;
            above > SEEN * SEEN
        };
        squares.rev().position(reaches).map_or(0, |unseen| count - unseen)
    };
    let of_term = |term: &Term| match &term.coefficients {
        Coefficients::Vector(all) => seen(&mut all.iter().map(|c| c.iter().map(|c| c * c).sum()), all.len()),
        Coefficients::Normal(all) => seen(&mut all.iter().map(|c| c * c), all.len()),
    };
    item.terms.iter().map(of_term).max().unwrap_or(0)
}

/// How many vertices a shape needs that moves by `harmonics` in a cell of `pixels`.
pub fn vertices_needed(harmonics: usize, pixels: usize) -> usize {
    (pixels / PIXELS_OF_VERTEX).max(VERTICES_OF_HARMONIC * harmonics)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fine_waves_need_more_vertices_where_they_are_seen() {
        let item = |fine: f32| {
            let coefficients =
                Coefficients::Normal((0..500).map(|k| if k < 40 { 0.1 } else { fine }).collect());
            let term = Term { coefficients, residual: None, residual_gain: 0.0, mask: None };
            Item { terms: vec![term] }
        };
        let seen = [0.0, 1e-5, 0.01].map(|fine| harmonics_seen(&item(fine)));
        assert_eq!((seen, harmonics_seen(&Item::default())), ([40, 40, 500], 0));
        let needed = [(40, 50_000), (40, 100), (500, 50_000)].map(|(k, pixels)| vertices_needed(k, pixels));
        assert_eq!(needed, [1000, 200, 2500]);
    }
}
