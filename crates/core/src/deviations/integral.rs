//! The running sum of a phase, stored so that its third differences lose no digits.
//!
//! The phase is stored relative to the height of an anchor in each block. Its sum is stored relative to a
//! parabola: the sum of the straight line from the anchor of the block to the next anchor. Only the origins
//! of the parabolas are large, and they are stored with twice the usual precision.

use super::thirds::{Correction, Curve, third_of_sums};
use crate::compensated::{Sum, two_sum};
use crate::parallel::prelude::*;
use crate::phase::Phase;
use crate::points::Points;

/// The sums X(p) = Σ x(i), i < p, of a phase of N + 1 points: N + 2 of them, the first 0.
pub struct Integral {
    /// Points per parabola.
    block: usize,
    values: Points,
    parabolas: Vec<Parabola>,
}

/// Reference of the points of a block: height + slope·o + bend·o (o − 1) / 2 at the o-th point of the block.
#[derive(Clone, Copy, Default)]
struct Parabola {
    height: Sum,
    slope: Sum,
    bend: f64,
    /// Height of the first point after the block, relative to the parabola.
    end: f64,
}

impl Integral {
    /// Converts a phase, reusing its memory.
    pub fn of(phase: Phase) -> Self {
        let rises: Vec<f64> = (1..phase.anchors.len()).map(|block| phase.step_to(block)).collect();
        let Phase { block: length, mut values, anchors, .. } = phase;
        let of_block = |(block, points): (usize, &mut [f64])| {
            let rise = rises.get(block).copied().unwrap_or(points[points.len() - 1]);
            let bend = forty_bits(rise / points.len() as f64);
            Parabola { height: Sum::default(), slope: anchors[block], bend, end: sum(points, bend) }
        };
        let mut parabolas: Vec<Parabola> = values.par_chunks_mut(length).enumerate().map(of_block).collect();
        // There is one sum more than points of the phase: it is in the last block, or in a separate block.
        let last = parabolas[parabolas.len() - 1].end;
        if values.len() % length == 0 {
            values.push(0.0);
            parabolas.push(Parabola::default());
        } else {
            values.push(last);
        }
        for block in 1..parabolas.len() {
            let before = parabolas[block - 1];
            parabolas[block].height = before.at(length).plus(Sum { hi: before.end, lo: 0.0 });
        }
        Self { block: length, values, parabolas }
    }
}

/// Replaces the points of a block, minus their line, by their running sum, which excludes the point itself;
/// returns the total.
fn sum(points: &mut [f64], bend: f64) -> f64 {
    let mut running = Sum::default();
    for (i, point) in points.iter_mut().enumerate() {
        let (difference, before) = two_sum(*point, -bend * i as f64);
        *point = running.value();
        let (hi, after) = two_sum(running.hi, difference);
        // One addition to `lo` per point, because each addition waits for the previous one.
        running = Sum { hi, lo: running.lo + (before + after) };
    }
    running.value()
}

impl Parabola {
    /// Value at the o-th point.
    fn at(&self, o: usize) -> Sum {
        let pairs = (o * o.wrapping_sub(1) / 2) as f64;
        let o = o as f64;
        let (rise, curve) = (product(self.slope.hi, o), product(self.bend, pairs));
        let (hi, first) = two_sum(self.height.hi, rise.hi);
        let (hi, second) = two_sum(hi, curve.hi);
        let lo = (self.height.lo + rise.lo) + (self.slope.lo * o + curve.lo);
        Sum { hi, lo: lo + (first + second) }
    }
}

/// Reference of a window: the value, slope and half the bend of a parabola at its beginning.
#[derive(Clone, Copy)]
pub struct Frame {
    value: Sum,
    slope: Sum,
    bend: f64,
}

/// Combined contribution of the frames of four windows, which is a parabola too.
#[derive(Clone, Copy)]
pub struct Quadratic {
    value: f64,
    slope: f64,
    bend: f64,
}

impl Correction for Quadratic {
    #[inline(always)]
    #[allow(clippy::inline_always)] // The loop that calls it is only fast if this is inlined.
    fn at(self, index: f64) -> f64 {
        self.value + index * (self.slope + index * self.bend)
    }
}

impl Curve for Integral {
    type Origin = Frame;
    type Correction = Quadratic;

    fn values(&self) -> &[f64] {
        &self.values
    }

    fn block(&self) -> usize {
        self.block
    }

    fn origin(&self, point: usize) -> Frame {
        let parabola = self.parabolas[point / self.block];
        let o = point % self.block;
        Frame {
            value: parabola.at(o),
            slope: sum_of(parabola.slope, product(parabola.bend, o as f64 - 0.5)),
            bend: 0.5 * parabola.bend,
        }
    }

    fn correction(&self, frames: [Frame; 4]) -> Quadratic {
        let [x, y, z, w] = frames.map(|frame| frame.bend);
        Quadratic {
            value: third_of_sums(frames.map(|frame| frame.value)),
            slope: third_of_sums(frames.map(|frame| frame.slope)),
            bend: (w - x) + 3.0 * (y - z),
        }
    }

    fn lift(&self, point: usize, window: &mut [f64]) {
        let border = self.block - point % self.block;
        if border < window.len() {
            let (before, after) =
                (self.parabolas[point / self.block], self.parabolas[point / self.block + 1]);
            // `after` relative to `before`, from the first point of `after` on.
            let slope_before = before.slope.plus(product(before.bend, self.block as f64));
            let slope = after.slope.plus(slope_before.negated()).value();
            let bend = 0.5 * (after.bend - before.bend);
            for (o, value) in window[border..].iter_mut().enumerate() {
                let o = o as f64;
                *value += before.end + o * (slope + (o - 1.0) * bend);
            }
        }
    }
}

/// A number with its last 13 bits cleared, so that its products with numbers below 2¹³ are exact.
fn forty_bits(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & !0x1fff)
}

/// A product and its rounding error.
fn product(a: f64, b: f64) -> Sum {
    let hi = a * b;
    Sum { hi, lo: a.mul_add(b, -hi) }
}

/// Sum of two pairs, whose parts may overlap.
fn sum_of(a: Sum, b: Sum) -> Sum {
    let (hi, error) = two_sum(a.hi, b.hi);
    Sum { hi, lo: error + (a.lo + b.lo) }
}
