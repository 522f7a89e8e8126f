//! Functional maps between two shapes (Ovsjanikov et al. 2012), their conversion from and to point maps,
//! and refinement by ZoomOut (Melzi et al. 2019).

use chladni_task::Task;
use faer::MatRef;
use rayon::prelude::*;

use crate::HarmonicsError;
use crate::least_squares::{least_squares, product};
use crate::nearest::nearest;

/// The first eigenvectors of a shape, at all of its vertices or at a sample of them.
#[derive(Clone, Copy, Debug)]
pub struct Eigenvectors<'a> {
    /// n ≥ 1, the number of vertices.
    pub vertices: usize,
    /// n × K values, column-major; finite.
    pub values: &'a [f64],
}

/// The K₂ × K₁ matrix C that maps coefficients on shape 1 to coefficients on shape 2.
#[derive(Clone, Debug, PartialEq)]
pub struct FunctionalMap {
    /// K₂, the number of rows.
    pub rows: usize,
    /// K₁, the number of columns.
    pub columns: usize,
    /// C, column-major; finite.
    pub values: Vec<f64>,
}

impl<'a> Eigenvectors<'a> {
    /// K, the number of eigenvectors.
    pub fn count(&self) -> usize {
        self.values.len() / self.vertices.max(1)
    }

    /// The first `count` ≤ K eigenvectors.
    fn first(&self, count: usize) -> MatRef<'a, f64> {
        MatRef::from_column_major_slice(&self.values[..count * self.vertices], self.vertices, count)
    }
}

impl FunctionalMap {
    /// For each vertex of shape 2 the corresponding vertex of shape 1: the one whose row of Φ₁ Cᵀ is
    /// nearest to its row of Φ₂, or, with `adjoint`, whose row of Φ₁ is nearest to its row of Φ₂ C.
    ///
    /// # Errors
    /// Fewer eigenvectors than C has columns or rows, a shape without vertices, or a cancelled task.
    pub fn to_point_map(
        &self,
        source: Eigenvectors,
        target: Eigenvectors,
        adjoint: bool,
        task: &Task,
    ) -> Result<Vec<u32>, HarmonicsError> {
        self.point_map(source, target, adjoint, &[], task)
    }

    fn point_map(
        &self,
        source: Eigenvectors,
        target: Eigenvectors,
        adjoint: bool,
        guesses: &[u32],
        task: &Task,
    ) -> Result<Vec<u32>, HarmonicsError> {
        enough(source, self.columns, "source")?;
        enough(target, self.rows, "target")?;
        if self.values.len() != self.rows * self.columns || self.values.is_empty() {
            return Err(bad(format!(
                "{} values are no {} × {} matrix",
                self.values.len(),
                self.rows,
                self.columns
            )));
        }
        let map = MatRef::from_column_major_slice(&self.values, self.rows, self.columns);
        let (from, to) = (source.first(self.columns), target.first(self.rows));
        let (points, queries) = if adjoint {
            (row_major(from), row_major(product(to, map).as_ref()))
        } else {
            (row_major(product(from, map.transpose()).as_ref()), row_major(to))
        };
        let dimensions = if adjoint { self.columns } else { self.rows };
        // If distances are not finite, there is no nearest vertex.
        if !points.iter().chain(&queries).all(|x| x.abs() < 1e150) {
            return Err(bad("the map or the eigenvectors are too large to compute distances with".into()));
        }
        Ok(nearest(&points, &queries, dimensions, guesses, task)?)
    }

    /// The functional map C of a point map, which gives for each of the n₂ vertices of shape 2 a vertex of
    /// shape 1. With `dual` = M₂ Φ₂, stored like the eigenvectors, C is (M₂ Φ₂)ᵀ Φ₁(map); without it, C is
    /// the least-squares solution of Φ₂ C = Φ₁(map), and the smallest of them where the eigenvectors Φ₂ depend on each
    /// other.
    ///
    /// # Errors
    /// A map or dual with another number of vertices, or a vertex that shape 1 does not have.
    pub fn of_point_map(
        map: &[u32],
        source: Eigenvectors,
        target: Eigenvectors,
        dual: Option<&[f64]>,
    ) -> Result<Self, HarmonicsError> {
        let values = target.vertices * target.count();
        if dual.is_some_and(|dual| dual.len() != values) {
            return Err(bad(format!("M Φ has another number of values than the target's Φ, {values}")));
        }
        Self::of_first(map, source, target, dual, [target.count(), source.count()])
    }

    fn of_first(
        map: &[u32],
        source: Eigenvectors,
        target: Eigenvectors,
        dual: Option<&[f64]>,
        [rows, columns]: [usize; 2],
    ) -> Result<Self, HarmonicsError> {
        enough(source, columns, "source")?;
        enough(target, rows, "target")?;
        let n = target.vertices;
        if map.len() != n {
            return Err(bad(format!("the map has {} values, the target {n} vertices", map.len())));
        }
        if dual.is_some_and(|dual| dual.len() < n * rows) {
            return Err(bad(format!("M has other than {n} rows, the target's number of vertices")));
        }
        if let Some(v) = map.iter().find(|v| **v as usize >= source.vertices) {
            let (vertex, vertices) = (*v as usize, source.vertices);
            return Err(HarmonicsError::NotOnSurface { vertex, vertices, reason: "the map leads to it" });
        }
        let mut pulled: Vec<f64> = vec![0.0; n * columns];
        pulled
            .par_chunks_exact_mut(n)
            .zip(source.values.par_chunks_exact(source.vertices))
            .for_each(|(out, h)| out.iter_mut().zip(map).for_each(|(out, v)| *out = h[*v as usize]));
        let pulled = MatRef::from_column_major_slice(&pulled, n, columns);
        let found = match dual {
            Some(dual) => {
                let dual = MatRef::from_column_major_slice(&dual[..n * rows], n, rows);
                product(dual.transpose(), pulled)
            }
            None if n < rows => {
                return Err(bad(format!("{rows} eigenvectors on {n} vertices leave the map undetermined")));
            }
            None => least_squares(target.first(rows), pulled).ok_or_else(|| {
                bad("the singular values of the target's eigenvectors were not found".into())
            })?,
        };
        let values =
            found.col_iter().flat_map(|column| column.iter().copied().collect::<Vec<f64>>()).collect();
        Ok(Self { rows, columns, values })
    }

    /// Refines C by ZoomOut: `rounds` conversions to a point map and back, each with `step` = [for K₂, for
    /// K₁] more eigenvectors than before.
    ///
    /// # Errors
    /// Those of [`to_point_map`](Self::to_point_map) and [`of_point_map`](Self::of_point_map), where each
    /// shape needs K + rounds · step eigenvectors; a cancelled task.
    pub fn zoomed_out(
        &self,
        source: Eigenvectors,
        target: Eigenvectors,
        dual: Option<&[f64]>,
        rounds: usize,
        step: [usize; 2],
        task: &Task,
    ) -> Result<Self, HarmonicsError> {
        let last = |from: usize, step: usize| rounds.saturating_mul(step).saturating_add(from);
        enough(source, last(self.columns, step[1]), "source")?;
        enough(target, last(self.rows, step[0]), "target")?;
        let stage = task.stage("ZoomOut", rounds as u64);
        let mut refined = self.clone();
        let mut points = Vec::new();
        for _ in 0..rounds {
            task.check()?;
            points = refined.point_map(source, target, false, &points, task)?;
            let size = [refined.rows + step[0], refined.columns + step[1]];
            refined = Self::of_first(&points, source, target, dual, size)?;
            stage.advance(1);
        }
        Ok(refined)
    }
}

fn bad(reason: String) -> HarmonicsError {
    HarmonicsError::BadMap { reason }
}

fn enough(given: Eigenvectors, needed: usize, side: &str) -> Result<(), HarmonicsError> {
    let count = given.count();
    if given.vertices == 0 || needed > count {
        return Err(bad(format!("{needed} eigenvectors of the {side} are needed, {count} are given")));
    }
    Ok(())
}

fn row_major(matrix: MatRef<f64>) -> Vec<f64> {
    let columns = matrix.ncols();
    let mut rows = vec![0.0; matrix.nrows() * columns];
    rows.par_chunks_exact_mut(columns.max(1)).enumerate().for_each(|(i, row)| {
        for (j, value) in row.iter_mut().enumerate() {
            *value = matrix[(i, j)];
        }
    });
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::threads::on_threads;
    use crate::{BasisSettings, Body};
    use chladni_mesh::samples;

    /// Eigenvectors of a shape without symmetries.
    fn basis() -> Body {
        let mut shape = samples::icosphere(3);
        for p in &mut shape.positions {
            *p = [p[0] * (1.3 + 0.3 * p[1]), p[1] + 0.2 * p[0] * p[2], 0.8 * p[2] + 0.2 * p[0] * p[0]];
        }
        Body::build(&shape, &BasisSettings::new(40), &Task::new()).unwrap()
    }

    #[test]
    fn a_shape_with_itself_is_mapped_by_one() {
        let body = basis();
        let n = body.positions.len();
        let vectors = Eigenvectors { vertices: n, values: &body.basis.vectors };
        // The vertices of the same shape in another order.
        let shuffled: Vec<u32> = (0..n).map(|v| ((v * 101) % n) as u32).collect();
        let values: Vec<f64> = (0..40)
            .flat_map(|k| shuffled.iter().map(|v| body.basis.harmonic(k)[*v as usize]).collect::<Vec<_>>())
            .collect();
        let target = Eigenvectors { vertices: n, values: &values };
        let mass = |row: usize| body.basis.mass[shuffled[row] as usize];
        let dual: Vec<f64> = values.iter().enumerate().map(|(at, h)| mass(at % n) * h).collect();
        for dual in [Some(&dual[..]), None] {
            let map = FunctionalMap::of_point_map(&shuffled, vectors, target, dual).unwrap();
            for j in 0..40 {
                for i in 0..40 {
                    let one = f64::from(u8::from(i == j));
                    assert!((map.values[40 * j + i] - one).abs() < 1e-8, "{i} {j}");
                }
            }
            for adjoint in [false, true] {
                assert_eq!(map.to_point_map(vectors, target, adjoint, &Task::new()).unwrap(), shuffled);
            }
            // Start from the signs of five functions, and refine to all forty.
            let start = FunctionalMap {
                rows: 5,
                columns: 5,
                values: (0..25).map(|i| f64::from(u8::from(i % 6 == 0))).collect(),
            };
            let refined = start.zoomed_out(vectors, target, dual, 7, [5, 5], &Task::new()).unwrap();
            assert_eq!((refined.rows, refined.columns), (40, 40));
            assert_eq!(refined.to_point_map(vectors, target, false, &Task::new()).unwrap(), shuffled);
        }
    }

    #[test]
    fn threads_change_no_bit() {
        let body = basis();
        let n = body.positions.len();
        let vectors = Eigenvectors { vertices: n, values: &body.basis.vectors };
        let start = FunctionalMap {
            rows: 5,
            columns: 5,
            values: (0..25).map(|i| (f64::from(i) * 0.7).cos()).collect(),
        };
        let on = |threads: usize| {
            on_threads(Some(threads), || start.zoomed_out(vectors, vectors, None, 7, [5, 5], &Task::new()))
                .unwrap()
                .unwrap()
        };
        let one = on(1);
        assert!([2, 5].into_iter().all(|threads| on(threads) == one));
    }

    #[test]
    fn eigenvectors_that_depend_on_each_other_give_the_smallest_map() {
        let source = [0.5, 0.5, 0.5, 0.5, 0.5, -0.5, 0.5, -0.5];
        let source = Eigenvectors { vertices: 4, values: &source };
        // Beside the constant, nothing; and the constant twice.
        for (second, exact) in [(0.0, [1.0, 0.0, 0.0, 0.0]), (0.5, [0.5, 0.5, 0.0, 0.0])] {
            let target = [0.5, 0.5, 0.5, 0.5, second, second, second, second];
            let target = Eigenvectors { vertices: 4, values: &target };
            let map = FunctionalMap::of_point_map(&[0, 1, 2, 3], source, target, None).unwrap();
            for (value, exact) in map.values.iter().zip(exact) {
                assert!((value - exact).abs() < 1e-12, "{:?}", map.values);
            }
        }
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let values = [1.0, 0.5, -0.5, 0.25, 0.1, 0.7];
        let (three, two) = (
            Eigenvectors { vertices: 3, values: &values },
            Eigenvectors { vertices: 2, values: &values[..4] },
        );
        let map = FunctionalMap { rows: 2, columns: 2, values: vec![1.0, 0.0, 0.0, 1.0] };
        assert_eq!(map.to_point_map(three, two, false, &Task::new()).unwrap().len(), 2);
        assert!(
            FunctionalMap { rows: 3, ..map.clone() }.to_point_map(three, two, false, &Task::new()).is_err()
        );
        let huge = FunctionalMap { values: vec![1e200, 0.0, 0.0, 1e200], ..map.clone() };
        assert!(huge.to_point_map(three, two, false, &Task::new()).is_err());
        assert!(
            FunctionalMap { values: vec![1.0], ..map.clone() }
                .to_point_map(three, two, false, &Task::new())
                .is_err()
        );
        assert!(map.zoomed_out(three, two, None, 1, [1, 1], &Task::new()).is_err());
        assert!(FunctionalMap::of_point_map(&[0, 3], three, two, None).is_err());
        assert!(FunctionalMap::of_point_map(&[0], three, two, None).is_err());
        for length in [1, 3, 5, 6] {
            let dual = Some(&values[..length]);
            assert!(FunctionalMap::of_point_map(&[0, 1], three, two, dual).is_err(), "{length}");
        }
        let none = Eigenvectors { vertices: 0, values: &[] };
        assert!(map.to_point_map(none, two, false, &Task::new()).is_err());
        let cancelled = Task::new();
        cancelled.cancel();
        assert_eq!(
            map.zoomed_out(three, two, None, 1, [0, 0], &cancelled),
            Err(HarmonicsError::Cancelled(chladni_task::Cancelled))
        );
    }
}
