//! Selection of the parts of a model, each of which has a price in deviance.

use crate::likelihood::adequacy::adequacy;
use crate::likelihood::bins::{Bins, MAX_FILTER};
use crate::likelihood::candidates::{Dictionary, Scores};
use crate::likelihood::exchange::{REPLACED, beside, best};
use crate::likelihood::expected::Part;
use crate::likelihood::filters::{best_of_families, other_families, other_side_of_mean};
use crate::likelihood::fit::{Fit, TOLERANCE, time_limits};
use crate::likelihood::model::Model;
use crate::likelihood::slow_lines::{add_lines, prices, without_idle_lines};
use crate::terms::Term;
use std::f64::consts::PI;

/// Prices, the smallest reductions of the deviance, for quantization noise, a coefficient of a filter, the filter
/// itself, a Gauss-Markov process and a resonance; then, while the model is not adequate, for a process, a resonance
/// and a coefficient.
const PRICE_OF_QUANTIZATION: f64 = 4.0;
const PRICE_OF_COEFFICIENT: f64 = 6.0;
const PRICE_OF_FILTER: f64 = 4.0;
const PRICE_OF_PROCESS: f64 = 14.0;
const PRICE_OF_RESONANCE: f64 = 20.0;
const PROCESS_IF_MISFIT: f64 = 9.0;
const RESONANCE_IF_MISFIT: f64 = 13.0;
const COEFFICIENT_IF_MISFIT: f64 = 3.0;

/// Rise of the deviance without a term above which the term is certain, reduction of the price of a process per certain
/// term that it replaces, and smallest price of a process.
const CERTAIN_RISE: f64 = 6.6;
const PRICE_REDUCTION: f64 = 7.0;
const MIN_PRICE: f64 = 2.0;

/// Reduction of the deviance above which a resonance below its price is an alternative explanation, and a process is stated
/// as one.
pub(crate) const ALTERNATIVE_REDUCTION: f64 = 6.0;

/// The same for a process that is joined, at the prices of `intervals`: a full fit gains much more than its first step.
const PROCESS_ALIKE: f64 = 0.2;

/// Number of further coefficients of the filter with which the intervals are joined: with 0, 1 and 2 the interval of the
/// random walk contains the truth in 86, 87 and 92 of 100 records after a second-order filter.
const OTHER_ORDERS: usize = 2;

/// Rise of the deviance up to which another shape of the filter is an alternative explanation.
const ALIKE_FILTER: f64 = 4.0;

/// P-value below which the selection continues.
pub(crate) const SELECTED_P_VALUE: f64 = 0.02;

/// Largest numbers of processes and resonances, and of steps of the selection.
const MAX_EXTRA: usize = 4;
const MAX_STEPS: usize = 14;

/// Share of quantization noise in the density at a twentieth of the rate, above which it remains when a filter is added.
const BESIDE_FILTER: f64 = 0.2;

/// Number of coefficients that are tested at once.
const FILTER_TRIES: usize = 4;

/// Parts that may be added.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(clippy::struct_excessive_bools)] // one flag for each kind of part that may be added
pub(crate) struct Allowed {
    pub quantization: bool,
    pub filter: bool,
    pub processes: bool,
    pub resonances: bool,
    pub drifts: bool,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Addition {
    Quantization,
    Filter(usize),
    Process(Part),
    Resonance(Part),
}

/// Candidates that were refused since the model last changed.
#[derive(Debug, Default)]
struct Refused {
    quantization: bool,
    filters: Vec<usize>,
    processes: bool,
    resonances: bool,
}

/// The selected model, from a fit with the terms.
pub(crate) fn select(start: Fit, bins: &Bins, allowed: Allowed) -> Fit {
    let mut fit = start;
    let bare = fit.clone();
    if allowed.filter && fit.model.filter.is_empty() && extra(&fit.model) == 0 {
        fit = with_filter(fit, bins);
    }
    if allowed.processes && extra(&fit.model) == 0 {
        let filtered = !fit.model.filter.is_empty() && bare.model.filter.is_empty();
        fit = with_process(fit, bins);
        if filtered {
            // A process with a correlation time of a second resembles a filter.
            let unfiltered = with_process(bare, bins);
            if cost(&unfiltered) < cost(&fit) {
                fit = unfiltered;
            }
        }
    }
    let dictionary = Dictionary::new(bins);
    let mut refused = Refused::default();
    for _ in 0..MAX_STEPS {
        let Some((next, addition)) = best_addition(&fit, bins, &dictionary, allowed, &mut refused) else {
            break;
        };
        fit = next;
        if !matches!(addition, Addition::Filter(_)) {
            refused = Refused::default();
        }
    }
    without_idle(without_filter(fit, bins, allowed), bins)
}

fn extra(model: &Model) -> usize {
    model.processes().count()
}

/// Selects the filter by full fits, because a score is not informative so far from the maximum.
fn with_filter(fit: Fit, bins: &Bins) -> Fit {
    let mut best: Option<(f64, Fit)> = None;
    let mut last: Option<Fit> = None;
    for count in 1..=FILTER_TRIES {
        let mut model = beside_filter(&fit, bins);
        model.filter = last.as_ref().map_or_else(Vec::new, |fit: &Fit| fit.model.filter.clone());
        model.filter.push(0.0);
        let tried = model.fit(bins);
        let gain = fit.deviance - tried.deviance - PRICE_OF_COEFFICIENT * count as f64 - PRICE_OF_FILTER;
        if gain > best.as_ref().map_or(0.0, |b| b.0) {
            best = Some((gain, tried.clone()));
        }
        last = Some(tried);
    }
    let Some((worth, series)) = best else { return fit };
    // Few parameters describe the shapes of sensor filters.
    match best_of_families(&beside_filter(&fit, bins), bins, &fit) {
        Some(found) if fit.deviance - found.deviance - price_of_filter(&found.model) >= worth => found,
        _ => series,
    }
}

fn price_of_filter(model: &Model) -> f64 {
    if model.filter.is_empty() {
        0.0
    } else {
        PRICE_OF_FILTER + PRICE_OF_COEFFICIENT * model.filter.len() as f64
    }
}

/// The model to which a filter is added, without quantization noise if its share is small.
fn beside_filter(fit: &Fit, bins: &Bins) -> Model {
    match fit.model.index(Term::Quantization) {
        Some(j) if quantization_share(fit, bins, j) < BESIDE_FILTER => fit.model.without(j),
        _ => fit.model.clone(),
    }
}

fn quantization_share(fit: &Fit, bins: &Bins, part: usize) -> f64 {
    const COMPARED_FREQUENCY: f64 = 0.05; // relative to the sampling rate
    let wanted = COMPARED_FREQUENCY / bins.record.tau0;
    let distance = |i: usize| (bins.frequency[i] - wanted).abs();
    let Some(bin) = (0..bins.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b))) else { return 0.0 };
    fit.model.theta[part] * bins.unit(Term::Quantization)[bin] / fit.spectrum[bin]
}

/// The model with slow lines as regressors of the mean, if they are worth more than other explanations, and its bins. A
/// line may be visible above a fit with only the terms, which does not yet have processes in its place, or above the
/// selected model.
pub(crate) fn select_with_lines<'a>(start: &Fit, bins: Bins<'a>, allowed: Allowed) -> (Fit, Bins<'a>) {
    let plain = select(start.clone(), &bins, allowed);
    let mut best: Option<(f64, Fit, Bins)> = None;
    for from in [start, &plain] {
        let (mut fit, mut with) = (from.clone(), bins.clone());
        if !add_lines(&mut fit, &mut with) {
            continue;
        }
        fit = select(fit, &with, allowed);
        add_lines(&mut fit, &mut with);
        without_idle_lines(&mut fit, &with);
        let least = cost(&fit) + prices(&fit, &with);
        if least < best.as_ref().map_or(cost(&plain), |(present, ..)| *present) {
            best = Some((least, fit, with));
        }
    }
    best.map_or((plain, bins), |(_, fit, with)| (fit, with))
}

/// The deviance of a model with the prices of its parts.
pub(crate) fn cost(fit: &Fit) -> f64 {
    let price = |(part, &theta): (&Part, &f64)| match part {
        Part::GaussMarkov { .. } => PRICE_OF_PROCESS,
        Part::Resonance { .. } => PRICE_OF_RESONANCE,
        Part::Term(Term::Quantization) if theta > 0.0 => PRICE_OF_QUANTIZATION,
        _ => 0.0,
    };
    let of_parts: f64 = fit.model.parts.iter().zip(&fit.model.theta).map(price).sum();
    fit.deviance - fit.restricted + price_of_filter(&fit.model) + of_parts
}

/// The fit with a Gauss-Markov process in addition to the terms or in place of some, whichever gains most.
fn with_process(fit: Fit, bins: &Bins) -> Fit {
    let mut chosen: Option<(f64, Fit)> = None;
    let [walk, flicker] = [Part::Term(Term::RateRandomWalk), Part::Term(Term::BiasInstability)];
    let needed: Vec<Part> = [walk, flicker].into_iter().filter(|&part| is_needed(&fit, part, bins)).collect();
    for replaced in REPLACED {
        // A process in addition to the rate random walk is always tested.
        let always = *replaced == [walk];
        if !always && !replaced.iter().all(|part| needed.contains(part)) {
            continue;
        }
        let Some(found) = best(&fit, bins, replaced) else { continue };
        let found = beside(found, &fit, bins, replaced);
        if !always && replaced.iter().any(|&part| is_needed(&found, part, bins)) {
            continue;
        }
        let exchanged = replaced.iter().filter(|part| needed.contains(part)).count();
        let price = (PRICE_OF_PROCESS - PRICE_REDUCTION * exchanged as f64).max(MIN_PRICE);
        let worth = fit.deviance - found.deviance - price;
        if worth > chosen.as_ref().map_or(0.0, |(most, _)| *most) {
            chosen = Some((worth, found));
        }
    }
    chosen.map_or(fit, |(_, found)| found)
}

/// Whether a term is certainly present.
pub(crate) fn is_needed(fit: &Fit, term: Part, bins: &Bins) -> bool {
    fit.model
        .index(term)
        .is_some_and(|j| fit.model.theta[j] > 0.0 && fit.removal_loss(j, bins).0 > CERTAIN_RISE)
}

fn smallest_ratio(fit: &Fit, unit: &[f64]) -> f64 {
    fit.spectrum.iter().zip(unit).map(|(s, c)| s / c).fold(f64::INFINITY, f64::min)
}

/// The refitted model with the addition that gains most beyond its price.
fn best_addition(
    fit: &Fit,
    bins: &Bins,
    dictionary: &Dictionary,
    allowed: Allowed,
    refused: &mut Refused,
) -> Option<(Fit, Addition)> {
    let misfit = adequacy(fit, bins).p_value < SELECTED_P_VALUE;
    let process = if misfit { PROCESS_IF_MISFIT } else { PRICE_OF_PROCESS };
    let resonance = if misfit { RESONANCE_IF_MISFIT } else { PRICE_OF_RESONANCE };
    let beyond = |count: usize| (count - fit.model.filter.len()) as f64;
    let price = |addition: Addition| match addition {
        Addition::Quantization => PRICE_OF_QUANTIZATION,
        Addition::Filter(count) if misfit && !fit.model.filter.is_empty() => {
            COEFFICIENT_IF_MISFIT * beyond(count)
        }
        Addition::Filter(count) => PRICE_OF_COEFFICIENT * beyond(count) + PRICE_OF_FILTER,
        Addition::Process(_) => process,
        Addition::Resonance(_) => resonance,
    };
    let scores = Scores::at(fit, bins);
    let mut worth: Vec<(f64, Addition)> = Vec::new();
    let no_quantization = fit.model.index(Term::Quantization).is_none();
    if allowed.quantization && no_quantization && !refused.quantization && fit.model.filter.is_empty() {
        let gain = scores.gain_of(&bins.unit(Term::Quantization), false);
        worth.push((gain, Addition::Quantization));
    }
    let present = fit.model.filter.len();
    if allowed.filter && fit.model.family.is_none() {
        for count in present + 1..=(present + FILTER_TRIES).min(MAX_FILTER) {
            if !refused.filters.contains(&count) {
                worth.push((scores.gain_of_filter(fit, bins, count), Addition::Filter(count)));
            }
        }
    }
    if extra(&fit.model) < MAX_EXTRA {
        if allowed.processes && !refused.processes {
            worth.extend(scores.best(&dictionary.processes).map(|(g, part)| (g, Addition::Process(part))));
        }
        if allowed.resonances && !refused.resonances {
            worth.extend(scores.best(&dictionary.resonances).map(|(g, part)| (g, Addition::Resonance(part))));
        }
    }
    let mut ranked: Vec<(f64, Addition)> =
        worth.into_iter().map(|(g, a)| (g - price(a), a)).filter(|(g, _)| *g > 0.0).collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    // A filter is tested first, because a wide resonance can resemble one.
    let simple = |a: &(f64, Addition)| matches!(a.1, Addition::Filter(count) if count <= FILTER_TRIES);
    if let Some(k) = ranked.iter().position(simple) {
        if ranked[k].0 > 0.2 * ranked[0].0 {
            let filter = ranked.remove(k);
            ranked.insert(0, filter);
        }
    }
    let mut best: Option<(f64, Fit, Addition)> = None;
    for &(expected, addition) in ranked.iter().take(3) {
        let (reference, tried) = added(fit, bins, addition);
        let net = reference - tried.deviance - price(addition);
        if net > 0.0 {
            if best.as_ref().is_none_or(|b| net > b.0) {
                best = Some((net, tried, addition));
            }
        } else {
            match addition {
                Addition::Quantization => refused.quantization = true,
                Addition::Filter(count) => refused.filters.push(count),
                Addition::Process(_) => refused.processes = true,
                Addition::Resonance(_) => refused.resonances = true,
            }
        }
        if let Some((net, _, addition)) = &best {
            if *net > 0.7 * expected || matches!(addition, Addition::Filter(_)) {
                break;
            }
        }
    }
    best.map(|(_, fit, addition)| (fit, addition))
}

/// The deviance for the comparison, and the fit with the addition.
fn added(fit: &Fit, bins: &Bins, addition: Addition) -> (f64, Fit) {
    match addition {
        Addition::Filter(count) => {
            let mut model = beside_filter(fit, bins);
            model.filter.resize(count, 0.0);
            (fit.deviance, model.refit(bins, 40, TOLERANCE, fit))
        }
        Addition::Quantization => {
            let theta = 0.1 * smallest_ratio(fit, &bins.unit(Term::Quantization));
            (
                fit.deviance,
                fit.model.with(Part::Term(Term::Quantization), theta).refit(bins, 40, TOLERANCE, fit),
            )
        }
        Addition::Process(part) | Addition::Resonance(part) => {
            let share = if matches!(addition, Addition::Process(_)) { 0.1 } else { 0.3 };
            let theta = share * smallest_ratio(fit, &bins.unit(part));
            (fit.deviance, fit.model.with(part, theta).refit(bins, 40, TOLERANCE, fit))
        }
    }
}

/// Backward step: removes the filter if a process that was added later has the same effect.
fn without_filter(fit: Fit, bins: &Bins, allowed: Allowed) -> Fit {
    if fit.model.filter.is_empty() || extra(&fit.model) == 0 {
        return fit;
    }
    let mut model = fit.model.clone().unfiltered();
    if allowed.quantization && model.index(Term::Quantization).is_none() {
        let theta = 0.1 * smallest_ratio(&fit, &bins.unit(Term::Quantization));
        model = model.with(Part::Term(Term::Quantization), theta);
    }
    let without = model.refit(bins, 40, TOLERANCE, &fit);
    if without.deviance - fit.deviance < price_of_filter(&fit.model) { without } else { fit }
}

/// Backward step: removes processes and resonances that are no longer worth their price.
fn without_idle(mut fit: Fit, bins: &Bins) -> Fit {
    loop {
        let loss = |j: usize| {
            let (loss, without) = fit.removal_loss(j, bins);
            let price = match fit.model.parts[j] {
                Part::GaussMarkov { .. } => PROCESS_IF_MISFIT,
                _ => RESONANCE_IF_MISFIT,
            };
            (loss - price, without)
        };
        let least = fit.model.processes().map(loss).min_by(|a, b| a.0.total_cmp(&b.0));
        match least {
            Some((net, without)) if net <= -0.5 * PRICE_OF_QUANTIZATION => fit = without,
            _ => return fit,
        }
    }
}

/// Alternative explanations that are nearly as good: with the best process or resonance below its price, without one just
/// above its price, and with a filter of more coefficients. A weak process matters if slow terms are observed.
pub(crate) fn second_explanations(fit: &Fit, bins: &Bins, allowed: Allowed, shows_slow: bool) -> Vec<Fit> {
    let mut found = Vec::new();
    if extra(&fit.model) < MAX_EXTRA {
        let (scores, dictionary) = (Scores::at(fit, bins), Dictionary::new(bins));
        let lists = [
            (
                allowed.processes,
                &dictionary.processes,
                if shows_slow { PROCESS_ALIKE } else { ALTERNATIVE_REDUCTION },
            ),
            (allowed.resonances, &dictionary.resonances, ALTERNATIVE_REDUCTION),
        ];
        for (_, list, least) in lists.into_iter().filter(|(allowed, ..)| *allowed) {
            let Some((_, part)) = scores.best(list).filter(|(gain, _)| *gain > least) else { continue };
            let (reference, tried) = added(fit, bins, Addition::Process(part));
            if reference - tried.deviance > least {
                found.push(tried);
            }
        }
    }
    let present = fit.model.filter.len();
    if fit.model.family.is_some() {
        found.extend(other_families(fit, bins, ALIKE_FILTER));
    } else if fit.model.mean.is_some() {
        found.extend(other_side_of_mean(fit, bins, ALIKE_FILTER));
    } else if allowed.filter && present > 0 {
        for count in present + 1..=(present + OTHER_ORDERS).min(MAX_FILTER) {
            found.push(added(fit, bins, Addition::Filter(count)).1);
        }
    }
    found.extend(process_like_filter(fit, bins, allowed));
    let losses = fit.model.processes().map(|j| fit.removal_loss(j, bins));
    found.extend(losses.filter(|(loss, _)| *loss < PRICE_OF_PROCESS).map(|(_, without)| without));
    found
}

/// The fit with a process in place of a first-order filter, if other white noise is visible.
fn process_like_filter(fit: &Fit, bins: &Bins, allowed: Allowed) -> Option<Fit> {
    let corner = fit.model.family?.corner_of_first_order(&fit.model.filter)?;
    let walk = fit.model.index(Term::RandomWalk).filter(|_| allowed.processes)?;
    let time = bins.record.tau0 / (2.0 * PI * corner);
    if time < time_limits(bins).0 {
        return None;
    }
    let variance = 0.5 * fit.model.theta[walk] / time;
    let mut model = fit.model.clone().unfiltered().with(Part::GaussMarkov { time }, variance);
    model.theta[walk] *= 0.01;
    let tried = model.refit(bins, 40, TOLERANCE, fit);
    let alike =
        tried.deviance + PRICE_OF_PROCESS <= fit.deviance + price_of_filter(&fit.model) + ALIKE_FILTER;
    (alike && is_needed(&tried, Part::Term(Term::RandomWalk), bins)).then_some(tried)
}
