//! The modified Allan variance, from the phase averaged over m points: NIST SP 1065, eq. (15).
//!
//! The sum of m consecutive second differences of the phase is one third difference of its running sum
//! (C. A. Greenhall, "The third-difference approach to modified Allan variance", IEEE Trans. Instrum. Meas.
//! 46(3), 1997, doi 10.1109/19.585434), so that the cost of a term does not depend on m.

use super::integral::Integral;
use super::thirds::sums_of_squares;
use crate::compensated::Sum;
use crate::deviations::deviation::Deviation;
use crate::error::Error;
use crate::phase::{LARGEST_RATE, Phase};

/// Largest number of points per origin of the sum of the phase, which grows faster than the phase.
const BLOCK: usize = 4096;

/// All N + 2 − 3m terms.
pub(super) fn modified(rate: &[f64], m: &[usize]) -> Result<Vec<Deviation>, Error> {
    let mut phase = Phase::default();
    phase.fill(rate, LARGEST_RATE, BLOCK)?;
    let integral = Integral::of(phase);
    let sums = sums_of_squares(&integral, m);
    let of_size = |(&m, sum): (&usize, f64)| {
        let (size, terms) = (m as f64, rate.len() + 2 - 3 * m);
        // For m = 1 it is the Allan variance, and needs no sum.
        let sum = if m == 1 { steps(rate) } else { sum };
        Deviation { m, deviation: (sum / (2.0 * terms as f64)).sqrt() / (size * size), terms }
    };
    Ok(m.iter().zip(sums).map(of_size).collect())
}

/// Σ (y(k + 1) − y(k))².
fn steps(rate: &[f64]) -> f64 {
    const LANES: usize = 8;
    let later = rate.get(1..).unwrap_or_default();
    let mut sum = Sum::default();
    for (before, after) in rate.chunks(BLOCK).zip(later.chunks(BLOCK)) {
        let mut lanes = [0.0; LANES];
        for (before, after) in before.chunks(LANES).zip(after.chunks(LANES)) {
            for (lane, (x, y)) in lanes.iter_mut().zip(before.iter().zip(after)) {
                *lane += (y - x) * (y - x);
            }
        }
        for lane in lanes {
            sum.add(lane);
        }
    }
    sum.value()
}
