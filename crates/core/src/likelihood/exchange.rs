//! Processes in place of terms: which of the two a record shows, and whether it distinguishes them.

use crate::likelihood::alike::{Alike, Walk, loss_of_term};
use crate::likelihood::bins::Bins;
use crate::likelihood::candidates::spaced;
use crate::likelihood::drifts::with_warm_up;
use crate::likelihood::expected::Part;
use crate::likelihood::fit::{Fit, TOLERANCE};
use crate::likelihood::flicker_slope::with_free_exponent;
use crate::likelihood::model::Model;
use crate::likelihood::profile::Thresholds;
use crate::terms::Term;
use std::f64::consts::PI;

/// Terms that a process may replace, alone or together.
pub(crate) const REPLACED: [&[Part]; 3] = [
    &[Part::Term(Term::RateRandomWalk)],
    &[Part::Term(Term::BiasInstability)],
    &[Part::Term(Term::BiasInstability), Part::Term(Term::RateRandomWalk)],
];

/// Number of correlation times that are tested per decade.
const TIMES_PER_DECADE: f64 = 2.0;

/// Number of steps of a fit, number of steps of a preliminary fit of a candidate, and the change of the deviance at which
/// the latter ends.
const STEPS: usize = 40;
const FIRST_STEPS: usize = 8;
const ROUGH_TOLERANCE: f64 = 0.1;

/// Price of a parameter in deviance (Akaike), and the numbers of parameters of a process and of a warm-up.
const PRICE_OF_PARAMETER: f64 = 2.0;
const NUMBERS_OF_PROCESS: f64 = 2.0;
const NUMBERS_OF_WARM_UP: f64 = 2.0;

/// Share of its amplitude above which a replaced term is fitted in addition to the process.
const REFITTED_SHARE: f64 = 0.05;

/// Rise of the deviance over the fit with the term, up to which a process may still be better together with the term.
const MAX_RISE: f64 = 8.0;

/// Amount by which a warm-up, the best of seven time constants, must be better than the others: by chance it is better in
/// 1.7 % of 168 records of N + B + K.
const SEARCH_PRICE: f64 = 1.4;

/// The fits with a process or a warm-up in place of observed terms that explain the record as well.
pub(crate) fn alike(
    fit: &Fit,
    bins: &Bins,
    walk: Option<Walk>,
    thresholds: Thresholds,
    drifts: bool,
) -> Vec<Alike> {
    let observed = |&part: &Part| match part {
        Part::Term(Term::RateRandomWalk) => walk.is_some(),
        _ => loss_of_term(fit, bins, part).is_some_and(|loss| loss > thresholds.observed),
    };
    let sets = REPLACED.into_iter().filter(|set| set.iter().all(observed));
    let mut found: Vec<Alike> =
        sets.filter_map(|set| with_process(fit, bins, set, walk, thresholds)).collect();
    if let Some(walk) = walk.filter(|_| drifts) {
        found.extend(with_warm_up_for_walk(fit, bins, walk));
    }
    found.extend(with_free_exponent(fit, bins, walk, thresholds));
    found
}

/// The fit with a process in place of observed terms, if it explains the record as well.
fn with_process(
    fit: &Fit,
    bins: &Bins,
    replaced: &[Part],
    walk: Option<Walk>,
    thresholds: Thresholds,
) -> Option<Alike> {
    let found = best(fit, bins, replaced)?;
    let fall = fit.deviance - found.deviance;
    let price = PRICE_OF_PARAMETER * (NUMBERS_OF_PROCESS - replaced.len() as f64);
    // In addition to a rate random walk, slow noise of any kind resembles bias instability.
    let rise = if walk.is_some() && replaced.len() == 1 { PRICE_OF_PARAMETER } else { thresholds.interval };
    let may_be_absent = |part: &Part| match (part, walk) {
        (Part::Term(Term::RateRandomWalk), Some(walk)) => walk.gives_way(fall, walk.needed_of_process(fit)),
        _ => fall + rise >= price,
    };
    let optional: Vec<Part> = replaced.iter().copied().filter(may_be_absent).collect();
    // A slow process always resembles a rate random walk. `process_like_walk` reports such a process; this function
    // only reports a better one.
    let is_alike = !optional.is_empty() || fall >= price;
    is_alike.then_some(Alike { fit: found, warm_up: None, optional })
}

/// The fit with a warm-up in place of the rate random walk, if it is better.
fn with_warm_up_for_walk(fit: &Fit, bins: &Bins, walk: Walk) -> Option<Alike> {
    let (loss, bare) = fit.removal_loss(fit.model.index(Term::RateRandomWalk)?, bins);
    let (gain, time, found) = with_warm_up(&bare, bins)?;
    let restricted = fit.restricted - bare.restricted; // `gain` refers to unrestricted likelihoods
    let price = PRICE_OF_PARAMETER * (NUMBERS_OF_WARM_UP - 1.0);
    let fall = gain - loss - restricted;
    let gives_way = walk.gives_way(fall, walk.certain_loss() + SEARCH_PRICE);
    let optional = if gives_way { vec![Part::Term(Term::RateRandomWalk)] } else { Vec::new() };
    (gives_way || fall >= price).then_some(Alike { fit: found, warm_up: Some(time), optional })
}

/// The best fit without `replaced` and with a process.
pub(crate) fn best(fit: &Fit, bins: &Bins, replaced: &[Part]) -> Option<Fit> {
    let (tau0, duration) = (bins.record.tau0, bins.record.duration());
    let bare = without(&fit.model, replaced);
    let tried = spaced(40.0 * tau0, duration / 12.0, TIMES_PER_DECADE).into_iter().map(|time| {
        let part = Part::GaussMarkov { time };
        let unit = bins.unit(part);
        let below: Vec<f64> = (0..bins.low)
            .filter(|&i| bins.frequency[i] < 1.0 / (2.0 * PI * time))
            .map(|i| fit.powers[i] / unit[i])
            .collect();
        let theta = if below.len() > 2 {
            below.iter().sum::<f64>() / below.len() as f64
        } else {
            let ratios = fit.spectrum.iter().zip(&unit).map(|(s, c)| s / c);
            0.3 * ratios.fold(f64::INFINITY, f64::min)
        };
        bare.with(part, theta.max(1e-300)).refit(bins, FIRST_STEPS, ROUGH_TOLERANCE, fit)
    });
    let best = tried.min_by(|a, b| a.deviance.total_cmp(&b.deviance))?;
    Some(best.model.clone().refit(bins, STEPS, TOLERANCE, fit))
}

/// The fit with the replaced terms in addition to the process, if that can be better than `fit`.
pub(crate) fn beside(found: Fit, fit: &Fit, bins: &Bins, replaced: &[Part]) -> Fit {
    if found.deviance > fit.deviance + MAX_RISE {
        return found;
    }
    let mut model = found.model.clone();
    for part in replaced {
        if let Some(j) = fit.model.index(*part) {
            model.parts.insert(0, *part);
            model.theta.insert(0, REFITTED_SHARE * fit.model.theta[j]);
        }
    }
    model.refit(bins, STEPS, TOLERANCE, fit)
}

fn without(model: &Model, replaced: &[Part]) -> Model {
    let indices = replaced.iter().filter_map(|part| model.index(*part));
    let mut indices: Vec<usize> = indices.collect();
    indices.sort_unstable();
    indices.into_iter().rev().fold(model.clone(), |model, j| model.without(j))
}
