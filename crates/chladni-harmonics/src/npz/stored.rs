//! A basis in a folder, of which only a piece is in memory at a time.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use chladni_task::Task;
use npyz::{DType, Endianness, NpyHeader, Order, TypeChar};
use rayon::prelude::*;

use super::{LONGEST_HEADER, header, numbers_of};
use crate::HarmonicsError;

/// The number of values that a thread has in memory at a time: 1 MiB, and in tests so few that there are many pieces.
const PIECE: usize = if cfg!(test) { 100 } else { 1 << 17 };

/// A basis that [`write_basis_folder`](super::write_basis_folder) wrote, in the units of the mesh's file.
///
/// Eigenvalues, areas and the rows of vertices are in memory. Harmonics are read from the folder in pieces
/// of 1 MiB for each thread whenever a signal is analyzed or synthesized, so that neither their number nor
/// that of vertices is limited by memory. Each call reads each value that it needs once.
///
/// ```
/// use chladni_harmonics::npz::{StoredBasis, write_basis_folder};
/// use chladni_harmonics::{BasisSettings, Body};
/// use chladni_task::Task;
/// # let folder = tempfile::tempdir()?;
/// # let folder = folder.path();
///
/// let ball = chladni_mesh::samples::icosphere(3);
/// let body = Body::build(&ball, &BasisSettings::new(16), &Task::new())?;
/// write_basis_folder(folder, &body, &Task::new())?;
///
/// let stored = StoredBasis::open(folder)?;
/// let heights: Vec<f64> = ball.positions.iter().map(|p| p[2]).collect();
/// let coefficients = stored.analyze(&[&heights], &Task::new())?;
/// let back = stored.synthesize(&[&coefficients[0]], &Task::new())?;
/// assert!((back[0][5] - heights[5]).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Not guaranteed: results while another program writes to the folder. A file that becomes shorter is an error.
#[derive(Clone, Debug)]
pub struct StoredBasis {
    /// The file of the harmonics, and where its values begin.
    vectors: PathBuf,
    start: u64,
    eigenvalues: Vec<f64>,
    mass: Vec<f64>,
    operator_vertex: Vec<Option<u32>>,
}

impl StoredBasis {
    /// The basis in `folder`.
    ///
    /// # Errors
    /// [`HarmonicsError::Stored`] if a file is missing, is damaged, or does not fit the others.
    pub fn open(folder: &Path) -> Result<Self, HarmonicsError> {
        let at = |name: &str| folder.join(format!("{name}.npy"));
        let vectors = at("eigenvectors");
        let (start, [vertices, harmonics]) = layout(&vectors).map_err(|e| unread(&vectors, &e))?;
        let values = |name: &str, count: Option<usize>| {
            let path = at(name);
            numbers(&path, count).map_err(|error| unread(&path, &error))
        };
        let row = |row: f64| match row {
            -1.0 => Ok(None),
            _ if row >= 0.0 && row < vertices as f64 && row.fract() == 0.0 => Ok(Some(row as u32)),
            _ => Err(bad(&at("operator_vertex"), format!("{row} is no row of {vertices}"))),
        };
        let mass = values("mass", Some(vertices))?;
        if let Some(area) = mass.iter().find(|area| !area.is_finite() || **area <= 0.0) {
            return Err(bad(&at("mass"), format!("{area} is no area")));
        }
        let eigenvalues = values("eigenvalues", Some(harmonics))?;
        let operator_vertex = values("operator_vertex", None)?.into_iter().map(row);
        Ok(Self {
            vectors,
            start,
            eigenvalues,
            mass,
            operator_vertex: operator_vertex.collect::<Result<_, _>>()?,
        })
    }

    /// λ_k, K eigenvalues.
    pub fn eigenvalues(&self) -> &[f64] {
        &self.eigenvalues
    }

    /// a(v), the areas of the N operator vertices.
    pub fn mass(&self) -> &[f64] {
        &self.mass
    }

    /// For each of the n vertices of the file its operator vertex; `None` if no triangle uses it.
    pub fn operator_vertex(&self) -> &[Option<u32>] {
        &self.operator_vertex
    }

    /// The harmonic transform f̃_k = Σ_v a(v) H_k(v) f(v) of several signals at once: for each of `signals` (n values, one
    /// for each vertex of the file) K coefficients. Where vertices were welded, f is the mean of their values.
    ///
    /// # Errors
    /// [`HarmonicsError::Stored`] if the harmonics cannot be read, [`HarmonicsError::BadSignal`] for a signal that
    /// does not have n values, and [`HarmonicsError::Cancelled`].
    pub fn analyze(&self, signals: &[&[f64]], task: &Task) -> Result<Vec<Vec<f64>>, HarmonicsError> {
        let weighted = signals.iter().map(|f| self.weighted(f)).collect::<Result<Vec<_>, _>>()?;
        let harmonics = self.eigenvalues.len();
        let stage = task.stage("reading the harmonics", harmonics as u64);
        let of_harmonic = |piece: &mut Vec<f64>, k: usize| {
            let mut sums = vec![0.0; signals.len()];
            let mut file = self.file()?;
            self.seek(&mut file, k, 0)?;
            for first in (0..self.mass.len()).step_by(PIECE) {
                task.check()?;
                let rows = first..self.mass.len().min(first + PIECE);
                let h = self.read(&mut file, piece, rows.len())?;
                sums.iter_mut().zip(&weighted).for_each(|(sum, f)| *sum += dot(h, &f[rows.clone()]));
            }
            stage.advance(1);
            Ok(sums)
        };
        let sums = (0..harmonics).into_par_iter().map_init(Vec::new, of_harmonic);
        let sums = sums.collect::<Result<Vec<_>, HarmonicsError>>()?;
        Ok((0..signals.len()).map(|c| sums.iter().map(|sums| sums[c]).collect()).collect())
    }

    /// Σ_k H_k(v) c_k for each of `coefficients`, the first up to K of a signal: n values for the vertices of the file,
    /// 0 for those that no triangle uses. Harmonics whose coefficients are all 0 are not read.
    ///
    /// # Errors
    /// [`HarmonicsError::Stored`] if the harmonics cannot be read, [`HarmonicsError::BadSignal`] for more than K
    /// coefficients, and [`HarmonicsError::Cancelled`].
    pub fn synthesize(&self, coefficients: &[&[f64]], task: &Task) -> Result<Vec<Vec<f64>>, HarmonicsError> {
        let harmonics = self.eigenvalues.len();
        if let Some(c) = coefficients.iter().find(|c| c.len() > harmonics) {
            return Err(HarmonicsError::BadSignal {
                given: c.len(),
                values: "coefficients",
                needed: harmonics,
            });
        }
        let of = |c: usize, k: usize| coefficients[c].get(k).copied().unwrap_or_default();
        let channels = 0..coefficients.len();
        let used: Vec<usize> =
            (0..harmonics).filter(|k| channels.clone().any(|c| of(c, *k) != 0.0)).collect();
        let vertices = self.mass.len();
        let stage = task.stage("reading the harmonics", vertices.div_ceil(PIECE) as u64);
        let of_rows = |piece: &mut Vec<f64>, number: usize| {
            let rows = number * PIECE..vertices.min((number + 1) * PIECE);
            let mut sums = vec![vec![0.0; rows.len()]; coefficients.len()];
            let mut file = self.file()?;
            for &k in &used {
                task.check()?;
                self.seek(&mut file, k, rows.start)?;
                let h = self.read(&mut file, piece, rows.len())?;
                for (c, sums) in sums.iter_mut().enumerate() {
                    let coefficient = of(c, k);
                    sums.iter_mut().zip(h).for_each(|(sum, h)| *sum += coefficient * h);
                }
            }
            stage.advance(1);
            Ok(sums)
        };
        let pieces = (0..vertices.div_ceil(PIECE)).into_par_iter().map_init(Vec::new, of_rows);
        let pieces = pieces.collect::<Result<Vec<_>, HarmonicsError>>()?;
        let value = |c: usize, v: usize| pieces[v / PIECE][c][v % PIECE];
        let in_file =
            |c: usize| self.operator_vertex.iter().map(move |v| v.map_or(0.0, |v| value(c, v as usize)));
        Ok(channels.map(|c| in_file(c).collect()).collect())
    }

    /// a(v) f(v) of the N operator vertices.
    fn weighted(&self, signal: &[f64]) -> Result<Vec<f64>, HarmonicsError> {
        let vertices = self.operator_vertex.len();
        if signal.len() != vertices {
            return Err(HarmonicsError::BadSignal {
                given: signal.len(),
                values: "vertices",
                needed: vertices,
            });
        }
        let (mut sum, mut welded) = (vec![0.0; self.mass.len()], vec![0_u32; self.mass.len()]);
        for (f, v) in signal.iter().zip(&self.operator_vertex) {
            if let Some(v) = v {
                sum[*v as usize] += f;
                welded[*v as usize] += 1;
            }
        }
        let areas = self.mass.iter().zip(welded);
        sum.iter_mut().zip(areas).for_each(|(f, (area, count))| *f *= area / f64::from(count.max(1)));
        Ok(sum)
    }

    fn file(&self) -> Result<File, HarmonicsError> {
        chladni_task::open_file(&self.vectors).map_err(|error| unread(&self.vectors, &error))
    }

    /// Moves `file` to the value of harmonic `k` in row `row`.
    fn seek(&self, file: &mut File, k: usize, row: usize) -> Result<(), HarmonicsError> {
        let value = (k * self.mass.len() + row) as u64;
        let moved = file.seek(SeekFrom::Start(self.start + 8 * value));
        moved.map(drop).map_err(|error| unread(&self.vectors, &error))
    }

    /// The next `count` values of `file`, in `piece`.
    fn read<'a>(
        &self,
        file: &mut File,
        piece: &'a mut Vec<f64>,
        count: usize,
    ) -> Result<&'a [f64], HarmonicsError> {
        piece.resize(count, 0.0);
        file.read_exact(bytemuck::cast_slice_mut(piece)).map_err(|error| unread(&self.vectors, &error))?;
        if cfg!(target_endian = "big") {
            piece.iter_mut().for_each(|x| *x = f64::from_bits(x.to_bits().swap_bytes()));
        }
        Ok(piece)
    }
}

fn bad(path: &Path, reason: String) -> HarmonicsError {
    HarmonicsError::Stored { path: path.to_owned(), reason }
}

fn unread(path: &Path, error: &io::Error) -> HarmonicsError {
    bad(path, error.to_string())
}

/// Where the values of a matrix of f64 begin, and its numbers of rows and columns. Columns are in one piece each.
fn layout(path: &Path) -> io::Result<(u64, [usize; 2])> {
    let mut file = chladni_task::open_file(path)?;
    let length = file.metadata()?.len();
    let header = header(&mut file)?;
    let about = NpyHeader::from_reader(header.as_slice())?;
    let is_number = match about.dtype() {
        DType::Plain(kind) => {
            (kind.type_char(), kind.size_field(), kind.endianness())
                == (TypeChar::Float, 8, Endianness::Little)
        }
        _ => false,
    };
    if !is_number || about.order() != Order::Fortran {
        return Err(io::Error::other("it is no matrix of 64-bit numbers, column by column"));
    }
    let &[rows, columns] = about.shape() else { return Err(io::Error::other("it is no matrix")) };
    let start = header.len() as u64;
    let values = rows.checked_mul(columns).and_then(|values| values.checked_mul(8));
    if values.and_then(|bytes| bytes.checked_add(start)) != Some(length) || rows == 0 || columns == 0 {
        let reason = format!("it is {length} bytes long, which do not hold {rows} rows of {columns} columns");
        return Err(io::Error::other(reason));
    }
    let [Ok(rows), Ok(columns)] = [rows, columns].map(usize::try_from) else {
        return Err(io::Error::other("it is too large for this machine"));
    };
    Ok((start, [rows, columns]))
}

/// The numbers of an array, which must be `count` where that is known.
fn numbers(path: &Path, count: Option<usize>) -> io::Result<Vec<f64>> {
    let file = chladni_task::open_file(path)?;
    let most = count.map_or(u64::MAX, |count| 8 * count as u64 + LONGEST_HEADER);
    let numbers = numbers_of(BufReader::new(file).take(most), usize::MAX)?;
    match count {
        Some(count) if count != numbers.len() => {
            Err(io::Error::other(format!("it has {} numbers, and the harmonics need {count}", numbers.len())))
        }
        _ => Ok(numbers),
    }
}

/// Σ_i x[i] y[i], in eight partial sums that the compiler can vectorize.
fn dot(x: &[f64], y: &[f64]) -> f64 {
    let ((x8, x_rest), (y8, y_rest)) = (x.as_chunks::<8>(), y.as_chunks::<8>());
    let mut lanes = [0.0; 8];
    for (x, y) in x8.iter().zip(y8) {
        (0..8).for_each(|i| lanes[i] += x[i] * y[i]);
    }
    lanes.iter().sum::<f64>() + x_rest.iter().zip(y_rest).map(|(x, y)| x * y).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use chladni_mesh::samples;
    use proptest::prelude::*;

    use super::super::write_basis_folder;
    use super::*;
    use crate::{BasisSettings, Body};

    /// A ball of radius 25 with one vertex that no triangle uses, and one that two share by welding.
    fn ball() -> (chladni_mesh::TriMesh, Body) {
        let mut ball = samples::icosphere(3);
        ball.positions.iter_mut().for_each(|p| *p = p.map(|x| 25.0 * x));
        ball.positions.extend([[0.0; 3], ball.positions[7]]);
        let twin = ball.positions.len() as u32 - 1;
        let corner = ball.triangles.as_flattened_mut().iter_mut().find(|v| **v == 7);
        *corner.unwrap() = twin;
        let body = Body::build(&ball, &BasisSettings::new(30), &Task::new()).unwrap();
        (ball, body)
    }

    #[test]
    fn a_stored_basis_does_what_one_in_memory_does() {
        let (ball, body) = ball();
        let folder = tempfile::tempdir().unwrap();
        write_basis_folder(folder.path(), &body, &Task::new()).unwrap();
        let (stored, basis) = (StoredBasis::open(folder.path()).unwrap(), body.basis_in_file());
        assert_eq!(stored.eigenvalues(), basis.eigenvalues);
        assert_eq!(stored.mass(), basis.mass);
        assert_eq!(stored.operator_vertex(), body.operator_vertex);
        assert!(stored.mass().len() > 5 * PIECE);

        let file: Vec<[f64; 3]> = ball.positions.iter().map(|p| [p[0], p[1] * p[2], 1.0 + p[2]]).collect();
        let signals: [Vec<f64>; 3] = std::array::from_fn(|c| file.iter().map(|f| f[c]).collect());
        let found = stored.analyze(&signals.each_ref().map(Vec::as_slice), &Task::new()).unwrap();
        let mut rows = vec![[0.0; 3]; basis.vertices()];
        file.iter()
            .zip(&body.operator_vertex)
            .for_each(|(f, v)| v.iter().for_each(|v| rows[*v as usize] = *f));
        for (k, expected) in basis.transform3(&rows).iter().enumerate() {
            assert!((0..3).all(|c| (found[c][k] - expected[c]).abs() < 1e-9), "{k}");
        }

        // Fewer coefficients than harmonics, some of them 0.
        let coefficients: Vec<f64> = (0..20).map(|k| if k % 3 == 0 { 0.0 } else { 1.0 / k as f64 }).collect();
        let back = stored.synthesize(&[&found[1], &coefficients], &Task::new()).unwrap();
        let expected = [basis.synthesize(&found[1]), basis.synthesize(&coefficients)];
        for (c, expected) in expected.iter().enumerate() {
            assert_eq!(back[c].len(), ball.positions.len());
            for (value, v) in back[c].iter().zip(&body.operator_vertex) {
                assert!((value - v.map_or(0.0, |v| expected[v as usize])).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn what_does_not_fit_is_an_error_and_work_can_be_stopped() {
        let folder = tempfile::tempdir().unwrap();
        let (ball, body) = ball();
        write_basis_folder(folder.path(), &body, &Task::new()).unwrap();
        let stored = StoredBasis::open(folder.path()).unwrap();
        let why = |error: HarmonicsError| error.to_string();
        assert!(
            why(stored.analyze(&[&[1.0]], &Task::new()).unwrap_err())
                .contains("1 vertices, where the basis has 644")
        );
        assert!(
            why(stored.synthesize(&[&[1.0; 31]], &Task::new()).unwrap_err())
                .contains("31 coefficients, where the basis has 30")
        );
        let stopped = Task::new();
        stopped.cancel();
        let signal = vec![1.0; ball.positions.len()];
        assert!(matches!(stored.analyze(&[&signal], &stopped), Err(HarmonicsError::Cancelled(_))));
        assert!(matches!(stored.synthesize(&[&[1.0]], &stopped), Err(HarmonicsError::Cancelled(_))));
        // The file loses its end after it was opened.
        let vectors = folder.path().join("eigenvectors.npy");
        let bytes = fs::read(&vectors).unwrap();
        fs::write(&vectors, &bytes[..bytes.len() - 8]).unwrap();
        assert!(why(stored.analyze(&[&signal], &Task::new()).unwrap_err()).contains("eigenvectors.npy"));
        assert!(why(StoredBasis::open(folder.path()).unwrap_err()).contains("642 rows of 30 columns"));
        fs::remove_file(&vectors).unwrap();
        assert!(StoredBasis::open(folder.path()).is_err());
    }

    /// Writing another basis over it is interrupted after the first array.
    #[test]
    fn arrays_of_two_bases_are_never_taken_for_one() {
        let folder = tempfile::tempdir().unwrap();
        let (_, body) = ball();
        write_basis_folder(folder.path(), &body, &Task::new()).unwrap();
        let mass = folder.path().join("mass.npy");
        let before = fs::read(&mass).unwrap();
        fs::remove_file(&mass).unwrap();
        fs::create_dir(&mass).unwrap();
        assert!(write_basis_folder(folder.path(), &body, &Task::new()).is_err());
        fs::remove_dir(&mass).unwrap();
        fs::write(&mass, before).unwrap();
        assert!(matches!(StoredBasis::open(folder.path()), Err(HarmonicsError::Stored { .. })));
        write_basis_folder(folder.path(), &body, &Task::new()).unwrap();
        StoredBasis::open(folder.path()).unwrap();
    }

    #[test]
    fn a_row_between_two_rows_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        write_basis_folder(folder.path(), &ball().1, &Task::new()).unwrap();
        let path = folder.path().join("operator_vertex.npy");
        let rows = numbers(&path, None).unwrap();
        let write = |second: f64| {
            let text = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({},), }}\n", rows.len());
            let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
            bytes.extend((text.len() as u16).to_le_bytes());
            bytes.extend(text.as_bytes());
            let changed = rows.iter().enumerate().map(|(i, row)| if i == 1 { second } else { *row });
            bytes.extend(changed.flat_map(f64::to_le_bytes));
            fs::write(&path, bytes).unwrap();
            StoredBasis::open(folder.path())
        };
        write(rows[1]).unwrap();
        for wrong in [0.5, 1.9, f64::NAN, -0.5] {
            let why = write(wrong).unwrap_err().to_string();
            assert!(why.contains("operator_vertex") && why.contains("is no row"), "{why}");
        }
    }

    /// One of the four files, damaged.
    fn damaged() -> impl Strategy<Value = (usize, Vec<u8>, usize, usize)> {
        (0..4_usize, prop::collection::vec(any::<u8>(), 1..12), 0..2000_usize, 0..200_usize)
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]
        #[test]
        fn damaged_folders_are_read_or_refused((which, junk, at, lost) in damaged()) {
            let folder = tempfile::tempdir().unwrap();
            let icosahedron = samples::icosphere(0);
            let body = Body::build(&icosahedron, &BasisSettings::new(5), &Task::new()).unwrap();
            write_basis_folder(folder.path(), &body, &Task::new()).unwrap();
            let path = folder.path().join(format!("{}.npy", ["eigenvectors", "eigenvalues", "mass", "operator_vertex"][which]));
            let mut bytes = fs::read(&path).unwrap();
            let at = at % bytes.len();
            bytes.iter_mut().skip(at).zip(&junk).for_each(|(byte, junk)| *byte = *junk);
            bytes.truncate(bytes.len() - lost.min(bytes.len()));
            fs::write(&path, bytes).unwrap();
            if let Ok(stored) = StoredBasis::open(folder.path()) {
                let signal = vec![1.0; stored.operator_vertex().len()];
                stored.analyze(&[&signal], &Task::new()).unwrap();
                stored.synthesize(&[&[1.0, 0.5]], &Task::new()).unwrap();
            }
        }
    }
}
