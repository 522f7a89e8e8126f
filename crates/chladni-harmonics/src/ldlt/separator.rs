//! Small vertex separators of a connected graph: coarsens the graph, cuts the coarsest one, and improves
//! the cut on the way back (Karypis & Kumar 1998; Hendrickson & Rothberg 1998).

use std::collections::BinaryHeap;

/// Which side of a cut a vertex is on.
pub(super) const LEFT: u8 = 0;
pub(super) const RIGHT: u8 = 1;
pub(super) const SEPARATOR: u8 = 2;

/// Coarsening stops at about this many vertices.
const COARSEST: usize = 120;
/// The number of cuts of the coarsest graph that are tried; larger for a large graph, whose separator
/// matters more.
const TRIALS: usize = 3;
const TRIALS_OF_LARGE: usize = 12;
const LARGE: u64 = 3000;
/// Rounds of improvement at each level.
const PASSES: usize = 3;

/// A graph as neighbor lists.
pub(super) struct Graph {
    pub starts: Vec<usize>,
    pub neighbors: Vec<u32>,
}

impl Graph {
    pub(super) fn size(&self) -> usize {
        self.starts.len() - 1
    }

    pub(super) fn of(&self, v: u32) -> &[u32] {
        &self.neighbors[self.starts[v as usize]..self.starts[v as usize + 1]]
    }
}

/// A graph whose vertices and edges represent several of the original graph.
struct Level {
    graph: Graph,
    /// The weight of each entry of `graph.neighbors`.
    edge_weights: Vec<u32>,
    vertex_weights: Vec<u32>,
    total: u64,
}

/// Computes the side of each vertex of a connected `graph`. No edge joins LEFT and RIGHT.
pub(super) fn separate(graph: &Graph) -> Vec<u8> {
    let n = graph.size();
    let finest = Level {
        graph: Graph { starts: graph.starts.clone(), neighbors: graph.neighbors.clone() },
        edge_weights: vec![1; graph.neighbors.len()],
        vertex_weights: vec![1; n],
        total: n as u64,
    };
    let mut levels = vec![finest];
    let mut maps: Vec<Vec<u32>> = Vec::new();
    while let Some(fine) = levels.last() {
        if fine.graph.size() <= COARSEST {
            break;
        }
        let (coarse, map) = fine.coarser();
        // A star shrinks by one vertex at a time; it is cut at this level.
        if coarse.graph.size() * 20 > fine.graph.size() * 19 {
            break;
        }
        levels.push(coarse);
        maps.push(map);
    }
    let mut part = levels.last().map_or_else(Vec::new, Level::first_cut);
    for (level, map) in levels.iter().zip(&maps).rev() {
        part = map.iter().map(|&coarse| part[coarse as usize]).collect();
        level.improve(&mut part);
    }
    part
}

impl Level {
    /// Merges pairs of neighbors joined by heavy edges. Also returns each vertex's index in the result.
    fn coarser(&self) -> (Self, Vec<u32>) {
        let n = self.graph.size();
        let heaviest = (self.total / (COARSEST as u64 / 2)).max(2);
        let mut map = vec![u32::MAX; n];
        let mut members: Vec<[u32; 2]> = Vec::with_capacity(n * 3 / 5);
        for v in scattered(n) {
            if map[v as usize] != u32::MAX {
                continue;
            }
            let range = self.graph.starts[v as usize]..self.graph.starts[v as usize + 1];
            let weight = |u: u32| u64::from(self.vertex_weights[u as usize]);
            let partner = self.graph.neighbors[range.clone()]
                .iter()
                .zip(&self.edge_weights[range])
                .filter(|&(&u, _)| map[u as usize] == u32::MAX && weight(u) + weight(v) <= heaviest)
                .max_by_key(|&(&u, &w)| (w, std::cmp::Reverse(self.vertex_weights[u as usize])))
                .map_or(v, |(&u, _)| u);
            map[v as usize] = members.len() as u32;
            map[partner as usize] = members.len() as u32;
            members.push([v, partner]);
        }
        (self.merged(&members, &map), map)
    }

    fn merged(&self, members: &[[u32; 2]], map: &[u32]) -> Self {
        let mut slot = vec![usize::MAX; members.len()];
        let mut graph = Graph {
            starts: Vec::with_capacity(members.len() + 1),
            neighbors: Vec::with_capacity(self.graph.neighbors.len()),
        };
        graph.starts.push(0);
        let mut edge_weights = Vec::with_capacity(self.graph.neighbors.len());
        let mut vertex_weights = Vec::with_capacity(members.len());
        for (own, &[a, b]) in members.iter().enumerate() {
            let first = graph.neighbors.len();
            let pair = if a == b { &[a][..] } else { &[a, b][..] };
            for &v in pair {
                let range = self.graph.starts[v as usize]..self.graph.starts[v as usize + 1];
                for (&u, &w) in self.graph.neighbors[range.clone()].iter().zip(&self.edge_weights[range]) {
                    let coarse = map[u as usize] as usize;
                    if coarse == own {
                        continue;
                    }
                    if slot[coarse] >= first && slot[coarse] < graph.neighbors.len() {
                        edge_weights[slot[coarse]] += w;
                    } else {
                        slot[coarse] = graph.neighbors.len();
                        graph.neighbors.push(coarse as u32);
                        edge_weights.push(w);
                    }
                }
            }
            graph.starts.push(graph.neighbors.len());
            vertex_weights.push(pair.iter().map(|&v| self.vertex_weights[v as usize]).sum());
        }
        Self { graph, edge_weights, vertex_weights, total: self.total }
    }

    /// The best of several cuts grown from vertices far apart.
    fn first_cut(&self) -> Vec<u8> {
        let n = self.graph.size();
        let mut best: Option<(u64, Vec<u8>)> = None;
        for seed in scattered(n).take(if self.total > LARGE { TRIALS_OF_LARGE } else { TRIALS }) {
            let mut part = self.grown(seed);
            self.improve(&mut part);
            let size = self.weights(&part)[SEPARATOR as usize];
            if best.as_ref().is_none_or(|(smallest, _)| size < *smallest) {
                best = Some((size, part));
            }
        }
        best.map_or_else(|| vec![LEFT; n], |(_, part)| part)
    }

    /// A cut whose left side is what a breadth-first search from `seed` reaches first, up to half of the
    /// weight.
    fn grown(&self, seed: u32) -> Vec<u8> {
        let n = self.graph.size();
        let mut part = vec![RIGHT; n];
        let mut queue = std::collections::VecDeque::from([seed]);
        let mut met = vec![false; n];
        met[seed as usize] = true;
        let mut weight = 0;
        while let Some(v) = queue.pop_front() {
            if 2 * weight >= self.total {
                break;
            }
            part[v as usize] = LEFT;
            weight += u64::from(self.vertex_weights[v as usize]);
            for &u in self.graph.of(v) {
                if !std::mem::replace(&mut met[u as usize], true) {
                    queue.push_back(u);
                }
            }
        }
        for v in 0..n {
            if part[v] == RIGHT && self.graph.of(v as u32).iter().any(|&u| part[u as usize] == LEFT) {
                part[v] = SEPARATOR;
            }
        }
        part
    }

    fn weights(&self, part: &[u8]) -> [u64; 3] {
        let mut sums = [0; 3];
        for (&p, &w) in part.iter().zip(&self.vertex_weights) {
            sums[p as usize] += u64::from(w);
        }
        sums
    }

    /// Makes the separator lighter by moving its vertices to a side; each vertex pulls its neighbors on the
    /// other side into the separator. The best moves come first, and intermediate states may be worse
    /// (Fiduccia & Mattheyses 1982). The sides stay balanced.
    fn improve(&self, part: &mut [u8]) {
        let mut moves = Moves {
            level: self,
            sums: self.weights(part),
            largest_side: self.total * 30 / 50,
            moved: vec![0; part.len()],
            heap: BinaryHeap::new(),
            log: Vec::new(),
        };
        for pass in 1..=PASSES {
            let before = moves.sums[2];
            moves.pass(part, pass as u8);
            if moves.sums[2] == before {
                break;
            }
        }
    }
}

/// The state of one improvement of a separator.
struct Moves<'a> {
    level: &'a Level,
    /// The weight of each side and of the separator.
    sums: [u64; 3],
    largest_side: u64,
    /// The last pass in which each vertex was moved out of the separator.
    moved: Vec<u8>,
    heap: BinaryHeap<(i64, u32, u8)>,
    /// The vertices changed since the best state, with their sides in it.
    log: Vec<(u32, u8)>,
}

impl Moves<'_> {
    fn weight(&self, v: u32) -> u64 {
        u64::from(self.level.vertex_weights[v as usize])
    }

    /// The gain of moving v out of the separator to `side`: its weight minus that of the vertices it pulls
    /// in.
    fn gain(&self, part: &[u8], v: u32, side: u8) -> i64 {
        let pulled = self.level.graph.of(v).iter().filter(|&&u| part[u as usize] == 1 - side);
        self.weight(v) as i64 - pulled.map(|&u| self.weight(u) as i64).sum::<i64>()
    }

    fn offer(&mut self, part: &[u8], v: u32) {
        for side in [LEFT, RIGHT] {
            self.heap.push((self.gain(part, v, side), v, side));
        }
    }

    fn pass(&mut self, part: &mut [u8], pass: u8) {
        self.heap.clear();
        self.log.clear();
        for v in 0..part.len() as u32 {
            if part[v as usize] == SEPARATOR {
                self.offer(part, v);
            }
        }
        let patience = 100 + self.heap.len() / 2;
        let score = |sums: [u64; 3]| (sums[2], sums[0].abs_diff(sums[1]));
        let (mut best, mut best_length) = (score(self.sums), 0);
        while let Some((claimed, v, side)) = self.heap.pop() {
            if part[v as usize] != SEPARATOR || self.moved[v as usize] == pass {
                continue;
            }
            if self.log.len() > best_length + patience {
                break;
            }
            let now = self.gain(part, v, side);
            if now != claimed {
                // A stale entry: it is queued again with its true gain.
                self.heap.push((now, v, side));
                continue;
            }
            if self.sums[side as usize] + self.weight(v) > self.largest_side {
                continue;
            }
            self.moved[v as usize] = pass;
            self.put(part, v, side);
            let level = self.level;
            for &u in level.graph.of(v) {
                if part[u as usize] == 1 - side {
                    self.put(part, u, SEPARATOR);
                    self.offer(part, u);
                    for &w in level.graph.of(u) {
                        if part[w as usize] == SEPARATOR && self.moved[w as usize] != pass {
                            self.offer(part, w);
                        }
                    }
                }
            }
            if score(self.sums) < best {
                (best, best_length) = (score(self.sums), self.log.len());
            }
        }
        while self.log.len() > best_length {
            let Some((v, was)) = self.log.pop() else { break };
            let weight = self.weight(v);
            self.sums[part[v as usize] as usize] -= weight;
            self.sums[was as usize] += weight;
            part[v as usize] = was;
        }
    }

    fn put(&mut self, part: &mut [u8], v: u32, side: u8) {
        let weight = self.weight(v);
        self.log.push((v, part[v as usize]));
        self.sums[part[v as usize] as usize] -= weight;
        self.sums[side as usize] += weight;
        part[v as usize] = side;
    }
}

/// All numbers of 0 .. n once, in a fixed order that is unrelated to the order of the mesh.
fn scattered(n: usize) -> impl Iterator<Item = u32> {
    let gcd = |mut a: usize, mut b: usize| {
        while b != 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    // About n / φ, and coprime to n.
    let mut step = (n as f64 * 0.618_034) as usize;
    while step > 1 && gcd(step, n) != 1 {
        step -= 1;
    }
    let step = step.max(1);
    let mut at = n - step;
    (0..n).map(move |_| {
        at = if at + step >= n { at + step - n } else { at + step };
        at as u32
    })
}
