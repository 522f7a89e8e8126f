//! Work on as many threads as were asked for.

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::HarmonicsError;
use crate::platform::HAS_THREADS;

/// The largest number of threads that may be asked for.
pub const MOST_THREADS: usize = 1024;

/// Runs `work` on `threads` threads. `None` means the pool from which it is called, or all threads of the
/// machine. Where the system gives fewer there are fewer; if it gives hardly any, the calling thread does all of the work.
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
    match pool_of(threads.unwrap_or_else(|| usual(std::env::var("RAYON_NUM_THREADS").ok().as_deref()))) {
        Some(pool) => Ok(pool.install(work)),
        None => on_calling_thread(work),
    }
}

/// 0, for as many as the variable `RAYON_NUM_THREADS` or the machine says; the most, where the variable asks for more.
fn usual(variable: Option<&str>) -> usize {
    let asked = variable.and_then(|number| number.parse::<usize>().ok());
    if asked.is_some_and(|asked| asked > MOST_THREADS) { MOST_THREADS } else { 0 }
}

/// A pool of this many threads, 0 for all of the machine, or of half of those that the system gives.
fn pool_of(threads: usize) -> Option<ThreadPool> {
    let mut started = Vec::new();
    let pool = ThreadPoolBuilder::new().num_threads(threads).spawn_handler(|thread| {
        started.push(std::thread::Builder::new().spawn(|| thread.run())?);
        Ok(())
    });
    if let Ok(pool) = pool.build() {
        return Some(pool);
    }
    let fewer = started.len() / 2;
    // There is room once they have ended.
    started.into_iter().for_each(|thread| drop(thread.join()));
    if fewer > 0 { pool_of(fewer) } else { None }
}

/// Runs `work` where no thread can be started, not even those of the shared pool.
fn on_calling_thread<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T, HarmonicsError> {
    if rayon::current_thread_index().is_some() {
        return Ok(work());
    }
    let pool = ThreadPoolBuilder::new().num_threads(1).use_current_thread().build();
    Ok(pool.map_err(|e| HarmonicsError::Threads(e.to_string()))?.install(work))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_variable_does_not_ask_for_more_threads_than_there_may_be() {
        assert_eq!([None, Some("two"), Some("2"), Some("2000")].map(usual), [0, 0, 0, MOST_THREADS]);
    }

    #[test]
    fn without_threads_the_calling_one_does_all_of_the_work() {
        // It stays in its own pool, so that it has to be one of the test.
        let caller = std::thread::spawn(|| {
            let who = || (std::thread::current().id(), rayon::current_num_threads());
            (who().0, [(); 2].map(|()| on_calling_thread(who).unwrap()))
        });
        let (caller, who) = caller.join().unwrap();
        assert_eq!(who, [(caller, 1); 2]);
    }
}
