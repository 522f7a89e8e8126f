//! NumPy archives that appear whole or not at all.

use std::fs::File;
use std::io::{BufWriter, Error, Result};
use std::path::Path;

use npyz::npz::NpzWriter;
use npyz::zip::write::FileOptions;
use npyz::{AutoSerialize, WriterBuilder};

/// An archive that is being written.
pub struct Npz<'a, 'b> {
    writer: NpzWriter<&'a mut BufWriter<&'b mut File>>,
}

impl Npz<'_, '_> {
    /// Adds an array in C order; `values` are as many as the product of `shape`.
    pub fn array<T: AutoSerialize>(
        &mut self,
        name: &str,
        shape: &[u64],
        values: impl IntoIterator<Item = T>,
    ) -> Result<()> {
        let options = FileOptions::default().compression_method(npyz::zip::CompressionMethod::Stored);
        let mut array =
            self.writer.array(name, options.large_file(true))?.default_dtype().shape(shape).begin_nd()?;
        array.extend(values)?;
        array.finish()
    }
}

/// Writes the archive at `path` with the arrays that `fill` adds.
pub fn write_npz(path: &Path, fill: impl FnOnce(&mut Npz<'_, '_>) -> Result<()>) -> Result<()> {
    chladni_task::write_atomic_with(path, |file| {
        let mut npz = Npz { writer: NpzWriter::new(file) };
        fill(&mut npz)?;
        npz.writer.zip_writer().finish().map(drop).map_err(Error::other)
    })
}
