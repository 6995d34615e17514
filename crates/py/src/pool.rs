//! Threads that are there: a process that was forked has a copy of the pool of its parent, and none of its threads.

use pyo3::prelude::*;
use std::sync::OnceLock;

/// Process that the pool was first used in.
static OWNER: OnceLock<u32> = OnceLock::new();

/// Runs without the interpreter's lock, on a pool whose threads live.
pub fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> T {
    let this = std::process::id();
    py.detach(|| {
        if *OWNER.get_or_init(|| this) == this {
            return work();
        }
        match rayon::ThreadPoolBuilder::new().build() {
            Ok(pool) => pool.install(work),
            // No thread can be had: a pool of this one alone needs none, and where even that fails, so will the work.
            Err(_) => work(),
        }
    })
}
