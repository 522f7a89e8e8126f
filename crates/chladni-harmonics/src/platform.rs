//! Differences between an operating system and a web page: the clock, and who starts threads.

use faer::Par;

pub(crate) use web_time::Instant;

/// Whether threads can be started. In a web page its JavaScript does that, before anything is asked for: there is the pool
/// from which we are called, or that one thread.
pub(crate) const HAS_THREADS: bool = !cfg!(target_family = "wasm");

/// The bytes that a program can have at most, whatever the system has: a page's module addresses 4 GiB.
pub(crate) const MOST_BYTES: Option<u64> = if cfg!(target_family = "wasm") { Some(1 << 32) } else { None };

/// How dense products and factorizations are split: into the same number of parts for any number of
/// threads, because the number of parts affects the rounding.
#[cfg(not(target_family = "wasm"))]
pub(crate) fn split() -> Par {
    Par::rayon(8)
}

#[cfg(target_family = "wasm")]
pub(crate) fn split() -> Par {
    Par::Seq
}
