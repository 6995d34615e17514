//! Theo1, an estimator that reaches three quarters of the record: NIST SP 1065, section 5.2.15 (D. A. Howe and
//! T. K. Peppler, "Very long-term frequency stability: estimation using a special-purpose statistic", Proc. 2003 IEEE
//! Frequency Control Symposium).
//!
//! At τ = 0.75 m τ₀ it is the mean over i of Σ (x(i) − x(i + a) − x(i + m − a) + x(i + m))² / a, a = 1 … m / 2, over
//! 0.75 m². Each a is computed for all starts: (N + 1 − m) m / 2 terms for each size.

use super::lifted::copy_lifted;
use crate::compensated::Sum;
use crate::deviations::deviation::Deviation;
use crate::parallel::prelude::*;
use crate::phase::Phase;
use pulp::{Arch, Simd, WithSimd};

/// Starts handled together.
const STARTS: usize = 1024;
const LANES: usize = 8;

type Window = [f64; STARTS];

pub(super) fn theo1(phase: &Phase, m: &[usize]) -> Vec<Deviation> {
    m.iter().map(|&m| of_size(phase, m)).collect()
}

fn of_size(phase: &Phase, m: usize) -> Deviation {
    let starts = phase.samples() + 1 - m;
    let sums: Vec<Sum> = (0..starts.div_ceil(STARTS))
        .into_par_iter()
        .map(|block| of_block(phase, m, block * STARTS))
        .collect();
    let total = sums.into_iter().fold(Sum::default(), Sum::plus);
    let size = m as f64;
    let deviation = (total.value() / (0.75 * starts as f64)).sqrt() / size;
    Deviation { m, deviation, terms: starts * m / 2 }
}

/// Sum over the starts of a block. Their points are copied without the line from first to last, which has no
/// effect on a term; points beyond the record are 0, and their terms do not count.
fn of_block(phase: &Phase, m: usize, start: usize) -> Sum {
    let starts = STARTS.min(phase.samples() + 1 - m - start);
    let mut points = vec![0.0; m + STARTS];
    let used = m + starts;
    copy_lifted(phase, start, &mut points[..used]);
    let slope = (points[used - 1] - points[0]) / (used - 1) as f64;
    points[..used].iter_mut().enumerate().for_each(|(i, x)| *x -= slope * i as f64);

    let mut outer = [0.0; STARTS];
    for (k, outer) in outer[..starts].iter_mut().enumerate() {
        *outer = points[k] + points[k + m];
    }
    let mut sum = Sum::default();
    for a in 1..=m / 2 {
        let squares = if starts == STARTS {
            let at = |from: usize| -> &Window {
                points[from..].first_chunk().expect("m + STARTS points hold a window at any a")
            };
            Arch::new().dispatch(Squares { outer: &outer, near: at(a), far: at(m - a) })
        } else {
            squares(&outer[..starts], &points[a..], &points[m - a..])
        };
        sum.add(squares / a as f64);
    }
    sum.normalized()
}

struct Squares<'a> {
    outer: &'a Window,
    near: &'a Window,
    far: &'a Window,
}

impl WithSimd for Squares<'_> {
    type Output = f64;

    // Products and sums are not fused, so every processor gives the same bits.
    #[inline(always)]
    #[allow(clippy::inline_always)] // Inlined into a function that is compiled for the processor.
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        squares(self.outer, self.near, self.far)
    }
}

/// Σ (outer − near − far)².
#[inline(always)]
#[allow(clippy::inline_always)] // As above.
fn squares(outer: &[f64], near: &[f64], far: &[f64]) -> f64 {
    let mut lanes = [0.0; LANES];
    for ((outer, near), far) in outer.chunks(LANES).zip(near.chunks(LANES)).zip(far.chunks(LANES)) {
        for (lane, ((o, x), y)) in lanes.iter_mut().zip(outer.iter().zip(near).zip(far)) {
            let d = o - (x + y);
            *lane += d * d;
        }
    }
    lanes.iter().sum()
}
