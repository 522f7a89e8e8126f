//! The heat map.

use chladni_view::ColorMap;

use super::session::Session;
use crate::work::{Coating, Quantity, Seen, coating, with_pointed};

/// The user's choice, and whether the stage shows it already.
#[derive(Debug)]
pub struct Heat {
    quantity: Quantity,
    /// The one that was chosen for longer than a look.
    chosen: Quantity,
    harmonic: usize,
    map: ColorMap,
    painting: Option<Painting>,
    /// A part of the shape under the pointer, 1 on it.
    pointed: Option<Vec<f32>>,
    stale: bool,
}

/// Which form of a region is shown while it is painted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Painting {
    /// As it was painted.
    Raw,
    /// As it acts.
    Smoothed,
}

impl Default for Heat {
    fn default() -> Self {
        Self {
            quantity: Quantity::None,
            chosen: Quantity::None,
            harmonic: 1,
            map: ColorMap::Viridis,
            painting: None,
            pointed: None,
            stale: false,
        }
    }
}

impl Heat {
    /// The quantity shown.
    pub fn quantity(&self) -> Quantity {
        self.quantity
    }

    /// A shape was opened, with or without colors of its own.
    pub fn start(&mut self, own_look: bool) {
        self.quantity = if own_look { Quantity::Own } else { Quantity::None };
        self.chosen = self.quantity;
        self.stale = true;
    }

    /// The harmonic to show.
    pub fn harmonic(&self) -> usize {
        self.harmonic
    }

    /// Shows something else.
    pub fn choose(&mut self, quantity: Quantity, harmonic: usize, map: ColorMap) {
        self.stale |= (quantity, harmonic, map) != (self.quantity, self.harmonic, self.map);
        if quantity != self.quantity {
            self.chosen = quantity;
        }
        (self.quantity, self.harmonic, self.map) = (quantity, harmonic, map);
    }

    /// Has a look at `quantity`, or, where it is shown already, shows what was chosen before.
    pub fn toggle(&mut self, quantity: Quantity) {
        let before = if self.chosen == quantity { Quantity::None } else { self.chosen };
        self.quantity = if self.quantity == quantity { before } else { quantity };
        self.stale = true;
    }

    /// The color map for magnitudes.
    pub fn map(&self) -> ColorMap {
        self.map
    }

    /// Whether the choice changed since this was last asked.
    pub fn take_stale(&mut self) -> bool {
        std::mem::take(&mut self.stale)
    }

    /// While a region is painted it is shown, as painted or as it acts, unless a map was chosen.
    pub fn paint(&mut self, painting: Option<Painting>) {
        self.stale |= painting != self.painting;
        self.painting = painting;
    }

    /// While parts are pointed at, that under the pointer is shown with the region, unless a map was chosen.
    pub fn point(&mut self, pointed: Option<Vec<f32>>) {
        self.stale |= pointed != self.pointed;
        self.pointed = pointed;
    }

    /// The coating of the stage.
    pub fn coating(&self, session: &Session) -> Coating {
        let shown = match self.painting.filter(|_| matches!(self.quantity, Quantity::None | Quantity::Own)) {
            Some(Painting::Raw) => Quantity::Painted,
            Some(Painting::Smoothed) => Quantity::Region,
            None => self.quantity,
        };
        let folds: Vec<u32> = session.shown.folds.iter().flat_map(|folds| folds.iter()).copied().collect();
        let seen = Seen {
            project: session.project(),
            stack: &session.stack,
            evaluation: &session.shown.evaluation,
            selected: session.selected,
            folds: &folds,
            crossings: session.crossings.triangles(),
        };
        let own = if self.quantity == Quantity::Own { Coating::Own } else { Coating::Material };
        match coating(shown, self.harmonic, self.map, &seen).unwrap_or(own) {
            Coating::Region(values) => Coating::Region(match self.pointed.as_deref() {
                Some(pointed) => with_pointed(&values, pointed),
                None => values,
            }),
            other => other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_look_at_folds_leaves_a_shape_its_own_colors() {
        let mut heat = Heat::default();
        heat.start(true);
        // The bar says each frame what is shown.
        let mut look_at = |quantity: Quantity| {
            heat.toggle(quantity);
            heat.choose(heat.quantity, heat.harmonic, heat.map);
            heat.quantity
        };
        assert_eq!(look_at(Quantity::Folds), Quantity::Folds);
        assert_eq!(look_at(Quantity::Confidence), Quantity::Confidence);
        assert_eq!(look_at(Quantity::Confidence), Quantity::Own);
        heat.choose(Quantity::Folds, 1, ColorMap::Viridis);
        heat.toggle(Quantity::Folds);
        assert_eq!(heat.quantity, Quantity::None);
    }
}
