//! Normal, gamma (χ²) and Student's t distributions: tails and quantiles with a relative error below 10⁻¹².
//!
//! Each tail is computed directly where it is small, so that neither loses digits in 1 − p. Quantiles solve
//! the logarithm of the smaller tail by Newton's method. Outside of its domain a function is NaN.

mod gamma;
mod student;

pub use gamma::{gamma_above, gamma_below, gamma_quantile, gamma_quantile_above};
pub use libm::lgamma as log_gamma;
pub use student::{student_below, student_quantile};

use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Coefficients B₂ₖ / (2k (2k − 1)) of Stirling's series for ln Γ; Abramowitz & Stegun 6.1.41.
const STIRLING: [f64; 8] = [
    1.0 / 12.0,
    -1.0 / 360.0,
    1.0 / 1260.0,
    -1.0 / 1680.0,
    1.0 / 1188.0,
    -691.0 / 360_360.0,
    1.0 / 156.0,
    -3617.0 / 122_400.0,
];

/// Argument above which the asymptotic series are exact to the last bit.
const ASYMPTOTIC_ABOVE: f64 = 10.0;

/// Newton step, relative to the solution, below which the error is less than the last bit.
const LAST_STEP: f64 = 1e-10;

/// Probability that a standard normal deviate is at most `z`.
#[must_use]
pub fn normal_below(z: f64) -> f64 {
    0.5 * libm::erfc(-z * FRAC_1_SQRT_2)
}

/// The value that a standard normal deviate does not exceed with a probability.
#[must_use]
pub fn normal_quantile(probability: f64) -> f64 {
    two_sided_quantile(probability, 1.0, |z| HalfLine {
        centre: 0.5 * libm::erf(z * FRAC_1_SQRT_2),
        tail: 0.5 * libm::erfc(z * FRAC_1_SQRT_2),
        density: (-0.5 * z * z).exp() / (2.0 * PI).sqrt(),
    })
}

/// ψ(x) = Γ′(x) / Γ(x) for x > 0, with a small relative error except near its zero at 1.46; Abramowitz &
/// Stegun 6.3.5, 6.3.18.
#[must_use]
pub fn digamma(x: f64) -> f64 {
    if x.is_nan() || x <= 0.0 {
        return f64::NAN;
    }
    let (mut x, mut sum) = (x, 0.0);
    while x < ASYMPTOTIC_ABOVE {
        sum -= 1.0 / x;
        x += 1.0;
    }
    // The derivative of Stirling's series, term by term.
    let y = 1.0 / (x * x);
    let series =
        STIRLING.iter().enumerate().rev().fold(0.0, |tail, (k, c)| tail * y + c * (2 * k + 1) as f64);
    sum + x.ln() - 0.5 / x - series * y
}

/// ln Γ(x) − ((x − ½) ln x − x + ½ ln 2π) for x ≥ [`ASYMPTOTIC_ABOVE`].
fn stirling(x: f64) -> f64 {
    let y = 1.0 / (x * x);
    STIRLING.iter().rev().fold(0.0, |sum, c| sum * y + c) / x
}

/// The excess of u − 1 over ln u, φ(u) = u − 1 − ln u, without cancellation, for u = 1 + `delta`.
fn above_log(u: f64, delta: f64) -> f64 {
    if !(-0.4..0.6).contains(&delta) {
        return delta - u.ln();
    }
    // With r = δ / (2 + δ): ln(1 + δ) = 2 (r + r³/3 + r⁵/5 + …), and δ − 2r = rδ.
    let r = delta / (2.0 + delta);
    let y = r * r;
    let sum = (0..14).rev().fold(0.0, |sum, k| sum * y + 1.0 / f64::from(2 * k + 3));
    r * (delta - 2.0 * y * sum)
}

/// A symmetric distribution on one side of its centre: the probabilities of 0 … x and of more than x, and the density at x.
struct HalfLine {
    centre: f64,
    tail: f64,
    density: f64,
}

/// Quantile of a distribution that is symmetric about 0. Near the centre it solves for the probability
/// between 0 and x.
fn two_sided_quantile(probability: f64, scale: f64, at: impl Fn(f64) -> HalfLine) -> f64 {
    if !(0.0..=1.0).contains(&probability) {
        return f64::NAN;
    }
    // Both differences are exact where they are used (Sterbenz's lemma).
    let tail = probability.min(1.0 - probability);
    let centre = (probability - 0.5).abs();
    let size = if tail == 0.0 {
        f64::INFINITY
    } else if centre == 0.0 {
        0.0
    } else if centre < 0.25 {
        solve(centre, centre * 2.5 * scale, true, |x| {
            let here = at(x);
            (here.centre, x * here.density)
        })
    } else {
        solve(tail, (-2.0 * tail.ln()).sqrt() * scale, false, |x| {
            let here = at(x);
            (here.tail, -x * here.density)
        })
    };
    if probability < 0.5 { -size } else { size }
}

/// The x > 0 where a monotone probability has a given value: Newton's method on its logarithm as a function
/// of ln x, between bounds.
///
/// `at` returns the probability and its derivative by ln x.
fn solve(target: f64, guess: f64, rising: bool, at: impl Fn(f64) -> (f64, f64)) -> f64 {
    let (mut low, mut high, mut x) = (0.0, f64::INFINITY, guess);
    for _ in 0..2000 {
        let (value, slope) = at(x);
        if (value > target) == rising {
            high = x;
        } else {
            low = x;
        }
        let step = -(value / target).ln() * value / slope;
        if step.abs() < LAST_STEP {
            return x + x * step.exp_m1(); // with one rounding
        }
        let newton = x * step.exp();
        x = if newton > low && newton < high {
            newton
        } else if high.is_infinite() {
            x * 4.0
        } else if low == 0.0 {
            x / 4.0
        } else {
            low.sqrt() * high.sqrt()
        };
        // The solution is out of the range of floats, or between two neighbouring ones.
        if x == 0.0 || x.is_infinite() || x <= low || x >= high {
            break;
        }
    }
    x
}

#[cfg(test)]
mod tests;
