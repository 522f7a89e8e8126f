//! Writes NumPy archives, whole or not at all, and reads single arrays and stored bases (feature `npz`).

mod fails_once;
mod stored;

use std::io::{BufWriter, Cursor, Error, ErrorKind, Read, Result, Seek, Write};
use std::path::{Path, PathBuf};

use chladni_task::{Draft, Stage, Task};
use npyz::{AutoSerialize, DType, Deserialize, NpyFile, Order, TypeChar, WriteOptions, WriterBuilder};
use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use crate::{Body, Operator};
use fails_once::FailsOnce;
pub use stored::StoredBasis;

/// An archive that is being written.
#[allow(missing_debug_implementations, reason = "it holds a writer")]
pub struct Npz<W: Write + Seek> {
    archive: ZipWriter<FailsOnce<W>>,
}

impl<W: Write + Seek> Npz<W> {
    /// Adds an array in C order. `values` must have as many values as `shape` says.
    ///
    /// # Errors
    /// An error of the system, or another number of values.
    pub fn array<T: AutoSerialize>(
        &mut self,
        name: &str,
        shape: &[u64],
        values: impl IntoIterator<Item = T>,
    ) -> Result<()> {
        self.add(name, T::default_dtype(), shape, Order::C, values)
    }

    /// Adds a matrix whose `values` are given column by column, and stores it in this order.
    ///
    /// # Errors
    /// Those of [`array`](Self::array).
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
    /// An error of the system.
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
        // Archives of more than 4 GB need 64-bit sizes, which all current readers support.
        let options =
            SimpleFileOptions::default().compression_method(CompressionMethod::Stored).large_file(true);
        self.archive.start_file(format!("{name}.npy"), options).map_err(of_system)?;
        let array = WriteOptions::new().dtype(kind).shape(shape).order(order);
        let mut array = array.writer(&mut self.archive).begin_nd()?;
        array.extend(values)?;
        array.finish()
    }
}

/// Writes the archive at `path` with the arrays that `fill` adds.
///
/// # Errors
/// An error of the system or of `fill`; then no file is left behind.
pub fn write_npz<F>(path: &Path, fill: F) -> Result<()>
where
    F: FnOnce(&mut Npz<&mut BufWriter<Draft<'_>>>) -> Result<()>,
{
    chladni_task::write_atomic_with(path, |file| archived(file, fill).map(drop))
}

/// The bytes of that file.
///
/// # Errors
/// Those of `fill`.
pub fn npz_of(fill: impl FnOnce(&mut Npz<Cursor<Vec<u8>>>) -> Result<()>) -> Result<Vec<u8>> {
    archived(Cursor::new(Vec::new()), fill).map(Cursor::into_inner)
}

/// Writes an archive into `into` and returns it.
fn archived<W: Write + Seek>(into: W, fill: impl FnOnce(&mut Npz<W>) -> Result<()>) -> Result<W> {
    let into = FailsOnce::new(into);
    let is_over = into.is_over();
    let mut npz = Npz { archive: ZipWriter::new(into) };
    fill(&mut npz).inspect_err(|_| is_over.set(true))?;
    npz.archive.finish().map_err(of_system)?.into_inner()
}

/// The error of the system inside the archive's, whose kind says that a disk is full.
fn of_system(error: ZipError) -> Error {
    match error {
        ZipError::Io(error) => error,
        other => Error::other(other),
    }
}

/// `values` as one array, the bytes of a `.npy` file.
///
/// # Errors
/// Only bugs: writing to memory does not fail.
pub fn npy_of<T: AutoSerialize>(values: &[T]) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let array = WriteOptions::new().default_dtype().shape(&[values.len() as u64]);
    let mut array = array.writer(&mut bytes).begin_nd()?;
    array.extend(values)?;
    array.finish()?;
    Ok(bytes)
}

/// Where the arrays of a basis go.
trait Arrays {
    /// Adds an array whose `values` are given in `order`.
    fn add<T: AutoSerialize>(
        &mut self,
        name: &str,
        shape: &[u64],
        order: Order,
        values: impl Iterator<Item = T>,
    ) -> Result<()>;
}

impl<W: Write + Seek> Arrays for Npz<W> {
    fn add<T: AutoSerialize>(
        &mut self,
        name: &str,
        shape: &[u64],
        order: Order,
        values: impl Iterator<Item = T>,
    ) -> Result<()> {
        Npz::add(self, name, T::default_dtype(), shape, order, values)
    }
}

/// A folder with one `.npy` file for each array, and the files that were written.
struct Folder<'a> {
    path: &'a Path,
    written: Vec<PathBuf>,
}

impl Arrays for Folder<'_> {
    fn add<T: AutoSerialize>(
        &mut self,
        name: &str,
        shape: &[u64],
        order: Order,
        values: impl Iterator<Item = T>,
    ) -> Result<()> {
        let path = self.path.join(format!("{name}.npy"));
        chladni_task::write_atomic_with(&path, |file| {
            let array = WriteOptions::new().default_dtype().shape(shape).order(order);
            let mut array = array.writer(file).begin_nd()?;
            array.extend(values)?;
            array.finish()
        })?;
        self.written.push(path);
        Ok(())
    }
}

/// The values of `pieces`, each of which is a step of `stage`, until `task` is cancelled: an array that lacks values is
/// refused when it is finished.
fn until_cancelled<'a, T: 'a>(
    pieces: impl Iterator<Item = &'a [T]>,
    task: &Task,
    stage: &Stage<'_>,
) -> impl Iterator<Item = &'a T> {
    pieces.take_while(move |_| !task.is_cancelled()).inspect(move |_| stage.advance(1)).flatten()
}

/// `written`, or [`Cancelled`](chladni_task::Cancelled) as its error where `task` was cancelled.
fn unless_cancelled(written: Result<()>, task: &Task) -> Result<()> {
    written.map_err(|error| task.check().map_or_else(Error::other, |()| error))
}

/// Adds `eigenvalues`, `mass`, `operator_vertex` and `eigenvectors` in the units of the file.
fn add_basis(arrays: &mut impl Arrays, body: &Body, task: &Task) -> Result<()> {
    let basis = &body.basis;
    let (n, k) = (basis.vertices() as u64, basis.harmonics() as u64);
    let stage = task.stage("writing the harmonics", k);
    let eigenvalues = basis.eigenvalues.iter().map(|l| body.eigenvalue_in_file(*l));
    arrays.add("eigenvalues", &[k], Order::C, eigenvalues)?;
    arrays.add("mass", &[n], Order::C, basis.mass.iter().map(|a| body.area_in_file(*a)))?;
    let rows = body.operator_vertex.iter().map(|v| v.map_or(-1, i64::from));
    arrays.add("operator_vertex", &[body.operator_vertex.len() as u64], Order::C, rows)?;
    let columns = basis.vectors.chunks_exact(basis.vertices().max(1));
    let harmonics = until_cancelled(columns, task, &stage).map(|h| body.harmonic_in_file(*h));
    arrays.add("eigenvectors", &[n, k], Order::Fortran, harmonics)
}

/// Writes `eigenvalues` (K), `mass` (N), `operator_vertex` (n: file vertex → row, −1 if no triangle uses
/// the vertex) and `eigenvectors` (N×K), in the units of the file from which `body` was made.
///
/// # Errors
/// An error of the system, or one that holds [`Cancelled`](chladni_task::Cancelled); then no file is left behind.
pub fn write_basis(path: &Path, body: &Body, task: &Task) -> Result<()> {
    unless_cancelled(write_npz(path, |npz| add_basis(npz, body, task)), task)
}

/// Writes the arrays of [`write_basis`] as `.npy` files of their own into `folder`, which is created if it
/// does not exist. [`StoredBasis`] and `numpy.load(…, mmap_mode="r")` then read only the harmonics that are
/// used: each is stored in one piece. The eigenvectors of an earlier basis there are removed first and the new ones
/// written last: whatever interrupts, the folder never holds those of another shape.
///
/// # Errors
/// An error of the system, or one that holds [`Cancelled`](chladni_task::Cancelled); then none of the arrays written here is
/// left behind. Before anything is written, a cancelled task leaves an earlier basis as it is.
pub fn write_basis_folder(folder: &Path, body: &Body, task: &Task) -> Result<()> {
    task.check().map_err(Error::other)?;
    let was_there = folder.is_dir();
    chladni_task::create_folder(folder)?;
    match std::fs::remove_file(folder.join("eigenvectors.npy")) {
        Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    let mut arrays = Folder { path: folder, written: Vec::new() };
    let written = add_basis(&mut arrays, body, task);
    if written.is_err() {
        // What cannot be removed is whole, and no basis without the eigenvectors.
        arrays.written.iter().for_each(|path| drop(std::fs::remove_file(path)));
        if !was_there {
            let _ = std::fs::remove_dir(folder);
        }
    }
    unless_cancelled(written, task)
}

/// The entries of a matrix that are written between two looks at the task.
const PIECE: usize = 1 << 16;

/// Writes the stiffness matrix S (N×N), which has no unit, for `scipy.sparse.load_npz`.
///
/// # Errors
/// An error of the system, or one that holds [`Cancelled`](chladni_task::Cancelled); then no file is left behind.
pub fn write_operator(path: &Path, operator: &Operator, task: &Task) -> Result<()> {
    let stiffness = &operator.stiffness;
    let (n, entries) = (stiffness.size() as u64, stiffness.values.len() as u64);
    let stage = task.stage("writing the operator", 2 * entries.div_ceil(PIECE as u64));
    let written = write_npz(path, |npz| {
        let rows = until_cancelled(stiffness.rows.chunks(PIECE), task, &stage);
        npz.array("indices", &[entries], rows.map(|&r| i64::from(r)))?;
        npz.array("indptr", &[n + 1], stiffness.column_starts.iter().map(|&c| c as i64))?;
        npz.word("format", "csc")?;
        npz.array("shape", &[2], [n as i64, n as i64])?;
        let values = until_cancelled(stiffness.values.chunks(PIECE), task, &stage);
        npz.array("data", &[entries], values.copied())
    });
    unless_cancelled(written, task)
}

/// The size of the largest array that is read, in bytes, after decompression.
pub const MOST_BYTES: u64 = 1 << 30;

/// The names of the arrays in a `.npz` archive; none where `bytes` are no archive.
pub fn array_names(bytes: &[u8]) -> Vec<String> {
    if !bytes.starts_with(b"PK") {
        return Vec::new();
    }
    let Ok(archive) = ZipArchive::new(Cursor::new(bytes)) else { return Vec::new() };
    archive.file_names().flatten().filter_map(|name| name.strip_suffix(".npy").map(str::to_owned)).collect()
}

/// The numbers of an array, in the order of the file, whose `bytes` these are: of a `.npy` file, or of the array `name`
/// of an `.npz` archive. Truth values become 0 and 1. There may be up to `most` numbers: a compressed
/// archive may hold a thousand for each of its bytes. Integers of 8 to 64 bits and floats of 32 and 64 are read;
/// floats of other sizes, such as 16 bits, and complex numbers are not.
///
/// # Errors
/// A file that is neither, or has no array of that name; an array that does not hold such numbers, holds more than `most`,
/// or is larger than 1 GiB.
pub fn numbers_in(bytes: &[u8], name: &str, most: usize) -> Result<Vec<f64>> {
    if !bytes.starts_with(b"PK") {
        return numbers_of(bytes, most);
    }
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(Error::other)?;
    let member = archive.by_name(&format!("{name}.npy")).map_err(|error| match error {
        ZipError::FileNotFound => Error::other(format!("it has no array {name:?}")),
        other => Error::other(other),
    })?;
    // Compression may shrink an archive a thousandfold: limit the decompressed size.
    numbers_of(member.take(MOST_BYTES), most)
}

/// The longest header of an array, in bytes, and the most brackets in it: an array of numbers has two, and the time in which
/// `npyz` reads nested ones doubles with each.
const LONGEST_HEADER: u64 = 64 << 10;
const MOST_BRACKETS: usize = 16;
/// The most digits in a shape: with more, the number of values may be beyond 64 bits, which `npyz` does not check.
const MOST_DIGITS: usize = 19;

fn numbers_of(mut file: impl Read, most: usize) -> Result<Vec<f64>> {
    let header = header(&mut file)?;
    let file = NpyFile::new(header.as_slice().chain(file))?;
    let DType::Plain(kind) = file.dtype() else { return Err(Error::other("it holds records, not numbers")) };
    match (kind.type_char(), kind.size_field()) {
        (TypeChar::Bool, _) => each(file, most, |x: bool| f64::from(u8::from(x))),
        (TypeChar::Float, 4) => each(file, most, |x: f32| f64::from(x)),
        (TypeChar::Float, 8) => each(file, most, |x: f64| x),
        (TypeChar::Int, 1) => each(file, most, |x: i8| f64::from(x)),
        (TypeChar::Int, 2) => each(file, most, |x: i16| f64::from(x)),
        (TypeChar::Int, 4) => each(file, most, |x: i32| f64::from(x)),
        (TypeChar::Int, 8) => each(file, most, |x: i64| x as f64),
        (TypeChar::Uint, 1) => each(file, most, |x: u8| f64::from(x)),
        (TypeChar::Uint, 2) => each(file, most, |x: u16| f64::from(x)),
        (TypeChar::Uint, 4) => each(file, most, |x: u32| f64::from(x)),
        (TypeChar::Uint, 8) => each(file, most, |x: u64| x as f64),
        _ => {
            Err(Error::other(format!("it holds {kind}, which is none of the kinds of number that are read")))
        }
    }
}

/// The beginning of a `.npy` file up to its numbers, if they are such as can be read.
fn header(file: &mut impl Read) -> Result<Vec<u8>> {
    let mut header = vec![0; 8];
    file.read_exact(&mut header)?;
    if !header.starts_with(b"\x93NUMPY") {
        return Ok(header);
    }
    let width = if header[6] == 1 { 2 } else { 4 };
    file.by_ref().take(width).read_to_end(&mut header)?;
    let length = header[8..].iter().rev().fold(0, |length, byte| length << 8 | u64::from(*byte));
    if length > LONGEST_HEADER {
        return Err(Error::other(format!("its header has {length} bytes")));
    }
    file.by_ref().take(length).read_to_end(&mut header)?;
    let text = header.iter().skip(8 + width as usize);
    if text.filter(|byte| b"([{".contains(byte)).count() > MOST_BRACKETS {
        return Err(Error::other("it holds records, not numbers, or its header is damaged"));
    }
    let shape = header.iter().skip_while(|byte| **byte != b'(').take_while(|byte| **byte != b')');
    if shape.filter(|byte| byte.is_ascii_digit()).count() > MOST_DIGITS {
        return Err(Error::other("it promises more numbers than a file can hold"));
    }
    Ok(header)
}

/// Reads numbers one by one, because a damaged header may promise more than memory holds.
fn each<T: Deserialize>(
    file: NpyFile<impl Read>,
    most: usize,
    number: impl Fn(T) -> f64,
) -> Result<Vec<f64>> {
    let mut numbers = Vec::new();
    for value in file.data::<T>().map_err(Error::other)? {
        if numbers.len() == most {
            return Err(Error::other(format!("it has more than {most} numbers")));
        }
        numbers.push(number(value?));
    }
    Ok(numbers)
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use chladni_task::Cancelled;

    use super::*;
    use crate::BasisSettings;

    /// A one-dimensional array, as NumPy writes it.
    fn npy(kind: &str, promised: usize, bytes: &[u8]) -> Vec<u8> {
        let mut header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({promised},), }}");
        while !(header.len() + 11).is_multiple_of(64) {
            header.push(' ');
        }
        header.push('\n');
        let length = (header.len() as u16).to_le_bytes();
        [b"\x93NUMPY\x01\x00", length.as_slice(), header.as_bytes(), bytes].concat()
    }

    thread_local! {
        static WRITING: RefCell<Task> = RefCell::default();
    }

    /// A task that is cancelled at its first step, by this thread.
    fn ending_at_once() -> Task {
        let task = Task::new();
        WRITING.set(task.clone());
        task.heard_by(|now| {
            if now.done == 1 {
                WRITING.with_borrow(Task::cancel);
            }
        });
        task
    }

    #[test]
    fn writing_stops_where_it_is_cancelled_and_leaves_nothing() {
        let above = tempfile::tempdir().unwrap();
        let at = |name: &str| above.path().join(name);
        let ball = chladni_mesh::samples::icosphere(2);
        let body = Body::build(&ball, &BasisSettings::new(9), &Task::new()).unwrap();
        let operator = Operator::of(&ball).unwrap();
        let is_cancelled = |written: Result<()>| {
            let error = written.unwrap_err();
            error.get_ref().is_some_and(|inner| inner.is::<Cancelled>())
        };
        assert!(is_cancelled(write_basis(&at("b.npz"), &body, &ending_at_once())));
        assert!(is_cancelled(write_operator(&at("s.npz"), &operator, &ending_at_once())));
        let cancelled = ending_at_once();
        assert!(is_cancelled(write_basis_folder(&at("new"), &body, &cancelled)));
        assert_eq!((cancelled.progress().done, cancelled.progress().total), (1, 9));
        assert_eq!(std::fs::read_dir(above.path()).unwrap().count(), 0);

        write_basis_folder(&at("old"), &body, &Task::new()).unwrap();
        assert!(is_cancelled(write_basis_folder(&at("old"), &body, &cancelled)));
        StoredBasis::open(&at("old")).unwrap();
        std::fs::write(at("old/notes.txt"), "kept").unwrap();
        assert!(is_cancelled(write_basis_folder(&at("old"), &body, &ending_at_once())));
        let left: Vec<_> =
            std::fs::read_dir(at("old")).unwrap().map(|file| file.unwrap().file_name()).collect();
        assert_eq!(left, ["notes.txt"]);
    }

    #[test]
    fn a_header_of_nested_brackets_is_refused_at_once() {
        for nested in ["(".repeat(160), "{".repeat(160), "[(".repeat(80)] {
            let header = format!("{{{nested}'descr': '<f8'\n");
            let length = (header.len() as u16).to_le_bytes();
            let bytes = [b"\x93NUMPY\x01\x00", length.as_slice(), header.as_bytes()].concat();
            assert!(numbers_in(&bytes, "mask", 9).unwrap_err().to_string().contains("damaged"));
        }
        let vast = b"{'descr': '<f8', 'fortran_order': False, 'shape': (4294967296, 4294967296), }\n";
        let bytes = [b"\x93NUMPY\x01\x00".as_slice(), &(vast.len() as u16).to_le_bytes(), vast].concat();
        assert!(numbers_in(&bytes, "mask", 9).unwrap_err().to_string().contains("more numbers"));
        let endless = [b"\x93NUMPY\x02\x00".as_slice(), &u32::MAX.to_le_bytes()].concat();
        assert!(numbers_in(&endless, "mask", 9).unwrap_err().to_string().contains("bytes"));
    }

    #[test]
    fn compressed_archives_are_read() {
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
        archive.start_file("mask.npy", options).unwrap();
        let numbers = [0.0_f32, 0.25, 1.0].map(f32::to_le_bytes).concat();
        archive.write_all(&npy("<f4", 3, &numbers)).unwrap();
        let bytes = archive.finish().unwrap().into_inner();
        assert_eq!(numbers_in(&bytes, "mask", 3).unwrap(), [0.0, 0.25, 1.0]);
        assert!(numbers_in(&bytes, "mask", 2).unwrap_err().to_string().contains("more than 2 numbers"));
    }

    #[test]
    fn what_was_written_is_read_and_what_is_damaged_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.npz");
        write_npz(&path, |npz| {
            npz.array("mask", &[3], [0.0f32, 0.25, 1.0])?;
            npz.array("part", &[2], [-1i64, 7])
        })
        .unwrap();
        let archive = std::fs::read(&path).unwrap();
        assert_eq!(array_names(&archive), ["mask", "part"]);
        assert_eq!(numbers_in(&archive, "mask", 9).unwrap(), [0.0, 0.25, 1.0]);
        assert_eq!(numbers_in(&archive, "part", 9).unwrap(), [-1.0, 7.0]);
        assert!(numbers_in(&archive, "none", 9).unwrap_err().to_string().contains("no array \"none\""));
        assert!(array_names(&archive[1..]).is_empty() && array_names(b"PK").is_empty());
        let read = |bytes: &[u8]| numbers_in(bytes, "", 9);
        assert_eq!(read(&npy("|b1", 3, &[1, 0, 1])).unwrap(), [1.0, 0.0, 1.0]);
        assert_eq!(read(&npy("<f8", 1, &2.5f64.to_le_bytes())).unwrap(), [2.5]);
        assert_eq!(read(&npy("<i2", 1, &(-3_i16).to_le_bytes())).unwrap(), [-3.0]);
        assert_eq!(read(&npy(">u2", 1, &300_u16.to_be_bytes())).unwrap(), [300.0]);
        assert_eq!(read(&npy("<u8", 1, &7_u64.to_le_bytes())).unwrap(), [7.0]);
        // The header promises far more than the file holds.
        assert!(read(&npy("<f8", usize::MAX / 16, &[0; 16])).is_err());
        for (kind, bytes) in [("<c16", 16), ("<f2", 2)] {
            let refused = read(&npy(kind, 1, &vec![0; bytes])).unwrap_err();
            assert!(refused.to_string().contains("kinds of number"), "{kind}");
        }
        for bytes in [&b""[..], b"P", b"PK\x03\x04", b"\x93NUMPY\x01\x00\xff\xff{", b"no array"] {
            assert!(read(bytes).is_err(), "{bytes:?}");
        }
    }
}
