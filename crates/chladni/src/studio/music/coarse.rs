//! Fewer triangles over some of the same vertices, for small pictures on slow devices.

use chladni_synth::{Coefficients, Item, Term};

use std::cmp::{Ordering, Reverse};
use std::collections::{BinaryHeap, HashMap};

/// A collapse may turn no triangle by more than this cosine.
const LEAST_COSINE: f64 = 0.3;
/// How much a long edge counts beside the distance from the surface: shapes bend where they are flat at rest.
const EVENNESS: f64 = 0.03;

/// A level of detail has a vertex for so many pixels of its cell, of which a shape fills about a third:
/// edges of five or six pixels.
const PIXELS_OF_VERTEX: usize = 50;
/// So many for each harmonic up to the finest that is seen: four in a wave's length, as the length of the
/// k-th wave squared is π/k of the surface (Weyl's law).
const VERTICES_OF_HARMONIC: usize = 5;
/// Displacements below this (the shape's area is one) are not seen in a cell: a third of a pixel.
const SEEN: f32 = 0.002;

/// A shape over the vertices of a larger one.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Triangles over the larger shape's vertices.
    pub triangles: Vec<[u32; 3]>,
    /// How many vertices they name.
    pub vertices: usize,
}

/// Shapes of at most so many vertices each, `wanted` being in falling order; what is drawn through them
/// moves exactly as the whole does.
///
/// One vertex after the other goes into a neighbour, the one that moves the surface least first (quadric
/// error metric: Garland and Heckbert 1997), as long as the surface keeps its kind and no triangle turns
/// over. A shape that cannot become as small as wanted ends with fewer levels.
pub fn levels(positions: &[[f32; 3]], triangles: &[[u32; 3]], wanted: &[usize]) -> Vec<Level> {
    let mut surface = Surface::new(positions, triangles);
    let mut queue = surface.collapses();
    let mut levels = Vec::new();
    for &count in wanted {
        while surface.vertices > count {
            let Some(Reverse(collapse)) = queue.pop() else { return levels };
            if surface.is_due(&collapse) && surface.allows(&collapse) {
                surface.collapse(&collapse);
                surface.renew(collapse.into, &mut queue);
            }
        }
        levels.push(surface.level());
    }
    levels
}

/// How many harmonics of `item` are needed for all that is seen of it in a cell.
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

/// How many vertices a shape needs that moves by so many harmonics in a cell of so many pixels.
pub fn vertices_needed(harmonics: usize, pixels: usize) -> usize {
    (pixels / PIXELS_OF_VERTEX).max(VERTICES_OF_HARMONIC * harmonics)
}

/// Distances from planes, squared and summed: pᵀ A p + 2 bᵀ p + c, of the symmetric A the upper half.
#[derive(Clone, Copy, Default)]
struct Quadric([f64; 10]);

impl Quadric {
    /// Of the plane through `at`, with a normal whose square is its weight.
    fn plane(normal: [f64; 3], at: [f64; 3]) -> Self {
        let [x, y, z] = normal;
        let d = -dot(normal, at);
        Self([x * x, x * y, x * z, y * y, y * z, z * z, x * d, y * d, z * d, d * d])
    }

    fn plus(self, other: &Self) -> Self {
        let mut sum = self;
        sum.0.iter_mut().zip(other.0).for_each(|(sum, other)| *sum += other);
        sum
    }

    fn at(&self, [x, y, z]: [f64; 3]) -> f64 {
        let [xx, xy, xz, yy, yz, zz, dx, dy, dz, dd] = self.0;
        let square = xx * x * x + yy * y * y + zz * z * z + 2.0 * (xy * x * y + xz * x * z + yz * y * z);
        square + 2.0 * (dx * x + dy * y + dz * z) + dd
    }
}

/// A vertex that goes into its neighbour.
#[derive(Clone, Copy)]
struct Collapse {
    cost: f64,
    from: u32,
    into: u32,
    /// How often what the cost depends on had changed when it was found.
    changes: [u32; 2],
}

impl Ord for Collapse {
    fn cmp(&self, other: &Self) -> Ordering {
        let key = |c: &Self| (c.from, c.into, c.changes);
        self.cost.total_cmp(&other.cost).then_with(|| key(self).cmp(&key(other)))
    }
}

impl PartialOrd for Collapse {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Collapse {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Collapse {}

struct Surface {
    positions: Vec<[f64; 3]>,
    /// Those that are gone name a vertex twice.
    triangles: Vec<[u32; 3]>,
    /// The triangles around each vertex.
    around: Vec<Vec<u32>>,
    quadrics: Vec<Quadric>,
    changes: Vec<u32>,
    vertices: usize,
}

impl Surface {
    /// Vertices at one place become one, so that seams stay closed.
    fn new(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Self {
        let mut first_at: HashMap<[u32; 3], u32> = HashMap::with_capacity(positions.len());
        // Adding zero makes −0 into 0.
        let place = |p: &[f32; 3]| p.map(|c| (c + 0.0).to_bits());
        let welded: Vec<u32> =
            (0..).zip(positions).map(|(v, p)| *first_at.entry(place(p)).or_insert(v)).collect();
        let inside = |t: &&[u32; 3]| t.iter().all(|v| (*v as usize) < positions.len());
        let triangles = triangles.iter().filter(inside).map(|t| t.map(|v| welded[v as usize]));
        let mut surface = Self {
            positions: positions.iter().map(|p| p.map(f64::from)).collect(),
            triangles: triangles.filter(is_there).collect(),
            around: vec![Vec::new(); positions.len()],
            quadrics: vec![Quadric::default(); positions.len()],
            changes: vec![0; positions.len()],
            vertices: 0,
        };
        for (t, triangle) in (0..).zip(&surface.triangles) {
            triangle.iter().for_each(|v| surface.around[*v as usize].push(t));
        }
        surface.vertices = surface.around.iter().filter(|around| !around.is_empty()).count();
        surface.find_quadrics();
        surface
    }

    fn find_quadrics(&mut self) {
        for t in 0..self.triangles.len() {
            let [a, b, c] = self.triangles[t];
            let (at, normal) = (self.at(a), self.normal([a, b, c]));
            let twice_area = dot(normal, normal).sqrt();
            if twice_area <= 0.0 || !twice_area.is_finite() {
                continue;
            }
            let quadric = Quadric::plane(normal.map(|n| n / twice_area.sqrt()), at);
            for (v, next) in [(a, b), (b, c), (c, a)] {
                self.add(v, &quadric);
                // A border stays where it is: a plane along it, upright.
                if self.shared(v, next) == 1 {
                    let edge = minus(self.at(next), self.at(v));
                    let upright = cross(edge, normal).map(|n| n / twice_area);
                    let quadric = Quadric::plane(upright, self.at(v));
                    self.add(v, &quadric);
                    self.add(next, &quadric);
                }
            }
        }
    }

    fn add(&mut self, v: u32, quadric: &Quadric) {
        self.quadrics[v as usize] = self.quadrics[v as usize].plus(quadric);
    }

    fn at(&self, v: u32) -> [f64; 3] {
        self.positions[v as usize]
    }

    /// As long as twice the triangle's area.
    fn normal(&self, [a, b, c]: [u32; 3]) -> [f64; 3] {
        cross(minus(self.at(b), self.at(a)), minus(self.at(c), self.at(a)))
    }

    fn triangles_around(&self, v: u32) -> impl Iterator<Item = [u32; 3]> {
        self.around[v as usize].iter().map(|t| self.triangles[*t as usize])
    }

    fn neighbours(&self, v: u32) -> Vec<u32> {
        let mut found: Vec<u32> = self.triangles_around(v).flatten().filter(|other| *other != v).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// How many triangles have the edge from `a` to `b`.
    fn shared(&self, a: u32, b: u32) -> usize {
        self.triangles_around(a).filter(|t| t.contains(&b)).count()
    }

    fn cheaper(&self, a: u32, b: u32) -> Collapse {
        let quadric = self.quadrics[a as usize].plus(&self.quadrics[b as usize]);
        let edge = minus(self.at(b), self.at(a));
        // Quadrics weigh distances by areas, as this does.
        let even = EVENNESS * dot(edge, edge).powi(2);
        let (into_a, into_b) = (quadric.at(self.at(a)), quadric.at(self.at(b)));
        let (cost, from, into) = if into_a < into_b { (into_a, b, a) } else { (into_b, a, b) };
        let changes = [self.changes[from as usize], self.changes[into as usize]];
        Collapse { cost: cost.max(0.0) + even, from, into, changes }
    }

    fn collapses(&self) -> BinaryHeap<Reverse<Collapse>> {
        let vertices = 0..self.positions.len() as u32;
        let later = |a| self.neighbours(a).into_iter().filter(move |b| *b > a).map(move |b| (a, b));
        vertices.flat_map(later).map(|(a, b)| Reverse(self.cheaper(a, b))).collect()
    }

    fn is_due(&self, collapse: &Collapse) -> bool {
        collapse.changes == [collapse.from, collapse.into].map(|v| self.changes[v as usize])
    }

    /// Whether the surface keeps its kind (the edge's ends share no neighbours but those of its triangles)
    /// and no triangle turns over.
    fn allows(&self, &Collapse { from, into, .. }: &Collapse) -> bool {
        let (ours, theirs) = (self.neighbours(from), self.neighbours(into));
        let common = ours.iter().filter(|v| theirs.binary_search(v).is_ok()).count();
        let mut staying = self.triangles_around(from).filter(|t| !t.contains(&into)).peekable();
        if common != self.shared(from, into) || common > 2 || staying.peek().is_none() {
            return false;
        }
        staying.all(|t| {
            let moved = t.map(|v| if v == from { into } else { v });
            let (before, after) = (self.normal(t), self.normal(moved));
            let lengths = (dot(before, before) * dot(after, after)).sqrt();
            dot(before, after) > LEAST_COSINE * lengths || dot(before, before) == 0.0
        })
    }

    fn collapse(&mut self, &Collapse { from, into, .. }: &Collapse) {
        let (going, staying): (Vec<u32>, Vec<u32>) = std::mem::take(&mut self.around[from as usize])
            .into_iter()
            .partition(|t| self.triangles[*t as usize].contains(&into));
        for t in going {
            let triangle = std::mem::take(&mut self.triangles[t as usize]);
            for v in triangle.into_iter().filter(|v| *v != from) {
                self.around[v as usize].retain(|other| *other != t);
                // The tip of an ear goes with it.
                self.vertices -= usize::from(v != into && self.around[v as usize].is_empty());
            }
        }
        for &t in &staying {
            self.triangles[t as usize].iter_mut().filter(|v| **v == from).for_each(|v| *v = into);
        }
        self.around[into as usize].extend(staying);
        let quadric = self.quadrics[from as usize];
        self.add(into, &quadric);
        self.changes[from as usize] += 1;
        self.vertices -= 1;
    }

    /// Finds the collapses around `v` anew; those known before are outdated.
    fn renew(&mut self, v: u32, queue: &mut BinaryHeap<Reverse<Collapse>>) {
        self.changes[v as usize] += 1;
        queue.extend(self.neighbours(v).into_iter().map(|other| Reverse(self.cheaper(v, other))));
    }

    fn level(&self) -> Level {
        let triangles = self.triangles.iter().filter(|t| is_there(t)).copied().collect();
        Level { triangles, vertices: self.vertices }
    }
}

fn is_there([a, b, c]: &[u32; 3]) -> bool {
    a != b && b != c && c != a
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_mesh::samples;
    use std::collections::{HashMap, HashSet};

    fn positions(mesh: &chladni_mesh::TriMesh) -> Vec<[f32; 3]> {
        mesh.positions.iter().map(|p| p.map(|c| c as f32)).collect()
    }

    /// How often each edge is there in each direction.
    fn directed(triangles: &[[u32; 3]]) -> HashMap<[u32; 2], usize> {
        let mut edges = HashMap::new();
        for [a, b, c] in triangles {
            [[*a, *b], [*b, *c], [*c, *a]].into_iter().for_each(|edge| *edges.entry(edge).or_default() += 1);
        }
        edges
    }

    #[test]
    fn levels_of_the_octopus_are_closed_and_lie_on_it() {
        let mesh = samples::sample("octopus").expect("it is there");
        let positions = positions(&mesh);
        let area = |triangles: &[[u32; 3]]| {
            let surface = Surface::new(&positions, triangles);
            let twice = |t: &[u32; 3]| dot(surface.normal(*t), surface.normal(*t)).sqrt();
            0.5 * triangles.iter().map(twice).sum::<f64>()
        };
        let (whole, volume) = (area(&mesh.triangles), volume(&positions, &mesh.triangles));
        let found = levels(&positions, &mesh.triangles, &[4000, 1300]);
        assert_eq!(found.iter().map(|level| level.vertices).collect::<Vec<_>>(), [4000, 1300]);
        for level in &found {
            let named: HashSet<u32> = level.triangles.iter().flatten().copied().collect();
            assert_eq!(named.len(), level.vertices);
            // Closed, oriented and of one piece without a handle, as the octopus is.
            assert_eq!(level.triangles.len(), 2 * level.vertices - 4);
            let edges = directed(&level.triangles);
            assert!(edges.iter().all(|([a, b], count)| *count == 1 && edges.contains_key(&[*b, *a])));
            let (area, volume) =
                (area(&level.triangles) / whole, self::volume(&positions, &level.triangles) / volume);
            assert!((0.97..1.01).contains(&area) && (0.97..1.01).contains(&volume), "{area} {volume}");
        }
        assert_eq!(found, levels(&positions, &mesh.triangles, &[4000, 1300]));
    }

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

    fn volume(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> f64 {
        let at = |v: u32| positions[v as usize].map(f64::from);
        triangles.iter().map(|[a, b, c]| dot(at(*a), cross(at(*b), at(*c))) / 6.0).sum()
    }

    #[test]
    fn a_border_stays_and_a_seam_does_not_open() {
        // A flat square of 20 × 20 cells whose halves do not share their vertices.
        let (n, mut positions, mut triangles) = (21_u32, Vec::new(), Vec::new());
        for half in 0..2 {
            for i in 0..n * 11 {
                let (x, y) = (i % 11 + 10 * half, i / 11);
                positions.push([x as f32, y as f32, 0.0]);
                let (here, up) = (i + half * n * 11, i + half * n * 11 + 11);
                if i % 11 < 10 && y + 1 < n {
                    triangles.extend([[here, here + 1, up], [up, here + 1, up + 1]]);
                }
            }
        }
        let level = levels(&positions, &triangles, &[30]).pop().expect("it becomes smaller");
        let edges = directed(&level.triangles);
        let border = edges.keys().filter(|[a, b]| !edges.contains_key(&[*b, *a]));
        let on_side = |v: u32| positions[v as usize][..2].iter().any(|c| *c == 0.0 || *c == 20.0);
        assert!(border.flatten().all(|v| on_side(*v)));
        let surface = Surface::new(&positions, &level.triangles);
        let area: f64 = level.triangles.iter().map(|t| 0.5 * surface.normal(*t)[2]).sum();
        assert!((area - 400.0).abs() < 1e-9, "{area}");
    }

    #[test]
    fn what_cannot_become_smaller_stays() {
        let ring = [[0, 1, 2], [2, 1, 0]];
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, f32::NAN]];
        assert!(levels(&corners, &ring, &[2]).is_empty());
        assert!(levels(&[], &[], &[5]).iter().all(|level| level.triangles.is_empty()));
        assert!(levels(&corners, &[[0, 1, 7]], &[2]).iter().all(|level| level.triangles.is_empty()));
    }
}
