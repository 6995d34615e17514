//! The interface to rayon: with the feature `threads` its iterators, without it the same calls on one thread.

#[cfg(feature = "threads")]
pub(crate) use rayon::{current_num_threads, join};
#[cfg(not(feature = "threads"))]
pub(crate) use serial::{current_num_threads, join};

/// The traits of parallel iterators.
pub(crate) mod prelude {
    #[cfg(not(feature = "threads"))]
    pub(crate) use super::serial::{Items, Pieces, Serial};
    #[cfg(feature = "threads")]
    pub(crate) use rayon::prelude::*;
}

#[cfg(not(feature = "threads"))]
mod serial {
    use std::slice;

    /// Number of threads.
    pub(crate) fn current_num_threads() -> usize {
        1
    }

    /// Calls both functions in turn.
    pub(crate) fn join<A, B>(first: impl FnOnce() -> A, second: impl FnOnce() -> B) -> (A, B) {
        (first(), second())
    }

    /// Slices with rayon's methods.
    pub(crate) trait Pieces<T> {
        fn par_iter(&self) -> slice::Iter<'_, T>;
        fn par_chunks(&self, length: usize) -> slice::Chunks<'_, T>;
        fn par_chunks_mut(&mut self, length: usize) -> slice::ChunksMut<'_, T>;
    }

    impl<T> Pieces<T> for [T] {
        fn par_iter(&self) -> slice::Iter<'_, T> {
            self.iter()
        }

        fn par_chunks(&self, length: usize) -> slice::Chunks<'_, T> {
            self.chunks(length)
        }

        fn par_chunks_mut(&mut self, length: usize) -> slice::ChunksMut<'_, T> {
            self.chunks_mut(length)
        }
    }

    /// Types that become an iterator.
    pub(crate) trait Items: IntoIterator + Sized {
        fn into_par_iter(self) -> Self::IntoIter {
            self.into_iter()
        }
    }

    impl<I: IntoIterator> Items for I {}

    /// Methods that only rayon's iterators have.
    pub(crate) trait Serial: Iterator + Sized {
        fn with_max_len(self, _: usize) -> Self {
            self
        }

        fn flat_map_iter<I: IntoIterator>(
            self,
            of: impl FnMut(Self::Item) -> I,
        ) -> impl Iterator<Item = I::Item> {
            self.flat_map(of)
        }
    }

    impl<I: Iterator> Serial for I {}
}
