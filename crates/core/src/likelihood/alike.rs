//! Alternative explanations of a record, and the rate random walk with which they compete.

use crate::likelihood::bins::Bins;
use crate::likelihood::expected::Part;
use crate::likelihood::fit::Fit;
use crate::likelihood::profile::Thresholds;
use crate::terms::Term;

/// Threshold above which a rate random walk is certain, and by which an alternative must be better than a certain walk,
/// over the threshold of an interval. It is one-sided, for three kinds of alternatives (process, warm-up, exponent)
/// together (Bonferroni): χ² of 2·5 %/3.
const THRESHOLD_FACTOR: f64 = 1.18;

/// An equivalent fit of a record, the time constant of its warm-up \[s\], and the terms that may be absent because of it.
pub(crate) struct Alike {
    pub fit: Fit,
    pub warm_up: Option<f64>,
    pub opens: Vec<Part>,
}

/// A rate random walk and its competing explanations.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Walk {
    /// Rise of the deviance without the walk.
    loss: f64,
    at: Thresholds,
}

impl Walk {
    /// Whether the walk may be absent because another explanation lowers the deviance by `fall`. An uncertain walk is
    /// dropped for any equally good explanation, a certain walk only for one that is better by `needed`.
    pub(crate) fn gives_way(self, fall: f64, needed: f64) -> bool {
        fall >= if self.loss > self.sure() { needed } else { -self.at.interval }
    }

    pub(crate) fn sure(self) -> f64 {
        THRESHOLD_FACTOR * self.at.interval
    }

    /// Amount by which a process must be better than the walk. The walk is the limit of the process for long correlation
    /// times, so by chance the process is better by a one-sided threshold. If the sensor already has a process, a second
    /// process is not surprising.
    pub(crate) fn needed_of_process(self, fit: &Fit) -> f64 {
        let is_present =
            |(part, &theta): (&Part, &f64)| matches!(part, Part::GaussMarkov { .. }) && theta > 0.0;
        if fit.model.parts.iter().zip(&fit.model.theta).any(is_present) { 0.0 } else { self.sure() }
    }
}

/// The rate random walk of a fit, if it is observed.
pub(crate) fn observed_walk(fit: &Fit, bins: &Bins, at: Thresholds) -> Option<Walk> {
    let loss = loss_of_term(fit, bins, Part::Term(Term::RateRandomWalk))?;
    (loss > at.observed).then_some(Walk { loss, at })
}

pub(crate) fn loss_of_term(fit: &Fit, bins: &Bins, term: Part) -> Option<f64> {
    let present = fit.model.index(term).filter(|&j| fit.model.theta[j] > 0.0)?;
    Some(fit.removal_loss(present, bins).0)
}
