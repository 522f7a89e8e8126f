//! Synthesis on the processor: SIMD kernels chosen at run time, threads by rayon.
#![allow(unsafe_code, reason = "tasks write disjoint vertices of every item, see `rows`")]

mod kernels;
mod normals;
mod rows;

use rayon::prelude::*;

pub use kernels::CpuPath;
use kernels::Product;

use crate::packed_basis::PANEL;
use crate::plan::{Plan, columns_of};
use crate::{Coefficients, FrameSettings, Item, Residual, SynthError, SynthModel, Synthesizer, Term};
use normals::Gather;
use rows::DisjointRows;

/// Vertices per task when computing normals.
const NORMALS_CHUNK: usize = 4096;

/// Tasks per thread when computing the product: enough for other threads to take over the work of an
/// interrupted one.
const TASKS_PER_THREAD: usize = 8;

/// One value per vertex of a panel.
type Lanes = [f32; PANEL];

/// The CPU backend. It works in the rayon pool from which it is called. Buffers are kept from frame to
/// frame: a frame with no more items than an earlier one allocates nothing here.
#[derive(Debug)]
pub struct CpuSynthesizer {
    model: SynthModel,
    path: CpuPath,
    plan: Plan,
    items: usize,
    /// S·N positions, and one more.
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    /// For each task, the columns of one panel.
    scratch: Vec<Lanes>,
}

impl CpuSynthesizer {
    /// A synthesizer that uses the fastest path of this processor.
    pub fn new(model: SynthModel) -> Self {
        let path = CpuPath::available()[0];
        Self::on_path(model, path)
    }

    /// A synthesizer that uses the given path; `None` if this processor does not support it.
    pub fn with_path(model: SynthModel, path: CpuPath) -> Option<Self> {
        CpuPath::available().contains(&path).then(|| Self::on_path(model, path))
    }

    fn on_path(model: SynthModel, path: CpuPath) -> Self {
        Self {
            model,
            path,
            plan: Plan::new(path.widths(), 1),
            items: 0,
            positions: Vec::new(),
            normals: Vec::new(),
            scratch: Vec::new(),
        }
    }

    /// The instruction set in use.
    pub fn path(&self) -> CpuPath {
        self.path
    }

    /// N deformed positions of item `item` of the last frame; empty if there is no such item.
    pub fn positions(&self, item: usize) -> &[[f32; 3]] {
        self.slice(self.all_positions(), item)
    }

    /// N unit normals of item `item` of the last frame; empty if there is no such item.
    pub fn normals(&self, item: usize) -> &[[f32; 3]] {
        self.slice(&self.normals, item)
    }

    /// S·N positions, item after item.
    pub fn all_positions(&self) -> &[[f32; 3]] {
        let frame = self.items * self.model.vertices();
        self.positions.get(..frame).unwrap_or_default()
    }

    /// S·N normals, item after item.
    pub fn all_normals(&self) -> &[[f32; 3]] {
        &self.normals
    }

    fn slice<'a>(&self, all: &'a [[f32; 3]], item: usize) -> &'a [[f32; 3]] {
        let n = self.model.vertices();
        if item < self.items { all.get(item * n..(item + 1) * n).unwrap_or_default() } else { &[] }
    }
}

impl Synthesizer for CpuSynthesizer {
    fn model(&self) -> &SynthModel {
        &self.model
    }

    fn replace_model(&mut self, model: SynthModel) -> Result<(), SynthError> {
        self.model = model;
        self.items = 0;
        self.positions.clear();
        self.normals.clear();
        Ok(())
    }

    fn items(&self) -> usize {
        self.items
    }

    fn synthesize_positions(&mut self, items: &[Item]) -> Result<(), SynthError> {
        let Self { model, path, plan, positions, normals, scratch, .. } = self;
        let (basis, vertices) = (&*model.basis, model.vertices());
        plan.lay_out(items, vertices, basis.scales())?;
        self.items = items.len();
        // One more position, because four lanes are read from the last vertex too.
        positions.resize(items.len() * vertices + 1, [0.0; 3]);
        normals.resize(items.len() * vertices, [0.0; 3]);

        let tasks = (rayon::current_num_threads() * TASKS_PER_THREAD).clamp(1, basis.panels().max(1));
        let panels_per_task = basis.panels().div_ceil(tasks);
        // Every term has columns, but an item may have no term.
        let columns = plan.columns().max(1);
        scratch.resize(tasks * columns, [0.0; PANEL]);
        let rows = DisjointRows::new(positions, vertices);
        scratch.par_chunks_mut(columns).enumerate().for_each(|(task, columns)| {
            let first = task * panels_per_task;
            for panel in first..(first + panels_per_task).min(basis.panels()) {
                for block in 0..plan.blocks {
                    let product = Product {
                        panel: basis.panel(panel),
                        active: &plan.active,
                        coefficients: plan.block(block),
                        next_panel: basis.panel((panel + 1).min(basis.panels() - 1)),
                        fetch: plan.share_of(block),
                    };
                    path.product(&product, &mut columns[block * plan.width..][..plan.width]);
                }
                let start = panel * PANEL;
                let end = (start + PANEL).min(vertices);
                let mut column = 0;
                for (s, item) in items.iter().enumerate() {
                    // SAFETY: tasks take disjoint panels, and a slice is dropped before the next is claimed.
                    let out = unsafe { rows.claim(s, start..end) };
                    place(model, item, &columns[column..], start, out);
                    column += item.terms.iter().map(columns_of).sum::<usize>();
                }
            }
        });
        Ok(())
    }

    fn synthesize_normals(&mut self, settings: &FrameSettings) -> Result<(), SynthError> {
        settings.check()?;
        let Self { model, path, positions, normals, .. } = self;
        let gather = Gather {
            rings: &model.rings,
            rest_normals: &model.rest_normals,
            blending: settings.normal_blending,
            simd: *path != CpuPath::Portable,
        };
        let vertices = model.vertices().max(1);
        let positions = positions.as_flattened();
        normals.par_chunks_mut(vertices).enumerate().for_each(|(s, normals)| {
            let positions = &positions[3 * s * vertices..];
            normals.par_chunks_mut(NORMALS_CHUNK).enumerate().for_each(|(chunk, out)| {
                gather.run(positions, chunk * NORMALS_CHUNK, out);
            });
        });
        Ok(())
    }
}

/// x' of the vertices of one panel for one item, from the columns of the item's terms.
#[inline(always)]
fn place(model: &SynthModel, item: &Item, mut columns: &[Lanes], start: usize, out: &mut [[f32; 3]]) {
    let mut sum = [[0.0; PANEL]; 3];
    for term in &item.terms {
        let (own, others) = columns.split_at(columns_of(term));
        columns = others;
        add_term(model, term, own, start..start + out.len(), &mut sum);
    }
    for (i, (out, x)) in out.iter_mut().zip(&model.rest_positions[start..]).enumerate() {
        *out = [x[0] + sum[0][i], x[1] + sum[1][i], x[2] + sum[2][i]];
    }
}

/// Adds χ (ΣHC + r g) [· n] of one term for a range of at most one panel of vertices.
#[inline(always)]
fn add_term(
    model: &SynthModel,
    term: &Term,
    columns: &[Lanes],
    range: std::ops::Range<usize>,
    sum: &mut [Lanes; 3],
) {
    let gain = term.residual_gain;
    let residual = term.residual.as_ref().filter(|_| gain != 0.0);
    let mask = term.mask.as_ref().map(|m| &m[range.clone()]);
    match term.coefficients {
        Coefficients::Vector(_) => {
            for c in 0..3 {
                let mut signal = columns[c];
                if let Some(Residual::Vector(r)) = residual {
                    signal.iter_mut().zip(&r[range.clone()]).for_each(|(s, r)| *s += gain * r[c]);
                }
                if let Some(mask) = mask {
                    signal.iter_mut().zip(mask).for_each(|(s, m)| *s *= m);
                }
                sum[c].iter_mut().zip(&signal).for_each(|(sum, s)| *sum += s);
            }
        }
        Coefficients::Normal(_) => {
            let mut signal = columns[0];
            if let Some(Residual::Normal(r)) = residual {
                signal.iter_mut().zip(&r[range.clone()]).for_each(|(s, r)| *s += gain * r);
            }
            if let Some(mask) = mask {
                signal.iter_mut().zip(mask).for_each(|(s, m)| *s *= m);
            }
            for (i, n) in model.rest_normals[range].iter().enumerate() {
                (0..3).for_each(|c| sum[c][i] += signal[i] * n[c]);
            }
        }
    }
}
