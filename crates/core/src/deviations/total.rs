//! The total variance: second differences of the phase extended at both ends by its reflection, so that long averaging
//! times have as many terms as short ones: NIST SP 1065, section 5.2.11.
//!
//! With x*(−j) = 2x(0) − x(j) and x*(N + j) = 2x(N) − x(N − j), it is the mean of the N − 1 squared second differences
//! x*(i − m) − 2x(i) + x*(i + m), 0 < i < N, over 2τ². Those that need no reflection are the terms of the Allan variance.

use super::lifted::copy_lifted;
use crate::allan::{Counting, Overlap, allan_variance};
use crate::compensated::Sum;
use crate::deviations::deviation::Deviation;
use crate::error::Error;
use crate::parallel::prelude::*;
use crate::phase::Phase;

/// Terms handled together.
const RUN: usize = 512;

pub(super) fn total(phase: &Phase, m: &[usize]) -> Result<Vec<Deviation>, Error> {
    let n = phase.samples();
    let inside: Vec<usize> = m.iter().copied().filter(|&m| 2 * m <= n).collect();
    let estimates = if inside.is_empty() {
        Vec::new()
    } else {
        allan_variance(phase, &inside, Overlap::Full, Counting::Standard)?
    };
    let of_size = |&m: &usize| {
        let size = m as f64;
        let whole = estimates.iter().find(|estimate| estimate.m == m);
        let mut sum = Sum::default();
        sum.add(whole.map_or(0.0, |e| e.avar * 2.0 * size * size * e.pairs as f64));
        if whole.is_some() {
            add_reflected(phase, m, 1..m, &mut sum);
            add_reflected(phase, m, n - m + 1..n, &mut sum);
        } else {
            add_reflected(phase, m, 1..n, &mut sum);
        }
        let terms = n - 1;
        Deviation { m, deviation: (sum.value() / (2.0 * terms as f64)).sqrt() / size, terms }
    };
    Ok(m.par_iter().map(of_size).collect())
}

/// Adds the squared terms of a range of points that have at least one reflected neighbour.
fn add_reflected(phase: &Phase, m: usize, range: std::ops::Range<usize>, sum: &mut Sum) {
    let n = phase.samples();
    let end = point(phase, n);
    let mut scratch = [[0.0; RUN]; 3];
    // Points are divided into runs with the same reflections.
    let borders =
        [range.start, m.clamp(range.start, range.end), (n + 1 - m).clamp(range.start, range.end), range.end];
    let mut cuts = borders;
    cuts.sort_unstable();
    for pair in cuts.windows(2) {
        let mut from = pair[0];
        while from < pair[1] {
            let count = RUN.min(pair[1] - from);
            let last = from + count - 1;
            let [before, middle, after] = &mut scratch;
            let (before, middle, after) = (&mut before[..count], &mut middle[..count], &mut after[..count]);
            let mut height = copy_lifted(phase, from, middle).doubled().negated();
            if from < m {
                // 2x(0) − x(m − i), and x(0) = 0.
                height = height.plus(copy_lifted(phase, m - last, before).negated());
                turn(before);
            } else {
                height = height.plus(copy_lifted(phase, from - m, before));
            }
            if last + m > n {
                height = height.plus(end.doubled());
                height = height.plus(copy_lifted(phase, 2 * n - m - last, after).negated());
                turn(after);
            } else {
                height = height.plus(copy_lifted(phase, from + m, after));
            }
            let height = height.value();
            let mut squares = 0.0;
            for ((x, y), z) in before.iter().zip(middle.iter()).zip(after.iter()) {
                let d = (x - y) + (z - y) + height;
                squares += d * d;
            }
            sum.add(squares);
            from += count;
        }
    }
}

/// Reflects a stretch.
fn turn(points: &mut [f64]) {
    points.reverse();
    for x in points {
        *x = -*x;
    }
}

fn point(phase: &Phase, k: usize) -> Sum {
    phase.anchors[k / phase.block].plus(Sum { hi: phase.values[k], lo: 0.0 })
}
