//! Generalised least squares on Allan variances: coefficients with tests, intervals, limits and a goodness of fit.
//!
//! The variances at different averaging times are correlated, up to 0.99 for neighbours, and their errors depend on the
//! noise that is estimated. Each step therefore uses the exact covariance for the coefficients of the last step and
//! solves for non-negative squared coefficients θ. Weights from the measured variances would bias the long times low,
//! because a variance that is small by chance would have a large weight.
//!
//! Times are in samples: the sample interval is 1, and θ is for this interval.

mod angles;
mod attempt;
mod cache;
mod columns;
mod components;
mod covariance;
mod curve_fit;
mod evidence;
mod goodness;
mod lanes;
mod laws;
mod modes;
mod non_negative;
mod process;
mod ramp;
mod roots;
mod selection;
mod statement;
mod step;
mod whitening;

use crate::terms::{NOISE_TERMS, Term};

pub use components::{Base, Components, Extra, Shape};
pub use curve_fit::{Curve, CurveFit};
pub use evidence::{Evidence, detectable};
pub use non_negative::non_negative;
pub use ramp::least_ramp;
pub use step::{Gls, Score};

/// Number of noise terms, in the order of [`Term::NOISE`]. The ramp is not a noise.
pub const LINEAR: usize = NOISE_TERMS;

/// Largest number of terms: the noise terms and one further component.
pub const TERMS: usize = LINEAR + 1;

const QUANTIZATION: usize = Term::Quantization.index();
const BIAS_INSTABILITY: usize = Term::BiasInstability.index();
const RATE_RANDOM_WALK: usize = Term::RateRandomWalk.index();

/// Squared coefficients, 0 for absent terms.
pub type Theta = [f64; TERMS];

/// A set of terms, one bit each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Terms(pub u8);

impl Terms {
    /// The set of the first `count` terms.
    #[must_use]
    pub fn first(count: usize) -> Self {
        Self((1 << count) - 1)
    }

    /// The set of the given terms.
    #[must_use]
    pub fn of(terms: &[usize]) -> Self {
        Self(terms.iter().fold(0, |bits, term| bits | 1 << term))
    }

    /// The terms in increasing order.
    pub fn iter(self) -> impl Iterator<Item = usize> {
        (0..TERMS).filter(move |&term| self.contains(term))
    }

    pub(crate) fn contains(self, term: usize) -> bool {
        self.0 >> term & 1 == 1
    }

    pub(crate) fn without(self, term: usize) -> Self {
        Self(self.0 & !(1 << term))
    }

    pub(crate) fn with(self, term: usize) -> Self {
        Self(self.0 | 1 << term)
    }

    pub(crate) fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    pub(crate) fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    pub(crate) fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The terms with a positive coefficient.
    pub(crate) fn positive(theta: &Theta) -> Self {
        (0..TERMS).filter(|&term| theta[term] > 0.0).fold(Self(0), Self::with)
    }
}

/// The fit failed: the covariance of the variances is not positive definite, or a number is not finite.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the covariance is not positive definite")]
pub struct Failed;

/// Returns a number if it is finite.
fn finite(x: f64) -> Result<f64, Failed> {
    if x.is_finite() { Ok(x) } else { Err(Failed) }
}
