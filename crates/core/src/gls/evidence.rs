//! Tests, intervals and detection limits of single terms.
//!
//! All of them use one statistic: the unconstrained estimate of a squared coefficient θ minus a trial value, over its
//! standard error if the trial value is true, with all other terms fitted for that value. A value belongs to the interval
//! if the statistic is not in the tails of its distribution ([`crate::gls::laws`]).

use crate::gls::components::Components;
use crate::gls::laws::{UpperShare, critical, deviate, skewed_tails};
use crate::gls::roots::{TOLERANCE, crossing};
use crate::gls::step::{Gls, Work};
use crate::gls::{Failed, Terms, Theta};

/// Precision of the logarithm of a coefficient that is detected with a given probability.
const TOLERANCE_OF_PLANS: f64 = 1e-3;

/// Test and interval of one squared coefficient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// Probability of this estimate or a larger one if the term is absent.
    pub p_value: f64,
    /// Lower end of the interval of θ; 0 if the term is not observed. The upper end is infinite if there is no limit.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

impl Gls {
    /// Test, interval and limit of one term. `theta` is the fit with all terms, the starting point; `level` is the
    /// confidence level of the interval. The term is observed if p < 1 − level.
    ///
    /// # Errors
    ///
    /// [`Failed`].
    pub fn evidence(&self, term: usize, theta: &Theta, level: f64) -> Result<Evidence, Failed> {
        self.evidence_in(term, theta, level, &UpperShare::of(level), &mut Work::default())
    }

    pub(crate) fn evidence_in(
        &self,
        term: usize,
        theta: &Theta,
        level: f64,
        shares: &UpperShare,
        work: &mut Work,
    ) -> Result<Evidence, Failed> {
        let estimate = theta[term].max(0.0);
        let (null, p_value) = match self.statistic(term, 0.0, None, work) {
            Ok(null) => (null, null.tails().1),
            // The other terms alone cannot be fitted.
            Err(Failed) => (self.statistic(term, estimate, None, work)?, 0.0),
        };
        let mut last = null.theta;
        let mut low = 0.0;
        if p_value < 1.0 - level && estimate > 0.0 {
            let top = estimate.sqrt();
            let above_low = |root: f64| {
                let found = self.statistic(term, root * root, Some(&last), work)?;
                last = found.theta;
                Ok(deviate(found.tails().1) - deviate(shares.at(root * root / found.sigma)))
            };
            low = crossing(above_low, 1e-4 * top, top, TOLERANCE * top)?.powi(2);
        }
        last = if estimate > 0.0 { *theta } else { null.theta };
        let mut below_high = |root: f64| {
            let found = self.statistic(term, root * root, Some(&last), work)?;
            last = found.theta;
            let share = shares.at(root * root / found.sigma);
            Ok(deviate(found.tails().0) - deviate(1.0 - level - share))
        };
        let error = null.sigma.sqrt();
        let mut bottom = if estimate > 0.0 { estimate.sqrt() } else { 0.1 * error };
        // The limit of an absent term may be below one standard error, if the other terms explain all of the variances.
        while below_high(bottom)? < 0.0 && bottom > 1e-3 * error {
            bottom /= 3.0;
        }
        let mut top = (estimate + 2.0 * null.sigma).sqrt();
        while below_high(top)? > 0.0 {
            (bottom, top) = (top, 1.5 * top);
            if !top.is_finite() || top > 1e6 * (null.sigma + estimate).sqrt() {
                return Ok(Evidence { p_value, low, high: f64::INFINITY });
            }
        }
        let high = crossing(|root| Ok(-below_high(root)?), bottom, top, TOLERANCE * top)?.powi(2);
        Ok(Evidence { p_value, low: low.min(estimate), high: high.max(estimate) })
    }
}

/// The smallest θ of a term that the test detects with probability `power`; infinite if there is none. No data are needed:
/// the Allan variances are those expected for θ of the other terms.
///
/// # Errors
///
/// [`Failed`].
pub fn detectable(
    parts: &Components,
    term: usize,
    others: &Theta,
    level: f64,
    power: f64,
) -> Result<f64, Failed> {
    let gls = Gls::new(parts, 0, &vec![1.0; parts.base.order()], Terms::first(parts.terms()), None);
    let mut work = Work::default();
    let mut excess = |theta_of_term: f64| {
        let mut truth = *others;
        truth[term] = theta_of_term;
        let found = gls.with_expected(&truth).statistic(term, 0.0, None, &mut work)?;
        let limit = critical(found.skewness, 1.0 - level);
        let (variance, skewness) = gls.scatter(&truth, &mut work);
        let sd = variance.sqrt() / found.sigma;
        Ok::<f64, Failed>(skewed_tails((limit - found.z) / sd, skewness).1 - power)
    };
    let sigma = gls.with_expected(others).statistic(term, 0.0, None, &mut Work::default())?.sigma;
    let (mut low, mut high) = (0.1 * sigma, 4.0 * sigma);
    while excess(high)? < 0.0 {
        (low, high) = (high, 4.0 * high);
        if high > 1e12 * sigma {
            return Ok(f64::INFINITY);
        }
    }
    Ok(crossing(|x| excess(x.exp()), low.ln(), high.ln(), TOLERANCE_OF_PLANS)?.exp())
}
