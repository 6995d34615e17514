//! How many threads work.

use crate::error::Error;

/// Runs on a pool of so many threads; without a number, on the current one.
///
/// # Errors
///
/// [`Error::Parameter`] if so many cannot be had.
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
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    Ok(pool.map_err(|_| out_of_range)?.install(work))
}
