//! Progress of the readers of this process, for a display.

use std::io::{self, Read};
use std::sync::atomic::{AtomicU64, Ordering};

static BYTES: AtomicU64 = AtomicU64::new(0);

/// Number of bytes that all readers have read since the process began.
#[must_use]
pub fn bytes_read() -> u64 {
    BYTES.load(Ordering::Relaxed)
}

pub(crate) fn count(bytes: usize) {
    BYTES.fetch_add(bytes as u64, Ordering::Relaxed);
}

/// A reader whose bytes are counted.
pub(crate) struct Counted<R>(pub(crate) R);

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let got = self.0.read(out)?;
        count(got);
        Ok(got)
    }
}
