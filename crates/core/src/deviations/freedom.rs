//! Expected variances and exact equivalent degrees of freedom of the Allan, modified Allan and Hadamard variances.
//!
//! Their terms are a stationary Gaussian sequence with autocovariance C. The mean of M squares therefore has
//! the variance (2 / M²) Σ (M − |u|) C(u)², over the lags −M < u < M, and edf = 2 E² / Var (C. A. Greenhall
//! and W. J. Riley, "Uncertainty of stability variances based on finite differences", Proc. 35th PTTI
//! Meeting, 2003). For the Hadamard variance, C is a sixth difference δₘ⁶ of the generalised autocovariance
//! of the phase; for the modified Allan variance, the same difference of the autocovariance of the running
//! sum of the phase; for the Allan variance, a fourth difference of the autocovariance of the phase. The sums
//! here run over all lags of the sampled processes of [`crate::terms`]; the publication interpolates between
//! asymptotes.

use super::Kind;
use crate::allan::Overlap;
use crate::covariance::PhaseCovariance;
use crate::covariance::lags::{Rules, SUMMED_LAGS};
use crate::error::Error;
use crate::special::{EULER_GAMMA, odd_harmonic};
use crate::terms::{NOISE_TERMS, Term};
use std::f64::consts::{LN_2, PI};

/// Estimators whose terms are a stationary sequence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stationary {
    /// The Allan variance, of all pairs of clusters or of disjoint ones.
    Allan(Overlap),
    /// The modified Allan variance.
    Modified,
    /// The Hadamard variance.
    Hadamard(Overlap),
}

/// Squared coefficients Q², N², B², K², and the squared ramp R², all for τ₀ = 1: see [`Coefficients::at_interval`].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Coefficients {
    /// Squared coefficients in the order of [`Term::NOISE`].
    pub noise: [f64; NOISE_TERMS],
    /// R².
    pub ramp: f64,
}

/// Expected variance and equivalent degrees of freedom at one cluster size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moments {
    /// In the unit of the rate squared.
    pub variance: f64,
    /// 2 · variance² / Var; infinite for a ramp alone, NaN for a record without noise and ramp.
    pub edf: f64,
}

impl Coefficients {
    /// From coefficients (not squared) in SI units and a sample interval, in the order of [`Term::ALL`].
    #[must_use]
    pub fn at_interval(coefficients: [f64; NOISE_TERMS + 1], tau0: f64) -> Self {
        let square = |term: Term| coefficients[term.index()].powi(2) * tau0.powi(term.interval_power() - 2);
        Self { noise: Term::NOISE.map(square), ramp: square(Term::RateRamp) }
    }
}

/// The moments of an estimator for a record of `samples` rates at the cluster sizes `m`.
///
/// # Errors
///
/// [`Error::TooShort`] and [`Error::ClusterSize`], as for the estimator itself.
pub fn moments(
    kind: Stationary,
    samples: usize,
    m: &[usize],
    coefficients: &Coefficients,
) -> Result<Vec<Moments>, Error> {
    match kind {
        Stationary::Allan(overlap) => {
            crate::allan::check_sizes(samples, m, overlap, crate::allan::Counting::Standard)?;
        }
        Stationary::Modified => Kind::Modified.check(samples, m)?,
        Stationary::Hadamard(overlap) => Kind::Hadamard(overlap).check(samples, m)?,
    }
    let rules = Rules::get();
    Ok(m.iter().map(|&m| of_size(rules, kind, samples, m, coefficients)).collect())
}

fn of_size(
    rules: &Rules,
    kind: Stationary,
    samples: usize,
    m: usize,
    coefficients: &Coefficients,
) -> Moments {
    let size = m as f64;
    let (reach, terms, divisor) = match kind {
        Stationary::Allan(_) => (2, samples + 1 - 2 * m, 2.0 * size * size),
        Stationary::Modified => (3, samples + 2 - 3 * m, 2.0 * size.powi(4)),
        Stationary::Hadamard(_) => (3, samples + 1 - 3 * m, 6.0 * size * size),
    };
    let disjoint = matches!(kind, Stationary::Allan(Overlap::None) | Stationary::Hadamard(Overlap::None));
    // For disjoint terms only every m-th lag counts.
    let (step, terms) = if disjoint { (m, samples / m + 1 - reach) } else { (1, terms) };
    let kinks: Vec<usize> = (0..=reach).map(|kink| kink * m / step).collect();
    let covariance = |lag: f64| -> f64 {
        let u = lag * step as f64;
        let used = Term::NOISE.into_iter().zip(coefficients.noise).filter(|&(_, theta)| theta > 0.0);
        used.map(|(term, theta)| theta * autocovariance(kind, term, size, u)).sum()
    };
    let mean = match kind {
        Stationary::Allan(_) => size * size,
        Stationary::Modified => size.powi(3),
        Stationary::Hadamard(_) => 0.0,
    };
    let mean_squared = coefficients.ramp * mean * mean;
    let mut sum = 0.0;
    rules.visit(&kinks, terms - 1, SUMMED_LAGS, |lag, weight| {
        let c = covariance(lag);
        let sides = if lag == 0.0 { 1.0 } else { 2.0 };
        sum += sides * weight * (terms as f64 - lag) * (2.0 * c * c + 4.0 * mean_squared * c);
    });
    let expected = covariance(0.0) + mean_squared;
    let count = terms as f64;
    Moments { variance: expected / divisor, edf: 2.0 * (expected * count) * (expected * count) / sum }
}

/// Expected Theo1 variance at the even size m. Its ratio to the Allan variance at 0.75 m is the bias of Theo1.
///
/// A term x(i) − x(i + a) − x(i + m − a) + x(i + m) is a difference over a of a difference over m − a.
#[must_use]
pub fn theo1_expectation(m: usize, coefficients: &Coefficients) -> f64 {
    let size = m as f64;
    let of_term = |a: usize| -> f64 {
        let a = a as f64;
        let variance = |term: Term| term.covariance(a, size - a, 0.0);
        let noise = Term::NOISE.into_iter().zip(coefficients.noise).filter(|&(_, theta)| theta > 0.0);
        let drift = a * (size - a);
        noise.map(|(term, theta)| theta * variance(term)).sum::<f64>() + coefficients.ramp * drift * drift
    };
    (1..=m / 2).map(|a| of_term(a) / a as f64).sum::<f64>() / (0.75 * size * size)
}

/// C(u) of the terms of an estimator, for a unit coefficient and τ₀ = 1.
///
/// Accurate to about 1e-13 of C(0); the tail of flicker noise to all digits except the last few.
fn autocovariance(kind: Stationary, term: Term, m: f64, u: f64) -> f64 {
    match kind {
        Stationary::Allan(_) => term.covariance(m, m, u),
        // −δₘ² of the autocovariance of second differences.
        Stationary::Hadamard(_) => {
            let second = |u: f64| term.covariance(m, m, u.abs());
            2.0 * second(u) - second(u + m) - second(u - m)
        }
        Stationary::Modified => match term {
            // S(l) of the running sum, with −δ₁² S = s: −|l| / 2, (|l|³ − |l|) / 12, −(|l|⁵ − 5|l|³ + 4|l|) / 240.
            Term::Quantization => 0.5 * sixth_difference(1, m, u),
            Term::RandomWalk => (sixth_difference(1, m, u) - sixth_difference(3, m, u)) / 12.0,
            Term::RateRandomWalk => {
                (sixth_difference(5, m, u) - 5.0 * sixth_difference(3, m, u)
                    + 4.0 * sixth_difference(1, m, u))
                    / 240.0
            }
            Term::BiasInstability => averaged_flicker(m, u),
            Term::RateRamp => 0.0,
        },
    }
}

/// δₘ⁶ |u|^p for an odd p < 6 and u ≥ 0: only the parts of |u|^p beyond its kinks remain.
fn sixth_difference(power: i32, m: f64, u: f64) -> f64 {
    let beyond = |kink: f64| (kink - u).max(0.0).powi(power);
    2.0 * (beyond(3.0 * m) - 6.0 * beyond(2.0 * m) + 15.0 * beyond(m))
}

/// Coefficients of a sixth difference.
const SIXTH: [f64; 7] = [1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0];

/// Lag, in units of m, above which the sixth difference of x⁴ ln x is computed from its series.
const SERIES_LAG: f64 = 6.0;

/// δₘ⁶ of (4x² − 1)(4x² − 9) ψ(|x| + ½) / (384π), which is −S(x) of the running sum of the phase of discrete flicker noise
/// except for a polynomial: S(l) = −(4l² − 1)(4l² − 9) hₗ / (192π), with the hₗ of [`odd_harmonic`], has
/// −δ₁² S(l) = (4l² − 1) hₗ / (4π) except for a parabola.
fn averaged_flicker(m: f64, u: f64) -> f64 {
    let sixth = |f: &dyn Fn(f64) -> f64| -> f64 {
        SIXTH.iter().enumerate().map(|(k, c)| c * f((u + (k as f64 - 3.0) * m).abs())).sum()
    };
    let v = u / m;
    // The remainder is also a series.
    let near = v < SERIES_LAG || u < 3.0 * m + SUMMED_LAGS as f64;
    let difference = if near {
        sixth(&|x| (4.0 * x * x - 1.0) * (4.0 * x * x - 9.0) * (log_digamma(x) - m.ln()))
    } else {
        let square = m * m;
        16.0 * square * square * power_log(4, v) - 40.0 * square * power_log(2, v)
            + 9.0 * power_log(0, v)
            + sixth(&remainder)
    };
    difference / (384.0 * PI)
}

/// ψ(x + ½); a small x must be an integer.
fn log_digamma(x: f64) -> f64 {
    if x < SUMMED_LAGS as f64 {
        return 2.0 * odd_harmonic(x as usize) - EULER_GAMMA - 2.0 * LN_2;
    }
    let y = 1.0 / (x * x);
    x.ln() + DIGAMMA.iter().rev().fold(0.0, |sum, t| (sum + t) * y)
}

/// ψ(x + ½) − ln x = Σ tⱼ x⁻²ʲ, tⱼ = (1 − 2¹⁻²ʲ) B₂ⱼ / (2j), j = 1, 2 … (Abramowitz & Stegun 6.3.18 and 6.3.8).
const DIGAMMA: [f64; 7] = [
    1.0 / 24.0,
    -7.0 / 960.0,
    31.0 / 8064.0,
    -127.0 / 30720.0,
    511.0 / 67584.0,
    -1_414_477.0 / 67_092_480.0,
    8191.0 / 98304.0,
];

/// (16x⁴ − 40x² + 9) Σ tⱼ x⁻²ʲ, without its polynomial part, for large x.
fn remainder(x: f64) -> f64 {
    let t = |j: usize| DIGAMMA.get(j).copied().unwrap_or(0.0);
    let y = 1.0 / (x * x);
    let coefficient = |j: usize| 16.0 * t(j + 2) - 40.0 * t(j + 1) + 9.0 * t(j);
    (0..DIGAMMA.len() - 2).rev().fold(0.0, |sum, j| (sum + coefficient(j)) * y)
}

/// δ₁⁶ of v^p ln v for p = 0, 2, 4 and large v: Σ a(k) f⁽²ᵏ⁾(v), with Σ a(k) x²ᵏ = (2 sinh (x / 2))⁶.
fn power_log(power: u32, v: f64) -> f64 {
    // The n-th derivative of v^p ln v, n > p, is (−1)^(n − p − 1) p! (n − p − 1)! v^(p − n); n − p is even.
    // (2 sinh (x / 2))⁶ = 2 (cosh 3x − 6 cosh 2x + 15 cosh x − 10): a(k) = 2 (3²ᵏ − 6·2²ᵏ + 15) / (2k)!.
    let mut sum = 0.0;
    for k in (3..40).rev() {
        let n = 2 * k;
        let scale = 2.0 * ((3.0 / v).powi(n) - 6.0 * (2.0 / v).powi(n) + 15.0 * v.powi(-n));
        // (n − p − 1)! / n! = 1 / (n (n − 1) … (n − p)).
        let product: f64 = (0..=power as i32).map(|i| f64::from(n - i)).product();
        sum -= scale / product;
    }
    let factorial: f64 = (1..=power).map(f64::from).product();
    factorial * sum * v.powi(power as i32)
}

#[cfg(test)]
#[allow(clippy::unreadable_literal, clippy::excessive_precision)] // Digits as they were computed.
mod tests {
    use super::*;

    // Computed with 60 digits from S(l): m, u and C.
    const FLICKER: [(f64, f64, f64); 24] = [
        (1.0, 0.0, 1.2732395447351626862),
        (1.0, 1.0, -0.42441318157838756205),
        (1.0, 3.0, -0.03637827270671893389),
        (1.0, 5.0, -0.012861005502375380668),
        (1.0, 6.0, -0.0089037730401060327703),
        (1.0, 7.0, -0.0065294335627444240315),
        (1.0, 100.0, -0.000031831784412989391889),
        (1.0, 1000000.0, -3.1830988618387024901e-13),
        (2.0, 11.0, -0.17539162111200720163),
        (7.0, 21.0, -104.45443670207681248),
        (7.0, 41.0, -23.305281417745824257),
        (7.0, 42.0, -22.159368570579348455),
        (50.0, 0.0, 3722272.5229271549535),
        (50.0, 149.0, -278151.31992317467039),
        (50.0, 250.5, -84497.951745740001034),
        (50.0, 300.0, -57727.160947066334099),
        (50.0, 10000.0, -49.737784300235560677),
        (262144.0, 0.0, 2.8116237061907505981e+21),
        (262144.0, 5.0, 2.8116237043456652651e+21),
        (262144.0, 786433.0, -2.065693349467003559e+20),
        (262144.0, 1500000.0, -48178887685370386883.0),
        (262144.0, 1600000.0, -42086312224709063377.0),
        (262144.0, 10000000.0, -1034041131859670588.9),
        (1000.0, 1000000000.0, -0.31830988618426813597),
    ];

    #[test]
    fn averaged_flicker_at_every_lag() {
        for (m, u, expected) in FLICKER {
            let got = averaged_flicker(m, u);
            // The error is relative to C(0) at small lags, where large numbers are subtracted, and to the
            // value itself in the tail.
            let scale = if u < SERIES_LAG * m.max(4.0) { averaged_flicker(m, 0.0) } else { expected.abs() };
            assert!((got - expected).abs() <= 1e-11 * scale, "m {m}, u {u}: {got} instead of {expected}");
        }
    }
}
