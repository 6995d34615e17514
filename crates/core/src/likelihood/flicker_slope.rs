//! Bias instability with an exponent other than 1, in place of additional parts of a model with exponent 1.

use crate::likelihood::alike::{Alike, Walk};
use crate::likelihood::bins::Bins;
use crate::likelihood::expected::Part;
use crate::likelihood::fit::squares;
use crate::likelihood::fit::{Fit, TOLERANCE};
use crate::likelihood::model::Model;
use crate::likelihood::power_law::Mixture;
use crate::likelihood::profile::without;
use crate::likelihood::profile::{Bounds, Thresholds};
use crate::terms::Term;
use std::f64::consts::PI;

const STEPS: usize = 40;

/// Price of a parameter of a model in deviance (Akaike).
const PRICE_OF_PARAMETER: f64 = 2.0;

/// Ratio of the density to that of white noise above which other noise dominates.
const DOMINANT_RATIO: f64 = 2.0;

/// Exponent above which the noise is a random walk instead of a bias instability.
const MAX_EXPONENT: f64 = 1.75;

/// Share of the density above which a frequency counts in the mean frequency of the bias instability.
const COUNTED_SHARE: f64 = 0.5;

/// The best fit with a free exponent that explains the record as well. The free exponent replaces the bias instability and
/// processes, and in some fits the rate random walk. If it replaces fewer parameters than it has, it must be better by the
/// threshold of an interval; if as many, it must not be worse; if more, it may be worse by this threshold.
pub(crate) fn with_free_exponent(
    fit: &Fit,
    bins: &Bins,
    observed: Option<Walk>,
    thresholds: Thresholds,
) -> Option<Alike> {
    let fit = &without(
        fit,
        bins,
        vec![Part::Term(Term::BiasInstability), Part::Term(Term::RateRandomWalk)],
        thresholds,
    );
    let pivot = pivot(fit, bins)?;
    let is_process = |part: Part| matches!(part, Part::GaussMarkov { .. });
    let is_present = |test: &dyn Fn(Part) -> bool| {
        fit.model.parts.iter().zip(&fit.model.theta).any(|(&part, &theta)| theta > 0.0 && test(part))
    };
    let is_walk = |part: Part| part == Part::Term(Term::RateRandomWalk);
    let walk = is_present(&is_walk);
    if !(walk || is_present(&is_process) || is_present(&|part| part == Part::Term(Term::BiasInstability))) {
        return None;
    }
    let mut best: Option<(f64, Alike)> = None;
    for replaces_walk in [false, true] {
        if replaces_walk && !walk {
            continue;
        }
        let removed = |part: Part| {
            part == Part::Term(Term::BiasInstability) || (replaces_walk && is_walk(part)) || is_process(part)
        };
        let tried = free_exponent(fit, bins, pivot, removed);
        let fewer = numbers(&fit.model) - numbers(&tried.model);
        let rise = if fewer < 0.0 {
            -thresholds.interval
        } else if fewer > 0.0 {
            thresholds.interval
        } else {
            0.0
        };
        let price = tried.deviance + PRICE_OF_PARAMETER * numbers(&tried.model);
        let is_flicker = flicker(&tried).is_some_and(|(exponent, ..)| exponent < MAX_EXPONENT);
        let is_alike = tried.deviance <= fit.deviance + rise;
        let gives_way =
            observed.is_some_and(|walk| walk.gives_way(fit.deviance + rise - tried.deviance, 0.0));
        if is_flicker && (is_alike || gives_way) && best.as_ref().is_none_or(|(least, _)| price < *least) {
            let optional = if gives_way { vec![Part::Term(Term::RateRandomWalk)] } else { Vec::new() };
            best = Some((price, Alike { fit: tried, warm_up: None, optional }));
        }
    }
    best.map(|(_, alike)| alike)
}

/// Exponent, pivot and B² of a bias instability with a free exponent that is not 0.
fn flicker(fit: &Fit) -> Option<(f64, f64, f64)> {
    fit.model.parts.iter().zip(&fit.model.theta).find_map(|(part, &theta)| match *part {
        Part::Flicker { exponent, pivot } if theta > 0.0 => Some((exponent, pivot, theta)),
        _ => None,
    })
}

/// Number of parameters of the slow parts that are present in a model; the fast parts are the same in all compared models.
fn numbers(model: &Model) -> f64 {
    let parameters = |(part, &theta): (&Part, &f64)| match part {
        _ if theta <= 0.0 => 0.0,
        Part::Term(Term::Quantization | Term::RandomWalk) => 0.0,
        Part::GaussMarkov { .. } | Part::Flicker { .. } => 2.0,
        Part::Resonance { .. } | Part::Matern { .. } => 3.0,
        Part::Term(_) => 1.0,
    };
    model.parts.iter().zip(&model.theta).map(parameters).sum::<f64>()
}

fn free_exponent(fit: &Fit, bins: &Bins, pivot: f64, removed: impl Fn(Part) -> bool) -> Fit {
    let mut model = fit.model.clone();
    for j in (0..model.parts.len()).rev().filter(|&j| removed(fit.model.parts[j])) {
        model = model.without(j);
    }
    let part = Part::Flicker { exponent: 1.0, pivot };
    let nearest = bins.frequency[..bins.low].partition_point(|&f| f < pivot).min(bins.low - 1);
    let [_, white, ..] = squares(fit);
    let theta = 2.0 * PI * pivot * (fit.spectrum[nearest] - white).max(0.1 * fit.spectrum[nearest]);
    model.with(part, theta).refit(bins, STEPS, TOLERANCE, fit)
}

/// The middle of the frequencies below which the white noise does not dominate. \[Hz\]
fn pivot(fit: &Fit, bins: &Bins) -> Option<f64> {
    let [_, white, ..] = squares(fit);
    let below = (0..bins.low).take_while(|&i| fit.spectrum[i] > DOMINANT_RATIO * white).last()?;
    Some((bins.frequency[0] * bins.frequency[below]).sqrt())
}

/// The bias instability of a fit with a free exponent, over all frequencies at which it dominates the density.
pub(crate) fn over_frequencies(bounds: Bounds, fit: &Fit, bins: &Bins, part: usize) -> Bounds {
    let Part::Flicker { exponent, pivot } = fit.model.parts[part] else { return bounds };
    let unit = bins.unit(fit.model.parts[part]);
    let share = |i: &usize| fit.model.theta[part] * unit[*i] > COUNTED_SHARE * fit.spectrum[*i];
    let factors = (0..bins.low).filter(share).map(|i| (bins.frequency[i] / pivot).powf(1.0 - exponent));
    let (least, most) = factors.fold((1.0_f64, 1.0_f64), |(least, most), x| (least.min(x), most.max(x)));
    Bounds { low: least * bounds.low, high: most * bounds.high, ..bounds }
}

/// The exponent of a model, and the processes whose sum it is.
pub(crate) fn of_model(fit: &Fit, bins: &Bins) -> Option<(f64, Mixture)> {
    let (exponent, pivot, theta) = flicker(fit)?;
    let mixture = Mixture::new(exponent, pivot, bins.record.tau0, bins.record.duration());
    Some((exponent, mixture.times(theta)))
}
