//! The edge-manifold surface on which edges are flipped: the mesh itself if it is closed, edge-manifold and
//! oriented, otherwise its tufted cover.

use chladni_mesh::surface::vec3::{cross, dot, length, sub};

use crate::CoverReport;

/// Triangles glued side to side, with a length on every side and no boundary.
///
/// Side h = 3f + i runs from `tail[h]`, corner i of triangle f, to the next corner.
#[derive(Debug)]
pub(crate) struct Cover {
    /// How often the surface is covered: 1 or 2.
    pub sheets: usize,
    /// The vertex from which each side starts.
    pub tail: Vec<u32>,
    /// The side glued to each side, which runs in the opposite direction.
    pub twin: Vec<u32>,
    /// The length of each side, equal for both sides of a glued pair.
    pub length: Vec<f64>,
    /// The mean length of the surface's edges, each counted once whether it has one triangle or several.
    mean_length: f64,
    /// The length by which all sides have grown.
    mollified_by: f64,
    /// The number of flips so far.
    pub flips: usize,
}

/// The next side around the triangle of side `h`.
pub(crate) fn next(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

/// The side before `h` around its triangle.
pub(crate) fn previous(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

impl Cover {
    /// The cover of unconnected triangles, each with three different corners.
    pub(crate) fn of(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Self {
        let edges = Edges::of(positions.len(), triangles);
        let mut cover = if edges.are_closed_and_oriented(triangles) {
            Self::one_sheet(positions, triangles, &edges)
        } else {
            Self::tufted(positions, triangles, &edges)
        };
        let lengths = edges.iter().map(|sides| edge_length(positions, triangles, sides[0]));
        cover.mean_length = lengths.sum::<f64>() / edges.iter().count().max(1) as f64;
        cover
    }

    /// Sides without lengths, which are glued to nothing.
    fn unglued(sheets: usize, tail: Vec<u32>) -> Self {
        let sides = tail.len();
        let (twin, length) = (vec![0; sides], vec![0.0; sides]);
        Self { sheets, tail, twin, length, mean_length: 0.0, mollified_by: 0.0, flips: 0 }
    }

    fn one_sheet(positions: &[[f64; 3]], triangles: &[[u32; 3]], edges: &Edges) -> Self {
        let tail: Vec<u32> = triangles.iter().flatten().copied().collect();
        let mut cover = Self::unglued(1, tail);
        for sides in edges.iter() {
            cover.glue(sides[0], sides[1], edge_length(positions, triangles, sides[0]));
        }
        cover
    }

    /// The tufted cover (Sharp & Crane 2020, §3): every triangle occurs twice, as front and back. Around
    /// each edge, in the order of the dihedral angle, the facing sides of neighbors are glued.
    fn tufted(positions: &[[f64; 3]], triangles: &[[u32; 3]], edges: &Edges) -> Self {
        let m = triangles.len() as u32;
        // The back of (a, b, c) is (a, c, b). All backs follow all fronts.
        let fronts = triangles.iter().flatten().copied();
        let backs = triangles.iter().flat_map(|&[a, b, c]| [a, c, b]);
        let tail: Vec<u32> = fronts.chain(backs).collect();
        // Side 0 of the front, a → b, is side 2 of the back, b → a, and so on.
        let back = |h: u32| 3 * (m + h / 3) + (2 - h % 3);
        let mut cover = Self::unglued(2, tail);
        let mut around = Vec::new();
        for sides in edges.iter() {
            around.clear();
            radial_order(positions, triangles, sides, &mut around);
            let length = edge_length(positions, triangles, sides[0]);
            for i in 0..around.len() {
                let (side, along) = around[i];
                let (following, following_along) = around[(i + 1) % around.len()];
                // With the edge as axis, a triangle that runs along the edge has its front toward growing
                // angles; one that runs against it has its back there.
                let growing = if along { side } else { back(side) };
                let shrinking = if following_along { back(following) } else { following };
                cover.glue(growing, shrinking, length);
            }
        }
        cover
    }

    fn glue(&mut self, a: u32, b: u32, length: f64) {
        self.twin[a as usize] = b;
        self.twin[b as usize] = a;
        self.length[a as usize] = length;
        self.length[b as usize] = length;
    }

    /// Adds to all lengths the smallest constant that gives every triangle a slack of `factor` mean lengths
    /// (Sharp & Crane 2020, eq. 9 and 10). It is 0 for a sound mesh.
    pub(crate) fn mollify(&mut self, factor: f64) {
        let slack = factor * self.mean_length;
        let mut missing = 0.0_f64;
        for l in self.length.as_chunks::<3>().0 {
            for i in 0..3 {
                missing = missing.max(slack + l[i] - l[(i + 1) % 3] - l[(i + 2) % 3]);
            }
        }
        self.length.iter_mut().for_each(|l| *l += missing);
        self.mollified_by = missing;
    }

    /// What was done so far.
    pub(crate) fn report(&self) -> CoverReport {
        let mollified_by = self.mollified_by / self.mean_length.max(f64::MIN_POSITIVE);
        CoverReport { sheets: self.sheets, mollified_by, flips: self.flips }
    }
}

fn edge_length(positions: &[[f64; 3]], triangles: &[[u32; 3]], side: u32) -> f64 {
    let (u, v) = ends(triangles, side);
    let (p, q) = (positions[u as usize], positions[v as usize]);
    (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>().sqrt()
}

/// The two vertices of a side.
pub(super) fn ends(triangles: &[[u32; 3]], side: u32) -> (u32, u32) {
    let t = triangles[side as usize / 3];
    let i = side as usize % 3;
    (t[i], t[(i + 1) % 3])
}

/// The sides at one edge, in the order of their triangles' angle around it, each with whether it runs from
/// the smaller to the larger vertex index.
fn radial_order(positions: &[[f64; 3]], triangles: &[[u32; 3]], sides: &[u32], order: &mut Vec<(u32, bool)>) {
    let along = |side: u32| {
        let (u, v) = ends(triangles, side);
        u < v
    };
    if sides.len() <= 2 {
        // Up to rotation there is only one order.
        order.extend(sides.iter().map(|&s| (s, along(s))));
        return;
    }
    let (u, v) = ends(triangles, sides[0]);
    let (u, v) = (positions[u.min(v) as usize], positions[u.max(v) as usize]);
    let axis = sub(v, u);
    let length = length(axis);
    let axis = axis.map(|x| x / length);
    let mut unit = [0.0; 3];
    unit[(0..3).min_by(|&i, &j| axis[i].abs().total_cmp(&axis[j].abs())).unwrap_or(0)] = 1.0;
    let x = cross(axis, unit);
    let y = cross(axis, x);
    let mut angles: Vec<(f64, u32)> = sides
        .iter()
        .map(|&side| {
            let apex = positions[triangles[side as usize / 3][(side as usize + 2) % 3] as usize];
            let d = sub(apex, u);
            (dot(d, y).atan2(dot(d, x)), side)
        })
        .collect();
    angles.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    order.extend(angles.into_iter().map(|(_, s)| (s, along(s))));
}

/// The sides of all triangles, grouped by edge.
pub(super) struct Edges {
    /// All sides, grouped by edge; ascending within each edge.
    sides: Vec<u32>,
    /// The start of each edge in `sides`, and the end of the last one.
    starts: Vec<usize>,
}

impl Edges {
    pub(super) fn of(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        // Bucket by the smaller vertex, then order each small bucket by the larger.
        let mut first = vec![0_usize; vertices + 1];
        for h in 0..triangles.len() as u32 * 3 {
            let (u, v) = ends(triangles, h);
            first[u.min(v) as usize + 1] += 1;
        }
        for v in 0..vertices {
            first[v + 1] += first[v];
        }
        let mut at = first.clone();
        let mut keyed = vec![(0_u32, 0_u32); triangles.len() * 3];
        for h in 0..triangles.len() as u32 * 3 {
            let (u, v) = ends(triangles, h);
            let slot = &mut at[u.min(v) as usize];
            keyed[*slot] = (u.max(v), h);
            *slot += 1;
        }
        let mut starts = Vec::with_capacity(triangles.len() * 3 / 2 + 1);
        for v in 0..vertices {
            let bucket = &mut keyed[first[v]..first[v + 1]];
            bucket.sort_unstable();
            for (i, entry) in bucket.iter().enumerate() {
                if i == 0 || bucket[i - 1].0 != entry.0 {
                    starts.push(first[v] + i);
                }
            }
        }
        starts.push(keyed.len());
        Self { sides: keyed.into_iter().map(|(_, h)| h).collect(), starts }
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &[u32]> {
        self.starts.windows(2).map(|w| &self.sides[w[0]..w[1]])
    }

    fn are_closed_and_oriented(&self, triangles: &[[u32; 3]]) -> bool {
        self.iter().all(|s| s.len() == 2 && ends(triangles, s[0]).0 != ends(triangles, s[1]).0)
    }
}
