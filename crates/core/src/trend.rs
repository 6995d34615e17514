//! The mean of the second differences of a phase: what a ramp of the rate leaves in an Allan variance, with its sign.
//!
//! The mean over all k of z(k) = x(k) − 2x(k + n) + x(k + 2n) is n² times an unbiased estimate of the ramp per sample.
//! The sum of z telescopes to sums over the ends of the phase: with A(j) the sum of its first and B(j) that of its last
//! j points, it is 2A(n) + 2B(n) − A(2n) − B(2n).

use crate::compensated::Sum;
use crate::phase::{BLOCK, Phase};
use std::ops::Range;

/// Points per partial sum that is kept; divides [`BLOCK`].
const STEP: usize = 64;

/// Sums over the first points of a phase, for any number of them.
pub(crate) struct Trend<'a> {
    phase: &'a Phase,
    /// Sum of the first k·[`STEP`] points.
    sums: Vec<Sum>,
}

impl<'a> Trend<'a> {
    /// One pass over the phase.
    pub(crate) fn new(phase: &'a Phase) -> Self {
        let points = phase.values.len();
        let mut sums = Vec::with_capacity(points / STEP + 1);
        let mut sum = Sum::default();
        sums.push(sum);
        for start in (STEP..=points).step_by(STEP) {
            sum = sum.plus(stretch(phase, start - STEP, start));
            sums.push(sum);
        }
        Self { phase, sums }
    }

    /// Mean of all second differences over n², the change of the rate per sample, for consecutive cluster sizes n: each sum
    /// from the one before, by six points.
    pub(crate) fn ramps(&self, sizes: Range<usize>) -> Vec<f64> {
        let points = self.phase.values.len();
        let mut total = self.total(sizes.start);
        sizes
            .map(|n| {
                let mean = total.value() / (points - 2 * n) as f64;
                // Up to the largest size there is, beyond which no point is left.
                if 2 * (n + 1) < points {
                    let (near, far) = (self.point(n).plus(self.point(points - 1 - n)), 2 * n);
                    let first = self.point(far).plus(self.point(far + 1));
                    let last = self.point(points - 1 - far).plus(self.point(points - 2 - far));
                    total = total.plus(near.doubled()).plus(first.plus(last).negated());
                }
                let size = n as f64;
                mean / size / size
            })
            .collect()
    }

    /// Sum of all second differences of cluster size `n`.
    fn total(&self, n: usize) -> Sum {
        let points = self.phase.values.len();
        let all = self.first(points);
        let last = |count: usize| all.plus(self.first(points - count).negated());
        let near = self.first(n).plus(last(n)).doubled();
        let far = self.first(2 * n).plus(last(2 * n)).negated();
        near.plus(far)
    }

    fn point(&self, k: usize) -> Sum {
        self.phase.anchors[k / BLOCK].plus(Sum { hi: self.phase.values[k], lo: 0.0 })
    }

    /// Sum of the first `count` points.
    pub(crate) fn first(&self, count: usize) -> Sum {
        let step = count / STEP;
        self.sums[step].plus(stretch(self.phase, step * STEP, count))
    }
}

/// Sum of the points from `start` up to `end`, which lie in one block.
fn stretch(phase: &Phase, start: usize, end: usize) -> Sum {
    if start == end {
        return Sum::default();
    }
    // Few points and near their anchor: a plain sum will do, in lanes that the compiler can keep side by side.
    let mut lanes = [0.0; 8];
    let chunks = phase.values[start..end].chunks_exact(8);
    let rest = chunks.remainder();
    for chunk in chunks {
        lanes.iter_mut().zip(chunk).for_each(|(lane, value)| *lane += value);
    }
    let mut sum = Sum::default();
    lanes.iter().chain(rest).for_each(|part| sum.add(*part));
    let anchor = phase.anchors[start / BLOCK];
    let count = (end - start) as f64;
    // The product of a float and a small integer, and its rounding error.
    let hi = anchor.hi * count;
    let error = anchor.hi.mul_add(count, -hi);
    sum.normalized().plus(Sum { hi, lo: error + anchor.lo * count }.normalized())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(trend: &Trend, n: usize) -> f64 {
        trend.ramps(n..n + 1)[0]
    }

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
            let (got, expected) = (ramp(&trend, n), mean_difference(&phase, n));
            assert!((got - expected).abs() < 1e-10 * expected.abs().max(1e-3), "{n}: {got} {expected}");
        }
    }

    #[test]
    fn consecutive_sizes_are_the_same() {
        for (samples, sizes) in [(9001, 1..4501), (9000, 4000..4501), (2, 1..2), (5000, 7..7)] {
            let rate: Vec<f64> = (0..samples).map(|k| 1e6 + f64::from(k * k % 1009u32).sqrt()).collect();
            let phase = Phase::from_rate(&rate).unwrap();
            let trend = Trend::new(&phase);
            for (n, got) in sizes.clone().zip(trend.ramps(sizes)) {
                let expected = ramp(&trend, n);
                // Both round at 2⁻¹⁰⁴ of sums of the phase, which are 1e12 times the differences at most.
                assert!((got - expected).abs() <= 1e-15 * expected.abs() + 1e-18, "{n}: {got} {expected}");
            }
        }
    }

    #[test]
    fn finds_a_ramp_beside_a_large_offset() {
        let rate: Vec<f64> = (0..20_000u32).map(|k| 1e6 + 3e-7 * f64::from(k)).collect();
        let phase = Phase::from_rate(&rate).unwrap();
        let trend = Trend::new(&phase);
        for n in [1, 100, 10_000] {
            // Samples are rounded to 1e-10.
            assert!((ramp(&trend, n) - 3e-7).abs() < 1e-10 / n as f64, "{n}: {}", ramp(&trend, n));
        }
    }

    #[test]
    fn every_point_of_an_impulse_counts_once() {
        for at in [0, 63, 64, 4095, 4096, 8000] {
            let mut rate = vec![0.0; 9001];
            rate[at] = 1.0;
            let phase = Phase::from_rate(&rate).unwrap();
            let trend = Trend::new(&phase);
            for n in [1, 63, 64, 65, 4500] {
                let (got, expected) = (ramp(&trend, n), mean_difference(&phase, n));
                assert!((got - expected).abs() < 1e-15, "{at} {n}: {got} {expected}");
            }
        }
    }
}
