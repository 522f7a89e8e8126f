//! The threads that all parallel work of a command shares.

use std::io;
use std::num::NonZero;
use std::sync::mpsc::{Sender, channel};

use chladni_harmonics::MOST_THREADS;
use rayon::{ThreadBuilder, ThreadPoolBuilder};

use crate::work::Warning;

/// A thread that waits for its place in a pool, and ends without one.
type Waiting = Sender<ThreadBuilder>;

/// Starts the shared threads: one for each core, or as many as `RAYON_NUM_THREADS` says. Left to itself, the pool would
/// panic where the system gives fewer, and cannot be built a second time. Then, and where more are asked for than are
/// possible, a warning says how many there are.
pub fn start() -> Option<Warning> {
    let asked = std::env::var("RAYON_NUM_THREADS").ok().and_then(|number| number.parse::<usize>().ok());
    let asked = asked.filter(|number| *number > 0);
    let wanted = wanted(asked);
    let waiting = as_many(wanted, wait);
    let got = waiting.len();
    let pool = ThreadPoolBuilder::new().num_threads(got.max(1));
    // It fails only where there is a pool already.
    let _ = if waiting.is_empty() {
        pool.use_current_thread().build_global()
    } else {
        pool.spawn_handler(places_for(waiting)).build_global()
    };
    let asked = asked.unwrap_or(wanted);
    let why = if got < wanted { "the system gives too few" } else { "more are not possible" };
    (got < asked).then(|| Warning::Plain(format!("{} of {asked} threads are used: {why}", got.max(1))))
}

/// As many as are `asked` for, within reason, or one for each core.
fn wanted(asked: Option<usize>) -> usize {
    let cores = || std::thread::available_parallelism().map_or(1, NonZero::get);
    asked.map_or_else(cores, |asked| asked.min(MOST_THREADS)).min(rayon::max_num_threads())
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
    fn no_more_threads_are_wanted_than_may_be_asked_for() {
        let most = MOST_THREADS.min(rayon::max_num_threads());
        assert_eq!([1, 3, 2000].map(|asked| wanted(Some(asked))), [1, 3, most]);
        assert!(wanted(None) > 0);
    }

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
