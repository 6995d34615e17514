//! All steps from a summary to coefficients with intervals.

use crate::likelihood::adequacy::{Adequacy, adequacy};
use crate::likelihood::band::{
    Attempt, SLOWEST_FILTER, allowed, attempt, best_attempt, hides_white_noise, of_terms,
};
use crate::likelihood::band::{LINE_SEARCHES, MIN_P_VALUE};
use crate::likelihood::bins::{Bins, Regressor, usable};
use crate::likelihood::discrepancy::widened;
use crate::likelihood::drifts::{Drifts, FIRST_REGRESSOR, drift, regressors, with_drifts};
use crate::likelihood::expected::{Part, TERMS};
use crate::likelihood::fit::squares;
use crate::likelihood::fit::{Fit, TOLERANCE};
use crate::likelihood::intervals::{
    gauss_markov, heavy_tails, intervals, join_alike, process_like_walk, thresholds, thresholds_of_student,
    value_of_likelihood,
};
use crate::likelihood::line::Line;
use crate::likelihood::linear::Symmetric;
use crate::likelihood::lines::{above_medians, beyond_band, without_images};
use crate::likelihood::matern_process::{MaternOutcome, with_matern};
use crate::likelihood::no_quantization::without_quantization;
use crate::likelihood::outcome::Tails;
use crate::likelihood::outcome::{Drift, Options, Outcome, Process, Second};
use crate::likelihood::profile::{Bounds, Thresholds, part_bounds, resonance_bounds, time_bounds};
use crate::likelihood::resonance_shape::join_without_resonances;
use crate::likelihood::running_mean::RunningMean;
use crate::likelihood::select::{Allowed, SELECTED_P_VALUE, cost, is_needed};
use crate::likelihood::slow_lines::{prices, slow_lines};
use crate::likelihood::summary::Summary;
use crate::likelihood::white_levels::white_levels;
use crate::terms::Term;
use std::cmp::Ordering;
use std::f64::consts::PI;
use std::sync::Arc;

/// Degrees of freedom of Student's t if a model is not adequate: the size of the misfit is estimated from about this number
/// of bands.
const WIGGLE_FREEDOM: f64 = 7.0;

/// Deviance by which a model with slow noise before a running mean must be better than one with slow noise after it,
/// because the density at the zeros is then an additional parameter. Without this price, quantization noise replaced slow
/// noise after the mean in 45 % of records. Without slow noise the choice only concerns the noise that fills the zeros, and
/// the alternative must be better by the same amount.
const IN_FRONT: f64 = 4.0;

/// Analyses one channel.
#[must_use]
pub fn analyse(record: &Summary, options: &Options) -> Outcome {
    let (Attempt { bins, fit: plain, lines, highest, .. }, drifts) = fitted(record, options);
    let test = adequacy(&plain, &bins);
    let tails = Tails { kurtosis: record.kurtosis, present: record.present() };
    let allowed = allowed(record, options);
    let bare = without_quantization(&plain, &bins, options.most_quantization.powi(2));
    let infer = |fit: &Fit| inferred(fit, &bins, test.p_value, tails, allowed, options.level);
    let found = match bare {
        Some(bare) => {
            let mut found = infer(&bare.fit);
            found
                .terms
                .insert(bare.removed, unseen(&plain, &bins, bare.removed, test.p_value, options.level));
            if let Some(j) = plain.model.index(Term::RandomWalk) {
                found.terms[j].low = (found.terms[j].low - bare.reduction).max(0.0);
            }
            found
        }
        None => infer(&plain),
    };
    Outcome {
        lines,
        slow_lines: if options.lines { slow_lines(&plain, &bins) } else { Vec::new() },
        highest,
        ramp: drifts.ramp,
        ramp_observed: drifts.ramp_observed,
        warm_up: drifts.warm_up,
        regressors: (0..options.regressors.len()).map(|k| drift(&plain, FIRST_REGRESSOR + k)).collect(),
        levels: white_levels(&plain, &bins, tails),
        matern: if options.matern { matern(record, options, &plain, &bins) } else { None },
        ..outcome(&plain, &bins, test, found)
    }
}

/// The model with a Matérn process. A filter or resonances may stand for the slope of its density: the model has them only if
/// none without them is adequate.
fn matern(record: &Summary, options: &Options, plain: &Fit, bins: &Bins) -> Option<MaternOutcome> {
    let thresholds = |p_value| model_thresholds(p_value, options.level);
    let has_resonance = plain.model.parts.iter().any(|part| matches!(part, Part::Resonance { .. }));
    if !plain.model.filter.is_empty() || has_resonance {
        let simple = Options { filter: false, resonances: false, ..options.clone() };
        let (Attempt { bins, fit, .. }, _) = fitted(record, &simple);
        let found = with_matern(&fit, &bins, thresholds).filter(|found| found.p_value >= SELECTED_P_VALUE);
        if found.is_some() {
            return found;
        }
    }
    with_matern(plain, bins, thresholds)
}

/// The model of a record with its lines and drifts. Its filter is a running mean, unless only a series of cosines has an
/// adequate model.
pub(crate) fn fitted<'a>(record: &'a Summary, options: &Options) -> (Attempt<'a>, Drifts) {
    let recognised = if options.filter { RunningMean::of(record) } else { None };
    let Some((mean, mask)) = recognised else { return fitted_with_series(record, options) };
    let regressors = Arc::new(regressors(record, options));
    let powers = mean.powers(record);
    let lines = if options.lines { beyond_band(record, &mean.with_lobes(record, &mask)) } else { Vec::new() };
    let (mask, lines) = without_lines(record, mask, lines, Some((mean, &powers)), options);
    // The ends of the record fill the zeros, for which the mean has a floor, or slow noise after a mean of the
    // white noise alone.
    let without_floor = RunningMean { floor: 0.0, ..mean };
    let attempt_with = |of_white: bool, mean: RunningMean| {
        attempt(record, mask.clone(), lines.clone(), &regressors, options, (None, Some((mean, of_white))))
    };
    let (of_all, of_white) = (attempt_with(false, mean), attempt_with(true, without_floor));
    // With missing samples, each fit determines how much information the mask leaves. The deviance is proportional to it, and
    // is comparable for the same information only.
    let information = of_all.bins.information.min(of_white.bins.information);
    let total = |Attempt { bins, fit, .. }: &Attempt| {
        if bins.information <= information {
            return cost(fit) + prices(fit, bins);
        }
        let mut bins = bins.clone();
        bins.inform(information);
        let fit = fit.model.clone().fit(&bins);
        cost(&fit) + prices(&fit, &bins)
    };
    let better = match of_white.lines.len().cmp(&of_all.lines.len()) {
        Ordering::Less => true,
        Ordering::Equal => {
            total(&of_white) < total(&of_all) + if shows_slow(&of_white) { IN_FRONT } else { -IN_FRONT }
        }
        Ordering::Greater => false,
    };
    let attempt = if better { of_white } else { of_all };
    if attempt.p_value < MIN_P_VALUE {
        let with_series = fitted_with_series(record, options);
        if with_series.0.p_value >= MIN_P_VALUE {
            return with_series;
        }
    }
    drifting(attempt, &regressors, options)
}

/// Whether a fit needs noise that is slower than white noise.
fn shows_slow(attempt: &Attempt) -> bool {
    let (fit, bins) = (&attempt.fit, &attempt.bins);
    fit.model.processes().next().is_some()
        || [Part::Term(Term::BiasInstability), Part::Term(Term::RateRandomWalk)]
            .into_iter()
            .any(|part| is_needed(fit, part, bins))
}

/// The model of a record with a series of cosines as the only filter.
pub(crate) fn fitted_with_series<'a>(record: &'a Summary, options: &Options) -> (Attempt<'a>, Drifts) {
    let regressors = Arc::new(regressors(record, options));
    let mask = usable(record);
    let lines = if options.lines { beyond_band(record, &mask) } else { Vec::new() };
    let (mask, lines) = without_lines(record, mask, lines, None, options);
    let attempt = best_attempt(record, &mask, &lines, &regressors, options);
    drifting(attempt, &regressors, options)
}

/// The mask without lines above running medians, and all lines. `filter`: a running mean and its powers.
fn without_lines(
    record: &Summary,
    mut mask: Vec<bool>,
    mut lines: Vec<Line>,
    filter: Option<(RunningMean, &[f64])>,
    options: &Options,
) -> (Vec<bool>, Vec<Line>) {
    for _ in 0..if options.lines { LINE_SEARCHES } else { 0 } {
        let floor = of_terms(record, &mask, filter.map(|(mean, _)| mean));
        let found = above_medians(record, &mut mask, floor.as_deref(), filter.map(|(_, powers)| powers));
        if found.is_empty() {
            break;
        }
        lines.extend(found);
    }
    (mask, without_images(record, lines))
}

/// Adds the regressors of the mean to the model.
fn drifting<'a>(
    mut attempt: Attempt<'a>,
    regressors: &Arc<Vec<Regressor>>,
    options: &Options,
) -> (Attempt<'a>, Drifts) {
    let of_lines = attempt.bins.regressors.iter().skip(regressors.len()).cloned();
    attempt.bins.regressors = Arc::new(regressors.iter().cloned().chain(of_lines).collect());
    let drifts = with_drifts(&mut attempt.fit, &mut attempt.bins, thresholds(options.level), options.drifts);
    (attempt, drifts)
}

/// Intervals of a model, and the model without the terms that were not observed.
pub(crate) struct Inferred {
    pub terms: Vec<Bounds>,
    pub reduced: Fit,
    processes: Vec<Process>,
    covariance: Symmetric,
    alike_from: Option<(f64, f64)>,
    second: Vec<Second>,
    discrepancy: Vec<(f64, f64)>,
}

/// The intervals of a fitted model.
pub(crate) fn inferred(
    plain: &Fit,
    bins: &Bins,
    p_value: f64,
    tails: Tails,
    allowed: Allowed,
    level: f64,
) -> Inferred {
    let tail_thresholds = thresholds(level);
    let (limited, limited_bins, discrepancy) = widened(plain, bins);
    let thresholds = model_thresholds(p_value, level);
    let (mut terms, mut reduced) = intervals(&limited, &limited_bins, thresholds);
    let mut second = join_alike(&mut terms, plain, bins, thresholds, allowed);
    join_without_resonances(&mut terms, plain, bins, thresholds);
    reduced = reduced.model.clone().refit(bins, 40, TOLERANCE, plain);
    value_of_likelihood(&mut terms, plain, &reduced);
    if let Some(j) = plain.model.index(Term::RandomWalk) {
        heavy_tails(&mut terms[j], tails, tail_thresholds);
    }
    // These values come from the reduced model, like those of the terms, because together they are the model of the record.
    let processes: Vec<Process> = limited
        .model
        .processes()
        .zip(reduced.model.processes())
        .map(|(j, k)| {
            let part = reduced.model.parts[k];
            let shape = match (time_bounds(&limited, &limited_bins, j, thresholds), part) {
                (Some(bounds), Part::GaussMarkov { time }) => [Some(bounds.around(time)), None],
                (_, Part::Resonance { frequency, width }) => {
                    resonance_bounds(&limited, &limited_bins, j, thresholds)
                        .map_or([None, None], |[centre, half]| {
                            [Some(centre.around(frequency)), Some(half.around(width))]
                        })
                }
                _ => [None, None],
            };
            let variance = part_bounds(&limited, &limited_bins, j, thresholds).around(reduced.model.theta[k]);
            Process { part, variance, shape }
        })
        .collect();
    // White noise after a first-order filter is such a process, with N² = 2σ²T.
    if let Some(j) = plain.model.index(Term::RandomWalk).filter(|_| hides_white_noise(plain)) {
        for process in &processes {
            if let Part::GaussMarkov { time } = process.part {
                if time <= SLOWEST_FILTER {
                    terms[j].high = terms[j].high.max(2.0 * process.variance.high * time);
                    second.push(behind_filter(&reduced, process));
                }
            }
        }
    }
    // After a slow filter the level at low frequencies is the sum of both.
    if let (Some(j), Some(slowest)) = (plain.model.index(Term::RandomWalk), slowest_process(plain, bins)) {
        for process in &processes {
            if let Part::GaussMarkov { time } = process.part {
                if time <= slowest {
                    let both = terms[j].value + 2.0 * process.variance.high * time;
                    terms[j].high = terms[j].high.max(both);
                }
            }
        }
    }
    let (information, _) = reduced.information(&limited_bins);
    let covariance = information.pseudo_inverse();
    let alike_from = process_like_walk(&reduced, &limited_bins, thresholds);
    Inferred { terms, reduced, processes, covariance, alike_from, second, discrepancy }
}

/// The limit of a term that is not observed.
fn unseen(plain: &Fit, bins: &Bins, part: usize, p_value: f64, level: f64) -> Bounds {
    let (limited, limited_bins, _) = widened(plain, bins);
    part_bounds(&limited, &limited_bins, part, model_thresholds(p_value, level))
}

/// The thresholds of the intervals of a model.
fn model_thresholds(p_value: f64, level: f64) -> Thresholds {
    if p_value < MIN_P_VALUE { thresholds_of_student(level, WIGGLE_FREEDOM) } else { thresholds(level) }
}

/// The model in which a process is white noise after a first-order filter.
fn behind_filter(fit: &Fit, process: &Process) -> Second {
    let mut terms = squares(fit);
    let mut gauss_markov: Vec<(f64, f64)> = gauss_markov(fit).collect();
    let mut filter = None;
    if let Part::GaussMarkov { time } = process.part {
        terms[Term::RandomWalk.index()] += 2.0 * process.variance.value * time;
        gauss_markov.retain(|&(_, other)| other.to_bits() != time.to_bits());
        filter = Some(1.0 / (2.0 * PI * time));
    }
    Second { terms, gauss_markov, warm_up: None, exponent: None, filter }
}

/// Largest correlation time for which a process is as fast as the filter of a model. \[s\]
fn slowest_process(fit: &Fit, bins: &Bins) -> Option<f64> {
    const MAX_TIME_RATIO: f64 = 3.0; // relative to the time constant of the filter
    let corner = fit.model.family?.shape(&fit.model.filter).half_power() / bins.record.tau0;
    Some(MAX_TIME_RATIO / (2.0 * PI * corner))
}

/// The result of a model, without lines and drifts.
pub(crate) fn outcome(plain: &Fit, bins: &Bins, test: Adequacy, found: Inferred) -> Outcome {
    let Inferred { terms, reduced, processes, covariance, alike_from, second, discrepancy } = found;
    // Levels and separate terms of several runs come last, and are not part of the result.
    let count = reduced.model.numbers();
    Outcome {
        alike_from,
        matern: None,
        second,
        terms: TERMS.map(|part| plain.model.index(part).map(|j| terms[j])),
        reduced: squares(&reduced),
        processes,
        filter: reduced.model.filter.clone(),
        mean: reduced.model.mean,
        family: reduced.model.family,
        of_white: reduced.model.of_white,
        filter_interval: reduced.model.interval(bins),
        lines: Vec::new(),
        slow_lines: Vec::new(),
        end_of_modes: bins.record.mode_frequency(bins.record.low_modes().max(1)),
        highest: None,
        ramp: Drift { value: f64::NAN, error: f64::NAN },
        ramp_observed: false,
        warm_up: None,
        regressors: Vec::new(),
        p_value: test.p_value,
        widened: test.p_value < MIN_P_VALUE,
        bands: test.bands,
        discrepancy,
        levels: Vec::new(),
        parameters: reduced.model.parts.clone(),
        covariance: (0..count)
            .flat_map(|i| (0..count).map(move |j| (i, j)))
            .map(|(i, j)| covariance.get(i, j))
            .collect(),
        bins: (0..bins.len())
            .map(|i| [bins.frequency[i], plain.powers[i], plain.spectrum[i], bins.freedom[i]])
            .collect(),
    }
}
