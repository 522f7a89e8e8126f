//! Files that are read whole, up to a size limit, and the time of their use.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::time::SystemTime;

/// The content of the regular file at `path`, of at most `most_bytes` bytes.
///
/// # Errors
/// An error of the file system; [`io::ErrorKind::IsADirectory`] for a folder;
/// [`io::ErrorKind::InvalidInput`] for a device or a pipe, because reading it might never end;
/// [`io::ErrorKind::FileTooLarge`] if the file is longer than `most_bytes`.
pub fn read_file(path: &Path, most_bytes: u64) -> io::Result<Vec<u8>> {
    let mut file = open_file(path)?;
    let too_large = || {
        let why = format!("larger than the {} that are read of such a file", in_words(most_bytes));
        io::Error::new(io::ErrorKind::FileTooLarge, why)
    };
    let length = file.metadata()?.len();
    if length > most_bytes {
        return Err(too_large());
    }
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(usize::try_from(length).map_err(|_| too_large())?)?;
    // The file may grow while it is read.
    file.by_ref().take(most_bytes).read_to_end(&mut bytes)?;
    if file.read(&mut [0])? > 0 {
        return Err(too_large());
    }
    Ok(bytes)
}

/// The content of a file as text, without the mark with which some programs begin UTF-8; otherwise the same as [`read_file`].
///
/// # Errors
/// Those of [`read_file`], and [`io::ErrorKind::InvalidData`] if the content is not UTF-8.
pub fn read_text_file(path: &Path, most_bytes: u64) -> io::Result<String> {
    let mut bytes = read_file(path, most_bytes)?;
    if bytes.starts_with(b"\xef\xbb\xbf") {
        bytes.drain(..3);
    }
    String::from_utf8(bytes)
        .map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "it is not a text in UTF-8"))
}

/// Opens the regular file at `path` for reading.
///
/// # Errors
/// Those of [`read_file`], except that the size is not limited.
pub fn open_file(path: &Path) -> io::Result<File> {
    // Checked before the file is opened: opening a pipe would wait for a writer.
    let found = std::fs::metadata(path)?;
    if found.is_dir() {
        return Err(io::Error::from(io::ErrorKind::IsADirectory));
    }
    if !found.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is a device or a pipe, not a file"));
    }
    File::open(path)
}

/// Dates the file at `path` now, as one that was used. Its content stays.
///
/// # Errors
/// Those of the file system, such as of a file that may not be written.
pub fn date_now(path: &Path) -> io::Result<()> {
    // Windows dates only what is open for writing.
    File::options().append(true).open(path)?.set_modified(SystemTime::now())
}

fn in_words(bytes: u64) -> String {
    if bytes >= 1 << 30 { format!("{} GiB", bytes >> 30) } else { format!("{} MiB", bytes >> 20) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_read_without_its_mark() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("list.txt");
        std::fs::write(&path, b"\xef\xbb\xbfa.obj\n").unwrap();
        assert_eq!(read_text_file(&path, 99).unwrap(), "a.obj\n");
    }

    #[test]
    fn a_file_that_was_used_is_dated_and_keeps_its_content() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("old");
        assert!(date_now(&path).is_err() && !path.exists());
        std::fs::write(&path, b"it").unwrap();
        let modified = || path.metadata().unwrap().modified().unwrap();
        File::options().append(true).open(&path).unwrap().set_modified(SystemTime::UNIX_EPOCH).unwrap();
        date_now(&path).unwrap();
        assert!(modified() > SystemTime::UNIX_EPOCH && std::fs::read(&path).unwrap() == b"it");
    }

    #[test]
    fn a_file_is_read_up_to_its_bound() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        std::fs::write(&path, [7; 100]).unwrap();
        assert_eq!(read_file(&path, 100).unwrap(), [7; 100]);
        assert_eq!(read_file(&path, 99).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        assert_eq!(read_file(folder.path(), 99).unwrap_err().kind(), io::ErrorKind::IsADirectory);
        std::fs::write(&path, [0xff; 4]).unwrap();
        assert_eq!(read_text_file(&path, 99).unwrap_err().kind(), io::ErrorKind::InvalidData);
    }

    #[cfg(unix)]
    #[test]
    #[allow(clippy::print_stdout, reason = "a skipped part must say so")]
    fn what_never_ends_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        // Nobody writes into it: to open it would wait for ever.
        let made = std::process::Command::new("mkfifo").arg(at("pipe")).status();
        for (target, link) in [("/dev/zero", "device"), ("pipe", "to-pipe")] {
            std::os::unix::fs::symlink(target, at(link)).unwrap();
        }
        let mut unending = vec![at("device"), "/dev/zero".into(), "/dev/null".into()];
        if made.is_ok_and(|made| made.success()) {
            unending.extend([at("pipe"), at("to-pipe")]);
        } else {
            println!("skipped: a pipe, which mkfifo does not make here");
        }
        for path in unending {
            let error = read_file(&path, 1 << 20).unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::InvalidInput, "{}: {error}", path.display());
        }
    }
}
