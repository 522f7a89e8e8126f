//! A file that can be opened a second time.

use std::io::{Read, Result, Seek, SeekFrom};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use symphonia::core::io::MediaSource;

/// A source that outlives the container reader that reads it.
#[derive(Clone)]
pub(super) struct SharedSource(Arc<Mutex<Box<dyn MediaSource>>>);

impl SharedSource {
    pub fn new(source: Box<dyn MediaSource>) -> Self {
        Self(Arc::new(Mutex::new(source)))
    }

    fn source(&self) -> MutexGuard<'_, Box<dyn MediaSource>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Read for SharedSource {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        self.source().read(buffer)
    }
}

impl Seek for SharedSource {
    fn seek(&mut self, to: SeekFrom) -> Result<u64> {
        self.source().seek(to)
    }
}

impl MediaSource for SharedSource {
    fn is_seekable(&self) -> bool {
        self.source().is_seekable()
    }

    fn byte_len(&self) -> Option<u64> {
        self.source().byte_len()
    }
}
