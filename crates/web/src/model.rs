//! The model that the page shows: coefficients of the terms, a Gauss-Markov process and a filter of the white noise.

use sigmatau_core::bandlimited::{Filter, band_limited_avar};
use sigmatau_core::psd;
use sigmatau_core::terms::{self, NOISE_TERMS, Term};

/// Number of parts: the five terms and the Gauss-Markov process.
pub const PARTS: usize = NOISE_TERMS + 2;

/// Place of the Gauss-Markov process among the parts.
pub const PROCESS: usize = NOISE_TERMS + 1;

/// Number of values that describe a model.
pub const MODEL_VALUES: usize = 10;

/// The noise of one channel, in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Model {
    /// Coefficients in the order of [`Term::ALL`]; 0 for an absent term.
    pub terms: [f64; NOISE_TERMS + 1],
    /// Standard deviation of the Gauss-Markov process; 0 for none.
    pub sigma: f64,
    /// Its correlation time. \[s\]
    pub time: f64,
    /// Order of the Butterworth filter in front of the sampler; 0 for none.
    pub order: u8,
    /// Its corner. \[Hz\]
    pub corner: f64,
    /// Sample interval. \[s\]
    pub tau0: f64,
}

impl Model {
    /// The model of the first [`MODEL_VALUES`] values, and the values after them.
    ///
    /// # Panics
    ///
    /// If there are fewer values.
    #[must_use]
    pub fn split(values: &[f64]) -> (Self, &[f64]) {
        let (head, rest) = values.split_at(MODEL_VALUES);
        let terms = std::array::from_fn(|k| head[k]);
        let [sigma, time, order, corner, tau0] = std::array::from_fn(|k| head[NOISE_TERMS + 1 + k]);
        (Self { terms, sigma, time, order: order as u8, corner, tau0 }, rest)
    }

    /// Coefficient of a term.
    #[must_use]
    pub fn coefficient(&self, term: Term) -> f64 {
        self.terms[term.index()]
    }

    fn is_filtered(&self, term: Term) -> bool {
        term == Term::RandomWalk && self.order > 0
    }

    /// Allan variances of each part at the cluster sizes, one part after the other.
    #[must_use]
    pub fn avar(&self, sizes: &[usize]) -> Vec<f64> {
        let of_term = |term: Term| -> Vec<f64> {
            let coefficient = self.coefficient(term);
            if self.is_filtered(term) {
                let filter = Filter::Butterworth(self.order);
                return band_limited_avar(coefficient, filter, self.corner, self.tau0, sizes);
            }
            sizes.iter().map(|&m| term.avar(coefficient, self.tau0, m)).collect()
        };
        let process = |&m: &usize| terms::gauss_markov_avar_sampled(self.sigma, self.time, self.tau0, m);
        Term::ALL.into_iter().flat_map(of_term).chain(sizes.iter().map(process)).collect()
    }

    /// Two-sided densities of each part of the samples at the frequencies, one part after the other. That of the ramp is
    /// conventional.
    #[must_use]
    pub fn psd(&self, frequencies: &[f64]) -> Vec<f64> {
        let of_term = |term: Term, f: f64| {
            let coefficient = self.coefficient(term);
            if self.is_filtered(term) {
                // Far above the corner, the sum over the poles is rounding error of either sign.
                psd::band_limited_sampled(coefficient, self.order, self.corner, self.tau0, f).max(0.0)
            } else {
                term.psd(coefficient, self.tau0, f)
            }
        };
        let of_terms =
            Term::ALL.into_iter().flat_map(|term| frequencies.iter().map(move |&f| of_term(term, f)));
        let process = |&f: &f64| psd::gauss_markov_sampled(self.sigma, self.time, self.tau0, f);
        of_terms.chain(frequencies.iter().map(process)).collect()
    }
}

/// Sum of the parts, one value for each size or frequency.
#[must_use]
pub fn total(parts: &[f64], count: usize) -> Vec<f64> {
    (0..count).map(|k| parts.iter().skip(k).step_by(count).sum()).collect()
}
