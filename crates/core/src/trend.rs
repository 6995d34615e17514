//! The mean of the second differences of a phase: what a ramp of the rate leaves in an Allan variance, with its sign.
//!
//! The mean over all k of z(k) = x(k) − 2x(k + n) + x(k + 2n) is n² times an unbiased estimate of the ramp per sample.
//! The sum of z telescopes to sums over the ends of the phase: with A(j) the sum of its first and B(j) that of its last
//! j points, it is 2A(n) + 2B(n) − A(2n) − B(2n).

use crate::compensated::Sum;
use crate::phase::{Phase, sum_in_lanes};

/// Sums over the first points of a phase, for any number of them.
pub(crate) struct Trend<'a> {
    phase: &'a Phase,
    /// Sum of the points of the first k blocks.
    sums: Vec<Sum>,
}

impl<'a> Trend<'a> {
    /// Adds up what the blocks of the phase know of themselves.
    pub(crate) fn new(phase: &'a Phase) -> Self {
        let whole = phase.values.len() / phase.block;
        let mut sum = Sum::default();
        let mut sums = vec![sum];
        for (area, anchor) in phase.areas.iter().zip(&phase.anchors).take(whole) {
            sum = sum.plus(lifted(*area, *anchor, phase.block));
            sums.push(sum);
        }
        Self { phase, sums }
    }

    /// Mean of all second differences of cluster size `n`, over n²: the change of the rate per sample.
    pub(crate) fn ramp(&self, n: usize) -> f64 {
        let points = self.phase.values.len();
        let all = self.first(points);
        let last = |count: usize| all.plus(self.first(points - count).negated());
        let near = self.first(n).plus(last(n)).doubled();
        let far = self.first(2 * n).plus(last(2 * n)).negated();
        let size = n as f64;
        near.plus(far).value() / ((points - 2 * n) as f64) / size / size
    }

    /// Sum of the first `count` points.
    fn first(&self, count: usize) -> Sum {
        let block = count / self.phase.block;
        let points = &self.phase.values[block * self.phase.block..count];
        if points.is_empty() {
            return self.sums[block];
        }
        self.sums[block].plus(lifted(sum_in_lanes(points), self.phase.anchors[block], points.len()))
    }
}

/// Sum of `count` points from their sum relative to an anchor.
fn lifted(area: f64, anchor: Sum, count: usize) -> Sum {
    let count = count as f64;
    // The product of a float and a small integer, and its rounding error.
    let hi = anchor.hi * count;
    let error = anchor.hi.mul_add(count, -hi);
    Sum { hi: area, lo: 0.0 }.plus(Sum { hi, lo: error + anchor.lo * count }.normalized())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::phase::LONGEST_BLOCK as BLOCK;

    fn mean_difference(phase: &Phase, n: usize) -> f64 {
        let pairs = phase.samples() + 1 - 2 * n;
        let sum: f64 = (0..pairs).map(|k| phase.second_difference(k, n)).sum();
        sum / pairs as f64 / (n * n) as f64
    }

    #[test]
    fn is_the_mean_of_the_differences() {
        // Integers: every sum is exact.
        let rate: Vec<f64> = (0..10_007u32).map(|k| f64::from(k.wrapping_mul(2_654_435_761) >> 20)).collect();
        let phase = Phase::from_rate(&rate).unwrap();
        let trend = Trend::new(&phase);
        for n in [1, 2, 31, 32, 33, 64, 100, 2047, 2048, 4096, 5003] {
            let (got, expected) = (trend.ramp(n), mean_difference(&phase, n));
            assert!((got - expected).abs() < 1e-10 * expected.abs().max(1e-3), "{n}: {got} {expected}");
        }
    }

    #[test]
    fn a_last_block_that_its_end_fills_counts_whole() {
        for n in [BLOCK - 2, BLOCK - 1, BLOCK, 2 * BLOCK - 1] {
            let rate: Vec<f64> = (0..n).map(|k| if k % 7 == 0 { 3.0 } else { -1.0 }).collect();
            let phase = Phase::from_rate(&rate).unwrap();
            let (got, expected) = (Trend::new(&phase).ramp(n / 2), mean_difference(&phase, n / 2));
            // Plain sums of some 10⁴ differences as large as 10⁴, over 10⁸.
            assert!((got - expected).abs() < 1e-12, "{n}: {got} {expected}");
        }
    }

    #[test]
    fn finds_a_ramp_beside_a_large_offset() {
        let rate: Vec<f64> = (0..20_000u32).map(|k| 1e6 + 3e-7 * f64::from(k)).collect();
        let phase = Phase::from_rate(&rate).unwrap();
        let trend = Trend::new(&phase);
        for n in [1, 100, 10_000] {
            // Samples are rounded to 1e-10.
            assert!((trend.ramp(n) - 3e-7).abs() < 1e-10 / n as f64, "{n}: {}", trend.ramp(n));
        }
    }

    #[test]
    fn every_point_of_an_impulse_counts_once() {
        for at in [0, 63, 64, BLOCK - 1, BLOCK, 2 * BLOCK - 1, 2 * BLOCK] {
            let mut rate = vec![0.0; 2 * BLOCK + 1234];
            rate[at] = 1.0;
            let phase = Phase::from_rate(&rate).unwrap();
            let trend = Trend::new(&phase);
            for n in [1, 63, 64, 65, BLOCK / 2, BLOCK] {
                let (got, expected) = (trend.ramp(n), mean_difference(&phase, n));
                assert!((got - expected).abs() < 1e-15, "{at} {n}: {got} {expected}");
            }
        }
    }
}
