//! Sums of squared second differences of a phase, for many cluster sizes at once.
//!
//! Starts are divided into fixed blocks, and all taus are computed for a block while its points are in the cache. Partial
//! sums are added in the order of the blocks, so that results do not depend on the number of threads.

use crate::compensated::Sum;
use crate::kernel::{self, Batch, MAX_TAUS, Path, STARTS, Window};
use crate::parallel::prelude::*;
use crate::phase::{Phase, SHORTEST_BLOCK};
use std::cell::RefCell;
use std::ops::Range;

/// Number of blocks of starts in a task, the unit of parallel work, which depends on the record and not on the machine.
const BLOCKS_PER_TASK: usize = 64;
/// The same for distant blocks, where a task begins by loading all windows of its first block.
const FAR_BLOCKS_PER_TASK: usize = 1024;

/// Number of points between the first and the last window of a start above which the windows count as distant: half a
/// cache, at 8 bytes each.
const DISTANT_POINTS: usize = 1 << 17;

/// Shortest chain: a shorter one saves too little over sizes that only share their starts.
const SHORTEST_CHAIN: usize = 3;

/// Cluster sizes, divided into batches that are computed together.
#[derive(Debug, Clone)]
pub(crate) struct Squares {
    sizes: Vec<usize>,
    batches: Vec<SizeBatch>,
}

impl Squares {
    /// Batches for sizes in any order, repeated or not.
    pub(crate) fn new(m: &[usize]) -> Self {
        let mut sizes = m.to_vec();
        sizes.sort_unstable();
        sizes.dedup();
        let batches = batches(&sizes);
        Self { sizes, batches }
    }

    /// The distinct sizes in increasing order.
    pub(crate) fn sizes(&self) -> &[usize] {
        &self.sizes
    }

    /// Sums of z² for each size, over the first `starts` starts, as far as the first `points` points of the phase reach.
    /// Runs on the current rayon pool.
    pub(crate) fn sums(&self, phase: &Phase, points: usize, starts: usize) -> Vec<Sum> {
        let blocks = Blocks { phase, points, starts, batches: &self.batches, path: Path::default() };
        let tasks = blocks.tasks();
        let sums: Vec<Vec<Sum>> = match &tasks[..] {
            // Too little work for another thread.
            [task] => vec![blocks.over(task)],
            tasks => tasks.par_iter().map(|task| blocks.over(task)).collect(),
        };
        let mut totals = vec![Sum::default(); self.sizes.len()];
        for (task, sums) in tasks.iter().zip(sums) {
            let before: usize =
                self.batches[..task.batches.start].iter().map(|batch| batch.sizes.len()).sum();
            for (total, sum) in totals[before..].iter_mut().zip(sums) {
                *total = total.plus(sum);
            }
        }
        // The batches are not in the order of the sizes. The squares are of half differences, hence the factor four.
        let in_order = self.batches.iter().flat_map(|batch| batch.sizes.iter().copied());
        let mut by_size: Vec<(usize, Sum)> = in_order.zip(totals).collect();
        by_size.sort_unstable_by_key(|&(m, _)| m);
        by_size.into_iter().map(|(_, sum)| sum.doubled().doubled()).collect()
    }
}

/// Sizes that are handled in one pass, increasing.
#[derive(Debug, Clone)]
struct SizeBatch {
    sizes: Vec<usize>,
    /// m, 2m, 4m …
    chained: bool,
}

impl SizeBatch {
    /// Length of the smallest cluster in blocks, if the blocks of a task are that far apart; None if they are
    /// consecutive.
    ///
    /// If a chain reaches farther than a cache, each window would be loaded from memory for each size. In steps of the
    /// smallest size, all windows of a block but one are also windows of the next block.
    fn stride(&self) -> Option<usize> {
        let (&smallest, &largest) = (self.sizes.first()?, self.sizes.last()?);
        let apart = 2 * largest > DISTANT_POINTS && self.chained && smallest % STARTS == 0;
        apart.then_some(smallest / STARTS)
    }
}

/// Consecutive blocks for some of the batches.
struct Task {
    batches: Range<usize>,
    first: usize,
    step: usize,
    count: usize,
}

/// Groups distinct sorted sizes: first chains, then the remaining sizes in order.
fn batches(sizes: &[usize]) -> Vec<SizeBatch> {
    let mut used = vec![false; sizes.len()];
    let mut batches = Vec::new();
    for start in 0..sizes.len() {
        if used[start] {
            continue;
        }
        let mut chain = vec![start];
        while let Ok(next) = sizes.binary_search(&(2 * sizes[chain[chain.len() - 1]])) {
            chain.push(next);
        }
        if chain.len() >= SHORTEST_CHAIN {
            for &at in &chain {
                used[at] = true;
            }
            let sizes: Vec<usize> = chain.iter().map(|&at| sizes[at]).collect();
            batches
                .extend(even_parts(&sizes).map(|sizes| SizeBatch { sizes: sizes.to_vec(), chained: true }));
        }
    }
    let left: Vec<usize> = sizes.iter().zip(used).filter(|(_, used)| !used).map(|(&m, _)| m).collect();
    batches.extend(even_parts(&left).map(|sizes| SizeBatch { sizes: sizes.to_vec(), chained: false }));
    batches.sort_by_key(|batch| batch.stride().is_some());
    batches
}

/// The smallest number of parts of at most [`MAX_TAUS`] sizes, with nearly equal lengths, because a short part has too
/// few sums to keep the processor busy.
fn even_parts(sizes: &[usize]) -> impl Iterator<Item = &[usize]> {
    let parts = sizes.len().div_ceil(MAX_TAUS);
    (0..parts).map(move |k| &sizes[k * sizes.len() / parts..(k + 1) * sizes.len() / parts])
}

/// Computes sums of squared half differences by block.
struct Blocks<'a> {
    phase: &'a Phase,
    /// Number of phase points in use.
    points: usize,
    /// Number of starts in use, as far as they have points.
    starts: usize,
    batches: &'a [SizeBatch],
    path: Path,
}

thread_local! {
    /// Buffers of this thread with any content, because new memory would take long compared with a task.
    static SCRATCH: RefCell<Vec<Window>> = const { RefCell::new(Vec::new()) };
}

/// Copies of windows across the border of a block, one for each of the 2·[`MAX_TAUS`] lags of a batch, relative to one
/// anchor each.
type Scratch = [Window];

impl Blocks<'_> {
    /// All tasks; batches with close windows share tasks.
    fn tasks(&self) -> Vec<Task> {
        let near =
            self.batches.iter().position(|batch| batch.stride().is_some()).unwrap_or(self.batches.len());
        let blocks = |batch: &SizeBatch| self.start_count(batch.sizes[0]).div_ceil(STARTS);
        let count = self.batches[..near].iter().map(blocks).max().unwrap_or(0);
        let mut tasks: Vec<Task> = (0..count)
            .step_by(BLOCKS_PER_TASK)
            .map(|first| Task { batches: 0..near, first, step: 1, count: BLOCKS_PER_TASK.min(count - first) })
            .collect();
        for (at, batch) in self.batches.iter().enumerate().skip(near) {
            let step = batch.stride().unwrap_or(1);
            for first in 0..step.min(blocks(batch)) {
                let count = (blocks(batch) - first).div_ceil(step);
                tasks.extend((0..count).step_by(FAR_BLOCKS_PER_TASK).map(|from| Task {
                    batches: at..at + 1,
                    first: first + from * step,
                    step,
                    count: FAR_BLOCKS_PER_TASK.min(count - from),
                }));
            }
        }
        tasks
    }

    /// One sum per size of a task, in the order of its batches.
    fn over(&self, task: &Task) -> Vec<Sum> {
        SCRATCH.with_borrow_mut(|scratch| {
            scratch.resize(2 * MAX_TAUS, [0.0; STARTS]);
            self.over_in(task, scratch)
        })
    }

    /// [`Blocks::over`] with given buffers.
    fn over_in(&self, task: &Task, scratch: &mut Scratch) -> Vec<Sum> {
        let batches = &self.batches[task.batches.clone()];
        let mut sums = vec![Sum::default(); batches.iter().map(|batch| batch.sizes.len()).sum()];
        let mut at = 0;
        for batch in batches {
            let sums = &mut sums[at..at + batch.sizes.len()];
            for block in 0..task.count {
                let at = task.first + block * task.step;
                self.add_block(at, at + task.step, batch, sums, scratch);
            }
            at += batch.sizes.len();
        }
        sums
    }

    /// Number of starts of one size that have all their points.
    fn start_count(&self, m: usize) -> usize {
        self.points.saturating_sub(2 * m).min(self.starts)
    }

    fn add_block(
        &self,
        block: usize,
        next: usize,
        batch: &SizeBatch,
        sums: &mut [Sum],
        scratch: &mut Scratch,
    ) {
        let (start, next) = (block * STARTS, next * STARTS);
        // Sizes grow along a batch, so the sizes for which the whole block has points come first.
        let whole = batch.sizes.iter().take_while(|&&m| start + STARTS <= self.start_count(m)).count();
        match whole {
            6 => self.add_whole::<6>(start, next, batch, sums, scratch),
            5 => self.add_whole::<5>(start, next, batch, sums, scratch),
            4 => self.add_whole::<4>(start, next, batch, sums, scratch),
            3 => self.add_whole::<3>(start, next, batch, sums, scratch),
            2 => self.add_whole::<2>(start, next, batch, sums, scratch),
            1 => self.add_whole::<1>(start, next, batch, sums, scratch),
            _ => {}
        }
        for (&m, sum) in batch.sizes.iter().zip(sums).skip(whole) {
            let starts = self.start_count(m).saturating_sub(start).min(STARTS);
            if starts > 0 {
                sum.add(self.last_block(start, starts, m, scratch));
            }
        }
    }

    /// Adds a block for the first `T` sizes of a batch, for which all its starts have their points.
    fn add_whole<const T: usize>(
        &self,
        start: usize,
        next: usize,
        batch: &SizeBatch,
        sums: &mut [Sum],
        scratch: &mut Scratch,
    ) {
        let size = |tau: usize| batch.sizes[tau];
        let (middles, lasts) = scratch.split_at_mut(MAX_TAUS);
        for tau in 0..T {
            if tau == 0 || !batch.chained {
                self.rebase(start + size(tau), &mut middles[tau]);
            }
            self.rebase(start + 2 * size(tau), &mut lasts[tau]);
        }
        let middle = |tau: usize| {
            let copy = if batch.chained && tau > 0 { &lasts[tau - 1] } else { &middles[tau] };
            self.window(start + size(tau), copy)
        };
        let mut halves = [kernel::Lanes::default(); T];
        let first = self.plain_window(start);
        let windows = Batch {
            first,
            middle: std::array::from_fn(middle),
            last: std::array::from_fn(|tau| self.window(start + 2 * size(tau), &lasts[tau])),
            correction: std::array::from_fn(|tau| self.correction(start, size(tau))),
            chained: batch.chained,
            ahead: self
                .phase
                .values
                .get(next + 2 * size(T - 1)..)
                .and_then(<[f64]>::first_chunk)
                .unwrap_or(first),
        };
        windows.add_to(&mut halves, self.path);
        for (sum, half) in sums.iter_mut().zip(halves) {
            sum.add(kernel::add_lanes(half));
        }
    }

    /// Sum over the last block of a size, in which only some starts have all their points.
    fn last_block(&self, start: usize, starts: usize, m: usize, scratch: &mut Scratch) -> f64 {
        let (middles, lasts) = scratch.split_at_mut(1);
        let (scratch_middle, scratch_last) = (&mut middles[0], &mut lasts[0]);
        let copy = |point: usize, scratch: &mut Window| {
            scratch[..starts].copy_from_slice(&self.phase.values[point..point + starts]);
            self.lift_beyond_border(point, &mut scratch[..starts]);
        };
        copy(start + m, scratch_middle);
        copy(start + 2 * m, scratch_last);
        kernel::partial(
            &self.phase.values[start..start + starts],
            &scratch_middle[..starts],
            &scratch_last[..starts],
            self.correction(start, m),
        )
    }

    /// Half the second difference of the anchors of the three windows of a block.
    fn correction(&self, start: usize, m: usize) -> f64 {
        let block = |point: usize| self.phase.block_of(point);
        0.5 * self.phase.anchor_difference(block(start), block(start + m), block(start + 2 * m))
    }

    /// The window at a point: the phase itself, or its rebased copy if the anchor changes within the window.
    fn window<'a>(&'a self, point: usize, rebased: &'a Window) -> &'a Window {
        if self.crosses_border(point) { rebased } else { self.plain_window(point) }
    }

    /// Whether the anchor changes within the window at a point.
    fn crosses_border(&self, point: usize) -> bool {
        self.phase.offset_of(point) + STARTS > self.phase.block
    }

    fn plain_window(&self, point: usize) -> &Window {
        self.phase.values[point..].first_chunk().expect("the caller counted the points of the window")
    }

    /// Copies a window that crosses the border of a block, all of it relative to the anchor of its first point.
    fn rebase(&self, point: usize, copy: &mut Window) {
        if self.crosses_border(point) {
            *copy = *self.plain_window(point);
            self.lift_beyond_border(point, copy);
        }
    }

    fn lift_beyond_border(&self, point: usize, window: &mut [f64]) {
        let border = self.phase.block - self.phase.offset_of(point);
        if border < window.len() {
            let step = self.phase.step_to(self.phase.block_of(point) + 1);
            for value in &mut window[border..] {
                *value += step;
            }
        }
    }
}

// Windows at the starts themselves never cross a border.
const _: () = assert!(SHORTEST_BLOCK % STARTS == 0);

// `add_block` has an arm for every length of a batch.
const _: () = assert!(MAX_TAUS == 6);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::phase::LONGEST_BLOCK;

    #[test]
    fn sizes_are_batched_once_each() {
        let octaves: Vec<usize> = (0..20).map(|j| 1 << j).collect();
        let odd = [1, 2, 3, 4, 5, 6, 7, 8, 9, 16, 17, 100, 101, 202, 404, 50_000];
        for sizes in [&octaves[..], &odd[..], &[7][..], &[][..]] {
            let batches = batches(sizes);
            let mut all: Vec<usize> = batches.iter().flat_map(|batch| batch.sizes.iter().copied()).collect();
            all.sort_unstable();
            assert_eq!(all, sizes);
            for SizeBatch { sizes, chained } in batches {
                assert!(sizes.len() <= MAX_TAUS);
                assert!(
                    sizes.windows(2).all(|pair| pair[0] < pair[1] && (!chained || 2 * pair[0] == pair[1]))
                );
            }
        }
        let lengths: Vec<usize> = batches(&octaves).iter().map(|batch| batch.sizes.len()).collect();
        assert_eq!(lengths, [5; 4]);
        assert!(batches(&octaves).iter().all(|batch| batch.chained));
    }

    /// A record with an offset, a drift and noise, long enough that windows cross the borders of blocks.
    fn record() -> Vec<f64> {
        let mut state = 1u64;
        let mut noise = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..5 * LONGEST_BLOCK + 321).map(|k| 1e3 + 1e-4 * k as f64 + noise()).collect()
    }

    #[test]
    fn every_path_gives_the_same_to_rounding() {
        let phase = Phase::from_rate(&record()).unwrap();
        let points = phase.samples() + 1;
        let sizes: Vec<usize> =
            vec![1, 2, 3, 4, 5, 6, 7, 8, 9, 11, 16, 32, 1000, 1024, 2048, 4096, 8192, 40_000];
        let batches = batches(&sizes);
        let sums = |path| {
            let blocks = Blocks { phase: &phase, points, starts: usize::MAX, batches: &batches, path };
            blocks.over(&Task {
                batches: 0..batches.len(),
                first: 0,
                step: 1,
                count: (points - 2).div_ceil(STARTS),
            })
        };
        for (fast, portable) in sums(Path::Fastest).iter().zip(sums(Path::Portable)) {
            let difference = fast.value() / portable.value() - 1.0;
            // Thousands of squares are added in the same order; fused products have one rounding fewer.
            assert!(difference.abs() <= 1e-13, "{difference:e}");
        }
    }
}
