//! From a signed distance function to a closed mesh of well-shaped triangles.
//!
//! Surface nets (S. Gibson, "Constrained Elastic Surface Nets", MICCAI 1998): one vertex per grid
//! cell that the surface crosses, one quadrilateral per grid edge that it crosses. The vertices are
//! then relaxed along the surface and brought back onto it.

use rayon::prelude::*;

use super::field::gradient;
use crate::TriMesh;
use crate::surface::doubled_area_normal;
use crate::surface::vec3::{Vec3, add, dot, length, scaled, sub, unit};

/// A box of space, mirrored in x = 0, in cells that grow away from its center.
pub(crate) struct Grid {
    /// Where the cells are finest; its x is 0.
    pub center: Vec3,
    /// Least and greatest x, y and z; x is mirrored.
    pub low: Vec3,
    pub high: Vec3,
    /// Side of the cells at the center.
    pub cell: f64,
    /// How much larger cells are at distance 1 from the center, along each axis.
    pub growth: f64,
}

impl Grid {
    fn axis(&self, a: usize) -> Vec<f64> {
        let center = self.center[a];
        let side = |limit: f64| {
            let mut offsets = vec![0.5 * self.cell];
            while let Some(&last) = offsets.last().filter(|last| **last < (limit - center).abs()) {
                offsets.push(last + self.cell * (1.0 + self.growth * last * last));
            }
            offsets
        };
        let below = side(self.low[a]).into_iter().rev().map(|offset| center - offset);
        below.chain(side(self.high[a]).into_iter().map(|offset| center + offset)).collect()
    }
}

/// The surface where `half` is zero, and its mirror image: `half` is evaluated at x ≥ 0 only. The surface
/// must lie inside the grid, and `half` must not change faster than twice the distance.
pub(crate) fn surface(half: impl Fn(Vec3) -> f64 + Sync, grid: &Grid) -> TriMesh {
    let field = |[x, y, z]: Vec3| half([x.abs(), y, z]);
    let mut samples = Samples::take(&field, grid);
    samples.simplify();
    let (mut positions, quads) = samples.nets();
    let neighbors = quad_neighbors(positions.len(), &quads);
    for _ in 0..8 {
        positions = positions
            .par_iter()
            .zip(&neighbors)
            .map(|(&p, around)| relaxed(&field, p, around.iter().map(|&w| positions[w as usize]), grid.cell))
            .collect();
    }
    positions.par_iter_mut().for_each(|p| *p = on_surface(&field, *p, grid.cell));
    let triangles = quads.iter().flat_map(|quad| split(&positions, *quad)).collect();
    TriMesh { positions, triangles, ..TriMesh::default() }
}

/// The field at the points of a grid.
struct Samples {
    axes: [Vec<f64>; 3],
    values: Vec<f64>,
}

/// Side of the blocks that are skipped where the surface is far.
const BLOCK: usize = 6;

impl Samples {
    fn take(field: &(impl Fn(Vec3) -> f64 + Sync), grid: &Grid) -> Self {
        let axes = [0, 1, 2].map(|a| grid.axis(a));
        let [nx, ny, nz] = [0, 1, 2].map(|a| axes[a].len());
        let mut values = vec![0.0; nx * ny * nz];
        values.par_chunks_mut(nx * ny * BLOCK).enumerate().for_each(|(slab, values)| {
            let zs = slab * BLOCK..(slab * BLOCK + BLOCK).min(nz);
            let mut is_near = vec![false; nx.div_ceil(BLOCK)];
            for y in (0..ny).step_by(BLOCK) {
                for x in (0..nx).step_by(BLOCK).rev() {
                    let ranges = [x..(x + BLOCK).min(nx), y..(y + BLOCK).min(ny), zs.clone()];
                    let ends = [0, 1, 2].map(|a| [axes[a][ranges[a].start], axes[a][ranges[a].end - 1]]);
                    let middle = ends.map(|[low, high]| 0.5 * (low + high));
                    let radius = 0.5 * length(ends.map(|[low, high]| high - low));
                    let far = field(middle);
                    is_near[x / BLOCK] = far.abs() <= 2.0 * radius;
                    for k in ranges[2].clone() {
                        for j in ranges[1].clone() {
                            let row = &mut values[((k - slab * BLOCK) * ny + j) * nx..][..nx];
                            for i in ranges[0].clone().rev() {
                                let mirrored = nx - 1 - i;
                                let is_known = i < mirrored
                                    && is_near[mirrored / BLOCK]
                                    && axes[0][i] == -axes[0][mirrored];
                                row[i] = match (is_near[x / BLOCK], is_known) {
                                    (false, _) => far,
                                    (true, true) => row[mirrored],
                                    (true, false) => field([axes[0][i], axes[1][j], axes[2][k]]),
                                };
                            }
                        }
                    }
                }
            }
        });
        Self { axes, values }
    }

    fn size(&self) -> [usize; 3] {
        [0, 1, 2].map(|a| self.axes[a].len())
    }

    fn at(&self, i: [usize; 3]) -> usize {
        (i[2] * self.axes[1].len() + i[1]) * self.axes[0].len() + i[0]
    }

    fn index(&self, n: usize) -> [usize; 3] {
        let [nx, ny, _] = self.size();
        [n % nx, n / nx % ny, n / (nx * ny)]
    }

    fn point(&self, i: [usize; 3]) -> Vec3 {
        std::array::from_fn(|a| self.axes[a][i[a]])
    }

    /// The values' indices at the corners of the cell at `n`, `None` past the last cell. Bit a
    /// of a corner's number says which side of axis a it is on.
    fn cell(&self, n: usize) -> Option<[usize; 8]> {
        let (base, size) = (self.index(n), self.size());
        let inner = (0..3).all(|a| base[a] + 1 < size[a]);
        inner.then(|| std::array::from_fn(|bits| self.at(std::array::from_fn(|a| base[a] + (bits >> a & 1)))))
    }

    /// The cells that the surface crosses, in order.
    fn crossed(&self) -> Vec<usize> {
        let [nx, ny, nz] = self.size();
        let of_row = |row: usize| {
            let is_inner = row % ny + 1 < ny && row / ny + 1 < nz;
            let first = row * nx;
            let columns = if is_inner { nx - 1 } else { 0 };
            // The four corners on one side are those on the other side of the next cell.
            let inside =
                move |n: usize| [n, n + nx, n + nx * ny, n + nx * (ny + 1)].map(|c| self.values[c] < 0.0);
            (first..first + columns).filter(move |n| {
                let (low, high) = (inside(*n), inside(n + 1));
                low.iter().chain(&high).any(|is_inside| *is_inside != low[0])
            })
        };
        (0..ny * nz).into_par_iter().flat_map_iter(of_row).collect()
    }

    /// Fills the corners that make the surface pass a cell in more than one sheet, which one
    /// vertex cannot hold, until there are none. The vertices go to the true surface later.
    fn simplify(&mut self) {
        let mut doubtful = self.crossed();
        for _ in 0..32 {
            let mut filled = Vec::new();
            for n in doubtful {
                let Some(corners) = self.cell(n) else { continue };
                let inside = corners.map(|c| self.values[c] < 0.0);
                if is_simple(inside) {
                    continue;
                }
                // All equally near outside corners together, to keep the mirror symmetry.
                let outside = |i: &usize| !inside[*i];
                let nearest =
                    (0..8).filter(outside).map(|i| self.values[corners[i]]).fold(f64::MAX, f64::min);
                let near = |i: &usize| self.values[corners[*i]] <= nearest * (1.0 + 1e-9);
                filled.extend((0..8).filter(outside).filter(near).map(|i| corners[i]));
            }
            if filled.is_empty() {
                return;
            }
            for &n in &filled {
                self.values[n] = -self.values[n].abs().max(1e-9);
            }
            // Only the cells around a filled corner have changed.
            doubtful = filled.into_iter().flat_map(|n| self.cells_around(n)).collect();
            doubtful.sort_unstable();
            doubtful.dedup();
        }
    }

    /// The cells that have the value at `n` at a corner.
    fn cells_around(&self, n: usize) -> impl Iterator<Item = usize> + use<> {
        let (at, [nx, ny, _]) = (self.index(n), self.size());
        let inner = move |bits: &usize| (0..3).all(|a| at[a] >= bits >> a & 1);
        (0..8).filter(inner).map(move |bits| n - (bits & 1) - nx * (bits >> 1 & 1) - nx * ny * (bits >> 2))
    }

    /// Vertices and quadrilaterals, counter-clockwise seen from outside.
    fn nets(&self) -> (Vec<Vec3>, Vec<[u32; 4]>) {
        let mut vertex = vec![u32::MAX; self.values.len()];
        let mut positions = Vec::new();
        let crossed = self.crossed();
        for &n in &crossed {
            if let Some(position) = self.cell(n).and_then(|corners| self.cell_vertex(corners)) {
                vertex[n] = positions.len() as u32;
                positions.push(position);
            }
        }
        let mut quads = Vec::new();
        for n in crossed {
            let base = self.index(n);
            for axis in 0..3 {
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                if base[u] == 0 || base[v] == 0 {
                    continue;
                }
                let mut end = base;
                end[axis] += 1;
                let inside = self.values[n] < 0.0;
                if inside == (self.values[self.at(end)] < 0.0) {
                    continue;
                }
                let cell = |du: usize, dv: usize| {
                    let mut i = base;
                    i[u] -= du;
                    i[v] -= dv;
                    vertex[self.at(i)]
                };
                let [a, b, c, d] = [cell(1, 1), cell(0, 1), cell(0, 0), cell(1, 0)];
                quads.push(if inside { [a, b, c, d] } else { [d, c, b, a] });
            }
        }
        quads.retain(|quad| !quad.contains(&u32::MAX));
        (positions, quads)
    }

    /// The mean of the points where the surface crosses the cell's edges.
    fn cell_vertex(&self, corners: [usize; 8]) -> Option<Vec3> {
        let (mut sum, mut crossings) = ([0.0; 3], 0);
        for [i, j] in cell_edges() {
            let (fa, fb) = (self.values[corners[i]], self.values[corners[j]]);
            if (fa < 0.0) != (fb < 0.0) {
                let (pa, pb) = (self.point(self.index(corners[i])), self.point(self.index(corners[j])));
                sum = add(sum, add(pa, scaled(sub(pb, pa), fa / (fa - fb))));
                crossings += 1;
            }
        }
        (crossings > 0).then(|| scaled(sum, 1.0 / f64::from(crossings)))
    }
}

/// The 12 edges of a cell, by their corners.
fn cell_edges() -> impl Iterator<Item = [usize; 2]> {
    (0..3).flat_map(|axis| (0..8).filter(move |i| i >> axis & 1 == 0).map(move |i| [i, i | 1 << axis]))
}

/// Whether the inside corners are connected by edges, the outside corners too, and no face has two inside
/// corners diagonally opposite.
fn is_simple(inside: [bool; 8]) -> bool {
    let mut piece: [usize; 8] = std::array::from_fn(|i| i);
    for _ in 0..3 {
        for [i, j] in cell_edges().filter(|&[i, j]| inside[i] == inside[j]) {
            let least = piece[i].min(piece[j]);
            (piece[i], piece[j]) = (least, least);
        }
    }
    let pieces = |side: bool| (0..8).filter(|&i| inside[i] == side && piece[i] == i).count();
    let crossed = |axis: usize, i: usize| {
        let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        inside[i] == inside[i | u | v] && inside[i | u] == inside[i | v] && inside[i] != inside[i | u]
    };
    let is_crossed = (0..3).any(|axis| [0, 1 << axis].into_iter().any(|i| crossed(axis, i)));
    pieces(true) <= 1 && pieces(false) <= 1 && !is_crossed
}

fn quad_neighbors(count: usize, quads: &[[u32; 4]]) -> Vec<Vec<u32>> {
    let mut neighbors = vec![Vec::with_capacity(4); count];
    for quad in quads {
        for side in 0..4 {
            // Every edge has two quads, which run through it in opposite directions.
            neighbors[quad[side] as usize].push(quad[(side + 1) % 4]);
        }
    }
    neighbors
}

/// `p` half way to the middle of its neighbors along the surface, then back toward it.
fn relaxed(
    field: &impl Fn(Vec3) -> f64,
    p: Vec3,
    neighbors: impl ExactSizeIterator<Item = Vec3>,
    cell: f64,
) -> Vec3 {
    let count = neighbors.len().max(1) as f64;
    let middle = scaled(neighbors.fold([0.0; 3], add), 1.0 / count);
    let toward = scaled(sub(middle, p), 0.5);
    let g = gradient(field, p, 0.1 * cell);
    let n = unit(g);
    let q = add(p, sub(toward, scaled(n, dot(n, toward))));
    let slope = length(g).max(0.1);
    sub(q, scaled(n, (field(q) / slope).clamp(-0.5 * cell, 0.5 * cell)))
}

/// `p` brought onto the surface by Newton's method along the gradient.
fn on_surface(field: &impl Fn(Vec3) -> f64, mut p: Vec3, cell: f64) -> Vec3 {
    for _ in 0..3 {
        let g = gradient(field, p, 0.05 * cell);
        // Where the field is not a true distance, a full step may overshoot.
        let slope = length(g).max(0.1);
        p = sub(p, scaled(unit(g), (field(p) / slope).clamp(-0.5 * cell, 0.5 * cell)));
    }
    p
}

/// The two triangles of a quadrilateral, cut where they come out least narrow.
fn split(positions: &[Vec3], [a, b, c, d]: [u32; 4]) -> [[u32; 3]; 2] {
    let quality = |triangle: &[u32; 3]| {
        let p = triangle.map(|v| positions[v as usize]);
        let longest = (0..3).map(|i| length(sub(p[i], p[(i + 1) % 3]))).fold(0.0, f64::max);
        length(doubled_area_normal(p)) / (longest * longest)
    };
    let worst = |pair: &[[u32; 3]; 2]| quality(&pair[0]).min(quality(&pair[1]));
    let (one, other) = ([[a, b, c], [a, c, d]], [[b, c, d], [b, d, a]]);
    if worst(&one) >= worst(&other) { one } else { other }
}
