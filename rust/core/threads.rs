//! Work spread over threads.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use rayon::ThreadPool;
use rayon::prelude::*;

/// Runs every job once, on this many threads; 0 is rayon's own number (`RAYON_NUM_THREADS`, or as many as there are cores).
///
/// One job, or one thread, is a plain loop here: no other thread is woken for it.
pub(crate) fn spread<J: Send>(threads: usize, jobs: Vec<J>, run: impl Fn(J) + Sync) {
    if threads == 1 || jobs.len() <= 1 {
        jobs.into_iter().for_each(run);
        return;
    }
    let all = || jobs.into_par_iter().for_each(&run);
    match pool(threads) {
        Some(pool) => pool.install(all),
        None => all(),
    }
}

/// The pool of so many threads, kept for next time; `None` for rayon's own, or where the machine gives no more threads.
fn pool(threads: usize) -> Option<Arc<ThreadPool>> {
    static POOLS: Mutex<Option<HashMap<usize, Arc<ThreadPool>>>> = Mutex::new(None);
    if threads == 0 {
        return None;
    }
    let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    let pools = pools.get_or_insert_default();
    if let Some(pool) = pools.get(&threads) {
        return Some(Arc::clone(pool));
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().ok()?;
    Some(Arc::clone(pools.entry(threads).or_insert(Arc::new(pool))))
}
