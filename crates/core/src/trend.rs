//! The mean of the second differences of a phase: the signed effect of a ramp of the rate on an Allan variance.
//!
//! The mean over all k of z(k) = x(k) − 2x(k + n) + x(k + 2n) is n² times an unbiased estimate of the ramp per sample.
//! The sum of z telescopes to sums over the ends of the phase: where A(j) is the sum of its first and B(j) that of its last
//! j points, it is 2A(n) + 2B(n) − A(2n) − B(2n).

use crate::compensated::Sum;
use crate::phase::{PIECE, Phase, sum_in_lanes};
use std::ops::Range;

/// Sums over the first points of a phase, for any number of them.
pub(crate) struct Trend<'a> {
    phase: &'a Phase,
    /// Sum of the points of the first k stretches.
    sums: Vec<Sum>,
}

impl<'a> Trend<'a> {
    /// Adds up the stored sums of the stretches of a phase.
    pub(crate) fn new(phase: &'a Phase) -> Self {
        let stretch = phase.stretch();
        let mut sum = Sum::default();
        let mut sums = vec![sum];
        for (k, area) in phase.areas.iter().enumerate().take(phase.values.len() / stretch) {
            let anchor = phase.anchors[k * stretch / phase.block];
            sum = sum.plus(lifted(area.normalized(), anchor, stretch));
            sums.push(sum);
        }
        Self { phase, sums }
    }

    /// Mean of all second differences over n², the change of the rate per sample, for consecutive cluster sizes n. Each sum
    /// follows from the previous one by six points.
    pub(crate) fn ramps(&self, sizes: Range<usize>) -> Vec<f64> {
        let points = self.phase.values.len();
        let mut total = self.total(sizes.start);
        sizes
            .map(|n| {
                let mean = total.value() / (points - 2 * n) as f64;
                // Up to the largest possible size.
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
        self.phase.anchors[k / self.phase.block].plus(Sum { hi: self.phase.values[k], lo: 0.0 })
    }

    /// Sum of the first `count` points.
    pub(crate) fn first(&self, count: usize) -> Sum {
        let stretch = self.phase.stretch();
        let whole = count / stretch;
        let points = &self.phase.values[whole * stretch..count];
        if points.is_empty() {
            return self.sums[whole];
        }
        let anchor = self.phase.anchors[whole * stretch / self.phase.block];
        let mut area = Sum::default();
        points.chunks(PIECE).for_each(|piece| area.add(sum_in_lanes(piece)));
        self.sums[whole].plus(lifted(area.normalized(), anchor, points.len()))
    }
}

/// Sum of `count` points from their sum relative to an anchor.
fn lifted(area: Sum, anchor: Sum, count: usize) -> Sum {
    let count = count as f64;
    // The product of a float and a small integer, and its rounding error.
    let hi = anchor.hi * count;
    let error = anchor.hi.mul_add(count, -hi);
    area.plus(Sum { hi, lo: error + anchor.lo * count }.normalized())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::phase::LONGEST_BLOCK as BLOCK;

    /// Bound on the error of plain sums over the pieces of a phase: as many roundings as points, at the height of the sum.
    fn sum_rounding(phase: &Phase) -> f64 {
        let height = phase.values.iter().fold(0.0, |height: f64, value| height.max(value.abs()));
        f64::EPSILON * (PIECE * PIECE) as f64 * height
    }

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
    fn a_last_block_that_its_end_fills_counts_whole() {
        for n in [BLOCK - 2, BLOCK - 1, BLOCK, 2 * BLOCK - 1] {
            let rate: Vec<f64> = (0..n).map(|k| if k % 7 == 0 { 3.0 } else { -1.0 }).collect();
            let phase = Phase::from_rate(&rate).unwrap();
            let (got, expected) = (ramp(&Trend::new(&phase), n / 2), mean_difference(&phase, n / 2));
            // Plain sums of about 10⁴ differences up to 10⁴, over 10⁸.
            assert!((got - expected).abs() < 1e-12, "{n}: {got} {expected}");
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
                let rounding = sum_rounding(&phase) / ((samples as usize + 1 - 2 * n) * n * n) as f64;
                assert!((got - expected).abs() <= 1e-15 * expected.abs() + rounding, "{n}: {got} {expected}");
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
        for at in [0, 63, 64, BLOCK - 1, BLOCK, 2 * BLOCK - 1, 2 * BLOCK] {
            let mut rate = vec![0.0; 2 * BLOCK + 1234];
            rate[at] = 1.0;
            let phase = Phase::from_rate(&rate).unwrap();
            let trend = Trend::new(&phase);
            for n in [1, 63, 64, 65, BLOCK / 2, BLOCK] {
                let (got, expected) = (ramp(&trend, n), mean_difference(&phase, n));
                assert!((got - expected).abs() < 1e-15, "{at} {n}: {got} {expected}");
            }
        }
    }
}
