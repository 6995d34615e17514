//! A Gauss-Markov process in place of a rate random walk or of bias instability.
//!
//! If the walk is far too high at the longest times, a step from the fit with the walk gives no information, so each
//! correlation time is tested by full fits. These use one averaging time per octave, because the covariance of a process is
//! recomputed for each correlation time.

use crate::distributions::normal_quantile;
use crate::gls::attempt::{Attempt, Data};
use crate::gls::goodness::octaves;
use crate::gls::step::Work;
use crate::gls::{BIAS_INSTABILITY, Failed, LINEAR, RATE_RANDOM_WALK, Terms, Theta};

/// Smallest gain in deviance, as in the likelihood: at most 2.3 % of 300 ideal records in each of 18 cells had a larger gain
/// and p < 0.3.
const MIN_GAIN: f64 = 7.0;

/// Shortest correlation time over the shortest averaging time.
const MIN_TIME_RATIO: f64 = 10.0;

/// Length of the record over the longest correlation time.
const LONGEST_SHARE: f64 = 4.0;

const PER_DECADE: f64 = 2.0;

/// Largest number of refinement steps; each computes a covariance.
const MAX_STEPS: usize = 3;

/// Largest step of the logarithm: half the distance of two tested times.
const LONGEST_STEP: f64 = 0.6;

/// Tolerance in standard errors.
const SMALL_STEP: f64 = 0.1;

/// Largest half width of the interval of a logarithm.
const MAX_HALF: f64 = 50.0;

/// Value, low and high.
pub(crate) type Interval = [f64; 3];

/// Correlation time in samples of a process that improves a fit by more than its price; None if there is none.
pub(crate) fn best_time(data: &Data, without: &Attempt, level: f64, work: &mut Work) -> Option<f64> {
    // Components are computed at all averaging times, so that all starts of the fit share them.
    let mut coarse = data.at_sizes(&octaves(data.sizes()));
    let start = data.sizes()[without.first];
    coarse.first = Some(coarse.sizes().partition_point(|&size| size < start));
    let shortest = (MIN_TIME_RATIO * coarse.sizes()[0] as f64).ln();
    let longest = (data.base.n() as f64 / LONGEST_SHARE).ln();
    if longest <= shortest {
        return None;
    }
    let steps = (longest - shortest) / std::f64::consts::LN_10 * PER_DECADE;
    let count = (steps.round_ties_even() as usize + 1).max(2);
    let step = (longest - shortest) / (count - 1) as f64;
    let time = |k: usize| if k + 1 == count { longest } else { shortest + step * k as f64 };
    let remove = without.ramp.is_some_and(|ramp| ramp.used != 0.0);
    let terms = without.gls.candidates;
    let least = deviance(&coarse, None, terms, remove, level, work);
    let found: Vec<f64> =
        (0..count).map(|k| replacing(&coarse, time(k).exp(), terms, remove, level, work)).collect();
    let best = (0..count).fold(0, |best, k| if found[k] < found[best] { k } else { best });
    let gain = least - found[best];
    if gain.is_nan() || gain <= MIN_GAIN {
        return None;
    }
    let inside = best > 0 && best + 1 < count;
    let begin = if inside {
        time(best) + (time(best) - time(best - 1)) * vertex([found[best - 1], found[best], found[best + 1]])
    } else {
        time(best)
    };
    let refined = refined(&coarse, terms, begin.exp(), work).ln();
    // A step beyond the range means that the record does not show a process.
    (shortest - LONGEST_STEP < refined && refined < longest + LONGEST_STEP).then(|| refined.exp())
}

/// Smallest deviance with a process in place of one of the terms.
fn replacing(data: &Data, time: f64, terms: Terms, remove: bool, level: f64, work: &mut Work) -> f64 {
    [RATE_RANDOM_WALK, BIAS_INSTABILITY]
        .into_iter()
        .filter(|&replaced| terms.contains(replaced))
        .map(|replaced| deviance(data, Some(time), terms.without(replaced), remove, level, work))
        .fold(f64::INFINITY, f64::min)
}

/// Deviance of the fit of some terms and a process, with or without the removal of a ramp; infinite if the fit fails.
fn deviance(data: &Data, time: Option<f64>, terms: Terms, remove: bool, level: f64, work: &mut Work) -> f64 {
    let first = data.first.unwrap_or(0);
    let mut found = || {
        let mut gls = data.gls(first, time)?;
        gls.candidates = if time.is_some() { terms.with(LINEAR) } else { terms };
        let mut theta = gls.fit_in(gls.candidates, None, None, work)?;
        if remove {
            (_, gls, theta) = gls.ramp(&theta, &data.ramps[first..], level, work)?;
        }
        gls.deviance_in(&theta, work)
    };
    found().unwrap_or(f64::INFINITY)
}

/// Position of the minimum of a parabola through three equidistant values, of which the middle one is the lowest, relative
/// to the middle and in units of the distance.
fn vertex(y: [f64; 3]) -> f64 {
    let curvature = y[0] - 2.0 * y[1] + y[2];
    if curvature.is_finite() && curvature > 0.0 { 0.5 * (y[0] - y[2]) / curvature } else { 0.0 }
}

/// The least-squares correlation time, by Gauss-Newton steps.
fn refined(data: &Data, terms: Terms, time: f64, work: &mut Work) -> f64 {
    let mut time = time;
    for _ in 0..MAX_STEPS {
        let Ok(Some((step, error))) = newton_step(data, terms, time, work) else { break };
        time *= step.clamp(-LONGEST_STEP, LONGEST_STEP).exp();
        if step.abs() < SMALL_STEP * error {
            break;
        }
    }
    time
}

/// A step of the logarithm of the time, and its standard error; None if there is no process.
fn newton_step(data: &Data, terms: Terms, time: f64, work: &mut Work) -> Result<Option<(f64, f64)>, Failed> {
    let first = data.first.unwrap_or(0);
    let mut gls = data.gls(first, Some(time))?;
    gls.candidates = terms.with(LINEAR);
    let theta = gls.fit_in(gls.candidates, None, None, work)?;
    if theta[LINEAR] <= 0.0 {
        return Ok(None);
    }
    let active = gls.candidates.and(Terms::positive(&theta));
    let tangent: Vec<f64> = data.by_time(first, time).iter().map(|x| theta[LINEAR] * x).collect();
    let mut left = gls.expectation(&theta);
    left.iter_mut().zip(&gls.avar).for_each(|(expected, avar)| *expected = avar - *expected);
    let width = gls.whitened(&theta, active, &[&tangent, &left], work)?;
    let last = width - 2;
    let target: Vec<f64> = work.rows.iter().map(|row| row[last + 1]).collect();
    let inverse = crate::gls::columns::PseudoInverse::new(&mut work.rows, last + 1)?;
    let step = inverse.coefficient(last, &work.rows, target.into_iter());
    Ok(Some((step, inverse.covariance(last, last).sqrt())))
}

/// Value, low and high of the standard deviation and of the correlation time, symmetric in the logarithm, with the time as
/// a free parameter.
pub(crate) fn intervals(
    found: &Attempt,
    time: f64,
    data: &Data,
    theta: &Theta,
    level: f64,
    work: &mut Work,
) -> Result<(Interval, Interval), Failed> {
    let size = theta[LINEAR];
    let tangent: Vec<f64> = data.by_time(found.first, time).iter().map(|x| size * x).collect();
    let candidates = found.gls.candidates;
    let count = candidates.iter().count();
    let inverse = found.gls.inverse(theta, candidates, Some(&tangent), work)?;
    let sd = |p: usize| inverse.covariance(p, p).sqrt();
    let k = normal_quantile(0.5 + 0.5 * level);
    let around = |value: f64, half: f64| {
        let factor = half.min(MAX_HALF).exp();
        [value, value / factor, value * factor]
    };
    Ok((around(size.sqrt(), k * sd(count - 1) / (2.0 * size)), around(time, k * sd(count))))
}
