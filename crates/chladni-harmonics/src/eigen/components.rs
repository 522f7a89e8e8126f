//! Pencils with several connected components: S and M are block-diagonal, and each block is a separate
//! problem.

use rayon::prelude::*;

use chladni_task::Task;

use super::plan::inertia;
use super::problem::{Problem, Profile};
use super::{CLUSTER, Solved, Wanted, cluster_end, or_dense, solve_connected};
use crate::platform::Instant;
use crate::{Basis, Certificate, HarmonicsError, Laplacian, Pencil, SymmetricSparse};

/// Relative width of the gap below the common shift in which no component has an eigenvalue.
const GAP: f64 = 1e-6;
/// When the bracket of the common shift is this narrow, its upper end is used.
const NARROW: f64 = 1e-3;
/// The largest number of rounds of counting in the search for the shift.
const ROUNDS: usize = 100;

/// One connected component.
struct Component {
    /// Its vertices in the whole pencil, ascending.
    vertices: Vec<u32>,
    stiffness: SymmetricSparse,
    mass: Vec<f64>,
    consistent: Option<SymmetricSparse>,
    problem: Problem,
}

/// All connected components.
pub(super) struct Components(Vec<Component>);

/// Prior knowledge of the spectrum.
#[derive(Clone, Copy)]
pub(super) enum Kind {
    /// A surface: each component has one eigenvalue 0, and Weyl's law says where the others are.
    Surface,
    /// A pencil that the caller gave; its eigenvalues are about this far apart, and none is 0.
    Given { spacing: f64 },
}

/// A shift, with the number of eigenvalues below it in each component.
struct Shift {
    sigma: f64,
    counts: Vec<usize>,
}

/// Solves for the first pairs of a pencil with several components; `component` holds that of
/// each vertex. Each component is solved for the pairs below a common shift, and the results are merged.
pub(super) fn solve(
    pencil: Pencil,
    component: &[u32],
    kind: Kind,
    wanted: Wanted,
    task: &Task,
) -> Result<Solved, HarmonicsError> {
    task.stage("harmonics", 0);
    let start = Instant::now();
    let components = Components::of(pencil, component, kind)?;
    let fitting = components.0.iter().try_fold(wanted, |room, part| room.fitted(&part.problem.symbolic))?;
    let analyze = start.elapsed().as_secs_f64();
    let solve = || solve_all(components, pencil, fitting, task);
    let mut solved = wanted.on_fewer(fitting, pencil.mass.len(), solve)?;
    solved.profile.analyze += analyze;
    Ok(solved)
}

/// Solves all components where and with as many slices at once as `wanted` says.
fn solve_all(
    components: Components,
    pencil: Pencil,
    wanted: Wanted,
    task: &Task,
) -> Result<Solved, HarmonicsError> {
    let mut profile = Profile::default();
    let start = Instant::now();
    let shift = components.common_shift(wanted.harmonics, &mut profile, task)?;
    profile.plan = start.elapsed().as_secs_f64();
    let stage = task.stage("harmonics", shift.counts.iter().sum::<usize>() as u64);
    // The largest component is solved first: the last to finish is then a small one.
    let mut queue: Vec<(usize, Component)> = components.0.into_iter().enumerate().collect();
    queue.retain(|(c, _)| shift.counts[*c] > 0);
    queue.sort_by_key(|(c, component)| std::cmp::Reverse(component.mass.len() * shift.counts[*c]));
    let mut parts = queue
        .into_iter()
        .par_bridge()
        .map(|(c, component)| {
            let Component { vertices, stiffness, mass, consistent, problem } = component;
            let pencil = Pencil { stiffness: &stiffness, mass: &mass, consistent: consistent.as_ref() };
            let (below, zeros) = (shift.counts[c], problem.zeros);
            // The first K of all are among the first K of each.
            let count = if below > wanted.most { wanted.harmonics } else { below };
            let wanted = Wanted { harmonics: count, whole_clusters: false, most: count, ..wanted };
            let solved = solve_connected(pencil, zeros, Some(problem), wanted, &stage, task);
            let solved = or_dense(solved, pencil, zeros, wanted, task)?;
            if solved.basis.eigenvalues.last().is_some_and(|last| *last > shift.sigma) {
                return Err(HarmonicsError::not_certified(
                    "a component has fewer eigenvalues below a shift than were counted",
                ));
            }
            Ok((c, vertices, solved))
        })
        .collect::<Result<Vec<_>, _>>()?;
    parts.sort_by_key(|(c, ..)| *c);
    let start = Instant::now();
    let parts = parts.into_iter().map(|(_, vertices, solved)| (vertices, solved)).collect();
    let mut merged = merge(pencil, parts, wanted)?;
    merged.profile.add(&profile);
    merged.profile.assemble += start.elapsed().as_secs_f64();
    Ok(merged)
}

impl Components {
    pub(super) fn of(pencil: Pencil, component: &[u32], kind: Kind) -> Result<Self, HarmonicsError> {
        let n = pencil.mass.len();
        let count = component.iter().max().map_or(0, |c| *c as usize + 1);
        let mut vertices: Vec<Vec<u32>> = vec![Vec::new(); count];
        // The index of each vertex within its component.
        let mut local = vec![0; n];
        for (v, &c) in component.iter().enumerate() {
            local[v] = vertices[c as usize].len() as u32;
            vertices[c as usize].push(v as u32);
        }
        let component = |vertices: Vec<u32>| {
            let stiffness = pencil.stiffness.block(&vertices, &local);
            let mass: Vec<f64> = vertices.iter().map(|&v| pencil.mass[v as usize]).collect();
            let consistent = pencil.consistent.map(|m| m.block(&vertices, &local));
            let part = Pencil { stiffness: &stiffness, mass: &mass, consistent: consistent.as_ref() };
            let problem = match kind {
                Kind::Surface => Problem::of(part),
                Kind::Given { spacing } => {
                    let mut problem = Problem::of(part).given(part)?;
                    problem.expect_spacing(spacing * n as f64 / vertices.len() as f64);
                    problem
                }
            };
            Ok(Component { vertices, stiffness, mass, consistent, problem })
        };
        Ok(Self(vertices.into_par_iter().map(component).collect::<Result<_, HarmonicsError>>()?))
    }

    /// The number of eigenvalues below `lambda` in each component.
    fn counts(&self, lambda: f64, profile: &mut Profile) -> Result<Vec<usize>, HarmonicsError> {
        let counted: Vec<_> = self
            .0
            .par_iter()
            .map(|component| {
                let mut profile = Profile::default();
                component.count(lambda, &mut profile).map(|count| (count, profile))
            })
            .collect::<Result<_, _>>()?;
        Ok(counted
            .into_iter()
            .map(|(count, part)| {
                profile.add(&part);
                count
            })
            .collect())
    }

    /// The number of eigenvalues below `lambda`, or slightly beside it if `lambda` is an eigenvalue.
    pub(super) fn count(&self, lambda: f64) -> Result<usize, HarmonicsError> {
        Ok(self.counts(lambda, &mut Profile::default())?.iter().sum())
    }

    /// Rounding moves no count by more than this along the spectrum.
    pub(super) fn resolved(&self) -> f64 {
        self.0.iter().map(|component| component.problem.resolved()).fold(0.0, f64::max)
    }

    /// A shift with at least `wanted` eigenvalues below it (few more unless there is a multiple one) and
    /// none just below it: the cluster of the K-th eigenvalue ends below the shift.
    fn common_shift(
        &self,
        wanted: usize,
        profile: &mut Profile,
        task: &Task,
    ) -> Result<Shift, HarmonicsError> {
        let zeros: usize = self.0.iter().map(|c| c.problem.zeros).sum();
        if wanted <= zeros {
            return Ok(Shift { sigma: 0.0, counts: self.0.iter().map(|c| c.problem.zeros).collect() });
        }
        let slack = 2 + wanted / 32;
        let target = (wanted + slack / 2) as f64;
        let mut bracket = Bracket::of(&self.0, zeros);
        // Weyl's law.
        let area: f64 = self.0.iter().map(|c| c.problem.area).sum();
        let mut sigma = (4.0 * std::f64::consts::PI * (target - zeros as f64) / area).min(bracket.bound);
        for _ in 0..ROUNDS {
            task.check()?;
            let mut profile_beneath = Profile::default();
            let (beneath, counts) = rayon::join(
                || self.counts(sigma * (1.0 - GAP), &mut profile_beneath),
                || self.counts(sigma, profile),
            );
            profile.add(&profile_beneath);
            let (beneath, counts) = (beneath?, counts?);
            let found: usize = counts.iter().sum();
            let fits = found >= wanted && (found <= wanted + slack || bracket.is_narrow());
            if fits && beneath == counts {
                return Ok(Shift { sigma, counts });
            }
            sigma = if fits {
                sigma * (1.0 + 3.0 * GAP)
            } else {
                bracket.narrow(sigma, found as f64, wanted as f64);
                bracket.guess(target)
            };
        }
        Err(HarmonicsError::not_certified("no shift was found that just the lowest eigenvalues lie below"))
    }
}

/// Two values of λ with the counts N(λ) there, between which the wanted count is reached.
struct Bracket {
    low: (f64, f64),
    /// `None` until a count was large enough.
    high: Option<(f64, f64)>,
    /// No eigenvalue is above this.
    bound: f64,
    /// Whether the last step at least halved its width.
    halved: bool,
    /// How far to go beyond `low` while there is no `high`.
    reach: f64,
}

impl Bracket {
    fn of(components: &[Component], zeros: usize) -> Self {
        let bound = 1.01 * components.iter().map(Component::bound).fold(0.0, f64::max);
        Self { low: (0.0, zeros as f64), high: None, bound, halved: true, reach: 1.0 }
    }

    fn is_narrow(&self) -> bool {
        self.high.is_some_and(|high| high.0 - self.low.0 <= NARROW * high.0)
    }

    fn narrow(&mut self, lambda: f64, count: f64, wanted: f64) {
        let width = |bracket: &Self| bracket.high.map_or(f64::INFINITY, |high| high.0 - bracket.low.0);
        let before = width(self);
        if count < wanted {
            self.low = (lambda, count);
        } else {
            self.high = Some((lambda, count));
        }
        self.halved = width(self) <= 0.5 * before;
    }

    /// An estimate of the λ where N is `target`.
    fn guess(&mut self, target: f64) -> f64 {
        let low = self.low;
        match self.high {
            Some(high) if self.is_narrow() => high.0,
            Some(high) if self.halved => {
                low.0 + (high.0 - low.0) * ((target - low.1) / (high.1 - low.1)).min(1.0)
            }
            Some(high) => 0.5 * (low.0 + high.0),
            None => {
                // In proportion to the missing pairs, and farther each time.
                let ahead = self.reach * (target / low.1 - 1.0).clamp(0.02, 3.0);
                self.reach *= 2.0;
                (low.0 * (1.0 + ahead)).min(self.bound)
            }
        }
    }
}

impl Component {
    fn bound(&self) -> f64 {
        Pencil::lumped(&self.stiffness, &self.mass).bound() * self.problem.stretch()
    }

    fn count(&self, lambda: f64, profile: &mut Profile) -> Result<usize, HarmonicsError> {
        // For a tiny component the count is taken higher up: if only λ = 0 lies below that λ, the same
        // holds here.
        let (resolved, zeros) = (self.problem.resolved(), self.problem.zeros);
        if lambda < resolved && inertia(&self.problem, resolved, profile)?.1 == zeros {
            return Ok(zeros);
        }
        Ok(inertia(&self.problem, lambda, profile)?.1)
    }
}

/// Merges the lowest pairs of all components to pairs of the whole, which are zero outside their component.
fn merge(pencil: Pencil, parts: Vec<(Vec<u32>, Solved)>, wanted: Wanted) -> Result<Solved, HarmonicsError> {
    let harmonics = wanted.harmonics;
    let n = pencil.mass.len();
    // (λ, component, index in it); the sort is stable: equal values keep their order.
    let mut entries: Vec<(f64, usize, usize)> = Vec::new();
    for (c, (_, solved)) in parts.iter().enumerate() {
        entries.extend(solved.basis.eigenvalues.iter().enumerate().map(|(k, value)| (*value, c, k)));
    }
    entries.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut eigenvalues: Vec<f64> = entries.iter().map(|e| e.0).collect();
    let cluster_end = cluster_end(&eigenvalues, harmonics);
    let keep = wanted.kept(cluster_end);
    eigenvalues.truncate(keep);
    let last = eigenvalues.last().map_or(0.0, |last| last * (1.0 + CLUSTER));
    let cuts = |basis: &Basis| basis.eigenvalues.last().is_some_and(|own| *own <= last);
    let cuts_cluster =
        keep < cluster_end || parts.iter().any(|(_, part)| part.cuts_cluster && cuts(&part.basis));
    let mut vectors = wanted.vectors(n, keep)?;
    let mut columns: Vec<Vec<&mut [f64]>> = parts.iter().map(|_| Vec::new()).collect();
    // Within a component the pairs are ascending, and its columns keep that order.
    for (column, &(_, c, _)) in vectors.chunks_exact_mut(n).zip(&entries) {
        columns[c].push(column);
    }
    let mut certificate = Certificate {
        laplacian: Laplacian::default(),
        inertia_counts_match: Some(true),
        max_relative_residual: 0.0,
        max_orthogonality_error: 0.0,
    };
    let mut profile = Profile::default();
    let mut fell_back_to_dense = false;
    for (_, solved) in &parts {
        certificate = certificate.and(&solved.basis.certificate);
        profile.add(&solved.profile);
        fell_back_to_dense |= solved.fell_back_to_dense;
    }
    // Each component is freed as soon as it is written: the vectors are in memory only once.
    parts.into_par_iter().zip(columns).with_max_len(1).for_each(|((vertices, solved), columns)| {
        for (column, h) in columns.into_iter().zip(solved.basis.vectors.chunks_exact(vertices.len())) {
            vertices.iter().zip(h).for_each(|(&v, h)| column[v as usize] = *h);
        }
    });
    let basis = Basis { eigenvalues, vectors, mass: pencil.mass.to_vec(), certificate };
    Ok(Solved { basis, cuts_cluster, fell_back_to_dense, short_of_memory: None, profile })
}
