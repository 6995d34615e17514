//! Memory for points: aligned to cache lines, and in large pages if it is large.
//!
//! A vector across two cache lines costs two loads. A window in small pages costs a page-table walk for each page, and new
//! pages cost a page fault each.

use crate::error::Error;
#[cfg(feature = "threads")]
use memmap2::MmapMut;
use std::fmt;
use std::ops::{Deref, DerefMut};

/// Number of floats in a cache line.
const LINE: usize = 8;

/// Number of floats in a large page of most processors.
#[cfg(any(test, feature = "threads"))]
const LARGE_PAGE: usize = (1 << 21) / size_of::<f64>();

/// Number of floats above which large pages are requested.
#[cfg(any(test, feature = "threads"))]
const WORTH_PAGES: usize = 2 * LARGE_PAGE;

/// Floats, the first of them at the beginning of a cache line.
#[derive(Default)]
pub(crate) struct Points {
    memory: Memory,
    /// Position of the first float.
    start: usize,
    count: usize,
}

enum Memory {
    Heap(Vec<f64>),
    #[cfg(feature = "threads")]
    Pages(MmapMut),
}

impl Points {
    /// A single float, 0.
    pub(crate) fn zero() -> Self {
        let mut points = Self::default();
        points.push(0.0);
        points
    }

    /// Changes the number of floats, whose values are then undefined.
    ///
    /// # Errors
    ///
    /// [`Error::Memory`].
    pub(crate) fn resize(&mut self, count: usize) -> Result<(), Error> {
        if self.capacity() < count || matches!(self.memory, Memory::Heap(_)) {
            self.memory = Memory::of(count, std::mem::take(&mut self.memory))?;
            // It only affects the time of a load.
            let line = self.memory.line();
            self.start = self.memory.numbers().as_ptr().align_offset(line * size_of::<f64>()).min(line - 1);
        }
        self.count = count;
        Ok(())
    }

    /// Memory for `count` floats; ends the program if there is no memory, as any vector does.
    fn of(count: usize) -> Self {
        let mut points = Self::default();
        if points.resize(count).is_err() {
            points = Self { memory: Memory::Heap(vec![0.0; count]), start: 0, count };
        }
        points
    }

    /// Appends a float.
    pub(crate) fn push(&mut self, value: f64) {
        if self.count == self.capacity() {
            let mut more = Self::of(self.count + 1);
            more[..self.count].copy_from_slice(self);
            *self = more;
        } else {
            self.count += 1;
        }
        let last = self.count - 1;
        self[last] = value;
    }

    /// Number of floats for which there is memory.
    pub(crate) fn capacity(&self) -> usize {
        self.memory.numbers().len() - self.start
    }
}

impl Memory {
    /// Memory for `count` + 1 floats at any alignment; reuses `before` if possible.
    fn of(count: usize, before: Self) -> Result<Self, Error> {
        #[cfg(feature = "threads")]
        if count >= WORTH_PAGES {
            let bytes = (count + 1 + LARGE_PAGE) * size_of::<f64>();
            let pages = MmapMut::map_anon(bytes).map_err(|_| Error::Memory { bytes })?;
            // A system without large pages uses small ones.
            #[cfg(target_os = "linux")]
            let _ = pages.advise(memmap2::Advice::HugePage);
            return Ok(Self::Pages(pages));
        }
        let mut numbers = match before {
            Self::Heap(numbers) => numbers,
            #[cfg(feature = "threads")]
            Self::Pages(_) => Vec::new(),
        };
        let size = count + 1 + LINE;
        let more = size.saturating_sub(numbers.len());
        numbers.try_reserve(more).map_err(|_| Error::Memory { bytes: more * size_of::<f64>() })?;
        numbers.resize(size, 0.0);
        Ok(Self::Heap(numbers))
    }

    /// Number of floats to a multiple of which the first one is aligned; the memory has room for as many more.
    fn line(&self) -> usize {
        match self {
            Self::Heap(_) => LINE,
            #[cfg(feature = "threads")]
            Self::Pages(_) => LARGE_PAGE,
        }
    }

    fn numbers(&self) -> &[f64] {
        match self {
            Self::Heap(numbers) => numbers,
            #[cfg(feature = "threads")]
            Self::Pages(pages) => bytemuck::cast_slice(pages),
        }
    }

    fn numbers_mut(&mut self) -> &mut [f64] {
        match self {
            Self::Heap(numbers) => numbers,
            #[cfg(feature = "threads")]
            Self::Pages(pages) => bytemuck::cast_slice_mut(pages),
        }
    }
}

impl Default for Memory {
    fn default() -> Self {
        Self::Heap(Vec::new())
    }
}

impl Clone for Points {
    fn clone(&self) -> Self {
        let mut copy = Self::of(self.count);
        copy.copy_from_slice(self);
        copy
    }
}

impl fmt::Debug for Points {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&self[..], formatter)
    }
}

impl Deref for Points {
    type Target = [f64];

    #[inline]
    fn deref(&self) -> &[f64] {
        &self.memory.numbers()[self.start..self.start + self.count]
    }
}

impl DerefMut for Points {
    #[inline]
    fn deref_mut(&mut self) -> &mut [f64] {
        &mut self.memory.numbers_mut()[self.start..self.start + self.count]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_begin_with_a_line() {
        let mut points = Points::default();
        assert!(points.is_empty());
        for count in [0, 1, 7, 8, 9, 1000, WORTH_PAGES - 1, WORTH_PAGES, 5, 3 * WORTH_PAGES, 3] {
            points.resize(count).unwrap();
            assert_eq!(points.len(), count);
            assert!(points.capacity() > count);
            assert_eq!(points.as_ptr() as usize % 64, 0);
            points.fill(1.0);
        }
        points.push(2.0);
        assert_eq!(points[..], [1.0, 1.0, 1.0, 2.0]);
        assert_eq!(points.clone()[..], points[..]);
    }

    #[test]
    fn there_may_be_no_memory() {
        let mut points = Points::default();
        assert!(matches!(points.resize(1 << 58), Err(Error::Memory { .. })));
    }

    #[test]
    fn points_are_added_beyond_their_memory() {
        let mut points = Points::default();
        for k in 0..1000 {
            points.push(f64::from(k));
        }
        assert_eq!(points[..], (0..1000).map(f64::from).collect::<Vec<f64>>());
    }
}
