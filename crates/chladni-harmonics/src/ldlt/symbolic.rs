//! The pattern of L: elimination tree, supernodes and their rows.

use super::panel::diagonal_len;
use crate::SymmetricSparse;

/// Consecutive columns of L that share the rows below them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Supernode {
    /// The first column and the number of columns.
    pub first: usize,
    pub width: usize,
    /// The rows below it are `rows[rows_start ..][.. below]` of the analysis.
    pub rows_start: usize,
    pub below: usize,
    /// The start of its values of L: the diagonal block, followed by the values below it (see
    /// [`super::panel`]).
    pub values_start: usize,
    /// The number of its children in the tree. In postorder they are the last supernodes that were finished
    /// and not used yet.
    pub children: usize,
}

/// The analysis of one pattern, valid for every shift.
#[derive(Debug)]
pub(crate) struct Symbolic {
    /// For each new index the old one: the elimination order, postordered.
    pub old: Vec<u32>,
    pub supernodes: Vec<Supernode>,
    /// The rows below each supernode, ascending, in new indices.
    pub rows: Vec<u32>,
    /// For each of `rows`, its place in the front of the supernode's parent.
    pub into_parent: Vec<u32>,
    /// Number of stored values of L.
    pub values: usize,
}

const NONE: u32 = u32::MAX;

impl Symbolic {
    /// Analyzes `matrix`, eliminated in the order `old` (the old index for each new one).
    pub(crate) fn of(matrix: &SymmetricSparse, old: Vec<u32>) -> Self {
        let (lower, parent) = lower_rows_and_tree(matrix, &old);
        let counts = column_counts(&lower, &parent);
        // Children come before their parents, and siblings are adjacent.
        let post = postorder(&parent);
        let place = inverse(&post);
        let parent: Vec<u32> = post
            .iter()
            .map(|&v| match parent[v as usize] {
                NONE => NONE,
                up => place[up as usize],
            })
            .collect();
        let counts = renamed(&post, &counts);
        let (order, spans) = supernodes(&parent, &counts);
        let order = renamed(&order, &post);
        let lower = lower.renamed(&order);
        Self::with_rows(renamed(&order, &old), &lower, &spans)
    }

    fn with_rows(old: Vec<u32>, lower: &Rows, spans: &[(usize, usize)]) -> Self {
        let n = old.len();
        let mut of_column = vec![0_u32; n];
        for (s, &(first, end)) in spans.iter().enumerate() {
            of_column[first..end].fill(s as u32);
        }
        // The columns of the lower triangle, from its rows.
        let columns = lower.transposed();
        let mut mark = vec![NONE; n];
        let mut children: Vec<Vec<u32>> = vec![Vec::new(); spans.len()];
        let mut supernodes: Vec<Supernode> = Vec::with_capacity(spans.len());
        let mut rows: Vec<u32> = Vec::new();
        let mut values_start = 0;
        for (s, &(first, end)) in spans.iter().enumerate() {
            let rows_start = rows.len();
            for j in first..end {
                for &i in columns.of(j) {
                    if i as usize >= end && mark[i as usize] != s as u32 {
                        mark[i as usize] = s as u32;
                        rows.push(i);
                    }
                }
            }
            for &child in &children[s] {
                let c = supernodes[child as usize];
                for at in c.rows_start..c.rows_start + c.below {
                    let i = rows[at];
                    if i as usize >= end && mark[i as usize] != s as u32 {
                        mark[i as usize] = s as u32;
                        rows.push(i);
                    }
                }
            }
            rows[rows_start..].sort_unstable();
            let (width, below) = (end - first, rows.len() - rows_start);
            if let Some(&i) = rows.get(rows_start) {
                children[of_column[i as usize] as usize].push(s as u32);
            }
            supernodes.push(Supernode {
                first,
                width,
                rows_start,
                below,
                values_start,
                children: children[s].len(),
            });
            values_start += diagonal_len(width) + width * below;
        }
        let mut into_parent = vec![0_u32; rows.len()];
        let mut place = vec![0_u32; n];
        for (s, node) in supernodes.iter().enumerate() {
            for (at, &i) in rows[node.rows_start..node.rows_start + node.below].iter().enumerate() {
                place[i as usize] = (node.width + at) as u32;
            }
            for &child in &children[s] {
                let c = supernodes[child as usize];
                for at in c.rows_start..c.rows_start + c.below {
                    let i = rows[at] as usize;
                    into_parent[at] =
                        if i < node.first + node.width { (i - node.first) as u32 } else { place[i] };
                }
            }
        }
        Self { old, supernodes, rows, into_parent, values: values_start }
    }

    /// The bytes of a factor, and of the largest front while it is computed.
    pub(crate) fn bytes(&self) -> u64 {
        let front = self.supernodes.iter().map(|node| node.width + node.below).max().unwrap_or(0) as u64;
        8 * (self.values as u64 + front * front)
    }

    /// n.
    pub(crate) fn size(&self) -> usize {
        self.old.len()
    }
}

/// Lists of indices, one per row.
struct Rows {
    starts: Vec<usize>,
    indices: Vec<u32>,
}

impl Rows {
    fn of(&self, i: usize) -> &[u32] {
        &self.indices[self.starts[i]..self.starts[i + 1]]
    }

    /// The lower triangle of the same matrix in another order that keeps children before parents.
    fn renamed(&self, order: &[u32]) -> Self {
        let new = inverse(order);
        let ends = |i: usize, j: u32| {
            let (a, b) = (new[i], new[j as usize]);
            (a.max(b) as usize, a.min(b))
        };
        let mut starts = vec![0; order.len() + 1];
        for i in 0..order.len() {
            self.of(i).iter().for_each(|&j| starts[ends(i, j).0 + 1] += 1);
        }
        for i in 0..order.len() {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut indices = vec![0; self.indices.len()];
        for i in 0..order.len() {
            for &j in self.of(i) {
                let (row, column) = ends(i, j);
                indices[next[row]] = column;
                next[row] += 1;
            }
        }
        Self { starts, indices }
    }

    fn transposed(&self) -> Self {
        let n = self.starts.len() - 1;
        let mut starts = vec![0; n + 1];
        for &j in &self.indices {
            starts[j as usize + 1] += 1;
        }
        for j in 0..n {
            starts[j + 1] += starts[j];
        }
        let mut next = starts.clone();
        let mut indices = vec![0; self.indices.len()];
        for i in 0..n {
            for &j in self.of(i) {
                indices[next[j as usize]] = i as u32;
                next[j as usize] += 1;
            }
        }
        Self { starts, indices }
    }
}

/// The entries left of the diagonal in each row of the new order, and the elimination tree (Liu 1990, with
/// path compression).
fn lower_rows_and_tree(matrix: &SymmetricSparse, old: &[u32]) -> (Rows, Vec<u32>) {
    let n = old.len();
    let new = inverse(old);
    let mut rows =
        Rows { starts: Vec::with_capacity(n + 1), indices: Vec::with_capacity(matrix.rows.len() / 2) };
    rows.starts.push(0);
    let mut parent = vec![NONE; n];
    let mut ancestor = vec![NONE; n];
    for i in 0..n {
        for (o, _) in matrix.column(old[i] as usize) {
            let k = new[o];
            if k as usize >= i {
                continue;
            }
            rows.indices.push(k);
            let mut j = k;
            while ancestor[j as usize] != i as u32 {
                let up = ancestor[j as usize];
                ancestor[j as usize] = i as u32;
                if up == NONE {
                    parent[j as usize] = i as u32;
                    break;
                }
                j = up;
            }
        }
        rows.starts.push(rows.indices.len());
    }
    (rows, parent)
}

/// The vertices of a forest, with children before parents and each subtree contiguous.
fn postorder(parent: &[u32]) -> Vec<u32> {
    let n = parent.len();
    // Children as linked lists, in ascending order.
    let (mut first_child, mut sibling) = (vec![NONE; n], vec![NONE; n]);
    for v in (0..n).rev() {
        if parent[v] != NONE {
            sibling[v] = first_child[parent[v] as usize];
            first_child[parent[v] as usize] = v as u32;
        }
    }
    let mut order = Vec::with_capacity(n);
    let mut stack = Vec::new();
    for root in (0..n as u32).filter(|&v| parent[v as usize] == NONE) {
        stack.push(root);
        while let Some(&v) = stack.last() {
            let child = first_child[v as usize];
            if child == NONE {
                order.push(v);
                stack.pop();
            } else {
                first_child[v as usize] = sibling[child as usize];
                stack.push(child);
            }
        }
    }
    order
}

/// The number of entries below the diagonal in each column of L, by climbing the tree from the entries of
/// each row.
fn column_counts(lower: &Rows, parent: &[u32]) -> Vec<u32> {
    let n = parent.len();
    let mut count = vec![0; n];
    let mut mark = vec![NONE; n];
    for i in 0..n {
        mark[i] = i as u32;
        for &k in lower.of(i) {
            let mut j = k as usize;
            while mark[j] != i as u32 {
                mark[j] = i as u32;
                count[j] += 1;
                j = parent[j] as usize;
            }
        }
    }
    count
}

/// The overhead of a supernode in a solve, in stored values: merging two supernodes is worth this many
/// stored zeros.
const OVERHEAD: usize = 32;

/// A group of columns that are eliminated together.
struct Group {
    columns: Vec<u32>,
    below: usize,
    parent: u32,
}

/// An order of the columns of a postordered tree, and its partition into supernodes, as (first, end).
/// Columns with equal rows are joined, and a supernode is merged with its parent if the additional stored
/// zeros cost less than a separate supernode (Ashcraft & Grimes 1989).
fn supernodes(parent: &[u32], counts: &[u32]) -> (Vec<u32>, Vec<(usize, usize)>) {
    let n = parent.len();
    let mut groups: Vec<Group> = Vec::new();
    let mut of_column = vec![0_u32; n];
    for j in 0..n {
        let joins = j > 0 && parent[j - 1] == j as u32 && counts[j - 1] == counts[j] + 1;
        match groups.last_mut() {
            Some(last) if joins => {
                last.columns.push(j as u32);
                last.below = counts[j] as usize;
            }
            _ => groups.push(Group { columns: vec![j as u32], below: counts[j] as usize, parent: NONE }),
        }
        of_column[j] = (groups.len() - 1) as u32;
    }
    let mut children: Vec<Vec<u32>> = vec![Vec::new(); groups.len()];
    for g in 0..groups.len() {
        let up = groups[g].columns.last().map_or(NONE, |&last| parent[last as usize]);
        if up != NONE {
            groups[g].parent = of_column[up as usize];
            children[of_column[up as usize] as usize].push(g as u32);
        }
    }
    // Children come before parents: each child is already complete.
    for g in 0..groups.len() {
        let mut own = std::mem::take(&mut children[g]);
        own.sort_by_key(|&c| std::cmp::Reverse(groups[c as usize].below));
        let mut kept = Vec::with_capacity(own.len());
        for c in own {
            let (wc, w) = (groups[c as usize].columns.len(), groups[g].columns.len());
            let zeros = wc * (w + groups[g].below - groups[c as usize].below);
            if zeros > OVERHEAD {
                kept.push(c);
                continue;
            }
            let mut columns = std::mem::take(&mut groups[c as usize].columns);
            columns.append(&mut groups[g].columns);
            groups[g].columns = columns;
            kept.append(&mut children[c as usize]);
        }
        for &c in &kept {
            groups[c as usize].parent = g as u32;
        }
        children[g] = kept;
    }
    let merged: Vec<u32> =
        (0..groups.len() as u32).filter(|&g| !groups[g as usize].columns.is_empty()).collect();
    let mut place = vec![NONE; groups.len()];
    for (at, &g) in merged.iter().enumerate() {
        place[g as usize] = at as u32;
    }
    let up = |g: u32| groups[g as usize].parent;
    let tree: Vec<u32> =
        merged.iter().map(|&g| if up(g) == NONE { NONE } else { place[up(g) as usize] }).collect();
    let (mut order, mut spans) = (Vec::with_capacity(n), Vec::with_capacity(merged.len()));
    for at in postorder(&tree) {
        let first = order.len();
        order.extend(&groups[merged[at as usize] as usize].columns);
        spans.push((first, order.len()));
    }
    (order, spans)
}

/// `values` in the new order.
fn renamed(order: &[u32], values: &[u32]) -> Vec<u32> {
    order.iter().map(|&v| values[v as usize]).collect()
}

/// For each old index the new one.
fn inverse(order: &[u32]) -> Vec<u32> {
    let mut new = vec![0; order.len()];
    for (i, &v) in order.iter().enumerate() {
        new[v as usize] = i as u32;
    }
    new
}
