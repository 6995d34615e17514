//! White noise after a filter: the sampled process, including aliasing.
//!
//! For samples of autocovariance rₖ the sum of l of them has the variance V(l) = l·r₀ + 2 Σ (l − k) rₖ, k = 1 … l − 1,
//! and the Allan variance is (4V(m) − V(2m)) / (2m²). The sums of rₖ of these filters have closed forms.

use crate::special::exp_minus_one;
use sigmatau_fft::Complex64;
use std::f64::consts::PI;

/// A low-pass filter of unit gain at zero frequency.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Filter {
    /// Butterworth filter with n poles, |H|² = 1 / (1 + (f / `corner_hz`)²ⁿ); with one pole an RC filter.
    Butterworth(u8),
    /// Passes everything below the corner and nothing above.
    BrickWall,
}

/// The poles of a Butterworth filter in the left half-plane, in units of its corner, one of each conjugate
/// pair. Each comes with the factor of its residue in r(t) = −Σ p / (2n) · e^(p ωc |t|): 2 for a pair, 1 for
/// the real pole.
pub(crate) fn poles(order: u8) -> impl Iterator<Item = (Complex64, f64)> {
    let n = usize::from(order);
    (0..n.div_ceil(2)).map(move |k| {
        let angle = PI * (2 * k + n + 1) as f64 / (2 * n) as f64;
        let real = 2 * k + 1 == n;
        let pole = if real { Complex64::new(-1.0, 0.0) } else { Complex64::cis(angle) };
        (pole, if real { 1.0 } else { 2.0 })
    })
}

/// Allan variance at each cluster size of white noise with density `n`² after a filter, sampled every `tau0`.
///
/// `n` has the unit of a random walk coefficient: far above the time constant of the filter, and without aliasing,
/// the result is N² / T. The standard deviation of the samples is [`band_limited_sigma`].
#[must_use]
pub fn band_limited_avar(n: f64, filter: Filter, corner_hz: f64, tau0: f64, m: &[usize]) -> Vec<f64> {
    let turn = 2.0 * PI * corner_hz * tau0;
    let avar = |m: usize| match filter {
        Filter::Butterworth(order) => {
            let sum: f64 = poles(order)
                .map(|(pole, times)| times * (-pole * exponential_avar(-pole * turn, m)).re)
                .sum();
            n * n * PI * corner_hz / f64::from(order) * sum
        }
        Filter::BrickWall => brick_wall_avar(n, corner_hz, tau0, m),
    };
    m.iter().map(|&m| avar(m)).collect()
}

/// Standard deviation of white noise with density `n`² after a filter: N √(2 · noise bandwidth).
#[must_use]
pub fn band_limited_sigma(n: f64, filter: Filter, corner_hz: f64) -> f64 {
    let noise_bandwidth = corner_hz
        * match filter {
            // (π / 2n) / sin(π / 2n)
            Filter::Butterworth(order) => {
                let angle = 0.5 * PI / f64::from(order);
                angle / angle.sin()
            }
            Filter::BrickWall => 1.0,
        };
    n * (2.0 * noise_bandwidth).sqrt()
}

/// Allan variance of samples with autocovariance pᵏ, p = e^(−a), for a real or complex decay `a`.
///
/// [m (1 − p²) − 3p + 4p^(m+1) − p^(2m+1)] / (m² (1 − p)²), free of cancellation for slow decay.
pub(crate) fn exponential_avar(a: Complex64, m: usize) -> Complex64 {
    let size = m as f64;
    let loss = -exp_minus_one(-a);
    let whole = 2.0 * size + 1.0;
    let numerator = if (whole * a).norm() > 2.0 {
        let loss_of_cluster = -exp_minus_one(-a * size);
        let kept = 1.0 - loss;
        size * loss * (1.0 + kept) - kept * loss_of_cluster * (2.0 + loss_of_cluster)
    } else {
        // Expanded in a, the powers below the third cancel: Σ cⱼ (−a)ʲ / j! with
        // cⱼ = 4 (m + 1)ʲ − (2m + 1)ʲ − m 2ʲ − 3, all taken relative to (2m + 1)ʲ.
        let ratios = [(size + 1.0) / whole, 2.0 / whole, 1.0 / whole];
        let mut powers = ratios.map(|ratio| ratio * ratio);
        let mut power = 0.5 * (whole * a) * (whole * a);
        let mut sum = Complex64::new(0.0, 0.0);
        for j in 3..=30 {
            power *= -whole * a / f64::from(j);
            for (power, ratio) in powers.iter_mut().zip(ratios) {
                *power *= ratio;
            }
            sum += power * (4.0 * powers[0] - 1.0 - size * powers[1] - 3.0 * powers[2]);
        }
        sum
    };
    let scaled = size * loss;
    numerator / (scaled * scaled)
}

/// With rₖ = (N² / πτ₀) sin(ck) / k, c = 2π · corner · τ₀, both sums in V(l) are sums of sines:
/// V(l) = l·r₀ + (2N² / πτ₀) · (l·S(l) − P(l)), S(l) = Σ sin(ck) / k and P(l) = Σ sin(ck), k = 1 … l − 1.
fn brick_wall_avar(n: f64, corner_hz: f64, tau0: f64, m: usize) -> f64 {
    let size = m as f64;
    let turn = corner_hz * tau0 - (corner_hz * tau0).round();
    let weighted = |l: usize| sine_over_index_sum(turn, l);
    let plain = |l: usize| sine_sum(turn, l);
    let sums = 4.0 * size * weighted(m) - 2.0 * size * weighted(2 * m) - 4.0 * plain(m) + plain(2 * m);
    2.0 * corner_hz * n * n / size + n * n * sums / (PI * tau0 * size * size)
}

/// sin(2π · turn · k), reduced by whole turns.
fn sine_of_turns(turn: f64, k: f64) -> f64 {
    let turns = turn * k;
    (2.0 * PI * (turns - turns.round())).sin()
}

/// Σ sin(ck), k = 1 … l − 1, c = 2π · turn.
fn sine_sum(turn: f64, l: usize) -> f64 {
    let half = (PI * turn).sin();
    if half == 0.0 {
        return 0.0;
    }
    let l = l as f64;
    sine_of_turns(0.5 * turn, l - 1.0) * sine_of_turns(0.5 * turn, l) / half
}

/// Σ sin(ck) / k, k = 1 … l − 1, c = 2π · turn, |turn| ≤ ½.
fn sine_over_index_sum(turn: f64, l: usize) -> f64 {
    /// Value of l·|1 − e^(jc)| above which the asymptotic series of the tail is accurate to the last bit.
    const ASYMPTOTIC_FROM: f64 = 45.0;
    let c = 2.0 * PI * turn;
    let gap = 2.0 * (0.5 * c).sin().abs();
    if gap == 0.0 {
        return 0.0;
    }
    let first = l as f64;
    if first * gap < ASYMPTOTIC_FROM {
        return (1..l).rev().map(|k| sine_of_turns(turn, k as f64) / k as f64).sum();
    }
    // The whole series is (π − c) / 2; its tail from l on, summed by parts repeatedly, is
    // Im Σ e^(jcl) / (1 − w) · (−w / (1 − w))ⁱ i! / (l (l + 1) … (l + i)), w = e^(jc).
    let whole = 0.5 * (PI.copysign(c) - c);
    let w = Complex64::cis(c);
    let one_minus_w = -exp_minus_one(Complex64::new(0.0, c));
    let turns_to_l = turn * first;
    let at_l = Complex64::cis(2.0 * PI * (turns_to_l - turns_to_l.round()));
    let mut term = at_l / (one_minus_w * first);
    let mut tail = term;
    for i in 1..=40 {
        let i = f64::from(i);
        term *= -w / one_minus_w * (i / (first + i));
        tail += term;
    }
    whole - tail.im
}

#[cfg(test)]
#[allow(clippy::unreadable_literal, clippy::excessive_precision)] // Digits as they were computed.
mod tests {
    use super::*;

    fn assert_relative(got: f64, expected: f64, tolerance: f64, what: &str) {
        assert!((got / expected - 1.0).abs() <= tolerance, "{what}: {got} instead of {expected}");
    }

    // Computed with 40 digits: ω_cτ₀ / √2, m and the variance for samples of unit variance.
    const BUTTERWORTH: [(f64, usize, f64); 7] = [
        (1e-3, 1, 9.9933349999998893365e-7),
        (1e-3, 10, 0.000099072209950774172545),
        (1e-2, 50, 0.15355026943093679018),
        (0.1, 7, 0.24644168114536563452),
        (1.0, 1, 0.49167401400047486093),
        (1.0, 100, 0.019988135888057753745),
        (3.0, 1_000_000, 9.1872975759797725632e-7),
    ];

    #[test]
    fn butterworth_known_answers() {
        for (angle, m, expected) in BUTTERWORTH {
            let pole = Complex64::new(1.0, -1.0);
            let got = (pole * exponential_avar(pole * angle, m)).re;
            // Far below the corner the largest part is imaginary, 1 / (m·angle) times the real one.
            let tolerance = 2e-15 * (1.0 + 1.0 / (angle * m as f64));
            assert_relative(got, expected, tolerance, &format!("angle {angle}, m {m}"));
        }
    }

    // Summed with 30 digits: f_cτ₀, m and the variance for N = 1, τ₀ = 1.
    const BRICK_WALL: [(f64, usize, f64); 10] = [
        (0.3, 1, 0.29726930854373717924),
        (0.3, 7, 0.13524034480971119198),
        (0.3, 1_000, 0.0009996531018271617434),
        (0.3, 20_000, 0.000049999132753741831354),
        (0.01, 100, 0.0085575733005826390056),
        (0.01, 3_000, 0.00033164532130853856644),
        (0.5, 5, 0.2),
        (0.7, 50, 0.020138706479761874185),
        (0.001, 20_000, 0.000049620106915678037071),
        (1.0, 3, 0.66666666666666666667),
    ];

    #[test]
    fn brick_wall_known_answers() {
        for (corner, m, expected) in BRICK_WALL {
            let got = band_limited_avar(1.0, Filter::BrickWall, corner, 1.0, &[m])[0];
            assert_relative(got, expected, 1e-13, &format!("corner {corner}, m {m}"));
        }
    }

    #[test]
    fn all_filters_pass_white_noise_at_long_times() {
        // The relative deficit is the time constant over T, 10⁻⁶ here, times the excess by aliasing.
        let (n, tau0, m) = (0.5, 1e-3, 10_000_000);
        for filter in
            [Filter::Butterworth(1), Filter::Butterworth(2), Filter::Butterworth(5), Filter::BrickWall]
        {
            let got = band_limited_avar(n, filter, 20.0, tau0, &[m])[0];
            let aliased = if filter == Filter::Butterworth(1) { 2e-3 } else { 1e-5 };
            assert_relative(got, n * n / (m as f64 * tau0), aliased, &format!("{filter:?}"));
        }
    }

    #[test]
    fn variance_of_the_samples_is_twice_their_allan_variance_when_they_are_independent() {
        // e^(−τ₀ω) is 10⁻²⁷ here.
        for filter in [Filter::Butterworth(1), Filter::Butterworth(2)] {
            let got = band_limited_avar(1.0, filter, 20.0, 0.5, &[1])[0];
            assert_relative(got, band_limited_sigma(1.0, filter, 20.0).powi(2), 1e-15, "");
        }
    }
}
