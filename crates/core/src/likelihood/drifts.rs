//! Curves that the mean follows: a ramp, a warm-up, and given curves.

use crate::likelihood::bins::{Bins, Regressor};
use crate::likelihood::fit::Fit;
use crate::likelihood::outcome::{Drift, Options};
use crate::likelihood::profile::{Thresholds, part_bounds};
use crate::likelihood::summary::Summary;
use crate::terms::Term;
use std::f64::consts::PI;
use std::sync::Arc;

/// Smallest reduction of the deviance for a warm-up.
const WARM_UP: f64 = 16.0;

const WARM_UPS: [f64; 7] = [96.0, 48.0, 24.0, 12.0, 6.0, 3.0, 1.5];

/// Steps of the logarithm of the time constant in its refinement.
const REFINING_STEPS: [f64; 4] = [0.34, 0.17, 0.09, 0.045];

/// Step for the derivative with respect to the logarithm of the time constant.
const LOG_TIME_STEP: f64 = 1e-3;

/// Deviance by which a warm-up must be better than a ramp.
const PRICE_OF_WARM_UP: f64 = 6.0;

/// Number of standard errors above which a ramp counts, with the rate random walk at its upper limit.
const MIN_RAMP_ERRORS: f64 = 3.3;

/// Number of steps of the search for the ends of the interval of a ramp.
const RAMP_DOUBLINGS: usize = 8;

const RAMP_HALVINGS: usize = 5;

pub(crate) const RAMP_INDEX: usize = 2;

const FIRST_WARM_UP: usize = 3;

pub(crate) const FIRST_REGRESSOR: usize = FIRST_WARM_UP + WARM_UPS.len();

/// The curves that the mean may follow: the end values of the angle, a ramp, warm-ups, and given curves.
pub(crate) fn regressors(record: &Summary, options: &Options) -> Vec<Regressor> {
    let (m, length) = (record.blocks as f64, record.block_length());
    // With missing samples the ends are those of runs, where the weights fall to 0.
    let length = if record.masked.is_some() { f64::INFINITY } else { length };
    let samples = m * record.block as f64;
    let end = |k: usize| (2.0 / m).sqrt() * (PI * k as f64 / (2.0 * samples)).cos() / length.sqrt();
    let modes = 1..=record.modes.len();
    let last = modes.clone().map(|k| if k % 2 == 0 { end(k) } else { -end(k) }).collect();
    let mut found = vec![Regressor::of_modes(last), Regressor::of_modes(modes.map(end).collect())];
    found.push(Regressor::of_modes(record.modes_of_ramp()));
    found.extend(WARM_UPS.map(|share| Regressor::of_modes(record.modes_of_decay(record.duration() / share))));
    found.extend(options.regressors.iter().map(|curve| Regressor::of_modes(record.modes_of(curve))));
    found
}

/// The coefficient of a regressor.
pub(crate) fn drift(fit: &Fit, regressor: usize) -> Drift {
    match fit.model.regressors.iter().position(|&k| k == regressor) {
        Some(k) => Drift { value: fit.beta[k], error: fit.beta_covariance.get(k, k).max(0.0).sqrt() },
        None => Drift { value: f64::NAN, error: f64::NAN },
    }
}

fn with_regressor(fit: &Fit, bins: &Bins, regressor: usize) -> Fit {
    let mut model = fit.model.clone();
    model.regressors.push(regressor);
    model.fit(bins)
}

/// The drifts of the mean in a fit.
pub(crate) struct Drifts {
    pub ramp: Drift,
    pub ramp_observed: bool,
    /// Time constant \[s\], amplitude at the start, and reduction of the deviance.
    pub warm_up: Option<(f64, Drift, f64)>,
}

/// Adds the ramp and the warm-up to a fit, the larger one first, if they are significant, and replaces earlier ones.
/// Without them a selection mistakes a drift for processes. The curve of the warm-up replaces the nearest one of the grid.
pub(crate) fn with_drifts(fit: &mut Fit, bins: &mut Bins, thresholds: Thresholds, wanted: bool) -> Drifts {
    if fit.model.regressors.iter().any(|k| (RAMP_INDEX..FIRST_REGRESSOR).contains(k)) {
        let mut model = fit.model.clone();
        model.regressors.retain(|k| !(RAMP_INDEX..FIRST_REGRESSOR).contains(k));
        *fit = model.fit(bins);
    }
    let mut found = Drifts { ramp: drift(fit, RAMP_INDEX), ramp_observed: false, warm_up: None };
    let mut chosen = None;
    loop {
        let ramp = if found.ramp_observed { None } else { Some(ramp_of(fit, bins, thresholds)) };
        let warm_up = if wanted && chosen.is_none() { best_warm_up(fit, bins) } else { None };
        if let Some((value, observed, gain, next)) = ramp {
            found.ramp = value;
            if wanted && observed && warm_up.as_ref().is_none_or(|w| w.0 < gain + PRICE_OF_WARM_UP) {
                *fit = next;
                found.ramp_observed = true;
                continue;
            }
        }
        let Some((gain, k, next)) = warm_up else { break };
        *fit = next;
        chosen = Some((k, gain));
    }
    found.warm_up = chosen.map(|(k, gain)| refined(fit, bins, k, gain));
    if found.ramp_observed {
        found.ramp = profiled_ramp(fit, bins, thresholds);
    }
    found
}

/// The ramp and the half width of its profile interval: for a fixed ramp the rate random walk may grow.
fn profiled_ramp(fit: &Fit, bins: &Bins, thresholds: Thresholds) -> Drift {
    let plain = drift(fit, RAMP_INDEX);
    let mut bare = fit.model.clone();
    bare.regressors.retain(|&k| k != RAMP_INDEX);
    let rise = |value: f64| {
        let ramp = &bins.regressors[RAMP_INDEX].modes;
        let modes = bins.record.modes.iter().zip(ramp).map(|(x, r)| x - value * r).collect();
        let record = Summary { modes, ..bins.record.clone() };
        let held = bare.clone().fit(&bins.of_record(&record));
        held.deviance - held.restricted
    };
    let target = thresholds.interval + rise(plain.value);
    let end = |sign: f64| {
        let (mut inside, mut outside) = (0.0, plain.error * thresholds.interval.sqrt());
        for _ in 0..RAMP_DOUBLINGS {
            if rise(plain.value + sign * outside) > target {
                break;
            }
            (inside, outside) = (outside, 2.0 * outside);
        }
        for _ in 0..RAMP_HALVINGS {
            let middle = 0.5 * (inside + outside);
            *if rise(plain.value + sign * middle) > target { &mut outside } else { &mut inside } = middle;
        }
        outside
    };
    Drift { value: plain.value, error: 0.5 * (end(1.0) + end(-1.0)) / thresholds.interval.sqrt() }
}

/// The best fit with an additional warm-up, its time constant from the grid \[s\] and the reduction of the deviance; None
/// if the fit has a warm-up.
pub(crate) fn with_warm_up(fit: &Fit, bins: &Bins) -> Option<(f64, f64, Fit)> {
    if fit.model.regressors.iter().any(|k| (FIRST_WARM_UP..FIRST_REGRESSOR).contains(k)) {
        return None;
    }
    let (gain, k, found) = best_of_warm_ups(fit, bins)?;
    Some((gain, bins.record.duration() / WARM_UPS[k], found))
}

/// Reduction of the deviance by a regressor. The likelihoods are not restricted, because the regressors differ.
pub(crate) fn gain_of(fit: &Fit, next: &Fit) -> f64 {
    (fit.deviance - fit.restricted) - (next.deviance - next.restricted)
}

/// The warm-up that reduces the deviance most, if it is significant.
fn best_warm_up(fit: &Fit, bins: &Bins) -> Option<(f64, usize, Fit)> {
    best_of_warm_ups(fit, bins).filter(|(gain, ..)| *gain > WARM_UP)
}

/// The warm-up of the grid that reduces the deviance most: the reduction, its place in the grid, and the fit.
fn best_of_warm_ups(fit: &Fit, bins: &Bins) -> Option<(f64, usize, Fit)> {
    let tried = (0..WARM_UPS.len()).map(|k| {
        let found = with_regressor(fit, bins, FIRST_WARM_UP + k);
        (gain_of(fit, &found), k, found)
    });
    tried.max_by(|a, b| a.0.total_cmp(&b.0))
}

/// The warm-up of the grid with its best time constant. The error of its amplitude includes that of the time constant: the
/// derivative with respect to the logarithm is a regressor.
fn refined(fit: &mut Fit, bins: &mut Bins, k: usize, mut gain: f64) -> (f64, Drift, f64) {
    let at = FIRST_WARM_UP + k;
    let mut time = bins.record.duration() / WARM_UPS[k];
    for step in REFINING_STEPS {
        for other in [time * step.exp(), time / step.exp()] {
            let other_bins = with_curve(bins, at, bins.record.modes_of_decay(other));
            let next = fit.model.clone().fit(&other_bins);
            let more = gain_of(fit, &next);
            if more > 0.0 {
                (time, gain, *fit, *bins) = (other, gain + more, next, other_bins);
            }
        }
    }
    let curve = |factor: f64| bins.record.modes_of_decay(time * factor);
    let slope = curve(1.0 + LOG_TIME_STEP)
        .iter()
        .zip(curve(1.0 - LOG_TIME_STEP))
        .map(|(a, b)| (a - b) / (2.0 * LOG_TIME_STEP))
        .collect();
    let last = bins.regressors.len();
    let error = drift(&with_regressor(fit, &with_curve(bins, last, slope), last), at).error;
    (time, Drift { error, ..drift(fit, at) }, gain)
}

/// The bins with other modes in place of a regressor, or appended.
fn with_curve<'a>(bins: &Bins<'a>, at: usize, modes: Vec<f64>) -> Bins<'a> {
    let mut all = bins.regressors.to_vec();
    match all.get_mut(at) {
        Some(old) => old.modes = modes,
        None => all.push(Regressor::of_modes(modes)),
    }
    let mut bins = bins.clone();
    bins.regressors = Arc::new(all);
    bins
}

/// The rate ramp, whether it is significant even with the rate random walk at its upper limit, the reduction of the
/// deviance, and the fit.
fn ramp_of(fit: &Fit, bins: &Bins, thresholds: Thresholds) -> (Drift, bool, f64, Fit) {
    let found = with_regressor(fit, bins, RAMP_INDEX);
    let gain = gain_of(fit, &found);
    let mut ramp = drift(&found, RAMP_INDEX);
    if ramp.value.abs() <= MIN_RAMP_ERRORS * ramp.error {
        return (ramp, false, gain, found);
    }
    if let Some(j) = found.model.index(Term::RateRandomWalk) {
        let high = part_bounds(&found, bins, j, thresholds).high;
        if high.is_finite() {
            let mut model = found.model.clone();
            model.theta[j] = high.max(model.theta[j]);
            ramp = drift(&model.refit(bins, 0, 0.0, &found), RAMP_INDEX);
        }
    }
    let observed = ramp.value.abs() > MIN_RAMP_ERRORS * ramp.error;
    (ramp, observed, gain, found)
}
