//! The phase: the running sum of a rate record, stored so that its second differences lose no digits.
//!
//! A plain running sum grows with the mean of the record, and its second differences, eq. (10) of the paper, are then small
//! differences of large numbers. Here a constant rate is subtracted first (the Allan variance does not depend on it), the
//! sum keeps its rounding errors, and starts again in each block. Only the starting points of the blocks, the anchors, are
//! large, and they are stored with twice the usual precision.

use crate::compensated::Sum;
use crate::error::Error;
use crate::parallel::prelude::*;
use crate::points::Points;
use scan::{GROUP, Plain, Vectors};
use std::sync::Mutex;
use survey::Survey;

mod scan;
mod survey;

pub use survey::{LONGEST_BLOCK, SHORTEST_BLOCK};

/// Largest number of points in a stretch, of which the sum is stored.
const STRETCH: usize = 16_384;

/// Memory of phases that are no longer used, because new pages would take longer than the sums.
static SPARE: Mutex<Vec<Points>> = Mutex::new(Vec::new());

/// Largest number of points in a piece of spare memory, and largest number of pieces: 256 MiB in all.
const SPARE_POINTS: usize = 1 << 24;
/// See [`SPARE_POINTS`].
const SPARE_PIECES: usize = 2;

/// Number of samples below which no other thread is started.
const WORTH_THREADS: usize = 1 << 18;

/// Number of samples that are checked, summed and summed again before the next ones are read; it divides all block lengths.
pub(crate) const PIECE: usize = 1024;

/// Largest magnitude of a sample. The sum of the squared second differences of 10⁹ such samples does not overflow.
pub const LARGEST_RATE: f64 = 1e130;

/// The phase of a rate record of N samples: N + 1 points, in units of rate × sample; the first is 0.
#[derive(Debug, Clone)]
pub struct Phase {
    /// Points per anchor: a power of two.
    pub(crate) block: usize,
    /// Rate that was subtracted before the samples were summed.
    pub(crate) slope: f64,
    /// Phase relative to the anchor of the block, after the subtraction of the slope.
    pub(crate) values: Points,
    /// Phase at the first point of each block, after the subtraction of the slope.
    pub(crate) anchors: Vec<Sum>,
    /// Sum of each [`Phase::stretch`] of points, relative to the anchor of its block.
    pub(crate) areas: Vec<Sum>,
}

impl Default for Phase {
    /// The phase of a record without samples.
    fn default() -> Self {
        Self {
            block: LONGEST_BLOCK,
            slope: 0.0,
            values: Points::zero(),
            anchors: vec![Sum::default()],
            areas: Vec::new(),
        }
    }
}

impl Phase {
    /// Sums a rate record, on the current rayon pool.
    ///
    /// # Errors
    ///
    /// [`Error::NonFinite`] with the index of the first sample that is not finite or exceeds [`LARGEST_RATE`].
    pub fn from_rate(rate: &[f64]) -> Result<Self, Error> {
        let mut phase = Self::default();
        phase.refill(rate)?;
        Ok(phase)
    }

    /// An empty phase, in memory of a phase that is no longer used.
    pub(crate) fn reused() -> Self {
        // This does not wait for the lock, which a process forked at this moment could never acquire.
        let values = SPARE.try_lock().ok().and_then(|mut spare| spare.pop()).unwrap_or_default();
        Self { values, ..Self::default() }
    }

    /// Returns the memory to the spare memory.
    pub(crate) fn leave(self) {
        if let Ok(mut spare) = SPARE.try_lock() {
            if self.values.capacity() <= SPARE_POINTS && spare.len() < SPARE_PIECES {
                spare.push(self.values);
            }
        }
    }

    /// Sums another rate record in the memory of this one, because new memory would take longer than the sums.
    ///
    /// # Errors
    ///
    /// Those of [`Phase::from_rate`]. The phase cannot be used after an error.
    pub fn refill(&mut self, rate: &[f64]) -> Result<(), Error> {
        self.fill(rate, LARGEST_RATE, LONGEST_BLOCK)
    }

    /// [`Phase::refill`] with other limits than [`LARGEST_RATE`] and [`LONGEST_BLOCK`].
    pub(crate) fn fill(&mut self, rate: &[f64], largest: f64, longest: usize) -> Result<(), Error> {
        self.values.resize(rate.len() + 1)?;
        let Survey { slope, block } = Survey::of(rate);
        let length = block.min(longest);
        (self.block, self.slope) = (length, slope);
        let of_block = |(rate, points): (&[f64], &mut [f64])| Block { rate, slope, largest, points }.sum();
        let totals: Vec<Option<Totals>> = if rate.len() < WORTH_THREADS {
            rate.chunks(length).zip(self.values.chunks_mut(length)).map(of_block).collect()
        } else {
            rate.par_chunks(length).zip(self.values.par_chunks_mut(length)).map(of_block).collect()
        };
        let mut anchor = Sum::default();
        self.anchors.clear();
        self.areas.clear();
        self.anchors.push(anchor);
        for (block, totals) in totals.into_iter().enumerate() {
            let Some(Totals { height, areas }) = totals else {
                return Err(Error::NonFinite { index: first_unusable(rate, block * length, largest) });
            };
            anchor = anchor.plus(height);
            self.anchors.push(anchor);
            self.areas.extend(areas);
        }
        // No sample follows the last point: it is the anchor of a new block, or the end of an incomplete one.
        let full = rate.len() % length == 0;
        let end = if full {
            0.0
        } else {
            let beyond = self.anchors.pop().unwrap_or_default();
            let last = self.anchors.last().copied().unwrap_or_default();
            beyond.plus(last.negated()).value()
        };
        self.values[rate.len()] = end;
        let begins_a_stretch = rate.len() % self.stretch() == 0;
        match self.areas.last_mut() {
            Some(area) if !begins_a_stretch => area.add(end),
            _ => self.areas.push(Sum { hi: end, lo: 0.0 }),
        }
        Ok(())
    }

    /// Number of the block that contains a point: a division, by a power of two.
    #[inline]
    pub(crate) fn block_of(&self, point: usize) -> usize {
        point >> self.block.trailing_zeros()
    }

    /// Number of points from the anchor of a point to the point.
    #[inline]
    pub(crate) fn offset_of(&self, point: usize) -> usize {
        point & (self.block - 1)
    }

    /// Number of points with a common sum: a block, or a part of a long block.
    pub(crate) fn stretch(&self) -> usize {
        self.block.min(STRETCH)
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
        let anchors = self.anchor_difference(k / self.block, (k + n) / self.block, (k + 2 * n) / self.block);
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

    /// Height of the anchor of a block above that of the previous block.
    #[inline]
    pub(crate) fn step_to(&self, block: usize) -> f64 {
        self.anchors[block].plus(self.anchors[block - 1].negated()).value()
    }
}

/// A block of samples that is being summed.
struct Block<'a> {
    rate: &'a [f64],
    slope: f64,
    largest: f64,
    points: &'a mut [f64],
}

/// Sums of a block.
struct Totals {
    /// Sum of the samples: the height of the next anchor.
    height: Sum,
    /// Sums of the points, by stretch.
    areas: Vec<Sum>,
}

impl Block<'_> {
    /// The points are relative to the first one, which is 0; a sample is the step to the next one. None if a sample
    /// cannot be used. The result has the same bits on every processor.
    fn sum(self) -> Option<Totals> {
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            return simd.vectorize(Vectorized { block: self, simd });
        }
        self.sum_on(Plain)
    }

    #[inline(always)]
    #[allow(clippy::inline_always)] // Inlined into a function that is compiled for wide vectors.
    fn sum_on<S: Vectors>(self, simd: S) -> Option<Totals> {
        let mut height = Sum::default();
        let mut areas = Vec::with_capacity(self.rate.len() / STRETCH + 1);
        for (at, (rate, points)) in self.rate.chunks(PIECE).zip(self.points.chunks_mut(PIECE)).enumerate() {
            let piece = scan::sum_piece(simd, rate, self.slope, &mut height, points);
            if piece.largest > self.largest {
                return None;
            }
            match areas.last_mut() {
                Some(sum) if at % (STRETCH / PIECE) > 0 => Sum::add(sum, piece.area),
                _ => areas.push(Sum { hi: piece.area, lo: 0.0 }),
            }
        }
        let height = height.normalized();
        // It is NaN only if a sample is.
        height.value().is_finite().then_some(Totals { height, areas })
    }
}

/// [`Block::sum_on`] with the vectors for which `pulp` compiles it.
#[cfg(target_arch = "x86_64")]
struct Vectorized<'a> {
    block: Block<'a>,
    simd: pulp::x86::V3,
}

#[cfg(target_arch = "x86_64")]
impl pulp::NullaryFnOnce for Vectorized<'_> {
    type Output = Option<Totals>;

    #[inline(always)]
    #[allow(clippy::inline_always)] // As above.
    fn call(self) -> Option<Totals> {
        self.block.sum_on(self.simd)
    }
}

/// Plain sum, in lanes that the compiler can vectorise.
#[inline(always)]
#[allow(clippy::inline_always)] // As above.
pub(crate) fn sum_in_lanes(points: &[f64]) -> f64 {
    let mut lanes = [0.0; GROUP];
    let chunks = points.chunks_exact(GROUP);
    let rest: f64 = chunks.remainder().iter().sum();
    for chunk in chunks {
        lanes.iter_mut().zip(chunk).for_each(|(lane, value)| *lane += value);
    }
    lanes.iter().sum::<f64>() + rest
}

/// Index of the first sample that is not finite or too large, known to lie in the block that starts at `from`.
fn first_unusable(rate: &[f64], from: usize, largest: f64) -> usize {
    let usable = |y: &f64| y.abs() <= largest;
    from + rate[from..].iter().position(|y| !usable(y)).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples with 53 bits, so that no sum of them is exact.
    fn samples() -> Vec<i64> {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 12) as i64
        };
        (0..3 * LONGEST_BLOCK).map(|k| if k % 2 == 0 { random() } else { -random() }).collect()
    }

    #[test]
    fn anchors_keep_the_digits_that_a_plain_sum_loses() {
        // Next to zeros, which are not rounded.
        let mut rate = vec![0.0; LONGEST_BLOCK];
        rate.extend(samples().iter().map(|&y| y.abs() as f64));
        let phase = Phase::from_rate(&rate).unwrap();
        let slope = Survey::of(&rate).slope;
        let largest = rate.iter().copied().fold(0.0, f64::max);
        for (block, anchor) in phase.anchors.iter().enumerate() {
            let before = &rate[..block * phase.block];
            // Without the last bits of the slope, which is a multiple of 2⁻¹⁰ or so.
            let exact: i128 = before.iter().map(|&y| ((y - slope) * 1024.0) as i128).sum();
            let error = ((anchor.hi * 1024.0) as i128 + (anchor.lo * 1024.0) as i128 - exact) as f64 / 1024.0;
            // The sum of each group of samples is rounded, and is no larger than a group of the largest sample. The errors
            // of the groups add up like a random walk, of which six standard deviations are allowed. The error of a plain
            // sum is a thousand times that.
            let groups = (before.len() / GROUP) as f64;
            let bound = 6.0 * groups.sqrt() * f64::EPSILON * GROUP as f64 * largest;
            assert!(error.abs() <= bound, "block {block}: {error:e}, allowed {bound:e}");
        }
        assert_eq!(phase.anchors.len(), phase.samples() / phase.block + 1);
    }

    #[test]
    fn points_are_sums_of_the_samples_before_them() {
        // Small integers: every sum is exact.
        for n in [
            0,
            1,
            2,
            GROUP - 1,
            GROUP,
            PIECE,
            PIECE + 3,
            LONGEST_BLOCK - 1,
            LONGEST_BLOCK,
            LONGEST_BLOCK + 1,
            2 * LONGEST_BLOCK + 777,
        ] {
            let rate: Vec<f64> =
                (0..n).map(|k| f64::from((k as u32).wrapping_mul(2_654_435_761) >> 20)).collect();
            let phase = Phase::from_rate(&rate).unwrap();
            let slope = Survey::of(&rate).slope;
            assert_eq!(phase.samples(), n);
            assert_eq!(phase.anchors.len(), n / phase.block + 1);
            let mut sum = 0.0;
            for k in 0..=n {
                let point = phase.anchors[k / phase.block].value() + phase.values[k];
                let expected = sum - slope * k as f64;
                assert!(
                    (point - expected).abs() <= 1e-15 * 4096.0 * (k + 1) as f64,
                    "{n} {k}: {point} {expected}"
                );
                sum += rate.get(k).copied().unwrap_or_default();
            }
        }
    }

    #[test]
    fn memory_used_before_makes_no_difference() {
        let long: Vec<f64> = samples().iter().map(|&y| y as f64).collect();
        let mut phase = Phase::from_rate(&long).unwrap();
        for n in [0, 5, LONGEST_BLOCK, LONGEST_BLOCK + 5, long.len()] {
            phase.refill(&long[long.len() - n..]).unwrap();
            let fresh = Phase::from_rate(&long[long.len() - n..]).unwrap();
            assert_eq!(
                (&phase.values[..], phase.anchors.as_slice()),
                (&fresh.values[..], &fresh.anchors[..])
            );
            assert_eq!(phase.areas, fresh.areas);
        }
    }
}
