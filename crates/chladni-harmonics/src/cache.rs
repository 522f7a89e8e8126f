//! A cache on disk for bases: a shape is solved only once.

use std::fs;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use chladni_task::write_atomic_with;

use crate::operator::Domain;
use crate::values::{Keep, Values};
use crate::{Basis, BasisSettings, Certificate, HarmonicsError, Laplacian, memory};

/// Increased whenever the same mesh and settings would give a different basis or certificate.
const VERSION: u32 = 5;
const MAGIC: &[u8; 16] = b"chladni basis  1";
/// How much the entries of a cache take together unless it says otherwise, in bytes.
const MOST_BYTES: u64 = 10 << 30;

/// A folder of solved bases.
///
/// The name of an entry is a BLAKE3 hash of the welded surface, the settings and the version of the solver.
/// An entry ends with a hash of its own bytes: a damaged entry is solved again and never trusted. Entries
/// are written whole or not at all; several processes may share the folder. Together the entries take 10 GiB at most, or
/// as much as the newest: each that is written removes those that were used the longest time ago.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BasisCache {
    folder: PathBuf,
    most_bytes: u64,
}

impl BasisCache {
    /// A cache in `folder`, which is created when the first entry is written.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into(), most_bytes: MOST_BYTES }
    }

    /// The same cache with another bound on what all entries take, in bytes.
    #[must_use]
    pub fn of_at_most(self, most_bytes: u64) -> Self {
        Self { most_bytes, ..self }
    }

    /// The cache in the user's cache folder; `None` if the system does not define one.
    pub fn of_user() -> Option<Self> {
        let folders = directories::ProjectDirs::from("", "", "chladni")?;
        Some(Self::new(folders.cache_dir().join("bases")))
    }

    /// The folder of the entries.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    pub(crate) fn entry(&self, domain: &Domain, settings: &BasisSettings) -> CacheEntry {
        let laplacian = settings.laplacian;
        let path = self.folder.join(name(VERSION, domain, settings));
        CacheEntry { laplacian, path, most_bytes: self.most_bytes }
    }
}

/// The name of the entry that this version of the solver makes.
fn name(version: u32, domain: &Domain, settings: &BasisSettings) -> String {
    let mut hash = blake3::Hasher::new();
    hash.update(&version.to_le_bytes());
    hash.update(&(settings.harmonics as u64).to_le_bytes());
    hash.update(&[u8::from(settings.whole_clusters)]);
    hash.update(settings.laplacian.to_string().as_bytes());
    hash.update(&(domain.positions.len() as u64).to_le_bytes());
    hash.update(bytemuck::cast_slice(&domain.positions));
    hash.update(bytemuck::cast_slice(&domain.triangles));
    format!("{}.basis", hash.finalize().to_hex())
}

/// The file of one basis in the cache.
pub(crate) struct CacheEntry {
    /// The Laplacian, which is a part of the name.
    laplacian: Laplacian,
    path: PathBuf,
    /// What all entries may take.
    most_bytes: u64,
}

/// Why an entry was not used or not written. The work goes on without it, and this is its warning.
#[derive(Debug, thiserror::Error)]
pub(crate) enum CacheError {
    #[error("{}: {source}", path.display())]
    Unreadable { path: PathBuf, source: io::Error },
    #[error("damaged cache entry {} was solved again: {damage}", path.display())]
    Damaged { path: PathBuf, damage: Damage },
    #[error("the basis was not cached: {}: {source}", path.display())]
    Unwritten { path: PathBuf, source: io::Error },
    #[error(transparent)]
    NoRoom(#[from] HarmonicsError),
}

/// A fault in an entry.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Damage {
    #[error("its head does not fit")]
    Head,
    #[error("its checksum does not match")]
    Checksum,
    #[error(transparent)]
    Io(#[from] io::Error),
}

/// The header of an entry, of fixed size. It is followed by eigenvalues, mass and vectors (f64, native byte
/// order) and the BLAKE3 hash of everything before it.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Header {
    magic: [u8; 16],
    vertices: u64,
    harmonics: u64,
    inertia_counts_match: u64,
    cuts_cluster: u64,
    max_relative_residual: f64,
    max_orthogonality_error: f64,
}

impl CacheEntry {
    /// The basis and whether it cuts a cluster; `None` if there is no entry.
    pub(crate) fn read(
        &self,
        vertices: usize,
        settings: &BasisSettings,
    ) -> Result<Option<(Basis, bool)>, CacheError> {
        let mut file = match chladni_task::open_file(&self.path) {
            Ok(file) => file,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(source) => return Err(CacheError::Unreadable { path: self.path.clone(), source }),
        };
        // The time of an entry is that of its last use. In a folder that cannot be written nothing is removed, either.
        let _ = chladni_task::date_now(&self.path);
        let length = file.metadata().map(|m| m.len()).unwrap_or(0);
        let keep = memory::room_for_harmonics(vertices, 1, settings)?;
        read_entry(&mut file, length, vertices, self.laplacian, keep)
            .map(Some)
            .map_err(|damage| CacheError::Damaged { path: self.path.clone(), damage })
    }

    /// Writes the entry, whole or not at all.
    pub(crate) fn write(&self, basis: &Basis, cuts_cluster: bool) -> Result<(), CacheError> {
        let unwritten = |source| CacheError::Unwritten { path: self.path.clone(), source };
        if let Some(folder) = self.path.parent() {
            chladni_task::create_folder(folder).map_err(unwritten)?;
        }
        let header = Header {
            magic: *MAGIC,
            vertices: basis.vertices() as u64,
            harmonics: basis.harmonics() as u64,
            inertia_counts_match: basis.certificate.inertia_counts_match.map_or(2, u64::from),
            cuts_cluster: u64::from(cuts_cluster),
            max_relative_residual: basis.certificate.max_relative_residual,
            max_orthogonality_error: basis.certificate.max_orthogonality_error,
        };
        // A damaged entry may be a link to a file of another kind, which stays as it is.
        if self.path.is_symlink() {
            fs::remove_file(&self.path).map_err(unwritten)?;
        }
        let mut checksum = [0; blake3::OUT_LEN];
        let written = write_atomic_with(&self.path, |file| {
            let mut hash = blake3::Hasher::new();
            for part in [
                bytemuck::bytes_of(&header),
                bytemuck::cast_slice(&basis.eigenvalues),
                bytemuck::cast_slice(&basis.mass),
                bytemuck::cast_slice(&basis.vectors),
            ] {
                hash.update(part);
                file.write_all(part)?;
            }
            checksum = *hash.finalize().as_bytes();
            file.write_all(&checksum)
        });
        // Some systems do not replace a file that is read: then another program has written this entry.
        if let Err(source) = written
            && !self.ends_with(&checksum).unwrap_or(false)
        {
            return Err(unwritten(source));
        }
        self.remove_unused();
        Ok(())
    }

    /// Whether the file that is there has this checksum at its end.
    fn ends_with(&self, checksum: &[u8; blake3::OUT_LEN]) -> io::Result<bool> {
        let mut file = chladni_task::open_file(&self.path)?;
        file.seek(SeekFrom::End(-(blake3::OUT_LEN as i64)))?;
        let mut there = [0; blake3::OUT_LEN];
        file.read_exact(&mut there)?;
        Ok(there == *checksum)
    }

    /// Removes the entries that were used the longest time ago while all take more than they may. This one stays. What
    /// cannot be removed, as it is in use or another process was faster, stays or is gone.
    fn remove_unused(&self) {
        let files =
            self.path.parent().and_then(|folder| fs::read_dir(folder).ok()).into_iter().flatten().flatten();
        let mut entries: Vec<(SystemTime, u64, PathBuf)> = files
            .filter(|file| is_entry(&file.path()))
            .filter_map(|file| {
                let known = file.metadata().ok().filter(fs::Metadata::is_file)?;
                Some((known.modified().ok()?, known.len(), file.path()))
            })
            .collect();
        entries.sort_unstable();
        let mut total: u64 = entries.iter().map(|(_, length, _)| length).sum();
        for (_, length, path) in entries {
            if total <= self.most_bytes {
                return;
            }
            if path != self.path && fs::remove_file(&path).is_ok() {
                total -= length;
            }
        }
    }
}

/// Whether a file of this name is an entry, of whatever version.
fn is_entry(path: &Path) -> bool {
    let name = path.file_stem().and_then(|name| name.to_str()).unwrap_or_default();
    path.extension().is_some_and(|ending| ending == "basis")
        && name.len() == 2 * blake3::OUT_LEN
        && name.bytes().all(|byte| byte.is_ascii_hexdigit())
}

fn read_entry(
    file: &mut fs::File,
    length: u64,
    vertices: usize,
    laplacian: Laplacian,
    keep: Keep,
) -> Result<(Basis, bool), Damage> {
    let mut hash = blake3::Hasher::new();
    let mut header: Header = bytemuck::Zeroable::zeroed();
    read_part(file, bytemuck::bytes_of_mut(&mut header), &mut hash)?;
    let (n, k) = (header.vertices, header.harmonics);
    let values = k.checked_mul(n).and_then(|v| v.checked_add(k)).and_then(|v| v.checked_add(n));
    let expected =
        values.and_then(|v| v.checked_mul(8)).and_then(|b| b.checked_add(size_of::<Header>() as u64 + 32));
    if header.magic != *MAGIC || n != vertices as u64 || expected != Some(length) {
        return Err(Damage::Head);
    }
    let (n, k) = (n as usize, k as usize);
    // The length of the file has been checked: the buffers are not larger than the file.
    let (mut eigenvalues, mut mass) = (vec![0.0; k], vec![0.0; n]);
    let mut vectors = Values::zeroed(n * k, keep)?;
    for part in [&mut eigenvalues[..], &mut mass, &mut vectors] {
        read_part(file, bytemuck::cast_slice_mut(part), &mut hash)?;
    }
    let mut stored = [0; 32];
    file.read_exact(&mut stored)?;
    if hash.finalize() != blake3::Hash::from_bytes(stored) {
        return Err(Damage::Checksum);
    }
    let certificate = Certificate {
        laplacian,
        inertia_counts_match: match header.inertia_counts_match {
            0 => Some(false),
            1 => Some(true),
            _ => None,
        },
        max_relative_residual: header.max_relative_residual,
        max_orthogonality_error: header.max_orthogonality_error,
    };
    Ok((Basis { eigenvalues, vectors, mass, certificate }, header.cuts_cluster == 1))
}

fn read_part(file: &mut fs::File, bytes: &mut [u8], hash: &mut blake3::Hasher) -> io::Result<()> {
    file.read_exact(bytes)?;
    hash.update(bytes);
    Ok(())
}

#[cfg(test)]
mod tests {
    use chladni_mesh::TriMesh;

    use super::*;

    #[test]
    fn another_version_and_other_settings_have_other_names() {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let mesh = TriMesh { positions, triangles, ..TriMesh::default() };
        let domain = Domain::of(&mesh).unwrap();
        let [few, more] = [2, 3].map(BasisSettings::new);
        let ours = name(VERSION, &domain, &few);
        assert_eq!(ours, name(VERSION, &domain, &few));
        assert_ne!(ours, name(VERSION + 1, &domain, &few));
        assert_ne!(ours, name(VERSION, &domain, &more));
    }
}
