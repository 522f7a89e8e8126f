//! A few well-chosen places at which, before synthesis, an item's displacement and steepness are measured.

use chladni_harmonics::Body;
use chladni_mesh::surface::vec3::single;
use chladni_synth::{Coefficients, Item, Residual, Term};

use crate::Class;
use crate::steepness::Patch;

/// Vertices at the extremes of the broad harmonics that move the shape most, and far from each other;
/// and the corners of triangles, evenly spread ones and those that some harmonic bends most.
///
/// Which of them judge an item depends on the harmonics that it moves, not on how many there are: the same
/// waves are limited alike whatever K.
#[derive(Clone, Debug)]
pub(crate) struct Probes {
    vertices: Vec<u32>,
    /// H at the probes: K rows of `vertices.len()`.
    harmonics: Vec<f32>,
    normals: Vec<[f32; 3]>,
    /// How many of the vertices belong to no patch; the corners of the patches follow them.
    spots: usize,
    patches: Vec<Patch>,
    /// For each patch the lowest harmonic that may fold it, ascending: 0 for those that are evenly spread.
    from: Vec<u32>,
}

/// The largest displacement and steepness of an item or a part of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    pub displacement: f32,
    pub steepness: f32,
}

const COUNT: usize = 64;
/// Harmonics whose extremes are probed, those first that move the shape most.
const BROAD: usize = 32;
/// The number of evenly spread patches.
const PATCHES: usize = 64;

impl Probes {
    /// `unit[k]`: how far harmonic k moves the shape. `steep`: harmonics, ascending, and the patches that they
    /// bend most.
    pub(crate) fn new(body: &Body, unit: &[f32], normals: &[[f32; 3]], steep: &[(u32, Patch)]) -> Self {
        let n = body.positions.len();
        let mut order: Vec<usize> = (0..unit.len().min(BROAD)).collect();
        order.sort_by(|&i, &j| unit[j].total_cmp(&unit[i]).then(i.cmp(&j)));
        let mut vertices: Vec<u32> = Vec::with_capacity(COUNT + 3 * (PATCHES + steep.len()));
        for k in order {
            if vertices.len() >= COUNT * 3 / 4 {
                break;
            }
            let h = body.basis.harmonic(k);
            let by = |i: &usize, j: &usize| h[*i].total_cmp(&h[*j]);
            for v in [(0..n).max_by(by), (0..n).min_by(by)].into_iter().flatten() {
                if !vertices.contains(&(v as u32)) {
                    vertices.push(v as u32);
                }
            }
        }
        chladni_mesh::surface::spread(&body.positions, &mut vertices, COUNT.min(n));
        let spots = vertices.len();
        let mut patches = Patch::among(body, PATCHES);
        let mut from = vec![0; patches.len()];
        for (k, patch) in steep {
            if !patches.iter().any(|p| p.corners == patch.corners) {
                patches.push(*patch);
                from.push(*k);
            }
        }
        vertices.extend(patches.iter().flat_map(|patch| patch.corners));
        let harmonics = (0..body.basis.harmonics())
            .flat_map(|k| {
                let h = body.basis.harmonic(k);
                vertices.iter().map(|&v| h[v as usize] as f32).collect::<Vec<_>>()
            })
            .collect();
        let normals = vertices.iter().map(|&v| normals[v as usize]).collect();
        Self { vertices, harmonics, normals, spots, patches, from }
    }

    pub(crate) fn count(&self) -> usize {
        self.vertices.len()
    }

    /// The largest displacement of a probe under `terms`. `scratch` keeps its memory between
    /// calls; nothing else is allocated.
    pub(crate) fn displacement(&self, terms: &[Term], scratch: &mut Vec<[f32; 3]>) -> f32 {
        let [part, total] = fields::<2>(scratch, self.count());
        self.sum(terms, part, total);
        farthest(total)
    }

    /// Adds to `out` the displacements and gradients of an item as shares of the limits; the squares of each
    /// kind are divided by the number of places, so that they add up to a mean.
    pub(crate) fn feel(&self, item: &Item, limits: Limits, scratch: &mut Vec<[f32; 3]>, out: &mut Vec<f32>) {
        let [part, total] = fields::<2>(scratch, self.count());
        self.sum(&item.terms, part, total);
        let (spots, corners) = total.split_at(self.spots);
        let scale = 1.0 / (limits.displacement * (spots.len().max(1) as f32).sqrt());
        out.extend(spots.as_flattened().iter().map(|d| scale * d));
        let scale = 1.0 / (limits.steepness * (self.patches.len().max(1) as f32).sqrt());
        for (patch, u) in self.patches.iter().zip(corners.chunks_exact(3)) {
            out.extend(patch.gradient([u[0], u[1], u[2]]).as_flattened().iter().map(|g| scale * g));
        }
    }

    /// Scales each of the `groups` of harmonics in each term so that it keeps `limits` by itself, then the
    /// whole item so that the sum keeps them; so a loud group does not silence a soft one. Returns the
    /// largest share of the limits that any of these reached before scaling. Allocates nothing but `scratch`.
    ///
    /// Where `swinging` has the harmonics' classes, antisymmetric ones swing toward one side, and each movement is judged
    /// toward the other, too: the triangles of the two halves differ, but sound from either side has the same limit.
    pub(crate) fn soften(
        &self,
        item: &mut Item,
        groups: &[Vec<u32>],
        swinging: Option<&[Class]>,
        limits: Limits,
        scratch: &mut Vec<[f32; 3]>,
    ) -> f32 {
        let highest = groups.iter().filter_map(|group| group.last()).max().copied().unwrap_or(0);
        let judging = self.from.partition_point(|&from| from <= highest);
        let [part, other_part, total, other_total] = fields::<4>(scratch, self.spots + 3 * judging);
        let (mut parts, mut totals) = ([part, other_part], [total, other_total]);
        let ways = if swinging.is_some() { 2 } else { 1 };
        let (parts, totals) = (&mut parts[..ways], &mut totals[..ways]);
        let sign = |way: usize, k: usize| {
            let class = swinging.and_then(|classes| classes.get(k));
            if way == 1 && class == Some(&Class::Antisymmetric) { -1.0 } else { 1.0 }
        };
        let mut most = 0.0f32;
        for term in &mut item.terms {
            for group in groups {
                for (way, part) in parts.iter_mut().enumerate() {
                    self.field(term, group.iter().copied(), |k| sign(way, k), part);
                }
                // Measured without a half's mask, so that halves that play the same are limited the same.
                let reach = parts.iter().map(|part| self.reach(part, limits)).fold(0.0, f32::max);
                let scale = soft_limit(reach);
                if scale < 1.0 {
                    scale_group(&mut term.coefficients, group, scale);
                }
                most = most.max(reach);
                for (part, total) in parts.iter_mut().zip(totals.iter_mut()) {
                    self.mask(term, part);
                    add(total, part, scale);
                }
            }
            for (part, total) in parts.iter_mut().zip(totals.iter_mut()) {
                self.residual(term, part);
                add(total, part, 1.0);
            }
        }
        let reach = totals.iter().map(|total| self.reach(total, limits)).fold(0.0, f32::max);
        let scale = soft_limit(reach);
        if scale < 1.0 {
            item.terms.iter_mut().for_each(|term| scale_term(term, scale));
        }
        most.max(reach)
    }

    /// Adds all `terms` to `total`.
    fn sum(&self, terms: &[Term], part: &mut [[f32; 3]], total: &mut [[f32; 3]]) {
        for term in terms {
            let count = match &term.coefficients {
                Coefficients::Vector(c) => c.len(),
                Coefficients::Normal(c) => c.len(),
            };
            self.field(term, 0..count as u32, |_| 1.0, part);
            self.mask(term, part);
            add(total, part, 1.0);
            self.residual(term, part);
            add(total, part, 1.0);
        }
    }

    /// The displacement by some harmonics of a term, each times its `sign`, without the mask of a half.
    fn field(
        &self,
        term: &Term,
        harmonics: impl Iterator<Item = u32>,
        sign: impl Fn(usize) -> f32,
        out: &mut [[f32; 3]],
    ) {
        let p = self.count();
        out.fill([0.0; 3]);
        for k in harmonics.map(|k| k as usize) {
            let Some(row) = self.harmonics.get(k * p..(k + 1) * p) else { continue };
            match &term.coefficients {
                Coefficients::Vector(c) => {
                    let c = c.get(k).copied().unwrap_or_default().map(|c| sign(k) * c);
                    if c != [0.0; 3] {
                        out.iter_mut().zip(row).for_each(|(d, h)| (0..3).for_each(|i| d[i] += h * c[i]));
                    }
                }
                Coefficients::Normal(c) => {
                    let c = sign(k) * c.get(k).copied().unwrap_or_default();
                    if c != 0.0 {
                        out.iter_mut().zip(row).for_each(|(d, h)| d[0] += h * c);
                    }
                }
            }
        }
        self.turn(term, out);
    }

    /// The displacement by the residual of a term, with its mask.
    fn residual(&self, term: &Term, out: &mut [[f32; 3]]) {
        let g = term.residual_gain;
        out.fill([0.0; 3]);
        if g == 0.0 {
            return;
        }
        for (d, &v) in out.iter_mut().zip(&self.vertices) {
            match &term.residual {
                Some(Residual::Vector(r)) => {
                    *d = r.get(v as usize).copied().unwrap_or_default().map(|c| g * c);
                }
                Some(Residual::Normal(r)) => d[0] = g * r.get(v as usize).copied().unwrap_or_default(),
                None => {}
            }
        }
        self.turn(term, out);
        self.mask(term, out);
    }

    /// Turns amplitudes into displacements along the normals, under their mask, where the term is in normal form.
    fn turn(&self, term: &Term, field: &mut [[f32; 3]]) {
        if matches!(term.coefficients, Coefficients::Normal(_)) {
            for ((d, normal), v) in field.iter_mut().zip(&self.normals).zip(&self.vertices) {
                let weight = weight(term, *v);
                *d = normal.map(|n| weight * (d[0] * n));
            }
        }
    }

    /// Puts a movement under the mask of its half. In normal form the mask is part of the movement.
    fn mask(&self, term: &Term, field: &mut [[f32; 3]]) {
        if matches!(term.coefficients, Coefficients::Vector(_)) {
            for (d, v) in field.iter_mut().zip(&self.vertices) {
                let weight = weight(term, *v);
                *d = d.map(|c| weight * c);
            }
        }
    }

    /// The share of the limits that a movement of the probes reaches.
    fn reach(&self, field: &[[f32; 3]], limits: Limits) -> f32 {
        let corners = &field[self.spots..];
        let steepest = (self.patches.iter().zip(corners.chunks_exact(3)))
            .map(|(patch, u)| patch.steepness([u[0], u[1], u[2]]))
            .fold(0.0, f32::max);
        (farthest(field) / limits.displacement).max(steepest / limits.steepness)
    }
}

/// The mask of a term at vertex v.
fn weight(term: &Term, v: u32) -> f32 {
    term.mask.as_ref().and_then(|mask| mask.get(v as usize)).copied().unwrap_or(1.0)
}

/// N fields over the first `count` probes, at rest.
fn fields<const N: usize>(scratch: &mut Vec<[f32; 3]>, count: usize) -> [&mut [[f32; 3]]; N] {
    scratch.clear();
    scratch.resize(N * count, [0.0; 3]);
    let mut fields = scratch.chunks_exact_mut(count.max(1));
    std::array::from_fn(|_| fields.next().unwrap_or_default())
}

fn add(total: &mut [[f32; 3]], part: &[[f32; 3]], scale: f32) {
    total.iter_mut().zip(part).for_each(|(t, p)| (0..3).for_each(|i| t[i] += scale * p[i]));
}

fn farthest(field: &[[f32; 3]]) -> f32 {
    field.iter().map(|d| d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).fold(0.0, f32::max).sqrt()
}

fn scale_group(coefficients: &mut Coefficients, group: &[u32], scale: f32) {
    for &k in group {
        match coefficients {
            Coefficients::Vector(c) => c[k as usize] = c[k as usize].map(|x| scale * x),
            Coefficients::Normal(c) => c[k as usize] *= scale,
        }
    }
}

/// Scales the movement of a term.
pub(crate) fn scale_term(term: &mut Term, scale: f32) {
    match &mut term.coefficients {
        Coefficients::Vector(c) => c.iter_mut().for_each(|c| *c = c.map(|x| scale * x)),
        Coefficients::Normal(c) => c.iter_mut().for_each(|c| *c *= scale),
    }
    term.residual_gain *= scale;
}

/// The factor for a movement that reaches `reach` times its limit: 1 up to half the limit, then falling
/// smoothly so that the limit is never reached.
pub(crate) fn soft_limit(reach: f32) -> f32 {
    if reach <= 0.5 {
        return 1.0;
    }
    (0.5 + 0.5 * (2.0 * reach - 1.0).tanh()) / reach
}

/// Area-weighted rest normals of all vertices, zero where there is none.
pub(crate) fn rest_normals(body: &Body) -> Vec<[f32; 3]> {
    single(&chladni_mesh::surface::vertex_normals(&body.positions, &body.triangles))
}
