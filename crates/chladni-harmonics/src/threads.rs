//! Work on as many threads as were asked for.

use crate::HarmonicsError;
use crate::platform::HAS_THREADS;

/// The largest number of threads that may be asked for.
const MOST_THREADS: usize = 1024;

/// Runs `work` on `threads` threads. `None` means the pool from which it is called, or all threads of the
/// machine. If no thread can be started, the calling thread does all of the work.
pub(crate) fn on_threads<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> T + Send,
) -> Result<T, HarmonicsError> {
    if let Some(threads) = threads.filter(|threads| *threads > MOST_THREADS) {
        return Err(HarmonicsError::TooManyThreads { threads, most: MOST_THREADS });
    }
    if !HAS_THREADS || (threads.is_none() && rayon::current_thread_index().is_some()) {
        return Ok(work());
    }
    // Not in the shared pool: drawing uses it and must not wait for a solve.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build();
    Ok(pool.map_err(|e| HarmonicsError::Threads(e.to_string()))?.install(work))
}
