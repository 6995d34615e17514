//! Information in the powers of a record with missing samples, whose mask correlates the powers of different frequencies.

use crate::likelihood::expected::Part;
use crate::likelihood::masked::Masked;
use crate::likelihood::masked::differences::Differences;
use crate::likelihood::masked::windows::spectrum;
use crate::terms::Term;
use std::f64::consts::PI;

/// Covariance of the values in the segments, times τ₀: of a value with itself, and with the value one step later.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Levels {
    own: f64,
    next: f64,
}

impl Masked {
    /// The two terms for which the information left by the mask is known: first the term with white values in the segments,
    /// then the term that also has a covariance at one step.
    pub(crate) fn plain_terms(&self) -> [Part; 2] {
        if self.seen.differences.used {
            [Part::Term(Term::RateRandomWalk), Part::Term(Term::RandomWalk)]
        } else {
            [Part::Term(Term::RandomWalk), Part::Term(Term::Quantization)]
        }
    }

    /// Contribution of these two terms, with these squared coefficients, to the covariance.
    pub(crate) fn levels(&self, [white, stepped]: [f64; 2], tau0: f64) -> Levels {
        let Differences { step, used } = self.seen.differences;
        if used {
            return Levels { own: white * step as f64 * tau0 * tau0 + 2.0 * stepped, next: -stepped };
        }
        let next = if step == 1 { -stepped / tau0 } else { 0.0 };
        Levels { own: white + 2.0 * stepped / tau0, next }
    }

    /// Degrees of freedom of a mean of `count` neighbouring densities, over those without missing samples. Isolated losses
    /// do not reduce the freedom of a single density; long gaps reduce it by their share.
    pub(crate) fn freedom_share(&self, count: usize) -> f64 {
        let n = count as f64;
        let mean = |spread: &[f64]| {
            let beside = (1..count.min(spread.len())).map(|d| 2.0 * (1.0 - d as f64 / n) * spread[d]);
            spread[0] + beside.sum::<f64>()
        };
        mean(&self.windows.spread_of_whole) / mean(&self.windows.spread)
    }

    /// Information on a term in all bins of the periodogram together, over that of independent and complete bins.
    ///
    /// It compares the variance that the fit assumes with the variance of Σ x P for the covariance of the powers P of the
    /// two plain terms with this mask, where x are the weights of the term in the fit. `weights` are x by density; `noise`
    /// are the expected densities of the two terms.
    pub(crate) fn information_share(&self, weights: &[f64], noise: &[f64], levels: Levels) -> f64 {
        let period = 2 * (weights.len() - 1);
        let Levels { own, next } = levels;
        let step = self.seen.differences.step as f64;
        let plain: Vec<f64> = weights.iter().zip(&self.seen.gains).map(|(x, gain)| x / gain).collect();
        let turned: Vec<f64> = plain
            .iter()
            .enumerate()
            .map(|(k, x)| x * (2.0 * PI * k as f64 * step / period as f64).cos())
            .collect();
        let seen: Vec<f64> = weights.iter().zip(noise).map(|(x, s)| x * s).collect();
        let [plain, turned, seen] = [&plain, &turned, &seen].map(|x| spectrum(x, period));
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
