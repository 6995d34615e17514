//! Two-sided power spectral densities of the noise terms, in the unit of the rate squared per hertz.
//!
//! Each term has its continuous form, which eq. (11) of the paper integrates to the Allan variance, and, where it
//! differs, the form of the sampled process, folded into |f| ≤ 1 / (2τ₀). The latter corresponds to σ²(m) = 4 ∫ S(f)
//! sin⁴(πfmτ₀) / (m² sin²(πfτ₀)) df, from 0 to 1 / (2τ₀). A one-sided density is twice the value given here.

use crate::bandlimited::{Filter, poles};
use sigmatau_fft::Complex64;
use std::f64::consts::PI;

/// Quantization noise, (2πf)² τ₀Q²: the right-hand side of eq. (14) of the paper.
#[must_use]
pub fn quantization(q: f64, tau0: f64, f: f64) -> f64 {
    (2.0 * PI * f * q).powi(2) * tau0
}

/// Quantization noise of samples, (4Q² / τ₀) sin²(πfτ₀): the middle of eq. (14) of the paper.
#[must_use]
pub fn quantization_sampled(q: f64, tau0: f64, f: f64) -> f64 {
    (2.0 * q * (PI * f * tau0).sin()).powi(2) / tau0
}

/// Angle or velocity random walk, N² at every frequency: eq. (16) of the paper. Sampling does not change it.
#[must_use]
pub fn random_walk(n: f64) -> f64 {
    n * n
}

/// Bias instability, B² / (2πf) up to the cut-off `f0`, if there is one: eq. (18) of the paper.
#[must_use]
pub fn bias_instability(b: f64, f0: Option<f64>, f: f64) -> f64 {
    let f = f.abs();
    if f0.is_some_and(|f0| f > f0) { 0.0 } else { b * b / (2.0 * PI * f) }
}

/// Bias instability of samples, B²τ₀ / (2 |sin(πfτ₀)|): flicker noise after Kasdin, see
/// [`crate::terms::bias_instability_avar`].
#[must_use]
pub fn bias_instability_sampled(b: f64, tau0: f64, f: f64) -> f64 {
    b * b * tau0 / (2.0 * (PI * f * tau0).sin().abs())
}

/// Rate random walk, (K / 2πf)²: eq. (20) of the paper.
#[must_use]
pub fn rate_random_walk(k: f64, f: f64) -> f64 {
    (k / (2.0 * PI * f)).powi(2)
}

/// Rate random walk of samples, K²τ₀² / (4 sin²(πfτ₀)).
#[must_use]
pub fn rate_random_walk_sampled(k: f64, tau0: f64, f: f64) -> f64 {
    (k * tau0 / (2.0 * (PI * f * tau0).sin())).powi(2)
}

/// Rate ramp, R² / (2πf)³: eq. (24) of the paper.
///
/// For comparison only: a ramp is not a stationary process, and eq. (11) diverges with this density at f = 0.
#[must_use]
pub fn rate_ramp(r: f64, f: f64) -> f64 {
    r * r / (2.0 * PI * f.abs()).powi(3)
}

/// First-order Gauss–Markov process, 2σ²T / (1 + (2πfT)²) with T = `tc` (IEEE 952, annex C).
#[must_use]
pub fn gauss_markov(sigma: f64, tc: f64, f: f64) -> f64 {
    2.0 * sigma * sigma * tc / (1.0 + (2.0 * PI * f * tc).powi(2))
}

/// First-order Gauss–Markov process, sampled: σ²τ₀ (1 − p²) / (1 − 2p cos(2πfτ₀) + p²), p = e^(−τ₀ / `tc`).
#[must_use]
pub fn gauss_markov_sampled(sigma: f64, tc: f64, tau0: f64, f: f64) -> f64 {
    let loss = -(-tau0 / tc).exp_m1();
    let kept = 1.0 - loss;
    // 1 − 2p cos φ + p² = (1 − p)² + 4p sin²(φ / 2).
    let denominator = loss * loss + 4.0 * kept * (PI * f * tau0).sin().powi(2);
    sigma * sigma * tau0 * loss * (1.0 + kept) / denominator
}

/// White noise with density `n`² after a filter, before sampling.
#[must_use]
pub fn band_limited(n: f64, filter: Filter, corner_hz: f64, f: f64) -> f64 {
    let ratio = f / corner_hz;
    let gain = match filter {
        Filter::Butterworth(order) => 1.0 / (1.0 + ratio.powi(2 * i32::from(order))),
        Filter::BrickWall => f64::from(u8::from(ratio.abs() <= 1.0)),
    };
    n * n * gain
}

/// Sampled white noise with density `n`² after a Butterworth filter: the sum over its images in closed form.
///
/// With poles p and a = −p ωc τ₀ each exponential e^(−a|k|) has the spectrum sinh a / (cosh a − cos 2πfτ₀).
#[must_use]
pub fn band_limited_sampled(n: f64, order: u8, corner_hz: f64, tau0: f64, f: f64) -> f64 {
    let turn = 2.0 * PI * corner_hz * tau0;
    let phase = Complex64::new(0.0, PI * f * tau0);
    let sum: f64 = poles(order)
        .map(|(pole, times)| {
            let half = -0.5 * pole * turn;
            // cosh a − cos φ = 2 sinh((a + jφ) / 2) sinh((a − jφ) / 2)
            let spectrum = (2.0 * half).sinh() / (2.0 * (half + phase).sinh() * (half - phase).sinh());
            // Far above the corner sinh overflows, and the ratio is 1.
            let spectrum = if half.re > 300.0 { Complex64::new(1.0, 0.0) } else { spectrum };
            times * (-pole * spectrum).re
        })
        .sum();
    n * n * 0.5 * turn / f64::from(order) * sum
}

/// Cluster size from which sin⁴ is replaced by its mean over an oscillation.
const AVERAGED_FROM: usize = 1024;

/// Mean of sin⁴ over an oscillation.
pub(crate) const MEAN_OF_SINE_4: f64 = 0.375;

/// Allan variances of sampled noise with a density up to half the rate: 4 ∫ S(f) sin⁴(πfmτ₀) / (m² sin²(πfτ₀)) df, by the
/// midpoints of `points` intervals.
#[must_use]
pub fn avar_of_density(density: impl Fn(f64) -> f64, points: usize, tau0: f64, sizes: &[usize]) -> Vec<f64> {
    let step = 0.5 / (points as f64 * tau0);
    let (weights, turns): (Vec<f64>, Vec<f64>) = (0..points)
        .map(|k| {
            let f = (k as f64 + 0.5) * step;
            let turn = PI * f * tau0;
            (density(f) / turn.sin().powi(2), turn)
        })
        .unzip();
    let all: f64 = MEAN_OF_SINE_4 * weights.iter().sum::<f64>();
    let sum = |m: usize| {
        if m >= AVERAGED_FROM {
            return all;
        }
        let size = m as f64;
        weights.iter().zip(&turns).map(|(weight, turn)| weight * (size * turn).sin().powi(4)).sum()
    };
    sizes.iter().map(|&m| 4.0 * step * sum(m) / (m as f64).powi(2)).collect()
}
