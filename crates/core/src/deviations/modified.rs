//! The modified Allan variance: that of the phase averaged over m points, NIST SP 1065, eq. (15).
//!
//! The sum of m consecutive second differences of the phase is one third difference of its running sum
//! (C. A. Greenhall, "The third-difference approach to modified Allan variance", IEEE Trans. Instrum. Meas. 46(3), 1997,
//! doi 10.1109/19.585434), so that every term costs the same, however large m is.

use super::Deviation;
use super::integral::Integral;
use super::thirds::sums_of_squares;
use crate::allan::{Counting, Overlap, allan_variance};
use crate::phase::Phase;

/// All N + 2 − 3m terms.
pub(super) fn modified(phase: &Phase, m: &[usize]) -> Vec<Deviation> {
    let integral = Integral::new(phase);
    let sums = sums_of_squares(&integral, m);
    // With one sample to average over it is the Allan variance.
    let first = m.contains(&1).then(|| allan_variance(phase, &[1], Overlap::Full, Counting::Standard));
    let first = first.and_then(Result::ok).and_then(|estimates| estimates.first().map(|e| e.avar));
    let of_size = |(&m, sum): (&usize, f64)| {
        let (size, terms) = (m as f64, phase.samples() + 2 - 3 * m);
        let deviation = match first {
            Some(avar) if m == 1 => avar.sqrt(),
            _ => (sum / (2.0 * terms as f64)).sqrt() / (size * size),
        };
        Deviation { m, deviation, terms }
    };
    m.iter().zip(sums).map(of_size).collect()
}
