//! A writer that fails once.

use std::cell::Cell;
use std::io::{Error, ErrorKind, Result, Seek, SeekFrom, Write};
use std::rc::Rc;

/// Writes into another writer until that fails, or [`is_over`](Self::is_over) is set. From then on it takes everything and
/// writes nothing: a `ZipWriter` that is dropped finishes its archive, and prints where it cannot.
pub(super) struct FailsOnce<W> {
    into: W,
    is_over: Rc<Cell<bool>>,
    /// Where the next byte goes, and where the last one ends.
    at: u64,
    end: u64,
}

impl<W> FailsOnce<W> {
    /// Writes into `into`, which is empty.
    pub fn new(into: W) -> Self {
        Self { into, is_over: Rc::default(), at: 0, end: 0 }
    }

    /// Whether nothing is written any more.
    pub fn is_over(&self) -> Rc<Cell<bool>> {
        Rc::clone(&self.is_over)
    }

    /// The writer that was written into; an error where it failed, and nobody has noticed.
    pub fn into_inner(self) -> Result<W> {
        if self.is_over.get() { Err(Error::other("a part of it was not written")) } else { Ok(self.into) }
    }

    fn noting<T>(&mut self, done: impl FnOnce(&mut W) -> Result<T>) -> Result<T> {
        let done = done(&mut self.into);
        // What was interrupted is tried again.
        if done.as_ref().is_err_and(|error| error.kind() != ErrorKind::Interrupted) {
            self.is_over.set(true);
        }
        done
    }
}

impl<W: Write> Write for FailsOnce<W> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        let count = if self.is_over.get() { bytes.len() } else { self.noting(|into| into.write(bytes))? };
        self.at += count as u64;
        self.end = self.end.max(self.at);
        Ok(count)
    }

    fn flush(&mut self) -> Result<()> {
        if self.is_over.get() { Ok(()) } else { self.noting(Write::flush) }
    }
}

impl<W: Seek> Seek for FailsOnce<W> {
    fn seek(&mut self, to: SeekFrom) -> Result<u64> {
        self.at = match to {
            _ if !self.is_over.get() => self.noting(|into| into.seek(to))?,
            SeekFrom::Start(at) => at,
            SeekFrom::Current(by) => self.at.saturating_add_signed(by),
            SeekFrom::End(by) => self.end.saturating_add_signed(by),
        };
        Ok(self.at)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::super::{Npz, archived};
    use super::*;

    /// A disk with room for so many more bytes.
    struct Disk {
        bytes: Cursor<Vec<u8>>,
        room: usize,
        is_full: bool,
        asked_when_full: usize,
    }

    impl Disk {
        fn with(room: usize) -> Self {
            Self { bytes: Cursor::default(), room, is_full: false, asked_when_full: 0 }
        }

        fn asked(&mut self) {
            self.asked_when_full += usize::from(self.is_full);
        }
    }

    impl Write for Disk {
        fn write(&mut self, bytes: &[u8]) -> Result<usize> {
            self.asked();
            if self.room == 0 {
                self.is_full = true;
                return Err(Error::new(ErrorKind::StorageFull, "no room"));
            }
            let count = bytes.len().min(self.room);
            self.room -= count;
            self.bytes.write(&bytes[..count])
        }

        fn flush(&mut self) -> Result<()> {
            self.asked();
            Ok(())
        }
    }

    impl Seek for Disk {
        fn seek(&mut self, to: SeekFrom) -> Result<u64> {
            self.asked();
            self.bytes.seek(to)
        }
    }

    fn fill<W: Write + Seek>(npz: &mut Npz<W>) -> Result<()> {
        npz.array("mask", &[3], [0.0_f32, 0.25, 1.0])?;
        npz.array("part", &[2], [-1_i64, 7])
    }

    #[test]
    fn a_disk_that_is_full_is_not_asked_again_and_says_so_once() {
        const ROOM: usize = 1 << 20;
        let mut disk = Disk::with(ROOM);
        archived(&mut disk, fill).unwrap();
        let needed = ROOM - disk.room;
        for room in 0..needed {
            let mut disk = Disk::with(room);
            let error = archived(&mut disk, fill).map(drop).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::StorageFull, "{room}");
            assert_eq!(error.to_string(), "no room");
            assert!(disk.is_full && disk.asked_when_full == 0, "{room}: {}", disk.asked_when_full);
        }
    }

    #[test]
    fn an_archive_that_is_given_up_is_not_finished() {
        let mut disk = Disk::with(1 << 20);
        let given_up = archived(&mut disk, |npz| {
            npz.array("mask", &[1], [0.5_f32])?;
            Err(Error::other("given up"))
        });
        assert_eq!(given_up.map(drop).unwrap_err().to_string(), "given up");
        assert!(!disk.bytes.into_inner().windows(4).any(|four| four == b"PK\x05\x06"));
        // A failure that is passed over is one all the same.
        let mut disk = Disk::with(9);
        let passed_over = archived(&mut disk, |npz| {
            let _ = fill(npz);
            Ok(())
        });
        assert!(passed_over.is_err());
    }
}
