//! Intervals of the terms: profiles, joined with those of other explanations.

use crate::distributions::student_quantile;
use crate::likelihood::alike::{Alike, observed_walk};
use crate::likelihood::bins::Bins;
use crate::likelihood::discrepancy::widened;
use crate::likelihood::exchange::alike;
use crate::likelihood::expected::{Part, TERMS};
use crate::likelihood::fit::squares;
use crate::likelihood::fit::{Fit, TOLERANCE};
use crate::likelihood::flicker_slope::{of_model, over_frequencies};
use crate::likelihood::laws::chi2_quantile_above;
use crate::likelihood::model::Shape;
use crate::likelihood::outcome::Second;
use crate::likelihood::outcome::Tails;
use crate::likelihood::profile::without;
use crate::likelihood::profile::{Bounds, Thresholds, part_bounds};
use crate::likelihood::select::{ALTERNATIVE_REDUCTION, Allowed, second_explanations};
use crate::terms::Term;

/// Price in deviance of an additional process, when the interval of a term is joined with its interval in the model with
/// this process. For the rate random walk it is the price of two parameters (Akaike). For other terms it is higher, because
/// slow noise of any kind resembles the bias instability, and highest if the rate random walk is observed too. With 6 for
/// all, the intervals contain B in the presence of a hump in 71 % of records, with these values in 82 to 91 %. Without a
/// hump the interval of B is 7 % wider; with 5 for all it is 5 to 15 % wider, with 4 for all 40 %.
const WALK_PRICE: f64 = 4.0;
const TERM_PRICE: f64 = 5.5;
const BOTH_PRICE: f64 = 6.0;

/// Smallest reduction of the deviance by a process that is stated in place of a rate random walk. The model with the
/// process does not need the walk.
const MIN_REDUCTION: f64 = 1.0;

pub(crate) fn thresholds(level: f64) -> Thresholds {
    Thresholds {
        interval: chi2_quantile_above(1.0 - level, 1.0),
        observed: chi2_quantile_above((2.0 * (1.0 - level)).min(0.9), 1.0),
    }
}

/// The thresholds if the size of the misfit is estimated from `freedom` bands: those of Student's t instead of the normal
/// distribution.
pub(crate) fn thresholds_of_student(level: f64, freedom: f64) -> Thresholds {
    let normal = thresholds(level);
    normal.scaled(student_quantile(freedom, 0.5 + 0.5 * level).powi(2) / normal.interval)
}

/// Intervals of all terms, and the model without those that were not observed. These are dropped one by one: of two
/// interchangeable terms the last one remains in the model, but neither is observed. The interval in the model without them
/// is joined.
pub(crate) fn intervals(fit: &Fit, bins: &Bins, thresholds: Thresholds) -> (Vec<Bounds>, Fit) {
    let count = fit.model.parts.len();
    let is_term = |j: &usize| fit.model.parts[*j].is_term();
    let unknown = Bounds { value: 0.0, low: 0.0, high: f64::INFINITY, observed: false, loss: 0.0 };
    let mut bounds: Vec<Bounds> = (0..count)
        .map(|j| if is_term(&j) { part_bounds(fit, bins, j, thresholds) } else { unknown })
        .collect();
    let open: Vec<Part> =
        (0..count).filter(is_term).filter(|&j| !bounds[j].observed).map(|j| fit.model.parts[j]).collect();
    if open.is_empty() {
        return (bounds, fit.clone());
    }
    let reduced = without(fit, bins, open, thresholds);
    for (j, part) in fit.model.parts.iter().enumerate().filter(|(j, _)| is_term(j)) {
        let Some(k) = reduced.model.index(*part) else { continue };
        let alone = part_bounds(&reduced, bins, k, thresholds);
        let full = bounds[j];
        bounds[j] = Bounds {
            value: if alone.observed { alone.value } else { full.value },
            // Intervals in the models that need the term.
            low: if alone.observed { full.low.min(alone.low) } else { full.low },
            high: alone.high.max(full.high),
            observed: full.observed,
            loss: full.loss,
        };
    }
    (bounds, reduced)
}

/// Joins the intervals of terms with those of alternatives that are nearly as good. Returns the equally good alternatives
/// with other processes.
pub(crate) fn join_alike(
    terms: &mut [Bounds],
    plain: &Fit,
    bins: &Bins,
    thresholds: Thresholds,
    allowed: Allowed,
) -> Vec<Second> {
    let is_slow = |part: Part| matches!(part, Part::Term(Term::BiasInstability | Term::RateRandomWalk));
    // With several runs a term is never dropped, because a process of a quarter of a run could replace any rate random
    // walk.
    let is_single = bins.runs.is_empty();
    let shows_slow = is_single
        && plain.model.parts.iter().zip(terms.iter()).any(|(&part, term)| is_slow(part) && term.observed);
    let walk = observed_walk(plain, bins, thresholds);
    let others = second_explanations(plain, bins, allowed, shows_slow);
    let mut others: Vec<Alike> =
        others.into_iter().map(|fit| Alike { fit, warm_up: None, optional: Vec::new() }).collect();
    if allowed.processes {
        others.extend(alike(plain, bins, walk, thresholds, allowed.drifts));
    }
    let is_walk = |part: Part| part == Part::Term(Term::RateRandomWalk);
    let has_walk = plain.model.index(Term::RateRandomWalk).is_some_and(|j| terms[j].observed);
    // If a walk is not needed in addition to a process, but the process does not replace it, its lower end is between 0,
    // where the process is just good enough to replace it, and two standard errors, as in `profile::part_bounds`.
    let error_of_walk =
        plain.model.index(Term::RateRandomWalk).map_or(0.0, |j| terms[j].error_below(thresholds));
    let least_walk = |gain: f64| {
        let needed = walk.map_or(0.0, |walk| walk.needed_of_process(plain));
        let share = (needed - gain) / (needed + thresholds.interval - TERM_PRICE);
        2.0 * error_of_walk * share.clamp(0.0, 1.0)
    };
    let mut second = Vec::new();
    for Alike { fit: other, warm_up, optional } in others {
        let exponent = of_model(&other, bins);
        let gain = plain.deviance - other.deviance;
        let has_other_processes = gauss_markov(&other).count() != gauss_markov(plain).count();
        let is_addition = warm_up.is_none() && exponent.is_none() && adds_process(&other, plain);
        let mut is_second = warm_up.is_some()
            || exponent.is_some()
            || (gain >= if is_addition { ALTERNATIVE_REDUCTION } else { -thresholds.interval }
                && has_other_processes);
        let (limited, limited_bins, _) = widened(&other, bins);
        for (j, part) in plain.model.parts.iter().enumerate().filter(|(_, part)| part.is_term()) {
            let is_same = |&p: &Part| {
                p == *part
                    || (*part == Part::Term(Term::BiasInstability) && matches!(p, Part::Flicker { .. }))
            };
            let Some(k) = limited.model.parts.iter().position(is_same) else {
                if optional.contains(part) {
                    terms[j].low = 0.0;
                } else if is_walk(*part) && warm_up.is_none() && exponent.is_none() {
                    terms[j].low = terms[j].low.min(least_walk(gain));
                }
                continue;
            };
            if is_addition && gain <= ALTERNATIVE_REDUCTION && !(is_slow(*part) && terms[j].observed) {
                continue; // a weak process does not change other intervals
            }
            let price = match part {
                Part::Term(Term::RateRandomWalk) => WALK_PRICE,
                Part::Term(Term::BiasInstability) if has_walk => BOTH_PRICE,
                _ => TERM_PRICE,
            };
            let less = if is_addition { (price - gain).max(0.0) } else { 0.0 };
            if less >= thresholds.interval {
                continue;
            }
            let thresholds = Thresholds {
                interval: thresholds.interval - less,
                observed: (thresholds.observed - less).max(0.0),
            };
            let joined = over_frequencies(
                part_bounds(&limited, &limited_bins, k, thresholds),
                &limited,
                &limited_bins,
                k,
            );
            // With a free exponent, a term that is not needed may be absent.
            let may_be_absent = exponent.is_some() && (!is_walk(*part) || optional.contains(part));
            if terms[j].observed && (joined.observed || may_be_absent) {
                terms[j].low = terms[j].low.min(joined.low);
            }
            // With a process, a rate random walk may be absent too.
            let is_idle = is_single && is_addition && is_walk(*part) && terms[j].observed && !joined.observed;
            if is_idle && gain > MIN_REDUCTION {
                terms[j].low = terms[j].low.min(least_walk(gain));
                is_second = true;
            }
            if is_idle && walk.is_some_and(|walk| walk.gives_way(gain, walk.needed_of_process(plain))) {
                terms[j].low = 0.0;
                is_second = true;
            }
            terms[j].high = terms[j].high.max(joined.high);
        }
        if is_second {
            second.push(second_model(&without(&other, bins, TERMS.to_vec(), thresholds), bins, warm_up));
        }
    }
    second
}

/// Whether a fit has one process more than another fit, and everything else that the other fit has.
fn adds_process(fit: &Fit, other: &Fit) -> bool {
    let has = |part: &Part| !part.is_term() || fit.model.index(*part).is_some();
    gauss_markov(fit).count() > gauss_markov(other).count()
        && fit.model.filter.len() == other.model.filter.len()
        && other.model.parts.iter().all(has)
}

/// An alternative as a model; a free exponent is represented by the processes that add up to it.
fn second_model(fit: &Fit, bins: &Bins, warm_up: Option<f64>) -> Second {
    let mut found = Second {
        terms: squares(fit),
        gauss_markov: gauss_markov(fit).collect(),
        warm_up,
        exponent: None,
        filter: None,
    };
    if let Some((exponent, mixture)) = of_model(fit, bins) {
        found.exponent = Some(exponent);
        found.terms[Term::RandomWalk.index()] += mixture.white;
        found.gauss_markov.extend(mixture.processes());
    }
    found
}

/// Variances and correlation times of the Gauss-Markov processes.
pub(crate) fn gauss_markov(fit: &Fit) -> impl Iterator<Item = (f64, f64)> + '_ {
    fit.model.parts.iter().zip(&fit.model.theta).filter_map(|(part, &variance)| match part {
        Part::GaussMarkov { time } if variance > 0.0 => Some((variance, *time)),
        _ => None,
    })
}

/// The shortest correlation time of a Gauss-Markov process that represents the rate random walk about equally well.
pub(crate) fn process_like_walk(fit: &Fit, bins: &Bins, thresholds: Thresholds) -> Option<(f64, f64)> {
    let walk = fit.model.index(Term::RateRandomWalk).filter(|&j| fit.model.theta[j] > 0.0)?;
    let (bare, walk) = (fit.model.without(walk), fit.model.theta[walk]);
    let reference = fit.model.clone().refit(bins, 40, TOLERANCE, fit).deviance;
    let mut found = None;
    let mut time = 0.5 * bins.record.duration();
    while time > bins.record.duration() / 300.0 {
        // A process that is slow enough is a random walk with K² = 2σ²/T.
        let mut model = bare.with(Part::GaussMarkov { time }, 0.5 * walk * time);
        model.held_shape = Some((model.parts.len() - 1, Shape::Time));
        let last = model.parts.len() - 1;
        let alike = model.refit(bins, 40, TOLERANCE, fit);
        if alike.deviance > reference + thresholds.interval {
            break;
        }
        found = Some((time, alike.model.theta[last]));
        time /= 1.5;
    }
    found
}

/// Replaces the values of the likelihood with limited weights by those of the plain likelihood, limited to their intervals.
pub(crate) fn value_of_likelihood(bounds: &mut [Bounds], plain: &Fit, reduced: &Fit) {
    for (j, part) in plain.model.parts.iter().enumerate() {
        let value = match reduced.model.index(*part) {
            Some(k) => reduced.model.theta[k],
            _ => plain.model.theta[j],
        };
        bounds[j] = bounds[j].around(value);
    }
}

/// Widens the interval of white noise for samples with heavy tails: the relative variance of N² is (2 + κ)/N instead of
/// 2/N.
pub(crate) fn heavy_tails(white: &mut Bounds, tails: Tails, thresholds: Thresholds) {
    let heavy = tails.heavy();
    if heavy == 0.0 || !white.observed {
        return;
    }
    let more = (thresholds.interval * heavy / tails.present as f64).sqrt() * white.value;
    white.low = (white.value - (white.value - white.low).hypot(more)).max(0.0);
    white.high = white.value + (white.high - white.value).hypot(more);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both ends follow the confidence level: quantiles from tables, in units of the normal threshold and of a standard
    /// error.
    #[test]
    fn level_sets_student_and_tails() {
        for (level, student, normal) in [(0.95, 2.364_624, 1.959_964), (0.5, 0.711_142, 0.674_490)] {
            let at = thresholds(level);
            let wide = thresholds_of_student(level, 7.0);
            assert!((wide.interval.sqrt() - student).abs() < 1e-5, "{level}: {wide:?}");
            assert!((wide.observed / at.observed - wide.interval / at.interval).abs() < 1e-12);
            let mut white = Bounds { value: 1.0, low: 1.0, high: 1.0, observed: true, loss: 1e9 };
            heavy_tails(&mut white, Tails { kurtosis: 6.0, present: 60_000 }, at);
            assert!(
                (white.high - 1.0 - normal * 0.01).abs() < 1e-7
                    && (white.low + white.high - 2.0).abs() < 1e-12
            );
        }
    }
}
