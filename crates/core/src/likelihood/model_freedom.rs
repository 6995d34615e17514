//! Degrees of freedom of the overlapped Allan variances of a fitted model.

use crate::covariance::{Component, variances};
use crate::error::Error;
use crate::likelihood::fitted_model::FittedModel;
use crate::likelihood::lines::interpolated;
use crate::terms::{self, NOISE_TERMS, Term};

/// Largest number of cluster sizes with exact degrees of freedom; others are interpolated.
const MAX_EXACT: usize = 100;

impl FittedModel {
    /// Degrees of freedom 2 E²/Var of the Allan variances of the terms, processes and lines; None for a model without
    /// noise, because a line alone has no scatter. They are exact for up to 100 sizes, otherwise interpolated between 100
    /// sizes.
    ///
    /// # Errors
    ///
    /// For a size that is 0 or above half the record.
    pub fn degrees_of_freedom(&self, sizes: &[usize]) -> Result<Option<Vec<f64>>, Error> {
        // for samples 1 s apart
        let of_samples = |term: Term| {
            let root = self.coefficient(term) * self.tau0.powf(0.5 * f64::from(term.interval_power()) - 1.0);
            root * root
        };
        let theta = Term::NOISE.map(of_samples);
        if theta.iter().all(|&theta| theta == 0.0) && self.gauss_markov.is_empty() {
            return Ok(None);
        }
        let mut grid = sizes.to_vec();
        grid.sort_unstable();
        grid.dedup();
        if grid.len() > MAX_EXACT {
            grid = thinned(&grid);
        }
        let exact = self.freedom_at(&grid, theta)?;
        let centres: Vec<(f64, f64)> =
            grid.iter().zip(exact).map(|(&m, edf)| ((m as f64).ln(), edf.ln())).collect();
        Ok(Some(sizes.iter().map(|&m| interpolated(&centres, (m as f64).ln()).exp()).collect()))
    }

    fn freedom_at(&self, sizes: &[usize], theta: [f64; NOISE_TERMS]) -> Result<Vec<f64>, Error> {
        // The unit is chosen so that squares of the largest and the smallest numbers stay in range.
        let powers = self.gauss_markov.iter().map(|(sigma, _)| sigma * sigma);
        let unit = theta.into_iter().chain(powers.clone()).fold(0.0, f64::max);
        let theta = theta.map(|theta| theta / unit);
        let powers: Vec<f64> = powers.map(|power| power / unit).collect();
        let times: Vec<f64> = self.gauss_markov.iter().map(|(_, time)| time / self.tau0).collect();
        let ramp = self.coefficient(Term::RateRamp) * self.tau0 / unit.sqrt();
        let components: Vec<Component> = Term::NOISE
            .into_iter()
            .map(Component::Term)
            .chain(times.iter().map(|&tc| Component::GaussMarkov { tc }))
            .collect();
        let all: Vec<f64> = theta.iter().chain(&powers).copied().collect();
        let scatter = variances(self.samples, sizes, &components, &all, ramp)?;
        let roots = theta.map(f64::sqrt);
        let freedom = |(&m, mut variance): (&usize, f64)| {
            let noise = Term::NOISE.into_iter().zip(roots);
            let mut avar = terms::rate_ramp_avar(ramp, m as f64)
                + noise.map(|(term, root)| term.avar(root, 1.0, m)).sum::<f64>();
            for (power, &time) in powers.iter().zip(&times) {
                avar += power * terms::gauss_markov_avar_sampled(1.0, time, 1.0, m);
            }
            for &(amplitude, frequency) in &self.sinusoid {
                let (shape, power) =
                    (terms::sinusoid_avar(1.0, frequency * self.tau0, 1.0, m), amplitude * amplitude / unit);
                // The variance of the squared amplitude by the noise at its frequency is 8 A² S(f)/n, with S two-sided.
                let density = density(theta, frequency * self.tau0);
                variance += 8.0 / self.samples as f64 * density * power * shape * shape;
                avar += power * shape;
            }
            2.0 * avar * avar / variance
        };
        Ok(sizes.iter().zip(scatter).map(freedom).collect())
    }
}

/// Two-sided density of the noise terms at a frequency in cycles per sample.
fn density(theta: [f64; NOISE_TERMS], frequency: f64) -> f64 {
    Term::NOISE.into_iter().zip(theta).map(|(term, theta)| theta * term.psd(1.0, 1.0, frequency)).sum()
}

/// Sizes whose ranks are in a geometric series, from the first to the last.
fn thinned(sizes: &[usize]) -> Vec<usize> {
    let last = (sizes.len() as f64).ln();
    let rank = |k: usize| (last * k as f64 / (MAX_EXACT - 1) as f64).exp().round_ties_even() as usize;
    let mut ranks: Vec<usize> = (0..MAX_EXACT).map(rank).collect();
    ranks.dedup();
    ranks.into_iter().map(|rank| sizes[rank.clamp(1, sizes.len()) - 1]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::covariance::Gamma;
    use crate::likelihood::fitted_model::tests::white;

    const SIZES: [usize; 8] = [1, 2, 3, 7, 50, 400, 5000, 9999];
    const THETA: [f64; NOISE_TERMS] = [3.0, 2.0, 0.5, 1e-4];

    /// They equal those from the diagonal of the whole covariance, for any sample interval.
    #[test]
    fn equals_the_whole_covariance() {
        for time in [None, Some(4.0), Some(300.0)] {
            for ramp in [0.0, 1e-3] {
                let mut components = Term::NOISE.map(Component::Term).to_vec();
                let mut theta = THETA.to_vec();
                if let Some(tc) = time {
                    components.push(Component::GaussMarkov { tc });
                    theta.push(0.7);
                }
                let expected = Gamma::new(20_000, &SIZES, &components).unwrap().edf(&theta, ramp);
                for tau0 in [1.0, 0.01_f64] {
                    let [q, n, b, k] = THETA.map(f64::sqrt);
                    let model = FittedModel {
                        samples: 20_000,
                        terms: [q * tau0, n * tau0.sqrt(), b, k / tau0.sqrt(), ramp / tau0],
                        gauss_markov: time.map(|time| (0.7_f64.sqrt(), time * tau0)).into_iter().collect(),
                        ..white(tau0)
                    };
                    let all = model.degrees_of_freedom(&SIZES).unwrap().unwrap();
                    for (freedom, expected) in all.iter().zip(&expected) {
                        assert!((freedom / expected - 1.0).abs() < 1e-10, "{freedom} instead of {expected}");
                    }
                }
            }
        }
    }

    #[test]
    fn line_alone_has_no_scatter() {
        let line = FittedModel { terms: [0.0; Term::ALL.len()], sinusoid: vec![(1.0, 2.0)], ..white(0.01) };
        assert_eq!(line.degrees_of_freedom(&[1]), Ok(None));
    }

    #[test]
    fn many_sizes_are_interpolated() {
        let sizes: Vec<usize> = (1..=2000).collect();
        let all = white(0.01).degrees_of_freedom(&sizes).unwrap().unwrap();
        let exact = white(0.01).degrees_of_freedom(&[1, 137, 2000]).unwrap().unwrap();
        for (m, exact) in [1, 137, 2000].into_iter().zip(exact) {
            assert!((all[m - 1] / exact - 1.0).abs() < 1e-3);
        }
        assert!(white(0.01).degrees_of_freedom(&[150_000]).is_err());
    }
}
