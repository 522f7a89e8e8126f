//! Sparse symmetric matrices.

use crate::HarmonicsError;

/// A symmetric sparse matrix in compressed-column form. Both triangles are stored, with ascending rows in
/// each column; the matrix is therefore its own compressed-row form.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SymmetricSparse {
    /// Column j is entries `column_starts[j] .. column_starts[j + 1]`; n + 1 values.
    pub column_starts: Vec<usize>,
    /// Row of each entry.
    pub rows: Vec<u32>,
    /// Value of each entry.
    pub values: Vec<f64>,
}

impl SymmetricSparse {
    /// The n×n matrix with the sum of `entries` (i, j, value) at (i, j) and (j, i). Give each pair i ≠ j
    /// once, in either order. All of the diagonal is stored.
    ///
    /// # Errors
    /// [`HarmonicsError::BadPencil`] if an index is not less than n, a value is not finite, or n is too
    /// large for 32 bits.
    pub fn from_entries(
        n: usize,
        entries: impl IntoIterator<Item = (usize, usize, f64)>,
    ) -> Result<Self, HarmonicsError> {
        let bad = HarmonicsError::bad_pencil;
        if u32::try_from(n).is_err() {
            return Err(bad(format!("{n} rows are more than 32 bits can number")));
        }
        let mut all: Vec<(u32, u32, f64)> = (0..n as u32).map(|i| (i, i, 0.0)).collect();
        for (i, j, value) in entries {
            if i >= n || j >= n {
                return Err(bad(format!("there is an entry at ({i}, {j}) of a matrix of {n} rows")));
            }
            if !value.is_finite() {
                return Err(bad(format!("the entry at ({i}, {j}) is {value}")));
            }
            all.push((i as u32, j as u32, value));
            if i != j {
                all.push((j as u32, i as u32, value));
            }
        }
        // A stable sort: equal places are summed in the same order above and below the diagonal.
        all.sort_by_key(|(row, column, _)| (*column, *row));
        let mut matrix = Self { column_starts: vec![0; n + 1], ..Self::default() };
        for same in all.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let (row, column, _) = same[0];
            matrix.push(row, same.iter().map(|entry| entry.2).sum());
            matrix.column_starts[column as usize + 1] = matrix.rows.len();
        }
        Ok(matrix)
    }

    /// The n×n matrix of compressed columns: column j has `values` in the `rows` from `starts[j]` to
    /// `starts[j + 1]`, in any order; values at the same place are added. Values that mirror each other may
    /// differ by rounding, and their mean is used. `name` is what an error calls the matrix.
    ///
    /// # Errors
    /// [`HarmonicsError::BadPencil`] if `starts` does not describe columns, an index is not less than n, a
    /// value is not finite, or the matrix is not symmetric.
    pub fn from_columns(
        name: &str,
        starts: &[usize],
        rows: &[usize],
        values: &[f64],
    ) -> Result<Self, HarmonicsError> {
        let bad = HarmonicsError::bad_pencil;
        let n = starts.len().saturating_sub(1);
        let ascend = starts.first() == Some(&0) && starts.is_sorted() && starts.last() == Some(&rows.len());
        if !ascend || values.len() != rows.len() || u32::try_from(n).is_err() {
            return Err(bad(format!("the starts of the columns of {name} do not fit its entries")));
        }
        if let Some(at) = (0..rows.len()).find(|at| rows[*at] >= n || !values[*at].is_finite()) {
            let (row, value) = (rows[at], values[at]);
            return Err(bad(format!("{name} of {n} rows has {value} in row {row}")));
        }
        let mut matrix = Self { column_starts: vec![0], ..Self::default() };
        let mut column: Vec<(u32, f64)> = Vec::new();
        for j in 0..n {
            let range = starts[j]..starts[j + 1];
            column.clear();
            column.push((j as u32, 0.0));
            column
                .extend(rows[range.clone()].iter().zip(&values[range]).map(|(i, value)| (*i as u32, *value)));
            column.sort_by_key(|entry| entry.0);
            for same in column.chunk_by(|a, b| a.0 == b.0) {
                matrix.push(same[0].0, same.iter().map(|entry| entry.1).sum());
            }
            matrix.column_starts.push(matrix.rows.len());
        }
        matrix.mirrored(name)
    }

    /// The mean of the matrix and its transpose, which must agree up to rounding.
    fn mirrored(&self, name: &str) -> Result<Self, HarmonicsError> {
        let diagonal = self.diagonal();
        // Summing an entry of a positive semidefinite matrix loses a share of its diagonal values.
        let size = |i: usize, j: usize| (diagonal[i].abs() * diagonal[j].abs()).sqrt();
        // A place that only one triangle has gets its mirror image in the other.
        let mut transposed = self.transposed();
        let mut matrix = self.at_places_of(&transposed);
        transposed = transposed.at_places_of(self);
        for j in 0..self.size() {
            for at in matrix.column_starts[j]..matrix.column_starts[j + 1] {
                let (i, a, b) = (matrix.rows[at] as usize, matrix.values[at], transposed.values[at]);
                if (a - b).abs() > 1e-10 * a.abs().max(b.abs()) + 1e-12 * size(i, j) {
                    let reason = format!("{name} is not symmetric: {a} at ({i}, {j}), {b} at ({j}, {i})");
                    return Err(HarmonicsError::bad_pencil(reason));
                }
                matrix.values[at] = 0.5 * (a + b);
            }
        }
        Ok(matrix)
    }

    fn transposed(&self) -> Self {
        let n = self.size();
        let mut starts = vec![0; n + 1];
        self.rows.iter().for_each(|i| starts[*i as usize + 1] += 1);
        for j in 0..n {
            starts[j + 1] += starts[j];
        }
        let mut next = starts.clone();
        let mut out = Self {
            column_starts: starts,
            rows: vec![0; self.rows.len()],
            values: vec![0.0; self.rows.len()],
        };
        for j in 0..n {
            for (i, value) in self.column(j) {
                (out.rows[next[i]], out.values[next[i]]) = (j as u32, value);
                next[i] += 1;
            }
        }
        out
    }

    /// Checks that the matrix is symmetric and that all of its diagonal is stored; `name` is what an error
    /// calls the matrix.
    pub(crate) fn check(&self, name: &str) -> Result<(), HarmonicsError> {
        let bad = |reason: String| Err(HarmonicsError::bad_pencil(reason));
        let (n, entries) = (self.size(), self.rows.len());
        let starts = &self.column_starts;
        let ascend = starts.first() == Some(&0) && starts.is_sorted() && starts.last() == Some(&entries);
        if !ascend || self.values.len() != entries {
            return bad(format!("the starts of the columns of {name} do not fit its entries"));
        }
        for j in 0..n {
            let rows = &self.rows[starts[j]..starts[j + 1]];
            if !rows.is_sorted_by(|a, b| a < b) || rows.last().is_none_or(|last| *last as usize >= n) {
                return bad(format!("the rows in column {j} of {name} do not ascend, or go beyond {n}"));
            }
            if rows.binary_search(&(j as u32)).is_err() {
                return bad(format!("{name} stores no value at ({j}, {j})"));
            }
        }
        for j in 0..n {
            for (i, value) in self.column(j) {
                let mirrored = self.at(j, i).unwrap_or(0.0);
                let alike = (value - mirrored).abs() <= 1e-12 * value.abs().max(mirrored.abs());
                if !alike || !value.is_finite() {
                    return bad(format!(
                        "{name} is not symmetric: {value} at ({i}, {j}), {mirrored} at ({j}, {i})"
                    ));
                }
            }
        }
        Ok(())
    }

    /// The value stored in row i of column j, if there is one.
    fn at(&self, i: usize, j: usize) -> Option<f64> {
        let range = self.column_starts[j]..self.column_starts[j + 1];
        let place = self.rows[range.clone()].binary_search(&(i as u32)).ok()?;
        Some(self.values[range.start + place])
    }

    /// The matrix plus `factor` times the diagonal matrix of `diagonal`. All of its own diagonal must be
    /// stored.
    pub(crate) fn plus_diagonal(&self, diagonal: &[f64], factor: f64) -> Self {
        let mut sum = self.clone();
        for (j, d) in diagonal.iter().enumerate() {
            for place in sum.column_starts[j]..sum.column_starts[j + 1] {
                if sum.rows[place] as usize == j {
                    sum.values[place] += factor * d;
                }
            }
        }
        sum
    }

    /// The matrix plus `factor` times `other`, which must have the same places (see
    /// [`at_places_of`](Self::at_places_of)).
    pub(crate) fn plus(&self, other: &Self, factor: f64) -> Self {
        let values = self.values.iter().zip(&other.values).map(|(a, b)| a + factor * b).collect();
        Self { values, ..self.clone() }
    }

    /// The matrix with zeros stored at all places where only `other`, of the same size, has entries.
    pub(crate) fn at_places_of(&self, other: &Self) -> Self {
        let mut all = Self { column_starts: vec![0], ..Self::default() };
        for j in 0..self.size() {
            let mut theirs = other.column(j).map(|(i, _)| i).peekable();
            for (i, value) in self.column(j) {
                while let Some(before) = theirs.next_if(|row| *row < i) {
                    all.push(before as u32, 0.0);
                }
                theirs.next_if(|row| *row == i);
                all.push(i as u32, value);
            }
            theirs.for_each(|row| all.push(row as u32, 0.0));
            all.column_starts.push(all.rows.len());
        }
        all
    }

    /// Sums `edges` (i, j, w), i ≠ j, as −w at (i, j) and (j, i) and +w at (i, i) and (j, j):
    /// the weighted graph Laplacian of n vertices, whose rows sum to zero. Every diagonal
    /// entry is present.
    pub(crate) fn laplacian(n: usize, edges: &[(u32, u32, f64)]) -> Self {
        let mut starts = vec![0_usize; n + 1];
        for &(i, j, _) in edges {
            starts[i as usize + 1] += 1;
            starts[j as usize + 1] += 1;
        }
        for j in 0..n {
            starts[j + 1] += starts[j];
        }
        let mut next = starts.clone();
        let mut entries = vec![(0_u32, 0.0); edges.len() * 2];
        for &(i, j, w) in edges {
            for (row, column) in [(i, j), (j, i)] {
                entries[next[column as usize]] = (row, w);
                next[column as usize] += 1;
            }
        }
        let mut matrix = Self {
            column_starts: Vec::with_capacity(n + 1),
            rows: Vec::with_capacity(edges.len() + n),
            values: Vec::with_capacity(edges.len() + n),
        };
        matrix.column_starts.push(0);
        for j in 0..n {
            let column = &mut entries[starts[j]..starts[j + 1]];
            // A stable sort: equal rows are summed in the same order above and below the diagonal.
            column.sort_by_key(|e| e.0);
            let first = matrix.rows.len();
            let mut diagonal_at = None;
            for &(row, w) in column.iter() {
                if diagonal_at.is_none() && row as usize > j {
                    diagonal_at = Some(matrix.rows.len());
                    matrix.push(j as u32, 0.0);
                }
                if matrix.rows.len() > first && matrix.rows.last() == Some(&row) {
                    if let Some(value) = matrix.values.last_mut() {
                        *value -= w;
                    }
                } else {
                    matrix.push(row, -w);
                }
            }
            let diagonal_at = diagonal_at.unwrap_or_else(|| {
                matrix.push(j as u32, 0.0);
                matrix.rows.len() - 1
            });
            matrix.values[diagonal_at] = -matrix.values[first..].iter().sum::<f64>();
            matrix.column_starts.push(matrix.rows.len());
        }
        matrix
    }

    fn push(&mut self, row: u32, value: f64) {
        self.rows.push(row);
        self.values.push(value);
    }

    /// n, the number of rows and columns.
    pub fn size(&self) -> usize {
        self.column_starts.len().saturating_sub(1)
    }

    /// Rows and values of column j.
    ///
    /// # Panics
    /// If j ≥ n.
    pub fn column(&self, j: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let range = self.column_starts[j]..self.column_starts[j + 1];
        self.rows[range.clone()].iter().zip(&self.values[range]).map(|(&r, &v)| (r as usize, v))
    }

    /// The matrix times `x`, n values.
    ///
    /// # Panics
    /// If `x` has fewer than n values and one that is missing is needed.
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        (0..self.size()).map(|j| self.column(j).map(|(i, v)| v * x[i]).sum()).collect()
    }
}

impl SymmetricSparse {
    /// The diagonal, n values.
    pub fn diagonal(&self) -> Vec<f64> {
        (0..self.size()).map(|j| self.at(j, j).unwrap_or(0.0)).collect()
    }

    /// The largest diagonal value.
    pub(crate) fn largest_diagonal(&self) -> f64 {
        self.diagonal().into_iter().fold(0.0, f64::max)
    }

    /// For each row its connected component; components are numbered from 0 in order of appearance.
    pub(crate) fn components(&self) -> Vec<u32> {
        let mut component = vec![u32::MAX; self.size()];
        let (mut count, mut reached) = (0, Vec::new());
        for first in 0..self.size() {
            if component[first] != u32::MAX {
                continue;
            }
            component[first] = count;
            reached.push(first);
            while let Some(j) = reached.pop() {
                for (i, _) in self.column(j) {
                    if component[i] == u32::MAX {
                        component[i] = count;
                        reached.push(i);
                    }
                }
            }
            count += 1;
        }
        component
    }

    /// The rows and columns of `vertices`, which no entry connects with others. Vertex v gets the number
    /// `local[v]`.
    pub(crate) fn block(&self, vertices: &[u32], local: &[u32]) -> Self {
        let mut out = Self { column_starts: vec![0], ..Self::default() };
        for &v in vertices {
            let range = self.column_starts[v as usize]..self.column_starts[v as usize + 1];
            out.rows.extend(self.rows[range.clone()].iter().map(|&i| local[i as usize]));
            out.values.extend(&self.values[range]);
            out.column_starts.push(out.rows.len());
        }
        out
    }

    /// D P A Pᵀ D: row and column i are the old `old[i]`, and each value is multiplied by the `scale` of
    /// its old row and column.
    pub(crate) fn permuted_and_scaled(&self, old: &[u32], scale: &[f64]) -> Self {
        let n = old.len();
        let mut new = vec![0_u32; n];
        for (i, &o) in old.iter().enumerate() {
            new[o as usize] = i as u32;
        }
        let mut out = Self {
            column_starts: Vec::with_capacity(n + 1),
            rows: Vec::with_capacity(self.rows.len()),
            values: Vec::with_capacity(self.values.len()),
        };
        out.column_starts.push(0);
        let mut column = Vec::new();
        for &o in old {
            column.clear();
            let s = scale[o as usize];
            // Symmetric to the last bit, because the two scales are multiplied first.
            column.extend(self.column(o as usize).map(|(i, v)| (new[i], (scale[i] * s) * v)));
            column.sort_unstable_by_key(|e| e.0);
            out.rows.extend(column.iter().map(|e| e.0));
            out.values.extend(column.iter().map(|e| e.1));
            out.column_starts.push(out.rows.len());
        }
        out
    }
}
