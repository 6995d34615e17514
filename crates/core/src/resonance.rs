//! A resonance: narrow-band noise, the velocity of a damped oscillator driven by white noise.
//!
//! With γ = 2π·width and ω² = (2π·frequency)² − γ² its autocovariance is σ² Re[(1 + iγ/ω) e^((iω − γ)t)].

use crate::bandlimited::exponential_avar;
use crate::psd::avar_of_density;
use crate::special::exp_minus_one;
use sigmatau_fft::Complex64;
use std::f64::consts::PI;

/// Frequency over the sampling rate below which folding is negligible.
const NEGLIGIBLE_FREQUENCY: f64 = 0.02;

/// Density that sampling folds to the frequency 0, over that of the white noise, above which a model without the resonance
/// describes longer averaging times better.
const MAX_FOLDED_RATIO: f64 = 0.02;

/// Number of frequencies up to half the rate in the integral of the density.
const POINTS: usize = 8192;

/// A resonance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resonance {
    /// Standard deviation. \[rate unit\]
    pub sigma: f64,
    /// Centre. \[Hz\]
    pub frequency: f64,
    /// Half width, less than the centre. \[Hz\]
    pub width: f64,
}

impl Resonance {
    /// Two-sided density: 0 at the frequency 0. [(rate unit)²/Hz]
    #[must_use]
    pub fn psd(&self, f: f64) -> f64 {
        let Self { sigma, frequency, width } = *self;
        let square = f * f;
        let below = (square - frequency * frequency).powi(2) + 4.0 * width * width * square;
        sigma * sigma * 2.0 * width / PI * square / below
    }

    /// Allan variance of the samples, including the noise folded from above half the rate. [(rate unit)²]
    #[must_use]
    pub fn avar_sampled(&self, tau0: f64, m: usize) -> f64 {
        let (weight, decay) = self.exponential(tau0);
        (weight * exponential_avar(decay, m)).re
    }

    /// Allan variances of samples whose density is [`Self::psd`] up to half the rate, as in a fit of the spectrum: without
    /// the noise folded from above. [(rate unit)²]
    #[must_use]
    pub fn avar_unfolded(&self, tau0: f64, sizes: &[usize]) -> Vec<f64> {
        if self.frequency * tau0 < NEGLIGIBLE_FREQUENCY {
            return sizes.iter().map(|&m| self.avar_sampled(tau0, m)).collect();
        }
        avar_of_density(|f| self.psd(f), POINTS, tau0, sizes)
    }

    /// Two-sided density of the samples at the frequency 0: the noise folded from above half the rate. [(rate unit)²/Hz]
    #[must_use]
    pub fn folded_level(&self, tau0: f64) -> f64 {
        let (weight, decay) = self.exponential(tau0);
        let lost = -exp_minus_one(-decay);
        tau0 * (weight * (2.0 - lost) / lost).re
    }

    /// Whether sampling folds noise to low frequencies that counts beside the white noise, and that a fit does not
    /// show.
    #[must_use]
    pub fn folds(&self, tau0: f64, random_walk: f64) -> bool {
        self.folded_level(tau0) > MAX_FOLDED_RATIO * random_walk * random_walk
    }

    /// Weight, and decay per sample, of the complex exponential whose real part is the autocovariance.
    fn exponential(&self, tau0: f64) -> (Complex64, Complex64) {
        let damping = 2.0 * PI * self.width;
        let turning = ((2.0 * PI * self.frequency).powi(2) - damping * damping).sqrt();
        let weight = self.sigma * self.sigma * Complex64::new(1.0, damping / turning);
        (weight, Complex64::new(damping, -turning) * tau0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TAU0: f64 = 0.01;
    const WIDE: Resonance = Resonance { sigma: 1.0, frequency: 31.0, width: 7.7 };
    const SLOW: Resonance = Resonance { sigma: 1.0, frequency: 1.5, width: 0.2 };

    /// σ²(τ) = 4 ∫ S sin⁴(πfmτ₀)/(m sin πfτ₀)² df up to half the rate, on a grid 50 times finer.
    #[test]
    fn unfolded_variance_is_the_integral_of_the_density() {
        for band in
            [WIDE, Resonance { frequency: 9.2, width: 0.3, ..WIDE }, Resonance { frequency: 2.5, ..SLOW }]
        {
            let variances = band.avar_unfolded(TAU0, &[1, 4, 12, 96]);
            let expected = avar_of_density(|f| band.psd(f), 400_000, TAU0, &[1, 4, 12, 96]);
            for (a, b) in variances.iter().zip(expected) {
                assert!((a / b - 1.0).abs() < 1e-3, "{a} instead of {b}");
            }
        }
    }

    /// At long averaging times the sampled resonance has the Allan variance of white noise of the folded density.
    #[test]
    fn folded_noise_is_white() {
        for m in [1000, 10_000] {
            let white = WIDE.folded_level(TAU0) / (m as f64 * TAU0);
            assert!((WIDE.avar_sampled(TAU0, m) / white - 1.0).abs() < 0.02);
        }
        assert!(SLOW.folded_level(TAU0) < 0.03 * WIDE.folded_level(TAU0));
        assert!(WIDE.folds(TAU0, 0.1) && !SLOW.folds(TAU0, 0.1));
    }

    /// The integral of the density is the autocovariance at lag 0.
    #[test]
    fn density_integrates_to_the_variance() {
        let (step, count) = (0.001, 4_000_000);
        let sum: f64 = (0..count).map(|k| SLOW.psd((f64::from(k) + 0.5) * step)).sum();
        assert!((2.0 * step * sum - 1.0).abs() < 1e-3);
    }
}
