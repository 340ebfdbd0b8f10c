//! Work spread over threads.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use rayon::ThreadPool;
use rayon::prelude::*;

/// Runs every job once, on this many threads; 0 is rayon's own number (`RAYON_NUM_THREADS`, or as many as there are cores).
///
/// One job, or one thread, is a plain loop here: no other thread is woken for it. So is all where the machine gives no more
/// threads.
pub(crate) fn spread<J: Send>(threads: usize, jobs: Vec<J>, run: impl Fn(J) + Sync) {
    if threads != 1
        && jobs.len() > 1
        && let Some(pool) = pool(threads)
    {
        pool.install(|| jobs.into_par_iter().for_each(&run));
    } else {
        jobs.into_iter().for_each(run);
    }
}

/// How many threads [`spread`] takes for a number of them, which may be 0.
pub(crate) fn thread_count(threads: usize) -> usize {
    if threads > 0 { threads } else { pool(0).map_or(1, |pool| pool.current_num_threads()) }
}

/// The pool of so many threads, kept for next time; `None` where the machine gives no more threads.
///
/// A pool is one of this process: in a forked child its threads are gone, and who waits for them waits forever. That is why
/// rayon's own pool, of which there is one, is never used.
fn pool(threads: usize) -> Option<Arc<ThreadPool>> {
    static POOLS: Mutex<BTreeMap<(u32, usize), Arc<ThreadPool>>> = Mutex::new(BTreeMap::new());
    let pools = || POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    let key = (std::process::id(), threads);
    if let Some(pool) = pools().get(&key) {
        return Some(Arc::clone(pool));
    }
    // Built while the lock is free: one that is held during a fork stays held in the child.
    let pool = Arc::new(rayon::ThreadPoolBuilder::new().num_threads(threads).build().ok()?);
    Some(Arc::clone(pools().entry(key).or_insert(pool)))
}
