//! Checks the items of a frame and arranges them as the columns of one matrix product.

use crate::{Coefficients, Item, Residual, SynthError, Term};

/// An error in a term, without its place.
#[derive(Debug)]
pub(crate) enum TermFault {
    TooMany { found: usize, harmonics: usize },
    NotFinite(String),
    Length { what: &'static str, found: usize, vertices: usize },
    MixedForms,
}

impl TermFault {
    pub fn at(self, item: usize, term: usize) -> SynthError {
        match self {
            Self::TooMany { found, harmonics } => {
                SynthError::TooManyCoefficients { item, term, found, harmonics }
            }
            Self::NotFinite(what) => SynthError::WeightNotFinite { item, term, what },
            Self::Length { what, found, vertices } => {
                SynthError::SignalLength { item, term, what, found, vertices }
            }
            Self::MixedForms => SynthError::MixedForms { item, term },
        }
    }
}

/// Checks everything about a term that does not need a pass over the vertices.
pub(crate) fn check_term(term: &Term, vertices: usize, harmonics: usize) -> Result<(), TermFault> {
    let (found, bad) = match &term.coefficients {
        Coefficients::Vector(c) => (c.len(), c.iter().position(|c| !c.iter().all(|c| c.is_finite()))),
        Coefficients::Normal(c) => (c.len(), c.iter().position(|c| !c.is_finite())),
    };
    if found > harmonics {
        return Err(TermFault::TooMany { found, harmonics });
    }
    if let Some(k) = bad {
        return Err(TermFault::NotFinite(format!("coefficient of harmonic {k}")));
    }
    if !term.residual_gain.is_finite() {
        return Err(TermFault::NotFinite("residual gain".into()));
    }
    let residual = match (&term.residual, &term.coefficients) {
        (None, _) => vertices,
        (Some(Residual::Vector(r)), Coefficients::Vector(_)) => r.len(),
        (Some(Residual::Normal(r)), Coefficients::Normal(_)) => r.len(),
        _ => return Err(TermFault::MixedForms),
    };
    if residual != vertices {
        return Err(TermFault::Length { what: "residual", found: residual, vertices });
    }
    match &term.mask {
        Some(mask) if mask.len() != vertices => {
            Err(TermFault::Length { what: "mask", found: mask.len(), vertices })
        }
        _ => Ok(()),
    }
}

/// The number of columns that a term takes in the product.
pub(crate) fn columns_of(term: &Term) -> usize {
    match term.coefficients {
        Coefficients::Vector(_) => 3,
        Coefficients::Normal(_) => 1,
    }
}

/// The right-hand side of the product: all columns of all terms, for the harmonics that have weight in any
/// of them.
///
/// Columns are split evenly into `blocks` of `width` columns (at most as many as a kernel holds in registers);
/// the last block is padded with zeros. Buffers are kept from frame to frame.
#[derive(Debug)]
pub(crate) struct Plan {
    /// The harmonics with weight, ascending.
    pub active: Vec<u32>,
    /// Their number, rounded up to whole batches.
    pub rows: usize,
    /// blocks × rows × width values, already multiplied by the scales of the basis; zero in padded rows.
    pub coefficients: Vec<f32>,
    pub blocks: usize,
    pub width: usize,
    widths: &'static [usize],
    batch: usize,
    weighted: Vec<bool>,
}

impl Plan {
    /// A plan for kernels that sum one of `widths` (ascending) columns at once and take harmonics in
    /// batches.
    pub fn new(widths: &'static [usize], batch: usize) -> Self {
        Self {
            active: Vec::new(),
            rows: 0,
            coefficients: Vec::new(),
            blocks: 0,
            width: 0,
            widths,
            batch,
            weighted: Vec::new(),
        }
    }

    /// Checks `items` and arranges them. After an error the plan must not be used.
    pub fn lay_out(&mut self, items: &[Item], vertices: usize, scales: &[f64]) -> Result<(), SynthError> {
        if items.len().checked_mul(vertices).is_none_or(|n| u32::try_from(n).is_err()) {
            return Err(SynthError::TooLarge { items: items.len(), vertices });
        }
        self.weighted.clear();
        self.weighted.resize(scales.len(), false);
        let mut columns = 0;
        for (i, item) in items.iter().enumerate() {
            for (t, term) in item.terms.iter().enumerate() {
                check_term(term, vertices, scales.len()).map_err(|e| e.at(i, t))?;
                mark_weighted(&term.coefficients, &mut self.weighted);
                columns += columns_of(term);
            }
        }
        self.active.clear();
        self.active.extend((0_u32..).zip(&self.weighted).filter(|(_, w)| **w).map(|(k, _)| k));
        self.rows = self.active.len().next_multiple_of(self.batch);
        self.blocks = columns.div_ceil(self.widths.last().copied().unwrap_or(1));
        let width = if self.blocks > 0 { columns.div_ceil(self.blocks) } else { 0 };
        self.width = self.widths.iter().copied().find(|&w| w >= width).unwrap_or(width);
        self.coefficients.clear();
        self.coefficients.resize(self.blocks * self.rows * self.width, 0.0);
        let mut column = 0;
        for term in items.iter().flat_map(|item| &item.terms) {
            match &term.coefficients {
                Coefficients::Vector(c) => {
                    (0..3).for_each(|i| self.fill(column + i, scales, c.len(), |k| c[k][i]));
                }
                Coefficients::Normal(c) => self.fill(column, scales, c.len(), |k| c[k]),
            }
            column += columns_of(term);
        }
        Ok(())
    }

    /// The number of columns, including padding.
    pub fn columns(&self) -> usize {
        self.blocks * self.width
    }

    /// The rows × width coefficients of one block.
    pub fn block(&self, block: usize) -> &[f32] {
        let size = self.rows * self.width;
        &self.coefficients[block * size..][..size]
    }

    /// The active harmonics of the next panel that a kernel prefetches while it computes `block`. All
    /// blocks get an equal share, which gives memory an even load.
    pub fn share_of(&self, block: usize) -> &[u32] {
        let share = self.active.len().div_ceil(self.blocks);
        let start = (block * share).min(self.active.len());
        &self.active[start..(start + share).min(self.active.len())]
    }

    fn fill(&mut self, column: usize, scales: &[f64], len: usize, at: impl Fn(usize) -> f32) {
        let (block, lane) = (column / self.width, column % self.width);
        let size = self.rows * self.width;
        let rows = self.coefficients[block * size..][..size].chunks_exact_mut(self.width);
        for (row, &k) in rows.zip(&self.active).take_while(|(_, k)| (**k as usize) < len) {
            let k = k as usize;
            row[lane] = (f64::from(at(k)) * scales[k]) as f32;
        }
    }
}

fn mark_weighted(coefficients: &Coefficients, weighted: &mut [bool]) {
    match coefficients {
        Coefficients::Vector(c) => {
            weighted.iter_mut().zip(c).for_each(|(w, c)| *w |= *c != [0.0; 3]);
        }
        Coefficients::Normal(c) => weighted.iter_mut().zip(c).for_each(|(w, c)| *w |= *c != 0.0),
    }
}
