//! Tails of the χ² and the normal distribution, and functions for the gamma distribution of a mean of powers.

use crate::distributions::{gamma_above, gamma_below, gamma_quantile_above, normal_quantile};

pub(crate) use crate::distributions::digamma;

/// Probability that χ² with `freedom` degrees of freedom exceeds `x`; 1 for NaN.
pub(crate) fn chi2_above(x: f64, freedom: f64) -> f64 {
    if x > 0.0 { gamma_above(0.5 * freedom, 0.5 * x) } else { 1.0 }
}

/// Probability that χ² with `freedom` degrees of freedom is at most `x`; 0 for NaN.
pub(crate) fn chi2_below(x: f64, freedom: f64) -> f64 {
    if x > 0.0 { gamma_below(0.5 * freedom, 0.5 * x) } else { 0.0 }
}

/// The value that χ² with `freedom` degrees of freedom exceeds with a probability.
pub(crate) fn chi2_quantile_above(probability: f64, freedom: f64) -> f64 {
    2.0 * gamma_quantile_above(0.5 * freedom, probability)
}

/// The value that a standard normal deviate exceeds with a probability.
pub(crate) fn normal_quantile_above(probability: f64) -> f64 {
    -normal_quantile(probability.clamp(1e-300, 1.0 - 1e-16))
}

/// ψ′(x) for x > 0; Abramowitz & Stegun 6.4.12 after the recurrence 6.4.6.
pub(crate) fn trigamma(mut x: f64) -> f64 {
    let mut sum = 0.0;
    while x < 12.0 {
        sum += 1.0 / (x * x);
        x += 1.0;
    }
    let y = 1.0 / (x * x);
    let series = y * (1.0 / 6.0 - y * (1.0 / 30.0 - y * (1.0 / 42.0 - y * (1.0 / 30.0 - y * 5.0 / 66.0))));
    sum + (1.0 + 0.5 / x + series) / x
}

#[cfg(test)]
#[allow(clippy::unreadable_literal, clippy::excessive_precision)] // Digits as they were computed.
mod tests {
    use super::*;

    fn close(got: f64, expected: f64, tolerance: f64) {
        assert!((got - expected).abs() <= tolerance * expected.abs(), "{got} instead of {expected}");
    }

    #[test]
    fn known_answers() {
        // computed with 40 digits
        close(chi2_above(3.841458820694124, 1.0), 0.05, 1e-12);
        close(chi2_above(100.0, 3.0), 1.5541594313896026e-21, 1e-12);
        close(chi2_below(0.5, 4.0), 0.026499021160743926, 1e-12);
        close(chi2_quantile_above(1e-4, 10.0), 35.56401394195254, 1e-12);
        close(normal_quantile_above(0.025), 1.959963984540054, 1e-12);
        close(trigamma(0.5), 4.934802200544679, 1e-12);
        close(trigamma(30.25), 0.033_610_281_744_3, 1e-11);
    }
}
