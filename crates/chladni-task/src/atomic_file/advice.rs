//! What to do about a file that could not be written.

use std::io::{self, ErrorKind};

const FULL: &str = "the disk is full: make room, or write to another one";
const FAILED: &str = "the disk failed: write to another one; what was there before is unchanged";

/// Adds advice to the errors of writing a file that a user can do something about.
pub fn advised(error: io::Error) -> io::Error {
    let advice = match error.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => FULL,
        ErrorKind::ReadOnlyFilesystem => "the disk is read-only: write to another one",
        ErrorKind::PermissionDenied => "permission denied: write to a folder of your own",
        ErrorKind::CrossesDevices => {
            "its folder lies on two disks, between which no file can be renamed: write to another one; \
             what was there before is unchanged"
        }
        _ if error.raw_os_error().is_some_and(|code| DISK_FAILED.contains(&code)) => FAILED,
        _ => return error,
    };
    io::Error::new(error.kind(), advice)
}

/// The system's numbers for an input/output error, of which the standard library makes no kind: EIO; elsewhere those of
/// Windows for a checksum and for a device.
pub(super) const DISK_FAILED: &[i32] = if cfg!(unix) { &[5] } else { &[23, 1117] };

/// The error, with advice, that another program says it met as it wrote a file, where there is one in its words.
pub fn advice_in(said: &str) -> Option<io::Error> {
    let known = [
        ("No space left on device", ErrorKind::StorageFull, FULL),
        ("Disk quota exceeded", ErrorKind::QuotaExceeded, FULL),
        ("Input/output error", ErrorKind::Other, FAILED),
    ];
    let (_, kind, advice) = known.into_iter().find(|(words, ..)| said.contains(words))?;
    Some(io::Error::new(kind, advice))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_another_program_says_of_the_disk_gets_our_advice() {
        let advice = |said| advice_in(said).map(|why| why.to_string());
        let full = advice("av_interleaved_write_frame(): No space left on device");
        assert!(full.is_some_and(|said| said.contains("make room")));
        assert!(advice("d.mp4: Input/output error").is_some_and(|said| said.contains("write to another")));
        assert_eq!(advice("d.mp4: Invalid argument"), None);
    }
}
