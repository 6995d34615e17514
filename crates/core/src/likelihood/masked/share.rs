//! How much the powers of a record with missing samples say: the mask makes those of different frequencies go together.

use crate::likelihood::masked::Masked;
use crate::likelihood::masked::windows::spectrum;
use std::f64::consts::PI;

/// Levels of quantization noise and random walk: Q² and N².
#[derive(Debug, Clone, Copy)]
pub(crate) struct Levels {
    pub quantization: f64,
    pub random_walk: f64,
}

impl Masked {
    /// Degrees of freedom of a mean of so many neighbouring densities, over those without missing samples. Isolated losses
    /// leave a single density its freedom, long gaps take their share away.
    pub(crate) fn freedom_left(&self, count: usize) -> f64 {
        let n = count as f64;
        let mean = |spread: &[f64]| {
            let beside = (1..count.min(spread.len())).map(|d| 2.0 * (1.0 - d as f64 / n) * spread[d]);
            spread[0] + beside.sum::<f64>()
        };
        mean(&self.windows.spread_of_whole) / mean(&self.windows.spread)
    }

    /// Information on a term in all bins of the periodogram together, over that of bins which are independent and complete.
    ///
    /// The variance of Σ x P, with the weights x that the term has in the fit, for the covariance of the powers P of
    /// quantization noise and random walk with this mask, against the variance that the fit assumes. `weights`: x by
    /// density; `noise`: expected densities of these two.
    pub(crate) fn information_left(&self, weights: &[f64], noise: &[f64], levels: Levels, tau0: f64) -> f64 {
        let period = 2 * (weights.len() - 1);
        let own = levels.random_walk + 2.0 * levels.quantization / tau0;
        let next = -levels.quantization / tau0;
        let turned: Vec<f64> = weights
            .iter()
            .enumerate()
            .map(|(k, x)| x * (2.0 * PI * k as f64 / period as f64).cos())
            .collect();
        let seen: Vec<f64> = weights.iter().zip(noise).map(|(x, s)| x * s).collect();
        let [plain, turned, seen] = [weights, &turned, &seen].map(|x| spectrum(x, period));
        let [squares, both, pairs] = &self.windows.laws;
        let (mut above, mut below) = (0.0, 0.0);
        for t in 0..plain.len() {
            let times = if t == 0 || t + 1 == plain.len() { 1.0 } else { 2.0 };
            above += times * seen[t].powi(2) * self.windows.law_of_whole[t];
            below += times
                * (own * own * plain[t].powi(2) * squares[t]
                    + 4.0 * own * next * plain[t] * turned[t] * both[t]
                    + 4.0 * next * next * turned[t].powi(2) * pairs[t]);
        }
        above / below
    }
}
