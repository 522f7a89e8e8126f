//! What differs between an operating system and a page in a browser: the clock, and whether there are threads.

use faer::Par;

pub(crate) use web_time::Instant;

/// Whether threads can be started. A page has only the one that it is called on.
pub(crate) const HAS_THREADS: bool = !cfg!(target_family = "wasm");

/// All threads of the pool that this is called in, for dense products and factorizations.
#[cfg(not(target_family = "wasm"))]
pub(crate) fn all_threads() -> Par {
    Par::rayon(rayon::current_num_threads())
}

#[cfg(target_family = "wasm")]
pub(crate) fn all_threads() -> Par {
    Par::Seq
}
