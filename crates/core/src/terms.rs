//! The list of noise terms and their expected Allan variances.
//!
//! `tau0` is the sample interval, `m` the cluster size in samples (≥ 1) and `tau` = m·τ₀ the averaging time, in
//! seconds. Functions of `tau` are exact for every cluster size. Functions of `m` are exact for the sampled process that
//! they name; the continuous process has no samples of finite variance, or differs at short times.

use crate::bandlimited::exponential_avar;
use crate::psd;
use crate::special::{flicker_cutoff_bracket, odd_harmonic, odd_harmonic_doubling};
use sigmatau_fft::Complex64;
use std::f64::consts::PI;

/// Number of terms that are noise.
pub const NOISE_TERMS: usize = 4;

/// A term of IEEE 952. To add a term, add a variant; the compiler then reports each place that needs its formulas.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Term {
    /// White noise on the phase; the coefficient is Q.
    Quantization,
    /// White noise on the rate; N.
    RandomWalk,
    /// Discrete flicker noise, see [`bias_instability_avar`]; B.
    BiasInstability,
    /// Random walk of the samples, see [`rate_random_walk_avar_sampled`]; K.
    RateRandomWalk,
    /// Deterministic ramp of either sign, not a noise; R.
    RateRamp,
}

impl Term {
    /// The terms that are noise, in the order of coefficients. The Allan variance is linear in their squares.
    pub const NOISE: [Self; NOISE_TERMS] =
        [Self::Quantization, Self::RandomWalk, Self::BiasInstability, Self::RateRandomWalk];

    /// All terms: the noise, then the ramp.
    pub const ALL: [Self; NOISE_TERMS + 1] = {
        let mut all = [Self::RateRamp; NOISE_TERMS + 1];
        let mut k = 0;
        while k < NOISE_TERMS {
            all[k] = Self::NOISE[k];
            k += 1;
        }
        all
    };

    /// Place in [`Term::ALL`].
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize
    }

    /// Name in results and model files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Quantization => "quantization",
            Self::RandomWalk => "random_walk",
            Self::BiasInstability => "bias_instability",
            Self::RateRandomWalk => "rate_random_walk",
            Self::RateRamp => "rate_ramp",
        }
    }

    /// The term of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|term| term.name() == name)
    }

    /// Expected Allan variance of the sampled term at the cluster size `m`.
    #[must_use]
    pub fn avar(self, coefficient: f64, tau0: f64, m: usize) -> f64 {
        let tau = m as f64 * tau0;
        match self {
            Self::Quantization => quantization_avar(coefficient, tau),
            Self::RandomWalk => random_walk_avar(coefficient, tau),
            Self::BiasInstability => bias_instability_avar(coefficient, m),
            Self::RateRandomWalk => rate_random_walk_avar_sampled(coefficient, tau0, m),
            Self::RateRamp => rate_ramp_avar(coefficient, tau),
        }
    }

    /// Two-sided density of the sampled term at the frequency `f`; for a ramp the conventional density, see
    /// [`psd::rate_ramp`].
    #[must_use]
    pub fn psd(self, coefficient: f64, tau0: f64, f: f64) -> f64 {
        match self {
            Self::Quantization => psd::quantization_sampled(coefficient, tau0, f),
            Self::RandomWalk => psd::random_walk(coefficient),
            Self::BiasInstability => psd::bias_instability_sampled(coefficient, tau0, f),
            Self::RateRandomWalk => psd::rate_random_walk_sampled(coefficient, tau0, f),
            Self::RateRamp => psd::rate_ramp(coefficient, f),
        }
    }

    /// The power p for which the squared coefficient for τ₀ = 1 is that in SI times τ₀^(p − 2).
    #[must_use]
    pub const fn interval_power(self) -> i32 {
        match self {
            Self::Quantization => 0,
            Self::RandomWalk => 1,
            Self::BiasInstability => 2,
            Self::RateRandomWalk => 3,
            Self::RateRamp => 4,
        }
    }
}

/// Quantization noise, white noise of standard deviation `q` on the phase: 3Q² / T², eq. (15) of the paper.
#[must_use]
pub fn quantization_avar(q: f64, tau: f64) -> f64 {
    3.0 * q * q / (tau * tau)
}

/// Angle or velocity random walk, white noise on the rate: N² / T, eq. (17) of the paper.
#[must_use]
pub fn random_walk_avar(n: f64, tau: f64) -> f64 {
    n * n / tau
}

/// Bias instability as discrete flicker noise, white noise of standard deviation `b` through (1 − z⁻¹)^(−1/2)
/// (N. J. Kasdin, "Discrete simulation of colored noise", Proc. IEEE 83(5), 1995), for any sample interval.
///
/// With hₗ = Σ 1 / (2j − 1), j = 1 … l, the variogram of the rate is 4B²hₗ / π, and summing it twice gives
/// (2B² / π) · [2 (h₂ₘ − hₘ) + (4hₘ − h₂ₘ) / (8m²)]. It falls from 2B² / π at m = 1 to the plateau (2 ln 2 / π) B² of
/// eq. (19) of the paper.
#[must_use]
pub fn bias_instability_avar(b: f64, m: usize) -> f64 {
    let size = m as f64;
    let doubling = odd_harmonic_doubling(m);
    let near = (3.0 * odd_harmonic(m) - doubling) / (8.0 * size * size);
    2.0 * b * b / PI * (2.0 * doubling + near)
}

/// Bias instability with the spectrum of eq. (18) of the paper, which ends at `f0`: eq. (19).
#[must_use]
pub fn bias_instability_avar_cutoff(b: f64, f0: f64, tau: f64) -> f64 {
    2.0 * b * b / PI * flicker_cutoff_bracket(PI * f0 * tau)
}

/// Rate random walk of the samples, yₖ = yₖ₋₁ + K √τ₀ wₖ: (K²T / 3) · (1 + 1 / (2m²)).
#[must_use]
pub fn rate_random_walk_avar_sampled(k: f64, tau0: f64, m: usize) -> f64 {
    let size = m as f64;
    k * k * tau0 * (2.0 * size * size + 1.0) / (6.0 * size)
}

/// Rate random walk in continuous time, averaged over every sample interval: K²T / 3, eq. (21) of the paper.
#[must_use]
pub fn rate_random_walk_avar_averaged(k: f64, tau: f64) -> f64 {
    k * k * tau / 3.0
}

/// Rate ramp R·t: R²T² / 2, eq. (23) of the paper.
#[must_use]
pub fn rate_ramp_avar(r: f64, tau: f64) -> f64 {
    0.5 * r * r * tau * tau
}

/// First-order Gauss–Markov process of standard deviation `sigma` and correlation time `tc`, sampled.
///
/// With p = e^(−τ₀ / `tc`): σ² · [m (1 − p²) − 3p + 4p^(m+1) − p^(2m+1)] / (m² (1 − p)²).
#[must_use]
pub fn gauss_markov_avar_sampled(sigma: f64, tc: f64, tau0: f64, m: usize) -> f64 {
    sigma * sigma * exponential_avar(Complex64::new(tau0 / tc, 0.0), m).re
}

/// First-order Gauss–Markov process in continuous time, averaged over every sample interval (IEEE 952, annex C).
///
/// With u = T / `tc`: σ² · (2u − 3 + 4e⁻ᵘ − e⁻²ᵘ) / u².
#[must_use]
pub fn gauss_markov_avar_averaged(sigma: f64, tc: f64, tau: f64) -> f64 {
    let u = tau / tc;
    let bracket = if u > 1.0 {
        let loss = -(-u).exp_m1();
        (2.0 * u - loss * (2.0 + loss)) / (u * u)
    } else {
        // Σ (4 − 2ʲ) (−u)ʲ / j!, j = 3, 4 …: the lower powers cancel.
        let mut sum = 0.0;
        let mut power = 0.5;
        let mut two = 4.0;
        for j in 3..=24 {
            power *= -u / f64::from(j);
            two *= 2.0;
            sum += power * (4.0 - two);
        }
        sum
    };
    sigma * sigma * bracket
}

/// Sampled sinusoid of random phase: A² sin⁴(πf₀T) / (m² sin²(πf₀τ₀)); 0 if all samples are equal.
#[must_use]
pub fn sinusoid_avar(amplitude: f64, f0: f64, tau0: f64, m: usize) -> f64 {
    let size = m as f64;
    // Whole turns are subtracted before the multiplication by π.
    let turn = f0 * tau0 - (f0 * tau0).round();
    let turns = size * turn;
    let step = (PI * turn).sin();
    if step == 0.0 {
        return 0.0;
    }
    let ratio = (PI * (turns - turns.round())).sin().powi(2) / (size * step);
    (amplitude * ratio).powi(2)
}

#[cfg(test)]
#[allow(clippy::unreadable_literal, clippy::excessive_precision, clippy::approx_constant)] // Digits as computed.
mod tests {
    use super::*;

    fn assert_relative(got: f64, expected: f64, tolerance: f64) {
        assert!((got / expected - 1.0).abs() <= tolerance, "{got} instead of {expected}");
    }

    // Computed with 60 digits from sums of the digamma function.
    const FLICKER: [(usize, f64); 13] = [
        (1, 0.63661977236758134308),
        (2, 0.50929581789406507446),
        (3, 0.47673501824916232499),
        (7, 0.44983024275641059522),
        (16, 0.44329423764070029609),
        (32, 0.44185772862074295789),
        (33, 0.44182609238569065542),
        (50, 0.44153274850651149156),
        (100, 0.44134486087359775072),
        (1_000, 0.44127221176078942831),
        (12_345, 0.441271208910691117),
        (1_000_000, 0.44127120030713919482),
        (1_000_000_000, 0.44127120030530318945),
    ];

    #[test]
    fn bias_instability_keeps_its_digits_at_every_size() {
        for (m, expected) in FLICKER {
            assert_relative(bias_instability_avar(1.0, m), expected, 5e-16);
        }
    }

    // Computed with 40 digits: T / T_c and the variance for σ = 1.
    const AVERAGED: [(f64, f64); 7] = [
        (1e-9, 6.6666666616666670842e-10),
        (1e-3, 0.00066616689991669127745),
        (0.5, 0.23297279071636549128),
        (1.0, 0.33618248144915659449),
        (1.0000001, 0.33618249412793924411),
        (3.0, 0.35518550236608771261),
        (1e6, 1.999997e-6),
    ];

    #[test]
    fn gauss_markov_averaged_at_short_and_long_times() {
        for (u, expected) in AVERAGED {
            assert_relative(gauss_markov_avar_averaged(1.0, 1.0, u), expected, 2e-15);
        }
    }

    // Computed with 40 digits: τ₀ / T_c, m and the variance for σ = 1.
    const SAMPLED: [(f64, usize, f64); 11] = [
        (1e-9, 1, 9.9999999950000006245e-10),
        (1e-9, 1_000, 6.6666650000023337472e-7),
        (1e-3, 1, 0.00099950016662500835274),
        (1e-3, 700, 0.28519280186123153592),
        (1e-3, 999, 0.33605587454501829867),
        (1e-3, 1_001, 0.33630944965048983214),
        (1e-3, 1_000_000, 0.0019970001669166638349),
        (0.6, 1, 0.45118836390597355519),
        (0.7, 1, 0.50341469620859046324),
        (5.0, 3, 0.3355792132393444119),
        (1e-7, 1_000_000_000, 0.019700000000000017795),
    ];

    #[test]
    fn gauss_markov_sampled_at_short_and_long_times() {
        for (ratio, m, expected) in SAMPLED {
            assert_relative(gauss_markov_avar_sampled(1.0, 1.0, ratio, m), expected, 4e-15);
        }
    }

    #[test]
    fn gauss_markov_turns_into_white_noise_and_random_walk() {
        let (sigma, tau0) = (0.3, 0.01);
        // T ≪ T_c: K = σ √(2 / T_c); the next order is T / T_c = 10⁻⁹.
        let tc = 1e8;
        let k = sigma * f64::sqrt(2.0 / tc);
        let walk = rate_random_walk_avar_sampled(k, tau0, 10);
        assert_relative(gauss_markov_avar_sampled(sigma, tc, tau0, 10), walk, 2e-9);
        // Independent samples: σ² / m.
        assert_relative(gauss_markov_avar_sampled(sigma, 1e-9, tau0, 10), sigma * sigma / 10.0, 1e-15);
        assert_relative(gauss_markov_avar_sampled(sigma, 0.0, tau0, 10), sigma * sigma / 10.0, 1e-15);
    }

    #[test]
    fn sinusoid_at_a_multiple_of_the_sample_rate_is_a_constant() {
        for f0 in [0.0, 100.0, 300.0] {
            assert!(sinusoid_avar(1.0, f0, 0.01, 7).abs() < 1e-30);
        }
        // At the Nyquist frequency samples alternate between ±a, with a² = A² / 2 on average: z = ∓2a for odd m only.
        assert_relative(sinusoid_avar(1.0, 50.0, 0.01, 3), 1.0 / 9.0, 1e-15);
        assert!(sinusoid_avar(1.0, 50.0, 0.01, 4) < 1e-30);
    }
}
