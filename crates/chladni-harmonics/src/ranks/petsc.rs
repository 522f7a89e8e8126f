//! PETSc's binary format, from which ranks read their rows.

use std::io::{self, Write};

use crate::{HarmonicsError, Pencil};

/// The number that marks a sparse matrix in this format.
const MATRIX: i32 = 1_211_216;

/// A = M^-½ S M^-½, row by row, with big-endian numbers and 32-bit indices, which PETSc expects unless it
/// is built for larger ones.
pub(super) struct ScaledOperator<'a> {
    pencil: Pencil<'a>,
    rows: i32,
    entries: i32,
}

impl<'a> ScaledOperator<'a> {
    /// The scaled operator of `pencil`, whose M must be diagonal.
    pub(super) fn of(pencil: Pencil<'a>) -> Result<Self, HarmonicsError> {
        let (rows, entries) = (pencil.mass.len(), pencil.stiffness.values.len());
        let (Ok(rows), Ok(entries)) = (i32::try_from(rows), i32::try_from(entries)) else {
            let reason =
                format!("{rows} rows with {entries} entries are more than PETSc's 32 bits can number");
            return Err(HarmonicsError::NoRanks { reason });
        };
        Ok(Self { pencil, rows, entries })
    }

    pub(super) fn write(&self, file: &mut impl Write) -> io::Result<()> {
        let Pencil { stiffness, mass, .. } = self.pencil;
        for number in [MATRIX, self.rows, self.rows, self.entries] {
            file.write_all(&number.to_be_bytes())?;
        }
        for ends in stiffness.column_starts.windows(2) {
            file.write_all(&((ends[1] - ends[0]) as i32).to_be_bytes())?;
        }
        for row in &stiffness.rows {
            file.write_all(&row.to_be_bytes())?;
        }
        let inverse_root: Vec<f64> = mass.iter().map(|a| a.sqrt().recip()).collect();
        for j in 0..stiffness.size() {
            for (i, value) in stiffness.column(j) {
                // Symmetric to the last bit, because the two scales are multiplied first.
                file.write_all(&((inverse_root[i] * inverse_root[j]) * value).to_be_bytes())?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SymmetricSparse;

    #[test]
    fn a_matrix_is_scaled_and_laid_out_as_petsc_reads_it() {
        let stiffness = SymmetricSparse::from_entries(2, [(0, 0, 8.0), (1, 0, -3.0), (1, 1, 9.0)]).unwrap();
        let mass = [4.0, 9.0];
        let mut bytes = Vec::new();
        ScaledOperator::of(Pencil::new(&stiffness, &mass).unwrap()).unwrap().write(&mut bytes).unwrap();
        let (head, values) = bytes.split_at(4 * (4 + 2 + 4));
        let head: Vec<i32> = head.chunks(4).map(|b| i32::from_be_bytes(b.try_into().unwrap())).collect();
        let values: Vec<f64> = values.chunks(8).map(|b| f64::from_be_bytes(b.try_into().unwrap())).collect();
        assert_eq!(head, [1_211_216, 2, 2, 4, 2, 2, 0, 1, 0, 1]);
        assert_eq!(values, [2.0, -0.5, -0.5, 1.0]);
    }
}
