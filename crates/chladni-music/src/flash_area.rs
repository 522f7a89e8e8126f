//! Where a picture flashes, cell by cell: in relative luminance and in saturated red (WCAG 2.3.1, ITU-R BT.1702).

use std::collections::VecDeque;

use crate::flash::{GUARDED, GUARDED_DARK, Swings};
use crate::flash_field::{FlashArea, are_too_many};
use crate::histogram::{CELLS, relative_luminance};
use crate::{FLASH_DARK, FLASH_STEP, Histogram, MAX_FLASHES, Veil};

/// A saturated red has at least this share of its light in red.
const RED_SHARE: f32 = 0.8;
/// The change of (R − G − B) · 320 that counts; negatives count as 0.
const RED_STEP: f32 = 20.0;

/// The quantity in which a picture may flash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    Luminance,
    Red,
}

/// One quantity of all cells, and which cells changed within the last second.
///
/// It notes all changes, or only rises. Rises and falls of a cell alternate, so that a cell with at most three rises in
/// any second has at most seven changes in it: three flashes, which are pairs. A denser black veil lowers all cells,
/// so it makes no rises, and under black nothing rises: limiting rises can always be done.
#[derive(Clone, Debug)]
pub(crate) struct Places {
    quantity: Quantity,
    /// From here on a red is saturated.
    red_share: f32,
    swings: Vec<Swings>,
    /// Whether a cell was saturated red since its last change.
    was_red: Vec<bool>,
    rises_only: bool,
    recent: VecDeque<(f64, u16)>,
    counts: Vec<u16>,
}

impl Places {
    /// Notes all changes of a quantity, exactly as defined.
    pub(crate) fn counting(quantity: Quantity) -> Self {
        let swings = match quantity {
            Quantity::Luminance => Swings::of(FLASH_STEP, FLASH_DARK),
            Quantity::Red => Swings::of(RED_STEP, f32::INFINITY),
        };
        Self {
            quantity,
            red_share: RED_SHARE,
            swings: vec![swings; CELLS],
            was_red: vec![false; CELLS],
            rises_only: false,
            recent: VecDeque::with_capacity(4 * CELLS),
            counts: vec![0; CELLS],
        }
    }

    /// Notes the rises of a quantity, from somewhat less than what counts.
    pub(crate) fn guarding(quantity: Quantity) -> Self {
        let swings = match quantity {
            Quantity::Luminance => Swings::of(GUARDED * FLASH_STEP, GUARDED_DARK),
            Quantity::Red => Swings::of(GUARDED * RED_STEP, f32::INFINITY),
        };
        let exact = Self::counting(quantity);
        Self { red_share: RED_SHARE - 0.02, swings: vec![swings; CELLS], rises_only: true, ..exact }
    }

    /// Notes the rises of a quantity, exactly as defined. One that counts may come later than the smaller one that
    /// [`guarding`](Self::guarding) notes, and so fall into another second.
    pub(crate) fn rising(quantity: Quantity) -> Self {
        Self { rises_only: true, ..Self::counting(quantity) }
    }

    /// Forgets changes more than a second before `time_secs`.
    pub(crate) fn forget(&mut self, time_secs: f64) {
        while let Some((_, cell)) = self.recent.pop_front_if(|(at_secs, _)| time_secs - *at_secs > 1.0) {
            self.counts[usize::from(cell)] -= 1;
        }
    }

    /// Takes the picture shown at `time_secs`: `picture` behind `veil`.
    pub(crate) fn show(&mut self, time_secs: f64, picture: &Histogram, veil: Veil) {
        self.forget(time_secs);
        for cell in 0..CELLS {
            let Some(color) = picture.color(cell, veil) else { continue };
            let (value, is_red) = self.read(color);
            let change = self.change(cell, value, is_red);
            self.swings[cell].take(value, change);
            self.was_red[cell] = is_red || change == 0 && self.was_red[cell];
            if change > 0 || change < 0 && !self.rises_only {
                self.recent.push_back((time_secs, cell as u16));
                self.counts[cell] += 1;
            }
        }
    }

    /// Whether more than a quarter of the cells of `area` would have risen more than three times within a
    /// second if `picture` were shown now behind `veil`.
    pub(crate) fn would_flash(&self, picture: &Histogram, veil: Veil, area: FlashArea) -> bool {
        let rises_too_often = |cell: usize| {
            let rises = usize::from(self.counts[cell]);
            rises > MAX_FLASHES
                || rises == MAX_FLASHES
                    && picture.color(cell, veil).is_some_and(|color| {
                        let (value, is_red) = self.read(color);
                        self.change(cell, value, is_red) > 0
                    })
        };
        are_too_many(picture, area, rises_too_often)
    }

    /// Flashes that more than a quarter of the cells of `area` had within the last second, each.
    pub(crate) fn flashes(&self, picture: &Histogram, area: FlashArea) -> usize {
        let have = |flashes: usize| {
            are_too_many(picture, area, |cell| usize::from(self.counts[cell]) >= 2 * flashes)
        };
        (1..).take_while(|&flashes| have(flashes)).last().unwrap_or(0)
    }

    /// The quantity of a linear color, and whether the color is a saturated red.
    fn read(&self, color: [f32; 3]) -> (f32, bool) {
        let [r, g, b] = color;
        match self.quantity {
            Quantity::Luminance => (relative_luminance(color), false),
            Quantity::Red => (320.0 * (r - g - b).max(0.0), r > 0.0 && r >= self.red_share * (r + g + b)),
        }
    }

    /// Which change it would be: of red only one to or from a saturated red.
    fn change(&self, cell: usize, value: f32, is_red: bool) -> i8 {
        let counts = self.quantity == Quantity::Luminance || is_red || self.was_red[cell];
        if counts { self.swings[cell].change(value) } else { 0 }
    }
}

#[cfg(test)]
mod limits;
#[cfg(test)]
mod tests;
