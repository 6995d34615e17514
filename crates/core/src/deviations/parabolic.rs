//! The parabolic variance: the mean squared difference of the slopes that two lines, fitted by least squares to adjacent
//! clusters of m points of the phase, have: F. Vernotte, M. Lenczner, P.-Y. Bourgeois, E. Rubiola, "The parabolic variance
//! (PVAR), a wavelet variance based on the least-square fit", IEEE Trans. UFFC 63(4), 2016.
//!
//! It is 72 / (m⁶ τ₀²) times the mean over i of [Σ ((m − 1)/2 − k) (x(i + k) − x(i + m + k))]², 0 ≤ k < m. The weighted sums
//! of a cluster are differences of the running sums of x(j) and j·x(j), so that the cost of a term does not depend on m.
//! Running sums begin anew in each block of m starts: over a longer block they would lose digits.

use super::lifted::copy_lifted;
use crate::allan::{Counting, Overlap, allan_variance};
use crate::compensated::Sum;
use crate::deviations::deviation::Deviation;
use crate::error::Error;
use crate::parallel::prelude::*;
use crate::phase::Phase;

/// Cluster size below which the weighted sums are computed directly.
const SHORT: usize = 32;

/// Starts handled together below that size.
const RUN: usize = 512;

/// N + 1 − 2m terms, as in the publication; it is the Allan variance for m = 1.
pub(super) fn parabolic(phase: &Phase, m: &[usize]) -> Result<Vec<Deviation>, Error> {
    let of_size = |&m: &usize| {
        let terms = phase.samples() + 1 - 2 * m;
        if m == 1 {
            let estimate = allan_variance(phase, &[1], Overlap::Full, Counting::Standard)?;
            return Ok(Deviation { m, deviation: estimate[0].avar.sqrt(), terms });
        }
        let run = if m < SHORT { RUN } else { m };
        let sums: Vec<Sum> = (0..terms.div_ceil(run))
            .into_par_iter()
            .map(|block| squares_of_block(phase, m, block * run, run.min(terms - block * run)))
            .collect();
        let sum = sums.into_iter().fold(Sum::default(), Sum::plus);
        Ok(Deviation { m, deviation: (72.0 * sum.value() / terms as f64).sqrt() / (m as f64).powi(3), terms })
    };
    m.iter().map(of_size).collect()
}

/// Sum of the squared terms of consecutive starts. The line from the first point to the last one has no effect on a term.
fn squares_of_block(phase: &Phase, m: usize, start: usize, starts: usize) -> Sum {
    let mut points = vec![0.0; starts + 2 * m - 1];
    copy_lifted(phase, start, &mut points);
    remove_line(&mut points);
    let half = (m - 1) as f64 / 2.0;
    let mut sum = Sum::default();
    if m < SHORT {
        let mut terms = vec![0.0; starts];
        for k in 0..m {
            let weight = half - k as f64;
            let pairs = points[k..].iter().zip(&points[k + m..]);
            terms.iter_mut().zip(pairs).for_each(|(term, (x, y))| *term += weight * (x - y));
        }
        for term in terms {
            sum.add(term * term);
        }
        return sum.normalized();
    }
    let area = running(points.iter().copied());
    let moment = running(points.iter().enumerate().map(|(j, x)| j as f64 * x));
    let weighted = |i: usize| (half + i as f64) * (area[i + m] - area[i]) - (moment[i + m] - moment[i]);
    for i in 0..starts {
        let term = weighted(i) - weighted(i + m);
        sum.add(term * term);
    }
    sum.normalized()
}

/// Running sums, the first one 0.
pub(super) fn running(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sum = 0.0;
    std::iter::once(0.0)
        .chain(values.map(|x| {
            sum += x;
            sum
        }))
        .collect()
}

/// Subtracts the line from the first point to the last one.
pub(super) fn remove_line(points: &mut [f64]) {
    let first = points[0];
    let slope = (points[points.len() - 1] - first) / (points.len() - 1).max(1) as f64;
    points.iter_mut().enumerate().for_each(|(i, x)| *x = (*x - first) - slope * i as f64);
}
