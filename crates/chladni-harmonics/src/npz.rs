//! NumPy archives that appear whole or not at all (feature `npz`).

use std::fs::File;
use std::io::{BufWriter, Error, Result};
use std::path::Path;

use npyz::{AutoSerialize, DType, Order, WriteOptions, WriterBuilder};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::{Body, Operator};

/// An archive that is being written.
#[allow(missing_debug_implementations, reason = "it holds a writer")]
pub struct Npz<'a, 'b> {
    archive: ZipWriter<&'a mut BufWriter<&'b mut File>>,
}

impl Npz<'_, '_> {
    /// Adds an array in C order; `values` are as many as the product of `shape`.
    ///
    /// # Errors
    /// What the system says, or another number of values.
    pub fn array<T: AutoSerialize>(
        &mut self,
        name: &str,
        shape: &[u64],
        values: impl IntoIterator<Item = T>,
    ) -> Result<()> {
        self.add(name, T::default_dtype(), shape, Order::C, values)
    }

    /// Adds a matrix whose `values` come column by column, and are stored so.
    ///
    /// # Errors
    /// As [`array`](Self::array).
    pub fn columns<T: AutoSerialize>(
        &mut self,
        name: &str,
        shape: [u64; 2],
        values: impl IntoIterator<Item = T>,
    ) -> Result<()> {
        self.add(name, T::default_dtype(), &shape, Order::Fortran, values)
    }

    /// Adds a single word of ASCII.
    ///
    /// # Errors
    /// What the system says.
    pub fn word(&mut self, name: &str, word: &str) -> Result<()> {
        let kind = format!("|S{}", word.len()).parse().map_err(Error::other)?;
        self.add(name, DType::Plain(kind), &[], Order::C, [word.as_bytes().to_vec()])
    }

    fn add<T: npyz::Serialize>(
        &mut self,
        name: &str,
        kind: DType,
        shape: &[u64],
        order: Order,
        values: impl IntoIterator<Item = T>,
    ) -> Result<()> {
        // Archives of more than 4 GB need wider numbers, which all of today's readers know.
        let options =
            SimpleFileOptions::default().compression_method(CompressionMethod::Stored).large_file(true);
        self.archive.start_file(format!("{name}.npy"), options).map_err(Error::other)?;
        let array = WriteOptions::new().dtype(kind).shape(shape).order(order);
        let mut array = array.writer(&mut self.archive).begin_nd()?;
        array.extend(values)?;
        array.finish()
    }
}

/// Writes the archive at `path` with the arrays that `fill` adds.
///
/// # Errors
/// What the system or `fill` says; no file is left behind.
pub fn write_npz(path: &Path, fill: impl FnOnce(&mut Npz<'_, '_>) -> Result<()>) -> Result<()> {
    chladni_task::write_atomic_with(path, |file| {
        let mut npz = Npz { archive: ZipWriter::new(file) };
        fill(&mut npz)?;
        npz.archive.finish().map(drop).map_err(Error::other)
    })
}

/// Writes `eigenvalues` (K), `mass` (N), `operator_vertex` (n: file vertex → row, −1 where no triangle uses it)
/// and `eigenvectors` (N×K), in the units of the file that `body` was made from.
///
/// # Errors
/// What the system says; no file is left behind.
pub fn write_basis(path: &Path, body: &Body) -> Result<()> {
    let basis = &body.basis;
    let (n, k) = (basis.vertices() as u64, basis.harmonics() as u64);
    write_npz(path, |npz| {
        npz.array("eigenvalues", &[k], basis.eigenvalues.iter().map(|l| body.eigenvalue_in_file(*l)))?;
        npz.array("mass", &[n], basis.mass.iter().map(|a| body.area_in_file(*a)))?;
        let rows = body.operator_vertex.iter().map(|v| v.map_or(-1, i64::from));
        npz.array("operator_vertex", &[body.operator_vertex.len() as u64], rows)?;
        npz.columns("eigenvectors", [n, k], basis.vectors.iter().map(|h| body.harmonic_in_file(*h)))
    })
}

/// Writes the stiffness S (N×N), which has no unit, for `scipy.sparse.load_npz`.
///
/// # Errors
/// What the system says; no file is left behind.
pub fn write_operator(path: &Path, operator: &Operator) -> Result<()> {
    let stiffness = &operator.stiffness;
    let (n, entries) = (stiffness.size() as u64, stiffness.values.len() as u64);
    write_npz(path, |npz| {
        npz.array("indices", &[entries], stiffness.rows.iter().map(|&r| i64::from(r)))?;
        npz.array("indptr", &[n + 1], stiffness.column_starts.iter().map(|&c| c as i64))?;
        npz.word("format", "csc")?;
        npz.array("shape", &[2], [n as i64, n as i64])?;
        npz.array("data", &[entries], stiffness.values.iter().copied())
    })
}
