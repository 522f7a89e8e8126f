//! `chladni-bench limbs`: how well the limbs of shapes are found whose limbs are known, and whether noise, other triangles
//! and another pose change them.

use std::collections::BTreeMap;

use chladni_caricature::Limbs;
use chladni_harmonics::{BasisSettings, Body};
use chladni_mesh::surface::details;
use chladni_mesh::surface::vec3::{add, distance, scaled, single, unit};
use chladni_mesh::{TriMesh, samples};
use chladni_task::Task;

use chladni_program::cli::Terminal;
use chladni_program::work::{Error, Watcher};

/// Measure how well limbs are found whose places are known.
#[derive(clap::Args)]
pub struct BenchLimbs {}

/// A shape and the number of the limb of each vertex; 0 is the trunk.
#[derive(Clone)]
struct Known {
    mesh: TriMesh,
    limb: Vec<u8>,
}

/// The limbs found on one shape.
struct Found {
    parts: usize,
    /// For each known limb, and the trunk, the best intersection over union, by area, with a part that was found.
    overlaps: Vec<f64>,
    /// The share of the area whose part at level 0.6 lies in one part of level 0.3, to nine tenths.
    nested: f64,
}

impl BenchLimbs {
    /// Prints a row of a Markdown table for each shape and change.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        for (shape, known) in shapes() {
            for (change, known) in changed(&known) {
                let Found { parts, overlaps, nested } =
                    terminal.watch("limbs", |task| found(&known, task))?;
                let least = overlaps.iter().copied().fold(1.0, f64::min);
                let mean = overlaps.iter().sum::<f64>() / overlaps.len() as f64;
                let (limbs, nested) = (overlaps.len(), 100.0 * nested);
                terminal.result(format_args!(
                    "| {shape} | {change} | {limbs} | {parts} | {least:.2} | {mean:.2} | {nested:.0} |"
                ))?;
            }
        }
        Ok(())
    }
}

fn shapes() -> Vec<(&'static str, Known)> {
    let octopus = samples::sample("octopus").and_then(|mesh| {
        let limb = samples::limbs("octopus", &mesh)?;
        Some(Known { mesh, limb })
    });
    let axis = |x: f64, y: f64, z: f64| unit([x, y, z]);
    let all = [
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -1.0],
    ];
    let even: Vec<_> = all.map(|a| (a, 0.18, 2.0)).into();
    // Four legs, a tail and a thick neck, as of an animal.
    let animal = [
        (axis(0.7, -0.8, 0.3), 0.16, 1.6),
        (axis(0.7, -0.8, -0.3), 0.16, 1.6),
        (axis(-0.7, -0.8, 0.3), 0.16, 1.6),
        (axis(-0.7, -0.8, -0.3), 0.16, 1.6),
        (axis(-1.0, 0.35, 0.0), 0.12, 1.2),
        (axis(0.9, 0.6, 0.0), 0.26, 1.4),
    ];
    let uneven = [
        (axis(1.0, 0.2, 0.0), 0.3, 1.0),
        (axis(-0.3, 1.0, 0.2), 0.2, 1.8),
        (axis(0.0, -0.4, -1.0), 0.14, 1.4),
    ];
    octopus
        .map(|octopus| ("octopus", octopus))
        .into_iter()
        .chain([("ball with six spikes", spikes(&even)), ("ball with legs, tail and neck", spikes(&animal))])
        .chain([("ball with three spikes of three kinds", spikes(&uneven))])
        .collect()
}

/// A ball with spikes: each along an axis (unit), of a width and a height in radii.
fn spikes(spikes: &[([f64; 3], f64, f64)]) -> Known {
    let mut mesh = samples::icosphere(5);
    let mut limb = Vec::with_capacity(mesh.positions.len());
    for p in &mut mesh.positions {
        let rises = spikes
            .iter()
            .map(|(axis, width, height)| height * (-(distance(*p, *axis) / width).powi(4)).exp());
        let (spike, rise) =
            rises.zip(1_u8..).fold((0, 0.0), |best, (rise, i)| if rise > best.1 { (i, rise) } else { best });
        // A spike begins where it has risen by a tenth of a radius.
        limb.push(if rise > 0.1 { spike } else { 0 });
        *p = scaled(*p, 1.0 + rise);
    }
    Known { mesh, limb }
}

/// The shape as it is, with noise of 0.4 % of its half width, with a third of its triangles split, with a third of its
/// vertices and triangles anew, and twisted about its upright axis, by 43° where it is widest.
fn changed(known: &Known) -> [(&'static str, Known); 5] {
    let half = known.mesh.positions.as_flattened().iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let mut noisy = known.clone();
    for (i, x) in noisy.mesh.positions.iter_mut().flatten().enumerate() {
        *x += 0.004 * half * noise(i);
    }
    let mut split = known.clone();
    for t in (0..known.mesh.triangles.len()).filter(|t| noise(*t) > 0.33) {
        let [a, b, c] = known.mesh.triangles[t];
        let new = split.mesh.positions.len() as u32;
        let at = |v: u32| known.mesh.positions[v as usize];
        split.mesh.positions.push(scaled(add(add(at(a), at(b)), at(c)), 1.0 / 3.0));
        split.limb.push(known.limb[a as usize]);
        split.mesh.triangles[t] = [a, b, new];
        split.mesh.triangles.extend([[b, c, new], [c, a, new]]);
    }
    let mut posed = known.clone();
    for p in &mut posed.mesh.positions {
        let turn: f64 = (p[0].hypot(p[2]) / half - 0.25).max(0.0);
        let (s, c) = turn.sin_cos();
        *p = [c * p[0] + s * p[2], p[1] + 0.15 * half * turn, c * p[2] - s * p[0]];
    }
    [
        ("as it is", known.clone()),
        ("noise", noisy),
        ("a third of the triangles split", split),
        ("a third of the vertices", coarser(known)),
        ("another pose", posed),
    ]
}

/// The shape with a third of its vertices.
fn coarser(known: &Known) -> Known {
    let all = single(&known.mesh.positions);
    let detail = details(&all, &known.mesh.triangles, &[all.len() / 3]).pop();
    let (mut positions, mut limb, mut number) = (Vec::new(), Vec::new(), BTreeMap::new());
    let mut kept = |v: u32| {
        *number.entry(v).or_insert_with(|| {
            positions.push(known.mesh.positions[v as usize]);
            limb.push(known.limb[v as usize]);
            limb.len() as u32 - 1
        })
    };
    let triangles = detail.iter().flat_map(|detail| &detail.triangles).map(|t| t.map(&mut kept)).collect();
    Known { mesh: TriMesh { positions, triangles, ..TriMesh::default() }, limb }
}

/// A number in [−1, 1] for each index.
fn noise(i: usize) -> f64 {
    let x = (i as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    ((x ^ (x >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 40) as f64 / f64::from(1_u32 << 23) - 1.0
}

fn found(known: &Known, task: &Task) -> Result<Found, Error> {
    let body = Body::build(&known.mesh, &BasisSettings::new(Limbs::HARMONICS), task)?;
    let limbs = Limbs::of(&body, Limbs::USUAL_LEVEL);
    let mass = &body.basis.mass;
    let count = usize::from(known.limb.iter().copied().max().unwrap_or(0)) + 1;
    let own: Vec<u32> = known.limb.iter().map(|limb| u32::from(*limb)).collect();
    let shared = shared_areas(&own, count, &limbs.part, limbs.parts.len(), mass);
    let best = |i: usize| (0..limbs.parts.len()).map(|j| overlap(&shared, i, j)).fold(0.0, f64::max);
    let finer = Limbs::of(&body, 0.6);
    let within = shared_areas(&finer.part, finer.parts.len(), &limbs.part, limbs.parts.len(), mass);
    let whole: f64 = mass.iter().sum();
    let nested = within.iter().map(|row| (row.iter().sum::<f64>(), row.iter().copied().fold(0.0, f64::max)));
    let nested: f64 = nested.filter(|(area, most)| *most >= 0.9 * area).map(|(area, _)| area).sum();
    Ok(Found { parts: limbs.parts.len(), overlaps: (0..count).map(best).collect(), nested: nested / whole })
}

/// Intersection over union of label `i` of one and `j` of the other, by the areas that they share.
pub fn overlap(shared: &[Vec<f64>], i: usize, j: usize) -> f64 {
    let (row, column): (f64, f64) = (shared[i].iter().sum(), shared.iter().map(|row| row[j]).sum());
    shared[i][j] / (row + column - shared[i][j])
}

/// The area that each of `m` labels in `a` shares with each of `n` in `b`.
pub fn shared_areas(a: &[u32], m: usize, b: &[u32], n: usize, mass: &[f64]) -> Vec<Vec<f64>> {
    let mut shared = vec![vec![0.0; n]; m];
    for ((a, b), mass) in a.iter().zip(b).zip(mass) {
        shared[*a as usize][*b as usize] += mass;
    }
    shared
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_mesh::surface::vec3::dot;

    #[test]
    fn known_limbs_are_found_whatever_the_noise_the_triangles_and_the_pose() {
        for (shape, known) in shapes() {
            for (change, known) in changed(&known) {
                let Found { parts, overlaps, nested } = found(&known, &Task::new()).unwrap();
                assert!(overlaps.iter().all(|o| *o > 0.8), "{shape}, {change}: {overlaps:.2?}");
                assert!(parts >= overlaps.len(), "{shape}, {change}: {parts}");
                assert!((0.0..=1.0 + 1e-9).contains(&nested));
            }
        }
    }

    #[test]
    fn a_spike_is_as_high_and_as_wide_as_it_was_asked_for() {
        let up = [0.0, 0.0, 1.0];
        let Known { mesh, limb } = spikes(&[(up, 0.2, 1.5)]);
        let top = mesh.positions.iter().map(|p| dot(*p, up)).fold(0.0, f64::max);
        assert!((top - 2.5).abs() < 0.05, "{top}");
        let far = mesh.positions.iter().zip(&limb).filter(|(_, limb)| **limb == 1);
        assert!(far.clone().count() > 20 && far.clone().all(|(p, _)| distance(unit(*p), up) < 0.3));
    }
}
