//! The parts of any shape, from whole limbs to small features, by how heat stays in them.
//!
//! Of the heat that starts at a point v, the share k_t(v, v) remains after a time t: much at the tip of a part that
//! stands out farther than √t, little on a trunk. Limbs are the hills of its logarithm that rise higher than a
//! threshold above the pass to the next hill (persistence: Skraba, Ovsjanikov, Chazal & Guibas, "Persistence-based
//! segmentation of deformable shapes", 2010), cut where that is shortest near the pass, rather in a crease than across a
//! bulge; the rest is trunk.

mod creases;

use std::sync::Arc;

use chladni_harmonics::Body;
use chladni_mesh::MirrorPlane;
use chladni_mesh::surface::vec3::{Vec3, add, distance, scaled};
use chladni_mesh::surface::{Rows, vertex_neighbors};

use self::creases::Creases;
use crate::Painted;

/// The parts of a shape at one level.
#[derive(Clone, Debug, PartialEq)]
pub struct Limbs {
    /// For each of the N vertices its part, an index of `parts`.
    pub part: Vec<u32>,
    /// From the largest to the smallest.
    pub parts: Vec<Limb>,
}

/// One of the [`Limbs`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limb {
    /// Its share of the area, in (0, 1].
    pub share: f64,
    /// How far it stands out: the logarithm of how many times more heat stays at its tip than where it meets the next.
    /// 0 of a trunk.
    pub persistence: f64,
    /// Its middle, working frame.
    pub middle: Vec3,
}

impl Limb {
    /// Whether it is left over where all limbs are taken.
    pub fn is_trunk(&self) -> bool {
        self.persistence <= 0.0
    }
}

/// The time at level 0, in squares of the size √(A / π), and the factor on it at level 1.
const TIME: [f64; 2] = [0.25, 0.04];
/// The same of the persistence from which on a hill is a limb.
const PERSISTENCE: [f64; 2] = [0.5, 0.2];
/// Where a limb may end, in shares of its height above its pass.
const ABOUT: [f64; 2] = [-0.15, 0.15];
/// If a limb's cut does not become longer by this factor on the way down to where it may end, there is no trunk: the
/// limb meets other limbs and ends there.
const MEETS: f64 = 2.2;
/// A flat hill beside a limb that is larger than this, as a share of the limb's area, belongs to the trunk, not to
/// the limb.
const TRUNK: f64 = 0.5;
/// The smallest trunk, as a share of the whole area; less belongs to a limb.
const SCRAP: f64 = 0.01;

impl Limbs {
    /// The level at which the limbs of animals and the parts of faces are found.
    pub const USUAL_LEVEL: f64 = 0.3;
    /// Harmonics that are enough for every level.
    pub const HARMONICS: usize = 256;

    /// The parts of `body` at `level`, from 0 (whole limbs) to 1 (small features); clamped.
    pub fn of(body: &Body, level: f64) -> Self {
        let level = level.clamp(0.0, 1.0);
        let at = |[zero, factor]: [f64; 2]| zero * factor.powf(level);
        let warmth = warmth(body, at(TIME));
        let neighbors = vertex_neighbors(body.positions.len(), &body.triangles);
        let mass = &body.basis.mass;
        let hills = Hills::climbed(&warmth, &neighbors, mass, at(PERSISTENCE));
        let mut label = hills.limbs(&warmth, &neighbors, &Creases::of(body));
        sweep_scraps(&mut label, &neighbors, mass, &hills.tips);
        Self::numbered(body, &label, &neighbors, &hills)
    }

    /// Numbers the connected pieces of one label, the largest first.
    fn numbered(body: &Body, label: &[u32], neighbors: &Rows, hills: &Hills) -> Self {
        let (piece, count) = pieces(label, neighbors);
        let total: f64 = body.basis.mass.iter().sum();
        let mut parts = vec![Limb { share: 0.0, persistence: 0.0, middle: [0.0; 3] }; count];
        for (v, piece) in piece.iter().enumerate() {
            let (part, mass) = (&mut parts[*piece as usize], body.basis.mass[v]);
            part.share += mass / total;
            part.middle = add(part.middle, scaled(body.positions[v], mass / total));
            let hill = (label[v] as usize).checked_sub(1).and_then(|hill| hills.tips.get(hill));
            part.persistence = hill.map_or(0.0, |tip| tip.height);
        }
        parts.iter_mut().for_each(|part| part.middle = scaled(part.middle, 1.0 / part.share));
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by(|a, b| parts[*b].share.total_cmp(&parts[*a].share));
        let mut number = vec![0; count];
        order.iter().zip(0..).for_each(|(old, new)| number[*old] = new);
        let part = piece.into_iter().map(|piece| number[piece as usize]).collect();
        Self { part, parts: order.into_iter().map(|old| parts[old]).collect() }
    }

    /// For each part the other one that is its mirror image in `plane`, where there is one: as large, and its middle
    /// within a twentieth of the shape's half size of where the image says.
    pub fn twins(&self, plane: &MirrorPlane) -> Vec<Option<usize>> {
        const NEAR: f64 = 0.05;
        let nearest = |i: usize| {
            let image = plane.image(self.parts[i].middle);
            let far = |j: &usize| distance(self.parts[*j].middle, image);
            let all = (0..self.parts.len()).filter(|j| far(j) < NEAR);
            all.min_by(|a, b| far(a).total_cmp(&far(b)))
        };
        let alike = |i: usize, j: usize| {
            let ratio = self.parts[i].share / self.parts[j].share;
            i != j && (0.7..1.4).contains(&ratio) && nearest(j) == Some(i)
        };
        (0..self.parts.len()).map(|i| nearest(i).filter(|j| alike(i, *j))).collect()
    }

    /// χ01 of some of the parts.
    pub fn painted(&self, parts: &[usize]) -> Painted {
        let value = |part: &u32| f32::from(u8::from(parts.contains(&(*part as usize))));
        Painted::Vertices(self.part.iter().map(value).collect::<Arc<[f32]>>())
    }
}

/// ln(A k_t(v, v)) with t in squares of the size √(A / π): 0 where heat is spread evenly.
fn warmth(body: &Body, time: f64) -> Vec<f64> {
    let area: f64 = body.basis.mass.iter().sum();
    let mut stays = vec![0.0; body.positions.len()];
    // More would move the limbs a little: they have the same numbers on any body with enough.
    for (k, eigenvalue) in body.basis.eigenvalues.iter().take(Limbs::HARMONICS).enumerate() {
        let left = area * (-eigenvalue * time * area / std::f64::consts::PI).exp();
        for (sum, h) in stays.iter_mut().zip(body.basis.harmonic(k)) {
            *sum += left * h * h;
        }
    }
    stays.into_iter().map(|x| x.max(f64::MIN_POSITIVE).ln()).collect()
}

/// The hills of a function on vertices.
struct Hills {
    /// For each vertex the hill on which it lies, named by its highest vertex.
    hill: Vec<u32>,
    /// The hills that are high enough, highest vertex first.
    tips: Vec<Tip>,
}

struct Tip {
    vertex: u32,
    /// Above the pass.
    height: f64,
    /// The value at the pass.
    pass: f64,
}

impl Hills {
    /// From the highest vertex down: each joins the hill of its highest neighbor. Where two hills meet, the lower is a
    /// part of the higher one, unless it is high enough itself, or, being large, is a trunk beside a limb.
    fn climbed(warmth: &[f64], neighbors: &Rows, mass: &[f64], enough: f64) -> Self {
        let n = warmth.len();
        let mut order: Vec<u32> = (0..n as u32).collect();
        order.sort_by(|a, b| warmth[*b as usize].total_cmp(&warmth[*a as usize]).then(a.cmp(b)));
        let mut rank = vec![0_u32; n];
        order.iter().zip(0..).for_each(|(v, r)| rank[*v as usize] = r);
        let mut parent: Vec<u32> = (0..n as u32).collect();
        let (mut area, mut pass) = (mass.to_vec(), vec![f64::NAN; n]);
        for &v in &order {
            let own = rank[v as usize];
            let higher = || neighbors.row(v as usize).iter().copied().filter(|w| rank[*w as usize] < own);
            let Some(up) = higher().min_by_key(|w| rank[*w as usize]) else { continue };
            let hill = root(&mut parent, up);
            parent[v as usize] = hill;
            area[hill as usize] += mass[v as usize];
            for w in higher() {
                let (a, b) = (root(&mut parent, w), root(&mut parent, v));
                if a == b {
                    continue;
                }
                let (low, high) = if rank[a as usize] > rank[b as usize] { (a, b) } else { (b, a) };
                let [low_height, high_height] =
                    [low, high].map(|tip| warmth[tip as usize] - warmth[v as usize]);
                let is_trunk = area[low as usize] > TRUNK * area[high as usize];
                if low_height >= enough || (is_trunk && high_height >= enough) {
                    for tip in [low, high] {
                        let pass = &mut pass[tip as usize];
                        *pass = pass.max(warmth[v as usize]);
                    }
                } else {
                    parent[low as usize] = high;
                    area[high as usize] += area[low as usize];
                }
            }
        }
        let hill: Vec<u32> = (0..n as u32).map(|v| root(&mut parent, v)).collect();
        let mut lowest = vec![f64::INFINITY; n];
        for (hill, w) in hill.iter().zip(warmth) {
            lowest[*hill as usize] = lowest[*hill as usize].min(*w);
        }
        let tip = |vertex: &u32| {
            let v = *vertex as usize;
            // A hill that meets no other ends at its foot.
            let pass = if pass[v].is_nan() { lowest[v] } else { pass[v] };
            Tip { vertex: *vertex, height: warmth[v] - pass, pass }
        };
        let tips = order.iter().filter(|v| hill[**v as usize] == **v).map(tip);
        let tips = tips.filter(|tip| tip.height >= enough).collect();
        Self { hill, tips }
    }

    /// For each vertex the number of its limb, from 1, or 0 on a trunk. A limb ends near its pass, where its cut is the
    /// shortest for its area, or below it where it meets the next limb.
    fn limbs(&self, warmth: &[f64], neighbors: &Rows, creases: &Creases<'_>) -> Vec<u32> {
        let mut number = vec![0_u32; self.hill.len()];
        self.tips.iter().zip(1..).for_each(|(tip, i)| number[tip.vertex as usize] = i);
        let mut members: Vec<Vec<u32>> = vec![Vec::new(); self.tips.len()];
        for (v, hill) in (0..).zip(&self.hill) {
            if let Some(limb) = (number[*hill as usize] as usize).checked_sub(1) {
                members[limb].push(v);
            }
        }
        let mut label = vec![0; self.hill.len()];
        for ((tip, mut hill), limb) in self.tips.iter().zip(members).zip(1..) {
            hill.sort_by(|a, b| warmth[*b as usize].total_cmp(&warmth[*a as usize]).then(a.cmp(b)));
            let reach = ABOUT.map(|share| tip.pass + share * tip.height);
            let (mut area, mut least, mut taken) = (0.0, f64::INFINITY, 0);
            let (mut cut, mut cuts) = (0.0, Vec::with_capacity(hill.len()));
            for (count, v) in (1..).zip(&hill) {
                let v = *v as usize;
                for w in neighbors.row(v).iter().map(|w| *w as usize) {
                    let across = creases.length_across(v, w);
                    cut += if label[w] == limb { -across } else { across };
                }
                label[v] = limb;
                area += creases.mass[v];
                cuts.push(cut);
                let is_near = warmth[v] >= reach[0] && (warmth[v] <= reach[1] || count == hill.len());
                if is_near && cut < least * area {
                    (least, taken) = (cut / area, count);
                }
            }
            let lower = hill.partition_point(|v| warmth[*v as usize] >= reach[0]);
            let cut_after = |count: usize| count.checked_sub(1).map_or(0.0, |last| cuts[last]);
            if lower > taken && cut_after(lower) < MEETS * cut_after(taken) {
                taken = lower;
            }
            hill.iter().skip(taken).for_each(|v| label[*v as usize] = 0);
        }
        label
    }
}

/// The root of `v`, with path halving.
fn root(parent: &mut [u32], mut v: u32) -> u32 {
    while parent[v as usize] != v {
        let above = parent[parent[v as usize] as usize];
        parent[v as usize] = above;
        v = above;
    }
    v
}

/// Connected pieces of one label, numbered in order of appearance, and how many there are.
fn pieces(label: &[u32], neighbors: &Rows) -> (Vec<u32>, usize) {
    let mut piece = vec![u32::MAX; label.len()];
    let mut count = 0;
    let mut pending = Vec::new();
    for start in 0..label.len() {
        if piece[start] != u32::MAX {
            continue;
        }
        piece[start] = count;
        pending.push(start as u32);
        while let Some(v) = pending.pop() {
            for &w in neighbors.row(v as usize) {
                if piece[w as usize] == u32::MAX && label[w as usize] == label[start] {
                    piece[w as usize] = count;
                    pending.push(w);
                }
            }
        }
        count += 1;
    }
    (piece, count as usize)
}

/// Gives small pieces of trunk, and pieces of limbs without their tip, to the part that they touch most.
fn sweep_scraps(label: &mut [u32], neighbors: &Rows, mass: &[f64], tips: &[Tip]) {
    let (piece, count) = pieces(label, neighbors);
    let mut share = vec![0.0; count];
    let total: f64 = mass.iter().sum();
    piece.iter().zip(mass).for_each(|(piece, mass)| share[*piece as usize] += mass / total);
    let mut is_kept: Vec<bool> = share.iter().map(|share| *share >= SCRAP).collect();
    tips.iter().for_each(|tip| is_kept[piece[tip.vertex as usize] as usize] = true);
    let mut touched: Vec<std::collections::BTreeMap<u32, usize>> = vec![Default::default(); count];
    for v in 0..label.len() {
        let own = piece[v] as usize;
        let others = neighbors.row(v).iter().map(|w| *w as usize);
        for w in others.filter(|w| !is_kept[own] && piece[*w] as usize != own && is_kept[piece[*w] as usize])
        {
            *touched[own].entry(label[w]).or_default() += 1;
        }
    }
    let taken: Vec<Option<u32>> = touched
        .iter()
        .map(|labels| {
            labels.iter().max_by_key(|(label, edges)| (**edges, u32::MAX - **label)).map(|(l, _)| *l)
        })
        .collect();
    for (label, piece) in label.iter_mut().zip(piece) {
        *label = taken[piece as usize].unwrap_or(*label);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_harmonics::BasisSettings;
    use chladni_mesh::samples::{icosphere, limbs, sample};
    use chladni_mesh::surface::vec3::unit;
    use chladni_mesh::{MirrorSearch, TriMesh};
    use chladni_task::Task;

    fn body(mesh: &TriMesh) -> Body {
        Body::build(mesh, &BasisSettings::new(160), &Task::new()).unwrap()
    }

    /// For each known part the best intersection over union, by area, with a part that was found.
    fn overlaps(found: &Limbs, known: &[u8], mass: &[f64]) -> Vec<f64> {
        let labels = usize::from(*known.iter().max().unwrap()) + 1;
        let overlap = |label: usize, part: usize| {
            let (mut both, mut either) = (0.0, 0.0);
            for ((k, p), m) in known.iter().zip(&found.part).zip(mass) {
                let (k, p) = (usize::from(*k) == label, *p as usize == part);
                both += if k && p { *m } else { 0.0 };
                either += if k || p { *m } else { 0.0 };
            }
            both / either
        };
        let best = |label| (0..found.parts.len()).map(|part| overlap(label, part)).fold(0.0, f64::max);
        (0..labels).map(best).collect()
    }

    #[test]
    fn the_arms_of_an_octopus_are_found_and_their_mirror_images() {
        let mesh = sample("octopus").unwrap();
        let known = limbs("octopus", &mesh).unwrap();
        let body = body(&mesh);
        let found = Limbs::of(&body, Limbs::USUAL_LEVEL);
        let overlaps = overlaps(&found, &known, &body.basis.mass);
        assert!(overlaps.iter().all(|o| *o > 0.8), "{overlaps:?}");
        let plane = MirrorSearch::of(&body.positions, &body.triangles).unwrap();
        let plane = plane.best(&[], &Task::new()).unwrap().unwrap();
        let twins = found.twins(&plane);
        assert_eq!(twins.iter().flatten().count(), 8, "{twins:?}");
        assert!(twins.iter().enumerate().all(|(i, j)| j.is_none_or(|j| twins[j] == Some(i))));
    }

    #[test]
    fn the_spikes_of_a_ball_are_its_limbs_and_the_ball_is_its_trunk() {
        let mut mesh = icosphere(5);
        let axes: Vec<Vec3> = (0..6)
            .map(|i| {
                std::array::from_fn(|j| if i / 2 == j { if i % 2 == 0 { 1.0 } else { -1.0 } } else { 0.0 })
            })
            .collect();
        let mut known = Vec::new();
        for p in &mut mesh.positions {
            let (spike, far) =
                axes.iter().map(|a| distance(*p, *a)).enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
            let rise = 2.0 * (-(far / 0.18).powi(4)).exp();
            known.push(if rise > 0.1 { spike as u8 + 1 } else { 0 });
            *p = scaled(unit(*p), 1.0 + rise);
        }
        let body = body(&mesh);
        for level in [0.0, Limbs::USUAL_LEVEL] {
            let found = Limbs::of(&body, level);
            assert_eq!(found.parts.len(), 7, "{:?}", found.parts);
            let overlaps = overlaps(&found, &known, &body.basis.mass);
            println!("spikes at level {level}: {overlaps:.2?}");
            assert!(overlaps.iter().all(|o| *o > 0.8), "{overlaps:?}");
            let trunk = found.parts.iter().position(|part| part.persistence == 0.0).unwrap();
            assert!(distance(found.parts[trunk].middle, [0.0; 3]) < 0.02);
            let painted = found.painted(&[trunk]).values(&body.positions).to_vec();
            assert!(painted.iter().zip(&found.part).all(|(x, p)| (*x == 1.0) == (*p as usize == trunk)));
        }
    }

    #[test]
    fn more_harmonics_than_are_enough_change_nothing() {
        let mut mesh = icosphere(3);
        mesh.positions.iter_mut().for_each(|p| *p = [1.5 * p[0], p[1], 0.7 * p[2] + 0.3 * p[0] * p[0]]);
        let of = |harmonics| {
            let body = Body::build(&mesh, &BasisSettings::new(harmonics), &Task::new()).unwrap();
            warmth(&body, 5e-4)
        };
        let [enough, more] = [Limbs::HARMONICS, Limbs::HARMONICS + 60].map(of);
        let largest = enough.iter().zip(&more).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(largest < 1e-6, "{largest}");
    }

    #[test]
    fn a_ball_has_no_limbs_and_two_balls_are_two_parts() {
        let ball = icosphere(3);
        assert_eq!(Limbs::of(&body(&ball), 0.5).parts.len(), 1);
        let mut two = ball.clone();
        let n = ball.positions.len() as u32;
        two.positions.extend(ball.positions.iter().map(|p| add(*p, [3.0, 0.0, 0.0])));
        two.triangles.extend(ball.triangles.iter().map(|t| t.map(|v| v + n)));
        let found = Limbs::of(&body(&two), 0.5);
        assert_eq!(found.parts.len(), 2);
        assert!(found.part.iter().enumerate().all(|(v, p)| (*p == found.part[0]) == (v < n as usize)));
    }
}
