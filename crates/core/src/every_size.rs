//! The Allan variance at every cluster size up to half the record, in about N log² N operations in place of N² / 4.
//!
//! # The sum over a record
//!
//! With `q(n) = Σ_j (x(j + n) − x(j))²`, over all j with both points in the record, the identity
//! (c − b − (b − a))² = 2 (b − a)² + 2 (c − b)² − (c − a)² gives for the sum of the squared second differences
//!
//! D(n) = 4 q(n) − q(2n) − 2 h(n) − 2 t(n),
//!
//! where h(n), the head, is the part of q(n) with j among the first n points: no second difference has
//! x(j) and x(j + n) as its middle and last points. t(n), the tail, is the corresponding part at the end. A sum of
//! squared differences consists of sums of squares, which are updated from one n to the next, and of a correlation,
//! which Fourier transforms give for all n at once; for the head see [`triangle`].
//!
//! # By blocks
//!
//! The squares of a phase with strong drift are large, and D is their small difference. Second differences do
//! not depend on a straight line. For each group of sizes n the phase is therefore cut into blocks, 16 times as long as
//! the smallest n and 4 times as long as the largest, and from each block a separate line is subtracted, which is
//! fitted to the block and to the points that its starts j reach. If x(j) is in one block and the middle point x(j + n)
//! in the next one, whose line is steeper by s, the second difference must use the line of the next block.
//! With δ = n s its three squares are those of x(j + n) − x(j) − δ, of x(j + 2n) − x(j + n) − δ and of x(j +
//! 2n) − x(j) − 2δ. The second one is correct already, because it belongs to the start j + n, in the next block. The
//! other two change the sum by Σ (4δ (x(j + 2n) − x(j + n)) − 2δ²) over the n starts before the border: sums of
//! points, not of products.
//!
//! The remaining phase in a block is as large as its second differences, up to a factor that depends only on the shape
//! of its spectrum, whatever the drift and the mean of the record.
//!
//! # Errors
//!
//! The error of a correlation by Fourier transforms is a small multiple of ε times the sum of squares E. Most D(n) are of
//! the order of E, but they are much smaller if n is a multiple of the period of a strong line. If the error
//! bound of D exceeds [`TOLERANCE`] · D, no value is returned, and it must be summed directly. The value is
//! returned anyway if the bound is below the effect of the rounding of the phase, as in a constant record, because the
//! direct sum is then no better. A record that repeats itself exactly, or whose phase has one outlier, may thus need up to
//! N² / 8 terms, but never more than direct sums.
//!
//! The transforms use the vectors of the processor, so the last bits may differ between processors. They do
//! not depend on the number of threads.
//!
//! Memory: some 20 numbers for each sample, when n is of the order of the record.

mod correlation;
mod stretch;
#[cfg(test)]
mod tests;
mod triangle;

use crate::compensated::Sum;
use crate::parallel::{join, prelude::*};
use crate::phase::Phase;
use crate::trend::Trend;
use std::ops::Range;
use stretch::{Line, Stretch};

/// Smallest cluster size: smaller ones are cheaper to sum directly.
pub const SMALLEST: usize = 256;

/// Number of terms below which a direct sum is cheaper, because a transform would handle mostly other points.
const DIRECT_TERMS: usize = 512;

/// Largest relative error of a sum that is returned.
const TOLERANCE: f64 = 5e-10;

/// Error of a correlation, divided by the norm of its starts and by that of the points that they reach: twice the
/// largest error in the tests, for a strong line.
const TRANSFORM_ERROR: f64 = 4.0 * f64::EPSILON;

/// Sums of the squared second differences of the first `points` of a phase, for n from [`SMALLEST`] up to `largest`; None if
/// cancellation leaves fewer than nine digits, or if there are few terms.
///
/// Runs on the current rayon pool. The division of the record and the order of the sums do not depend on the number of
/// threads, and neither does the result.
pub fn sums_of_squares(phase: &Phase, trend: &Trend, points: usize, largest: usize) -> Vec<Option<f64>> {
    let largest = largest.min(points.saturating_sub(DIRECT_TERMS) / 2);
    let mut sums = Vec::new();
    let mut smallest = SMALLEST;
    while smallest <= largest {
        let group = Group::new(phase, trend, points, smallest, largest);
        sums.extend(group.trusted());
        smallest = group.sizes.end;
    }
    sums
}

/// Cluster sizes that share their blocks.
struct Group<'a> {
    phase: &'a Phase,
    points: usize,
    sizes: Range<usize>,
    /// Starts j of each block; each is at least four times the largest size, or there is only one.
    blocks: Vec<Range<usize>>,
    lines: Vec<Line>,
}

/// Contribution of one block to the sums.
struct Part {
    /// Sums by size.
    sums: Vec<f64>,
    /// Bound on the errors of the sums.
    error: f64,
    /// Effect of the rounding of the phase on the sums.
    rounding: f64,
}

impl<'a> Group<'a> {
    fn new(phase: &'a Phase, trend: &Trend, points: usize, smallest: usize, largest: usize) -> Self {
        let length = 16 * smallest;
        // The last block includes the remainder, so it is at least as long as the others.
        let count = (points / length).max(1);
        let end = if count == 1 { largest + 1 } else { (4 * smallest).min(largest + 1) };
        let border = |block: usize| if block == count { points } else { block * length };
        let blocks: Vec<_> = (0..count).map(|block| border(block)..border(block + 1)).collect();
        let reach = 2 * (end - 1);
        let through = |block: &Range<usize>| Line::through(trend, &reached(block, reach, points));
        let lines = blocks.par_iter().map(through).collect();
        Self { phase, points, sizes: smallest..end, blocks, lines }
    }

    /// The sums with a sufficiently small error.
    fn trusted(&self) -> Vec<Option<f64>> {
        let (sums, error, rounding) = self.sums();
        let trusted = |sum: f64| {
            // Both comparisons are false for NaN.
            let exact = error <= TOLERANCE * sum;
            let is_rounding = error <= rounding && sum >= -error;
            (exact || is_rounding).then_some(sum.max(0.0))
        };
        sums.into_iter().map(|sum| trusted(sum.value())).collect()
    }

    /// The sums, the bound on their errors, and the effect of the rounding of the phase.
    fn sums(&self) -> (Vec<Sum>, f64, f64) {
        let parts: Vec<Part> = (0..self.blocks.len()).into_par_iter().map(|block| self.part(block)).collect();
        let mut sums = vec![Sum::default(); self.sizes.len()];
        let (mut error, mut rounding) = (0.0, 0.0);
        for part in parts {
            sums.iter_mut().zip(part.sums).for_each(|(sum, part_sum)| sum.add(part_sum));
            error += part.error;
            rounding += part.rounding;
        }
        (sums, error, rounding)
    }

    fn part(&self, block: usize) -> Part {
        let starts = self.blocks[block].clone();
        let lags = 2 * (self.sizes.end - 1) + 1;
        let reached = reached(&starts, lags - 1, self.points);
        let stretch = Stretch::new(self.phase, &reached, &self.lines[block]);
        let values = &stretch.values;
        let last = block + 1 == self.blocks.len();
        let (increments, (head, tail)) = join(
            || increments(values, starts.len(), lags),
            || {
                join(
                    || (block == 0).then(|| self.head(values)),
                    || last.then(|| self.head(&values.iter().rev().take(lags).copied().collect::<Vec<_>>())),
                )
            },
        );
        let mut sums: Vec<f64> =
            self.sizes.clone().map(|n| 4.0 * increments[n] - increments[2 * n]).collect();
        drop(increments);
        for end in [head, tail].into_iter().flatten() {
            sums.iter_mut().zip(end).for_each(|(sum, part)| *sum -= 2.0 * part);
        }
        if !last {
            let step = self.lines[block + 1].slope - self.lines[block].slope;
            self.add_border(&values[starts.len()..], step, &mut sums);
        }
        let squares: f64 = values.iter().map(|value| value * value).sum();
        // Each sum contains twice a correlation; weights are 4 + 1 for increments, 2 for the head and 2 for the tail.
        let error = TRANSFORM_ERROR
            * squares
            * (10.0 + if block == 0 { 4.0 } else { 0.0 } + if last { 4.0 } else { 0.0 });
        // The squared weights of the three points of a second difference are 1, 4 and 1.
        let rounding = 6.0 * stretch.rounding * stretch.rounding * starts.len() as f64;
        Part { sums, error, rounding }
    }

    /// Σ_{k<n} (x(k + n) − x(k))², for every size.
    fn head(&self, values: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.sizes.len()];
        triangle::head_products(values, self.sizes.start, &mut sums);
        // Each point before 2n is in exactly one of the squares.
        let (before, next) = values.split_at(2 * (self.sizes.start - 1));
        let mut squares = Sum::default();
        for value in before {
            squares.add(value * value);
        }
        for (sum, pair) in sums.iter_mut().zip(next.chunks_exact(2)) {
            squares.add(pair[0] * pair[0]);
            squares.add(pair[1] * pair[1]);
            *sum = squares.value() - 2.0 * *sum;
        }
        sums
    }

    /// Corrects the second differences across the end of a block for the line of the next block, which is
    /// steeper by `step`. `beyond` are the values after the end.
    fn add_border(&self, beyond: &[f64], step: f64, sums: &mut [f64]) {
        let (before, next) = beyond.split_at(2 * (self.sizes.start - 1));
        // Sums of the first n and of the first 2n values.
        let (mut half, mut whole) = (Sum::default(), Sum::default());
        for (k, value) in before.iter().enumerate() {
            whole.add(*value);
            if k < self.sizes.start - 1 {
                half.add(*value);
            }
        }
        for ((n, sum), pair) in self.sizes.clone().zip(sums).zip(next.chunks_exact(2)) {
            half.add(beyond[n - 1]);
            whole.add(pair[0]);
            whole.add(pair[1]);
            let delta = n as f64 * step;
            let differences = whole.value() - 2.0 * half.value();
            *sum += delta * (4.0 * differences - 2.0 * n as f64 * delta);
        }
    }
}

/// The points that second differences with a start in the block use.
fn reached(block: &Range<usize>, reach: usize, points: usize) -> Range<usize> {
    block.start..points.min(block.end + reach)
}

/// The sum of (x(j + l) − x(j))² over the first `starts` values, as far as x(j + l) exists, for each l below `lags`.
fn increments(values: &[f64], starts: usize, lags: usize) -> Vec<f64> {
    let mut sums = vec![0.0; lags];
    if starts == values.len() {
        correlation::auto(values, &mut sums);
    } else {
        correlation::cross(&values[..starts], values, &mut sums);
    }
    let square = |k: usize| values[k] * values[k];
    let mut squares = Sum::default();
    (0..starts).for_each(|k| squares.add(2.0 * square(k)));
    for (lag, sum) in sums.iter_mut().enumerate() {
        *sum = squares.value() - 2.0 * *sum;
        // For the next lag the first x(j + l) is removed, and either a new one is added or the last x(j) is removed too.
        squares.add(-square(lag));
        squares.add(values.get(starts + lag).map_or_else(|| -square(values.len() - lag - 1), |x| x * x));
    }
    sums
}
