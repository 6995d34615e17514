//! The fit of a curve in SI: coefficients with intervals or limits, their covariance, and the descriptive model.

use crate::gls::attempt::Data;
use crate::gls::components::Base;
use crate::gls::statement::{AdequateFit, Described, Outcome, Ramps, fit};
use crate::gls::{Failed, LINEAR, Terms};
use crate::likelihood::{Estimate, GaussMarkovEstimate, TermEstimate};
use crate::terms::Term;
use std::sync::Arc;

const RAMP: usize = LINEAR;

/// A curve to be fitted, in SI.
#[derive(Debug, Clone)]
pub struct Curve {
    /// The noise terms at the averaging times.
    pub base: Arc<Base>,
    /// Sample interval. \[s\]
    pub tau0: f64,
    /// Allan variances, and a typical Allan variance. [(rate unit)²]
    pub avar: Vec<f64>,
    /// See `avar`.
    pub scale: f64,
    /// Ramps from the mean second differences. [rate unit / s]
    pub ramps: Vec<f64>,
    /// Noise terms that are fitted.
    pub candidates: Terms,
    /// Whether a ramp is fitted.
    pub with_ramp: bool,
    /// Index of the shortest averaging time, if it is given.
    pub first: Option<usize>,
    /// Relative covariance of the errors of the variances from reading a figure, in row order; None for a computed curve.
    pub digitising: Option<Arc<Vec<f64>>>,
}

/// The fit of a curve.
#[derive(Debug, Clone, PartialEq)]
pub struct CurveFit {
    /// Whether a model is adequate. Otherwise the coefficients of `model` describe the curve to a few per cent.
    pub adequate: bool,
    /// Index of the shortest averaging time that was used.
    pub first: usize,
    /// P-value of the goodness of fit; the largest of all models if none is adequate, None if no model could be fitted.
    pub p_value: Option<f64>,
    /// Whether a model was adequate, but its covariance is not positive definite.
    pub no_covariance: bool,
    /// Terms that were fitted, by name; none if no model is adequate. \[SI\]
    pub terms: Vec<(&'static str, TermEstimate)>,
    /// Coefficients that together describe the curve, by name. \[SI\]
    pub model: Vec<(&'static str, f64)>,
    /// Terms of which at least one is present, although none is significant given the others.
    pub unclear: Vec<&'static str>,
    /// A Gauss-Markov process in place of a term.
    pub gauss_markov: Vec<GaussMarkovEstimate>,
    /// Names of the rows of `covariance`.
    pub parameters: Vec<&'static str>,
    /// Covariance of the coefficients of noise in row order. \[SI\]
    pub covariance: Vec<f64>,
    /// The averaging time with the largest difference from the model, if times were left out or no model is adequate: its
    /// index, and the measured deviation over that of the model.
    pub worst: Option<(usize, f64)>,
}

impl Curve {
    /// Selects a model, fits and tests it.
    ///
    /// # Errors
    ///
    /// [`Failed`] for variances that are not positive numbers.
    pub fn fit(&self, level: f64) -> Result<CurveFit, Failed> {
        let data = Data {
            base: self.base.clone(),
            avar: self.avar.iter().map(|avar| avar / self.scale).collect(),
            ramps: self.ramps.iter().map(|ramp| ramp * self.tau0 / self.scale.sqrt()).collect(),
            candidates: self.candidates,
            with_ramp: self.with_ramp,
            first: self.first,
            digitising: self.digitising.clone(),
        };
        Ok(match fit(&data, level)? {
            Outcome::Adequate(result) => self.stated(&result, level),
            Outcome::Described(result) => self.described(&result),
        })
    }

    /// A coefficient in SI from its square θ in samples.
    fn coefficient(&self, theta: f64, term: usize) -> f64 {
        (theta * self.scale).max(0.0).sqrt()
            * self.tau0.powf(1.0 - 0.5 * f64::from(Term::ALL[term].interval_power()))
    }

    fn stated(&self, result: &AdequateFit, level: f64) -> CurveFit {
        let positive: Vec<usize> = (0..LINEAR).filter(|&term| result.theta[term] > 0.0).collect();
        let values: Vec<f64> =
            positive.iter().map(|&term| self.coefficient(result.theta[term], term)).collect();
        // The delta method converts from θ to √θ.
        let slopes: Vec<f64> =
            positive.iter().zip(&values).map(|(&term, value)| value / (2.0 * result.theta[term])).collect();
        let order = positive.len();
        let covariance: Vec<f64> = (0..order * order)
            .map(|k| result.covariance[k] * (slopes[k / order] * slopes[k % order]))
            .collect();
        let mut terms: Vec<(&str, TermEstimate)> = Vec::new();
        for term in self.candidates.iter().filter(|&term| term < LINEAR) {
            let row = positive.iter().position(|&present| present == term);
            let estimate = result.evidence[term].map_or_else(TermEstimate::default, |evidence| {
                let [low, high] = [evidence.low, evidence.high].map(|end| self.coefficient(end, term));
                if result.observed.contains(term) {
                    let error = row.map_or(0.0, |row| covariance[row * (order + 1)].max(0.0).sqrt());
                    let value = row.map_or(0.0, |row| values[row]);
                    TermEstimate::significant(value, [low, high], error, evidence.p_value, level)
                } else {
                    TermEstimate::limited(Some(high), evidence.p_value)
                }
            });
            terms.push((Term::ALL[term].name(), estimate));
        }
        let parameters: Vec<&str> = positive.iter().map(|&term| Term::ALL[term].name()).collect();
        let mut model: Vec<(&str, f64)> = parameters.iter().copied().zip(values).collect();
        let mut unclear: Vec<&str> =
            result.unclear.into_iter().flat_map(Terms::iter).map(|term| Term::ALL[term].name()).collect();
        if let Some(ramp) = result.ramp {
            let estimate = self.ramp(ramp, level);
            terms.push((Term::RateRamp.name(), estimate));
            model.extend(estimate.value.map(|value| (Term::RateRamp.name(), value)));
            if ramp.undecided && result.unclear.is_some() {
                unclear.push(Term::RateRamp.name());
            }
        }
        let gauss_markov = result.process.map(|(size, time)| GaussMarkovEstimate {
            sigma: interval(size.map(|x| self.scale.sqrt() * x)),
            time: interval(time.map(|x| self.tau0 * x)),
        });
        CurveFit {
            adequate: true,
            first: result.first,
            p_value: Some(result.p_value),
            no_covariance: false,
            terms,
            model,
            unclear,
            gauss_markov: gauss_markov.into_iter().collect(),
            parameters,
            covariance,
            worst: result.left_out,
        }
    }

    fn ramp(&self, ramp: Ramps, level: f64) -> TermEstimate {
        let factor = self.scale.sqrt() / self.tau0;
        let [low, high] =
            [ramp.value - ramp.half_width, ramp.value + ramp.half_width].map(|end| end * factor);
        if ramp.p_value >= 1.0 - level {
            return TermEstimate {
                upper_limit: Some(low.abs().max(high.abs())),
                p_value: Some(ramp.p_value),
                ..TermEstimate::default()
            };
        }
        TermEstimate {
            observed: true,
            value: Some(ramp.value * factor),
            low: Some(low),
            high: Some(high),
            p_value: Some(ramp.p_value),
            ..TermEstimate::default()
        }
    }

    /// The sign of the ramp is taken at the longest averaging time.
    fn described(&self, result: &Described) -> CurveFit {
        let sign = self.ramps.last().map_or(1.0, |ramp| ramp.signum());
        let model = result
            .needed
            .iter()
            .map(|term| {
                let value = self.coefficient(result.theta[term], term);
                (Term::ALL[term].name(), if term == RAMP { value.copysign(sign) } else { value })
            })
            .collect();
        CurveFit {
            adequate: false,
            first: result.first,
            p_value: result.p_value,
            no_covariance: result.no_covariance,
            terms: Vec::new(),
            model,
            unclear: Vec::new(),
            gauss_markov: Vec::new(),
            parameters: Vec::new(),
            covariance: Vec::new(),
            worst: Some(result.worst),
        }
    }
}

fn interval([value, low, high]: [f64; 3]) -> Estimate {
    Estimate { value, low: Some(low), high: Some(high) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terms;

    const TAU0: f64 = 0.01;

    fn curve(n: usize, avar: impl Fn(usize) -> f64, with_ramp: bool) -> Curve {
        let sizes: Vec<usize> = (0..14)
            .flat_map(|j| [1 << j, 3 << j])
            .filter(|&m: &usize| 3 * m <= n)
            .collect::<std::collections::BTreeSet<_>>()
            .into_iter()
            .collect();
        let avar: Vec<f64> = sizes.iter().map(|&m| avar(m)).collect();
        Curve {
            base: Base::new(n, &sizes).unwrap(),
            tau0: TAU0,
            scale: avar[avar.len() / 2],
            ramps: vec![-1e-9; avar.len()],
            avar,
            candidates: Terms::first(LINEAR),
            with_ramp,
            first: None,
            digitising: None,
        }
    }

    /// An error of the scale of a figure is common to all averaging times, and changes all coefficients by its factor.
    #[test]
    fn error_of_the_scale_widens_every_interval() {
        let (walk, slow) = (1e-4, 3e-6);
        let avar = |m: usize| {
            terms::random_walk_avar(walk, m as f64 * TAU0)
                + terms::rate_random_walk_avar_sampled(slow, TAU0, m)
        };
        let alone = curve(1 << 16, avar, false);
        let order = alone.avar.len();
        let error: f64 = 0.03; // of a deviation
        let read =
            Curve { digitising: Some(Arc::new(vec![4.0 * error * error; order * order])), ..alone.clone() };
        let (alone, read) = (alone.fit(0.95).unwrap(), read.fit(0.95).unwrap());
        for (name, expected) in [("random_walk", walk), ("rate_random_walk", slow)] {
            let half = |fit: &CurveFit| {
                let term = fit.terms.iter().find(|(term, _)| *term == name).unwrap().1;
                assert!((term.value.unwrap() / expected - 1.0).abs() < 1e-3);
                0.5 * (term.high.unwrap() - term.low.unwrap()) / expected
            };
            let sum = half(&alone).hypot(1.96 * error);
            assert!((half(&read) / sum - 1.0).abs() < 0.1, "{name}: {} {sum}", half(&read));
        }
        let added = (read.covariance[1] - alone.covariance[1]) / (error * error * walk * slow);
        assert!((added - 1.0).abs() < 0.1, "the factor is common to both coefficients: {added}");
    }

    #[test]
    fn coefficients_are_in_si() {
        let (walk, slow) = (1e-4, 3e-6);
        let avar = |m: usize| {
            terms::random_walk_avar(walk, m as f64 * TAU0)
                + terms::rate_random_walk_avar_sampled(slow, TAU0, m)
        };
        let fit = curve(1 << 16, avar, true).fit(0.95).unwrap();
        assert!(fit.adequate && fit.worst.is_none());
        assert_eq!(fit.parameters, ["random_walk", "rate_random_walk"]);
        for (name, expected) in [("random_walk", walk), ("rate_random_walk", slow)] {
            let term = fit.terms.iter().find(|(term, _)| *term == name).unwrap().1;
            assert!((term.value.unwrap() / expected - 1.0).abs() < 1e-3);
            assert!(term.low.unwrap() < expected && expected < term.high.unwrap());
        }
        // The interval, with all terms free, is at least as wide as the standard error in the model implies.
        let width = fit.terms[1].1.high.unwrap() - fit.terms[1].1.low.unwrap();
        let ratio = width / (2.0 * 1.96 * fit.covariance[0].sqrt());
        assert!((0.95..3.0).contains(&ratio), "{ratio}");
        let ramp = fit.terms[4];
        assert_eq!((ramp.0, ramp.1.observed, ramp.1.value), ("rate_ramp", false, None));
    }

    /// No term has this variance; the model describes it, with the sign of the last ramp.
    #[test]
    fn curve_that_no_model_fits_is_described() {
        let avar = |m: usize| {
            1e-8 / (m as f64 * TAU0) * (1.0 + 0.8 * (m as f64).ln().sin()) + 1e-12 * (m as f64).powi(2)
        };
        let fit = curve(1 << 16, avar, true).fit(0.95).unwrap();
        assert!(!fit.adequate && fit.terms.is_empty() && fit.worst.is_some());
        let ramp = fit.model.iter().find(|(name, _)| *name == "rate_ramp").unwrap().1;
        assert!((ramp / -(2e-12_f64.sqrt() / TAU0) - 1.0).abs() < 0.3, "{ramp}");
    }
}
