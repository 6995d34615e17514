//! Tails of the χ² and the normal distribution, and the functions behind the gamma law of a mean of powers.

use statrs::function::erf::erfc_inv;
use statrs::function::gamma::{gamma_lr, gamma_ur};

pub(crate) use statrs::function::gamma::digamma;

/// Degrees of freedom beyond which the cube root of χ² is taken as normal (Wilson and Hilferty 1931): its error is then
/// below 1e-7 of the deviate.
const NEARLY_NORMAL: f64 = 1e5;

/// Probability that χ² with `freedom` degrees of freedom exceeds `x`.
pub(crate) fn chi2_above(x: f64, freedom: f64) -> f64 {
    if !x.is_finite() {
        return if x > 0.0 { 0.0 } else { 1.0 };
    }
    if x <= 0.0 {
        return 1.0;
    }
    if freedom > NEARLY_NORMAL {
        return normal_above(cube_root_deviate(x, freedom));
    }
    gamma_ur(0.5 * freedom, 0.5 * x)
}

/// Probability that χ² with `freedom` degrees of freedom is at most `x`.
pub(crate) fn chi2_below(x: f64, freedom: f64) -> f64 {
    if !x.is_finite() {
        return if x > 0.0 { 1.0 } else { 0.0 };
    }
    if x <= 0.0 {
        return 0.0;
    }
    if freedom > NEARLY_NORMAL {
        return normal_above(-cube_root_deviate(x, freedom));
    }
    gamma_lr(0.5 * freedom, 0.5 * x)
}

/// The value that χ² with `freedom` degrees of freedom exceeds with a probability.
pub(crate) fn chi2_quantile_above(probability: f64, freedom: f64) -> f64 {
    // Wilson and Hilferty's value is within some per cent: bisection of the logarithm from there.
    let scale = 2.0 / (9.0 * freedom);
    let guess = freedom * (1.0 - scale + normal_quantile_above(probability) * scale.sqrt()).max(0.01).powi(3);
    let (mut low, mut high) = (guess.ln() - 1.0, guess.ln() + 1.0);
    while chi2_above(low.exp(), freedom) < probability {
        low -= 1.0;
    }
    while chi2_above(high.exp(), freedom) > probability {
        high += 1.0;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if chi2_above(middle.exp(), freedom) > probability {
            low = middle;
        } else {
            high = middle;
        }
        if high - low < 1e-12 {
            break;
        }
    }
    (0.5 * (low + high)).exp()
}

/// Probability that a standard normal deviate exceeds `z`.
pub(crate) fn normal_above(z: f64) -> f64 {
    if z == 0.0 {
        return 0.5;
    }
    let tail = 0.5 * gamma_ur(0.5, 0.5 * z * z);
    if z > 0.0 { tail } else { 1.0 - tail }
}

/// The value that a standard normal deviate exceeds with a probability.
pub(crate) fn normal_quantile_above(probability: f64) -> f64 {
    std::f64::consts::SQRT_2 * erfc_inv(2.0 * probability.clamp(1e-300, 1.0 - 1e-16))
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

fn cube_root_deviate(x: f64, freedom: f64) -> f64 {
    let scale = 2.0 / (9.0 * freedom);
    ((x / freedom).cbrt() - (1.0 - scale)) / scale.sqrt()
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
        // With 40 digits.
        close(chi2_above(3.841458820694124, 1.0), 0.05, 1e-12);
        close(chi2_above(100.0, 3.0), 1.5541594313896026e-21, 1e-8);
        close(chi2_below(0.5, 4.0), 0.026499021160743926, 1e-12);
        close(chi2_quantile_above(1e-4, 10.0), 35.56401394195254, 1e-10);
        close(normal_quantile_above(0.025), 1.959963984540054, 1e-10);
        close(trigamma(0.5), 4.934802200544679, 1e-12);
        close(trigamma(30.25), 0.03361028174434329, 1e-12);
    }

    #[test]
    fn many_degrees_of_freedom_join() {
        let x = NEARLY_NORMAL + 900.0;
        close(chi2_above(x, NEARLY_NORMAL * 1.000_000_1), chi2_above(x, NEARLY_NORMAL), 1e-3);
    }
}
