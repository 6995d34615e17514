//! The fit of a curve: tests, intervals and limits of its terms if a model is adequate, otherwise a description.

use crate::gls::attempt::{Attempt, Data, largest};
use crate::gls::components::Components;
use crate::gls::evidence::Evidence;
use crate::gls::laws::UpperShare;
use crate::gls::non_negative::relative_fit;
use crate::gls::process::{Interval, intervals};
use crate::gls::selection::{MIN_P, best_attempt};
use crate::gls::step::{Gls, Work};
use crate::gls::{Failed, LINEAR, QUANTIZATION, RATE_RANDOM_WALK, TERMS, Terms, Theta, finite};
use std::sync::Arc;

/// Share of the width of an interval. A value closer to an end is tested without the terms that were not observed.
const SHARE_NEAR_END: f64 = 0.2;

/// Smallest p-value; smaller ones are rounding errors.
const SMALLEST_P: f64 = 1e-12;

/// Relative error of a variance in a descriptive fit: 5 % of a deviation.
const DESCRIPTIVE_ERROR: f64 = 0.1;

const DESCRIPTIVE_STEPS: usize = 4;

/// A ramp per sample with its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ramps {
    /// Estimate of the ramp.
    pub value: f64,
    /// Half width of the interval.
    pub half_width: f64,
    /// Two-sided p-value.
    pub p_value: f64,
    /// Whether it is not significant, but would be if the noise were known exactly.
    pub undecided: bool,
}

/// Result of an adequate model, with squared coefficients for a sample interval of 1.
#[derive(Debug, Clone, PartialEq)]
pub struct AdequateFit {
    /// Index of the shortest averaging time that was used.
    pub first: usize,
    /// P-value of the goodness of fit.
    pub p_value: f64,
    /// Terms that were fitted, in their order.
    pub evidence: [Option<Evidence>; LINEAR],
    /// Terms that are significant.
    pub observed: Terms,
    /// Terms that are not significant although the model does not fit without them. If [`AdequateFit::ramp`] is undecided, one of
    /// them may be the ramp.
    pub unclear: Option<Terms>,
    /// Coefficients that together describe the curve.
    pub theta: Theta,
    /// Covariance of the positive noise terms, in row order.
    pub covariance: Vec<f64>,
    /// The ramp, if one was tested.
    pub ramp: Option<Ramps>,
    /// Standard deviation and correlation time of a Gauss-Markov process, each with its interval.
    pub process: Option<(Interval, Interval)>,
    /// The left-out averaging time with the largest difference: its index, and the ratio of the deviations.
    pub left_out: Option<(usize, f64)>,
}

/// Coefficients that describe a curve to a few per cent, where no model is adequate.
#[derive(Debug, Clone, PartialEq)]
pub struct Described {
    /// Index of the shortest averaging time that was used.
    pub first: usize,
    /// Largest p-value of a model; None if no model could be fitted.
    pub p_value: Option<f64>,
    /// Whether that model was adequate, but its covariance is not positive definite.
    pub no_covariance: bool,
    /// Squared coefficients, that of the ramp last.
    pub theta: Theta,
    /// Terms that the description needs.
    pub needed: Terms,
    /// Index of the averaging time with the largest difference, and the ratio of the measured to the described deviation.
    pub worst: (usize, f64),
}

/// Result of the fit of a curve.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// A model is adequate.
    Adequate(Box<AdequateFit>),
    /// No model is adequate.
    Described(Described),
}

/// Selects a model, fits and tests it.
///
/// # Errors
///
/// [`Failed`] for variances that are not positive numbers.
pub fn fit(data: &Data, level: f64) -> Result<Outcome, Failed> {
    let mut work = Work::default();
    let (best, adequate) = best_attempt(data, level, &mut work);
    let found = best.as_ref().filter(|_| adequate).map(|best| stated(data, best, level, &mut work));
    if let Some(Ok(found)) = found {
        return Ok(Outcome::Adequate(Box::new(found)));
    }
    // Even for an adequate model, rounding may make the covariance for trial values far from the fit indefinite.
    let described = described(data, best.as_ref())?;
    Ok(Outcome::Described(Described { no_covariance: adequate, ..described }))
}

fn stated(data: &Data, best: &Attempt, level: f64, work: &mut Work) -> Result<AdequateFit, Failed> {
    let shares = UpperShare::of(level);
    let (gls, theta) = (&best.gls, &best.theta);
    let linear = gls.candidates.and(Terms::first(LINEAR));
    let extra = gls.candidates.and(Terms::of(&[LINEAR]));
    let mut evidence = [None; LINEAR];
    let mut observed = Terms(0);
    for p in linear.iter() {
        let found = limited(gls, p, theta, level, &shares, work)?;
        if found.p_value < 1.0 - level {
            observed = observed.with(p);
        }
        evidence[p] = Some(found);
    }
    let undecided = best.ramp.is_some_and(|ramp| ramp.suspicious() && ramp.used == 0.0);
    let asked = undecided && observed.contains(RATE_RANDOM_WALK);
    if let Some((ramp_removed, theta_ramp_removed)) = best.ramp_removed.as_ref().filter(|_| asked) {
        // It is undecided whether the noise explains the ramp: is the walk significant without the ramp?
        let without = ramp_removed.evidence_in(RATE_RANDOM_WALK, theta_ramp_removed, level, &shares, work)?;
        if without.p_value >= 1.0 - level {
            observed = observed.without(RATE_RANDOM_WALK);
            evidence[RATE_RANDOM_WALK] =
                evidence[RATE_RANDOM_WALK].map(|found| Evidence { low: 0.0, ..found });
        }
    }
    let chosen = observed.or(extra);
    let mut selected = if chosen.is_empty() { *theta } else { gls.fit_in(chosen, None, None, work)? };
    let mut unclear = None;
    if chosen.is_empty() || gls.p_value_in(&selected, work)? <= MIN_P {
        // Several terms, none of which is significant given the others, although at least one is needed.
        selected = *theta;
        let not_observed = linear.iter().filter(|&p| theta[p] > 0.0 && !observed.contains(p));
        unclear = Some(not_observed.fold(Terms(0), Terms::with));
    }
    // Terms that the record does not distinguish are included: their sum is better determined than each term.
    let positive = Terms::positive(&selected);
    let used = positive.and(linear);
    let mut covariance = Vec::new();
    if !used.is_empty() {
        let with_process = used.or(positive.and(Terms::of(&[LINEAR])));
        let all = gls.covariance_of_theta_in(&selected, with_process, work)?;
        let (width, count) = (with_process.iter().count(), used.iter().count());
        covariance = all.chunks_exact(width).take(count).flat_map(|row| &row[..count]).copied().collect();
    }
    for p in observed.iter() {
        let Some(e) = evidence[p] else { continue };
        let margin = SHARE_NEAR_END * (e.high - e.low);
        if !(e.low + margin <= selected[p] && selected[p] <= e.high - margin) {
            // The value is far from the middle of the interval, which allows for terms that were not observed. The interval
            // without these terms is therefore included.
            let tangent = gls.tangent.clone().filter(|_| !extra.is_empty());
            let without = Gls { candidates: chosen, tangent, ..gls.clone() };
            let alone = limited(&without, p, &selected, level, &shares, work)?;
            evidence[p] = Some(Evidence { low: e.low.min(alone.low), high: e.high.max(alone.high), ..e });
        }
    }
    let process = match best.time {
        Some(time) if selected[LINEAR] > 0.0 => Some(intervals(best, time, data, &selected, level, work)?),
        _ => None,
    };
    let ramp = best.ramp.map(|ramp| Ramps {
        value: ramp.value,
        half_width: ramp.half_width(level),
        p_value: ramp.p_value,
        undecided,
    });
    Ok(AdequateFit {
        first: best.first,
        p_value: best.p_value,
        evidence,
        observed,
        unclear,
        theta: selected,
        covariance,
        ramp,
        process,
        left_out: best.left_out(data),
    })
}

/// The evidence of one term. If it has no limit because other terms are poorly determined, the limit is that of the term
/// alone.
fn limited(
    gls: &Gls,
    term: usize,
    theta: &Theta,
    level: f64,
    shares: &UpperShare,
    work: &mut Work,
) -> Result<Evidence, Failed> {
    let found = gls.evidence_in(term, theta, level, shares, work)?;
    if found.high.is_finite() {
        return Ok(found);
    }
    let alone = Gls::new(&gls.parts, gls.first, &gls.avar, Terms::of(&[term]), None);
    let (design, ramp_weights) = (gls.design.clone(), gls.ramp_weights.clone());
    let alone = Gls { design, ramp_weights, digitising: gls.digitising.clone(), ..alone };
    let theta = alone.fit_in(alone.candidates, None, None, work)?;
    Ok(Evidence { high: alone.evidence_in(term, &theta, level, shares, work)?.high, ..found })
}

/// Coefficients that describe the curve to a few per cent.
fn described(data: &Data, nearest: Option<&Attempt>) -> Result<Described, Failed> {
    let first =
        nearest.filter(|one| one.p_value > SMALLEST_P).map_or(data.first.unwrap_or(0), |one| one.first);
    let parts = Components { base: Arc::clone(&data.base), extra: None };
    let avar = &data.avar[first..];
    let drift: Vec<f64> = data.base.squares()[first..].iter().map(|square| 0.5 * square).collect();
    let columns: [&[f64]; TERMS] =
        std::array::from_fn(|p| if p < LINEAR { &parts.design(p)[first..] } else { &drift[..] });
    let mut allowed = data.candidates;
    if data.with_ramp {
        allowed = allowed.with(LINEAR);
    }
    let (mut theta, mut errors) = descriptive_theta(&parts, first, &columns, avar, allowed)?;
    let others = allowed.without(QUANTIZATION);
    if data.exceeded_by_quantization(first, theta[QUANTIZATION]) && !others.is_empty() {
        (theta, errors) = descriptive_theta(&parts, first, &columns, avar, others)?;
    }
    let expected: Vec<f64> =
        (0..avar.len()).map(|i| (0..TERMS).map(|p| theta[p] * columns[p][i]).sum()).collect();
    let mut needed = Terms(0);
    for p in 0..TERMS {
        let share = columns[p].iter().zip(&expected).map(|(column, all)| theta[p] * column / all);
        if theta[p] > 0.0 && share.fold(0.0, f64::max) > DESCRIPTIVE_ERROR {
            needed = needed.with(p);
        }
    }
    let ratios = avar.iter().zip(&expected).zip(&errors).enumerate();
    let ratios = ratios
        .map(|(i, ((avar, all), error))| (first + i, (avar / all).sqrt(), (avar / all).ln().abs() / error));
    let worst = largest(ratios).ok_or(Failed)?;
    finite(worst.1)?;
    let p_value = nearest.map(|one| one.p_value);
    Ok(Described { first, p_value, no_covariance: false, theta, needed, worst })
}

/// θ fitted to the variances with errors of at least a tenth, the squared ramp last, and these relative errors.
fn descriptive_theta(
    parts: &Components,
    first: usize,
    columns: &[&[f64]; TERMS],
    avar: &[f64],
    allowed: Terms,
) -> Result<(Theta, Vec<f64>), Failed> {
    let used: Vec<&[f64]> = allowed.iter().map(|p| columns[p]).collect();
    let mut theta = [0.0; TERMS];
    let mut errors = vec![DESCRIPTIVE_ERROR; avar.len()];
    for _ in 0..DESCRIPTIVE_STEPS {
        let found = relative_fit(&used, avar, &errors)?;
        allowed.iter().zip(found).for_each(|(p, value)| theta[p] = value);
        if theta[..LINEAR].iter().any(|&value| value > 0.0) {
            let ramp = theta[LINEAR].sqrt();
            let freedom = parts.degrees_of_freedom(first, &theta, ramp);
            errors
                .iter_mut()
                .zip(freedom)
                .for_each(|(error, edf)| *error = DESCRIPTIVE_ERROR.hypot((2.0 / edf).sqrt()));
        }
    }
    Ok((theta, errors))
}
