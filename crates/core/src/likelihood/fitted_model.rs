//! The model of a record as a curve: expected Allan variance and density of all its parts, filtered.

use crate::likelihood::filter::FittedFilter;
use crate::resonance::Resonance;
use crate::terms::Term;
use crate::{psd, terms};

/// Smallest share of the Allan variance that remains after a filter.
const MIN_VARIANCE_SHARE: f64 = 1e-6;

/// Shortest time from the first to the last pair of clusters, over the time constant of a warm-up.
const MIN_PAIRS: f64 = 1e-9;

/// A model of a record. Coefficients of 0 are absent.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedModel {
    /// Sample interval. \[s\]
    pub tau0: f64,
    /// Samples of the record.
    pub samples: usize,
    /// Coefficients in the order of [`Term::ALL`]. \[SI\]
    pub terms: [f64; Term::ALL.len()],
    /// Gauss-Markov processes: standard deviation and correlation time. [rate unit, s]
    pub gauss_markov: Vec<(f64, f64)>,
    /// Resonances, up to half the rate.
    pub resonance: Vec<Resonance>,
    /// Lines after the filter: amplitude and frequency. [rate unit, Hz]
    pub sinusoid: Vec<(f64, f64)>,
    /// Filter of all noise except quantization.
    pub filter: Option<FittedFilter>,
    /// Frequency from which the spectrum was left out. \[Hz\]
    pub highest: Option<f64>,
    /// Drift of the mean that decays from the first sample: amplitude and time constant. [rate unit, s]
    pub warm_up: Option<(f64, f64)>,
}

impl FittedModel {
    /// A model without any part.
    pub(crate) fn without_parts(tau0: f64, samples: usize) -> Self {
        Self {
            tau0,
            samples,
            terms: [0.0; Term::ALL.len()],
            gauss_markov: Vec::new(),
            resonance: Vec::new(),
            sinusoid: Vec::new(),
            filter: None,
            highest: None,
            warm_up: None,
        }
    }

    /// Coefficient of a term. \[SI\]
    #[must_use]
    pub fn coefficient(&self, term: Term) -> f64 {
        self.terms[term.index()]
    }

    /// Expected Allan variances at cluster sizes in samples. [(rate unit)²]
    #[must_use]
    pub fn avar(&self, sizes: &[usize]) -> Vec<f64> {
        let mut total = self.avar_before_filter(sizes);
        if let Some(filter) = &self.filter {
            let lost = filter.reduction_of_avar(|f| self.psd_that_is_filtered(f), sizes, self.highest);
            total
                .iter_mut()
                .zip(lost)
                .for_each(|(all, lost)| *all = (*all - lost).max(MIN_VARIANCE_SHARE * *all));
        }
        for (all, &m) in total.iter_mut().zip(sizes) {
            for &(amplitude, frequency) in &self.sinusoid {
                *all += terms::sinusoid_avar(amplitude, frequency, self.tau0, m);
            }
            *all += self.warm_up_avar(m);
        }
        total
    }

    /// Allan variances of the terms, processes and resonances without the filter.
    pub(crate) fn avar_before_filter(&self, sizes: &[usize]) -> Vec<f64> {
        let tau0 = self.tau0;
        let mut total: Vec<f64> = sizes
            .iter()
            .map(|&m| {
                let coefficients = Term::ALL.into_iter().zip(self.terms);
                let of_terms: f64 = coefficients.map(|(term, value)| term.avar(value, tau0, m)).sum();
                self.gauss_markov.iter().fold(of_terms, |sum, &(sigma, time)| {
                    sum + terms::gauss_markov_avar_sampled(sigma, time, tau0, m)
                })
            })
            .collect();
        for band in &self.resonance {
            total.iter_mut().zip(band.avar_unfolded(tau0, sizes)).for_each(|(all, part)| *all += part);
        }
        total
    }

    /// Two-sided density before the filter of the noise on which it acts. [(rate unit)²/Hz]
    #[must_use]
    pub fn psd_before_filter(&self, f: f64) -> f64 {
        let tau0 = self.tau0;
        // The filter does not act on quantization noise, and a ramp has no density.
        let filtered = Term::NOISE.into_iter().filter(|&term| term != Term::Quantization);
        let present = filtered.map(|term| (term, self.coefficient(term))).filter(|&(_, value)| value != 0.0);
        let mut total: f64 = present.map(|(term, value)| term.psd(value, tau0, f)).sum();
        for &(sigma, time) in &self.gauss_markov {
            total += psd::gauss_markov_sampled(sigma, time, tau0, f);
        }
        self.resonance.iter().fold(total, |sum, band| sum + band.psd(f))
    }

    /// The part of this density on which the filter acts. [(rate unit)²/Hz]
    pub(crate) fn psd_that_is_filtered(&self, f: f64) -> f64 {
        match &self.filter {
            Some(filter) if filter.of_white => psd::random_walk(self.coefficient(Term::RandomWalk)),
            _ => self.psd_before_filter(f),
        }
    }

    /// Two-sided densities after the filter; lines, ramp and warm-up have none. [(rate unit)²/Hz]
    #[must_use]
    pub fn psd(&self, frequencies: &[f64]) -> Vec<f64> {
        let ones = || vec![1.0; frequencies.len()];
        let powers = self.filter.as_ref().map_or_else(ones, |filter| filter.powers(frequencies));
        let of_white = self.filter.as_ref().is_some_and(|filter| filter.of_white);
        let white = psd::random_walk(self.coefficient(Term::RandomWalk));
        let quantization = self.coefficient(Term::Quantization);
        let density = |(&f, power): (&f64, f64)| {
            let all = self.psd_before_filter(f);
            let filtered = if of_white { white } else { all };
            filtered * power + (all - filtered) + psd::quantization_sampled(quantization, self.tau0, f)
        };
        frequencies.iter().zip(powers).map(density).collect()
    }

    /// Contribution of the drift A e^(−t/T) to the overlapped Allan variance: the mean over the pairs of clusters of
    /// A² e^(−2t/T) (1 − e^(−τ/T))⁴ / (2 (τ/T)²).
    fn warm_up_avar(&self, m: usize) -> f64 {
        let Some((amplitude, time)) = self.warm_up else { return 0.0 };
        let tau = m as f64 * self.tau0;
        let (share, duration) = (tau / time, self.samples as f64 * self.tau0);
        let pairs = ((duration - 2.0 * tau) / time).max(MIN_PAIRS);
        let mean = -(-2.0 * pairs).exp_m1() / (2.0 * pairs);
        0.5 * amplitude * amplitude * mean * ((-share).exp_m1().powi(2) / share).powi(2)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::allan::{Counting, Overlap, allan_variances};
    use crate::likelihood::filter::FilterShape;

    pub(crate) fn white(tau0: f64) -> FittedModel {
        FittedModel { terms: [0.0, 1.0, 0.0, 0.0, 0.0], ..FittedModel::without_parts(tau0, 200_000) }
    }

    /// σ²(m) = 4 ∫ S sin⁴(πfmτ₀)/(m sin πfτ₀)² df of every part with a density.
    #[test]
    fn variance_is_the_integral_of_the_density() {
        let coefficients = vec![0.3, 0.1];
        let filter = FittedFilter {
            coefficients,
            tau0: 0.01,
            interval: 0.01,
            shape: FilterShape::Uneven,
            order: None,
            corner: None,
            low_pass: None,
            known_to: None,
            damping: None,
            analog: false,
            of_white: false,
        };
        let model = FittedModel {
            terms: [0.001, 1.0, 0.5, 0.1, 0.0],
            gauss_markov: vec![(2.0, 0.3)],
            resonance: vec![Resonance { sigma: 3.0, frequency: 12.0, width: 1.0 }],
            filter: Some(filter),
            ..white(0.01)
        };
        let sizes = [1, 3, 10];
        let expected = psd::avar_of_density(|f| model.psd(&[f])[0], 200_000, 0.01, &sizes);
        for (avar, expected) in model.avar(&sizes).iter().zip(expected) {
            // The integral of the rate random walk's density begins at half a step.
            assert!((avar / expected - 1.0).abs() < 1e-3, "{avar} instead of {expected}");
        }
    }

    #[test]
    fn warm_up_and_line_are_those_of_their_samples() {
        let (tau0, n) = (0.01, 200_000);
        let (size, time, amplitude, frequency) = (0.05, 150.0, 0.02, 0.013);
        let model = FittedModel {
            terms: [0.0; Term::ALL.len()],
            warm_up: Some((size, time)),
            sinusoid: vec![(amplitude, frequency)],
            ..white(tau0)
        };
        let rate: Vec<f64> = (0..n)
            .map(|k| {
                let t = f64::from(k) * tau0;
                size * (-t / time).exp() + amplitude * (std::f64::consts::TAU * frequency * t).sin()
            })
            .collect();
        let sizes = [100, 1000, 10_000];
        let measured = allan_variances(&[&rate], &sizes, Overlap::Full, Counting::Standard, None).unwrap();
        for (expected, measured) in model.avar(&sizes).iter().zip(&measured[0]) {
            assert!((measured.avar / expected - 1.0).abs() < 0.1, "{} instead of {expected}", measured.avar);
        }
    }
}
