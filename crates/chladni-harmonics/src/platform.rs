//! What differs between an operating system and a page in a browser: the clock, and whether there are threads.

use faer::Par;

pub(crate) use web_time::Instant;

/// Whether threads can be started. A page has only the one that it is called on.
pub(crate) const HAS_THREADS: bool = !cfg!(target_family = "wasm");

/// How dense products and factorizations are split: into as many parts on any number of threads, since as many
/// as there are threads would round differently on each machine.
#[cfg(not(target_family = "wasm"))]
pub(crate) fn split() -> Par {
    Par::rayon(8)
}

#[cfg(target_family = "wasm")]
pub(crate) fn split() -> Par {
    Par::Seq
}
