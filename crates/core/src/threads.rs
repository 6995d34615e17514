//! How many threads work.

use crate::error::Error;

/// More threads than a machine has.
const MOST: usize = 1024;

/// Memory of a thread. \[bytes\]
const STACK: usize = 1 << 21;

/// Runs on a pool of so many threads; without a number, on the current one.
///
/// # Errors
///
/// [`Error::Parameter`] for a number that no machine has, [`Error::Memory`] if they cannot be had.
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
    let refused = if threads > MOST { out_of_range } else { Error::Memory { bytes: threads * STACK } };
    #[cfg(feature = "threads")]
    return Ok(rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|_| refused)?
        .install(work));
    #[cfg(not(feature = "threads"))]
    if threads > MOST { Err(refused) } else { Ok(work()) }
}
