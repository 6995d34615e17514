//! A stretch of the phase minus a straight line, so that the remainder is small.

use crate::compensated::Sum;
use crate::phase::Phase;
use crate::trend::Trend;
use std::ops::Range;

/// A straight line through a stretch of the phase.
#[derive(Debug, Clone, Copy)]
pub struct Line {
    /// Height at the first point of the stretch.
    height: Sum,
    /// Slope per sample.
    pub slope: f64,
}

impl Line {
    /// The line through the means of the first and the last third, so that no single point has a large
    /// weight.
    pub fn through(trend: &Trend, points: &Range<usize>) -> Self {
        let third = (points.len() / 3).max(1);
        let mean = |start: usize| {
            let sum = trend.first(start + third).plus(trend.first(start).negated());
            // Rounding of the mean shifts the line, which has no effect on second differences.
            Sum { hi: sum.hi / third as f64, lo: sum.lo / third as f64 }
        };
        let last = points.end - third;
        if last == points.start {
            return Self { height: mean(points.start), slope: 0.0 };
        }
        let (low, high) = (mean(points.start), mean(last));
        let slope = high.plus(low.negated()).value() / (last - points.start) as f64;
        let to_middle = 0.5 * (third - 1) as f64;
        Self { height: low.plus(product(slope, to_middle).negated()), slope }
    }
}

/// Points of the phase minus a line.
pub struct Stretch {
    pub values: Vec<f64>,
    /// Largest error of the values from the rounding of the phase.
    pub rounding: f64,
}

impl Stretch {
    /// The phase at `points` minus a line through them.
    ///
    /// The anchors, which are large numbers, are combined with the line in twice the usual precision, once
    /// per block.
    pub fn new(phase: &Phase, points: &Range<usize>, line: &Line) -> Self {
        let mut values = Vec::with_capacity(points.len());
        let mut largest: f64 = 0.0;
        let mut start = points.start;
        while start < points.end {
            let block = start / phase.block;
            let end = points.end.min((block + 1) * phase.block);
            let on_line = line.height.plus(product(line.slope, (start - points.start) as f64));
            let base = phase.anchors[block].plus(on_line.negated()).value();
            for (offset, &value) in phase.values[start..end].iter().enumerate() {
                values.push((value - line.slope * offset as f64) + base);
                largest = largest.max(value.abs());
            }
            start = end;
        }
        // Each of value, line and their difference is rounded once.
        let rounding = f64::EPSILON * (largest + line.slope.abs() * phase.block as f64);
        Self { values, rounding }
    }
}

/// A product of two floats, and its rounding error.
fn product(a: f64, b: f64) -> Sum {
    let hi = a * b;
    Sum { hi, lo: a.mul_add(b, -hi) }
}
