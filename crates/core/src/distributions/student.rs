//! Student's t distribution, through the incomplete beta function.

use super::{ASYMPTOTIC_ABOVE, HalfLine, above_log, stirling, two_sided_quantile};
use std::f64::consts::PI;

/// Probability that Student's t with `freedom` degrees of freedom is at most `t`.
#[must_use]
pub fn student_below(freedom: f64, t: f64) -> f64 {
    let half = half_line(freedom, t.abs());
    if t < 0.0 { half.tail } else { 1.0 - half.tail }
}

/// The value that Student's t with `freedom` degrees of freedom does not exceed with a probability.
#[must_use]
pub fn student_quantile(freedom: f64, probability: f64) -> f64 {
    if freedom.is_nan() || freedom <= 0.0 {
        return f64::NAN;
    }
    two_sided_quantile(probability, 1.0 + 1.0 / freedom, |t| half_line(freedom, t))
}

/// With r² = t² / ν, x = 1 / (1 + r²) and y = 1 − x the tail is Iₓ(ν/2, ½) / 2 and the centre 1 − Iₓ(ν/2, ½) over 2; DLMF
/// 8.17.
fn half_line(freedom: f64, t: f64) -> HalfLine {
    if freedom.is_nan() || t.is_nan() || freedom <= 0.0 {
        return HalfLine { centre: f64::NAN, tail: f64::NAN, density: f64::NAN };
    }
    let a = 0.5 * freedom;
    let r = t / freedom.sqrt();
    let hypotenuse = r.hypot(1.0);
    let (x, y) = ((1.0 / hypotenuse).powi(2), (r / hypotenuse).powi(2));
    let log_x = if r > 1e8 { -2.0 * r.ln() } else { -(r * r).ln_1p() };
    // t times the density, which is also xᵃ √y / B(a, ½).
    let common = (a * log_x).exp() * (r / hypotenuse) * gamma_ratio(a) / PI.sqrt();
    let (centre, tail) = if t.is_infinite() {
        (0.5, 0.0)
    } else if x < (a + 1.0) / (a + 2.5) {
        let tail = 0.5 * common * fraction(a, 0.5, x, y);
        (0.5 - tail, tail)
    } else {
        let centre = 0.5 * common * fraction(0.5, a, y, x);
        (centre, 0.5 - centre)
    };
    HalfLine { centre, tail, density: common / t }
}

/// Γ(a + ½) / Γ(a).
fn gamma_ratio(a: f64) -> f64 {
    let (mut a, mut factor) = (a, 1.0);
    while a < ASYMPTOTIC_ABOVE {
        factor *= a / (a + 0.5);
        a += 1.0;
    }
    factor * a.sqrt() * (stirling(a + 0.5) - stirling(a) - a * above_log(1.0 + 0.5 / a, 0.5 / a)).exp()
}

/// The continued fraction of the incomplete beta function over xᵃ yᵇ / B(a, b), y = 1 − x; for x below or
/// near its mean.
///
/// Didonato and Morris, ACM Transactions on Mathematical Software 18(3), 1992, eq. (9): free of cancellation
/// if x is nearly 0 or 1.
fn fraction(a: f64, b: f64, x: f64, y: f64) -> f64 {
    let lambda = if a > b { (a + b) * y - b } else { a - (a + b) * x };
    let mut c = f64::INFINITY;
    let mut d = (a + 1.0) / (a * (lambda + 1.0));
    let mut value = d;
    for n in 1..100_000 {
        let n = f64::from(n);
        let odd = a + 2.0 * n - 1.0;
        let alpha = (a + n - 1.0) * (a + b + n - 1.0) * n * (b - n) * (x / odd).powi(2);
        let beta = n + n * (b - n) * x / odd + (a + n) * (lambda + 1.0 + n * (1.0 + y)) / (odd + 2.0);
        d = 1.0 / (alpha * d + beta);
        c = beta + alpha / c;
        let factor = c * d;
        value *= factor;
        if (factor - 1.0).abs() < f64::EPSILON {
            break;
        }
    }
    value
}
