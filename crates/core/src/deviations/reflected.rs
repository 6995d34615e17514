//! The modified total and the Hadamard total variance: NIST SP 1065, sections 5.2.12 and 5.2.14.
//!
//! Each stretch of 3m points (of the phase; of the rate for the Hadamard total variance) loses the slope between the means of
//! its halves, and is continued by its reflection at both ends, as an even function of period 6m. The variance is the mean
//! over all stretches of the mean square of the second differences of its means over m points, over a whole period.
//!
//! These differences are third differences of the running sum S of the stretch. If the mean of the stretch is subtracted, S
//! is odd at both ends of the stretch, S(−b) = −S(b) and S(3m + b) = −S(3m − b), so that half a period is enough. A stretch
//! takes about 12m steps, all of them N·m for each m.

use super::hadamard;
use super::lifted::copy_lifted;
use super::parabolic::{remove_line, running};
use crate::compensated::Sum;
use crate::deviations::deviation::Deviation;
use crate::parallel::prelude::*;
use crate::phase::Phase;
use pulp::{Arch, Simd, WithSimd};

/// Smallest number of stretches handled together. More than m of them would lose digits in the running sum.
const RUN: usize = 64;
const LANES: usize = 8;

/// N + 2 − 3m stretches of the phase.
pub(super) fn modified_total(phase: &Phase, m: &[usize]) -> Vec<Deviation> {
    let of_size = |&m: &usize| {
        let stretches = phase.samples() + 2 - 3 * m;
        let copy = |start: usize, points: &mut [f64]| {
            copy_lifted(phase, start, points);
        };
        let square = mean_square(&copy, m, stretches);
        Deviation { m, deviation: (square / 2.0).sqrt() / m as f64, terms: stretches }
    };
    m.iter().map(of_size).collect()
}

/// N + 1 − 3m stretches of the rate. For m = 1 it is the Hadamard variance, as in the programs that have it (W. J. Riley,
/// "The Hadamard total variance", 1999).
pub(super) fn hadamard_total(phase: &Phase, rate: &[f64], m: &[usize]) -> Vec<Deviation> {
    let of_size = |&m: &usize| {
        if m == 1 {
            return hadamard::overlapping(phase, &[1])[0];
        }
        let stretches = rate.len() + 1 - 3 * m;
        let copy =
            |start: usize, points: &mut [f64]| points.copy_from_slice(&rate[start..start + points.len()]);
        let square = mean_square(&copy, m, stretches);
        Deviation { m, deviation: (square / 6.0).sqrt(), terms: stretches }
    };
    m.iter().map(of_size).collect()
}

/// Mean over all stretches, and over the 6m means of each, of the squared second difference.
fn mean_square(copy: &(impl Fn(usize, &mut [f64]) + Sync), m: usize, stretches: usize) -> f64 {
    let run = m.max(RUN);
    let of_block = |block: usize| {
        let start = block * run;
        let count = run.min(stretches - start);
        let mut points = vec![0.0; count + 3 * m - 1];
        copy(start, &mut points);
        remove_line(&mut points);
        let area = running(points.into_iter());
        let mut folded = vec![0.0; 2 * reach(m) + 3 * m + 1];
        let mut sum = Sum::default();
        for first in 0..count {
            let stretch = Stretch { area: &area[first..=first + 3 * m], m, folded: &mut folded };
            sum.add(Arch::new().dispatch(stretch));
        }
        sum.normalized()
    };
    let sums: Vec<Sum> = (0..stretches.div_ceil(run)).into_par_iter().map(of_block).collect();
    let size = m as f64;
    sums.into_iter().fold(Sum::default(), Sum::plus).value() / (6.0 * size.powi(3) * stretches as f64)
}

/// Largest shift of a third difference from the stretch: half a period has the shifts −1.5m … 1.5m.
fn reach(m: usize) -> usize {
    3 * m / 2
}

/// The running sum of a stretch, 3m + 1 points, and space for its reflections.
struct Stretch<'a> {
    area: &'a [f64],
    m: usize,
    folded: &'a mut [f64],
}

impl WithSimd for Stretch<'_> {
    type Output = f64;

    // Products and sums are not fused, so every processor gives the same bits.
    #[inline(always)]
    #[allow(clippy::inline_always)] // Inlined into a function that is compiled for the processor.
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let Self { area, m, folded } = self;
        let (length, reach) = (3 * m, reach(m));
        let half = length / 2;
        let first = area[0];
        let slope =
            ((area[length] - area[length - half]) - (area[half] - first)) / (half * (length - half)) as f64;
        let mean = (area[length] - first) / length as f64;
        let (before, rest) = folded.split_at_mut(reach);
        let (inside, after) = rest.split_at_mut(length + 1);
        for (a, (inside, area)) in inside.iter_mut().zip(area).enumerate() {
            let a = a as f64;
            *inside = (area - first) - a * (mean + 0.5 * slope * (a - length as f64));
        }
        before.iter_mut().rev().zip(&inside[1..]).for_each(|(folded, s)| *folded = -s);
        after.iter_mut().zip(inside.iter().rev().skip(1)).for_each(|(folded, s)| *folded = -s);
        // Shifts by −reach … reach.
        let count = 2 * reach + 1;
        let part = |from: usize| &folded[from..from + count];
        let (x, y, z, w) = (part(0), part(m), part(2 * m), part(length));
        let difference = |k: usize| (w[k] - x[k]) + 3.0 * (y[k] - z[k]);
        let mut lanes = [0.0; LANES];
        let whole = count / LANES * LANES;
        for k in (0..whole).step_by(LANES) {
            for (lane, sum) in lanes.iter_mut().enumerate() {
                let d = difference(k + lane);
                *sum += d * d;
            }
        }
        for k in whole..count {
            lanes[k - whole] += difference(k) * difference(k);
        }
        // If m is even, both ends are their own mirror images.
        let ends = if m % 2 == 0 { difference(0).powi(2) + difference(count - 1).powi(2) } else { 0.0 };
        2.0 * lanes.iter().sum::<f64>() - ends
    }
}
