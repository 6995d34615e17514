//! The Allan variance of a phase, eq. (10) of the paper, with every overlapping pair of clusters or with disjoint ones.

use crate::compensated::Sum;
use crate::error::Error;
use crate::every_size;
use crate::parallel::{current_num_threads, prelude::*};
use crate::phase::Phase;
use crate::squares::Squares;
use crate::threads::on_threads;
use crate::trend::Trend;

/// Which clusters are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Overlap {
    /// Every pair of adjacent clusters, one for each start.
    #[default]
    Full,
    /// Disjoint clusters: floor(N / m) of them, and one pair fewer.
    None,
}

/// Number of terms for a record of N rate samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Counting {
    /// N + 1 − 2m terms, all that exist (NIST SP 1065, table 31).
    #[default]
    Standard,
    /// N − 2m terms, as in eq. (6) of the paper: the last term is left out. Disjoint clusters are counted as
    /// in [`Counting::Standard`].
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
    /// Mean of all overlapping differences over m²: the signed change of the rate per sample.
    pub ramp: f64,
}

/// Number of cluster sizes whose ramps make one task.
const SIZES_PER_TASK: usize = 1024;

/// Number of terms per sample above which all cluster sizes are computed at once. At this number both methods
/// take about 0.3 µs per sample, for records of 10⁵ to 10⁷ samples.
const DENSE_TERMS: usize = 2000;

/// Allan variance of one phase at the cluster sizes `m`, in any order, repeated or not. Runs on the current rayon pool.
///
/// Very many overlapping sizes, such as all from 1 to N / 2, are computed together, with relative errors
/// below 1e-9.
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
        Overlap::Full if dense(phase.samples(), m) => by_every_size(phase, &trend, m, counting),
        Overlap::Full => overlapping(phase, m, counting),
        Overlap::None => m.par_iter().map(|&m| disjoint(phase, m)).collect(),
    };
    // Consecutive sizes share their sums.
    estimates.par_chunks_mut(SIZES_PER_TASK).for_each(|chunk| {
        for run in chunk.chunk_by_mut(|one, next| one.m + 1 == next.m) {
            let ramps = trend.ramps(run[0].m..run[0].m + run.len());
            run.iter_mut().zip(ramps).for_each(|(estimate, ramp)| estimate.ramp = ramp);
        }
    });
    Ok(estimates)
}

/// Allan variances of several rate records, such as the axes of a unit; one result per record, in the same
/// order.
///
/// `threads` is the number of threads; without it, the current rayon pool is used. The results are the same to the last bit.
///
/// # Errors
///
/// Those of [`Phase::from_rate`] and [`allan_variance`], for the first channel that has one, and [`Error::Parameter`]
/// if a pool of `threads` threads cannot be started.
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
    let all_channels = || {
        // Each share of the channels reuses the memory of one phase.
        let share = channels.len().div_ceil(current_num_threads()).max(1);
        let in_one_phase = |channels: &[&[f64]]| -> Vec<Result<_, Error>> {
            let mut phase = Phase::reused();
            let one_channel = |channel: &&[f64]| {
                phase.refill(channel)?;
                allan_variance(&phase, m, overlap, counting)
            };
            let results = channels.iter().map(one_channel).collect();
            phase.leave();
            results
        };
        let results: Vec<_> = channels.par_chunks(share).map(in_one_phase).collect();
        results.into_iter().flatten().collect()
    };
    on_threads(threads, all_channels)?
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

/// Squared differences of each whole cluster, k·m … (k + 1)·m − 1, from the next one.
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

/// Number of phase points in use: all of them, or all but one if the last term is left out.
fn points_in_use(phase: &Phase, counting: Counting) -> usize {
    match counting {
        Counting::Standard => phase.samples() + 1,
        Counting::Paper => phase.samples(),
    }
}

/// Whether there are so many cluster sizes that computing all up to the largest, see [`every_size`], costs less than
/// computing them one by one.
fn dense(samples: usize, m: &[usize]) -> bool {
    let large = m.iter().filter(|&&m| m >= every_size::SMALLEST);
    let terms: usize = large.map(|m| samples + 1 - 2 * m).sum();
    terms > DENSE_TERMS * samples
}

/// Computes the sizes by [`every_size`]; small sizes, and those for which it returns nothing, are summed
/// directly.
fn by_every_size(phase: &Phase, trend: &Trend, m: &[usize], counting: Counting) -> Vec<Estimate> {
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
    let squares = Squares::new(m);
    let sums = squares.sums(phase, points, usize::MAX);
    m.iter()
        .filter_map(|m| {
            let at = squares.sizes().binary_search(m).ok()?;
            Some(estimate(*m, points - 2 * m, sums[at].value()))
        })
        .collect()
}
