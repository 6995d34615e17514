//! Changes of a phase: MTIE, the largest range of the phase within any window of m + 1 points, and TIE rms, the root mean
//! square of x(k + m) − x(k): NIST SP 1065, sections 5.2.13 and 5.2.14 (ITU-T G.810 for MTIE).
//!
//! Both depend on the constant rate, which the stored phase lacks; it is recovered from the rates.

use super::lifted::copy_lifted;
use crate::compensated::Sum;
use crate::deviations::deviation::Deviation;
use crate::parallel::prelude::*;
use crate::phase::Phase;

/// Number of starts that are handled together; results do not depend on their division between threads.
const RUN: usize = 1024;

/// Root mean square of the N + 1 − m differences of the phase.
pub(super) fn tie_rms(phase: &Phase, m: &[usize]) -> Vec<Deviation> {
    let slope = phase.slope;
    let of_size = |&m: &usize| {
        let terms = phase.samples() + 1 - m;
        let sums: Vec<f64> = (0..terms.div_ceil(RUN))
            .into_par_iter()
            .map(|run| {
                let mut moves = [0.0; RUN];
                let count = RUN.min(terms - run * RUN);
                moves_of(phase, slope, run * RUN, m, &mut moves[..count]);
                sum_of_squares(&moves[..count])
            })
            .collect();
        let mut sum = Sum::default();
        for squares in sums {
            sum.add(squares);
        }
        Deviation { m, deviation: (sum.value() / terms as f64).sqrt(), terms }
    };
    m.iter().map(of_size).collect()
}

fn sum_of_squares(values: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    for chunk in values.chunks(8) {
        lanes.iter_mut().zip(chunk).for_each(|(lane, x)| *lane += x * x);
    }
    lanes.iter().sum()
}

/// x(k + m) − x(k) for the starts k beginning with `from`.
fn moves_of(phase: &Phase, slope: f64, from: usize, m: usize, moves: &mut [f64]) {
    let mut first = [0.0; RUN];
    let first = &mut first[..moves.len()];
    let anchor = copy_lifted(phase, from, first);
    let height = copy_lifted(phase, from + m, moves).plus(anchor.negated());
    let drift = Sum { hi: slope * m as f64, lo: 0.0 };
    let height = height.plus(drift).value();
    moves.iter_mut().zip(first).for_each(|(z, x)| *z = (*z - *x) + height);
}

/// Largest range over all N + 1 − m windows.
///
/// The rise and fall of the phase within p steps of each start are computed for p = 1, 2, 4 …, each from the
/// previous one; two such windows cover a window of p ≤ m < 2p steps. This takes N operations per octave and
/// per size.
pub(super) fn mtie(phase: &Phase, m: &[usize]) -> Vec<Deviation> {
    let slope = phase.slope;
    let n = phase.samples();
    let mut peaks = vec![0.0; m.len()];
    let mut extremes: Vec<(f64, f64)> = vec![(0.0, 0.0); n];
    extremes.par_chunks_mut(RUN).enumerate().for_each(|(run, chunk)| {
        let mut moves = [0.0; RUN];
        let moves = &mut moves[..chunk.len()];
        moves_of(phase, slope, run * RUN, 1, moves);
        for (extreme, step) in chunk.iter_mut().zip(moves) {
            *extreme = (step.max(0.0), step.min(0.0));
        }
    });
    let mut p = 1;
    let largest = m.iter().copied().max().unwrap_or(0);
    while p <= largest {
        for (peak, &m) in peaks.iter_mut().zip(m).filter(|(_, m)| (p..2 * p).contains(*m)) {
            let ranges: Vec<f64> = (0..(n + 1 - m).div_ceil(RUN))
                .into_par_iter()
                .map(|run| {
                    let from = run * RUN;
                    let count = RUN.min(n + 1 - m - from);
                    let mut range = 0.0;
                    widened(phase, slope, &extremes, (from, count), m - p, |_, (high, low)| {
                        range = f64::max(range, high - low);
                    });
                    range
                })
                .collect();
            *peak = ranges.into_iter().fold(0.0, f64::max);
        }
        if 2 * p <= largest {
            let mut wider = vec![(0.0, 0.0); n + 1 - 2 * p];
            wider.par_chunks_mut(RUN).enumerate().for_each(|(run, chunk)| {
                let count = chunk.len();
                widened(phase, slope, &extremes, (run * RUN, count), p, |k, extreme| chunk[k] = extreme);
            });
            extremes = wider;
        }
        p *= 2;
    }
    m.iter().zip(peaks).map(|(&m, peak)| Deviation { m, deviation: peak, terms: n + 1 - m }).collect()
}

/// Largest rise and fall within the union of the window of each start and the window `shift` later.
fn widened(
    phase: &Phase,
    slope: f64,
    extremes: &[(f64, f64)],
    (from, count): (usize, usize),
    shift: usize,
    mut visit: impl FnMut(usize, (f64, f64)),
) {
    let mut moves = [0.0; RUN];
    let moves = &mut moves[..count];
    if shift > 0 {
        moves_of(phase, slope, from, shift, moves);
    }
    let here = &extremes[from..from + count];
    let there = &extremes[from + shift..from + shift + count];
    for (k, ((&(high, low), &(later_high, later_low)), step)) in here.iter().zip(there).zip(moves).enumerate()
    {
        visit(k, (high.max(later_high + *step), low.min(later_low + *step)));
    }
}
