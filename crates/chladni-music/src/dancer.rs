//! A body prepared for dancing: the data that every frame needs.

use std::ops::Range;
use std::sync::Arc;

use chladni_harmonics::{Basis, Body};
use chladni_mesh::Orientation;
use chladni_mesh::surface::Bounds;
use chladni_mesh::surface::vec3::single;
use chladni_synth::Residual;
use rayon::prelude::*;

use crate::probes::{Probes, rest_normals};
use crate::sides::Sides;
use crate::steepness::{Patch, steepness};
use crate::swelling::swelling;
use crate::swing::Swing;
use crate::unison::unisons;
use crate::{Class, Form, MusicError, SymmetrySettings, Timbre, symmetry};

/// The data of one body that the mappings of all items share, in the working frame.
#[derive(Clone, Debug)]
pub struct Dancer {
    /// λ_k, K values.
    pub eigenvalues: Vec<f64>,
    /// x̃_k: the harmonic transform of the rest positions.
    pub spectrum: Vec<[f32; 3]>,
    /// Whether H_k is symmetric, antisymmetric or neither.
    pub classes: Vec<Class>,
    /// χ_L and χ_R.
    pub sides: Sides,
    /// dx: the part of the rest positions above K.
    pub residual: Residual,
    /// Diagonal of the bounding box, the yardstick of every displacement.
    pub box_diagonal: f32,
    /// Where the shape at rest is that its broad movements move farthest.
    pub liveliest: [f32; 3],
    pub(crate) probes: Probes,
    pub(crate) swing: Swing,
    /// The mask of the modal form.
    pub(crate) swelling: Arc<[f32]>,
    /// For each harmonic, the range of those that sound in unison with it.
    unisons: Vec<Range<u32>>,
    /// Reach of one unit of each harmonic in the filter form, with its unison: Σ H_k x̃_k.
    filter_reach: Vec<Reach>,
    /// Reach of one unit of each harmonic in the modal form: H_k n under its mask.
    modal_reach: Vec<Reach>,
    octaves: Vec<u8>,
    /// λ of the slowest wave.
    slowest: f64,
}

/// How far and how steeply one unit of a harmonic moves the shape.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Reach {
    /// Displacement of the most moved vertex.
    pub displacement: f32,
    /// ‖∇u‖, exceeded by at most one triangle in 50.
    pub steepness: f32,
}

/// Triangles on which the steepness of each harmonic is measured.
const PATCHES: usize = 4096;
/// Harmonics in each doubling of their number whose steepest triangle is probed.
const STEEP_PROBES: i32 = 8;
/// Octaves of frequency that are calibrated and limited separately; higher ones count as the last.
const OCTAVES: usize = 16;

impl Dancer {
    /// Prepares `body`, whose harmonics have `classes` (K of them, see [`Symmetry`](crate::Symmetry)) and which
    /// stands as `stands` says: its left half is the viewer's.
    ///
    /// # Errors
    /// The counts differ, or there is no harmonic or no vertex.
    pub fn new(body: &Body, classes: &[Class], stands: &Orientation) -> Result<Self, MusicError> {
        let basis = &*body.basis;
        let k = basis.harmonics();
        if classes.len() != k {
            return Err(MusicError::Size { what: "symmetry classes", found: classes.len(), expected: k });
        }
        if k == 0 || basis.vertices() == 0 {
            return Err(MusicError::Size { what: "harmonics", found: k, expected: 1 });
        }
        if body.positions.len() != basis.vertices() {
            return Err(MusicError::Size {
                what: "positions",
                found: body.positions.len(),
                expected: basis.vertices(),
            });
        }
        let spectrum64 = basis.transform3(&body.positions);
        let smooth = basis.synthesize3(&spectrum64);
        let residual = body
            .positions
            .iter()
            .zip(&smooth)
            .map(|(x, s)| std::array::from_fn(|i| (x[i] - s[i]) as f32))
            .collect();
        let spectrum = single(&spectrum64);
        let runs = unisons(basis, classes, SymmetrySettings::default().cluster_gap);
        let normals = rest_normals(body);
        let box_diagonal = box_diagonal(&body.positions);
        let swelling = swelling(body, &normals, box_diagonal);
        let patches = Patch::among(body, PATCHES);
        let of_runs: Vec<(Reach, Option<Patch>)> =
            runs.par_iter().map(|run| in_unison(basis, &spectrum64, run.clone(), &patches)).collect();
        let of_harmonics: Vec<(Reach, Option<Patch>)> = (0..k)
            .into_par_iter()
            .map(|k| {
                let h = basis.harmonic(k);
                let far = |v: usize| swelling[v] * h[v] as f32;
                let along = |v: u32| normals[v as usize].map(|n| far(v as usize) * n);
                let displacement = (0..h.len()).fold(0.0, |most: f32, v| most.max(far(v).abs()));
                let (steepness, steepest) = steepness(&patches, along);
                (Reach { displacement, steepness }, steepest)
            })
            .collect();
        let unisons = runs.iter().flat_map(|run| vec![run.start as u32..run.end as u32; run.len()]).collect();
        let filter_reach: Vec<Reach> =
            runs.iter().zip(&of_runs).flat_map(|(run, of)| vec![of.0; run.len()]).collect();
        let displacement: Vec<f32> = filter_reach.iter().map(|reach| reach.displacement).collect();
        let modal_reach = of_harmonics.iter().map(|of| of.0).collect();
        let of_unisons: Vec<_> = runs.iter().zip(&of_runs).map(|(run, of)| (run.start, of.1)).collect();
        let of_each: Vec<_> = of_harmonics.iter().map(|of| of.1).enumerate().collect();
        let mut steep = [steepest(&of_unisons), steepest(&of_each)].concat();
        steep.sort_by_key(|(k, _)| *k);
        let probes = Probes::new(body, &displacement, &normals, &steep);
        let sides = Sides::of(body, classes, stands);
        let slowest = symmetry::slowest(&basis.eigenvalues);
        Ok(Self {
            eigenvalues: basis.eigenvalues.clone(),
            swing: Swing::of(body, classes, &sides, &swelling),
            sides,
            probes,
            spectrum,
            classes: classes.to_vec(),
            residual: Residual::Vector(residual),
            box_diagonal,
            swelling,
            liveliest: liveliest(body, &spectrum64, &runs),
            unisons,
            filter_reach,
            modal_reach,
            octaves: octaves(&basis.eigenvalues, slowest),
            slowest,
        })
    }

    /// The same dancer, of the same `body`, which stands otherwise.
    #[must_use]
    pub fn standing(&self, body: &Body, stands: &Orientation) -> Self {
        let sides = Sides::of(body, &self.classes, stands);
        Self { swing: Swing::of(body, &self.classes, &sides, &self.swelling), sides, ..self.clone() }
    }

    /// K.
    pub fn harmonics(&self) -> usize {
        self.eigenvalues.len()
    }

    /// Positions that the picture must have room for: the rest positions, each moved away from the origin by
    /// the largest displacement, `limit` (a share of the bounding box's diagonal).
    pub fn room(&self, rest_positions: &[[f32; 3]], limit: f32) -> Vec<[f32; 3]> {
        let outwards = limit * self.box_diagonal;
        rest_positions.iter().map(|&p| p.map(|c| c * (1.0 + outwards / length(p).max(1e-6)))).collect()
    }

    /// How far and how steeply one unit of harmonic k and its unison moves the shape.
    pub(crate) fn reach(&self, form: Form, k: u32) -> Reach {
        match form {
            Form::Filter | Form::HalfMask => self.filter_reach[k as usize],
            Form::Modal => {
                let partner = self.swing.partner(k).unwrap_or(k);
                let [own, other] = [k, partner].map(|k| self.modal_reach[k as usize]);
                Reach {
                    displacement: own.displacement.max(other.displacement),
                    steepness: own.steepness.max(other.steepness),
                }
            }
        }
    }

    /// Octaves of frequency √λ between the slowest wave and harmonic k.
    pub(crate) fn octave(&self, k: u32) -> usize {
        self.octaves[k as usize].into()
    }

    /// The tone of the resonator bank with which harmonic k rings.
    pub(crate) fn tone(&self, timbre: &Timbre, k: u32) -> u8 {
        timbre.tone(self.eigenvalues[k as usize], self.slowest)
    }

    /// Harmonic k and those of the same eigenvalue and class. Their basis is arbitrary, so the filter form
    /// lets them sound as one.
    pub(crate) fn unison(&self, k: u32) -> Range<u32> {
        self.unisons[k as usize].clone()
    }
}

/// The reach of Σ H_k x̃_k over a run of harmonics, and where it is steepest.
fn in_unison(
    basis: &Basis,
    spectrum: &[[f64; 3]],
    run: Range<usize>,
    patches: &[Patch],
) -> (Reach, Option<Patch>) {
    let mut sum = vec![[0.0f64; 3]; basis.vertices()];
    for k in run {
        for (sum, h) in sum.iter_mut().zip(basis.harmonic(k)) {
            *sum = std::array::from_fn(|i| sum[i] + h * spectrum[k][i]);
        }
    }
    let squares = sum.iter().map(|d| d.iter().map(|c| c * c).sum::<f64>());
    let displacement = squares.fold(0.0, f64::max).sqrt() as f32;
    let (steepness, steepest) = steepness(patches, |v| sum[v as usize].map(|c| c as f32));
    (Reach { displacement, steepness }, steepest)
}

/// Harmonics, besides the constant ones, that count as broad movements.
const BROAD: usize = 24;

/// The position that the harmonics of the longest waves, each at full strength, move farthest.
fn liveliest(body: &Body, spectrum: &[[f64; 3]], runs: &[Range<usize>]) -> [f32; 3] {
    let basis = &*body.basis;
    let first = symmetry::first_waving(&basis.eigenvalues);
    let mut moved = vec![0.0f64; basis.vertices()];
    // By whole unisons: the choice of harmonics within one is arbitrary.
    for run in runs.iter().filter(|run| (first..first + BROAD).contains(&run.start)) {
        for (v, moved) in moved.iter_mut().enumerate() {
            let along = |i: usize| run.clone().map(|k| basis.harmonic(k)[v] * spectrum[k][i]).sum::<f64>();
            *moved += (0..3).map(|i| along(i).powi(2)).sum::<f64>();
        }
    }
    let most = (0..moved.len()).max_by(|&a, &b| moved[a].total_cmp(&moved[b])).unwrap_or(0);
    body.positions.get(most).map_or([0.0; 3], |p| p.map(|c| c as f32))
}

/// Of harmonics (or the first of their unison) that are spaced evenly in the logarithm of their number: the
/// steepest patches.
fn steepest(of: &[(usize, Option<Patch>)]) -> Vec<(u32, Patch)> {
    let number = |i: i32| 2f64.powf(f64::from(i) / f64::from(STEEP_PROBES)).round() as usize;
    let mut numbers: Vec<usize> = (0..).map(number).take_while(|&number| number < of.len()).collect();
    numbers.dedup();
    numbers.into_iter().filter_map(|i| Some((of[i].0 as u32, of[i].1?))).collect()
}

fn octaves(eigenvalues: &[f64], slowest: f64) -> Vec<u8> {
    let octave = |l: &f64| (0.5 * (l / slowest).max(1.0).log2()).min(OCTAVES as f64 - 1.0) as u8;
    eigenvalues.iter().map(octave).collect()
}

fn length(v: [f32; 3]) -> f32 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}

pub(crate) fn box_diagonal(positions: &[[f64; 3]]) -> f32 {
    Bounds::of(positions.iter().copied()).diagonal() as f32
}
