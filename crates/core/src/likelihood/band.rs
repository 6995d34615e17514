//! The model of the whole band, or of the widest band with an adequate model.

use crate::likelihood::adequacy::adequacy;
use crate::likelihood::bins::{Bins, ENDS, Regressor, first_density, usable};
use crate::likelihood::drifts::{FIRST_REGRESSOR, with_drifts};
use crate::likelihood::expected::{Part, TERMS};
use crate::likelihood::fit::Fit;
use crate::likelihood::intervals::thresholds;
use crate::likelihood::line::Line;
use crate::likelihood::lines::{above_model, through_mask, without_images};
use crate::likelihood::masked::Weighting;
use crate::likelihood::model::Model;
use crate::likelihood::outcome::Options;
use crate::likelihood::running_mean::RunningMean;
use crate::likelihood::select::{Allowed, SELECTED_P_VALUE, is_needed, select, select_with_lines};
use crate::likelihood::summary::Summary;
use crate::terms::{NOISE_TERMS, Term};
use std::sync::Arc;

/// P-value below which a model is not adequate, and its intervals are widened.
pub(crate) const MIN_P_VALUE: f64 = 0.002;

/// Number of searches for lines.
pub(crate) const LINE_SEARCHES: usize = 3;

/// Smallest ratio of the end of the band to the highest mode if the top of the band is left out.
const MIN_BAND: f64 = 5.0;

/// P-value below which a narrower band describes the record no better than the whole one.
const HOPELESS_P_VALUE: f64 = 1e-4;

/// Number of times that the band is halved, and number after which it is only halved to find white noise after a filter.
const MAX_HALVINGS: u32 = 10;
const USUAL_SHARE: f64 = 16.0;

/// Largest correlation time at which a process, without other white noise, may be white noise after a filter. \[s\]
pub(crate) const SLOWEST_FILTER: f64 = 2.0;

/// Ratio of the white noise to the level of such a process below which the model counts as without white noise.
const NO_WHITE: f64 = 0.1;

/// Number of filters and resonances in the high band above which its top is left out instead of described.
const MAX_HIGH_PARTS: f64 = 6.0;

/// Number of standard errors above which a term determines the information that a mask leaves.
const STANDS_OUT: f64 = 2.0;

pub(crate) struct Attempt<'a> {
    pub bins: Bins<'a>,
    pub fit: Fit,
    pub p_value: f64,
    pub lines: Vec<Line>,
    pub highest: Option<f64>,
}

/// The model of the whole band if it is good; otherwise of the widest band with a good model that shows its white noise;
/// otherwise of the widest band that is good except for hidden white noise, or adequate; otherwise of the best band, if its
/// fit is usable.
pub(crate) fn best_attempt<'a>(
    record: &'a Summary,
    mask: &[bool],
    lines: &[Line],
    regressors: &Arc<Vec<Regressor>>,
    options: &Options,
) -> Attempt<'a> {
    let nyquist = 0.5 / record.tau0;
    let lowest = record.mode_frequency(record.low_modes());
    let mut attempts: Vec<Attempt<'a>> = Vec::new();
    let mut good = None; // the widest band with an adequate model, whose white noise may be hidden
    for share in (0..MAX_HALVINGS).map(|halvings| f64::from(1 << halvings)) {
        let mut mask = mask.to_vec();
        let highest = (share > 1.0).then_some(nyquist / share);
        if let Some(highest) = highest {
            if highest < MIN_BAND * lowest {
                break;
            }
            let from = (highest * record.segment as f64 * record.tau0).ceil() as usize;
            if !mask[from..].contains(&true) {
                continue; // there is no noise in this band, so it was not used before
            }
            mask[from..].fill(false);
        }
        let attempt = attempt(record, mask, lines.to_vec(), regressors, options, (highest, None));
        let model = &attempt.fit.model;
        let high =
            |part: &Part| matches!(part, Part::Resonance { frequency, .. } if *frequency > nyquist / 32.0);
        let many = model.filter.len() as f64 / 2.0 + model.parts.iter().filter(|p| high(p)).count() as f64;
        let wanted = if highest.is_none() && many == 0.0 { MIN_P_VALUE } else { SELECTED_P_VALUE };
        let done = attempt.p_value >= wanted && many <= MAX_HIGH_PARTS;
        let hidden = hides_white_noise(&attempt.fit) && !shows_white_noise(&attempt);
        attempts.push(attempt);
        if done && !hidden {
            return attempts.swap_remove(attempts.len() - 1);
        }
        if done && good.is_none() {
            good = Some(attempts.len() - 1);
        }
        if share >= USUAL_SHARE
            && !attempts.iter().any(|a| hides_white_noise(&a.fit) && !shows_white_noise(a))
        {
            break;
        }
    }
    let last_good = attempts.iter().rposition(|a| a.p_value >= SELECTED_P_VALUE);
    let adequate = attempts.iter().position(|a| a.p_value >= MIN_P_VALUE);
    let least_bad = || {
        let among = (0..attempts.len()).filter(|&a| attempts[a].p_value >= HOPELESS_P_VALUE);
        among.max_by(|&a, &b| attempts[a].p_value.total_cmp(&attempts[b].p_value))
    };
    let chosen = good.or(last_good).or(adequate).or_else(least_bad).unwrap_or(0);
    attempts.swap_remove(chosen)
}

/// Whether a fast process represents white noise after a filter, because no other white noise is visible.
pub(crate) fn hides_white_noise(fit: &Fit) -> bool {
    fit.model.index(Term::RandomWalk).is_some_and(|j| fit.model.theta[j] < NO_WHITE * fast_level(fit))
}

/// Whether white noise is certainly visible in addition to such a process.
fn shows_white_noise(attempt: &Attempt) -> bool {
    let fit = &attempt.fit;
    fit.model.index(Term::RandomWalk).is_some_and(|j| is_needed(fit, fit.model.parts[j], &attempt.bins))
}

/// Highest level at low frequencies of processes that are as fast as filters.
fn fast_level(fit: &Fit) -> f64 {
    let level = |(part, theta): (&Part, &f64)| match part {
        Part::GaussMarkov { time } if *time <= SLOWEST_FILTER => 2.0 * theta * time,
        _ => 0.0,
    };
    fit.model.parts.iter().zip(&fit.model.theta).map(level).fold(0.0, f64::max)
}

/// The model of a band: up to a highest frequency \[Hz\] and after a running mean, if given, of all noise or of the random
/// walk alone.
pub(crate) fn attempt<'a>(
    record: &'a Summary,
    mask: Vec<bool>,
    mut lines: Vec<Line>,
    regressors: &Arc<Vec<Regressor>>,
    options: &Options,
    (highest, mean): (Option<f64>, Option<(RunningMean, bool)>),
) -> Attempt<'a> {
    let bins_of = |mask: Vec<bool>, regressors: &Arc<Vec<Regressor>>, lines: &[Line]| {
        let mut bins = Bins::new(record, Arc::new(mask), regressors.clone());
        bins.see(lines);
        if let Some((mean, _)) = mean {
            bins.see_mean(mean);
        }
        bins
    };
    let mut bins = bins_of(mask, regressors, &lines);
    let mut allowed = allowed(record, options);
    allowed.filter &= mean.is_none();
    let mut parts: Vec<Part> = TERMS
        .into_iter()
        .zip(wanted_terms(record, options))
        .filter(|(_, w)| *w)
        .map(|(part, _)| part)
        .collect();
    parts.extend(options.times.iter().map(|&time| Part::GaussMarkov { time }));
    let mut used = if record.masked.is_some() { Vec::new() } else { ENDS.to_vec() };
    used.extend((0..options.regressors.len()).map(|k| FIRST_REGRESSOR + k));
    let of_white = mean.is_some_and(|(_, of_white)| of_white);
    let bare = Model { mean: mean.map(|(mean, _)| mean), of_white, ..Model::new(parts, used) };
    let mut start = informed(bare.fit(&bins), &mut bins);
    with_drifts(&mut start, &mut bins, thresholds(options.level), options.drifts);
    let mut fit;
    if options.lines {
        (fit, bins) = select_with_lines(&start, bins, allowed);
    } else {
        fit = select(start, &bins, allowed);
    }
    for _ in 0..if options.lines { LINE_SEARCHES } else { 0 } {
        let mut mask = bins.mask.to_vec();
        let found = above_model(&bins, &fit.model, &mut mask);
        if found.is_empty() {
            break;
        }
        lines.extend(found);
        lines = without_images(record, lines);
        bins = bins_of(mask, &bins.regressors, &lines);
        fit = informed(fit.model.clone().fit(&bins), &mut bins);
        fit = select(fit, &bins, allowed);
    }
    fit = informed(fit, &mut bins);
    let p_value = adequacy(&fit, &bins).p_value;
    Attempt { bins, fit, p_value, lines, highest }
}

pub(crate) fn allowed(record: &Summary, options: &Options) -> Allowed {
    Allowed {
        quantization: wanted_terms(record, options)[Term::Quantization.index()],
        filter: options.filter,
        processes: options.processes,
        resonances: options.resonances,
        drifts: options.drifts,
    }
}

/// The terms that may be present. Without neighbouring samples the densities of quantization noise and random walk are
/// equal, and the random walk represents both.
pub(crate) fn wanted_terms(record: &Summary, options: &Options) -> [bool; NOISE_TERMS] {
    let mut terms = options.terms;
    let walk = terms[Term::RandomWalk.index()];
    terms[Term::Quantization.index()] &=
        record.masked.as_ref().is_none_or(|masked| masked.has_neighbours() || !walk);
    terms
}

/// With missing samples, reduces the information of a fit to the part that the mask leaves. This part is known for two
/// terms; the smaller one is used if both are significant.
fn informed(fit: Fit, bins: &mut Bins) -> Fit {
    let Some(masked) = bins.record.masked.clone() else { return fit };
    if bins.ranges.is_empty() {
        return fit;
    }
    let covariance = fit.information(bins).0.pseudo_inverse();
    let terms = masked.plain_terms().map(|part| fit.model.index(part).map(|j| (j, fit.model.theta[j])));
    let levels = masked.levels(terms.map(|of| of.map_or(0.0, |(_, theta)| theta)), bins.record.tau0);
    let mut noise = vec![0.0; bins.len()];
    for (j, theta) in terms.into_iter().flatten() {
        noise.iter_mut().zip(bins.unit(fit.model.parts[j])).for_each(|(s, c)| *s += theta * c);
    }
    let mut least: Option<f64> = None;
    for (j, theta) in terms.into_iter().flatten() {
        if theta <= STANDS_OUT * covariance.get(j, j).max(0.0).sqrt() {
            continue;
        }
        let column = bins.unit(fit.model.parts[j]);
        let weights: Vec<f64> = column.iter().zip(&fit.spectrum).map(|(c, s)| c / (s * s)).collect();
        let share = masked.information_share(&bins.spread(&weights), &bins.spread(&noise), levels);
        least = Some(least.map_or(share, |l| l.min(share)));
    }
    bins.inform(least.unwrap_or(masked.share(bins.record.samples)));
    fit.model.clone().fit(bins)
}

/// With missing samples, returns the expected densities for a fit of the terms, after a running mean if there is one. A mask
/// spreads low frequencies over all others, and a periodic mask makes images of them, which are not lines.
pub(crate) fn of_terms(record: &Summary, mask: &[bool], mean: Option<RunningMean>) -> Option<Vec<f64>> {
    let masked = record.masked.as_ref()?;
    let (bins, model) = fit_of_terms(record, mask.to_vec(), mean);
    if mean.is_none() {
        return Some(masked.densities(&model.theta));
    }
    let (first, count) = (first_density(record), record.density.len());
    let mut densities = vec![0.0; first.min(count)];
    densities.extend(through_mask(&bins, &model, masked, first..count));
    Some(densities)
}

/// A fit of the terms, after a running mean if there is one.
fn fit_of_terms(record: &Summary, mask: Vec<bool>, mean: Option<RunningMean>) -> (Bins<'_>, Model) {
    let bins = Bins::new(record, Arc::new(mask), Arc::new(Vec::new()));
    let model = Model { mean, ..Model::new(TERMS.to_vec(), Vec::new()) }.fit(&bins).model;
    (bins, model)
}

impl Summary {
    /// The weights that a second pass over a record with missing samples should have, from a fit of the terms.
    ///
    /// The weights of a run fall to 0 at its ends over a time that is the root of the ratio of quantization noise to random
    /// walk. If differences of samples have a smaller variance than the samples of a segment, the differences are used
    /// instead; random walk and rate random walk then play the part of quantization noise and random walk.
    #[must_use]
    pub fn weighting(&self) -> Weighting {
        let Some(masked) = &self.masked else { return Weighting::default() };
        let variance = 2.0 * self.density.iter().sum::<f64>() / (self.segment as f64 * self.tau0);
        let differenced = masked.wants_differences(variance);
        if !differenced && !masked.has_neighbours() {
            return Weighting::default();
        }
        let all = fit_of_terms(self, usable(self), None).1.theta;
        let theta = |term: Term| all[term.index()];
        let root = |above: f64, below: f64| {
            if above > 0.0 { (above / below.max(1e-12 * above)).sqrt() } else { 0.0 }
        };
        Weighting {
            taper: if masked.has_neighbours() {
                root(theta(Term::Quantization) / self.tau0, theta(Term::RandomWalk))
            } else {
                0.0
            },
            differences: differenced
                .then(|| root(theta(Term::RandomWalk), theta(Term::RateRandomWalk) * self.tau0 * self.tau0)),
        }
    }
}
