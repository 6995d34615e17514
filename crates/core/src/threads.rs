//! Number of threads.

use crate::error::Error;

/// Larger than the number of threads of any machine.
const MAX_THREADS: usize = 1024;

/// Memory of a thread. \[bytes\]
const STACK: usize = 1 << 21;

/// Runs on a pool with a number of threads; without a number, on the current pool.
///
/// # Errors
///
/// [`Error::Parameter`] for an impossible number, [`Error::Memory`] if the threads cannot be created.
pub(crate) fn on_threads<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> T + Send,
) -> Result<T, Error> {
    let Some(threads) = threads else {
        return Ok(work());
    };
    let out_of_range = Error::Parameter { name: "threads", value: threads as f64 };
    if threads == 0 {
        return Err(out_of_range);
    }
    // Threads need memory for their stacks.
    let refused = if threads > MAX_THREADS { out_of_range } else { Error::Memory { bytes: threads * STACK } };
    #[cfg(feature = "threads")]
    return Ok(rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|_| refused)?
        .install(work));
    #[cfg(not(feature = "threads"))]
    if threads > MAX_THREADS { Err(refused) } else { Ok(work()) }
}
