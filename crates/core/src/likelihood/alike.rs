//! Alternative explanations of a record, and the rate random walk with which they compete.

use crate::likelihood::bins::Bins;
use crate::likelihood::expected::Part;
use crate::likelihood::fit::Fit;
use crate::likelihood::profile::Thresholds;
use crate::terms::Term;

/// Threshold above which a rate random walk is certain, over that of an interval. A walk is certain if its loss is
/// above this threshold, and an alternative must then be better than the walk by as much. The threshold is one-sided,
/// for three kinds of alternatives (process, warm-up, exponent) together (Bonferroni): the quantile of χ² that is
/// exceeded with a probability of 2·5 %/3.
const THRESHOLD_FACTOR: f64 = 1.18;

/// An equivalent fit of a record, the time constant of its warm-up \[s\], and the terms that may be absent because of it.
pub(crate) struct Alike {
    pub fit: Fit,
    pub warm_up: Option<f64>,
    pub optional: Vec<Part>,
}

/// A rate random walk and its competing explanations.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Walk {
    /// Rise of the deviance without the walk.
    loss: f64,
    thresholds: Thresholds,
}

impl Walk {
    /// Whether the walk may be absent because another explanation lowers the deviance by `fall`. An uncertain walk is
    /// dropped for any equally good explanation, a certain walk only for one that is better by `needed`.
    pub(crate) fn gives_way(self, fall: f64, needed: f64) -> bool {
        fall >= if self.loss > self.certain_loss() { needed } else { -self.thresholds.interval }
    }

    /// Loss above which a walk is certain.
    pub(crate) fn certain_loss(self) -> f64 {
        THRESHOLD_FACTOR * self.thresholds.interval
    }

    /// Amount by which a process must be better than the walk. The walk is the limit of the process for long correlation
    /// times, so by chance the process is better by a one-sided threshold. If the sensor already has a process, a second
    /// process is not surprising.
    pub(crate) fn needed_of_process(self, fit: &Fit) -> f64 {
        let is_present =
            |(part, &theta): (&Part, &f64)| matches!(part, Part::GaussMarkov { .. }) && theta > 0.0;
        if fit.model.parts.iter().zip(&fit.model.theta).any(is_present) { 0.0 } else { self.certain_loss() }
    }
}

/// The rate random walk of a fit, if it is observed.
pub(crate) fn observed_walk(fit: &Fit, bins: &Bins, thresholds: Thresholds) -> Option<Walk> {
    let loss = loss_of_term(fit, bins, Part::Term(Term::RateRandomWalk))?;
    (loss > thresholds.observed).then_some(Walk { loss, thresholds })
}

/// Rise of the deviance without a term; None if the fit does not have it.
pub(crate) fn loss_of_term(fit: &Fit, bins: &Bins, term: Part) -> Option<f64> {
    let present = fit.model.index(term).filter(|&j| fit.model.theta[j] > 0.0)?;
    Some(fit.removal_loss(present, bins).0)
}
