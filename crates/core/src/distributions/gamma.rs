//! The gamma distribution with scale 1: regularised incomplete gamma functions and their inverses.

use super::{ASYMPTOTIC_ABOVE, above_log, normal_quantile, solve, stirling};
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Shape above which Temme's uniform expansion is used: series and fraction need up to 7 √shape terms.
const UNIFORM_ABOVE: f64 = 1e4;

/// Powers of 1 / shape in Temme's expansion; the next one is 10⁻²⁰.
const ORDERS: usize = 5;

/// Number of powers of η per order. Probabilities above 10⁻³²⁴ have |η| < 0.4, and the series converge for
/// |η| < 3.5.
const POWERS: usize = 20;

/// Probability that a gamma variate is at most `x`: P(a, x).
#[must_use]
pub fn gamma_below(shape: f64, x: f64) -> f64 {
    tails(shape, x).0
}

/// Probability that a gamma variate exceeds `x`: Q(a, x).
#[must_use]
pub fn gamma_above(shape: f64, x: f64) -> f64 {
    tails(shape, x).1
}

/// The value that a gamma variate does not exceed with a probability.
#[must_use]
pub fn gamma_quantile(shape: f64, probability: f64) -> f64 {
    if probability > 0.5 {
        quantile(shape, 1.0 - probability, true)
    } else {
        quantile(shape, probability, false)
    }
}

/// The value that a gamma variate exceeds with a probability.
#[must_use]
pub fn gamma_quantile_above(shape: f64, probability: f64) -> f64 {
    if probability > 0.5 {
        quantile(shape, 1.0 - probability, false)
    } else {
        quantile(shape, probability, true)
    }
}

/// Quantile by the probability of the smaller tail.
fn quantile(shape: f64, tail: f64, upper: bool) -> f64 {
    if !(tail >= 0.0 && shape > 0.0) {
        return f64::NAN;
    }
    if tail == 0.0 {
        return if upper { f64::INFINITY } else { 0.0 };
    }
    // Wilson and Hilferty: the cube root is nearly normal. Far below, P is nearly xᵃ / Γ(a + 1).
    let z = normal_quantile(tail);
    let root = 1.0 - 1.0 / (9.0 * shape) + if upper { -z } else { z } / (3.0 * shape.sqrt());
    let guess = if root > 0.3 || upper {
        shape * root.max(0.3).powi(3)
    } else {
        ((tail.ln() + libm::lgamma(shape + 1.0)) / shape).exp()
    };
    if guess == 0.0 {
        return 0.0;
    }
    solve(tail, guess, !upper, |x| {
        let (below, above) = tails(shape, x);
        let density = density(shape, x);
        if upper { (above, -density) } else { (below, density) }
    })
}

/// P(a, x) and Q(a, x).
fn tails(a: f64, x: f64) -> (f64, f64) {
    if a.is_nan() || x.is_nan() || a <= 0.0 || x < 0.0 || a.is_infinite() {
        return (f64::NAN, f64::NAN);
    }
    if x == 0.0 {
        return (0.0, 1.0);
    }
    if x.is_infinite() {
        return (1.0, 0.0);
    }
    if a > UNIFORM_ABOVE {
        return uniform(a, x);
    }
    let density = density(a, x);
    if x < a + 1.0 {
        let below = density / a * series(a, x);
        (below, 1.0 - below)
    } else {
        let above = density * fraction(a, x);
        (1.0 - above, above)
    }
}

/// x times the density: xᵃ e⁻ˣ / Γ(a).
///
/// For large a it is √(a / 2π) exp(−a φ(x / a)) over Stirling's correction, with φ(u) = u − 1 − ln u, which
/// is free of cancellation.
fn density(a: f64, x: f64) -> f64 {
    if a < ASYMPTOTIC_ABOVE {
        return (a * x.ln() - x).exp() / libm::tgamma(a);
    }
    (a / (2.0 * PI)).sqrt() * (-a * above_log(x / a, (x - a) / a) - stirling(a)).exp()
}

/// 1 + x / (a + 1) + x² / ((a + 1) (a + 2)) + …; Abramowitz & Stegun 6.5.29.
fn series(a: f64, x: f64) -> f64 {
    let (mut sum, mut term, mut n) = (1.0, 1.0, a);
    while term > 0.1 * f64::EPSILON * sum {
        n += 1.0;
        term *= x / n;
        sum += term;
    }
    sum
}

/// 1 / (x + 1 − a − 1 (1 − a) / (x + 3 − a − 2 (2 − a) / (x + 5 − a − …))); DLMF 8.9.2, by Lentz's method.
fn fraction(a: f64, x: f64) -> f64 {
    let mut b = x + 1.0 - a;
    let mut c = f64::INFINITY;
    let mut d = 1.0 / b;
    let mut value = d;
    for i in 1..100_000 {
        let i = f64::from(i);
        let numerator = -i * (i - a);
        b += 2.0;
        d = 1.0 / nonzero(numerator * d + b);
        c = nonzero(b + numerator / c);
        let factor = c * d;
        value *= factor;
        if (factor - 1.0).abs() < f64::EPSILON {
            break;
        }
    }
    value
}

fn nonzero(x: f64) -> f64 {
    if x == 0.0 { f64::MIN_POSITIVE } else { x }
}

/// Temme's expansion for large a, uniform in x; DLMF 8.12.3 and 8.12.4.
fn uniform(a: f64, x: f64) -> (f64, f64) {
    let delta = (x - a) / a;
    let phi = above_log(x / a, delta);
    let eta = (2.0 * phi).sqrt().copysign(delta);
    if a * phi > 750.0 {
        return if delta < 0.0 { (0.0, 1.0) } else { (1.0, 0.0) };
    }
    let polynomial = |c: &[f64; POWERS]| c.iter().rev().fold(0.0, |sum, c| sum * eta + c);
    let sum = TEMME.iter().rev().fold(0.0, |sum, c| sum / a + polynomial(c));
    let rest = (-a * phi).exp() / (2.0 * PI * a).sqrt() * sum;
    let z = (a * phi).sqrt().copysign(delta);
    (0.5 * libm::erfc(-z) - rest, 0.5 * libm::erfc(z) + rest)
}

/// Coefficients of ηⁿ / aᵏ: d₀ₙ = (n + 2) αₙ₊₂, dₖₙ = (−1)ᵏ gₖ d₀ₙ + (n + 2) dₖ₋₁,ₙ₊₂; DLMF 8.12.9 to 8.12.12.
static TEMME: LazyLock<[[f64; POWERS]; ORDERS]> = LazyLock::new(|| {
    const LENGTH: usize = POWERS + 2 * ORDERS + 3;
    /// Γ(a) over Stirling's formula without corrections is Σ gₖ / aᵏ.
    const G: [f64; ORDERS] = [1.0, 1.0 / 12.0, 1.0 / 288.0, -139.0 / 51_840.0, -571.0 / 2_488_320.0];
    let mut alpha = [0.0; LENGTH + 1];
    alpha[1] = 1.0;
    for n in 2..=LENGTH {
        let products: f64 = (2..n).map(|j| j as f64 * alpha[j] * alpha[n - j + 1]).sum();
        alpha[n] = (alpha[n - 1] - products) / (n + 1) as f64;
    }
    let mut first: Vec<f64> = (0..LENGTH - 1).map(|n| (n + 2) as f64 * alpha[n + 2]).collect();
    first[0] = -1.0 / 3.0;
    let mut row = first.clone();
    let mut rows = [[0.0; POWERS]; ORDERS];
    for (k, kept) in rows.iter_mut().enumerate() {
        if k > 0 {
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            row = (0..row.len() - 2).map(|n| sign * G[k] * first[n] + (n + 2) as f64 * row[n + 2]).collect();
        }
        kept.copy_from_slice(&row[..POWERS]);
    }
    rows
});
