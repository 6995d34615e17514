//! The Allan variance of a phase, eq. (10) of the paper, with every overlapping pair of clusters or with disjoint ones.
//!
//! Starts are taken in fixed blocks, and every tau is done for a block while its points are in the cache. Partial sums
//! are added in the order of the blocks, whoever computed them: results do not depend on the number of threads.

use crate::compensated::Sum;
use crate::error::Error;
use crate::every_size;
use crate::kernel::{self, CHAIN, STARTS, Window};
use crate::phase::{BLOCK, Phase};
use crate::trend::Trend;
use rayon::prelude::*;

/// Which clusters are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Overlap {
    /// Every pair of adjacent clusters, one for each start.
    #[default]
    Full,
    /// Disjoint clusters: floor(N / m) of them, and one pair fewer.
    None,
}

/// How many terms a record of N rate samples has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Counting {
    /// N + 1 − 2m terms: all there are (NIST SP 1065, table 31).
    #[default]
    Standard,
    /// N − 2m terms, as eq. (6) of the paper reads: the last one is left out. Disjoint clusters are counted as in
    /// [`Counting::Standard`].
    Paper,
}

/// The Allan variance at one cluster size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Cluster size in samples (n of the paper).
    pub m: usize,
    /// Allan variance, in the unit of the rate squared.
    pub avar: f64,
    /// Number of squared differences averaged.
    pub pairs: usize,
    /// Mean of all the overlapping differences over m²: the change of the rate per sample, with its sign.
    pub ramp: f64,
}

/// Blocks of starts that make one task: the unit of parallel work, fixed by the record and not by the machine.
const BLOCKS_PER_TASK: usize = 64;

/// Cluster sizes whose ramps make one task.
const SIZES_PER_TASK: usize = 1024;

/// Terms a sample from which on all cluster sizes are done at once. Both ways cost so much there, about 0.3 µs a sample,
/// for a record of 10⁵ to 10⁷ samples.
const DENSE_TERMS: usize = 2000;

/// Allan variance of one phase at the cluster sizes `m`, in any order, repeated or not. Runs on the current rayon pool.
///
/// Very many overlapping sizes, such as all from 1 to N / 2, are done together, which changes the variances by less than
/// 1e-9 of them.
///
/// # Errors
///
/// [`Error::TooShort`] if the record leaves no cluster size, [`Error::ClusterSize`] for the first `m` without a pair.
pub fn allan_variance(
    phase: &Phase,
    m: &[usize],
    overlap: Overlap,
    counting: Counting,
) -> Result<Vec<Estimate>, Error> {
    check_sizes(phase.samples(), m, overlap, counting)?;
    let trend = Trend::new(phase);
    let mut estimates = match overlap {
        Overlap::Full if dense(phase.samples(), m) => of_every_size(phase, &trend, m, counting),
        Overlap::Full => overlapping(phase, m, counting),
        Overlap::None => m.par_iter().map(|&m| disjoint(phase, m)).collect(),
    };
    // Runs of consecutive sizes, as a record's every size has them, share their sums.
    estimates.par_chunks_mut(SIZES_PER_TASK).for_each(|chunk| {
        for run in chunk.chunk_by_mut(|one, next| one.m + 1 == next.m) {
            let ramps = trend.ramps(run[0].m..run[0].m + run.len());
            run.iter_mut().zip(ramps).for_each(|(estimate, ramp)| estimate.ramp = ramp);
        }
    });
    Ok(estimates)
}

/// Allan variances of several rate records, such as the axes of a unit; one result for each, in their order.
///
/// `threads` is the number of threads to work on; without it, the current rayon pool does. The results are the same
/// to the last bit.
///
/// # Errors
///
/// Those of [`Phase::from_rate`] and [`allan_variance`], for the first channel that has one, and [`Error::Parameter`]
/// if `threads` cannot be had.
pub fn allan_variances(
    channels: &[&[f64]],
    m: &[usize],
    overlap: Overlap,
    counting: Counting,
    threads: Option<usize>,
) -> Result<Vec<Vec<Estimate>>, Error> {
    for channel in channels {
        check_sizes(channel.len(), m, overlap, counting)?;
    }
    let of_all = || {
        let results: Vec<Result<_, Error>> = channels
            .par_iter()
            .map(|channel| allan_variance(&Phase::from_rate(channel)?, m, overlap, counting))
            .collect();
        results.into_iter().collect()
    };
    let Some(threads) = threads else {
        return of_all();
    };
    let out_of_range = Error::Parameter { name: "threads", value: threads as f64 };
    if threads == 0 {
        return Err(out_of_range);
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|_| out_of_range)?.install(of_all)
}

/// The largest cluster size that leaves one pair in a record of `samples`; 0 if there is none.
#[must_use]
pub fn largest_cluster(samples: usize, overlap: Overlap, counting: Counting) -> usize {
    match (overlap, counting) {
        (Overlap::Full, Counting::Paper) => samples.saturating_sub(1) / 2,
        _ => samples / 2,
    }
}

pub(crate) fn check_sizes(
    samples: usize,
    m: &[usize],
    overlap: Overlap,
    counting: Counting,
) -> Result<(), Error> {
    let largest = largest_cluster(samples, overlap, counting);
    if largest == 0 {
        let need = if (overlap, counting) == (Overlap::Full, Counting::Paper) { 3 } else { 2 };
        return Err(Error::TooShort { need, got: samples });
    }
    match m.iter().find(|&&m| m == 0 || m > largest) {
        Some(&m) => Err(Error::ClusterSize { m, largest }),
        None => Ok(()),
    }
}

/// Clusters k·m … (k + 1)·m − 1 against the next, for every whole cluster.
fn disjoint(phase: &Phase, m: usize) -> Estimate {
    let pairs = phase.samples() / m - 1;
    let mut sum = Sum::default();
    for pair in 0..pairs {
        let z = phase.second_difference(pair * m, m);
        sum.add(z * z);
    }
    estimate(m, pairs, sum.value())
}

fn estimate(m: usize, pairs: usize, sum_of_squares: f64) -> Estimate {
    let size = m as f64;
    let avar = sum_of_squares / (2.0 * size * size * pairs as f64);
    Estimate { m, avar, pairs, ramp: 0.0 }
}

/// Phase points in use: one fewer than there are when the last term is left out.
fn points_in_use(phase: &Phase, counting: Counting) -> usize {
    match counting {
        Counting::Standard => phase.samples() + 1,
        Counting::Paper => phase.samples(),
    }
}

/// Whether there are so many cluster sizes that doing all up to the largest, see [`every_size`], costs less than doing
/// them one by one.
fn dense(samples: usize, m: &[usize]) -> bool {
    let large = m.iter().filter(|&&m| m >= every_size::SMALLEST);
    let terms: usize = large.map(|m| samples + 1 - 2 * m).sum();
    terms > DENSE_TERMS * samples
}

/// All sizes by [`every_size`] but for those where it gives nothing, and the small ones.
fn of_every_size(phase: &Phase, trend: &Trend, m: &[usize], counting: Counting) -> Vec<Estimate> {
    let points = points_in_use(phase, counting);
    let largest = m.iter().copied().max().unwrap_or(0);
    let sums = every_size::sums_of_squares(phase, trend, points, largest);
    let sum_of = |m: usize| m.checked_sub(every_size::SMALLEST).and_then(|at| *sums.get(at)?);
    let one_by_one: Vec<usize> = m.iter().copied().filter(|&m| sum_of(m).is_none()).collect();
    let mut others = overlapping(phase, &one_by_one, counting).into_iter();
    m.iter()
        .filter_map(|&m| match sum_of(m) {
            Some(sum) => Some(estimate(m, points - 2 * m, sum)),
            None => others.next(),
        })
        .collect()
}

fn overlapping(phase: &Phase, m: &[usize], counting: Counting) -> Vec<Estimate> {
    let points = points_in_use(phase, counting);
    let mut sizes = m.to_vec();
    sizes.sort_unstable();
    sizes.dedup();
    let Some(&smallest) = sizes.first() else {
        return Vec::new();
    };
    let chains = chains(&sizes);
    let sums = Sums { phase, points, chains: &chains };

    let blocks = (points - 2 * smallest).div_ceil(STARTS);
    let tasks: Vec<Vec<Sum>> = (0..blocks.div_ceil(BLOCKS_PER_TASK))
        .into_par_iter()
        .map(|task| {
            let first = task * BLOCKS_PER_TASK;
            sums.over_blocks(first..(first + BLOCKS_PER_TASK).min(blocks))
        })
        .collect();
    let mut totals = vec![Sum::default(); sizes.len()];
    for task in tasks {
        for (total, sum) in totals.iter_mut().zip(task) {
            *total = total.plus(sum);
        }
    }

    // The order of the chains is not that of the sizes.
    let mut by_size: Vec<(usize, f64)> =
        chains.iter().flatten().copied().zip(totals.iter().map(|sum| sum.value())).collect();
    by_size.sort_unstable_by_key(|&(m, _)| m);
    m.iter()
        .filter_map(|&m| {
            let at = by_size.binary_search_by_key(&m, |&(size, _)| size).ok()?;
            // Halves were squared: four times the sum.
            Some(estimate(m, points - 2 * m, 4.0 * by_size[at].1))
        })
        .collect()
}

/// Groups sorted sizes into chains m, 2m, 4m … of at most [`CHAIN`]; a size without a neighbour is a chain of one.
fn chains(sizes: &[usize]) -> Vec<Vec<usize>> {
    let mut used = vec![false; sizes.len()];
    let mut chains = Vec::new();
    for start in 0..sizes.len() {
        if used[start] {
            continue;
        }
        let mut chain = vec![sizes[start]];
        let mut last = start;
        while chain.len() < CHAIN {
            let Ok(next) = sizes.binary_search(&(2 * sizes[last])) else { break };
            used[next] = true;
            chain.push(sizes[next]);
            last = next;
        }
        chains.push(chain);
    }
    chains
}

/// Sums of squared half differences, block by block.
struct Sums<'a> {
    phase: &'a Phase,
    /// Phase points in use: one fewer than there are when the last term is left out.
    points: usize,
    chains: &'a [Vec<usize>],
}

impl Sums<'_> {
    /// One sum for every size, in the order of the chains, over a run of blocks.
    fn over_blocks(&self, blocks: std::ops::Range<usize>) -> Vec<Sum> {
        let mut scratch = vec![[0.0; STARTS]; CHAIN + 1];
        let mut sums = vec![Sum::default(); self.chains.iter().map(Vec::len).sum()];
        for block in blocks {
            let mut at = 0;
            for chain in self.chains {
                self.add_block(block, chain, &mut sums[at..at + chain.len()], &mut scratch);
                at += chain.len();
            }
        }
        sums
    }

    fn add_block(&self, block: usize, chain: &[usize], sums: &mut [Sum], scratch: &mut [Window]) {
        let start = block * STARTS;
        // Sizes grow along a chain, so the sizes that use the whole block come first.
        let whole = chain.iter().take_while(|&&m| start + STARTS + 2 * m <= self.points).count();
        match whole {
            4 => self.add_whole::<4>(start, chain, sums, scratch),
            3 => self.add_whole::<3>(start, chain, sums, scratch),
            2 => self.add_whole::<2>(start, chain, sums, scratch),
            1 => self.add_whole::<1>(start, chain, sums, scratch),
            _ => {}
        }
        for (&m, sum) in chain.iter().zip(sums).skip(whole) {
            let starts = self.points.saturating_sub(start + 2 * m);
            if starts > 0 {
                sum.add(self.last_block(start, starts, m, scratch));
            }
        }
    }

    /// Adds a block that the first `T` sizes of a chain use whole.
    fn add_whole<const T: usize>(
        &self,
        start: usize,
        chain: &[usize],
        sums: &mut [Sum],
        scratch: &mut [Window],
    ) {
        let middle = start + chain[0];
        let last: [usize; T] = std::array::from_fn(|tau| start + 2 * chain[tau]);
        let correction = std::array::from_fn(|tau| self.correction(start, chain[tau]));
        for (&point, scratch) in std::iter::once(&middle).chain(&last).zip(scratch.iter_mut()) {
            if crosses_border(point) {
                self.rebase(point, scratch);
            }
        }
        let mut halves = [kernel::Lanes::default(); T];
        kernel::chain(
            self.window(start, &scratch[0]),
            self.window(middle, &scratch[0]),
            std::array::from_fn(|tau| self.window(last[tau], &scratch[tau + 1])),
            correction,
            &mut halves,
        );
        for (sum, half) in sums.iter_mut().zip(halves) {
            sum.add(kernel::add_lanes(half));
        }
    }

    /// Sum over the last block of a size, of which only some starts have all their points.
    fn last_block(&self, start: usize, starts: usize, m: usize, scratch: &mut [Window]) -> f64 {
        let (scratch_middle, scratch_last) = scratch.split_at_mut(1);
        let (scratch_middle, scratch_last) = (&mut scratch_middle[0], &mut scratch_last[0]);
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

    /// Half the second difference of the anchors that the three windows of a block refer to.
    fn correction(&self, start: usize, m: usize) -> f64 {
        0.5 * self.phase.anchor_difference(start / BLOCK, (start + m) / BLOCK, (start + 2 * m) / BLOCK)
    }

    /// The window at a point: the phase itself, or its rebased copy if the anchor changes within.
    fn window<'a>(&'a self, point: usize, rebased: &'a Window) -> &'a Window {
        if crosses_border(point) { rebased } else { self.plain_window(point) }
    }

    fn plain_window(&self, point: usize) -> &Window {
        self.phase.values[point..].first_chunk().expect("the caller counted the points of the window")
    }

    /// Copies a window that crosses the border of a block, all of it relative to the anchor of its first point.
    fn rebase(&self, point: usize, copy: &mut Window) {
        *copy = *self.plain_window(point);
        self.lift_beyond_border(point, copy);
    }

    fn lift_beyond_border(&self, point: usize, window: &mut [f64]) {
        let border = BLOCK - point % BLOCK;
        if border < window.len() {
            let step = self.phase.step_to(point / BLOCK + 1);
            for value in &mut window[border..] {
                *value += step;
            }
        }
    }
}

/// Whether the anchor changes within the window at a point.
fn crosses_border(point: usize) -> bool {
    point % BLOCK + STARTS > BLOCK
}

// Windows at the starts themselves never cross a border.
const _: () = assert!(BLOCK % STARTS == 0);

// `add_block` has an arm for every length of a chain.
const _: () = assert!(CHAIN == 4);
