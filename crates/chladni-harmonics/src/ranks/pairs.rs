//! Combines the results that the ranks leave in their folder.

use std::fs::{self, File};
use std::io::{BufReader, Read};
use std::path::Path;

use chladni_task::Task;
use serde::Deserialize;

use super::{GAP, RanksSeconds};
use crate::eigen::{CLUSTER, cluster_end};
use crate::values::{Keep, Values};
use crate::{BasisSettings, HarmonicsError, memory};

/// The result of one rank.
#[derive(Deserialize)]
struct Part {
    rows: [usize; 2],
    eigenvalues: Vec<f64>,
    counts: Vec<(f64, usize)>,
    #[serde(default)]
    searches: usize,
    peak_bytes: u64,
    #[serde(default)]
    factor_entries: f64,
    #[serde(default)]
    factor_flops: f64,
    seconds: RanksSeconds,
}

/// The combined results of all ranks: the pairs of A = M^-½ S M^-½ with λ above 0.
#[derive(Default)]
pub(super) struct Pairs {
    pub(super) eigenvalues: Vec<f64>,
    /// Columns of zeros for the constants, followed by the N values of each pair as far as the group of the K-th goes.
    pub(super) vectors: Values,
    pub(super) counts: Vec<(f64, usize)>,
    pub(super) searches: usize,
    pub(super) peak_bytes: Vec<u64>,
    pub(super) factor: [f64; 2],
    pub(super) seconds: RanksSeconds,
}

impl Pairs {
    /// Reads what the ranks left, for a K above `zeros`.
    pub(super) fn read(
        folder: &Path,
        ranks: usize,
        n: usize,
        zeros: usize,
        keep: Keep,
        settings: &BasisSettings,
        task: &Task,
    ) -> Result<Self, HarmonicsError> {
        let mut pairs = Self::default();
        let mut next_row = 0;
        for rank in 0..ranks {
            let bad = |what: &str| HarmonicsError::RanksFailed { reason: format!("rank {rank} left {what}") };
            let json = fs::read(folder.join(format!("rank-{rank}.json"))).map_err(|_| bad("no result"))?;
            let part: Part =
                serde_json::from_slice(&json).map_err(|_| bad("a result that cannot be read"))?;
            if rank == 0 {
                // The ranks may find more than is wanted. There are none below λ = 0, and their last bound lies beyond a gap.
                const { assert!(CLUSTER < GAP) };
                let columns = zeros + cluster_end(&part.eigenvalues, settings.harmonics - zeros);
                pairs.vectors = memory::vectors(n, columns, keep, memory::free(settings))?;
                (pairs.eigenvalues, pairs.counts, pairs.seconds) =
                    (part.eigenvalues.clone(), part.counts, part.seconds);
                pairs.searches = part.searches;
                pairs.factor = [part.factor_entries, part.factor_flops];
            }
            let [first, end] = part.rows;
            let fits = first == next_row
                && first <= end
                && end <= n
                && part.eigenvalues.len() == pairs.eigenvalues.len();
            let file = File::open(folder.join(format!("rank-{rank}.f64"))).map_err(|_| bad("no vectors"))?;
            let expected = 8 * end.saturating_sub(first).saturating_mul(part.eigenvalues.len()) as u64;
            if !fits || file.metadata().is_ok_and(|about| about.len() != expected) {
                return Err(bad("rows that do not fit"));
            }
            let mut file = BufReader::with_capacity(1 << 20, file);
            for column in pairs.vectors.chunks_exact_mut(n).skip(zeros) {
                task.check()?;
                let rows = bytemuck::cast_slice_mut(&mut column[first..end]);
                file.read_exact(rows).map_err(|_| bad("vectors that end early"))?;
            }
            next_row = end;
            pairs.peak_bytes.push(part.peak_bytes);
        }
        if cfg!(target_endian = "big") {
            pairs.vectors.iter_mut().for_each(|x| *x = f64::from_bits(x.to_bits().swap_bytes()));
        }
        if next_row == n { Ok(pairs) } else { Err(HarmonicsError::not_certified("rows are missing")) }
    }

    /// Whether the number of pairs below every shift is the count of its factor.
    pub(super) fn counts_match(&self, zeros: usize) -> bool {
        let below = |shift: f64| zeros + self.eigenvalues.iter().filter(|value| **value < shift).count();
        self.counts.iter().all(|&(shift, count)| below(shift) == count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_that_are_missing_are_counted() {
        let pairs = |eigenvalues: &[f64]| Pairs {
            eigenvalues: eigenvalues.to_vec(),
            counts: vec![(0.1, 2), (3.5, 5), (9.0, 6)],
            ..Pairs::default()
        };
        assert!(pairs(&[1.0, 2.0, 3.0, 8.0]).counts_match(2));
        assert!(!pairs(&[1.0, 2.0, 8.0]).counts_match(2));
        assert!(!pairs(&[1.0, 2.0, 3.0, 3.0, 8.0]).counts_match(2));
        assert!(!pairs(&[1.0, 2.0, 3.0, 8.0]).counts_match(1));
    }

    #[test]
    fn damaged_results_of_ranks_are_errors() {
        let folder = tempfile::tempdir().unwrap();
        let task = Task::new();
        let read = |json: &str, vectors: &[u8]| {
            fs::write(folder.path().join("rank-0.json"), json).unwrap();
            fs::write(folder.path().join("rank-0.f64"), vectors).unwrap();
            let settings = BasisSettings::new(1);
            Pairs::read(folder.path(), 1, 2, 0, Keep::Memory, &settings, &task).map(|pairs| pairs.vectors)
        };
        let of = |rows: &str, eigenvalues: &str| {
            format!(
                r#"{{"rows": {rows}, "eigenvalues": {eigenvalues}, "counts": [[2.0, 2]],
                "peak_bytes": 1, "factor_entries": 3, "factor_flops": 4,
                "seconds": {{"read": 0, "count": 0, "solve": 0, "polish": 0}}}}"#
            )
        };
        let json = |rows: &str| of(rows, "[1.0]");
        let two: Vec<u8> = [1.5f64, -2.5].iter().flat_map(|x| x.to_le_bytes()).collect();
        assert_eq!(read(&json("[0, 2]"), &two).unwrap()[..], [1.5, -2.5]);
        for (rows, bytes) in [
            ("[0, 2]", &two[..15]),
            ("[1, 0]", &two),
            ("[0, 3]", &two),
            ("[0, 1]", &two),
            ("[0, 1]", &two[..8]),
        ] {
            assert!(read(&json(rows), bytes).is_err(), "{rows}");
        }
        assert!(read("{", &two).is_err());
        // Of two pairs the one that is wanted, or both if their eigenvalues are equal.
        let four: Vec<u8> = [&two[..], &two].concat();
        assert_eq!(read(&of("[0, 2]", "[1.0, 2.0]"), &four).unwrap()[..], [1.5, -2.5]);
        assert_eq!(read(&of("[0, 2]", "[1.0, 1.0]"), &four).unwrap().len(), 4);
        task.cancel();
        assert!(matches!(read(&json("[0, 2]"), &two), Err(HarmonicsError::Cancelled(_))));
    }
}
