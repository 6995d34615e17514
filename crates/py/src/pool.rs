//! A thread pool that survives a fork: a forked process has a copy of its parent's pool, but none of its threads.

use pyo3::prelude::*;
use std::sync::OnceLock;

/// Number of the process that first used the pool.
static OWNER: OnceLock<u32> = OnceLock::new();

/// Runs `work` without the interpreter's lock, on a pool with running threads.
pub fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> T {
    let this = std::process::id();
    py.detach(|| {
        if *OWNER.get_or_init(|| this) == this {
            return work();
        }
        match rayon::ThreadPoolBuilder::new().build() {
            Ok(pool) => pool.install(work),
            // If no thread can be started, `work` succeeds only on a pool of the current thread alone.
            Err(_) => work(),
        }
    })
}
