//! Work spread over threads.

use std::sync::{Arc, Mutex, PoisonError};

use rayon::ThreadPool;
use rayon::prelude::*;

/// Runs every job once, on this many threads; 0 is rayon's own number (`RAYON_NUM_THREADS`, or the number of cores).
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

/// The number of threads that [`spread`] uses for a given number, which may be 0.
pub(crate) fn thread_count(threads: usize) -> usize {
    if threads > 0 { threads } else { pool(0).map_or(1, |pool| pool.current_num_threads()) }
}

/// Pools that are kept: a caller seldom asks for more than a few numbers of threads in turn.
const KEPT: usize = 4;

/// A pool, and its owner: a process and a number of threads.
type OwnedPool = ((u32, usize), Arc<ThreadPool>);

/// The pool of this many threads, kept for next time; `None` if the machine gives no more threads.
///
/// A pool belongs to one process: in a forked child its threads are gone, and waiting for them never ends. That is why
/// rayon's own pool, of which there is one, is never used, and why a child never drops a pool of its parent.
fn pool(threads: usize) -> Option<Arc<ThreadPool>> {
    // Those used last come last.
    static POOLS: Mutex<Vec<OwnedPool>> = Mutex::new(Vec::new());
    let pools = || POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    let key = (std::process::id(), threads);
    let kept = |pools: &mut Vec<OwnedPool>| {
        let at = pools.iter().position(|(owner, _)| *owner == key)?;
        pools[at..].rotate_left(1);
        pools.last().map(|(_, pool)| Arc::clone(pool))
    };
    if let Some(pool) = kept(&mut pools()) {
        return Some(pool);
    }
    // Built, and others dropped, while the lock is free: one that is held during a fork stays held in the child.
    let pool = Arc::new(rayon::ThreadPoolBuilder::new().num_threads(threads).build().ok()?);
    let mut pools = pools();
    if let Some(pool) = kept(&mut pools) {
        return Some(pool);
    }
    pools.push((key, Arc::clone(&pool)));
    let mine = |((process, _), _): &OwnedPool| *process == key.0;
    let oldest = (pools.iter().filter(|pool| mine(pool)).count() > KEPT).then(|| pools.iter().position(mine)).flatten();
    let dropped = oldest.map(|at| pools.remove(at));
    drop(pools);
    drop(dropped);
    Some(pool)
}
