//! Curves that the mean follows: a ramp, a warm-up, those given.

use crate::likelihood::bins::{Bins, Regressor};
use crate::likelihood::fit::Fit;
use crate::likelihood::outcome::{Drift, Options};
use crate::likelihood::profile::{Thresholds, of_part};
use crate::likelihood::summary::Summary;
use crate::terms::Term;
use std::f64::consts::PI;
use std::sync::Arc;

/// Smallest fall of the deviance for a warm-up, and its time constants over the length of the record.
const WARM_UP: f64 = 16.0;

const WARM_UPS: [f64; 7] = [96.0, 48.0, 24.0, 12.0, 6.0, 3.0, 1.5];

/// Steps of the logarithm of the time constant by which the best one is refined.
const REFINED: [f64; 4] = [0.34, 0.17, 0.09, 0.045];

/// Step of the derivative by the logarithm of the time constant.
const SLOPE: f64 = 1e-3;

/// Fall of the deviance by which a warm-up must be better than a ramp.
const CURVATURE: f64 = 6.0;

/// Number of standard errors from which on a ramp counts, with the rate random walk at its upper limit.
const RAMP: f64 = 3.3;

/// Number of steps of the search for the ends of its interval.
const RAMP_DOUBLINGS: usize = 8;

const RAMP_HALVINGS: usize = 5;

pub(crate) const RAMP_AT: usize = 2;

const WARM_AT: usize = 3;

pub(crate) const GIVEN_AT: usize = WARM_AT + WARM_UPS.len();

/// The curves that the mean may follow: the end values of the angle, a ramp, warm-ups, and those given.
pub(crate) fn regressors(record: &Summary, options: &Options) -> Vec<Regressor> {
    let (m, length) = (record.blocks as f64, record.block_length());
    // With missing samples the ends are those of runs, and their weights fall to 0 there.
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

/// The drifts of the mean that a fit found.
pub(crate) struct Drifts {
    pub ramp: Drift,
    pub ramp_observed: bool,
    /// Time constant \[s\], amplitude at the start, and fall of the deviance.
    pub warm_up: Option<(f64, Drift, f64)>,
}

/// The ramp and the warm-up of a fit, the larger one first, each if it stands out; whatever the fit had before. Without
/// them a selection takes a drift for processes. The curve of the warm-up takes the place of the nearest one of the grid.
pub(crate) fn with_drifts(fit: &mut Fit, bins: &mut Bins, at: Thresholds, wanted: bool) -> Drifts {
    if fit.model.regressors.iter().any(|k| (RAMP_AT..GIVEN_AT).contains(k)) {
        let mut model = fit.model.clone();
        model.regressors.retain(|k| !(RAMP_AT..GIVEN_AT).contains(k));
        *fit = model.fit(bins);
    }
    let mut found = Drifts { ramp: drift(fit, RAMP_AT), ramp_observed: false, warm_up: None };
    let mut chosen = None;
    loop {
        let ramp = if found.ramp_observed { None } else { Some(ramp_of(fit, bins, at)) };
        let warm_up = if wanted && chosen.is_none() { best_warm_up(fit, bins) } else { None };
        if let Some((value, observed, gain, next)) = ramp {
            found.ramp = value;
            if wanted && observed && warm_up.as_ref().is_none_or(|w| w.0 < gain + CURVATURE) {
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
        found.ramp = profiled_ramp(fit, bins, at);
    }
    found
}

/// The ramp, and half of its profile interval in standard errors: the rate random walk may grow while the ramp is held
/// fixed.
fn profiled_ramp(fit: &Fit, bins: &Bins, at: Thresholds) -> Drift {
    let plain = drift(fit, RAMP_AT);
    let mut bare = fit.model.clone();
    bare.regressors.retain(|&k| k != RAMP_AT);
    let rise = |value: f64| {
        let ramp = &bins.regressors[RAMP_AT].modes;
        let modes = bins.record.modes.iter().zip(ramp).map(|(x, r)| x - value * r).collect();
        let record = Summary { modes, ..bins.record.clone() };
        let held = bare.clone().fit(&bins.of_record(&record));
        held.deviance - held.restricted
    };
    let target = at.interval + rise(plain.value);
    let end = |sign: f64| {
        let (mut inside, mut outside) = (0.0, plain.error * at.interval.sqrt());
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
    Drift { value: plain.value, error: 0.5 * (end(1.0) + end(-1.0)) / at.interval.sqrt() }
}

/// The best fit with a warm-up that the fit does not have yet, and its fall of the deviance; None if it has one. Its time
/// constant is that of the grid. \[s\]
pub(crate) fn with_warm_up(fit: &Fit, bins: &Bins) -> Option<(f64, f64, Fit)> {
    if fit.model.regressors.iter().any(|k| (WARM_AT..GIVEN_AT).contains(k)) {
        return None;
    }
    let (gain, k, found) = best_of_warm_ups(fit, bins)?;
    Some((gain, bins.record.duration() / WARM_UPS[k], found))
}

/// Fall of the deviance by a regressor. The likelihoods are not the restricted ones: regressors differ.
pub(crate) fn gain_of(fit: &Fit, next: &Fit) -> f64 {
    (fit.deviance - fit.restricted) - (next.deviance - next.restricted)
}

/// The warm-up from the first sample on that lowers the deviance most, if it stands out.
fn best_warm_up(fit: &Fit, bins: &Bins) -> Option<(f64, usize, Fit)> {
    best_of_warm_ups(fit, bins).filter(|(gain, ..)| *gain > WARM_UP)
}

/// The warm-up of the grid that lowers the deviance most: by how much, its place in the grid, and the fit.
fn best_of_warm_ups(fit: &Fit, bins: &Bins) -> Option<(f64, usize, Fit)> {
    let tried = (0..WARM_UPS.len()).map(|k| {
        let found = with_regressor(fit, bins, WARM_AT + k);
        (gain_of(fit, &found), k, found)
    });
    tried.max_by(|a, b| a.0.total_cmp(&b.0))
}

/// The warm-up of the grid with its best time constant. The error of its amplitude includes that of the time constant: the
/// derivative by the logarithm is a regressor.
fn refined(fit: &mut Fit, bins: &mut Bins, k: usize, mut gain: f64) -> (f64, Drift, f64) {
    let at = WARM_AT + k;
    let mut time = bins.record.duration() / WARM_UPS[k];
    for step in REFINED {
        for other in [time * step.exp(), time / step.exp()] {
            let bins_of_other = with_curve(bins, at, bins.record.modes_of_decay(other));
            let next = fit.model.clone().fit(&bins_of_other);
            let more = gain_of(fit, &next);
            if more > 0.0 {
                (time, gain, *fit, *bins) = (other, gain + more, next, bins_of_other);
            }
        }
    }
    let curve = |factor: f64| bins.record.modes_of_decay(time * factor);
    let slope =
        curve(1.0 + SLOPE).iter().zip(curve(1.0 - SLOPE)).map(|(a, b)| (a - b) / (2.0 * SLOPE)).collect();
    let last = bins.regressors.len();
    let error = drift(&with_regressor(fit, &with_curve(bins, last, slope), last), at).error;
    (time, Drift { error, ..drift(fit, at) }, gain)
}

/// The bins with other modes in the place of a regressor, or behind all.
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

/// The rate ramp, whether it stands out even with the rate random walk at its upper limit, the fall of the deviance, and
/// the fit.
fn ramp_of(fit: &Fit, bins: &Bins, at: Thresholds) -> (Drift, bool, f64, Fit) {
    let found = with_regressor(fit, bins, RAMP_AT);
    let gain = gain_of(fit, &found);
    let mut ramp = drift(&found, RAMP_AT);
    if ramp.value.abs() <= RAMP * ramp.error {
        return (ramp, false, gain, found);
    }
    if let Some(j) = found.model.index(Term::RateRandomWalk) {
        let high = of_part(&found, bins, j, at).high;
        if high.is_finite() {
            let mut model = found.model.clone();
            model.theta[j] = high.max(model.theta[j]);
            ramp = drift(&model.refit(bins, 0, 0.0, &found), RAMP_AT);
        }
    }
    let observed = ramp.value.abs() > RAMP * ramp.error;
    (ramp, observed, gain, found)
}
