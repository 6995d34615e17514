//! Running counts of a mask, and what follows exactly from counts in the pairs of clusters.

use crate::compensated::Sum;
use std::num::Wrapping;
use std::ops::{Add, Mul, Sub};

/// Starts whose terms are added plainly; the sums of such blocks are carried with their rounding errors.
const BLOCK: usize = 512;

/// Clusters up to this size have sums of squares of counts, m³/3 at most, below 2⁶⁴.
const LARGEST_IN_64_BITS: usize = 2_500_000;

/// Means over the pairs of clusters of one size, for unit coefficients; NaN without a pair.
pub(super) struct Exact {
    pub(super) pairs: usize,
    pub(super) quantization: f64,
    /// The mean of n²/(m₁m₂).
    pub(super) telescoping: f64,
    pub(super) random_walk: f64,
    pub(super) rate_random_walk: f64,
    /// Mean square of the distance of the mean times.
    pub(super) square_distance: f64,
}

/// Running counts: one more than there are samples, the first 0.
pub(super) struct Counts {
    /// Samples that are there.
    pub(super) valid: Vec<i64>,
    /// Those of them that follow one.
    following: Vec<i64>,
    /// Sum of their indices.
    pub(super) index: Vec<i64>,
}

impl Counts {
    pub(super) fn of(there: &[bool]) -> Self {
        let fresh = || {
            let mut counts = Vec::with_capacity(there.len() + 1);
            counts.push(0);
            counts
        };
        let mut counts = Self { valid: fresh(), following: fresh(), index: fresh() };
        let (mut valid, mut following, mut index) = (0, 0, 0);
        let mut last = false;
        for (k, &there) in there.iter().enumerate() {
            valid += i64::from(there);
            following += i64::from(there && last);
            index += if there { k as i64 } else { 0 };
            last = there;
            counts.valid.push(valid);
            counts.following.push(following);
            counts.index.push(index);
        }
        counts
    }

    /// Samples in each cluster of the pair that begins at a sample, if both are at least half full.
    #[inline]
    pub(super) fn pair(&self, start: usize, m: usize) -> Option<(i64, i64)> {
        let [a, b, c] = [start, start + m, start + 2 * m].map(|k| self.valid[k]);
        let (m1, m2) = (b - a, c - b);
        let full = m as i64;
        (2 * m1 >= full && 2 * m2 >= full).then_some((m1, m2))
    }

    pub(super) fn starts(&self, m: usize) -> usize {
        self.valid.len() - 2 * m
    }

    /// Runs of samples among the `m` from `start` on.
    fn runs(&self, start: usize, m: usize, count: i64) -> i64 {
        count - (self.following[start + m] - self.following[start + 1])
    }

    /// What the pairs show of the terms that counts know all of.
    pub(super) fn exact(&self, there: &[bool], m: usize) -> Exact {
        // Whole numbers that wrap around: only their last value is to fit.
        if m <= LARGEST_IN_64_BITS {
            self.sums(there, m, |count| Wrapping(count as u64), |sum| sum.0 as f64)
        } else {
            self.sums(there, m, |count| Wrapping(count as u128), |sum| sum.0 as f64)
        }
    }

    fn sums<W>(&self, there: &[bool], m: usize, whole: impl Fn(i64) -> W, float: impl Fn(W) -> f64) -> Exact
    where
        W: Copy + Add<Output = W> + Sub<Output = W> + Mul<Output = W>,
    {
        let mut sums = [Sum::default(); 5];
        let mut pairs = 0_usize;
        let least = m as i64;
        // Σ C and Σ C² of the counts C before each sample of the two clusters: from the second sample of the first on.
        let count = |k: usize| whole(self.valid[k]);
        let over = |range: std::ops::Range<usize>| {
            range.fold((whole(0), whole(0)), |(one, two), k| (one + count(k), two + count(k) * count(k)))
        };
        let (mut early, mut late) = (over(1..m), over(m..2 * m));
        let (size_early, size_late) = (whole(m as i64 - 1), whole(m as i64));
        let starts = self.starts(m);
        for first in (0..starts).step_by(BLOCK) {
            let mut block = [0.0; 5];
            for start in first..starts.min(first + BLOCK) {
                let [a, b, c] = [start, start + m, start + 2 * m].map(|k| self.valid[k]);
                let (m1, m2) = (b - a, c - b);
                let counts = 2 * m1 >= least && 2 * m2 >= least;
                pairs += usize::from(counts);
                // Without a branch, which random gaps would make costly.
                let (r1, r2) = if counts { (1.0 / m1 as f64, 1.0 / m2 as f64) } else { (0.0, 0.0) };
                let (runs1, runs2) = (self.runs(start, m, m1), self.runs(start + m, m, m2));
                let met = f64::from(u8::from(there[start + m - 1] & there[start + m]));
                let (begin, middle, end) = (whole(a), whole(b), whole(c));
                let of_early = early.1 - (begin + begin) * early.0 + begin * begin * size_early;
                let of_late = late.1 - (end + end) * late.0 + end * end * size_late;
                block[0] += runs1 as f64 * r1 * r1 + runs2 as f64 * r2 * r2 + met * r1 * r2;
                block[1] += r1 * r2;
                block[2] += r1 + r2;
                block[3] += float(of_early) * r1 * r1 + float(of_late) * r2 * r2;
                let distance = self.distance(start, m, [m1, m2], [r1, r2]);
                block[4] += distance * distance;
                // One sample on.
                let (out, new) = (count(start + 1), end);
                early.0 = early.0 + middle - out;
                early.1 = early.1 + middle * middle - out * out;
                late.0 = late.0 + new - middle;
                late.1 = late.1 + new * new - middle * middle;
            }
            sums.iter_mut().zip(block).for_each(|(sum, block)| sum.add(block));
        }
        let [phase, product, white, walk, square] = sums.map(|sum| sum.value() / pairs as f64);
        Exact {
            pairs,
            quantization: phase,
            telescoping: product * m as f64 * m as f64,
            random_walk: 0.5 * white,
            rate_random_walk: 0.5 * walk,
            square_distance: square,
        }
    }

    /// Distance of the mean times of two clusters, of which the reciprocals of their counts are given.
    #[inline]
    fn distance(&self, start: usize, m: usize, counts: [i64; 2], r: [f64; 2]) -> f64 {
        let [a, b, c] = [start, start + m, start + 2 * m].map(|k| self.index[k]);
        let from = start as i64;
        (c - b - from * counts[1]) as f64 * r[1] - (b - a - from * counts[0]) as f64 * r[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mask(n: usize) -> Vec<bool> {
        (0..n).map(|k| k % 7 != 3 && k * k % 11 != 4 && !(n / 2..n / 2 + n / 8).contains(&k)).collect()
    }

    #[test]
    fn both_widths_of_whole_numbers_agree() {
        let there = mask(3000);
        let counts = Counts::of(&there);
        for m in [1, 64, 700] {
            let narrow = counts.exact(&there, m);
            let wide = counts.sums(&there, m, |count| Wrapping(count as u128), |sum| sum.0 as f64);
            assert_eq!(narrow.pairs, wide.pairs);
            assert!(narrow.rate_random_walk.to_bits() == wide.rate_random_walk.to_bits(), "{m}");
        }
    }
}
