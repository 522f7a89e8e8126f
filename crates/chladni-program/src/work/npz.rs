//! NumPy archives that appear whole or not at all.

use std::fs::File;
use std::io::{BufWriter, Error, Result};
use std::path::Path;

use npyz::{AutoSerialize, DType, Order, WriteOptions, WriterBuilder};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// An archive that is being written.
pub struct Npz<'a, 'b> {
    archive: ZipWriter<&'a mut BufWriter<&'b mut File>>,
}

impl Npz<'_, '_> {
    /// Adds an array in C order; `values` are as many as the product of `shape`.
    pub fn array<T: AutoSerialize>(
        &mut self,
        name: &str,
        shape: &[u64],
        values: impl IntoIterator<Item = T>,
    ) -> Result<()> {
        self.add(name, T::default_dtype(), shape, Order::C, values)
    }

    /// Adds a matrix whose `values` come column by column, and are stored so.
    pub fn columns<T: AutoSerialize>(
        &mut self,
        name: &str,
        shape: [u64; 2],
        values: impl IntoIterator<Item = T>,
    ) -> Result<()> {
        self.add(name, T::default_dtype(), &shape, Order::Fortran, values)
    }

    /// Adds a single word of ASCII.
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
pub fn write_npz(path: &Path, fill: impl FnOnce(&mut Npz<'_, '_>) -> Result<()>) -> Result<()> {
    chladni_task::write_atomic_with(path, |file| {
        let mut npz = Npz { archive: ZipWriter::new(file) };
        fill(&mut npz)?;
        npz.archive.finish().map(drop).map_err(Error::other)
    })
}
