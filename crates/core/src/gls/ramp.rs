//! Estimate and test of the rate ramp, a deterministic term with a sign, for given noise.
//!
//! A rate random walk resembles a ramp of about K/√T. The test is whether the ramp of the record is larger than its noise
//! explains. The mean second difference at each averaging time is an estimate of the ramp. The covariance of these
//! estimates is known for any noise, and the weighted mean with the smallest variance is used. The noise is fitted to the
//! variances after the removal of that ramp, so that it does not include the ramp with which it is compared.

use crate::distributions::{normal_quantile, student_below, student_quantile};
use crate::gls::components::Components;
use crate::gls::covariance::{ramp_covariance, times};
use crate::gls::non_negative::relative_fit;
use crate::gls::step::{Gls, Work};
use crate::gls::{Failed, TERMS, Theta, finite};

/// Small number that is added to the diagonal of correlations.
const RIDGE: f64 = 1e-9;

const MAX_FREEDOM: f64 = 1e9;

/// Degrees of freedom if the rate random walk is poorly determined: the limit is then t = 6.2, which weak walks exceed in
/// fewer than 5 % of records.
const MIN_FREEDOM: f64 = 1.5;

/// Two-sided p-value of a ramp that would be significant if the noise were known exactly.
const SUSPICIOUS_P_VALUE: f64 = 0.05;

/// Relative errors of the rough fit for the initial weights.
const ROUGH_TOLERANCE: f64 = 0.1;

/// Estimate of a ramp per sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ramp {
    /// Estimate and standard error for the fitted noise.
    pub value: f64,
    pub error: f64,
    /// Degrees of freedom of the squared error.
    pub freedom: f64,
    /// Two-sided p-value of the ramp.
    pub p_value: f64,
    /// The ramp removed from the Allan variances: the value, or 0 if it is not significant.
    pub used: f64,
}

impl Ramp {
    pub(crate) fn suspicious(&self) -> bool {
        self.value.abs() > -normal_quantile(0.5 * SUSPICIOUS_P_VALUE) * self.error
    }

    /// Half width of the interval of the ramp.
    pub(crate) fn half_width(&self, level: f64) -> f64 {
        student_quantile(self.freedom, 0.5 + 0.5 * level) * self.error
    }
}

impl Gls {
    /// The problem after the removal of the ramp Σ weights·ramps. The mean of z² becomes that of (z − ramp·m²)².
    /// The variance v of the ramp and its covariance c with each estimate are known, and hence the expected variances after
    /// its removal.
    ///
    /// # Panics
    ///
    /// If the numbers of weights, ramps and sizes differ.
    #[must_use]
    pub fn without_ramp(&self, weights: &[f64], ramps: &[f64]) -> Self {
        assert!(weights.len() == self.order() && ramps.len() == self.order(), "one for each size");
        let ramp: f64 = weights.iter().zip(ramps).map(|(weight, ramp)| weight * ramp).sum();
        let mut ramp_removed = self.clone();
        ramp_removed.ramp_weights = Some(weights.to_vec());
        for ((avar, square), one) in ramp_removed.avar.iter_mut().zip(self.squares()).zip(ramps) {
            *avar -= ramp * square * (one - 0.5 * ramp);
        }
        let (mut upper, mut c) = (Vec::new(), Vec::new());
        for (p, row) in ramp_removed.design.chunks_exact_mut(self.order()).enumerate() {
            ramp_covariance(&self.parts, self.first, &unit(p), &mut upper);
            times(&upper, weights, &mut c);
            let v: f64 = c.iter().zip(weights).map(|(c, weight)| c * weight).sum();
            for ((cell, square), c) in row.iter_mut().zip(self.squares()).zip(&c) {
                *cell -= square * (c - 0.5 * v);
            }
        }
        ramp_removed
    }

    /// The ramp, the problem after its removal, and the θ of that problem. `theta` is the fit of this problem, from which
    /// the weights start if there is no better start; `ramps` are mean second differences over m².
    pub(crate) fn ramp(
        &self,
        theta: &Theta,
        ramps: &[f64],
        level: f64,
        work: &mut Work,
    ) -> Result<(Ramp, Self, Theta), Failed> {
        // A fit without the ramp is useless if the ramp is large; for the weights a rough fit with a ramp is sufficient.
        let drift: Vec<f64> = self.squares().iter().map(|square| 0.5 * square).collect();
        let columns: Vec<&[f64]> = self.design.chunks_exact(self.order()).chain([&drift[..]]).collect();
        let rough = relative_fit(&columns, &self.avar, &vec![ROUGH_TOLERANCE; self.order()])?;
        let mut theta = *theta;
        let begin: Theta = std::array::from_fn(|p| if self.candidates.contains(p) { rough[p] } else { 0.0 });
        if begin.iter().any(|&value| value > 0.0) {
            theta = begin;
        }
        let (mut weights, mut value) = self.combined(&theta, ramps)?;
        let mut ramp_removed = self.without_ramp(&weights, ramps);
        for again in [true, false] {
            if ramp_removed.avar.iter().any(|&avar| avar.is_nan() || avar <= 0.0) {
                // The record is a ramp without noise.
                return Err(Failed);
            }
            theta = ramp_removed.fit_in(ramp_removed.candidates, None, None, work)?;
            if again {
                (weights, value) = self.combined(&theta, ramps)?;
                ramp_removed = self.without_ramp(&weights, ramps);
            }
        }
        let (error, freedom) = ramp_removed.error_of_ramp(&theta, &weights, work)?;
        let p_value = finite(2.0 * student_below(freedom, -value.abs() / error))?;
        let used = if p_value < 1.0 - level { value } else { 0.0 };
        Ok((Ramp { value, error, freedom, p_value, used }, ramp_removed, theta))
    }

    /// The best weights for θ, and the ramp.
    fn combined(&self, theta: &Theta, ramps: &[f64]) -> Result<(Vec<f64>, f64), Failed> {
        let weights = self.least_variance(theta)?;
        let value = weights.iter().zip(ramps).map(|(weight, ramp)| weight * ramp).sum();
        Ok((weights, finite(value)?))
    }

    /// Standard error of the ramp for θ, and the degrees of freedom of its square, from the covariance of θ.
    fn error_of_ramp(&self, theta: &Theta, weights: &[f64], work: &mut Work) -> Result<(f64, f64), Failed> {
        let (mut upper, mut c) = (Vec::new(), Vec::new());
        let mut by_term = [0.0; TERMS];
        for (p, own) in by_term.iter_mut().enumerate().take(self.parts.terms()) {
            ramp_covariance(&self.parts, self.first, &unit(p), &mut upper);
            times(&upper, weights, &mut c);
            *own = c.iter().zip(weights).map(|(c, weight)| c * weight).sum();
        }
        let variance: f64 = by_term.iter().zip(theta).map(|(one, theta)| one * theta).sum();
        let covariance = self.covariance_of_theta_in(theta, self.candidates, work)?;
        let used: Vec<f64> = self.candidates.iter().map(|p| by_term[p]).collect();
        let rows = covariance.chunks_exact(used.len()).zip(&used);
        let scatter: f64 =
            rows.map(|(row, by)| by * row.iter().zip(&used).map(|(x, by)| x * by).sum::<f64>()).sum();
        let freedom = if scatter > 0.0 { 2.0 * variance * variance / scatter } else { MAX_FREEDOM };
        Ok((finite(variance.sqrt())?, freedom.clamp(MIN_FREEDOM, MAX_FREEDOM)))
    }

    /// Weights of the ramps with sum 1 and the smallest variance of the weighted mean, for noise θ.
    ///
    /// # Errors
    ///
    /// [`Failed`] if there is no noise with which a ramp can be compared.
    pub fn least_variance(&self, theta: &Theta) -> Result<Vec<f64>, Failed> {
        let mut upper = Vec::new();
        ramp_covariance(&self.parts, self.first, theta, &mut upper);
        let order = self.order();
        let sd: Vec<f64> = upper.iter().step_by(order + 1).map(|variance| variance.sqrt()).collect();
        if !sd.iter().all(|&sd| sd > 0.0 && sd.is_finite()) {
            return Err(Failed);
        }
        // Elimination without square roots, because rounding may make the matrix slightly indefinite.
        let mut solved: Vec<f64> = sd.iter().map(|sd| 1.0 / sd).collect();
        for i in 0..order {
            for j in i..order {
                upper[i * order + j] /= sd[i] * sd[j];
            }
            upper[i * (order + 1)] += RIDGE;
        }
        for i in 0..order {
            let (above, below) = upper.split_at_mut((i + 1) * order);
            let row = &above[i * order..];
            for k in i + 1..order {
                let factor = row[k] / row[i];
                let cells = below[(k - i - 1) * order + k..(k - i) * order].iter_mut().zip(&row[k..]);
                cells.for_each(|(x, u)| *x -= factor * u);
                solved[k] -= factor * solved[i];
            }
        }
        for i in (0..order).rev() {
            let row = &upper[i * order..(i + 1) * order];
            let known: f64 = row[i + 1..].iter().zip(&solved[i + 1..]).map(|(u, x)| u * x).sum();
            solved[i] = (solved[i] - known) / row[i];
        }
        solved.iter_mut().zip(&sd).for_each(|(x, sd)| *x /= sd);
        let total = finite(1.0 / solved.iter().sum::<f64>())?;
        for x in &mut solved {
            *x *= total;
        }
        Ok(solved)
    }
}

/// The ramp per sample that the test detects with probability `power` in a record with noise θ.
///
/// # Errors
///
/// [`Failed`].
pub fn least_ramp(parts: &Components, theta: &Theta, level: f64, power: f64) -> Result<f64, Failed> {
    let order = parts.base.order();
    let gls = Gls::new(parts, 0, &vec![1.0; order], crate::gls::Terms::first(parts.terms()), None);
    let gls = gls.with_expected(theta);
    let weights = gls.least_variance(theta)?;
    let ramp_removed = gls.without_ramp(&weights, &vec![0.0; order]);
    let (error, freedom) = ramp_removed.error_of_ramp(theta, &weights, &mut Work::default())?;
    finite((student_quantile(freedom, 0.5 + 0.5 * level) + normal_quantile(power)) * error)
}

fn unit(term: usize) -> Theta {
    std::array::from_fn(|p| if p == term { 1.0 } else { 0.0 })
}
