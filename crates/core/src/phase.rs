//! The phase: the running sum of a rate record, kept so that its second differences lose no digits.
//!
//! A plain running sum grows with the mean of the record, and its second differences, eq. (10) of the paper, are then
//! small differences of large numbers. Here a constant rate is taken out first (the Allan variance does not see it),
//! the sum is carried with its rounding errors, and it starts anew in every block: only the starting points, the
//! anchors, are large, and they are kept to twice the usual precision.

use crate::compensated::{Sum, two_sum};
use crate::error::Error;

/// Phase points per anchor.
pub const BLOCK: usize = 4096;

/// Largest magnitude of a sample; the squared second differences of 10⁹ of them can still be summed.
pub const LARGEST_RATE: f64 = 1e130;

/// The phase of a rate record of N samples: N + 1 points, in units of rate × sample; the first is 0.
#[derive(Debug, Clone)]
pub struct Phase {
    /// Phase relative to the anchor of the block, the slope removed.
    pub(crate) values: Vec<f64>,
    /// Phase at the first point of every block, the slope removed.
    pub(crate) anchors: Vec<Sum>,
}

impl Phase {
    /// Sums a rate record.
    ///
    /// # Errors
    ///
    /// [`Error::NonFinite`] with the index of the first sample that is not finite or exceeds [`LARGEST_RATE`].
    pub fn from_rate(rate: &[f64]) -> Result<Self, Error> {
        let mut builder = PhaseBuilder::new(rate.len());
        builder.push(rate)?;
        Ok(builder.finish())
    }

    /// Number N of rate samples.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.values.len() - 1
    }

    /// The second difference x(k) − 2 x(k + n) + x(k + 2n) of the phase x, a term of eq. (10) of the paper.
    ///
    /// # Panics
    ///
    /// If k + 2n exceeds [`Phase::samples`].
    #[must_use]
    pub fn second_difference(&self, k: usize, n: usize) -> f64 {
        let (first, middle, last) = (self.values[k], self.values[k + n], self.values[k + 2 * n]);
        let anchors = self.anchor_difference(k / BLOCK, (k + n) / BLOCK, (k + 2 * n) / BLOCK);
        (first - middle) + (last - middle) + anchors
    }

    /// The second difference of the anchors of three blocks, rounded only once.
    #[inline]
    pub(crate) fn anchor_difference(&self, first: usize, middle: usize, last: usize) -> f64 {
        if first == last {
            return 0.0;
        }
        let outer = self.anchors[first].plus(self.anchors[last]);
        outer.plus(self.anchors[middle].doubled().negated()).value()
    }

    /// Height of the anchor of a block over that of the block before.
    #[inline]
    pub(crate) fn step_to(&self, block: usize) -> f64 {
        self.anchors[block].plus(self.anchors[block - 1].negated()).value()
    }
}

/// Sums a record that comes in pieces. The result does not depend on how it is cut.
#[derive(Debug)]
pub struct PhaseBuilder {
    phase: Phase,
    /// The samples of the first block, held back until their mean, the slope, is known.
    first_block: Vec<f64>,
    slope: Option<f64>,
    /// Sum since the last anchor.
    running: Sum,
}

impl PhaseBuilder {
    /// A builder with room for `capacity_hint` samples.
    #[must_use]
    pub fn new(capacity_hint: usize) -> Self {
        let mut values = Vec::with_capacity(capacity_hint + 1);
        values.push(0.0);
        let mut anchors = Vec::with_capacity(capacity_hint / BLOCK + 1);
        anchors.push(Sum::default());
        Self {
            phase: Phase { values, anchors },
            first_block: Vec::with_capacity(capacity_hint.min(BLOCK)),
            slope: None,
            running: Sum::default(),
        }
    }

    /// Appends samples.
    ///
    /// # Errors
    ///
    /// [`Error::NonFinite`], the index counted from the first sample of the record. The builder is of no use after it.
    pub fn push(&mut self, rate: &[f64]) -> Result<(), Error> {
        // In pieces that are still in the cache when they are summed.
        for piece in rate.chunks(BLOCK) {
            if let Some(index) = first_unusable(piece) {
                let received = self.phase.samples() + self.first_block.len();
                return Err(Error::NonFinite { index: received + index });
            }
            self.add(piece);
        }
        Ok(())
    }

    /// The phase of all the samples pushed.
    #[must_use]
    pub fn finish(mut self) -> Phase {
        if self.slope.is_none() {
            self.sum_first_block();
        }
        self.phase
    }

    /// Sums samples, or holds them back while there is no slope yet.
    fn add(&mut self, rate: &[f64]) {
        let Some(slope) = self.slope else {
            let missing = BLOCK - self.first_block.len();
            let (head, tail) = rate.split_at(missing.min(rate.len()));
            self.first_block.extend_from_slice(head);
            if self.first_block.len() == BLOCK {
                self.sum_first_block();
                self.add(tail);
            }
            return;
        };
        self.sum(rate, slope);
    }

    /// Takes the slope from the samples held back, and sums them.
    fn sum_first_block(&mut self) {
        let samples = std::mem::take(&mut self.first_block);
        let slope = mean(&samples);
        self.slope = Some(slope);
        self.sum(&samples, slope);
    }

    fn sum(&mut self, rate: &[f64], slope: f64) {
        let mut rest = rate;
        while !rest.is_empty() {
            let to_border = BLOCK - self.phase.samples() % BLOCK;
            let (part, tail) = rest.split_at(to_border.min(rest.len()));
            let mut running = self.running;
            self.phase.values.extend(part.iter().map(|&y| {
                let (difference, before) = two_sum(y, -slope);
                let (hi, after) = two_sum(running.hi, difference);
                // One addition to `lo` a sample: each waits for the one before.
                running = Sum { hi, lo: running.lo + (before + after) };
                running.value()
            }));
            if part.len() == to_border {
                self.start_block(running);
            } else {
                self.running = running;
            }
            rest = tail;
        }
    }

    /// Makes the last point, `height` above the last anchor, the anchor of a new block.
    fn start_block(&mut self, height: Sum) {
        let last = self.phase.anchors.len() - 1;
        let anchor = self.phase.anchors[last].plus(height.normalized());
        self.phase.anchors.push(anchor);
        let point = self.phase.samples();
        self.phase.values[point] = 0.0;
        self.running = Sum::default();
    }
}

/// Plain mean: any slope will do, so that its rounding is of no account.
fn mean(samples: &[f64]) -> f64 {
    if samples.is_empty() {
        return 0.0;
    }
    samples.iter().sum::<f64>() / samples.len() as f64
}

/// Index of the first sample that is not finite or too large.
fn first_unusable(piece: &[f64]) -> Option<usize> {
    let usable = |y: &f64| y.abs() <= LARGEST_RATE;
    // All of them first, without a branch per sample.
    if piece.iter().fold(true, |so_far, y| so_far & usable(y)) {
        return None;
    }
    piece.iter().position(|y| !usable(y))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples of 53 bits, and a slope finer than their last bit: no subtraction and no sum of them is exact.
    fn samples() -> Vec<i64> {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 12) as i64
        };
        (0..3 * BLOCK).map(|k| if k % 2 == 0 { random() } else { -random() }).collect()
    }

    #[test]
    fn anchors_are_exact() {
        let slope = 0.25;
        let mut rate = vec![slope; BLOCK];
        rate.extend(samples().iter().map(|&y| y as f64));
        let phase = Phase::from_rate(&rate).unwrap();
        let mut quarters = 0i128;
        for (block, anchor) in phase.anchors.iter().enumerate() {
            let got = (4.0 * anchor.hi) as i128 + (4.0 * anchor.lo) as i128;
            assert_eq!(got, quarters, "block {block}");
            let samples = &rate[(block * BLOCK).min(rate.len())..((block + 1) * BLOCK).min(rate.len())];
            // Four times a sample is exact, and an integer.
            quarters += samples.iter().map(|&y| i128::from((4.0 * y) as i64) - 1).sum::<i128>();
        }
        assert_eq!(phase.anchors.len(), 5);
        assert_eq!(phase.samples(), 4 * BLOCK);
    }

    #[test]
    fn values_are_rounded_once() {
        let samples = samples();
        let mut rate = vec![0.0; BLOCK];
        rate.extend(samples.iter().map(|&y| y as f64));
        let phase = Phase::from_rate(&rate).unwrap();
        let mut sum = 0i128;
        for (k, &y) in samples.iter().enumerate().take(BLOCK - 1) {
            sum += i128::from(y);
            assert_eq!(phase.values[BLOCK + k + 1].to_bits(), (sum as f64).to_bits());
        }
    }
}
