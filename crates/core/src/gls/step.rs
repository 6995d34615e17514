//! The least squares problem of one curve, its fits, and the statistic of tests and intervals.

use crate::gls::columns::{MAX_COLUMNS, PseudoInverse, Row, last_row};
use crate::gls::components::Components;
use crate::gls::covariance::{RampRemoval, made_positive, noise_covariance, times};
use crate::gls::laws::skewed_tails;
use crate::gls::non_negative::Products;
use crate::gls::whitening::Whitened;
use crate::gls::{Failed, TERMS, Terms, Theta, finite};
use std::sync::Arc;

/// Largest number of steps of the iteration.
const STEPS: usize = 40;

/// Number of the step from which each step is averaged with the previous one.
const DAMPED_FROM: usize = 8;

/// Relative change of the expected variances at which the iteration ends.
const TOLERANCE: f64 = 1e-5;

/// Allan variances and their components for sizes from number `first`.
#[derive(Debug, Clone)]
pub struct Gls {
    pub(crate) parts: Components,
    pub(crate) first: usize,
    /// Components of the fitted terms; one row per term.
    pub(crate) design: Vec<f64>,
    pub(crate) avar: Vec<f64>,
    /// Terms that are fitted.
    pub(crate) candidates: Terms,
    /// Derivative of the variances with respect to the shape of a term, if a search determined the shape. An error of the
    /// shape is then not evidence for any term.
    pub(crate) tangent: Option<Vec<f64>>,
    /// Weights of the ramp that was removed, if any.
    pub(crate) ramp_weights: Option<Vec<f64>>,
    /// Relative covariance of the errors of the variances from reading a figure, for all sizes of the base in row order.
    pub(crate) digitising: Option<Arc<Vec<f64>>>,
}

/// Buffers of a fit, reused by the next one.
#[derive(Debug, Default)]
pub(crate) struct Work {
    pub(crate) covariance: Vec<f64>,
    pub(crate) whitened: Whitened,
    pub(crate) rows: Vec<Row>,
    removal: RampRemoval,
    expected: Vec<f64>,
    before: Vec<f64>,
    means: Vec<f64>,
    row: Vec<f64>,
    on_data: Vec<f64>,
    modes: Vec<f64>,
}

/// Comparison of the estimate of one squared coefficient with a trial value, with the others fitted for that value.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Statistic {
    /// (estimate − trial) / sigma; the estimate is unconstrained and may be negative.
    pub z: f64,
    /// Standard error of the estimate, if the trial value is true.
    pub sigma: f64,
    pub skewness: f64,
    /// The trial value, and the fitted coefficients of the other terms.
    pub theta: Theta,
}

impl Statistic {
    /// Probabilities of a smaller and of a larger estimate if the trial value is true.
    pub(crate) fn tails(&self) -> (f64, f64) {
        skewed_tails(self.z, self.skewness)
    }
}

/// A [`Statistic`] with the weights of the Allan variances in the estimate and the probability of a larger estimate.
#[derive(Debug, Clone)]
pub struct Score {
    /// (estimate − trial) / sigma.
    pub z: f64,
    /// Standard error if the trial value is true.
    pub sigma: f64,
    /// Skewness of the estimate.
    pub skewness: f64,
    /// Probability of a larger estimate.
    pub above: f64,
    /// The trial value, and the fitted coefficients of the other terms.
    pub theta: Theta,
    /// Weights of the Allan variances in the estimate.
    pub weights: Vec<f64>,
}

impl Gls {
    /// The problem for sizes from number `first`.
    ///
    /// # Panics
    ///
    /// If there is not one variance per size, or if the tangent has another length.
    #[must_use]
    pub fn new(
        parts: &Components,
        first: usize,
        avar: &[f64],
        candidates: Terms,
        tangent: Option<Vec<f64>>,
    ) -> Self {
        let order = parts.base.order() - first;
        assert_eq!(avar.len(), order, "one variance for each size");
        assert!(tangent.as_ref().is_none_or(|tangent| tangent.len() == order));
        let design = (0..parts.terms()).flat_map(|term| &parts.design(term)[first..]).copied().collect();
        Self {
            parts: parts.clone(),
            first,
            design,
            avar: avar.to_vec(),
            candidates,
            tangent,
            ramp_weights: None,
            digitising: None,
        }
    }

    /// Number of variances.
    #[must_use]
    pub fn order(&self) -> usize {
        self.avar.len()
    }

    /// Cluster sizes.
    #[must_use]
    pub fn sizes(&self) -> &[usize] {
        &self.parts.base.sizes()[self.first..]
    }

    /// Allan variances, without the ramp that was removed.
    #[must_use]
    pub fn variances(&self) -> &[f64] {
        &self.avar
    }

    /// Variances expected for θ.
    #[must_use]
    pub fn expectation(&self, theta: &Theta) -> Vec<f64> {
        let mut out = Vec::new();
        self.expected(theta, &mut out);
        out
    }

    pub(crate) fn squares(&self) -> &[f64] {
        &self.parts.base.squares()[self.first..]
    }

    /// Expected variances of a term for θ = 1.
    pub(crate) fn column(&self, term: usize) -> &[f64] {
        &self.design[term * self.order()..][..self.order()]
    }

    /// Sets the expected variances to the measured ones.
    pub(crate) fn with_expected(&self, theta: &Theta) -> Self {
        Self { avar: self.expectation(theta), tangent: None, ..self.clone() }
    }

    /// Expected variances for θ.
    pub(crate) fn expected(&self, theta: &Theta, out: &mut Vec<f64>) {
        let order = self.order();
        out.clear();
        out.resize(order, 0.0);
        for (row, theta) in self.design.chunks_exact(order).zip(theta).filter(|(_, theta)| **theta != 0.0) {
            out.iter_mut().zip(row).for_each(|(sum, value)| *sum += theta * value);
        }
    }

    /// Covariance of the variances if θ is true: the upper triangle in [`Work::covariance`].
    pub(crate) fn covariance_in(&self, theta: &Theta, work: &mut Work) {
        noise_covariance(&self.parts, self.first, theta, &mut work.covariance);
        if let Some(weights) = &self.ramp_weights {
            work.removal.apply(&self.parts, self.first, theta, weights, &mut work.covariance);
        }
        if let Some(errors) = &self.digitising {
            self.expected(theta, &mut work.means);
            let (order, all) = (self.order(), self.parts.base.order());
            for i in 0..order {
                let from = (self.first + i) * all + self.first;
                let cells = work.covariance[i * order + i..(i + 1) * order].iter_mut();
                for ((cell, error), mean) in cells.zip(&errors[from + i..]).zip(&work.means[i..]) {
                    *cell += work.means[i] * mean * error;
                }
            }
        }
    }

    /// Variance, if θ is true, that the errors of reading a figure cause in a sum of the variances with weights.
    fn digitising_variance(&self, theta: &Theta, weights: &[f64], means: &mut Vec<f64>) -> f64 {
        let Some(errors) = &self.digitising else { return 0.0 };
        self.expected(theta, means);
        means.iter_mut().zip(weights).for_each(|(mean, weight)| *mean *= weight);
        let rows = errors.chunks_exact(self.parts.base.order()).skip(self.first);
        rows.zip(means.iter())
            .map(|(row, x)| {
                x * row[self.first..].iter().zip(means.iter()).map(|(error, y)| error * y).sum::<f64>()
            })
            .sum()
    }

    /// The covariance as a whole matrix in row order.
    #[must_use]
    pub fn covariance(&self, theta: &Theta) -> Vec<f64> {
        let mut work = Work::default();
        self.covariance_in(theta, &mut work);
        let (order, upper) = (self.order(), work.covariance);
        (0..order * order)
            .map(|k| (k / order, k % order))
            .map(|(i, j)| upper[i.min(j) * order + i.max(j)])
            .collect()
    }

    /// Factors the covariance for θ and whitens columns.
    fn whiten(
        &self,
        theta: &Theta,
        work: &mut Work,
        width: usize,
        fill: impl Fn(usize, &mut [f64]),
    ) -> Result<(), Failed> {
        self.covariance_in(theta, work);
        let (order, covariance) = (self.order(), &mut work.covariance);
        match work.whitened.take(covariance, order, width, &fill) {
            Err(Failed) if self.ramp_weights.is_some() => {
                made_positive(covariance, order)?;
                work.whitened.take(covariance, order, width, &fill)
            }
            found => found,
        }
    }

    /// Whitens the columns of `terms`, then the tangent and the target if present, into [`Work::rows`]. Returns the number
    /// of columns.
    pub(crate) fn whitened(
        &self,
        theta: &Theta,
        terms: Terms,
        more: &[&[f64]],
        work: &mut Work,
    ) -> Result<usize, Failed> {
        let count = terms.iter().count();
        let width = count + more.len();
        assert!(width <= MAX_COLUMNS, "at most MAX_COLUMNS columns");
        self.whiten(theta, work, width, |i, row| {
            row.iter_mut().zip(terms.iter()).for_each(|(cell, term)| *cell = self.column(term)[i]);
            row[count..].iter_mut().zip(more).for_each(|(cell, column)| *cell = column[i]);
        })?;
        work.rows.clear();
        work.rows.extend(work.whitened.rows().map(|whitened| {
            let mut row = [0.0; MAX_COLUMNS];
            row[..width].copy_from_slice(whitened);
            row
        }));
        Ok(width)
    }

    /// Non-negative θ of the active terms; the others are 0, the fixed one keeps its value.
    pub(crate) fn fit_in(
        &self,
        active: Terms,
        fixed: Option<(usize, f64)>,
        start: Option<&Theta>,
        work: &mut Work,
    ) -> Result<Theta, Failed> {
        let terms = fixed.map_or(active, |(term, _)| active.without(term));
        let count = terms.iter().count();
        let target = |i: usize| match fixed {
            Some((term, value)) if value != 0.0 => self.avar[i] - value * self.column(term)[i],
            _ => self.avar[i],
        };
        let fill = |i: usize, row: &mut [f64]| {
            row[0] = target(i);
            row[1..].iter_mut().zip(terms.iter()).for_each(|(cell, term)| *cell = self.column(term)[i]);
        };
        let mut theta = [0.0; TERMS];
        if let Some(start) = start {
            terms.iter().for_each(|term| theta[term] = start[term]);
        } else {
            // Equal relative errors at all averaging times.
            let mut products = Products::new(count);
            for (i, avar) in self.avar.iter().enumerate() {
                let mut row = [0.0; TERMS + 1];
                fill(i, &mut row[..=count]);
                for x in &mut row {
                    *x /= avar;
                }
                products.add(&row);
            }
            let found = products.solve()?;
            terms.iter().zip(found).for_each(|(term, value)| theta[term] = value);
        }
        if let Some((term, value)) = fixed {
            theta[term] = value;
        }
        let mut expected = std::mem::take(&mut work.expected);
        let mut before = std::mem::take(&mut work.before);
        self.expected(&theta, &mut expected);
        for step in 0..STEPS {
            self.whiten(&theta, work, count + 1, fill)?;
            let mut products = Products::new(count);
            work.whitened.rows().for_each(|row| products.add(row));
            let found = products.solve()?;
            for (term, value) in terms.iter().zip(found) {
                theta[term] = if step >= DAMPED_FROM { 0.5 * (value + theta[term]) } else { value };
            }
            std::mem::swap(&mut before, &mut expected);
            self.expected(&theta, &mut expected);
            if expected.iter().zip(&before).all(|(new, old)| (new - old).abs() <= TOLERANCE * old) {
                break;
            }
        }
        (work.expected, work.before) = (expected, before);
        Ok(theta)
    }

    /// Non-negative θ of the active terms (default: all candidates); the others are 0, the fixed one keeps its value.
    ///
    /// # Errors
    ///
    /// [`Failed`].
    pub fn fit(
        &self,
        active: Option<Terms>,
        fixed: Option<(usize, f64)>,
        start: Option<&Theta>,
    ) -> Result<Theta, Failed> {
        self.fit_in(active.unwrap_or(self.candidates), fixed, start, &mut Work::default())
    }

    /// Pseudo-inverse of the whitened columns of the active terms and the tangent, if θ is true; [`Work::rows`] then has
    /// the columns.
    pub(crate) fn inverse(
        &self,
        theta: &Theta,
        active: Terms,
        tangent: Option<&[f64]>,
        work: &mut Work,
    ) -> Result<PseudoInverse, Failed> {
        let width = self.whitened(theta, active, tangent.as_slice(), work)?;
        PseudoInverse::new(&mut work.rows, width)
    }

    /// Covariance of unconstrained estimates of the active terms, if θ is true, in row order.
    ///
    /// # Errors
    ///
    /// [`Failed`].
    pub fn covariance_of_theta(&self, theta: &Theta, active: Terms) -> Result<Vec<f64>, Failed> {
        self.covariance_of_theta_in(theta, active, &mut Work::default())
    }

    pub(crate) fn covariance_of_theta_in(
        &self,
        theta: &Theta,
        active: Terms,
        work: &mut Work,
    ) -> Result<Vec<f64>, Failed> {
        let inverse = self.inverse(theta, active, self.tangent.as_deref(), work)?;
        let count = active.iter().count();
        Ok((0..count * count).map(|k| inverse.covariance(k / count, k % count)).collect())
    }

    /// Compares the estimate of one term with a trial value. Stores the weights in `Work::on_data`.
    pub(crate) fn statistic(
        &self,
        term: usize,
        trial: f64,
        start: Option<&Theta>,
        work: &mut Work,
    ) -> Result<Statistic, Failed> {
        let theta = self.fit_in(self.candidates, Some((term, trial)), start, work)?;
        let others = self.candidates.without(term);
        let empty: &[f64] = &[];
        let mut more = [empty; 3];
        let mut count = 0;
        for column in
            [self.tangent.as_deref(), Some(self.column(term)), Some(&self.avar)].into_iter().flatten()
        {
            more[count] = column;
            count += 1;
        }
        let width = self.whitened(&theta, others, &more[..count], work)?;
        work.row.resize(self.order(), 0.0);
        last_row(&mut work.rows, width - 1, &mut work.row)?;
        let sigma = work.row.iter().map(|x| x * x).sum::<f64>().sqrt();
        let estimate: f64 =
            work.row.iter().zip(&work.rows).map(|(weight, row)| weight * row[width - 1]).sum();
        work.on_data.clone_from(&work.row);
        work.whitened.unwhiten(&mut work.on_data);
        let (skewness, variance) = self.parts.skewness(&work.on_data, self.first, &theta, &mut work.modes);
        let digitised = self.digitising_variance(&theta, &work.on_data, &mut work.means);
        // The errors of reading a figure are normal: they widen the distribution without skewness.
        let share = (1.0 - digitised / (sigma * sigma)).max(0.0);
        // Independent modes overestimate the degrees of freedom where the ends of the record matter.
        let correction = (share.sqrt() * sigma / variance.sqrt()).clamp(0.7, 1.5) * share.powf(1.5);
        Ok(Statistic {
            z: finite((estimate - trial) / sigma)?,
            sigma,
            skewness: finite(correction * skewness)?,
            theta,
        })
    }

    /// Variance and skewness, if θ is true, of the estimate with the weights of [`Gls::statistic`].
    pub(crate) fn scatter(&self, theta: &Theta, work: &mut Work) -> (f64, f64) {
        self.covariance_in(theta, work);
        times(&work.covariance, &work.on_data, &mut work.row);
        let variance = work.row.iter().zip(&work.on_data).map(|(x, weight)| x * weight).sum();
        (variance, self.parts.skewness(&work.on_data, self.first, theta, &mut work.modes).0)
    }

    /// Compares the estimate of one term with a trial value, with the others fitted for that value.
    ///
    /// # Errors
    ///
    /// [`Failed`].
    pub fn score(&self, term: usize, trial: f64, start: Option<&Theta>) -> Result<Score, Failed> {
        let mut work = Work::default();
        let found = self.statistic(term, trial, start, &mut work)?;
        let Statistic { z, sigma, skewness, theta } = found;
        Ok(Score { z, sigma, skewness, above: found.tails().1, theta, weights: work.on_data })
    }
}
