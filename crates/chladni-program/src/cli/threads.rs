//! The threads that all parallel work of a command shares.

use std::io;
use std::num::NonZero;
use std::sync::mpsc::{Sender, channel};

use rayon::{ThreadBuilder, ThreadPoolBuilder};

use crate::work::Warning;

/// A thread that waits for its place in a pool, and ends without one.
type Waiting = Sender<ThreadBuilder>;

/// Starts the shared threads: one for each core, or as many as `RAYON_NUM_THREADS` says. Left to itself, the pool would
/// panic where the system gives fewer, and cannot be built a second time. Then a warning says how many there are.
pub fn start() -> Option<Warning> {
    let wanted = wanted();
    let waiting = as_many(wanted, wait);
    let got = waiting.len();
    let pool = ThreadPoolBuilder::new().num_threads(got.max(1));
    // It fails only where there is a pool already.
    let _ = if waiting.is_empty() {
        pool.use_current_thread().build_global()
    } else {
        pool.spawn_handler(places_for(waiting)).build_global()
    };
    let why = "the system gives too few";
    (got < wanted).then(|| Warning::Plain(format!("{} of {wanted} threads are used: {why}", got.max(1))))
}

/// As many as the pool would have by itself.
fn wanted() -> usize {
    let chosen = std::env::var("RAYON_NUM_THREADS").ok().and_then(|number| number.parse::<usize>().ok());
    let cores = || std::thread::available_parallelism().map_or(1, NonZero::get);
    chosen.filter(|number| *number > 0).unwrap_or_else(cores).min(rayon::max_num_threads())
}

/// As many as are `wanted`; where fewer can be started, half of those, since other work needs threads, too.
fn as_many(wanted: usize, start: impl Fn() -> io::Result<Waiting>) -> Vec<Waiting> {
    let mut waiting: Vec<Waiting> = (0..wanted).map_while(|_| start().ok()).collect();
    if waiting.len() < wanted {
        waiting.truncate(waiting.len().div_ceil(2));
    }
    waiting
}

fn wait() -> io::Result<Waiting> {
    let (give, take) = channel();
    std::thread::Builder::new().spawn(move || take.into_iter().for_each(ThreadBuilder::run))?;
    Ok(give)
}

/// Gives each of them one place in a pool.
fn places_for(mut waiting: Vec<Waiting>) -> impl FnMut(ThreadBuilder) -> io::Result<()> {
    move |place| {
        let given = waiting.pop().and_then(|thread| thread.send(place).ok());
        given.ok_or_else(|| io::Error::other("there are more places than threads"))
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    #[test]
    fn where_the_system_gives_fewer_threads_half_of_them_make_a_pool() {
        for (wanted, given, used) in [(2, 2_usize, 2), (8, 5, 3), (8, 1, 1), (1, 0, 0)] {
            let left = Cell::new(given);
            let start = || {
                let one = left.get().checked_sub(1).ok_or_else(|| io::Error::other("no more"))?;
                left.set(one);
                wait()
            };
            let waiting = as_many(wanted, start);
            assert_eq!(waiting.len(), used);
            if used > 0 {
                let pool = ThreadPoolBuilder::new().num_threads(used).spawn_handler(places_for(waiting));
                assert_eq!(pool.build().unwrap().install(rayon::current_num_threads), used);
            }
        }
    }
}
