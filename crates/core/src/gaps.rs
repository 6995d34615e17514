//! The Allan variance of a record with missing samples, from clusters that are at least half full.
//!
//! A cluster of n samples is averaged over its m present samples, and a pair of neighbouring clusters counts
//! if both are at least half full: z = S₂/m₂ − S₁/m₁, AVAR(n) = ½ mean z². Samples keep their place in time,
//! and none is interpolated.

mod few;
mod sums;

use crate::allan::{Counting, Estimate, Overlap, check_sizes};
use crate::compensated::Sum;
use crate::error::Error;
use crate::parallel::prelude::*;
use crate::phase::LARGEST_RATE;
use crate::threads::on_threads;
use sums::{BLOCK, Block, mean_of};

/// If fewer than one in this number of samples is missing, most neighbouring starts lack the same samples and
/// are summed together.
const RARE_LOSSES: usize = 64;

/// Number of sizes that one thread handles together.
const SIZES_TOGETHER: usize = 16;

/// Running sums over the present samples before a point.
#[derive(Clone, Copy, Default)]
struct Point {
    /// Sum of the samples minus their mean, in two parts, because a single float would lose digits for a
    /// drifting rate.
    high: f64,
    low: f64,
    /// Number of present samples.
    count: f64,
    /// Sum of their indices: integers, exact up to records of 10⁸ samples.
    index: f64,
}

/// Allan variance of one rate record whose missing samples are NaN, at the cluster sizes `m`, in any order.
///
/// The ramp of an [`Estimate`] is Σ z·d / Σ d², with d the distance of the mean times of the two clusters.
/// This is the least-squares slope of the pairs, and the mean of z/n if no sample is missing. A size without
/// a pair has `pairs` 0 and NaN.
///
/// Runs on the current rayon pool, or on a pool of `threads` threads; the results are the same to the last bit.
///
/// # Errors
///
/// [`Error::NonFinite`] for a sample that is infinite or exceeds [`LARGEST_RATE`]; those of
/// [`crate::allan::allan_variance`].
pub fn allan_variance(
    rate: &[f64],
    m: &[usize],
    overlap: Overlap,
    counting: Counting,
    threads: Option<usize>,
) -> Result<Vec<Estimate>, Error> {
    check_sizes(rate.len(), m, overlap, counting)?;
    if let Some(index) = rate.iter().position(|y| !(y.is_nan() || y.abs() <= LARGEST_RATE)) {
        return Err(Error::NonFinite { index });
    }
    let used = match (overlap, counting) {
        (Overlap::Full, Counting::Paper) => rate.len() - 1,
        _ => rate.len(),
    };
    let step = |m: usize| if overlap == Overlap::Full { 1 } else { m };
    let missing: Vec<usize> = (0..rate.len()).filter(|&k| rate[k].is_nan()).collect();
    if missing.len() < rate.len() / RARE_LOSSES {
        let points = few::Points::of(rate, missing);
        let some = |sizes: &[usize]| points.estimates(used, sizes, step);
        return on_threads(threads, || m.par_chunks(SIZES_TOGETHER).flat_map_iter(some).collect());
    }
    let points = running_sums(rate);
    on_threads(threads, || m.par_iter().map(|&m| estimate(&points[..=used], m, step(m))).collect())
}

fn running_sums(rate: &[f64]) -> Vec<Point> {
    // The variance does not depend on a constant, but the rounding does.
    let mean = mean_of(rate);
    let mut points = Vec::with_capacity(rate.len() + 1);
    let mut sum = Sum::default();
    let mut point = Point::default();
    points.push(point);
    for (k, &y) in rate.iter().enumerate() {
        if !y.is_nan() {
            sum.add(y - mean);
            point =
                Point { high: sum.hi, low: sum.lo, count: point.count + 1.0, index: point.index + k as f64 };
        }
        points.push(point);
    }
    points
}

/// Averages over the pairs of clusters of `m` samples that begin at every `step`-th sample.
fn estimate(points: &[Point], m: usize, step: usize) -> Estimate {
    let starts = points.len() - 2 * m;
    let mut pairs = 0.0;
    let (mut squares, mut products, mut distances) = (Sum::default(), Sum::default(), Sum::default());
    for first in (0..starts).step_by(BLOCK * step) {
        let last = starts.min(first + BLOCK * step);
        let block = block_of(points, m, step, first, last);
        pairs += block.pairs;
        squares.add(block.squares);
        products.add(block.products);
        distances.add(block.distances);
    }
    // Without a pair both are 0 / 0.
    let avar = squares.value() / (2.0 * pairs);
    Estimate { m, avar, pairs: pairs as usize, ramp: products.value() / distances.value() }
}

fn block_of(points: &[Point], m: usize, step: usize, first: usize, last: usize) -> Block {
    let least = 0.5 * m as f64;
    let length = last - first;
    let three = [0, m, 2 * m].map(|shift| &points[first + shift..first + shift + length]);
    let mut sums = Block::default();
    for k in (0..length).step_by(step) {
        let [a, b, c] = three.map(|points| points[k]);
        let (m1, m2) = (b.count - a.count, c.count - b.count);
        let counts = m1 >= least && m2 >= least;
        // No branch, because random gaps would make it costly.
        let (r1, r2) = if counts { (1.0 / m1, 1.0 / m2) } else { (0.0, 0.0) };
        let s1 = (b.high - a.high) + (b.low - a.low);
        let s2 = (c.high - b.high) + (c.low - b.low);
        let start = (first + k) as f64;
        let (t1, t2) = (b.index - a.index - start * m1, c.index - b.index - start * m2);
        let (z, d) = (s2 * r2 - s1 * r1, t2 * r2 - t1 * r1);
        sums.pairs += f64::from(u8::from(counts));
        sums.squares += z * z;
        sums.products += z * d;
        sums.distances += d * d;
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::allan;

    fn noise(n: usize) -> Vec<f64> {
        let mut state = 0x2545_F491_4F6C_DD1D_u64;
        let mut random = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        // A random walk, white noise and an offset.
        let mut walk = 9.8;
        (0..n)
            .map(|_| {
                walk += 0.1 * random();
                walk + random()
            })
            .collect()
    }

    #[test]
    fn without_a_gap_it_is_the_allan_variance() {
        let y = noise(5000);
        let sizes = [1, 2, 3, 17, 256, 1000, 2500];
        for overlap in [Overlap::Full, Overlap::None] {
            for counting in [Counting::Standard, Counting::Paper] {
                let sizes = if counting == Counting::Paper { &sizes[..6] } else { &sizes[..] };
                let got = allan_variance(&y, sizes, overlap, counting, None).unwrap();
                let expected = &allan::allan_variances(&[&y], sizes, overlap, counting, None).unwrap()[0];
                for (got, expected) in got.iter().zip(expected) {
                    assert_eq!((got.m, got.pairs), (expected.m, expected.pairs));
                    assert!((got.avar / expected.avar - 1.0).abs() < 1e-12, "{got:?} {expected:?}");
                    // `allan` uses all differences for the ramp of disjoint clusters; here only the pairs are
                    // used.
                    if overlap == Overlap::Full && counting == Counting::Standard {
                        assert!((got.ramp - expected.ramp).abs() < 1e-11, "{got:?} {expected:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_ramp_is_found_whatever_is_missing() {
        let y: Vec<f64> = (0..3000)
            .map(|k| if k % 7 == 3 || (900..1300).contains(&k) { f64::NAN } else { 1e-3 * f64::from(k) })
            .collect();
        for estimate in
            allan_variance(&y, &[1, 5, 64, 700, 1000], Overlap::Full, Counting::Standard, Some(2)).unwrap()
        {
            assert!((estimate.ramp / 1e-3 - 1.0).abs() < 1e-11, "{estimate:?}");
            assert!(estimate.pairs > 0);
            // Clusters of 1000 are half full everywhere.
            assert_eq!(estimate.pairs < 3001 - 2 * estimate.m, estimate.m < 1000, "{estimate:?}");
        }
    }

    #[test]
    fn few_missing_samples_by_both_ways() {
        let mut y = noise(5000);
        for k in [0, 1, 700, 701, 1450, 2501, 4990, 4999] {
            y[k] = f64::NAN;
        }
        let used = y.len();
        let missing: Vec<usize> = (0..used).filter(|&k| y[k].is_nan()).collect();
        let points = few::Points::of(&y, missing);
        for (m, step) in [(1, 1), (2, 1), (3, 3), (17, 1), (256, 256), (1024, 1), (2500, 1)] {
            let got = points.estimates(used, &[m], |_| step)[0];
            let expected = estimate(&running_sums(&y), m, step);
            assert_eq!(got.pairs, expected.pairs);
            assert!((got.avar / expected.avar - 1.0).abs() < 1e-13, "{got:?} {expected:?}");
            assert!((got.ramp - expected.ramp).abs() < 1e-14, "{got:?} {expected:?}");
        }
    }

    #[test]
    fn nothing_there_leaves_no_pair() {
        let mut y = vec![f64::NAN; 100];
        y[50] = 1.0;
        let estimates = allan_variance(&y, &[1, 10], Overlap::Full, Counting::Standard, None).unwrap();
        assert!(estimates.iter().all(|e| e.pairs == 0 && e.avar.is_nan()));
        y[3] = f64::INFINITY;
        let error = allan_variance(&y, &[1], Overlap::Full, Counting::Standard, None);
        assert_eq!(error, Err(Error::NonFinite { index: 3 }));
    }
}
