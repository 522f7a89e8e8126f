//! Threads in a page: a worker cannot start any, so the page starts further workers that share its memory, and each lends
//! itself to rayon.

use std::sync::{Condvar, Mutex, PoisonError};

use rayon::{ThreadBuilder, ThreadPoolBuilder};
use wasm_bindgen::prelude::*;

/// Threads that nobody has taken yet.
static OPEN: Mutex<Vec<ThreadBuilder>> = Mutex::new(Vec::new());
static OPENED: Condvar = Condvar::new();

/// All work of this worker is done on `threads` threads from now on: its own, and those of workers that call
/// [`join_pool`]. Waits for them.
///
/// # Errors
/// A second call.
#[wasm_bindgen]
pub fn open_pool(threads: usize) -> Result<(), JsError> {
    let offer = |thread| {
        OPEN.lock().unwrap_or_else(PoisonError::into_inner).push(thread);
        OPENED.notify_one();
        Ok(())
    };
    Ok(ThreadPoolBuilder::new()
        .num_threads(threads)
        .use_current_thread()
        .spawn_handler(offer)
        .build_global()?)
}

/// Is one of the threads, until the page ends this worker.
#[wasm_bindgen]
pub fn join_pool() {
    let mut open = OPEN.lock().unwrap_or_else(PoisonError::into_inner);
    let thread = loop {
        match open.pop() {
            Some(thread) => break thread,
            None => open = OPENED.wait(open).unwrap_or_else(PoisonError::into_inner),
        }
    };
    drop(open);
    thread.run();
}

/// How many threads answer.
#[wasm_bindgen]
pub fn threads() -> usize {
    rayon::broadcast(|_| ()).len()
}
